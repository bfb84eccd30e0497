//! `raymini report`: error against run time.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;

use crate::analysis::report::{
    Machine, Origin, Reference, Study, Summary, Variant, percent, three_digits, to_chart, to_csv,
    to_json, to_markdown,
};
use crate::control::CancelToken;
use crate::io::{self, LoadedScene, scene_file};
use crate::render::{PictureMemory, RenderProgress, RunConfig};
use crate::scene::{RenderSettings, Scene};

/// Fewest samples of a pixel at the last point: 3 points that a slope is fitted to.
const LEAST_SAMPLES: u32 = 16;

/// How many times the samples of what is measured the reference gets: 1/16 of its mean square error, or less.
const REFERENCE_FACTOR: u32 = 16;

/// What `raymini report` takes.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// A scene file (.toml) or a mesh; the built-in demo when left out
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,

    /// Folder to write report.json, report.csv, report.svg and report.md to
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Picture size in pixels; the scene's when left out
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    size: Option<(u32, u32)>,

    /// Samples per pixel at the last point; the scene's when left out, but at least 16
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(i64::from(LEAST_SAMPLES)..=i64::from(RenderSettings::MAX_SAMPLES))
    )]
    spp: Option<u32>,

    /// Renders of each variant: with the scene's seed, the one after it, and so on
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,

    /// Threads to use; one per core when left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// Change any key of the scene, e.g. render.shadows=off; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    assignments: Vec<String>,

    /// Lay the curve of a variant over that of the scene, e.g. render.shadows=hard; may be given several times
    #[arg(long = "compare", value_name = "KEY=VALUE[;KEY=VALUE...]")]
    comparisons: Vec<String>,

    /// Measure against this picture (.exr, .png, .hdr); one is rendered when left out
    #[arg(long, value_name = "FILE", conflicts_with_all = ["reference_samples", "exact"])]
    reference: Option<PathBuf>,

    /// Samples per pixel of the rendered reference; 16 times those of the last point when left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(RenderSettings::MAX_SAMPLES)))]
    reference_samples: Option<u32>,

    /// Measure against the exact answer: this radiance in every pixel
    #[arg(long, value_name = "R,G,B", value_parser = parse_radiance, conflicts_with = "reference_samples")]
    exact: Option<[f32; 3]>,
}

fn parse_radiance(text: &str) -> Result<[f32; 3], String> {
    let values: Option<Vec<f32>> = text
        .split(',')
        .map(|value| {
            value
                .trim()
                .parse()
                .ok()
                .filter(|value: &f32| value.is_finite())
        })
        .collect();
    let values = values.and_then(|values| values.try_into().ok());
    values.ok_or_else(|| "expected red, green, blue, such as 1,1,1".to_owned())
}

pub(super) fn run(arguments: &ReportArguments) -> Result<()> {
    let variants = variants(arguments)?;
    let name = arguments
        .scene
        .as_ref()
        .map_or_else(|| "demo".to_owned(), |path| path.display().to_string());
    let run = RunConfig {
        threads: arguments.threads.map_or(0, usize::from),
        ..RunConfig::default()
    };
    // Before work is spent on what could not be written.
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| format!("{}: the folder cannot be made", arguments.output.display()))?;
    for path in FILES.map(|name| arguments.output.join(name)) {
        io::check_writable(&path).with_context(|| cannot_write(&path))?;
    }

    let plan = Plan::new(arguments, variants)?;
    let memory = PictureMemory {
        pixels: plan.variants[0].scene.render.pixel_count(),
        layers: 0,
        has_error: true,
        // The reference, and what is measured against it.
        copies: 2,
    };
    memory.require()?;
    let steps = Steps::new(plan.work());
    let study = super::render::with_progress_bar(
        || steps.how_far(),
        || plan.carry_out(name, &run, &steps, &arguments.output),
    )?;
    describe(&study, &arguments.output)
}

