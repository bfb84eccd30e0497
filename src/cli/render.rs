use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::{Serialize, Serializer};

use super::Signals;
use super::checkpoint::{CheckpointArguments, CheckpointFile};
use super::costs::MeasuredCosts;
use super::plan::PlannedFeature;
use super::trace::TraceArguments;
use crate::analysis::cost::Trial;
use crate::control::{CancelToken, Progress};
use crate::io::{self, Origin};
use crate::render::{
    Bands, Checkpoint, CheckpointKeeper, Clamped, Ending, ErrorEstimate, Image, Interval,
    PictureMemory, PreparedScene, RayCounts, Region, RenderOutcome, RenderProgress, RenderStats,
    RunConfig, Watch, render_watched, resume,
};
use crate::scene::{Choice, Mode, RenderSettings, Scene};

/// What `raymini render` takes.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// A scene file (.toml) or a mesh; the built-in demo when left out
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,

    /// Where to write the picture: .png, or .exr for the radiance itself
    #[arg(short, long, value_name = "FILE", required_unless_present = "pixel")]
    output: Option<PathBuf>,

    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,

    /// What a pixel holds
    #[arg(long, value_parser = Mode::ALL.iter().map(|(_, name)| *name).collect::<Vec<_>>())]
    mode: Option<String>,

    /// Samples per pixel
    #[arg(long, value_name = "N")]
    spp: Option<u32>,

    /// Stop after so many seconds of rendering
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,

    /// Stop when the estimated noise (root of the relative mean square error) is down to E, e.g. 0.03
    #[arg(long, value_name = "E")]
    noise: Option<f64>,

    /// Start of the random numbers
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Threads to use; one per core when left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// Render and write this part of the picture only
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_region)]
    region: Option<Region>,

    /// Change any key of the scene, e.g. render.shadows=off; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    assignments: Vec<String>,

    /// Write times, counts and the picture's hash to this file as JSON
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,

    /// Measure afterwards what each effect of the render cost and what leaving out saved, by so many pairs of small renders, 6 to 1000
    #[arg(long, value_name = "PAIRS", num_args = 0..=1, default_missing_value = "20",
          value_parser = super::plan::pairs_parser())]
    costs: Option<u16>,

    #[command(flatten)]
    checkpoint: CheckpointArguments,

    #[command(flatten)]
    trace: TraceArguments,
}

impl RenderArguments {
    /// Looks for what cannot be written, before work is spent on it.
    fn check_files(&self, output: &Path) -> Result<()> {
        io::check_image_path(output)?;
        if let Some(path) = &self.stats {
            io::check_writable(path).with_context(|| cannot_write_stats(path))?;
        }
        let others: Vec<&Path> = std::iter::once(output)
            .chain(self.stats.as_deref())
            .collect();
        self.checkpoint.check(&others)
    }

    /// Every change to the scene's keys that the flags ask for.
    fn assignments(&self) -> Vec<String> {
        let mut assignments = self.assignments.clone();
        if let Some((width, height)) = self.size {
            assignments.push(format!("render.width={width}"));
            assignments.push(format!("render.height={height}"));
        }
        assignments.extend(self.mode.iter().map(|mode| format!("render.mode={mode}")));
        assignments.extend(
            self.spp
                .iter()
                .map(|spp| format!("render.samples_per_pixel={spp}")),
        );
        assignments.extend(
            self.seconds
                .iter()
                .map(|seconds| format!("render.stop.seconds={seconds}")),
        );
        assignments.extend(
            self.noise
                .iter()
                .map(|noise| format!("render.stop.noise={noise}")),
        );
        assignments.extend(self.seed.iter().map(|seed| format!("render.seed={seed}")));
        assignments
    }
}

/// The stats file.
#[derive(Debug, Serialize)]
struct Stats {
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
    /// Where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    costs: Option<MeasuredCosts>,
}

