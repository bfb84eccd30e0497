//! Bytes to meshes, scene files and pictures, and back.
