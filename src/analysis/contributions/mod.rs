//! What each effect and each light of a scene brings to its picture: the picture with it minus the picture without, both small and of
//! the same samples.
//!
//! Lights are switched off, not taken away: what they hide stays hidden, and in mode `direct` the contributions of all that shines add
//! up to the picture, up to rounding, where each light is aimed at. Paths choose among lights by how bright these are, so there they
//! add up but for noise. Effects do not add up: what one brings depends on the others.

mod colors;

pub use colors::{BRIGHTER, DARKER, color, color_of_share, scale_of};

use super::cost::Effect;
use super::metrics::{LocatedDifference, Metrics};
use super::signed_difference;
use crate::control::CancelToken;
use crate::render::{Image, PreparedScene, RenderProgress, RunConfig, render};
use crate::scene::{Background, Light, Material, Rgb, Scene, SceneError, Stop};

/// Pixels of the pictures along their longer side, where nothing else is asked for.
pub const LONGER_SIDE: u32 = 160;
/// Standard deviations that 95 of 100 values of a normal distribution lie within.
const CONFIDENCE: f64 = 1.96;
/// The most samples of a pixel.
const MOST_SAMPLES: u32 = 32;

/// Something that a picture can be rendered without.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Contributor {
    /// An effect.
    Effect(Effect),
    /// The light of that index.
    Light(usize),
    /// What shines by the emitter of that name.
    Emitter(String),
    /// The background: as it is seen, and what it lights.
    Background,
}

impl Contributor {
    /// All that the picture of `scene` has, where it shows light: the effects first.
    #[must_use]
    pub fn all_of(scene: &Scene) -> Vec<Self> {
        if !scene.render.mode.shows_light() {
            return Vec::new();
        }
        let effects = Effect::all_of(scene).into_iter();
        // The others change how the same light is found, or are counted below.
        let effects = effects.filter(|effect| {
            matches!(
                effect,
                Effect::Antialiasing
                    | Effect::DepthOfField
                    | Effect::Shadows
                    | Effect::SoftShadows
                    | Effect::AmbientOcclusion
                    | Effect::Mirrors
                    | Effect::Glass
                    | Effect::IndirectLight
            )
        });
        let lights = scene.lights.iter().enumerate();
        let lights = lights.filter(|(_, light)| light.shines());
        let emitters = scene.materials.iter().filter(|(name, material)| {
            let mut objects = scene.objects.iter();
            shines(material) && objects.any(|object| object.material.as_ref() == Some(*name))
        });
        let background = (!scene.background.is_black()).then_some(Self::Background);
        effects
            .map(Self::Effect)
            .chain(lights.map(|(index, _)| Self::Light(index)))
            .chain(emitters.map(|(name, _)| Self::Emitter(name.clone())))
            .chain(background)
            .collect()
    }

    /// In words, as one of `scene`.
    #[must_use]
    pub fn name(&self, scene: &Scene) -> String {
        match self {
            Self::Effect(effect) => effect.name().to_owned(),
            Self::Light(index) => scene.light_label(*index),
            Self::Emitter(name) => format!("the emitter {name}"),
            Self::Background => "background".to_owned(),
        }
    }

    /// The scene without it; the same where it is not there.
    #[must_use]
    pub fn removed_from(&self, scene: &Scene) -> Scene {
        let mut scene = match self {
            Self::Effect(effect) => return effect.removed_from(scene),
            _ => scene.clone(),
        };
        match self {
            Self::Effect(_) => {}
            Self::Light(index) => match scene.lights.get_mut(*index) {
                Some(Light::Point { intensity, .. }) => *intensity = Rgb::ZERO,
                Some(Light::Disk { radiance, .. }) => *radiance = Rgb::ZERO,
                None => {}
            },
            Self::Emitter(name) => {
                if let Some(Material::Emitter { radiance }) = scene.materials.get_mut(name) {
                    *radiance = Rgb::ZERO;
                }
            }
            Self::Background => scene.background = Background::default(),
        }
        scene
    }
}

fn shines(material: &Material) -> bool {
    matches!(material, Material::Emitter { radiance } if *radiance != Rgb::ZERO)
}

/// What something brings to a picture.
///
/// How far noise puts the mean of the change off follows from the estimated errors of the two pictures (see
/// [`ErrorEstimate`](crate::render::ErrorEstimate)). Pixels are sampled on their own, so errors of a mean over `n` of them fall by `√n`.
/// Those of the two pictures come of the same samples, and may cancel or not: their sum is what the error of the difference is at most, so
/// what is told is rather too large.
#[derive(Clone, Debug, PartialEq)]
pub struct Contribution {
    /// What brings it.
    pub contributor: Contributor,
    /// The picture without.
    pub without: Image,
    /// The picture minus [`Self::without`]: W/m²/sr, with its sign.
    pub change: Image,
    /// The change in numbers.
    pub figures: Figures,
}

/// A change of a picture in numbers. Pixels that are not finite in one of the pictures do not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Mean of the change per channel, W/m²/sr; negative where the picture is darker with what changes it. NaN where no pixel counts.
    pub mean: [f64; 3],
    /// Mean of all channels, as a share of the mean of the picture; infinite where the picture is black.
    pub mean_share: f64,
    /// How far noise puts [`Self::mean_share`] off at most, in 95 of 100 cases; `None` where the error of the pictures is not known. See
    /// [`Contribution`].
    pub mean_share_error: Option<f64>,
    /// The largest change of a channel, with its sign, and where it is; `None` where no pixel counts.
    pub largest: Option<LocatedDifference>,
    /// Mean of change² / (picture² + 0.01) over pixels and channels: how wrong the picture is without. NaN where no pixel counts.
    pub relmse: f64,
    /// The change that has the last colour, see [`scale_of`].
    pub scale: f32,
}

