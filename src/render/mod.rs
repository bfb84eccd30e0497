//! From a description to a picture.
//!
//! [`PreparedScene::prepare`] turns a [`crate::scene::Scene`] into what rendering reads: immutable, `f32`, centred and scaled
//! by a power of two ([`crate::math::SceneFrame`]). [`render`] runs passes of tiles over it and sums samples in a [`Film`],
//! which is read as an [`Image`] of linear radiance. Every random number depends on (seed, pixel, sample, dimension) and on
//! nothing else, and sums are formed in a fixed order, so the picture is the same for any number of threads.

mod alias;
mod background;
mod camera;
mod direct;
mod disks;
pub mod display;
mod emitters;
mod false_color;
mod film;
mod filter;
mod fresnel;
mod geometry;
mod image;
mod light;
mod light_tree;
mod material;
mod path;
mod phong;
mod prepare;
mod run;
mod sampler;
mod surface;
mod tiles;

pub use camera::{CameraRay, PreparedCamera};
pub use film::Film;
pub use geometry::{ObjectNormals, PreparedGeometry, PreparedObject};
pub use image::Image;
pub use prepare::PreparedScene;
pub use run::{RayCounts, RenderOutcome, RenderProgress, RenderStats, RunConfig, render};
pub use sampler::{Decision, Dimension, Sampler};
pub use tiles::{Region, TilePixels};
