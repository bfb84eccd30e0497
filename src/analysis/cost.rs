//! What each effect of a render costs, and what leaving out saves: renders that differ by one thing, in pairs, by processor time.

use crate::control::CancelToken;
use crate::render::{
    Feature, Plan, PreparedScene, PrimaryHitStore, Region, RenderProgress, RunConfig, is_nothing,
    render,
};
use crate::scene::{
    Background, LightSampling, Material, Mode, Rgb, Scene, SceneError, Shadows, Stop,
};

/// What a render takes at least, in seconds of processor time, for its time to mean anything.
const LEAST_SECONDS: f64 = 0.05;
/// The most samples per pixel of a render that is timed.
const MOST_SAMPLES: u32 = 16;
/// So many tiles along each side tell what the whole picture takes.
const TILES: u32 = 4;
/// Side of these tiles, in pixels.
const TILE_SIDE: u32 = 32;
/// The first picture that is tried has one pixel for so many along each side.
const COARSEST: u32 = 16;

/// What keeping parts of the picture is called.
pub const LAYERS: &str = "layers";

/// An effect that a scene may have, and that can be switched off, which makes another picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Points within a pixel.
    Antialiasing,
    /// A lens with an aperture.
    DepthOfField,
    /// All light, in place of how surfaces face the camera.
    Light,
    /// Aiming at lights, emitters and an image of the sky, which are else met by chance, or not at all.
    AimedLight,
    /// Meeting emitters, lights and the background by chance beside aiming at them.
    MetLight,
    /// Shadows.
    Shadows,
    /// Soft shadows in place of hard ones.
    SoftShadows,
    /// The background's light on surfaces, in mode `direct`.
    AmbientLight,
    /// Ambient occlusion.
    AmbientOcclusion,
    /// Mirrors, which are grey without.
    Mirrors,
    /// Glass, which is grey without.
    Glass,
    /// Light that met several surfaces.
    IndirectLight,
    /// Ending paths that carry little, in place of following them all.
    Roulette,
    /// The estimate of the error.
    ErrorEstimate,
}

impl Effect {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Antialiasing,
        Self::DepthOfField,
        Self::Light,
        Self::AimedLight,
        Self::MetLight,
        Self::Shadows,
        Self::SoftShadows,
        Self::AmbientLight,
        Self::AmbientOcclusion,
        Self::Mirrors,
        Self::Glass,
        Self::IndirectLight,
        Self::Roulette,
        Self::ErrorEstimate,
    ];

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Antialiasing => "antialiasing",
            Self::DepthOfField => "depth of field",
            Self::Light => "all light",
            Self::AimedLight => "light that is aimed at",
            Self::MetLight => "light met by chance",
            Self::Shadows => "shadows",
            Self::SoftShadows => "soft in place of hard shadows",
            Self::AmbientLight => "light of the background",
            Self::AmbientOcclusion => "ambient occlusion",
            Self::Mirrors => "mirrors in place of grey",
            Self::Glass => "glass in place of grey",
            Self::IndirectLight => "indirect light",
            Self::Roulette => "roulette, which ends paths",
            Self::ErrorEstimate => "estimate of the error",
        }
    }

    /// The scene without the effect; the same where it has none.
    #[must_use]
    pub fn removed_from(self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let settings = &mut scene.render;
        match self {
            Self::Antialiasing => settings.antialiasing = false,
            Self::DepthOfField => settings.depth_of_field = false,
            Self::Light => settings.mode = Mode::Facing,
            Self::AimedLight if settings.mode == Mode::Path => {
                settings.light_sampling = LightSampling::Bsdf;
            }
            Self::AimedLight => {
                scene.lights.clear();
                let radiance = Rgb::ZERO;
                let emitters = scene.materials.values_mut();
                emitters
                    .filter(|material| matches!(material, Material::Emitter { .. }))
                    .for_each(|emitter| *emitter = Material::Emitter { radiance });
            }
            Self::MetLight => settings.light_sampling = LightSampling::Nee,
            Self::Shadows => settings.shadows = Shadows::Off,
            Self::SoftShadows if settings.shadows != Shadows::Off => {
                settings.shadows = Shadows::Hard;
            }
            Self::SoftShadows => {}
            Self::AmbientLight => scene.background = Background::default(),
            Self::AmbientOcclusion if settings.mode == Mode::Ao => settings.mode = Mode::Facing,
            Self::AmbientOcclusion => settings.ambient_occlusion.enabled = false,
            Self::Mirrors => settings.mirror = false,
            Self::Glass => settings.glass = false,
            Self::IndirectLight => settings.max_bounces = settings.max_bounces.min(1),
            Self::Roulette => settings.roulette = false,
            Self::ErrorEstimate => settings.error_estimate = false,
        }
        scene
    }

    /// Those that the picture of `scene` has.
    pub(super) fn all_of(scene: &Scene) -> Vec<Self> {
        let plan = Plan::of(scene).ok();
        let all = Self::ALL.into_iter();
        all.filter(|effect| effect.is_in(scene, plan)).collect()
    }

    /// Whether the picture of `scene`, whose plan is `plan`, has it.
    fn is_in(self, scene: &Scene, plan: Option<Plan>) -> bool {
        let settings = &scene.render;
        let needs = |feature| plan.is_some_and(|plan| plan.needs(feature));
        let is_direct = settings.mode == Mode::Direct;
        let has_material = |is: fn(&Material) -> bool| {
            let used = scene
                .objects
                .iter()
                .filter(|object| scene.has_triangles(object));
            used.filter_map(|object| scene.material_of(object).ok())
                .any(|material| is(&material) && !is_nothing(&material, settings))
        };
        let shows_light = settings.mode.shows_light();
        match self {
            Self::Antialiasing => needs(Feature::PixelPoints),
            Self::DepthOfField => needs(Feature::Lens),
            Self::Light => shows_light && needs(Feature::Light),
            Self::AimedLight => shows_light && needs(Feature::Aiming),
            Self::MetLight => {
                settings.mode == Mode::Path
                    && settings.light_sampling == LightSampling::Mis
                    && needs(Feature::Aiming)
                    && needs(Feature::LastRays)
            }
            Self::Shadows => is_direct && needs(Feature::ShadowRays),
            Self::SoftShadows => {
                is_direct && needs(Feature::LightPoints) && settings.shadows == Shadows::Soft
            }
            Self::AmbientLight => is_direct && !scene.background.is_black() && !is_sky_black(scene),
            Self::AmbientOcclusion if settings.mode == Mode::Ao => needs(Feature::Occlusion),
            Self::AmbientOcclusion => {
                is_direct && settings.ambient_occlusion.enabled && needs(Feature::Occlusion)
            }
            Self::Mirrors => {
                shows_light
                    && settings.mirror
                    && has_material(|material| matches!(material, Material::Mirror { .. }))
            }
            Self::Glass => {
                shows_light
                    && settings.glass
                    && has_material(|material| matches!(material, Material::Glass { .. }))
            }
            Self::IndirectLight => settings.mode == Mode::Path && settings.max_bounces > 1,
            Self::Roulette => needs(Feature::Roulette),
            Self::ErrorEstimate => settings.measures_error(),
        }
    }
}

