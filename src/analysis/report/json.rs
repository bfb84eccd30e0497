//! The report for programs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::fit::TimeTo;
use super::honesty::Honesty;
use super::reference::{Origin, Reference};
use super::study::{Machine, Study, Variant};
use super::summary::{Efficiency, Summary, SummaryPoint};
use super::target::Target;
use crate::analysis::bench::Spread;
use crate::render::{Clamped, Interval, NOISE_TARGETS};
use crate::scene::Choice;

/// The file. Numbers that cannot be formed are null.
#[derive(Debug, Serialize)]
struct ReportFacts<'a> {
    version: &'static str,
    scene: &'a str,
    date: &'a str,
    /// What makes the report again, as a shell takes it; null where no command made it.
    command: Option<&'a str>,
    triangles: u64,
    /// What looked wrong before anything was rendered.
    warnings: &'a [String],
    /// Whether every variant has been rendered with every seed.
    finished: bool,
    machine: &'a Machine,
    reference: ReferenceFacts<'a>,
    /// The scene as it is.
    #[serde(flatten)]
    base: Option<VariantFacts<'a>>,
    variants: Vec<VariantFacts<'a>>,
}

#[derive(Debug, Serialize)]
struct ReferenceFacts<'a> {
    kind: &'static str,
    samples_per_pixel: Option<u32>,
    seed: Option<u64>,
    light_sampling: Option<&'static str>,
    render_seconds: Option<f64>,
    file: Option<&'a str>,
    radiance: Option<[f32; 3]>,
    /// Its own error: null where it is not known. What a file tells comes without an interval.
    rmse: Option<f64>,
    rmse_interval: Option<[f64; 2]>,
    relmse: Option<f64>,
    relmse_interval: Option<[f64; 2]>,
    non_finite_samples: Option<u64>,
}

#[derive(Debug, Serialize)]
struct VariantFacts<'a> {
    name: &'a str,
    seeds: Vec<u64>,
    settings: &'a toml::Table,
    build_seconds: f64,
    build_seconds_range: [f64; 2],
    points: Vec<PointFacts>,
    slope: Option<f64>,
    noise_slope: Option<f64>,
    /// The least and the largest of the slopes of one seed each.
    noise_slope_range: Option<[f64; 2]>,
    cpu_noise_slope: Option<f64>,
    cpu_noise_slope_range: Option<[f64; 2]>,
    /// CPU seconds over threads × wall seconds; null where it is not known.
    cpu_share: Option<f64>,
    shows_another_picture: bool,
    /// Null where there is no estimate from 16 samples on.
    honesty: Option<Honesty>,
    /// Samples from which on most of what is measured is not the renders' noise; null where it always is.
    reference_outweighs_from: Option<f64>,
    efficiency: Efficiency,
    time_to: BTreeMap<String, Option<TimeTo>>,
    /// What it took to the noise at which the renders stop; null where they stop at none.
    target: Option<Target>,
    non_finite_samples: u64,
    negative_samples: u64,
    clamped: Clamped,
    unmeasured_pixels: u64,
}

/// Medians over seeds; what is called a range holds the least and the largest.
#[derive(Debug, Serialize)]
struct PointFacts {
    samples_per_pixel: f64,
    seconds: f64,
    seconds_range: [f64; 2],
    cpu_seconds: f64,
    cpu_seconds_range: [f64; 2],
    seconds_with_build: f64,
    seconds_with_build_range: [f64; 2],
    estimated_rmse: Option<f64>,
    estimated_rmse_range: Option<[f64; 2]>,
    estimated_rmse_interval: Option<[f64; 2]>,
    estimated_relmse: Option<f64>,
    estimated_relmse_range: Option<[f64; 2]>,
    estimated_relmse_interval: Option<[f64; 2]>,
    estimated_percentile_999: Option<f64>,
    estimated_percentile_999_range: Option<[f64; 2]>,
    estimated_percentile_999_interval: Option<[f64; 2]>,
    true_rmse: f64,
    true_rmse_range: [f64; 2],
    true_relmse: f64,
    true_relmse_range: [f64; 2],
    true_percentile_999: f64,
    true_percentile_999_range: [f64; 2],
    /// With the reference's own error in it.
    measured_rmse: f64,
    measured_rmse_range: [f64; 2],
    measured_relmse: f64,
    measured_relmse_range: [f64; 2],
}