/// The small picture of a scene that others are compared with.
#[derive(Clone, Debug)]
pub struct Whole {
    scene: Scene,
    prepared: PreparedScene,
    picture: Picture,
}

/// A picture, and how wrong it is.
#[derive(Clone, Debug)]
struct Picture {
    image: Image,
    /// The upper end of its interval; `None` where it is not known.
    rmse: Option<f64>,
}

impl Picture {
    /// `None` when cancelled.
    fn render(prepared: &PreparedScene, run: &RunConfig) -> Option<Self> {
        let outcome = render(prepared, None, run, &RenderProgress::default(), None)?;
        let error = outcome.stats.error.map(|error| error.rmse.high);
        Some(Self {
            image: outcome.image,
            rmse: error.filter(|error| error.is_finite()),
        })
    }
}

impl Whole {
    /// Renders the picture of `scene`, `longer_side` pixels along its longer side, or as small as the scene asks. `None` when cancelled, as
    /// is then all that is asked of it. `prepared`: what was prepared of the scene, if anything was; its triangles and tree are used.
    ///
    /// # Errors
    /// What about the description cannot be rendered.
    pub fn render(
        scene: &Scene,
        prepared: Option<&PreparedScene>,
        longer_side: u32,
        run: &RunConfig,
    ) -> Result<Option<Self>, SceneError> {
        let mut small = scene.clone();
        let settings = &mut small.render;
        [settings.width, settings.height] = fitted([settings.width, settings.height], longer_side);
        settings.samples_per_pixel = settings.samples_per_pixel.min(MOST_SAMPLES);
        settings.stop = Stop::default();
        settings.error_estimate = true;
        // The same samples with and without.
        settings.adaptive = false;
        let Some(prepared) = PreparedScene::prepare(&small, prepared, &run.cancel)? else {
            return Ok(None);
        };
        let picture = Picture::render(&prepared, run);
        Ok(picture.map(|picture| Self {
            scene: small,
            prepared,
            picture,
        }))
    }

    /// The picture with everything.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.picture.image
    }

    /// The scene in the size and with the samples of the picture.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What `contributor` brings. `None` when cancelled.
    ///
    /// # Errors
    /// What about the scene without it cannot be rendered.
    pub fn contribution(
        &self,
        contributor: &Contributor,
        run: &RunConfig,
    ) -> Result<Option<Contribution>, SceneError> {
        let scene = contributor.removed_from(&self.scene);
        let prepared = self.prepare(&scene, &run.cancel)?;
        let without = prepared.and_then(|prepared| Picture::render(&prepared, run));
        Ok(without.map(|without| Contribution::new(contributor.clone(), &self.picture, without)))
    }

    fn prepare(
        &self,
        scene: &Scene,
        cancel: &CancelToken,
    ) -> Result<Option<PreparedScene>, SceneError> {
        PreparedScene::prepare(scene, Some(&self.prepared), cancel)
    }
}

impl Contribution {
    /// What `contributor` brings: `whole` minus `without`.
    ///
    /// # Panics
    /// When the sizes differ.
    fn new(contributor: Contributor, whole: &Picture, without: Picture) -> Self {
        const ONE_SIZE: &str = "both are rendered in one size";
        let errors = whole.rmse.zip(without.rmse);
        let (whole, without) = (&whole.image, without.image);
        let change = signed_difference(whole, &without).expect(ONE_SIZE);
        let metrics = Metrics::measure(&without, whole).expect(ONE_SIZE);
        let [before, after] = [metrics.mean_a, metrics.mean_b];
        let mean = std::array::from_fn(|channel| after[channel] - before[channel]);
        let sum = |channels: [f64; 3]| channels.into_iter().sum::<f64>();
        let changed = sum(mean);
        let mean_share = if changed == 0.0 {
            0.0
        } else {
            changed / sum(after)
        };
        let mean_share_error = errors.map(|(of_whole, of_without)| {
            let to_mean = CONFIDENCE / (whole.pixels.len() as f64).sqrt() / (sum(after) / 3.0);
            to_mean * (of_whole + of_without + mean_share.abs() * of_whole)
        });
        let largest = metrics.largest.map(|largest| LocatedDifference {
            value: f64::from(colors::largest_channel(change.pixel(largest.x, largest.y))),
            ..largest
        });
        let figures = Figures {
            mean,
            mean_share,
            mean_share_error: mean_share_error.filter(|error| error.is_finite()),
            largest,
            relmse: metrics.errors.relmse,
            scale: scale_of(&change),
        };
        Self {
            contributor,
            without,
            change,
            figures,
        }
    }
}

/// The largest size of the same shape that is `longer_side` along its longer side and no larger than `size`, and at least 1 × 1.
fn fitted(size: [u32; 2], longer_side: u32) -> [u32; 2] {
    let longest = u64::from(size[0].max(size[1])).max(1);
    let longer_side = u64::from(longer_side).min(longest);
    size.map(|side| {
        let side = (u64::from(side) * longer_side + longest / 2) / longest;
        u32::try_from(side).map_or(u32::MAX, |side| side.max(1))
    })
}

#[cfg(test)]
mod tests;