/// The scene as it is, and what is compared with it; tells what is wrong with them.
fn variants(arguments: &ReportArguments) -> Result<Vec<Variant>> {
    let mut loaded = super::load(arguments.scene.as_deref())?;
    let samples = arguments
        .spp
        .unwrap_or(loaded.scene.render.samples_per_pixel.max(LEAST_SAMPLES));
    let mut assignments = vec![
        format!("render.samples_per_pixel={samples}"),
        "render.error_estimate=true".to_owned(),
    ];
    if let Some((width, height)) = arguments.size {
        assignments.push(format!("render.width={width}"));
        assignments.push(format!("render.height={height}"));
    }
    // Last, so that they have the last word.
    assignments.extend_from_slice(&arguments.assignments);
    io::override_scene(&mut loaded, &assignments, &CancelToken::new())?;
    let warnings = warnings(&loaded);
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }

    let mut variants = vec![variant("as the scene says", &loaded.scene)];
    for comparison in &arguments.comparisons {
        let assignments: Vec<String> = comparison
            .split(';')
            .map(|assignment| assignment.trim().to_owned())
            .filter(|assignment| !assignment.is_empty())
            .collect();
        if assignments.is_empty() {
            bail!("--compare {comparison}: expected KEY=VALUE, such as render.light_sampling=nee");
        }
        let mut changed = loaded.clone();
        io::override_scene(&mut changed, &assignments, &CancelToken::new())
            .with_context(|| format!("--compare {comparison}"))?;
        let known = |warning: &String| warnings.contains(warning);
        for warning in self::warnings(&changed).iter().filter(|w| !known(w)) {
            eprintln!("warning: --compare {comparison}: {warning}");
        }
        let sizes = [&loaded, &changed].map(|l| (l.scene.render.width, l.scene.render.height));
        if sizes[0] != sizes[1] {
            bail!("--compare {comparison}: all pictures must be of one size");
        }
        variants.push(variant(&assignments.join("; "), &changed.scene));
    }
    Ok(variants)
}

fn warnings(loaded: &LoadedScene) -> Vec<String> {
    let of_scene = loaded.scene.warnings();
    let all = loaded.warnings.iter().map(ToString::to_string);
    all.chain(of_scene.iter().map(ToString::to_string))
        .collect()
}

fn variant(name: &str, scene: &Scene) -> Variant {
    Variant {
        name: name.to_owned(),
        scene: scene.clone(),
        settings: settings(&scene.render),
        trials: Vec::new(),
    }
}

/// The settings as a scene file says them.
fn settings(render: &RenderSettings) -> toml::Table {
    let scene = Scene {
        render: render.clone(),
        ..Scene::default()
    };
    let mut table: toml::Table = scene_file::write(&scene)
        .parse()
        .expect("a written scene can be read");
    match table.remove("render") {
        Some(toml::Value::Table(render)) => render,
        _ => toml::Table::new(),
    }
}

/// What is to be done.
struct Plan {
    variants: Vec<Variant>,
    seeds: u32,
    reference: Wanted,
}

/// The reference that was asked for.
enum Wanted {
    Given(Reference),
    Rendered { seed: u64, samples: u32 },
}

impl Plan {
    fn new(arguments: &ReportArguments, variants: Vec<Variant>) -> Result<Self> {
        let RenderSettings { width, height, .. } = variants[0].scene.render;
        let reference = if let Some(path) = &arguments.reference {
            Wanted::Given(read_reference(path, width, height)?)
        } else if let Some(radiance) = arguments.exact {
            Wanted::Given(Reference::exact(radiance, width, height))
        } else {
            let most = variants.iter().map(|v| v.scene.render.samples_per_pixel);
            let samples = most.max().expect("there is one") * REFERENCE_FACTOR;
            Wanted::Rendered {
                seed: free_seed(&variants, arguments.seeds),
                samples: arguments
                    .reference_samples
                    .unwrap_or(samples.min(RenderSettings::MAX_SAMPLES)),
            }
        };
        Ok(Self {
            variants,
            seeds: arguments.seeds,
            reference,
        })
    }

    /// Samples per pixel of all renders together, as far as that is known.
    fn work(&self) -> f64 {
        let trials = self.variants.iter().map(samples).sum::<f64>() * f64::from(self.seeds);
        match self.reference {
            Wanted::Given(_) => trials,
            Wanted::Rendered { samples, .. } => trials + f64::from(samples),
        }
    }

    /// Renders all, and writes after each render what is known.
    fn carry_out(
        self,
        scene_name: String,
        run: &RunConfig,
        steps: &Steps,
        folder: &Path,
    ) -> Result<Study> {
        let cancelled = || anyhow!("rendering was cancelled");
        let reference = match self.reference {
            Wanted::Given(reference) => reference,
            Wanted::Rendered { seed, samples } => {
                let progress = steps.begin("reference", f64::from(samples));
                let scene = &self.variants[0].scene;
                Reference::render(scene, seed, samples, run, &progress)?.ok_or_else(cancelled)?
            }
        };
        let mut study = Study {
            scene_name,
            machine: Machine {
                cpu: cpu_name(),
                threads: run.thread_count(),
                os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            },
            reference,
            seeds: self.seeds,
            default_settings: settings(&RenderSettings::default()),
            variants: self.variants,
        };
        while let Some(index) = study.next() {
            let variant = &study.variants[index];
            let number = variant.trials.len() + 1;
            let what = format!("{}, seed {number} of {}", variant.name, study.seeds);
            let progress = steps.begin(&what, samples(variant));
            study.render_next(run, &progress)?.ok_or_else(cancelled)?;
            write(&study, folder)?;
        }
        Ok(study)
    }
}

