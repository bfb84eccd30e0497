//! The pilot: a small picture, rendered once with each of several seeds, one sample per pixel each time.
//!
//! As every sample of a pixel starts through the pixel's middle, what differs between seeds is what lights, paths and the lens
//! decide, and nothing else. The seeds are independent: how much their means differ tells how far off these are.

use rayon::prelude::*;

use crate::control::CancelToken;
use crate::math::Vec3;
use crate::math::color::luminance;
use crate::render::{Image, PreparedScene, RenderProgress, RenderStats, RunConfig, render};
use crate::scene::{RenderSettings, Scene, SceneError, Stop};

/// Number of seeds, which is that of samples per pixel, where what is rare is looked for.
pub const SEEDS: u32 = 64;
/// The first so many of them, where means are compared.
pub const FEW_SEEDS: u32 = 16;

/// The longest side of the picture in pixels.
const LONGEST_SIDE: u32 = 128;
/// The shortest that the longer side may become where samples take long, in pixels.
const SHORTEST_SIDE: u32 = 8;

/// From so many bounces on the picture is smaller, by area in proportion.
const MANY_BOUNCES: f64 = 16.0;
/// The most bounces of a path.
pub const MOST_BOUNCES: u32 = 1 << 14;
/// The most rays to a light, or into the hemisphere, of a sample.
const MOST_RAYS: u32 = 256;

/// Nodes and blocks of triangles that an eye ray meets on the way, from which on the picture is smaller, by area in proportion: many
/// triangles at one spot take as long for each ray as a whole scene else.
const MANY_VISITS: f64 = 64.0;
/// So many rays along each side of the picture tell how many nodes and blocks those are.
const LOOKS: u32 = 8;

/// The samples of a pilot.
pub struct Pilot {
    pub width: usize,
    pub height: usize,
    /// The luminance of each pixel, row by row, for every seed; samples that are infinite or not a number are 0.
    pub luminances: Vec<Vec<f64>>,
    /// Samples that were infinite or not a number.
    pub non_finite: u64,
    /// Samples whose path `render.max_bounces` ended.
    pub depth_limited: u64,
}

/// The scene as its pilot is rendered.
pub fn scene_of(scene: &Scene) -> Scene {
    let settings = &scene.render;
    let max_bounces = settings.max_bounces.min(MOST_BOUNCES);
    let shrink = (MANY_BOUNCES / f64::from(max_bounces.max(1)))
        .sqrt()
        .min(1.0);
    let longest = f64::from(settings.width.max(settings.height));
    let wanted = (f64::from(LONGEST_SIDE) * shrink).max(f64::from(SHORTEST_SIDE));
    let factor = (wanted / longest).min(1.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "no longer than it was"
    )]
    let side = |pixels: u32| (f64::from(pixels) * factor).round().max(1.0) as u32;
    let mut ambient_occlusion = settings.ambient_occlusion;
    ambient_occlusion.samples = ambient_occlusion.samples.min(MOST_RAYS);
    Scene {
        render: RenderSettings {
            width: side(settings.width),
            height: side(settings.height),
            samples_per_pixel: 1,
            stop: Stop::default(),
            error_estimate: false,
            max_bounces,
            shadow_samples: settings.shadow_samples.min(MOST_RAYS),
            ambient_occlusion,
            ..settings.clone()
        },
        ..scene.clone()
    }
}

/// The pilot `scene` in a size at which its rays, as those from the eye tell, take a bounded time; `prepared` is the same scene.
pub fn bounded(scene: Scene, prepared: &PreparedScene) -> Scene {
    let (width, height) = (scene.render.width, scene.render.height);
    let middle =
        |number: u32, size: u32| (f64::from(number) + 0.5) * f64::from(size) / f64::from(LOOKS);
    let places = (0..LOOKS).flat_map(|y| (0..LOOKS).map(move |x| (x, y)));
    let visits = places
        .filter_map(|(x, y)| prepared.camera().ray(middle(x, width), middle(y, height)))
        .map(|from_eye| {
            let accelerator = prepared.geometry().accelerator();
            let visits = accelerator.visits(&from_eye.ray, f32::INFINITY, false);
            visits.nodes + visits.blocks
        })
        .sum::<u64>() as f64;
    let mean = visits / f64::from(LOOKS * LOOKS);
    resized(scene, (MANY_VISITS / mean).sqrt())
}

