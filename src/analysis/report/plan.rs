//! From what somebody wants to know to the renders that tell.

use std::path::Path;
use std::time::SystemTime;

use super::date;
use super::error::{ComparisonError, ReportError};
use super::files::{Refuge, make_folder};
use super::options::{ReferenceOptions, ReportOptions};
use super::progress::ReportProgress;
use super::reference::Reference;
use super::reference_file::read_reference;
use super::study::{Machine, Study, Variant};
use crate::control::CancelToken;
use crate::io::{self, LoadedScene, scene_file};
use crate::render::{PictureMemory, RunConfig};
use crate::scene::{LightSampling, Mode, RenderSettings, Scene, SceneError};

/// What is to be rendered, all of it known to make sense.
#[derive(Clone, Debug)]
pub struct ReportPlan {
    /// What looks wrong and is no reason to stop, in sentences.
    pub warnings: Vec<String>,
    /// What makes the report again, as a shell takes it, for the page to tell; `None` where no command does.
    pub command: Option<String>,
    scene_name: String,
    variants: Vec<Variant>,
    seeds: u32,
    reference: Wanted,
}

/// The reference that was asked for.
#[derive(Clone, Debug)]
enum Wanted {
    Given(Reference),
    Rendered(Rendering),
}

/// How a reference is made.
#[derive(Clone, Copy, Debug)]
struct Rendering {
    seed: u64,
    samples: u32,
    /// Samples of a pixel of what is measured against it, where `light_sampling` is a matter of choice. A render of so many
    /// then shows whether the reference is good enough.
    trial: Option<u32>,
}

impl ReportPlan {
    /// The plan for the scene that is called `scene_name`. Reads the files that `options` name.
    ///
    /// # Errors
    /// What about `options` cannot be understood, loaded or measured.
    pub fn new(
        scene_name: String,
        mut loaded: LoadedScene,
        options: &ReportOptions,
        cancel: &CancelToken,
    ) -> Result<Self, ReportError> {
        let samples = options
            .samples
            .unwrap_or_else(|| ReportOptions::default_samples(&loaded.scene.render));
        let mut assignments = vec![
            format!("render.samples_per_pixel={samples}"),
            "render.error_estimate=true".to_owned(),
        ];
        if let Some((width, height)) = options.size {
            assignments.push(format!("render.width={width}"));
            assignments.push(format!("render.height={height}"));
        }
        // Last, so that they have the last word.
        assignments.extend_from_slice(&options.assignments);
        io::override_scene(&mut loaded, &assignments, cancel)?;

        let mut warnings = all_warnings(&loaded);
        let of_scene = warnings.clone();
        let mut variants = vec![variant("as the scene says", &loaded.scene)];
        for (index, text) in options.comparisons.iter().enumerate() {
            let (name, changed) =
                compared(&loaded, text, cancel).map_err(|reason| ReportError::Comparison {
                    index,
                    text: text.clone(),
                    reason,
                })?;
            if let Some(same) = variants[1..].iter().find(|v| v.scene == changed.scene) {
                warnings.push(format!(
                    "{text}: it is the same as {}, and is measured once",
                    same.name
                ));
                continue;
            }
            let note = note_on(&loaded.scene, &changed.scene);
            let own = all_warnings(&changed).into_iter();
            let own = own.filter(|warning| !of_scene.contains(warning));
            let own = own.chain(note.map(|note| note.in_words().to_owned()));
            warnings.extend(own.map(|warning| format!("{text}: {warning}")));
            variants.push(Variant {
                shows_another_picture: note == Some(Note::AnotherPicture),
                ..variant(&name, &changed.scene)
            });
        }

        let RenderSettings { width, height, .. } = loaded.scene.render;
        let reference = match &options.reference {
            ReferenceOptions::File(path) => {
                let seeds = variants.iter().flat_map(|v| seeds_of(v, options.seeds));
                let seeds: Vec<u64> = seeds.collect();
                let (reference, in_file) = read_reference(path, (width, height), &seeds)?;
                let name = path.display();
                warnings.extend(in_file.iter().map(|warning| format!("{name}: {warning}")));
                Wanted::Given(reference)
            }
            ReferenceOptions::Exact(radiance) => {
                Wanted::Given(Reference::exact(*radiance, width, height))
            }
            ReferenceOptions::Rendered { samples } => {
                let most = variants.iter().map(|v| v.scene.render.samples_per_pixel);
                let most = most.fold(1, u32::max);
                let is_path = variants[0].scene.render.mode == Mode::Path;
                Wanted::Rendered(Rendering {
                    seed: free_seed(&variants, options.seeds),
                    samples: samples
                        .unwrap_or_else(|| ReportOptions::default_reference_samples(most)),
                    trial: is_path.then_some(most),
                })
            }
        };
        Ok(Self {
            warnings,
            command: None,
            scene_name,
            variants,
            seeds: options.seeds,
            reference,
        })
    }

    /// Samples per pixel of all renders together, as far as that is known.
    fn work(&self) -> f64 {
        let trials = self.variants.iter().map(samples).sum::<f64>() * f64::from(self.seeds);
        match self.reference {
            Wanted::Given(_) => trials,
            Wanted::Rendered(Rendering { samples, trial, .. }) => {
                trials + f64::from(samples) + f64::from(trial.unwrap_or(0))
            }
        }
    }

