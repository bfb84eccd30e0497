//! `raymini render`: renders a scene file or a mesh to a picture. A signal ends it early, with what is there.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;

use super::checkpoint::{CheckpointArguments, CheckpointFile};
use super::checkpoint_lock::Lock;
use super::costs::MeasuredCosts;
use super::inputs::{is_same_file, refuse_input};
use super::progress_bar::HowFar;
use super::scene_arguments::{SceneArguments, assigned};
use super::stats::{self, Stats};
use super::time_left::Left;
use super::trace::TraceArguments;
use super::{Signals, outcome, progress_bar, time_left, values};
use crate::analysis::cost::Trial;
use crate::analysis::pilot;
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadedScene, Origin, Values, WrittenError, WrittenOrigin};
use crate::math::percent;
use crate::render::{
    Bands, Checkpoint, CheckpointKeeper, Ending, PictureMemory, PreparedScene, Region,
    RenderOutcome, RenderProgress, RunConfig, Used, Watch, render_watched, resume,
};
use crate::scene::{Choice, Mode, RenderSettings, Scene};

/// What `raymini render` takes.
#[derive(Debug, Default, Args)]
pub struct RenderArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    /// Where to write the picture: .png, or .exr for the radiance itself
    #[arg(short, long, value_name = "FILE", required_unless_present = "pixel",
          allow_hyphen_values = true, value_parser = values::output())]
    output: Option<PathBuf>,

    /// What a pixel holds
    #[arg(long, value_parser = Mode::ALL.iter().map(|(_, name)| *name).collect::<Vec<_>>())]
    mode: Option<String>,

    /// Samples per pixel
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::samples)]
    spp: Option<u32>,

    /// Stop after so many seconds of rendering
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = values::positive)]
    seconds: Option<f64>,

    /// Stop when the estimated noise (root of the relative mean square error) is down to E, e.g. 0.03
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = values::positive)]
    noise: Option<f64>,

    /// Start of the random numbers
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::whole(0..=RenderSettings::MAX_SEED))]
    seed: Option<u64>,

    /// Threads to use; one per core when left out
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::threads)]
    threads: Option<u16>,

    /// Render and write this part of the picture only; where a part is rendered again, that part when left out
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = values::region)]
    region: Option<Region>,

    /// Write times, counts and the picture's hash to this file as JSON
    #[arg(long, value_name = "FILE", allow_hyphen_values = true, value_parser = values::output())]
    stats: Option<PathBuf>,

    /// Measure afterwards what each effect of the render cost and what leaving out saved, by so many pairs of small renders, 6 to 1000
    #[arg(long, value_name = "PAIRS", num_args = 0..=1, require_equals = true, default_missing_value = "20",
          value_parser = super::costs::pairs)]
    costs: Option<u16>,

    #[command(flatten)]
    checkpoint: CheckpointArguments,

    #[command(flatten)]
    trace: TraceArguments,
}

impl RenderArguments {
    /// Looks for what cannot be written, before work is spent on it. Keeps other renders from the checkpoint while what it returns lives.
    fn check_files(&self, output: &Path) -> Result<Option<Lock>> {
        io::check_image_path(output)?;
        if let Some(path) = &self.stats {
            stats::check_name(path)?;
            io::check_writable(path).with_context(|| stats::cannot_write(path))?;
            if is_same_file(path, output) {
                bail!(
                    "{}: it cannot hold both the picture and the figures of --stats",
                    path.display()
                );
            }
        }
        let others: Vec<&Path> = std::iter::once(output)
            .chain(self.stats.as_deref())
            .collect();
        self.checkpoint.take(&others)
    }

    /// Refuses to write over what `scene` was read from. A picture that holds its scene may be rendered anew in its place.
    fn check_inputs(&self, scene: &Scene) -> Result<()> {
        let own = self.scene.path();
        if let Some(output) = &self.output {
            let other = own.filter(|own| !io::is_render_file(own));
            refuse_input(scene, other, output, "the picture")?;
        }
        if let Some(stats) = &self.stats {
            refuse_input(scene, own, stats, "the figures of --stats")?;
        }
        Ok(())
    }

