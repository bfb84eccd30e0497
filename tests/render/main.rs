//! Renders against closed forms, against a second way to the same light, and against themselves.

mod blocks;
#[path = "../common/mod.rs"]
mod common;
mod error;
mod glass;
mod instances;
mod layers;
mod light;
mod many_lights;
mod occlusion;
mod path;
mod plan;
mod resume;
mod samplers;
mod scaling;
mod sky;
mod smooth;
mod stopping;
mod textures;
mod trace;
mod whole;
