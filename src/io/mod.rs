//! Bytes to meshes, scene files and pictures, and back.

pub mod mesh_file;
pub mod off;
