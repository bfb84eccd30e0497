//! `raymini report`: error against run time.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::Args;

use super::scene_arguments::SceneArguments;
use super::{Signals, values};
use crate::analysis::report::{
    REPORT_FILES, ReferenceOptions, ReportError, ReportOptions, ReportPlan, ReportProgress, Study,
    Summary, Variant, parse_radiance,
};
use crate::control::CancelToken;
use crate::math::{counted, percent, time_in_words};
use crate::render::RunConfig;

/// What `raymini report` takes.
#[derive(Debug, Args)]
pub struct ReportArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    /// Folder to write report.md, report.svg, report.png, report.json and report.csv to
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

pub(super) fn run(arguments: &ReportArguments, signals: &Signals) -> Result<ExitCode> {
    let cancel = signals.cancel_instead();
    let mut done = 0;
    let carried_out = carry_out(arguments, &cancel, &mut done);
    let Some(code) = signals.exit_code().filter(|_| cancel.is_cancelled()) else {
        carried_out?;
        return Ok(ExitCode::SUCCESS);
    };
    let folder = arguments.output.display();
    match (carried_out, done) {
        (Err(error), _) => super::tell(&format!("interrupted: {error:#}")),
        (Ok(_), 0) => super::tell("interrupted before a render was measured: no report is written"),
        (Ok(true), _) => {}
        (Ok(false), done) => {
            super::warn(&format!(
                "interrupted: the report in {folder} holds {} done so far",
                counted(done as u64, "render", "renders")
            ));
        }
    }
    Ok(code.into())
}

/// Carries the report out, counts the renders that are `done`, and tells what came out, also where it is interrupted or cannot be
/// written. Returns whether it is whole.
fn carry_out(arguments: &ReportArguments, cancel: &CancelToken, done: &mut usize) -> Result<bool> {
    let name = arguments.scene.name();
    let Some(loaded) = super::load_unless(cancel, arguments.scene.path())? else {
        return Ok(false);
    };
    let mut plan =
        ReportPlan::new(name, loaded, &arguments.options(), cancel).map_err(with_option)?;
    plan.command = Some(command_line(std::env::args_os().skip(1)));
    for warning in &plan.warnings {
        super::warn(warning);
    }
    let run = RunConfig {
        threads: arguments.threads.map_or(0, usize::from),
        cancel: cancel.clone(),
        ..RunConfig::default()
    };
    let progress = ReportProgress::default();
    let mut findings = Vec::new();
    let carried_out = super::progress_bar::show(
        || progress.how_far(),
        || {
            plan.carry_out(&run, &arguments.output, &progress, |study| {
                *done += 1;
                findings = findings_of(study);
            })
        },
    );
    if !matches!(
        carried_out,
        Err(ReportError::File { .. } | ReportError::Elsewhere { .. })
    ) && *done > 0
    {
        super::say(&format!(
            "{}: {}",
            arguments.output.display(),
            REPORT_FILES.join(", ")
        ))?;
    }
    for finding in &findings {
        match finding {
            Finding::Fact(text) => super::say(text)?,
            Finding::Warning(text) => super::warn(text),
        }
    }
    Ok(carried_out?.is_some())
}

/// The command with these arguments, as a POSIX shell takes it.
fn command_line(arguments: impl Iterator<Item = OsString>) -> String {
    let quoted = arguments.map(|argument| {
        let argument = argument.to_string_lossy();
        let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
        if !argument.is_empty() && argument.chars().all(is_plain) {
            argument.into_owned()
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    });
    let words = std::iter::once("raymini".to_owned()).chain(quoted);
    words.collect::<Vec<_>>().join(" ")
}

/// The error with the option it is about.
fn with_option(error: ReportError) -> anyhow::Error {
    match error {
        ReportError::Comparison { .. } => anyhow!("--compare {error}"),
        error => error.into(),
    }
}

/// A line of what came out.
enum Finding {
    Fact(String),
    /// Of what went wrong.
    Warning(String),
}

/// What came out so far.
fn findings_of(study: &Study) -> Vec<Finding> {
    let reference = format!("reference: {}", study.reference.describe());
    let mut findings = vec![Finding::Fact(reference)];
    let mut load = None;
    for variant in study.measured() {
        if let Some(summary) = Summary::of(variant, &study.reference) {
            findings.extend(findings_of_variant(variant, &summary));
            load = load.or(summary.load());
        }
    }
    findings.extend(load.map(Finding::Warning));
    findings
}

fn findings_of_variant(variant: &Variant, summary: &Summary) -> Vec<Finding> {
    let name = &variant.name;
    let mut findings = Vec::new();
    let mut say = |text: String| findings.push(Finding::Fact(format!("{name}: {text}")));
    if let Some(last) = summary.points.last() {
        let estimated = last.estimated_noise().map_or_else(String::new, |noise| {
            format!(" (estimated {})", percent(noise.median))
        });
        let slope = summary
            .noise_slope
            .map_or_else(String::new, |slope| format!(", slope {}", slope.in_words()));
        say(format!(
            "{}{estimated} after {}{slope}",
            last.noise_in_words(),
            time_in_words(last.seconds.median)
        ));
    }
    if let Some(honesty) = &summary.honesty {
        say(honesty.in_words());
    }
    let mut warn = |text: String| findings.push(Finding::Warning(format!("{name}: {text}")));
    if let Some(doubt) = summary.doubt() {
        warn(doubt);
    }
    if summary.clamped.samples > 0 {
        warn(format!(
            "render.clamp took {} of the light away, an error that no estimate knows and no sample cures",
            percent(summary.clamped.energy_share)
        ));
    }
    let counts = [
        (
            summary.non_finite_samples,
            ["sample was", "samples were"],
            "infinite or not a number",
        ),
        (
            summary.negative_samples,
            ["sample had", "samples had"],
            "less than no light",
        ),
    ];
    for (count, [one, many], fault) in counts {
        if count > 0 {
            warn(format!("{} {fault}", counted(count, one, many)));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `printf '%s\n'` of a shell gives back what was meant.
    #[test]
    fn a_command_is_quoted_as_a_shell_takes_it() {
        let arguments = ["report", "my scene.toml", "--compare", "a=1; b=$x", "it's"];
        let line = command_line(arguments.iter().map(OsString::from));
        let expected = r"raymini report 'my scene.toml' --compare 'a=1; b=$x' 'it'\''s'";
        assert_eq!(line, expected);
    }
}
