//! What a render has reached, as plain data: enough to go on from there, in another process too, and end with the same bits.

use serde::{Deserialize, Serialize};

use super::error::{Allotment, ErrorEstimator};
use super::film::Film;
use super::layers::Layer;
use super::prepare::PreparedScene;
use super::progress::ErrorPoint;
use super::renderer::TILE_SIDE;
use super::run::OnTile;
use super::tile_samples::{PassWork, SampleCounts};
use super::tiles::{Region, TilePixels};
use crate::control::CancelToken;

/// A moment of a render, from which [`resume`](super::resume) goes on as if nothing had happened.
///
/// It may lie in the middle of a pass, where some tiles have its samples and others not.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(super) shared: Shared,
    pub(super) course: Course,
    /// Wall time so far, and processor time of the threads that render.
    pub(super) seconds: f64,
    pub(super) cpu_seconds: f64,
    /// How the error fell.
    pub(super) errors: Vec<ErrorPoint>,
    /// Camera samples of the whole render, as far as was known.
    pub(super) expected_samples: u64,
}

/// What the threads of a render add to.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shared {
    pub film: Film,
    pub counts: SampleCounts,
    pub first_tile_seconds: Option<f64>,
    /// Which tiles have the samples of the pass that is going on.
    pub has_pass: Vec<bool>,
}

impl Shared {
    /// A copy; `None` when cancelled.
    pub fn copy_unless(&self, cancel: &CancelToken) -> Option<Self> {
        Some(Self {
            film: self.film.copy_unless(cancel)?,
            counts: self.counts,
            first_tile_seconds: self.first_tile_seconds,
            has_pass: self.has_pass.clone(),
        })
    }
}

/// Where a render stands, and what it has learnt: all that changes between passes only.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Course {
    /// `None` where the error is not asked for.
    pub estimator: Option<ErrorEstimator>,
    /// Where samples belong; `None` where all pixels get the same number, and before there is an estimate.
    pub allotment: Option<Allotment>,
    /// Number of passes that are over.
    pub passes: u32,
    /// The pass that is going on.
    pub pass: Option<Pass>,
    /// Samples that every pixel has from passes over all of them.
    pub even_samples: u32,
    /// Seconds that one more sample of every pixel took in the last pass over all of them.
    pub seconds_per_sample: f64,
    /// Samples when the error was noted last.
    pub noted_samples: f64,
}

/// A pass over the tiles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pass {
    /// Whether each pixel takes part; all do, where there is no choice.
    pub selected: Option<Vec<bool>>,
    /// Whether pixels take part whose number of samples is a power of two.
    pub begins_round: bool,
    /// The most samples of one pixel in this pass.
    pub longest: u32,
    /// When it began, in seconds of wall time.
    pub started: f64,
}

impl Pass {
    /// The work of the pass on a tile, where no pixel may get more than `most` samples in all.
    pub fn work(&self, most: u32) -> PassWork<'_> {
        PassWork {
            selected: self.selected.as_deref(),
            begins_round: self.begins_round,
            longest: self.longest,
            most,
        }
    }
}

impl Course {
    /// Whether the error already decides which pixels get samples.
    pub fn chooses_pixels(&self) -> bool {
        let pass = self.pass.as_ref();
        pass.is_some_and(|pass| pass.selected.is_some())
    }
}

impl Checkpoint {
    /// The moment before the first sample of a render of `region` of `scene` that keeps `layers`.
    ///
    /// # Panics
    /// When the region does not lie in the picture.
    #[must_use]
    pub fn before(scene: &PreparedScene, region: Region, layers: &[Layer]) -> Self {
        let settings = scene.settings();
        assert!(
            region.fits(settings.width, settings.height),
            "{region:?} lies outside the picture"
        );
        let pixels = region.pixel_count();
        let has_error = settings.measures_error();
        Self {
            shared: Shared {
                film: Film::new(region, layers, has_error),
                counts: SampleCounts::default(),
                first_tile_seconds: None,
                has_pass: vec![false; region.tiles(TILE_SIDE).len()],
            },
            course: Course {
                estimator: has_error.then(|| ErrorEstimator::new(pixels)),
                ..Course::default()
            },
            seconds: 0.0,
            cpu_seconds: 0.0,
            errors: Vec::new(),
            expected_samples: pixels as u64 * u64::from(settings.samples_per_pixel),
        }
    }

    /// The part of the picture that is rendered.
    #[must_use]
    pub fn region(&self) -> Region {
        self.shared.film.region()
    }

    /// Wall time of the render so far.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The share of all camera samples that is done, as far as their number was known, `0..=1`, where there are so many `more` beside.
    #[must_use]
    pub fn share_done(&self, more: u64) -> f64 {
        let done = (self.shared.film.total_samples() + more) as f64;
        (done / self.expected_samples.max(1) as f64).min(1.0)
    }

    /// Whether it has not what the tile number `tile` got in pass number `pass`.
    #[must_use]
    pub fn lacks(&self, pass: u32, tile: u32) -> bool {
        let has_tile = || self.shared.has_pass.get(tile as usize) == Some(&true);
        match pass.cmp(&self.course.passes) {
            std::cmp::Ordering::Less => false,
            std::cmp::Ordering::Equal => !has_tile(),
            std::cmp::Ordering::Greater => true,
        }
    }

    /// Mean samples of a pixel.
    #[must_use]
    pub fn samples_per_pixel(&self) -> f64 {
        self.shared.film.mean_samples()
    }

    /// Shows every tile that has samples to `on_tile`, as a render that goes on shows only those that get more.
    pub fn show(&self, on_tile: OnTile<'_>) {
        let Shared { film, has_pass, .. } = &self.shared;
        let tiles = film.region().tiles(TILE_SIDE).into_iter().zip(has_pass);
        for (region, _) in tiles.filter(|(_, has_pass)| **has_pass || self.course.passes > 0) {
            let means = film.means(region);
            on_tile(&TilePixels {
                region,
                rgb: &means[0],
                layers: &means[1..],
            });
        }
    }

    /// Whether a render of `region` of `scene` that keeps `layers` can go on from it: whether all parts of the checkpoint have the right
    /// size, as they have in any that such a render kept.
    #[must_use]
    pub fn fits(&self, scene: &PreparedScene, region: Region, layers: &[Layer]) -> bool {
        let settings = scene.settings();
        let (pixels, most) = (region.pixel_count(), settings.samples_per_pixel);
        let Self { shared, course, .. } = self;
        let has_error = settings.measures_error();
        let selects_pixels = |pass: &Pass| {
            pass.selected
                .iter()
                .all(|selected| selected.len() == pixels)
        };
        shared.film.is_like(region, layers, has_error, most)
            && shared.has_pass.len() == region.tiles(TILE_SIDE).len()
            && course.even_samples <= most
            && course.estimator.is_some() == has_error
            && course.estimator.iter().all(|e| e.is_like(pixels, most))
            && course.allotment.iter().all(|a| a.is_like(pixels))
            && course.pass.iter().all(selects_pixels)
    }
}