impl Stats {
    /// What `stats` says of a render of `scene`; seconds to load and to build.
    fn new(
        stats: &RenderStats,
        scene: &PreparedScene,
        [load_seconds, build_seconds]: [f64; 2],
        hash: &str,
        plan: Vec<PlannedFeature>,
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
            peak_memory_bytes: peak_memory_bytes(),
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
            costs: None,
        }
    }
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
            percentile_999: error.percentile_999,
            unmeasured_pixels: error.unmeasured_pixels,
            method: "halves of each pixel's sequence, extrapolated by the measured decay; 95 % intervals",
        }
    }
}

pub(super) fn run(arguments: &RenderArguments, signals: &Signals) -> Result<ExitCode> {
    if let Some(output) = &arguments.output {
        arguments.check_files(output)?;
    }
    let interrupt = signals.cancel_instead();
    let started = Instant::now();
    let Some(mut loaded) = super::load_unless(&interrupt, arguments.scene.as_deref())? else {
        return Ok(interrupted_early(signals));
    };
    io::override_scene(&mut loaded, &arguments.assignments(), &interrupt)?;
    if interrupt.is_cancelled() {
        return Ok(interrupted_early(signals));
    }
    for warning in loaded.warnings.iter().chain(&loaded.scene.warnings()) {
        eprintln!("warning: {warning}");
    }
    let load_seconds = started.elapsed().as_secs_f64();
    if let Some(pixel) = arguments.trace.pixel {
        let Some(prepared) = prepare(&loaded.scene, &interrupt)? else {
            return Ok(exit_code(signals));
        };
        arguments.trace.print(&loaded.scene, &prepared, pixel)?;
        return Ok(ExitCode::SUCCESS);
    }
    let output = arguments.output.as_deref();
    let output = output.context("--output names no file for the picture")?;
    render_scene(&loaded.scene, output, arguments, load_seconds, signals)
}

/// Renders `scene` as it is to `output`; what the window does where there is no screen.
///
/// # Errors
/// What kept the picture from being rendered or written.
pub fn render_to_file(scene: &Scene, output: &Path, signals: &Signals) -> Result<ExitCode> {
    io::check_image_path(output)?;
    let arguments = RenderArguments {
        scene: None,
        output: None,
        size: None,
        mode: None,
        spp: None,
        seconds: None,
        noise: None,
        seed: None,
        threads: None,
        region: None,
        assignments: Vec::new(),
        stats: None,
        costs: None,
        checkpoint: CheckpointArguments::default(),
        trace: TraceArguments::default(),
    };
    render_scene(scene, output, &arguments, 0.0, signals)
}

/// Prepares `scene` with the progress shown; `None` when cancelled.
fn prepare(scene: &Scene, cancel: &CancelToken) -> Result<Option<PreparedScene>> {
    let progress = Progress::new();
    let how_far = || (progress.fraction(), "building the tree".to_owned());
    let prepare = || PreparedScene::prepare_watched(scene, None, cancel, &progress);
    Ok(with_progress_bar(how_far, prepare)?)
}

