//! The stats file of a render: times, counts and the picture's hash, for programs.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::{Serialize, Serializer};

use super::costs::MeasuredCosts;
use super::plan::PlannedFeature;
use crate::io;
use crate::memory;
use crate::render::{
    Clamped, Ending, ErrorEstimate, ErrorPoint, Interval, NOISE_TARGETS, PreparedScene, RayCounts,
    RenderStats, Used,
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
    /// Whether the clock ended it in the middle of a pass, so that `passes` does not reproduce it.
    is_cut_short: bool,
    passes: u32,
    ending: Ending,
    rays: RayCounts,
    error: Option<ErrorFacts>,
    /// When noise is down to 10, 3 and 1 %; null where that is not foreseen, or never.
    time_to: BTreeMap<String, Option<LevelFacts>>,
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
    /// What `stats` and `errors`, the error on its way, say of a render of `scene`; seconds to load and to build; what it was planned to do and to use.
    pub fn new(
        (stats, errors): (&RenderStats, &[ErrorPoint]),
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
            is_cut_short: stats.is_cut_short,
            passes: stats.passes,
            ending: stats.ending,
            rays: stats.rays,
            error: stats.error.as_ref().map(ErrorFacts::from),
            time_to: LevelFacts::of(errors),
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

/// Refuses names of other kinds of files, which would be lost by a slip of the hand. Without an extension it may be a device or a pipe.
pub(super) fn check_name(path: &Path) -> Result<()> {
    let is_json = |extension: &OsStr| extension.eq_ignore_ascii_case("json");
    if !path.extension().is_none_or(is_json) {
        let name = path.display();
        bail!("{name}: the figures of --stats are JSON: expected the extension .json");
    }
    Ok(())
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

/// When noise is down to a level, in seconds of rendering.
#[derive(Debug, PartialEq, Serialize)]
struct LevelFacts {
    seconds: f64,
    /// Of what is foreseen; null where it was seen, at that time or before.
    interval: Option<[f64; 2]>,
}

impl LevelFacts {
    fn of(errors: &[ErrorPoint]) -> BTreeMap<String, Option<Self>> {
        let levels = NOISE_TARGETS.iter().enumerate();
        let facts = levels.map(|(number, &noise)| {
            let reached = errors.iter().find(|p| p.error.noise().value <= noise);
            let is_still = errors
                .last()
                .is_some_and(|last| last.error.noise().value <= noise);
            let facts = match reached.filter(|_| is_still) {
                Some(point) => Some(Self {
                    seconds: point.seconds,
                    interval: None,
                }),
                None => errors.last().and_then(|last| {
                    let time = last.time_to[number]?;
                    Some(Self {
                        seconds: time.value,
                        interval: Some([time.low, time.high]),
                    })
                }),
            };
            (format!("{noise:.2}"), facts)
        });
        facts.collect()
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
    percentile_999_interval: [f64; 2],
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_seen_or_foreseen() {
        let exactly = |value: f64| Interval {
            value,
            low: value,
            high: value,
        };
        let ahead = Interval {
            value: 80.0,
            low: 60.0,
            high: 99.0,
        };
        let point = |seconds: f64, noise: f64, time_to| ErrorPoint {
            seconds,
            cpu_seconds: seconds,
            error: ErrorEstimate {
                samples_per_pixel: 4.0,
                rmse: exactly(noise),
                relmse: exactly(noise * noise),
                percentile_999: exactly(noise),
                unmeasured_pixels: 0,
            },
            time_to,
            time_to_stop: None,
        };
        assert!(LevelFacts::of(&[]).values().all(Option::is_none));
        let facts = LevelFacts::of(&[
            point(1.0, 0.2, [Some(ahead); 3]),
            point(2.0, 0.09, [None, Some(ahead), None]),
            point(4.0, 0.05, [None, Some(ahead), None]),
        ]);
        let seen = LevelFacts {
            seconds: 2.0,
            interval: None,
        };
        assert_eq!(facts["0.10"], Some(seen));
        let foreseen = LevelFacts {
            seconds: 80.0,
            interval: Some([60.0, 99.0]),
        };
        assert_eq!(facts["0.03"], Some(foreseen));
        assert_eq!(facts["0.01"], None);
    }
}
