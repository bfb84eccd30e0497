//! Triangulation of polygons.