/// The scene with its sides scaled by `factor`, where that shortens them, down to [`SHORTEST_SIDE`] for the longer one.
pub fn resized(mut scene: Scene, factor: f64) -> Scene {
    let settings = &mut scene.render;
    let least = f64::from(SHORTEST_SIDE) / f64::from(settings.width.max(settings.height));
    let factor = factor.max(least).min(1.0);
    for side in [&mut settings.width, &mut settings.height] {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "no longer than it was"
        )]
        let shorter = (f64::from(*side) * factor).round() as u32;
        *side = shorter.max(1);
    }
    scene
}

/// Renders the pilot `scene` with `max_bounces` and the first `seeds` seeds; `prepared` is the same scene with any. `None` when
/// cancelled.
///
/// # Errors
/// What about the scene cannot be rendered.
pub fn take(
    scene: &Scene,
    prepared: &PreparedScene,
    (max_bounces, seeds): (u32, u32),
    cancel: &CancelToken,
) -> Result<Option<Pilot>, SceneError> {
    let RenderSettings { width, height, .. } = scene.render;
    // A picture has few tiles; seeds share the cores better.
    let run = RunConfig {
        threads: 1,
        cancel: cancel.clone(),
        ..RunConfig::default()
    };
    let of_seed = |turn: u32| {
        let mut scene = scene.clone();
        scene.render.max_bounces = max_bounces;
        scene.render.seed = scene.render.seed.wrapping_add(u64::from(turn));
        let Some(prepared) = PreparedScene::prepare(&scene, Some(prepared), cancel)? else {
            return Ok(None);
        };
        Ok(render(
            &prepared,
            None,
            &run,
            &RenderProgress::default(),
            None,
        ))
    };
    let outcomes: Option<Vec<_>> = (0..seeds)
        .into_par_iter()
        .map(of_seed)
        .collect::<Result<_, SceneError>>()?;
    Ok(outcomes.map(|outcomes| {
        let sum = |count: fn(&RenderStats) -> u64| outcomes.iter().map(|o| count(&o.stats)).sum();
        Pilot {
            width: width as usize,
            height: height as usize,
            non_finite: sum(|stats| stats.non_finite_samples),
            depth_limited: sum(|stats| stats.depth_limited_samples),
            luminances: outcomes
                .iter()
                .map(|outcome| luminances(&outcome.image))
                .collect(),
        }
    }))
}

fn luminances(image: &Image) -> Vec<f64> {
    let light = |&pixel: &[f32; 3]| {
        let luminance = f64::from(luminance(Vec3::from_array(pixel)));
        if luminance.is_finite() {
            luminance
        } else {
            0.0
        }
    };
    image.pixels.iter().map(light).collect()
}

impl Pilot {
    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.luminances.len() as u64 * (self.width * self.height) as u64
    }

    /// The mean luminance for each of the first [`FEW_SEEDS`].
    pub fn means(&self) -> Vec<f64> {
        let mean = |picture: &Vec<f64>| picture.iter().sum::<f64>() / picture.len() as f64;
        let few = self.luminances.iter().take(FEW_SEEDS as usize);
        few.map(mean).collect()
    }

    /// How many samples of the first [`FEW_SEEDS`] meet light.
    pub fn lit(&self) -> u64 {
        let few = self.luminances.iter().take(FEW_SEEDS as usize);
        few.flatten().filter(|&&luminance| luminance > 0.0).count() as u64
    }

    /// The share of samples whose path `render.max_bounces` ended.
    pub fn ended(&self) -> f64 {
        self.depth_limited as f64 / self.samples() as f64
    }
}