/// Renders `scene`, writes the picture to `output` and the stats, and says what it took. A signal ends that early, with what is
/// there.
fn render_scene(
    scene: &Scene,
    output: &Path,
    arguments: &RenderArguments,
    load_seconds: f64,
    signals: &Signals,
) -> Result<ExitCode> {
    let interrupt = signals.cancel_instead();
    let started = Instant::now();
    let Some(prepared) = prepare(scene, &interrupt)? else {
        return Ok(interrupted_early(signals));
    };
    let build_seconds = started.elapsed().as_secs_f64();

    let settings = prepared.settings();
    if let Some(region) = arguments.region
        && !region.fits(settings.width, settings.height)
    {
        bail!(
            "--region {},{},{},{} does not lie in the {}×{} picture",
            region.x,
            region.y,
            region.width,
            region.height,
            settings.width,
            settings.height
        );
    }
    let run = RunConfig {
        threads: arguments.threads.map_or(0, usize::from),
        interrupt,
        layers: scene.output.layers && io::holds_layers(output),
        ..RunConfig::default()
    };
    let region = (arguments.region).unwrap_or(Region::full(settings.width, settings.height));
    let kept = &arguments.checkpoint;
    let kept = kept.of_render(scene, &prepared, region, &run);
    let bands = Bands::of(&prepared, Some(region), &run).filter(|_| kept.is_none());
    let outcome = if let Some(bands) = bands {
        bands.memory(&prepared, &run).require()?;
        render_bands(&prepared, &bands, &run)
    } else {
        let memory = PictureMemory {
            has_checkpoint: kept.is_some(),
            ..PictureMemory::of_render(&prepared, Some(region), &run)
        };
        memory.require()?;
        let start = match &kept {
            Some(file) => file.load(&prepared, region, &run, memory)?,
            None => None,
        };
        render_with_progress(&prepared, region, &run, kept.as_ref(), start)
    };
    let outcome = outcome.ok_or_else(|| anyhow!("rendering was cancelled"))?;
    let is_interrupted = outcome.stats.ending == Ending::Interrupted;
    let [fewest, most] = outcome.stats.sample_range;
    if fewest == 0 && (kept.is_some() || most == 0) {
        let code = interrupted_early(signals);
        kept.iter().for_each(CheckpointFile::say_how_to_go_on);
        return Ok(code);
    }
    // Black where nothing is known would be taken for the scene's own black, and must not replace a picture that is whole.
    let unfinished = (fewest == 0).then(|| unfinished_name(output));
    let output = unfinished.as_deref().unwrap_or(output);
    let (place, failure) = write_picture(&outcome, scene, output)?;
    if !is_interrupted && failure.is_none() {
        kept.iter().for_each(CheckpointFile::remove);
    }

    let RenderOutcome { image, stats, .. } = &outcome;
    let hash = image.hash();
    let plan = super::plan::facts(scene)?;
    let mut facts = Stats::new(stats, &prepared, [load_seconds, build_seconds], &hash, plan);
    let stats_path = arguments.stats.as_deref();
    let mut recorded = stats_path.map_or(Ok(()), |path| write_stats(&facts, path));
    say_what_it_took(&place, image, &hash, stats, settings)?;
    if is_interrupted {
        kept.iter().for_each(CheckpointFile::say_how_to_go_on);
    } else if let Some(pairs) = arguments.costs {
        facts.costs = measure_costs(scene, &prepared, pairs, &run)?;
        if recorded.is_ok() && facts.costs.is_some() {
            recorded = stats_path.map_or(Ok(()), |path| write_stats(&facts, path));
        }
    }
    failure.map_or(Ok(()), Err)?;
    recorded?;
    Ok(exit_code(signals))
}

/// What the effects of the render cost, which is said; `None` when interrupted.
fn measure_costs(
    scene: &Scene,
    prepared: &PreparedScene,
    pairs: u16,
    run: &RunConfig,
) -> Result<Option<MeasuredCosts>> {
    let trial = Trial::new(scene, Some(prepared), &run.interrupt)?;
    let costs = match &trial {
        Some(trial) => MeasuredCosts::of(trial, pairs)?,
        None => None,
    };
    let Some(mut costs) = costs else {
        eprintln!("interrupted while costs were measured: they are not known");
        return Ok(None);
    };
    if run.layers {
        costs.forget_layers();
    }
    super::say(costs.describe().trim_end())?;
    Ok(Some(costs))
}

/// What is said and returned where there is no picture yet.
fn interrupted_early(signals: &Signals) -> ExitCode {
    eprintln!("interrupted before every pixel had a sample: no picture is written");
    exit_code(signals)
}

/// The name of a picture that has pixels without a sample.
fn unfinished_name(output: &Path) -> PathBuf {
    let format = output.extension().unwrap_or_default().to_string_lossy();
    output.with_extension(format!("unfinished.{format}"))
}

/// That of the signal, if one came, however far the work was.
fn exit_code(signals: &Signals) -> ExitCode {
    signals
        .exit_code()
        .map_or(ExitCode::SUCCESS, ExitCode::from)
}

