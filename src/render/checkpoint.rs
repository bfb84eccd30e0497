//! What a render has reached, as plain data: enough to go on from there, in another process too, and end with the same bits.

use serde::{Deserialize, Serialize};

use super::error::{Allotment, ErrorEstimator};
use super::film::Film;
use super::layers::Layer;
use super::prepare::PreparedScene;
use super::progress::ErrorPoint;
use super::renderer::{Ahead, TILE_SIDE, leads_elsewhere};
use super::rules::StopRules;
use super::run::OnTile;
use super::tile_samples::{PassWork, SampleCounts};
use super::tiles::{Region, TilePixels};
use crate::control::CancelToken;
use crate::scene::RenderSettings;

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
    /// The work of the pass on a tile, where no pixel may get more than `most` samples in all. One over all pixels is as long as it was begun,
    /// whatever the rules are by now: all have as many samples after it.
    pub fn work(&self, most: u32) -> PassWork<'_> {
        let most = if self.selected.is_some() {
            most
        } else {
            RenderSettings::MAX_SAMPLES
        };
        PassWork {
            selected: self.selected.as_deref(),
            begins_round: self.begins_round,
            longest: self.longest,
            most,
        }
    }
}

impl Course {
    /// Whether the error has decided already which pixels of `film` get samples.
    pub fn has_chosen_pixels(&self, film: &Film) -> bool {
        match &self.pass {
            Some(pass) => pass.selected.is_some(),
            None => film.total_samples() > film.pixels() as u64 * u64::from(self.even_samples),
        }
    }

    /// How many samples the pass that is going on has still to take of tiles that lack it, where no pixel may get more than `most`; 0 where
    /// none is.
    pub fn left_of_pass(&self, shared: &Shared, most: u32) -> u64 {
        let Some(pass) = &self.pass else {
            return 0;
        };
        let (film, work) = (&shared.film, pass.work(most));
        let tiles = film.region().tiles(TILE_SIDE);
        let tiles = tiles.into_iter().zip(&shared.has_pass);
        tiles
            .filter(|(_, has_pass)| !**has_pass)
            .map(|(tile, _)| work.samples_in(film, tile))
            .sum()
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

    /// Whether a render that goes on from it by the rules of `after` instead of `before`, which differ in nothing else, ends with another
    /// picture than one by those from the start would, were it to take as many samples.
    #[must_use]
    pub fn leads_elsewhere(&self, before: &RenderSettings, after: &RenderSettings) -> bool {
        let Self { shared, course, .. } = self;
        let has_chosen = course.has_chosen_pixels(&shared.film);
        let rules = [before, after].map(StopRules::of);
        leads_elsewhere(before, rules.each_ref(), course.even_samples, has_chosen)
    }

    /// The same with other rules to end by, those of `settings`: as many samples are expected of it as it takes by them, as far as that is
    /// known, and it does not tell any more when it would have ended by those before.
    #[must_use]
    pub fn with_rules_of(mut self, settings: &RenderSettings) -> Self {
        for point in &mut self.errors {
            point.time_to_stop = None;
        }
        let Self { shared, course, .. } = &self;
        let ahead = Ahead::of(course, shared, &StopRules::of(settings), self.seconds);
        Self {
            expected_samples: shared.film.total_samples() + ahead.samples,
            ..self
        }
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
    /// size, as they have in any that such a render kept. Pixels may have more samples than the scene allows by now: they get no more then.
    #[must_use]
    pub fn fits(&self, scene: &PreparedScene, region: Region, layers: &[Layer]) -> bool {
        let settings = scene.settings();
        let pixels = region.pixel_count();
        let Self { shared, course, .. } = self;
        let has_error = settings.measures_error();
        let selects_pixels = |pass: &Pass| {
            pass.selected
                .iter()
                .all(|selected| selected.len() == pixels)
        };
        shared.film.is_like(region, layers, has_error)
            && shared.has_pass.len() == region.tiles(TILE_SIDE).len()
            && course.even_samples <= RenderSettings::MAX_SAMPLES
            && course.estimator.is_some() == has_error
            && course.estimator.iter().all(|e| e.is_like(pixels))
            && course.allotment.iter().all(|a| a.is_like(pixels))
            && course.pass.iter().all(selects_pixels)
    }
}