    /// What is kept of the pictures at the same time.
    fn memory(&self) -> PictureMemory {
        PictureMemory {
            pixels: self.variants[0].scene.render.pixel_count(),
            layers: 0,
            has_error: true,
            // The reference, and what is measured against it.
            copies: 2,
            has_checkpoint: false,
            kept_bytes: 0,
        }
    }

    /// Renders all. After each render what is known is written to `folder`, which is made where it is missing, and handed to
    /// `on_render`, whether it could be written or not. `None` when cancelled.
    ///
    /// # Errors
    /// What cannot be rendered or written; at the end also that it could not be written to `folder` and is elsewhere.
    pub fn carry_out(
        self,
        run: &RunConfig,
        folder: &Path,
        progress: &ReportProgress,
        mut on_render: impl FnMut(&Study),
    ) -> Result<Option<Study>, ReportError> {
        make_folder(folder)?;
        self.memory().require()?;
        progress.set_total(self.work());
        let reference = match self.reference {
            Wanted::Given(reference) => reference,
            Wanted::Rendered(rendering) => {
                let scene = &self.variants[0].scene;
                let Some(reference) = rendering.carry_out(scene, run, progress)? else {
                    return Ok(None);
                };
                reference
            }
        };
        let mut study = Study {
            scene_name: self.scene_name,
            date: date::in_words(SystemTime::now()),
            command: self.command,
            warnings: self.warnings,
            triangles: self.variants[0].scene.triangle_count(),
            picture: None,
            machine: Machine::this(run.thread_count()),
            reference,
            seeds: self.seeds,
            default_settings: settings(&RenderSettings::default()),
            variants: self.variants,
        };
        let mut files = Refuge::of(folder);
        while let Some(index) = study.next() {
            let variant = &study.variants[index];
            let number = variant.trials.len() + 1;
            let what = format!("{}, seed {number} of {}", variant.name, study.seeds);
            let progress = progress.begin(what, samples(variant));
            if study.render_next(run, &progress)?.is_none() {
                files.end()?;
                return Ok(None);
            }
            let written = files.write(&study);
            on_render(&study);
            written?;
        }
        files.end()?;
        Ok(Some(study))
    }
}

impl Rendering {
    /// Renders with a seed of its own and by another way of finding light, so that what is wrong with one is not wrong with the
    /// other. Where that way finds the light of `scene` so badly that it is no reference, the scene's own is tried as well and
    /// the better of both is taken. `None` when cancelled.
    fn carry_out(
        self,
        scene: &Scene,
        run: &RunConfig,
        progress: &ReportProgress,
    ) -> Result<Option<Reference>, SceneError> {
        let render = |what: &str, samples, by| {
            let progress = progress.begin(what.to_owned(), f64::from(samples));
            Reference::render(scene, self.seed, samples, by, run, &progress)
        };
        let own = scene.render.light_sampling;
        let Some(reference) = render("reference", self.samples, other_way(own))? else {
            return Ok(None);
        };
        let Some(samples) = self.trial else {
            return Ok(Some(reference));
        };
        let Some(trial) = render("trial of the reference", samples, own)? else {
            return Ok(None);
        };
        if !reference.is_too_wrong_for(&trial) {
            return Ok(Some(reference));
        }
        progress.add_to_total(f64::from(self.samples));
        let second = render("reference by the scene's own way", self.samples, own)?;
        Ok(second.map(|second| {
            if is_better(&second, &reference) {
                second
            } else {
                reference
            }
        }))
    }
}

/// A way of finding light that shares as little as possible with `way`.
fn other_way(way: LightSampling) -> LightSampling {
    match way {
        LightSampling::Mis => LightSampling::Nee,
        LightSampling::Nee | LightSampling::Bsdf => LightSampling::Mis,
    }
}

/// Whether the own error of `one` is known to be smaller than that of `other`.
fn is_better(one: &Reference, other: &Reference) -> bool {
    let error = |reference: &Reference| reference.relmse().map_or(f64::INFINITY, |own| own.value);
    error(one) < error(other)
}

/// The name and the scene of the variant that `comparison` makes.
fn compared(
    loaded: &LoadedScene,
    comparison: &str,
    cancel: &CancelToken,
) -> Result<(String, LoadedScene), ComparisonError> {
    let assignments: Vec<String> = comparison
        .split(';')
        .map(|assignment| assignment.trim().to_owned())
        .filter(|assignment| !assignment.is_empty())
        .collect();
    if assignments.is_empty() {
        return Err(ComparisonError::Empty);
    }
    let mut changed = loaded.clone();
    io::override_scene(&mut changed, &assignments, cancel).map_err(ComparisonError::Scene)?;
    let sizes = [loaded, &changed].map(|l| (l.scene.render.width, l.scene.render.height));
    if sizes[0] != sizes[1] {
        return Err(ComparisonError::Size);
    }
    Ok((assignments.join("; "), changed))
}