fn samples(variant: &Variant) -> f64 {
    f64::from(variant.scene.render.samples_per_pixel)
}

/// The first seed after those of the scene that no variant is rendered with.
fn free_seed(variants: &[Variant], seeds: u32) -> u64 {
    let is_used = |seed| {
        let mut used = variants.iter().flat_map(|v| (0..seeds).map(|n| v.seed(n)));
        used.any(|used| used == seed)
    };
    let mut after = (seeds..=u32::MAX).map(|number| variants[0].seed(number));
    let free = after.find(|&seed| !is_used(seed));
    free.expect("there are more seeds than renders")
}

fn read_reference(path: &Path, width: u32, height: u32) -> Result<Reference> {
    let file = io::read_image(path)?;
    let name = path.display().to_string();
    for warning in &file.warnings {
        eprintln!("warning: {name}: {warning}");
    }
    if file.format == "PNG" {
        eprintln!(
            "warning: {name}: a PNG holds what a screen shows: exposure, tone curve, the end at 1 and rounding are in it"
        );
    }
    let image = file.image;
    if (image.width, image.height) != (width, height) {
        bail!(
            "{name}: the reference is {}×{} pixels, but the scene's picture is {width}×{height}",
            image.width,
            image.height
        );
    }
    Ok(Reference {
        image,
        origin: Origin::File { name },
    })
}

/// The processor's name where the system tells (Linux), else its kind.
fn cpu_name() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// What is written into the report's folder.
const FILES: [&str; 4] = ["report.json", "report.csv", "report.svg", "report.md"];

fn write(study: &Study, folder: &Path) -> Result<()> {
    let texts = [
        to_json(study),
        to_csv(study),
        to_chart(study).to_svg(),
        to_markdown(study),
    ];
    for (name, text) in FILES.into_iter().zip(texts) {
        let path = folder.join(name);
        io::write_atomically(&path, |file| file.write_all(text.as_bytes()))
            .with_context(|| cannot_write(&path))?;
    }
    Ok(())
}

fn cannot_write(path: &Path) -> String {
    format!("{}: cannot write the report", path.display())
}

/// Prints what came out, and warns of what went wrong.
fn describe(study: &Study, folder: &Path) -> Result<()> {
    super::say(&format!("{}: {}", folder.display(), FILES.join(", ")))?;
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
                "{}: noise {}{estimated} after {} s{slope}",
                variant.name,
                percent(last.true_noise().median),
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
        if summary.non_finite_samples > 0 {
            eprintln!(
                "warning: {}: {} samples were infinite or not a number",
                variant.name, summary.non_finite_samples
            );
        }
    }
    Ok(())
}

/// How far a series of renders is.
struct Steps {
    /// In samples per pixel, as all that follows.
    total: f64,
    state: Mutex<Step>,
}

/// The render that is going on.
#[derive(Default)]
struct Step {
    name: String,
    before: f64,
    own: f64,
    progress: RenderProgress,
}

impl Steps {
    fn new(total: f64) -> Self {
        Self {
            total,
            state: Mutex::default(),
        }
    }

    /// Begins the next render, which is called `name`.
    fn begin(&self, name: &str, samples: f64) -> RenderProgress {
        let mut step = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        *step = Step {
            name: name.to_owned(),
            before: step.before + step.own,
            own: samples,
            progress: RenderProgress::default(),
        };
        step.progress.clone()
    }

    /// The done part of the whole, and what is being done.
    fn how_far(&self) -> (f64, String) {
        let step = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let done = step.before + step.own * step.progress.samples.fraction();
        (done / self.total, step.name.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_radiance_is_three_numbers() {
        assert_eq!(parse_radiance("1, 0.5,2"), Ok([1.0, 0.5, 2.0]));
        for wrong in ["1", "1,2", "1,2,3,4", "a,1,1", "1,1,inf", ""] {
            assert!(parse_radiance(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_reference_has_a_seed_of_its_own() {
        let with_seed = |seed| {
            let mut scene = Scene::default();
            scene.render.seed = seed;
            variant("", &scene)
        };
        assert_eq!(free_seed(&[with_seed(3)], 5), 8);
        assert_eq!(free_seed(&[with_seed(3), with_seed(8)], 5), 13);
        assert_eq!(free_seed(&[with_seed(RenderSettings::MAX_SEED)], 5), 4);
    }

    #[test]
    fn settings_are_those_of_a_scene_file() {
        let mut render = RenderSettings::default();
        render.stop.noise = Some(0.03);
        let table = settings(&render);
        assert_eq!(table["mode"].as_str(), Some("direct"));
        assert_eq!(table["stop"]["noise"].as_float(), Some(0.03));
    }
}