/// The report as JSON.
///
/// # Panics
/// When a setting has no place in JSON, such as a date, which no scene has.
#[must_use]
pub fn to_json(study: &Study) -> String {
    let mut variants = study
        .measured()
        .filter_map(|variant| VariantFacts::new(variant, &study.reference));
    let facts = ReportFacts {
        version: env!("CARGO_PKG_VERSION"),
        scene: &study.scene_name,
        date: &study.date,
        command: study.command.as_deref(),
        triangles: study.triangles,
        warnings: &study.warnings,
        finished: study.next().is_none(),
        machine: &study.machine,
        reference: ReferenceFacts::new(&study.reference),
        base: variants.next(),
        variants: variants.collect(),
    };
    serde_json::to_string_pretty(&facts).expect("all keys are texts") + "\n"
}

fn range(spread: Spread) -> [f64; 2] {
    [spread.min, spread.max]
}

impl<'a> ReferenceFacts<'a> {
    fn new(reference: &'a Reference) -> Self {
        let ends = |interval: Interval| [interval.low, interval.high];
        let mut facts = Self {
            kind: "exact",
            samples_per_pixel: None,
            seed: None,
            light_sampling: None,
            render_seconds: None,
            file: None,
            radiance: None,
            rmse: reference.known_errors().map(|[rmse, _]| rmse),
            rmse_interval: reference.rmse().map(ends),
            relmse: reference.known_errors().map(|[_, relmse]| relmse),
            relmse_interval: reference.relmse().map(ends),
            non_finite_samples: None,
        };
        match &reference.origin {
            Origin::Exact { radiance } => facts.radiance = Some(*radiance),
            Origin::File { name, .. } => {
                facts.kind = "file";
                facts.file = Some(name);
            }
            Origin::Rendered {
                seed,
                samples_per_pixel,
                light_sampling,
                render_seconds,
                non_finite_samples,
                error: _,
            } => {
                facts.kind = "rendered";
                facts.seed = Some(*seed);
                facts.samples_per_pixel = Some(*samples_per_pixel);
                facts.light_sampling = light_sampling.map(Choice::name);
                facts.render_seconds = Some(*render_seconds);
                facts.non_finite_samples = Some(*non_finite_samples);
            }
        }
        facts
    }
}

impl<'a> VariantFacts<'a> {
    fn new(variant: &'a Variant, reference: &Reference) -> Option<Self> {
        let summary = Summary::of(variant, reference)?;
        let times = NOISE_TARGETS.iter().zip(summary.time_to);
        Some(Self {
            name: &variant.name,
            seeds: variant.trials.iter().map(|trial| trial.seed).collect(),
            settings: &variant.settings,
            build_seconds: summary.build_seconds.median,
            build_seconds_range: range(summary.build_seconds),
            points: summary.points.iter().map(PointFacts::from).collect(),
            slope: summary.slope,
            noise_slope: summary.noise_slope.map(|slope| slope.value),
            noise_slope_range: summary.noise_slope.map(|slope| slope.range),
            cpu_noise_slope: summary.cpu_noise_slope.map(|slope| slope.value),
            cpu_noise_slope_range: summary.cpu_noise_slope.map(|slope| slope.range),
            cpu_share: summary.cpu_share,
            shows_another_picture: summary.shows_another_picture,
            honesty: summary.honesty,
            reference_outweighs_from: summary.reference_outweighs_from,
            efficiency: summary.efficiency,
            time_to: times
                .map(|(noise, time)| (format!("{noise:.2}"), time))
                .collect(),
            target: summary.target,
            non_finite_samples: summary.non_finite_samples,
            negative_samples: summary.negative_samples,
            clamped: summary.clamped,
            unmeasured_pixels: summary.unmeasured_pixels,
        })
    }
}