/// Writes the picture to `output`, or, where that fails after all, where it is not lost. Returns where it is, and what failed.
///
/// # Errors
/// When it cannot be written anywhere.
fn write_picture(
    outcome: &RenderOutcome,
    scene: &Scene,
    output: &Path,
) -> Result<(PathBuf, Option<anyhow::Error>)> {
    let RenderOutcome { image, layers, .. } = outcome;
    let origin = Origin {
        scene,
        error: outcome.stats.error.as_ref(),
    };
    let Err(error) = io::write_render(image, layers, &origin, output) else {
        return Ok((output.to_owned(), None));
    };
    match io::rescue_render(image, layers, &origin, output) {
        Ok(place) => {
            let failure = anyhow!("{error}; the picture is in {} instead", place.display());
            Ok((place, Some(failure)))
        }
        Err(second) => bail!("{error}; {second}; the picture is lost"),
    }
}

fn write_stats(stats: &Stats, path: &Path) -> Result<()> {
    let json =
        serde_json::to_string_pretty(stats).context("the stats cannot be written as JSON")?;
    io::write_atomically(path, |file| writeln!(file, "{json}"))
        .with_context(|| cannot_write_stats(path))
}

fn cannot_write_stats(path: &Path) -> String {
    format!("{}: cannot write the stats", path.display())
}

/// Prints what a render took and how wrong it is, and warns of what went wrong.
fn say_what_it_took(
    output: &Path,
    image: &Image,
    hash: &str,
    stats: &RenderStats,
    settings: &RenderSettings,
) -> Result<()> {
    let rate = stats.rays.total() as f64 / stats.render_seconds.max(1e-9) / 1e6;
    super::say(&format!(
        "{}: {}×{} pixels, {}, {:.2} s, {rate:.2} Mrays/s, hash {}",
        output.display(),
        image.width,
        image.height,
        describe_samples(stats),
        stats.render_seconds,
        &hash[..16]
    ))?;
    if let Some(error) = &stats.error {
        super::say(&describe_error(error))?;
    }
    if stats.ending == Ending::Interrupted {
        let gaps = if stats.sample_range[0] == 0 {
            ", and is black where there are none"
        } else {
            ""
        };
        eprintln!("warning: interrupted: the picture has the samples taken so far{gaps}");
    }
    if stats.ending != Ending::Noise
        && let Some(noise) = settings.stop.noise
    {
        let reason = match stats.ending {
            Ending::Time => "the time was up",
            Ending::Interrupted => "the render was interrupted",
            _ => "pixels have all the samples that render.samples_per_pixel allows",
        };
        eprintln!("warning: noise is not down to {}: {reason}", percent(noise));
    }
    if stats.non_finite_samples > 0 {
        eprintln!(
            "warning: {} samples were infinite or not a number",
            stats.non_finite_samples
        );
    }
    if stats.negative_samples > 0 {
        eprintln!(
            "warning: {} samples had less than no light",
            stats.negative_samples
        );
    }
    if let Some(share) = stats.notable_depth_limited_share() {
        eprintln!(
            "warning: {:.0} % of the samples may lack light: render.max_bounces = {} ended their paths",
            share * 100.0,
            settings.max_bounces
        );
    }
    if settings.clamp.is_some() {
        eprintln!(
            "render.clamp limited {} samples and took {:.3} % of the picture's light away",
            stats.clamped.samples,
            stats.clamped.energy_share * 100.0
        );
    }
    Ok(())
}

/// Samples per pixel in words.
fn describe_samples(stats: &RenderStats) -> String {
    match stats.sample_range {
        [1, 1] => "1 sample".to_owned(),
        [least, most] if least == most => format!("{most} samples"),
        [least, most] => format!(
            "{:.1} samples on average ({least} to {most})",
            stats.samples_per_pixel
        ),
    }
}

/// The error in one line.
fn describe_error(error: &ErrorEstimate) -> String {
    let noise = error.noise();
    format!(
        "estimated noise {} ({} to {}), rmse {:.3e}, 99.9 % of pixels within {:.3e}",
        percent(noise.value),
        percent(noise.low),
        percent(noise.high),
        error.rmse.value,
        error.percentile_999
    )
}

/// A share with three digits.
fn percent(share: f64) -> String {
    let percent = share * 100.0;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 9"
    )]
    let decimals = if percent > 0.0 {
        (2.0 - percent.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        0
    };
    format!("{percent:.decimals$} %")
}

