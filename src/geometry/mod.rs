//! Triangle meshes and what can be said about them without knowing any material.

mod buckets;
pub mod cells;
mod edges;
mod face_normal;
mod mesh;
mod normals;
pub mod polygon;
mod precision;
pub mod shapes;
mod shells;
mod triangle;
mod welded;
mod winding;

pub use buckets::Buckets;
pub use edges::{Edges, Side};
pub use face_normal::{face_normal, has_area};
pub use mesh::TriangleMesh;
pub use normals::{CornerNormals, corner_normals};
pub use precision::{LostDigits, MeshSize, spacing_at};
pub use shells::{Shell, Shells};
pub use triangle::{RayKernel, Triangle, TriangleHit};
pub use welded::Welded;
pub use winding::Winding;
