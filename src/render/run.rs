use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use serde::Serialize;

use super::prepare::PreparedScene;
use super::tiles::{Region, TilePixels};
use super::{Film, Image};
use crate::control::{CancelToken, Progress};
use crate::math::DVec3;

/// Side of a tile in pixels: small enough to balance two threads to the end, large enough that handing one out costs nothing.
const TILE_SIDE: u32 = 32;

/// Samples of a pixel that are summed before they meet the film: one pass over the picture. The size is part of the
/// picture's definition, since it fixes the order of additions.
const SAMPLES_PER_PASS: u32 = 16;

/// How to run a render; it never changes the picture.
#[derive(Clone, Debug, Default)]
pub struct RunConfig {
    /// Threads to use; 0 is one per core.
    pub threads: usize,
    /// Asked between samples.
    pub cancel: CancelToken,
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
}

/// Rays by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayCounts {
    /// From the eye: one per sample, also where it misses the scene's box.
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

    fn add(&mut self, other: &Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.ambient_occlusion += other.ambient_occlusion;
        self.bounce += other.bounce;
    }
}

/// A running render's state for whoever watches; clones see the same render.
#[derive(Clone, Debug, Default)]
pub struct RenderProgress {
    /// In camera samples: the fraction is the true part of the work.
    pub samples: Progress,
    rays: std::sync::Arc<AtomicU64>,
}

impl RenderProgress {
    /// Rays traced so far.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct RenderOutcome {
    /// Linear radiance of the region.
    pub image: Image,
    /// What it took.
    pub stats: RenderStats,
}

/// What a render took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Wall time of all passes.
    pub render_seconds: f64,
    /// From the call to the first delivered tile.
    pub first_tile_seconds: f64,
    /// Threads used.
    pub threads: usize,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples that were infinite or not a number. They stay in the picture.
    pub non_finite_samples: u64,
}

/// Renders `region` of the picture, or all of it, calling `on_tile` with each tile as it is done, from any thread. `None` when
/// cancelled.
///
/// The pixels of a region are those of the full picture, bit for bit.
///
/// # Panics
/// When the region does not lie in the picture.
pub fn render(
    scene: &PreparedScene,
    region: Option<Region>,
    run: &RunConfig,
    progress: &RenderProgress,
    on_tile: &(dyn Fn(&TilePixels<'_>) + Sync),
) -> Option<RenderOutcome> {
    let settings = scene.settings();
    let region = region.unwrap_or(Region::full(settings.width, settings.height));
    assert!(
        region.fits(settings.width, settings.height),
        "{region:?} lies outside the picture"
    );
    progress
        .samples
        .set_total(region.pixel_count() as u64 * u64::from(settings.samples_per_pixel));

    let started = Instant::now();
    let threads = run.thread_count();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started");
    let shared = Mutex::new(Shared {
        film: Film::new(region),
        stats: RenderStats {
            threads,
            ..RenderStats::default()
        },
    });
    let tiles = region.tiles(TILE_SIDE);

    for first_sample in (0..settings.samples_per_pixel).step_by(SAMPLES_PER_PASS as usize) {
        let samples = first_sample
            ..settings
                .samples_per_pixel
                .min(first_sample + SAMPLES_PER_PASS);
        let next_tile = AtomicUsize::new(0);
        pool.broadcast(|_| {
            while let Some(&tile) = tiles.get(next_tile.fetch_add(1, Ordering::Relaxed)) {
                let Some(block) = sample_tile(scene, tile, samples.clone(), run, progress) else {
                    return;
                };
                let rgb = shared.lock().expect("no thread panicked").add(
                    tile,
                    &block,
                    samples.len(),
                    started,
                );
                on_tile(&TilePixels {
                    region: tile,
                    rgb: &rgb,
                });
            }
        });
        if run.cancel.is_cancelled() {
            return None;
        }
    }

    let Shared { film, mut stats } = shared.into_inner().expect("no thread panicked");
    stats.render_seconds = started.elapsed().as_secs_f64();
    Some(RenderOutcome {
        image: film.image(),
        stats,
    })
}

/// What the threads of a render add to.
struct Shared {
    film: Film,
    stats: RenderStats,
}

impl Shared {
    /// Takes in a tile and returns what it shows now.
    fn add(
        &mut self,
        tile: Region,
        block: &TileBlock,
        samples: usize,
        started: Instant,
    ) -> Vec<[f32; 3]> {
        let samples = u32::try_from(samples).expect("a pass is short");
        self.film.add(tile, &block.sums, samples);
        self.stats.rays.add(&block.rays);
        self.stats.non_finite_samples += block.non_finite;
        if self.stats.first_tile_seconds == 0.0 {
            self.stats.first_tile_seconds = started.elapsed().as_secs_f64();
        }
        self.film.means(tile)
    }
}

/// One pass over one tile.
struct TileBlock {
    sums: Vec<[f64; 3]>,
    rays: RayCounts,
    non_finite: u64,
}

/// Sums `samples` of every pixel of `tile`; `None` when cancelled.
fn sample_tile(
    scene: &PreparedScene,
    tile: Region,
    samples: std::ops::Range<u32>,
    run: &RunConfig,
    progress: &RenderProgress,
) -> Option<TileBlock> {
    let mut block = TileBlock {
        sums: Vec::with_capacity(tile.pixel_count()),
        rays: RayCounts::default(),
        non_finite: 0,
    };
    for y in tile.y..tile.y + tile.height {
        let traced_before = block.rays.total();
        for x in tile.x..tile.x + tile.width {
            let mut sum = DVec3::ZERO;
            for index in samples.clone() {
                if run.cancel.is_cancelled() {
                    return None;
                }
                let value = scene.sample(x, y, index, &mut block.rays);
                block.non_finite += u64::from(!value.is_finite());
                sum += value.as_dvec3();
            }
            block.sums.push(sum.to_array());
        }
        progress
            .samples
            .advance(u64::from(tile.width) * samples.len() as u64);
        progress
            .rays
            .fetch_add(block.rays.total() - traced_before, Ordering::Relaxed);
    }
    Some(block)
}