/// Renders, from `start` on if there is one, with the progress and the rate of rays shown, and checkpoints `kept`.
fn render_with_progress(
    prepared: &PreparedScene,
    region: Region,
    run: &RunConfig,
    kept: Option<&CheckpointFile<'_>>,
    start: Option<Checkpoint>,
) -> Option<RenderOutcome> {
    let progress = RenderProgress::default();
    let started = Instant::now();
    let how_far = || {
        let rate = progress.rays() as f64 / started.elapsed().as_secs_f64() / 1e6;
        let noise = progress.latest_error().map_or_else(String::new, |point| {
            format!(", noise {}", percent(point.error.noise().value))
        });
        (
            progress.samples.fraction(),
            format!("{rate:.1} Mrays/s{noise}"),
        )
    };
    let keep = |checkpoint| {
        if let Some(file) = kept {
            file.keep(&checkpoint);
        }
    };
    let watch = Watch {
        checkpoints: kept.map(|file| CheckpointKeeper {
            every: file.every,
            keep: &keep,
        }),
        ..Watch::default()
    };
    with_progress_bar(how_far, || match start {
        Some(start) => resume(prepared, start, run, &progress, watch),
        None => render_watched(prepared, Some(region), run, &progress, watch),
    })
}

/// [`render_watched`] of a picture too large to be held in one piece.
fn render_bands(prepared: &PreparedScene, bands: &Bands, run: &RunConfig) -> Option<RenderOutcome> {
    let current = Mutex::new((0, RenderProgress::default()));
    let lock = || current.lock().unwrap_or_else(PoisonError::into_inner);
    let how_far = || {
        let (number, progress) = &*lock();
        let done = f64::from(number.max(&1) - 1) + progress.samples.fraction();
        let count = bands.count();
        (done / count as f64, format!("part {number} of {count}"))
    };
    let begin = || {
        let mut current = lock();
        current.0 += 1;
        current.1 = RenderProgress::default();
        current.1.clone()
    };
    with_progress_bar(how_far, || bands.render(prepared, run, begin))
}

/// Runs `work` with its progress shown on a terminal, and nothing shown where there is none. `how_far` tells the done part of
/// the whole, and what to say about it.
pub(super) fn with_progress_bar<T>(
    how_far: impl Fn() -> (f64, String) + Sync,
    work: impl FnOnce() -> T,
) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(
        "{percent:>3} % {wide_bar} {elapsed_precise} left {eta} {msg}",
    );
    bar.set_style(style.expect("the template is right"));
    let finished = CancelToken::new();
    std::thread::scope(|scope| {
        // Also where the work panics: the scope waits for its thread.
        let ending = CancelWhenDropped(&finished);
        scope.spawn(|| {
            while !finished.is_cancelled() {
                let (fraction, message) = how_far();
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of 1000"
                )]
                bar.set_position((fraction * 1000.0) as u64);
                bar.set_message(message);
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        let result = work();
        drop(ending);
        bar.finish_and_clear();
        result
    })
}

/// Cancels a token when it goes.
struct CancelWhenDropped<'a>(&'a CancelToken);

impl Drop for CancelWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// The most memory this process has held, where the system tells (Linux).
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text
        .split_once(['x', 'X', '×'])
        .and_then(|(width, height)| {
            let side = |text: &str| text.trim().parse().ok().filter(|&side: &u32| side > 0);
            Some((side(width)?, side(height)?))
        });
    sides.ok_or_else(|| "expected width and height, such as 640x480".to_owned())
}

fn parse_region(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text
        .split(',')
        .map(|number| number.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Region {
            x,
            y,
            width,
            height,
        }),
        _ => Err("expected left, top, width, height in pixels, such as 0,0,320,240".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_regions_are_understood_or_refused() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert_eq!(parse_size("1X2"), Ok((1, 2)));
        for wrong in ["640", "0x3", "-1x3", "ax3", "3x", ""] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(
            parse_region("1, 2,3,4"),
            Ok(Region {
                x: 1,
                y: 2,
                width: 3,
                height: 4
            })
        );
        for wrong in ["1,2,3", "1,2,0,4", "1,2,3,4,5", "a,2,3,4"] {
            assert!(parse_region(wrong).is_err(), "{wrong}");
        }
    }
}