/// Whether the background is an image that gives no light.
fn is_sky_black(scene: &Scene) -> bool {
    let image = scene.background_image().ok().flatten();
    image.is_some_and(|image| image.is_black())
}

/// A part of the time of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The median of all pairs, as a share of the time of the plain render.
    pub value: f64,
    /// Where the median lies with 95 % confidence or more, by the sign test.
    pub interval: [f64; 2],
}

/// What was measured of a scene.
#[derive(Clone, Debug)]
pub struct Costs {
    /// Effects that the scene has, and the part of the time that each takes.
    pub effects: Vec<(Effect, Share)>,
    /// Features of the mode that are left out, and what each would add.
    pub savings: Vec<(Feature, Share)>,
    /// What keeping layers would add; `None` where there are none.
    pub layers: Option<Share>,
    /// What tracing the rays from the eye again after an edit of lights or materials would add; `None` where they differ from sample
    /// to sample.
    pub primary_rays: Option<Share>,
    /// Pairs of each.
    pub pairs: usize,
}

impl Costs {
    /// Everything that is left out, in words, and what it would add.
    pub fn left_out(&self) -> impl Iterator<Item = (&'static str, Share)> {
        let savings = self
            .savings
            .iter()
            .map(|(feature, share)| (feature.name(), *share));
        let layers = self.layers.map(|share| (LAYERS, share));
        let again = "rays from the eye, after an edit in the window";
        let primary_rays = self.primary_rays.map(|share| (again, share));
        savings.chain(layers).chain(primary_rays)
    }
}

/// A scene whose renders are short enough to be timed often, and long enough to be timed.
#[derive(Debug)]
pub struct Trial {
    scene: Scene,
    prepared: PreparedScene,
    cancel: CancelToken,
}

