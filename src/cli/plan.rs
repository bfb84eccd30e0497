//! `raymini plan`: what a render does, what it leaves out and why, and what each costs.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::Args;
use serde::Serialize;

use super::contributions::MeasuredContributions;
use super::costs::MeasuredCosts;
use super::scene_arguments::{SceneArguments, assigned};
use super::values;
use crate::analysis::contributions::LONGER_SIDE;
use crate::analysis::cost::Trial;
use crate::analysis::pilot::{TimeEstimate, estimate_time};
use crate::control::CancelToken;
use crate::render::{
    Bands, Decision, Feature, Interval, PictureMemory, PreparedScene, RunConfig, Used, Work,
    even_passes, reasons,
};
use crate::scene::{Choice, Mode, RenderSettings, Scene, Stop};

/// Pairs of renders for an estimate of what effects cost.
const ROUGH_PAIRS: u16 = 3;
/// Along each side of the picture so many pixels are looked at.
const LOOKS: u32 = 24;

/// What `raymini plan` takes.
#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    /// What a pixel holds
    #[arg(long, value_parser = Mode::ALL.iter().map(|(_, name)| *name).collect::<Vec<_>>())]
    mode: Option<String>,

    /// Samples per pixel
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::samples)]
    spp: Option<u32>,

    /// Measure what each effect costs and what leaving out saves by so many pairs of small renders, 6 to 1000, with intervals, in
    /// place of a rough estimate
    #[arg(long, value_name = "PAIRS", num_args = 0..=1, require_equals = true, default_missing_value = "20",
          value_parser = super::costs::pairs)]
    measure: Option<u16>,

    /// Write what each effect and each light brings into this folder: the picture with it minus the picture without, small and of the
    /// same samples, in colours and as it is, with its figures as JSON
    #[arg(long, value_name = "DIR", allow_hyphen_values = true, value_parser = values::output())]
    contributions: Option<PathBuf>,

    /// Pixels of these pictures along their longer side
    #[arg(long, value_name = "PIXELS", default_value_t = LONGER_SIDE, requires = "contributions",
          allow_hyphen_values = true, value_parser = values::whole(1..=RenderSettings::MAX_SIDE))]
    contribution_side: u32,

    /// Show of all that is left out that it is, in the built-in demo, changed to what each case takes: counted, and done for nothing by
    /// so many pairs of small renders, 6 to 1000; as a table in Markdown, in some minutes
    #[arg(long, value_name = "PAIRS", num_args = 0..=1, require_equals = true, default_missing_value = "20",
          value_parser = super::costs::pairs,
          conflicts_with_all = ["scene", "size", "mode", "spp", "assignments", "measure", "contributions"])]
    proofs: Option<u16>,

    /// Print the facts as JSON
    #[arg(long)]
    json: bool,
}

