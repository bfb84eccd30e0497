//! The stats file of a render: times, counts and the picture's hash, for programs.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Serialize, Serializer};

use super::costs::MeasuredCosts;
use super::plan::PlannedFeature;
use crate::io;
use crate::memory;
use crate::render::{
    Clamped, Ending, ErrorEstimate, Interval, PreparedScene, RayCounts, RenderStats, Used,
};

/// The stats file.
#[derive(Debug, Serialize)]
pub(super) struct Stats {
    load_seconds: f64,
    build_seconds: f64,
    render_seconds: f64,
    first_tile_seconds: f64,
    triangles: u64,
    accelerator: &'static str,
    accelerator_bytes: usize,
    /// `None` where the system does not tell.
    peak_memory_bytes: Option<u64>,
    threads: usize,
    /// Mean of all pixels; written as a whole number where it is one.
    #[serde(serialize_with = "whole_if_possible")]
    samples_per_pixel: f64,
    /// The fewest and the most of a pixel.
    sample_range: [u32; 2],
    passes: u32,
    ending: Ending,
    rays: RayCounts,
    error: Option<ErrorFacts>,
    non_finite_samples: u64,
    negative_samples: u64,
    depth_limited_samples: u64,
    clamped: Clamped,
    image_hash: String,
    plan: Vec<PlannedFeature>,
    used: Used,
    /// Where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub costs: Option<MeasuredCosts>,
}

impl Stats {
    /// What `stats` says of a render of `scene`; seconds to load and to build; what it was planned to do and to use.
    pub fn new(
        stats: &RenderStats,
        scene: &PreparedScene,
        [load_seconds, build_seconds]: [f64; 2],
        hash: &str,
        (plan, used): (Vec<PlannedFeature>, Used),
    ) -> Self {
        let accelerator = scene.geometry().accelerator();
        Self {
            load_seconds,
            build_seconds,
            render_seconds: stats.render_seconds,
            first_tile_seconds: stats.first_tile_seconds,
            triangles: u64::from(accelerator.triangle_count()),
            accelerator: accelerator.name(),
            accelerator_bytes: accelerator.bytes(),
            peak_memory_bytes: memory::peak_bytes(),
            threads: stats.threads,
            samples_per_pixel: stats.samples_per_pixel,
            sample_range: stats.sample_range,
            passes: stats.passes,
            ending: stats.ending,
            rays: stats.rays,
            error: stats.error.as_ref().map(ErrorFacts::from),
            non_finite_samples: stats.non_finite_samples,
            negative_samples: stats.negative_samples,
            depth_limited_samples: stats.depth_limited_samples,
            clamped: stats.clamped,
            image_hash: hash.to_owned(),
            plan,
            used,
            costs: None,
        }
    }

    /// Writes it whole or not at all.
    pub fn write(&self, path: &Path) -> Result<()> {
        let json =
            serde_json::to_string_pretty(self).context("the stats cannot be written as JSON")?;
        io::write_atomically(path, |file| writeln!(file, "{json}"))
            .with_context(|| cannot_write(path))
    }
}

/// What is said where it cannot be written.
pub(super) fn cannot_write(path: &Path) -> String {
    format!("{}: cannot write the stats", path.display())
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::trivially_copy_pass_by_ref,
    reason = "at least 0, and as serde asks for it"
)]
fn whole_if_possible<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if number.fract() == 0.0 {
        serializer.serialize_u64(*number as u64)
    } else {
        serializer.serialize_f64(*number)
    }
}

/// The error of a picture as it is written for programs.
#[derive(Debug, Serialize)]
struct ErrorFacts {
    rmse: f64,
    rmse_interval: [f64; 2],
    relmse: f64,
    relmse_interval: [f64; 2],
    /// √relmse.
    noise: f64,
    noise_interval: [f64; 2],
    percentile_999: f64,
    unmeasured_pixels: u64,
    method: &'static str,
}

impl From<&ErrorEstimate> for ErrorFacts {
    fn from(error: &ErrorEstimate) -> Self {
        let ends = |interval: Interval| [interval.low, interval.high];
        Self {
            rmse: error.rmse.value,
            rmse_interval: ends(error.rmse),
            relmse: error.relmse.value,
            relmse_interval: ends(error.relmse),
            noise: error.noise().value,
            noise_interval: ends(error.noise()),
            percentile_999: error.percentile_999.value,
            percentile_999_interval: ends(error.percentile_999),
            unmeasured_pixels: error.unmeasured_pixels,
            method: "halves of each pixel's sequence, extrapolated by the measured decay; 95 % intervals",
        }
    }
}
    percentile_999_interval: [f64; 2],