impl From<&SummaryPoint> for PointFacts {
    fn from(point: &SummaryPoint) -> Self {
        let estimated = point.estimated;
        Self {
            samples_per_pixel: point.samples_per_pixel,
            seconds: point.seconds.median,
            seconds_range: range(point.seconds),
            cpu_seconds: point.cpu_seconds.median,
            cpu_seconds_range: range(point.cpu_seconds),
            seconds_with_build: point.seconds_with_build.median,
            seconds_with_build_range: range(point.seconds_with_build),
            estimated_rmse: estimated.map(|e| e.rmse.median),
            estimated_rmse_range: estimated.map(|e| range(e.rmse)),
            estimated_rmse_interval: estimated.map(|e| e.rmse_interval),
            estimated_relmse: estimated.map(|e| e.relmse.median),
            estimated_relmse_range: estimated.map(|e| range(e.relmse)),
            estimated_relmse_interval: estimated.map(|e| e.relmse_interval),
            estimated_percentile_999: estimated.map(|e| e.percentile_999.median),
            estimated_percentile_999_range: estimated.map(|e| range(e.percentile_999)),
            estimated_percentile_999_interval: estimated.map(|e| e.percentile_999_interval),
            true_rmse: point.true_rmse.median,
            true_rmse_range: range(point.true_rmse),
            true_relmse: point.true_relmse.median,
            true_relmse_range: range(point.true_relmse),
            true_percentile_999: point.true_percentile_999.median,
            true_percentile_999_range: range(point.true_percentile_999),
            measured_rmse: point.measured_rmse.median,
            measured_rmse_range: range(point.measured_rmse),
            measured_relmse: point.measured_relmse.median,
            measured_relmse_range: range(point.measured_relmse),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::analysis::report::test_data;

    fn value(study: &Study) -> Value {
        serde_json::from_str(&to_json(study)).expect("is JSON")
    }

    #[test]
    fn the_base_is_at_the_top_and_variants_have_the_same_keys() {
        let report = value(&test_data::study());
        assert_eq!(report["finished"], true);
        assert_eq!(report["seeds"], json!([7, 8, 9]));
        assert_eq!(report["settings"]["stop"]["noise"], 0.03);
        assert_eq!(report["machine"]["threads"], 2);
        assert_eq!(report["reference"]["kind"], "exact");
        assert_eq!(report["reference"]["rmse"], 0.0);
        assert_eq!(report["points"][0]["estimated_rmse"], Value::Null);
        assert_eq!(report["points"][3]["seconds_with_build"], 8.5);
        assert_eq!(report["points"][3]["true_percentile_999"], 0.625);
        let interval = &report["points"][3]["estimated_percentile_999_interval"];
        assert_eq!(*interval, json!([0.4, 0.625]));
        assert_eq!(report["reference_outweighs_from"], Value::Null);
        assert_eq!(report["triangles"], 12);
        assert_eq!(report["shows_another_picture"], false);
        let ends = [0, 1].map(|end| report["noise_slope_range"][end].as_f64());
        assert!(ends[0] <= ends[1] && ends[0].is_some());
        assert!(report["cpu_noise_slope"].is_number());
        assert_eq!(report["time_to"]["0.10"]["predicted"], false);
        assert_eq!(report["time_to"]["0.03"]["predicted"], true);
        let variant = report["variants"][0].as_object().expect("an object");
        assert_eq!(variant["name"], "render.a=1, \"b\"");
        for key in variant.keys() {
            assert!(report.get(key).is_some(), "{key}");
        }
    }

    #[test]
    fn a_report_is_written_before_all_is_rendered() {
        let mut study = test_data::study();
        study.variants[1].trials.clear();
        let report = value(&study);
        assert_eq!(report["finished"], false);
        assert_eq!(report["variants"], json!([]));
        study.reference = test_data::rendered_reference(0.1, 0.04);
        let reference = &value(&study)["reference"];
        assert_eq!(reference["kind"], "rendered");
        assert_eq!(reference["relmse"], 0.04);
        assert_eq!(reference["light_sampling"], Value::Null);
        study.reference = test_data::file_reference(Some(0.25));
        let report = value(&study);
        assert_eq!(report["reference"]["rmse"], 0.25);
        assert_eq!(report["reference"]["relmse"], 0.25);
        assert_eq!(report["reference"]["relmse_interval"], Value::Null);
        assert_eq!(report["reference_outweighs_from"], 1.0);
        assert_eq!(
            report["points"][0]["true_relmse"],
            report["points"][0]["measured_relmse"]
        );
    }
}