impl Trial {
    /// Finds a size at which a render takes as long as it must. `None` when cancelled, as is then everything that it is asked for.
    /// `prepared`: what was prepared of the scene, if anything was; its triangles and tree are used.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn new(
        scene: &Scene,
        prepared: Option<&PreparedScene>,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        let mut small = scene.clone();
        small.render.stop = Stop::default();
        let samples = scene.render.samples_per_pixel;
        small.render.samples_per_pixel = samples.min(MOST_SAMPLES);
        let mut divisor = COARSEST;
        let mut previous = prepared.cloned();
        loop {
            small.render.width = scene.render.width.div_ceil(divisor);
            small.render.height = scene.render.height.div_ceil(divisor);
            let prepared = PreparedScene::prepare(&small, previous.as_ref(), cancel)?;
            let Some(prepared) = prepared else {
                return Ok(None);
            };
            let trial = Self {
                scene: small.clone(),
                prepared,
                cancel: cancel.clone(),
            };
            let Some(seconds) = Self::seconds_of(&trial.prepared, &trial.alone()) else {
                return Ok(None);
            };
            if seconds >= LEAST_SECONDS || divisor == 1 {
                return Ok(Some(trial));
            }
            divisor /= 2;
            previous = Some(trial.prepared);
        }
    }

    /// Seconds that the whole picture of `scene`, whose trial this is, takes on one thread. They are estimated by some of its tiles spread
    /// over it, whose rays are as near each other as in the whole.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn estimated_seconds(&self, scene: &Scene) -> Result<Option<f64>, SceneError> {
        let mut scene = scene.clone();
        scene.render.stop = Stop::default();
        let samples = scene.render.samples_per_pixel;
        scene.render.samples_per_pixel = samples.min(MOST_SAMPLES);
        let (width, height) = (scene.render.width, scene.render.height);
        let Some(prepared) = self.prepare(&scene)? else {
            return Ok(None);
        };
        let place = |number: u32, size: u32| (2 * number + 1) * (size / (2 * TILES));
        let (mut seconds, mut pixels) = (0.0, 0);
        for (row, column) in (0..TILES).flat_map(|row| (0..TILES).map(move |column| (row, column)))
        {
            let (x, y) = (place(column, width), place(row, height));
            let region = Region {
                x,
                y,
                width: TILE_SIDE.min(width - x),
                height: TILE_SIDE.min(height - y),
            };
            let progress = RenderProgress::default();
            let Some(outcome) = render(&prepared, Some(region), &self.alone(), &progress, None)
            else {
                return Ok(None);
            };
            seconds += outcome.stats.cpu_seconds;
            pixels += region.pixel_count();
        }
        let all = scene.render.pixel_count() as f64 * f64::from(samples);
        let taken = pixels as f64 * f64::from(scene.render.samples_per_pixel);
        Ok(Some(seconds * all / taken))
    }

    /// Measures everything in `pairs` pairs. `is_done` is told how many of how many measurements are done.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    ///
    /// # Panics
    /// When a picture differs where only what is not needed was done: a fault of the program.
    pub fn costs(
        &self,
        pairs: usize,
        mut is_done: impl FnMut(usize, usize),
    ) -> Result<Option<Costs>, SceneError> {
        let effects = Effect::all_of(&self.scene);
        let plan = self.prepared.plan();
        let left_out: Vec<_> = Feature::ALL
            .into_iter()
            .filter(|feature| !plan.needs(*feature) && feature.is_of(self.scene.render.mode))
            .collect();
        let has_layers = !self.prepared.layers().is_empty();
        let store = PrimaryHitStore::default();
        let known = self.prepared.clone().with_primary_hits(&store);
        let keeps_hits = known.keeps_primary_hits();
        let all =
            effects.len() + left_out.len() + usize::from(has_layers) + usize::from(keeps_hits);
        let mut done = 0;
        let mut tell = || {
            done += 1;
            is_done(done, all);
        };
        let mut costs = Costs {
            effects: Vec::new(),
            savings: Vec::new(),
            layers: None,
            primary_rays: None,
            pairs,
        };
        let plain = &self.prepared;
        for effect in effects {
            let Some(without) = self.prepare(&effect.removed_from(&self.scene))? else {
                return Ok(None);
            };
            let part = |plain: f64, without: f64| 1.0 - without / plain;
            let Some(share) = self.compare(plain, &without, &self.alone(), pairs, part) else {
                return Ok(None);
            };
            costs.effects.push((effect, share));
            tell();
        }
        for feature in left_out {
            let with = plain.clone().with_plan(plan.forcing(feature));
            let hashes = [&with, plain].map(|scene| self.picture_hash(scene));
            let [Some(hash), Some(expected)] = hashes else {
                return Ok(None);
            };
            assert_eq!(hash, expected, "{feature:?} changes the picture");
            let Some(share) = self.added_by(&with, pairs) else {
                return Ok(None);
            };
            costs.savings.push((feature, share));
            tell();
        }
        if has_layers {
            costs.layers = self.added_by_layers(pairs);
            tell();
        }
        if keeps_hits {
            let _ = Self::seconds_of(&known, &self.alone());
            costs.primary_rays = self.added_beside(&known, plain, pairs);
            tell();
        }
        Ok((!self.cancel.is_cancelled()).then_some(costs))
    }

    /// The scene, in the size at which it is timed.
    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The same, prepared.
    pub(super) fn prepared(&self) -> &PreparedScene {
        &self.prepared
    }

    /// What rendering `other` takes more than rendering the scene as it is.
    pub(super) fn added_by(&self, other: &PreparedScene, pairs: usize) -> Option<Share> {
        self.added_beside(&self.prepared, other, pairs)
    }

    /// What rendering `other` takes more than rendering `plain`.
    pub(super) fn added_beside(
        &self,
        plain: &PreparedScene,
        other: &PreparedScene,
        pairs: usize,
    ) -> Option<Share> {
        self.compare(plain, other, &self.alone(), pairs, added)
    }

    /// What keeping layers takes more.
    pub(super) fn added_by_layers(&self, pairs: usize) -> Option<Share> {
        let with_layers = RunConfig {
            layers: true,
            ..self.alone()
        };
        self.compare(&self.prepared, &self.prepared, &with_layers, pairs, added)
    }

    /// Renders `plain` and `other` in turns. `None` when cancelled.
    fn compare(
        &self,
        plain: &PreparedScene,
        other: &PreparedScene,
        run: &RunConfig,
        pairs: usize,
        share: impl Fn(f64, f64) -> f64,
    ) -> Option<Share> {
        let plain = || Self::seconds_of(plain, &self.alone());
        let changed = || Self::seconds_of(other, run);
        in_pairs(pairs, plain, changed, share)
    }

    fn alone(&self) -> RunConfig {
        RunConfig {
            threads: 1,
            cancel: self.cancel.clone(),
            ..RunConfig::default()
        }
    }

    /// Prepares `scene`, with what is already prepared of this one.
    pub(super) fn prepare(&self, scene: &Scene) -> Result<Option<PreparedScene>, SceneError> {
        PreparedScene::prepare(scene, Some(&self.prepared), &self.cancel)
    }

    /// Processor time of a render.
    fn seconds_of(scene: &PreparedScene, run: &RunConfig) -> Option<f64> {
        let outcome = render(scene, None, run, &RenderProgress::default(), None)?;
        Some(outcome.stats.cpu_seconds)
    }

    pub(super) fn picture_hash(&self, scene: &PreparedScene) -> Option<String> {
        let outcome = render(scene, None, &self.alone(), &RenderProgress::default(), None)?;
        Some(outcome.image.hash())
    }
}