/// Whether a render does something.
#[derive(Debug, Serialize)]
pub(super) struct PlannedFeature {
    feature: &'static str,
    needed: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// The plan of a render, for programs.
pub(super) fn facts(scene: &Scene) -> Result<Vec<PlannedFeature>> {
    let planned = |(feature, reason): (Feature, Option<&'static str>)| PlannedFeature {
        feature: feature.name(),
        needed: reason.is_none(),
        reason,
    };
    Ok(reasons(scene)?.map(planned).into())
}

#[derive(Debug, Serialize)]
struct Facts {
    mode: &'static str,
    width: u32,
    height: u32,
    samples_per_pixel: u32,
    /// How the random numbers of these are spread, where they need any.
    sampler: &'static str,
    features: Vec<PlannedFeature>,
    used: Used,
    per_sample: PerSample,
    bytes: Bytes,
    /// In so many parts the picture is rendered, one after the other: 1 where memory holds it at once.
    bands: usize,
    /// On one thread, for all samples.
    estimated_cpu_seconds: f64,
    /// The same until noise or the clock ends the render; null where neither does.
    estimated_cpu_seconds_to_stop: Option<f64>,
    /// Whether the error or the clock may end it before.
    may_stop_sooner: bool,
    /// What the render takes on `threads` threads, stops included.
    estimated_seconds: Interval,
    /// Whether that is only what it takes at most.
    is_bound: bool,
    threads: usize,
    costs: MeasuredCosts,
    /// What effects and lights bring, where that is wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    contributions: Option<MeasuredContributions>,
}

/// Means over samples spread over the picture.
#[derive(Debug, Serialize)]
struct PerSample {
    camera_rays: f64,
    shadow_rays: f64,
    ambient_occlusion_rays: f64,
    bounce_rays: f64,
    /// How often random numbers are drawn, by what they decide; none where they are not.
    draws: Vec<(&'static str, f64)>,
}

#[derive(Debug, Serialize)]
struct Bytes {
    triangles_and_structure: usize,
    normals: usize,
    textures: usize,
    picture: u64,
}

pub(super) fn run(arguments: &PlanArguments) -> Result<()> {
    if let Some(pairs) = arguments.proofs {
        return super::proofs::run(pairs, arguments.json);
    }
    let cancel = CancelToken::new();
    let changes = [
        assigned("--mode", "mode", arguments.mode.as_ref()),
        assigned("--spp", "samples_per_pixel", arguments.spp),
    ];
    let loaded = arguments.scene.load(changes, &cancel)?;
    let loaded = loaded.ok_or_else(|| anyhow!("loading was cancelled"))?;
    super::warn_of_scene(&loaded)?;
    let scene = &loaded.scene;
    let prepared = PreparedScene::prepare(scene, None, &cancel)?
        .ok_or_else(|| anyhow!("preparing was cancelled"))?;
    let trial = Trial::new(scene, Some(&prepared), &cancel)?;
    let trial = trial.ok_or_else(|| anyhow!("measuring was cancelled"))?;
    let pairs = arguments.measure.unwrap_or(ROUGH_PAIRS);
    let costs = MeasuredCosts::of(&trial, pairs)?;
    let seconds = trial.estimated_seconds(scene)?;
    let contributions = match &arguments.contributions {
        None => None,
        Some(folder) => {
            let side = arguments.contribution_side;
            let known = (scene, arguments.scene.path());
            let written = MeasuredContributions::write(known, &prepared, side, folder)?;
            Some(written.ok_or_else(|| anyhow!("rendering was cancelled"))?)
        }
    };
    let run = RunConfig::default();
    let time = estimate_time(scene, &prepared, None, &run)?;
    let time = time.ok_or_else(|| anyhow!("measuring was cancelled"))?;
    let seconds = seconds.ok_or_else(|| anyhow!("measuring was cancelled"))?;
    let stop = &scene.render.stop;
    let is_foreseen = stop.noise.is_some() || stop.seconds.is_some();
    let bands = Bands::of(&prepared, None, &run);
    let picture = bands.as_ref().map_or_else(
        || PictureMemory::of_render(&prepared, None, &run),
        |bands| bands.memory(&prepared, &run),
    );
    let facts = Facts {
        mode: scene.render.mode.name(),
        width: scene.render.width,
        height: scene.render.height,
        samples_per_pixel: scene.render.samples_per_pixel,
        sampler: scene.render.sampler.name(),
        features: facts(scene)?,
        used: Used::of(scene),
        per_sample: PerSample::of(&prepared),
        bytes: Bytes {
            triangles_and_structure: prepared.geometry().accelerator().bytes(),
            normals: prepared.geometry().normal_bytes(),
            textures: prepared.texture_bytes(),
            picture: picture.bytes(),
        },
        bands: bands.as_ref().map_or(1, Bands::count),
        estimated_cpu_seconds: seconds,
        estimated_cpu_seconds_to_stop: is_foreseen
            .then(|| cpu_seconds_to_stop(scene, seconds, &time, run.thread_count())),
        may_stop_sooner: *stop != Stop::default(),
        estimated_seconds: time.seconds,
        is_bound: time.is_bound,
        threads: run.thread_count(),
        costs: costs.ok_or_else(|| anyhow!("measuring was cancelled"))?,
        contributions,
    };
    if arguments.json {
        return super::say_json(&facts);
    }
    super::say(describe(&facts).trim_end())?;
    let written = facts
        .contributions
        .as_ref()
        .zip(arguments.contributions.as_ref());
    written.map_or(Ok(()), |(contributions, folder)| {
        super::say(&contributions.describe(folder))
    })
}

/// The processor time of a render that is to end as `time` says, where all its samples take `all_samples` seconds.
fn cpu_seconds_to_stop(
    scene: &Scene,
    all_samples: f64,
    time: &TimeEstimate,
    threads: usize,
) -> f64 {
    let most = f64::from(scene.render.samples_per_pixel);
    let of_samples = all_samples * (time.samples / most).min(1.0);
    // However many samples they take, threads have no more than the time of the render.
    let of_clock = scene
        .render
        .stop
        .seconds
        .map(|limit| limit * threads as f64);
    of_samples.min(of_clock.unwrap_or(f64::INFINITY))
}

impl PerSample {
    fn of(scene: &PreparedScene) -> Self {
        let settings = scene.settings();
        let (columns, rows) = (settings.width.min(LOOKS), settings.height.min(LOOKS));
        let middle = |number: u32, count: u32, size: u32| {
            let (number, count, size) = (u64::from(number), u64::from(count), u64::from(size));
            u32::try_from((2 * number + 1) * size / (2 * count)).expect("lies in the picture")
        };
        let pixels = (0..rows).flat_map(|row| {
            let y = middle(row, rows, settings.height);
            (0..columns).map(move |column| (middle(column, columns, settings.width), y))
        });
        let work = Work::of(scene, pixels, settings.samples_per_pixel.min(2));
        let per_sample = |count: u64| count as f64 / work.samples as f64;
        let draws =
            Decision::ALL.map(|decision| (decision.name(), per_sample(work.draws(decision))));
        let passes = even_passes(settings.samples_per_pixel);
        Self {
            camera_rays: if scene.plan().needs(Feature::EyeRays) {
                per_sample(work.rays.camera)
            } else {
                f64::from(passes) / f64::from(settings.samples_per_pixel)
            },
            shadow_rays: per_sample(work.rays.shadow),
            ambient_occlusion_rays: per_sample(work.rays.ambient_occlusion),
            bounce_rays: per_sample(work.rays.bounce),
            draws: draws
                .into_iter()
                .filter(|(_, draws)| *draws > 0.0)
                .collect(),
        }
    }
}

/// The same for people.
fn describe(facts: &Facts) -> String {
    let samples = match facts.samples_per_pixel {
        1 => "1 sample".to_owned(),
        samples => format!("{samples} samples"),
    };
    let mut text = format!(
        "mode {}, {}×{} pixels, {samples} per pixel\n\n",
        facts.mode, facts.width, facts.height
    );
    for planned in &facts.features {
        let state = planned.reason.map_or_else(
            || format!("needed     {}", planned.feature),
            |reason| format!("left out   {:27} {reason}", planned.feature),
        );
        let _ = writeln!(text, "{state}");
    }
    let _ = writeln!(text, "\n{}", facts.used.facts().join("; "));
    let rays = &facts.per_sample;
    let _ = writeln!(
        text,
        "rays of a sample: camera {:.3}, shadow {:.3}, ambient occlusion {:.3}, bounce {:.3}",
        rays.camera_rays, rays.shadow_rays, rays.ambient_occlusion_rays, rays.bounce_rays
    );
    let draws: Vec<String> = rays
        .draws
        .iter()
        .map(|(name, draws)| format!("{name} {draws:.3}"))
        .collect();
    let draws = if draws.is_empty() {
        "none".to_owned()
    } else {
        format!("{}; {}", facts.sampler, draws.join(", "))
    };
    let _ = writeln!(text, "random numbers of a sample: {draws}");
    let bands = match facts.bands {
        1 => String::new(),
        count => format!(" in {count} bands"),
    };
    let _ = writeln!(
        text,
        "bytes: triangles and structure {}, normals {}, textures {}, picture {}{bands}",
        facts.bytes.triangles_and_structure,
        facts.bytes.normals,
        facts.bytes.textures,
        facts.bytes.picture
    );
    let about = if facts.is_bound { "at most" } else { "about" };
    let cpu_seconds = match facts.estimated_cpu_seconds_to_stop {
        Some(seconds) => format!(
            "{about} {seconds:.2} s, as render.stop ends it; {:.2} s for all samples",
            facts.estimated_cpu_seconds
        ),
        None if facts.may_stop_sooner => format!(
            "about {:.2} s, unless render.stop ends it sooner",
            facts.estimated_cpu_seconds
        ),
        None => format!("about {:.2} s", facts.estimated_cpu_seconds),
    };
    let _ = writeln!(text, "processor time: {cpu_seconds}");
    let Interval { value, low, high } = facts.estimated_seconds;
    let threads = match facts.threads {
        1 => "1 thread".to_owned(),
        threads => format!("{threads} threads"),
    };
    let _ = writeln!(
        text,
        "render time: {about} {value:.2} s ({low:.2} to {high:.2}), on {threads}"
    );
    let _ = write!(text, "\n{}", facts.costs.describe());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: of 100 s for 1000 samples, 25 samples take 2.5 s, and 2 threads have no more than 1 s in half a second.
    #[test]
    fn the_processor_time_is_that_of_the_samples_foreseen() {
        let mut scene = Scene::default();
        scene.render.samples_per_pixel = 1000;
        scene.render.stop.noise = Some(0.03);
        let seconds = Interval {
            value: 1.25,
            low: 1.0,
            high: 1.5,
        };
        let time = |samples| TimeEstimate {
            seconds,
            is_bound: false,
            samples,
        };
        let foreseen = cpu_seconds_to_stop(&scene, 100.0, &time(25.0), 2);
        assert!((foreseen - 2.5).abs() < 1e-9);
        assert_eq!(cpu_seconds_to_stop(&scene, 100.0, &time(1000.0), 2), 100.0);
        scene.render.stop.seconds = Some(0.5);
        assert_eq!(cpu_seconds_to_stop(&scene, 100.0, &time(25.0), 2), 1.0);
    }
}
