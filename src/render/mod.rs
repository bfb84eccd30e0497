//! From a description to a picture.
//!
//! [`PreparedScene::prepare`] turns a [`crate::scene::Scene`] into what rendering reads: immutable, `f32`, centred and scaled
//! by a power of two ([`crate::math::SceneFrame`]). [`render`] runs passes of tiles over it and sums samples in a film,
//! which is read as an [`Image`] of linear radiance. Every random number depends on (seed, pixel, sample, dimension) and on
//! nothing else, and sums are formed in a fixed order, so the picture is the same for any number of threads.

mod aim;
mod ambient_occlusion;
mod background;
mod bands;
mod blocks;
mod camera;
mod camera_samples;
mod checkpoint;
mod clock;
mod coarse;
mod crew;
mod direct;
mod disks;
pub mod display;
mod emitters;
mod error;
mod eye_path;
mod false_color;
mod fault;
mod film;
mod filter;
mod fresnel;
mod geometry;
mod image;
mod kernel;
mod layers;
mod light;
mod light_tree;
mod material;
mod media;
mod memory;
mod mis;
mod path;
mod phong;
mod plan;
mod prepare;
mod primary_hits;
mod progress;
mod radiance_image;
mod renderer;
mod run;
mod sampler;
mod shadow_ray;
mod shares;
mod sky_light;
mod specular;
mod stops;
mod surface;
mod tally;
mod texturing;
mod tile_samples;
mod tiles;
mod trace;
mod used;
mod work;

pub use bands::Bands;
pub use blocks::{Block, BlockHeader, BlockStore};
pub use camera::{CameraRay, PreparedCamera};
pub use checkpoint::Checkpoint;
pub use coarse::{CoarsePicture, OnCoarse, Sketch};
pub use error::{ErrorEstimate, Interval, RELATIVE_FLOOR};
pub use false_color::{MOST_STEPS, steps_color};
pub use fault::{RenderFault, keep_panics_quiet, panic_message};
pub(crate) use fresnel::fresnel;
pub(crate) use geometry::is_nothing;
pub use geometry::{
    PreparedGeometry, PreparedObject, ShadingNormals, SketchStore, StructureChoice, build_structure,
};
pub use image::Image;
pub use layers::Layer;
pub use memory::{PictureMemory, PictureTooLarge};
pub use plan::{Feature, Plan, reasons};
pub use prepare::PreparedScene;
pub use primary_hits::PrimaryHitStore;
pub use progress::{ErrorPoint, NOISE_TARGETS, RenderProgress, TilesInHand};
pub use renderer::even_passes;
pub use run::{
    CheckpointKeeper, Clamped, Ending, OnRound, OnTile, RayCounts, RenderOutcome, RenderStats,
    Round, RunConfig, Watch, render, render_watched, resume,
};
pub use sampler::{Decision, Dimension, Sampler, Turns};
pub use surface::SurfacePoint;
pub use tally::RayPurpose;
pub use texturing::{Meaning, Pyramid};
pub use tiles::{Region, TilePixels};
pub use trace::{Met, MetSurface, SampleTrace, TraceError, TracedRay, trace_sample};
pub use used::Used;
pub use work::Work;
