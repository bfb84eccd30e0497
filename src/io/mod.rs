//! Bytes to meshes, scene files and pictures, and back.

pub mod atomic;
pub mod mesh_file;
pub mod off;
