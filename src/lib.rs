//! RayMini: an interactive ray tracer that reports its error, survives extreme scenes and leaves out what a scene does
//! not need.
//!
//! Data flows one way:
//!
//! ```text
//! files ──io──▶ Scene ──prepare──▶ PreparedScene ──passes of tiles──▶ Film ──▶ Image ──▶ window, PNG, EXR
//! ```
//!
//! and so do imports: `main → gui, cli → analysis → render → scene, accel → geometry → math`, with [`io`] beside [`scene`].
//!
//! - [`math`]: vectors, boxes, frames, colour, error bounds
//! - [`geometry`]: triangle meshes, watertight intersection, polygons, shading normals; knows no material
//! - [`accel`]: the wide tree, the kd-tree, and brute force as their reference
//! - [`scene`]: the description, plain data in the units of the file
//! - [`io`]: bytes to meshes, scenes and pictures, and back
//! - [`render`]: the prepared scene, samplers, shading, tiles and passes, film
//! - [`analysis`]: measuring structures and rays, and how far a picture is from another
//! - [`cli`], `gui`: the program's two faces, which do not know each other
//! - [`control`], [`memory`]: cancelling and progress as values, and what memory there is; for all of them

pub mod accel;
pub mod analysis;
pub mod cli;
pub mod control;
pub mod geometry;
#[cfg(feature = "gui")]
pub mod gui;
pub mod io;
pub mod math;
pub mod memory;
pub mod render;
pub mod scene;