    /// What the user has said the most samples of a pixel by.
    fn samples_key(&self) -> &'static str {
        match self.spp {
            Some(_) => "--spp",
            None => "render.samples_per_pixel",
        }
    }

    /// The scene with every change that the flags ask for; `None` when cancelled.
    fn load(&self, cancel: &CancelToken) -> Result<Option<LoadedScene>> {
        let changes = [
            assigned("--mode", "mode", self.mode.as_ref()),
            assigned("--spp", "samples_per_pixel", self.spp),
            assigned("--seconds", "stop.seconds", self.seconds),
            assigned("--noise", "stop.noise", self.noise),
            assigned("--seed", "seed", self.seed),
        ];
        self.scene.load(changes, cancel)
    }
}

pub(super) fn run(arguments: &RenderArguments, signals: &Signals) -> Result<ExitCode> {
    let _lock = match &arguments.output {
        Some(output) => arguments.check_files(output)?,
        None => None,
    };
    let interrupt = signals.cancel_instead();
    let started = Instant::now();
    let Some(loaded) = arguments.load(&interrupt)? else {
        return Ok(interrupted_early(signals));
    };
    arguments.check_inputs(&loaded.scene)?;
    super::warn_of_scene(&loaded)?;
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
    let region = match arguments.region {
        Some(region) => Some(region),
        None => part_rendered_before(arguments.scene.path(), &loaded.scene)?,
    };
    let timed = (arguments, load_seconds);
    render_scene(&loaded.scene, region, output, timed, signals)
}

/// Which part of its picture the file of a render is, of which `scene` was read; `None` for all of it, and where `path` is no such file.
///
/// # Errors
/// When the picture has another size by now, in which nobody knows that part.
fn part_rendered_before(path: Option<&Path>, scene: &Scene) -> Result<Option<Region>> {
    let Some(path) = path.filter(|path| io::is_render_file(path)) else {
        return Ok(None);
    };
    let name = path.display();
    let origin = WrittenOrigin::of_file(path).map_err(|reason| anyhow!("{name}: {reason}"))?;
    let (Some(region), Some((width, height))) = (origin.region, origin.picture_size()) else {
        return Ok(None);
    };
    if (scene.render.width, scene.render.height) != (width, height) {
        bail!(
            "{name}: this is the part {} of a {width}×{height} picture; say by --region which part of another size is to be rendered",
            in_words(region)
        );
    }
    super::tell(&format!(
        "{name}: rendering the part {} again; --region 0,0,{width},{height} renders all",
        in_words(region)
    ));
    Ok(Some(region))
}

/// As `--region` takes it.
fn in_words(region: Region) -> String {
    let Region {
        x,
        y,
        width,
        height,
    } = region;
    format!("{x},{y},{width},{height}")
}

/// Renders `scene`, which was read from `path`, as it is to `output`; what the window does where there is no screen.
///
/// # Errors
/// What kept the picture from being rendered or written.
pub fn render_to_file(
    scene: &Scene,
    path: Option<&Path>,
    output: &Path,
    signals: &Signals,
) -> Result<ExitCode> {
    io::check_image_path(output)?;
    let region = part_rendered_before(path, scene)?;
    let timed = (&RenderArguments::default(), 0.0);
    render_scene(scene, region, output, timed, signals)
}

/// Prepares `scene` with the progress shown; `None` when cancelled.
fn prepare(scene: &Scene, cancel: &CancelToken) -> Result<Option<PreparedScene>> {
    let progress = Progress::new();
    let how_far = || progress.fraction();
    let prepare = || PreparedScene::prepare_watched(scene, None, cancel, &progress);
    Ok(progress_bar::show_stage(
        "building the tree",
        how_far,
        prepare,
    )?)
}

