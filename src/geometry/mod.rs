//! Triangle meshes and what can be said about them without knowing any material.

pub mod cells;
mod face_normal;
mod mesh;
mod normals;
pub mod polygon;
pub mod shapes;
mod triangle;
mod welded;

pub use face_normal::{face_normal, has_area};
pub use mesh::TriangleMesh;
pub use normals::{CornerNormals, corner_normals};
pub use triangle::{RayKernel, Triangle, TriangleHit};
pub use welded::Welded;
