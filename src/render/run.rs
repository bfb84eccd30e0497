//! The entry to rendering: how to run it, who watches it, and what it returns. What the picture shows is decided by the scene alone.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::Image;
use super::blocks::BlockStore;
use super::checkpoint::Checkpoint;
use super::coarse::OnCoarse;
use super::error::{ErrorEstimate, ErrorEstimator};
use super::film::Film;
use super::layers::Layer;
use super::prepare::PreparedScene;
use super::progress::{ErrorPoint, RenderProgress};
use super::renderer::Renderer;
use super::rules::LiveRules;
use super::tiles::{Region, TilePixels};
use crate::control::{CancelToken, Throttle};

/// How to run a render; it never changes the picture.
#[derive(Clone, Debug, Default)]
pub struct RunConfig {
    /// Threads to use; 0 is one per core.
    pub threads: usize,
    /// Asked between samples, and now and then in long ones.
    pub cancel: CancelToken,
    /// Asked between tiles: ends the render with the samples it has then, [`Ending::Interrupted`].
    pub interrupt: CancelToken,
    /// How many of the threads may work: a pause holds them between samples and in long ones, without a trace in times and pixels; fewer than all are
    /// held between tiles. Whoever cancels a paused render must let it go on as well.
    pub throttle: Throttle,
    /// Whether to keep the parts of the picture, see [`Layer`]; those the scene can have.
    pub layers: bool,
    /// Whether there is memory for one more copy of the sums of the picture, as a checkpoint takes: with it a render goes on with the very bits
    /// of a longer one where its rules are changed while it ends, or after, see [`Watch::at_end`].
    pub has_room: bool,
    /// By which rules it ends; `None`: by those of the settings, all the while.
    pub rules: Option<LiveRules>,
}

impl RunConfig {
    /// The number of threads that `threads` stands for.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }

    /// The layers that a render of `scene` keeps beside the picture, except that of the error.
    #[must_use]
    pub fn layers_of<'a>(&self, scene: &'a PreparedScene) -> &'a [Layer] {
        if self.layers { scene.layers() } else { &[] }
    }
}

/// Rays by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayCounts {
    /// From the eye: one per sample, even where it misses the scene's box; where all samples of a pixel share one ray, one for all that a
    /// pass takes. None where it is [known](super::PrimaryHitStore) what they hit.
    pub camera: u64,
    /// To a light.
    pub shadow: u64,
    /// Into the hemisphere over a point.
    pub ambient_occlusion: u64,
    /// From a mirror or glass, or along a path.
    pub bounce: u64,
}

impl RayCounts {
    /// All rays.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.ambient_occlusion + self.bounce
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.ambient_occlusion += other.ambient_occlusion;
        self.bounce += other.bounce;
    }
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct RenderOutcome {
    /// Linear radiance of the region.
    pub image: Image,
    /// Its parts and factors, and its error, where asked for.
    pub layers: Vec<(Layer, Image)>,
    /// What it took.
    pub stats: RenderStats,
    /// How its error fell.
    pub errors: Vec<ErrorPoint>,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Every pixel has all its samples, or all that help.
    #[default]
    Samples,
    /// The noise is as low as asked for.
    Noise,
    /// The time is up. Where that was before the first pass was over, pixels have one sample or none.
    Time,
    /// It was told to end. Pixels may have any number of samples, even none.
    Interrupted,
}

/// What a render took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Wall time of all passes; that of a [`Watch`] does not count.
    pub render_seconds: f64,
    /// Processor time of the threads that rendered.
    pub cpu_seconds: f64,
    /// From the call to the first delivered tile.
    pub first_tile_seconds: f64,
    /// Threads used.
    pub threads: usize,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples of all pixels.
    pub samples: u64,
    /// Mean samples of a pixel.
    pub samples_per_pixel: f64,
    /// The fewest and the most samples of a pixel.
    pub sample_range: [u32; 2],
    /// Passes over the picture that are over. Where the error decides which pixels get samples, their number reproduces a picture that was
    /// ended between two of them.
    pub passes: u32,
    /// Whether it ended in the middle of a pass: as it was told to, or by the clock in the first or far beyond its time. Nothing reproduces that.
    pub is_cut_short: bool,
    /// Why it ended.
    pub ending: Ending,
    /// How wrong the picture is; `None` where it is not asked for, or there are too few samples to tell.
    pub error: Option<ErrorEstimate>,
    /// Samples that were infinite or not a number. They stay in the picture.
    pub non_finite_samples: u64,
    /// Samples that are negative in a channel. They stay in the picture.
    pub negative_samples: u64,
    /// Samples whose path `render.max_bounces` ended where it might have brought more: light is missing in them. Counted too are
    /// paths that would have left the scene next, as that is not looked for.
    pub depth_limited_samples: u64,
    /// What `render.clamp` took away.
    pub clamped: Clamped,
}

/// The share of depth-limited samples from which on the loss is told as a warning.
const NOTABLE_SHARE: f64 = 0.1;

impl RenderStats {
    /// The share of the samples that are depth-limited, where it is large enough to be warned of.
    #[must_use]
    pub fn notable_depth_limited_share(&self) -> Option<f64> {
        let share = self.depth_limited_samples as f64 / self.samples as f64;
        Some(share).filter(|&share| share > NOTABLE_SHARE)
    }
}

/// What clamping took away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Clamped {
    /// Samples that were brighter than allowed.
    pub samples: u64,
    /// Luminance they lost, as a share of the whole picture's, `0..=1`.
    pub energy_share: f64,
}

