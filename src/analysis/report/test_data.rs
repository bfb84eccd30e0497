//! A study of made-up numbers that can be followed by hand.

use super::reference::{Origin, Reference};
use super::study::{Machine, Study, Variant};
use super::trial::{Measurement, Trial};
use crate::analysis::SquaredErrors;
use crate::io::WrittenError;
use crate::render::{ErrorEstimate, Interval, RenderStats};
use crate::scene::Scene;

fn interval(value: f64) -> Interval {
    Interval {
        value,
        low: 0.8 * value,
        high: 1.25 * value,
    }
}

fn estimate(samples_per_pixel: f64, mse: f64, relmse: f64) -> ErrorEstimate {
    ErrorEstimate {
        samples_per_pixel,
        rmse: interval(mse.sqrt()),
        relmse: interval(relmse),
        percentile_999: interval(0.5),
        unmeasured_pixels: 0,
    }
}

/// Whose estimate is right, from 4 samples on.
pub fn measurement(samples_per_pixel: f64, seconds: f64, mse: f64, relmse: f64) -> Measurement {
    Measurement {
        samples_per_pixel,
        seconds,
        cpu_seconds: 2.0 * seconds,
        estimated: (samples_per_pixel >= 4.0).then(|| estimate(samples_per_pixel, mse, relmse)),
        measured: SquaredErrors {
            mse,
            relmse,
            compared_pixels: 2,
        },
        measured_percentile_999: 0.625,
    }
}

/// A second per sample; noise is 40 % of `factor` after the first and halves when they double, RMSE is half of it.
pub fn trial(seed: u64, factor: f64) -> Trial {
    let measurement = |samples: f64| {
        let noise = 0.4 * factor / samples;
        measurement(samples, samples, noise * noise / 4.0, noise * noise)
    };
    Trial {
        seed,
        build_seconds: 0.5,
        measurements: [1.0, 2.0, 4.0, 8.0].map(measurement).into(),
        stats: RenderStats {
            non_finite_samples: 2,
            ..RenderStats::default()
        },
    }
}

/// A picture of two pixels with this error.
pub fn rendered_reference(rmse: f64, relmse: f64) -> Reference {
    Reference {
        origin: Origin::Rendered {
            seed: 10,
            samples_per_pixel: 128,
            light_sampling: None,
            render_seconds: 128.0,
            error: Some(estimate(128.0, rmse * rmse, relmse)),
            non_finite_samples: 0,
        },
        ..Reference::exact([1.0; 3], 2, 1)
    }
}

/// A picture of two pixels from a file, which tells this error of its own or none.
pub fn file_reference(relmse: Option<f64>) -> Reference {
    Reference {
        origin: Origin::File {
            name: "before.exr".to_owned(),
            error: relmse.map(|relmse| WrittenError {
                rmse: 0.5 * relmse.sqrt(),
                relmse,
                samples_per_pixel: 128.0,
            }),
            is_rounded: false,
            shared_seed: None,
        },
        ..Reference::exact([1.0; 3], 2, 1)
    }
}

fn variant(name: &str, factors: [f64; 3]) -> Variant {
    let trials = (7..).zip(factors);
    let settings = "mode = \"path\"\nmirror = true\n[stop]\nnoise = 0.03\n";
    Variant {
        name: name.to_owned(),
        scene: Scene::default(),
        settings: settings.parse().expect("is TOML"),
        shows_another_picture: false,
        trials: trials.map(|(seed, factor)| trial(seed, factor)).collect(),
    }
}

/// Three seeds of a scene and a noisier variant, with an exact answer.
pub fn study() -> Study {
    Study {
        scene_name: "room.toml".to_owned(),
        date: "2026-11-28 01:05 UTC".to_owned(),
        command: None,
        warnings: Vec::new(),
        triangles: 12,
        picture: None,
        machine: Machine {
            cpu: "A CPU".to_owned(),
            threads: 2,
            os: "linux x86_64".to_owned(),
        },
        reference: Reference::exact([1.0; 3], 2, 1),
        seeds: 3,
        default_settings: "mode = \"direct\"\nmirror = true\n"
            .parse()
            .expect("is TOML"),
        variants: vec![
            variant("as the scene says", [1.0, 0.8, 1.2]),
            variant("render.a=1, \"b\"", [2.0, 2.0, 2.0]),
        ],
    }
}