/// What is to be known of the curve of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Note {
    /// Nothing is changed at all.
    NoChange,
    /// What is changed decides nothing.
    SameRenders,
    /// The difference is in what is measured.
    AnotherPicture,
}

impl Note {
    fn in_words(self) -> &'static str {
        match self {
            Self::NoChange => "it changes nothing: its renders are those of the scene as it is",
            Self::SameRenders => {
                "render.adaptive decides nothing without a stop at a noise or a time: both curves are of the same renders"
            }
            Self::AnotherPicture => {
                "it shows another picture than the scene as it is: the difference counts as noise, which no sample cures"
            }
        }
    }
}

/// What is to be known of the curve of a scene that was changed from `base`.
fn note_on(base: &Scene, changed: &Scene) -> Option<Note> {
    if base == changed {
        return Some(Note::NoChange);
    }
    let stop = &changed.render.stop;
    let mut like_base = changed.clone();
    like_base.display = base.display;
    like_base.output = base.output;
    like_base.render.adaptive = base.render.adaptive;
    if like_base == *base && changed.render.adaptive != base.render.adaptive {
        let is_without_stop = stop.noise.is_none() && stop.seconds.is_none();
        return is_without_stop.then_some(Note::SameRenders);
    }
    // What only says how the same picture is found.
    like_base.render = RenderSettings {
        samples_per_pixel: base.render.samples_per_pixel,
        stop: base.render.stop,
        error_estimate: base.render.error_estimate,
        seed: base.render.seed,
        sampler: base.render.sampler,
        roulette: base.render.roulette,
        light_sampling: base.render.light_sampling,
        shadow_samples: base.render.shadow_samples,
        accelerator: base.render.accelerator,
        accelerator_build: base.render.accelerator_build,
        ..like_base.render
    };
    like_base.render.ambient_occlusion.samples = base.render.ambient_occlusion.samples;
    (like_base != *base).then_some(Note::AnotherPicture)
}

fn all_warnings(loaded: &LoadedScene) -> Vec<String> {
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
        shows_another_picture: false,
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

fn samples(variant: &Variant) -> f64 {
    f64::from(variant.scene.render.samples_per_pixel)
}

/// The seeds that a variant is rendered with, so many.
fn seeds_of(variant: &Variant, count: u32) -> impl Iterator<Item = u64> {
    (0..count).map(|number| variant.seed(number))
}

/// The first seed after those of the scene that no variant is rendered with.
fn free_seed(variants: &[Variant], seeds: u32) -> u64 {
    let is_used = |seed| {
        let mut used = variants.iter().flat_map(|v| seeds_of(v, seeds));
        used.any(|used| used == seed)
    };
    let mut after = (seeds..=u32::MAX).map(|number| variants[0].seed(number));
    let free = after.find(|&seed| !is_used(seed));
    free.expect("there are more seeds than renders")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SamplerChoice;

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
    fn variants_that_show_something_else_are_told_of() {
        let base = Scene::default();
        let note = |change: &dyn Fn(&mut RenderSettings)| {
            let mut changed = base.clone();
            change(&mut changed.render);
            note_on(&base, &changed)
        };
        assert_eq!(note(&|_| ()), Some(Note::NoChange));
        assert_eq!(note(&|r| r.light_sampling = LightSampling::Bsdf), None);
        assert_eq!(note(&|r| r.sampler = SamplerChoice::Independent), None);
        assert_eq!(note(&|r| r.ambient_occlusion.samples += 1), None);
        assert_eq!(note(&|r| r.stop.noise = Some(0.1)), None);
        let bounces = note(&|r| r.max_bounces += 1);
        assert_eq!(bounces, Some(Note::AnotherPicture));
        let mut wider = base.clone();
        wider.camera.vertical_fov.0 += 1.0;
        assert_eq!(note_on(&base, &wider), bounces);
        let adaptive = note(&|r| r.adaptive = !r.adaptive);
        assert_eq!(adaptive, Some(Note::SameRenders));
        let with_stop = note(&|r| {
            r.adaptive = !r.adaptive;
            r.stop.noise = Some(0.1);
        });
        assert_eq!(with_stop, None);
    }

    #[test]
    fn variants_that_are_the_same_are_measured_once() {
        let loaded = LoadedScene {
            scene: io::demo_scene(),
            warnings: Vec::new(),
        };
        let comparisons = [
            "render.shadow_samples=4",
            "render.max_bounces=3",
            ";render.shadow_samples=4",
        ];
        let options = ReportOptions {
            comparisons: comparisons.map(str::to_owned).into(),
            ..ReportOptions::default()
        };
        let cancel = CancelToken::new();
        let plan = ReportPlan::new("scene".to_owned(), loaded, &options, &cancel);
        let plan = plan.expect("is right");
        let others: Vec<bool> = plan.variants[1..]
            .iter()
            .map(|variant| variant.shows_another_picture)
            .collect();
        assert_eq!(others, [false, true]);
        let said = ";render.shadow_samples=4: it is the same as render.shadow_samples=4, and is measured once";
        assert!(
            plan.warnings.iter().any(|w| w == said),
            "{:?}",
            plan.warnings
        );
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