/// What `other` takes more than `plain`, both in seconds, measured in turns.
pub(super) fn paired(pairs: usize, plain: impl Fn() -> f64, other: impl Fn() -> f64) -> Share {
    let share = in_pairs(pairs, || Some(plain()), || Some(other()), added);
    share.expect("nothing is cancelled")
}

fn added(plain: f64, other: f64) -> f64 {
    other / plain - 1.0
}

fn in_pairs(
    pairs: usize,
    plain: impl Fn() -> Option<f64>,
    other: impl Fn() -> Option<f64>,
    share: impl Fn(f64, f64) -> f64,
) -> Option<Share> {
    let pair = |number: usize| {
        // Either is first as often.
        if number.is_multiple_of(2) {
            let first = plain()?;
            Some(share(first, other()?))
        } else {
            let first = other()?;
            Some(share(plain()?, first))
        }
    };
    (0..pairs).map(pair).collect::<Option<_>>().map(Share::of)
}

impl Share {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let outside = ranks_outside(count);
        let middle = |values: &[f64]| {
            let half = values.len() / 2;
            if values.len().is_multiple_of(2) {
                f64::midpoint(values[half - 1], values[half])
            } else {
                values[half]
            }
        };
        Self {
            value: middle(&values),
            interval: [values[outside], values[count - 1 - outside]],
        }
    }
}

/// How many of `count` sorted values lie outside the interval of the sign test at each end: as many as may be for a confidence of 95 %.
fn ranks_outside(count: usize) -> usize {
    let mut probability = 0.5_f64.powi(i32::try_from(count).unwrap_or(i32::MAX));
    let mut tail = 0.0;
    for rank in 0..count / 2 {
        tail += probability;
        if tail > 0.025 {
            return rank.saturating_sub(1);
        }
        probability *= (count - rank) as f64 / (rank + 1) as f64;
    }
    (count / 2).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of values below the median is binomial; for 20 the 6th and the 15th bound it with 95.9 %. Source: Conover,
    /// Practical Nonparametric Statistics, table A3.
    #[test]
    fn the_interval_is_that_of_the_sign_test() {
        for (count, outside) in [(1, 0), (5, 0), (6, 0), (8, 0), (9, 1), (20, 5), (30, 9)] {
            assert_eq!(ranks_outside(count), outside, "{count}");
        }
    }
}
