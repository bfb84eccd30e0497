//! How fast the structures over a scene's triangles are built and traversed, on the rays that rendering the scene traces.
//!
//! [`RaySet`]s are made from a scene ([`generate`]) or given, and [`measure`] builds every structure over the same
//! [`Assembly`](crate::accel::Assembly), copies included, and traces the same rays through each, in turns. Shading, light
//! disks and the tree over lights have no part in it.

mod measure;
mod ray_set;
mod scene_rays;
mod spread;
mod structure;
mod world_mesh;

pub use measure::{Disagreement, MeanVisits, MeasureConfig, SetReport, StructureReport, measure};
pub use ray_set::{RayError, RaySet};
pub use scene_rays::{RayKind, generate, with_lamp};
pub use spread::Spread;
pub use structure::Structure;
pub use world_mesh::write_mesh;