/// Who is shown each tile as it is done, from any thread.
pub type OnTile<'a> = &'a (dyn Fn(&TilePixels<'_>) + Sync);

/// Who is shown the film whenever the samples of its pixels have doubled, or those of the ones that needed it, and at the end.
pub type OnRound<'a> = &'a (dyn Fn(&Round<'_>) + Sync);

/// A moment at which every pixel has a power of two of samples, or the most it may get, or the end.
#[derive(Clone, Copy, Debug)]
pub struct Round<'a> {
    /// Wall time since the start; that of the watch does not count.
    pub seconds: f64,
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// Mean samples of a pixel.
    pub samples_per_pixel: f64,
    /// The error, where it is estimated.
    pub error: Option<ErrorEstimate>,
    pub(super) film: &'a Film,
    pub(super) estimator: Option<&'a ErrorEstimator>,
}

impl Round<'_> {
    /// The picture so far.
    #[must_use]
    pub fn image(&self) -> Image {
        self.film.image()
    }

    /// The error of each pixel, where it is estimated; `None` when cancelled, too.
    #[must_use]
    pub fn error_image(&self, cancel: &CancelToken) -> Option<Image> {
        self.estimator?.image(self.film, cancel)
    }
}

/// Who keeps checkpoints of a render.
#[derive(Clone, Copy)]
pub struct CheckpointKeeper<'a> {
    /// How long to wait from one to the next, and before the first.
    pub every: Duration,
    /// The most that keeping them may take of the time of all threads, above 0: where one takes long, the next waits longer for it.
    /// Infinite where that does not matter.
    pub most_share: f64,
    /// Is given them: by the thread that finds one due after a tile, which takes no samples until this returns, and at the end of a
    /// render that is interrupted.
    pub keep: &'a (dyn Fn(Checkpoint) + Sync),
    /// Of one that goes on keeping when `keep` returns: how long it did so with the last one, zero before the first; `None` while it does.
    /// No other is taken then: each is a copy of all sums.
    pub in_background: Option<&'a (dyn Fn() -> Option<Duration> + Sync)>,
}

impl CheckpointKeeper<'_> {
    /// How long the last one was kept in the background; `None` while it still is.
    pub(super) fn took_in_background(&self) -> Option<Duration> {
        self.in_background
            .map_or(Some(Duration::ZERO), |took| took())
    }
}

/// Who watches a render.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Is shown coarse pictures, before any tile. Their rays are not counted.
    pub on_coarse: Option<OnCoarse<'a>>,
    /// Is shown tiles.
    pub on_tile: Option<OnTile<'a>>,
    /// Is shown rounds. The render waits for it, with its clock stopped.
    pub on_round: Option<OnRound<'a>>,
    /// Keeps checkpoints.
    pub checkpoints: Option<CheckpointKeeper<'a>>,
    /// Is given what it has reached at its end, for whoever would go on from there by other rules: when it was cancelled, and otherwise where
    /// [there is room](RunConfig::has_room).
    pub at_end: Option<&'a (dyn Fn(Checkpoint) + Sync)>,
    /// Keeps what tiles get between checkpoints, and knows what they got before.
    pub blocks: Option<&'a dyn BlockStore>,
}

/// Renders `region` of the picture, or all of it, and shows the tiles to `on_tile`, if anybody watches. `None` when cancelled.
///
/// The pixels of a region are those of the full picture, bit for bit, as long as every pixel gets the same number of samples.
///
/// # Panics
/// When the region does not lie in the picture, and with a [`RenderFault`](super::RenderFault) where the program fails at a sample.
#[must_use]
pub fn render(
    scene: &PreparedScene,
    region: Option<Region>,
    run: &RunConfig,
    progress: &RenderProgress,
    on_tile: Option<OnTile<'_>>,
) -> Option<RenderOutcome> {
    let watch = Watch {
        on_tile,
        ..Watch::default()
    };
    render_watched(scene, region, run, progress, watch)
}

/// [`render`] for whoever wants to see more than tiles.
///
/// # Panics
/// When the region does not lie in the picture, and with a [`RenderFault`](super::RenderFault) where the program fails at a sample.
#[must_use]
pub fn render_watched(
    scene: &PreparedScene,
    region: Option<Region>,
    run: &RunConfig,
    progress: &RenderProgress,
    watch: Watch<'_>,
) -> Option<RenderOutcome> {
    let settings = scene.settings();
    let region = region.unwrap_or(Region::full(settings.width, settings.height));
    finished(Renderer::new(scene, region, run, progress, watch))
}

/// [`render_watched`] that goes on from `checkpoint`. The picture, its error and all counts are those of a render that was never
/// interrupted; its time is that of both. Tiles are shown when they get more samples.
///
/// # Panics
/// When the checkpoint does not [fit](Checkpoint::fits) the scene and the layers to keep, and with a
/// [`RenderFault`](super::RenderFault) where the program fails at a sample.
#[must_use]
pub fn resume(
    scene: &PreparedScene,
    checkpoint: Checkpoint,
    run: &RunConfig,
    progress: &RenderProgress,
    watch: Watch<'_>,
) -> Option<RenderOutcome> {
    assert!(
        checkpoint.fits(scene, checkpoint.region(), run.layers_of(scene)),
        "the checkpoint is one of another render"
    );
    finished(Renderer::resume(scene, checkpoint, run, progress, watch))
}

fn finished(mut renderer: Renderer<'_>) -> Option<RenderOutcome> {
    if let Some(ending) = renderer.render() {
        renderer.hand_on_copy();
        renderer.outcome(ending)
    } else {
        renderer.hand_on();
        None
    }
}
