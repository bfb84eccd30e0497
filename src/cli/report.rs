//! `raymini report`: error against run time.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::Args;

use super::scene_arguments::SceneArguments;
use super::values;
use crate::analysis::report::{
    ReferenceOptions, ReportError, ReportOptions, ReportPlan, ReportProgress, Study, Summary,
    parse_radiance,
};
use crate::control::CancelToken;
use crate::math::{percent, three_digits};
use crate::render::RunConfig;

/// What `raymini report` takes.
#[derive(Debug, Args)]
pub struct ReportArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Folder to write report.json, report.csv, report.svg and report.md to
    #[arg(short, long, value_name = "DIR", allow_hyphen_values = true, value_parser = values::output())]
    output: PathBuf,

    /// Samples per pixel at the last point; the scene's when left out, but at least 16
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::whole(ReportOptions::SAMPLES))]
    spp: Option<u32>,

    /// Renders of each variant: with the scene's seed, the one after it, and so on
    #[arg(
        long,
        value_name = "N",
        default_value_t = ReportOptions::DEFAULT_SEEDS,
        allow_hyphen_values = true,
        value_parser = values::whole(ReportOptions::SEEDS)
    )]
    seeds: u32,

    /// Threads to use; one per core when left out
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::threads)]
    threads: Option<u16>,

    /// Lay the curve of a variant over that of the scene, e.g. render.shadows=hard; may be given several times
    #[arg(long = "compare", value_name = "KEY=VALUE[;KEY=VALUE...]")]
    comparisons: Vec<String>,

    /// Measure against this picture (.exr, .png, .hdr); one is rendered when left out
    #[arg(long, value_name = "FILE", conflicts_with_all = ["reference_samples", "exact"],
          allow_hyphen_values = true, value_parser = values::input())]
    reference: Option<PathBuf>,

    /// Samples per pixel of the rendered reference; 16 times those of the last point when left out
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::samples)]
    reference_samples: Option<u32>,

    /// Measure against the exact answer: this radiance in every pixel
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = parse_radiance, conflicts_with = "reference_samples")]
    exact: Option<[f32; 3]>,
}

impl ReportArguments {
    fn options(&self) -> ReportOptions {
        ReportOptions {
            size: self.scene.size,
            samples: self.spp,
            seeds: self.seeds,
            assignments: self.scene.assignments.clone(),
            comparisons: self.comparisons.clone(),
            reference: match (&self.reference, self.exact) {
                (Some(path), _) => ReferenceOptions::File(path.clone()),
                (None, Some(radiance)) => ReferenceOptions::Exact(radiance),
                (None, None) => ReferenceOptions::Rendered {
                    samples: self.reference_samples,
                },
            },
        }
    }
}

pub(super) fn run(arguments: &ReportArguments) -> Result<()> {
    let loaded = super::load(arguments.scene.path())?;
    let name = arguments.scene.name();
    let plan = ReportPlan::new(name, loaded, &arguments.options(), &CancelToken::new())
        .map_err(with_option)?;
    for warning in &plan.warnings {
        super::warn(warning);
    }
    let run = RunConfig {
        threads: arguments.threads.map_or(0, usize::from),
        ..RunConfig::default()
    };
    let progress = ReportProgress::default();
    let study = super::progress_bar::show(
        || progress.how_far(),
        || plan.carry_out(&run, &arguments.output, &progress, |_| ()),
    )?;
    let study = study.ok_or_else(|| anyhow!("rendering was cancelled"))?;
    describe(&study, &arguments.output)
}

/// The error with the option it is about.
fn with_option(error: ReportError) -> anyhow::Error {
    match error {
        ReportError::Comparison { .. } => anyhow!("--compare {error}"),
        error => error.into(),
    }
}

/// Prints what came out, and warns of what went wrong.
fn describe(study: &Study, folder: &Path) -> Result<()> {
    super::say(&format!(
        "{}: report.json, report.csv, report.svg, report.md",
        folder.display()
    ))?;
    super::say(&format!("reference: {}", study.reference.describe()))?;
    for variant in study.measured() {
        let Some(summary) = Summary::of(variant, &study.reference) else {
            continue;
        };
        if let Some(last) = summary.points.last() {
            let estimated = last.estimated_noise().map_or_else(String::new, |noise| {
                format!(" (estimated {})", percent(noise.median))
            });
            let slope = summary
                .noise_slope
                .map_or_else(String::new, |slope| format!(", slope {slope:.2}"));
            super::say(&format!(
                "{}: {}{estimated} after {} s{slope}",
                variant.name,
                last.noise_in_words(),
                three_digits(last.seconds.median)
            ))?;
        }
        if let Some(honesty) = summary.honesty {
            let [least, most] = honesty.estimated_over_true;
            super::say(&format!(
                "{}: estimated / true error {least:.2} to {most:.2} from 16 samples on, {} of {} intervals held the truth",
                variant.name, honesty.intervals_held, honesty.intervals
            ))?;
        }
        if let Some(doubt) = summary.doubt() {
            super::warn(&format!("{}: {doubt}", variant.name));
        }
        if summary.clamped.samples > 0 {
            super::warn(&format!(
                "{}: render.clamp took {} of the light away, an error that no estimate knows and no sample cures",
                variant.name,
                percent(summary.clamped.energy_share)
            ));
        }
        if summary.non_finite_samples > 0 {
            super::warn(&format!(
                "{}: {} samples were infinite or not a number",
                variant.name, summary.non_finite_samples
            ));
        }
        if summary.negative_samples > 0 {
            super::warn(&format!(
                "{}: {} samples had less than no light",
                variant.name, summary.negative_samples
            ));
        }
    }
    Ok(())
}