/// Renders `region` of `scene`, or all, writes the picture to `output` and the stats, and says what it took. A signal ends that early, with
/// what is there.
fn render_scene(
    scene: &Scene,
    region: Option<Region>,
    output: &Path,
    (arguments, load_seconds): (&RenderArguments, f64),
    signals: &Signals,
) -> Result<ExitCode> {
    let interrupt = signals.cancel_instead();
    let started = Instant::now();
    let Some(prepared) = prepare(scene, &interrupt)? else {
        return Ok(interrupted_early(signals));
    };
    let build_seconds = started.elapsed().as_secs_f64();

    let settings = prepared.settings();
    let region = region.unwrap_or(Region::full(settings.width, settings.height));
    if !region.fits(settings.width, settings.height) {
        bail!(
            "--region {} does not lie in the {}×{} picture",
            in_words(region),
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
    let kept = &arguments.checkpoint;
    let kept = kept.of_render(scene, &prepared, region, &run);
    let bands = Bands::of(&prepared, Some(region), &run).filter(|_| kept.is_none());
    let rendered = if let Some(bands) = bands {
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
        render_with_progress(scene, &prepared, region, &run, kept.as_ref(), start)
    };
    let rendered = rendered.ok_or_else(|| anyhow!("rendering was cancelled"))?;
    let is_interrupted = rendered.stats.ending == Ending::Interrupted;
    let [fewest, most] = rendered.stats.sample_range;
    let is_out_of_time = rendered.stats.ending == Ending::Time && fewest == 0;
    if is_out_of_time && most == 0 {
        bail!("the time was up before the first samples were taken: no picture is written");
    }
    if !is_out_of_time && fewest == 0 && (kept.is_some() || most == 0) {
        let code = interrupted_early(signals);
        kept.iter().for_each(CheckpointFile::say_how_to_go_on);
        return Ok(code);
    }
    // Black where nothing is known would be taken for the scene's own black, and must not replace a picture that is whole.
    let unfinished = (fewest == 0).then(|| unfinished_name(output));
    let output = unfinished.as_deref().unwrap_or(output);
    let (place, failure) = write_picture(&rendered, scene, region, output)?;
    if !is_interrupted && failure.is_none() {
        kept.iter().for_each(CheckpointFile::remove);
    }

    let RenderOutcome { image, stats, .. } = &rendered;
    let hash = image.hash();
    let plan = (super::plan::facts(scene)?, Used::of(scene));
    let known = (stats, rendered.errors.as_slice());
    let mut facts = Stats::new(known, &prepared, [load_seconds, build_seconds], &hash, plan);
    let stats_path = arguments.stats.as_deref();
    let mut recorded = stats_path.map_or(Ok(()), |path| facts.write(path));
    outcome::say(
        (&place, image, &hash),
        stats,
        settings,
        arguments.samples_key(),
    )?;
    let levels = rendered.errors.last().map(time_left::to_levels);
    if let Some(levels) = levels.filter(|levels| !levels.is_empty()) {
        super::say(&format!(
            "foreseen, with more samples: noise of {}",
            levels.join(", ")
        ))?;
    }
    if is_interrupted {
        kept.iter().for_each(CheckpointFile::say_how_to_go_on);
    } else if let Some(pairs) = arguments.costs {
        facts.costs = measure_costs(scene, &prepared, pairs, &run)?;
        if recorded.is_ok() && facts.costs.is_some() {
            recorded = stats_path.map_or(Ok(()), |path| facts.write(path));
        }
    }
    settle(failure, recorded, &facts)?;
    if is_out_of_time {
        return Ok(ExitCode::FAILURE);
    }
    Ok(exit_code(signals))
}

/// Prints the figures where they could not be `recorded`, so that they are not lost.
///
/// # Errors
/// What kept them or the picture from their files; where it is both, the figures' is told.
fn settle(failure: Option<anyhow::Error>, recorded: Result<()>, facts: &Stats) -> Result<()> {
    let Err(error) = recorded else {
        return failure.map_or(Ok(()), Err);
    };
    super::say_json(facts)?;
    let error = anyhow!("{error:#}; the figures are printed instead");
    let Some(failure) = failure else {
        return Err(error);
    };
    super::tell(&format!("error: {error:#}"));
    Err(failure)
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
        super::tell("interrupted while costs were measured: they are not known");
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
    super::tell("interrupted before every pixel had a sample: no picture is written");
    exit_code(signals)
}

/// The name of a picture that has pixels without a sample.
fn unfinished_name(output: &Path) -> PathBuf {
    let format = output.extension().unwrap_or_default().to_string_lossy();
    output.with_extension(format!("unfinished.{format}"))
}

/// The exit code of the signal, if one came, however far the work was.
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
    region: Region,
    output: &Path,
) -> Result<(PathBuf, Option<anyhow::Error>)> {
    let RenderOutcome { image, layers, .. } = outcome;
    let whole = Region::full(scene.render.width, scene.render.height);
    let origin = Origin {
        scene,
        error: outcome.stats.error.as_ref().map(WrittenError::from),
        region: (region != whole).then_some(region),
        values: Values::Rendered,
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

/// Renders, from `start` on if there is one, with the progress and the rate of rays shown, and checkpoints `kept`.
fn render_with_progress(
    scene: &Scene,
    prepared: &PreparedScene,
    region: Region,
    run: &RunConfig,
    kept: Option<&CheckpointFile<'_>>,
    start: Option<Checkpoint>,
) -> Option<RenderOutcome> {
    let progress = RenderProgress::default();
    let started = Instant::now();
    let seconds_before = start.as_ref().map_or(0.0, Checkpoint::seconds);
    let stop = &prepared.settings().stop;
    let how_far = || {
        let seconds = started.elapsed().as_secs_f64();
        let rate = progress.rays() as f64 / seconds / 1e6;
        let point = progress.latest_error();
        let noise = point.map(|point| {
            let noise = percent(point.error.noise().value);
            format!("noise {noise}")
        });
        let level = point.filter(|_| stop.noise.is_none());
        let level = level.and_then(|point| time_left::to_next_level(&point));
        let messages = noise.into_iter().chain([format!("{rate:.1} Mrays/s")]);
        HowFar {
            fraction: progress.share(),
            left: match time_left::left(point.as_ref(), stop, seconds_before + seconds) {
                Left::Foreseen(seconds) => Some(time_left::in_words(seconds)),
                Left::AtThisPace => None,
                Left::Unknown => Some("?".to_owned()),
            },
            messages: messages.chain(level).collect(),
        }
    };
    let keep = |checkpoint| {
        if let Some(file) = kept {
            file.keep(&checkpoint);
        }
    };
    let watch = Watch {
        checkpoints: kept.map(|file| CheckpointKeeper {
            every: file.every,
            most_share: f64::INFINITY,
            keep: &keep,
            in_background: None,
        }),
        ..Watch::default()
    };
    let render = || match start {
        Some(start) => resume(prepared, start, run, &progress, watch),
        None => render_watched(prepared, Some(region), run, &progress, watch),
    };
    if std::io::stderr().is_terminal() {
        let show = || pilot::foreseeing(scene, prepared, region, &progress, render);
        progress_bar::show(how_far, show)
    } else {
        render()
    }
}

/// [`render_watched`] of a picture too large to be held in one piece.
fn render_bands(prepared: &PreparedScene, bands: &Bands, run: &RunConfig) -> Option<RenderOutcome> {
    let current = Mutex::new((0, RenderProgress::default()));
    let lock = || current.lock().unwrap_or_else(PoisonError::into_inner);
    let how_far = || {
        let (number, progress) = &*lock();
        let done = f64::from(number.max(&1) - 1) + progress.share();
        let count = bands.count();
        (done / count as f64, format!("part {number} of {count}"))
    };
    let begin = || {
        let mut current = lock();
        current.0 += 1;
        current.1 = RenderProgress::default();
        current.1.clone()
    };
    progress_bar::show(how_far, || bands.render(prepared, run, begin))
}
