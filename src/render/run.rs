use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use serde::Serialize;

use super::Image;
use super::film::{Film, TileSums};
use super::layers::{Gathered, Layer};
use super::prepare::PreparedScene;
use super::tiles::{Region, TilePixels};
use crate::accel::Packet;
use crate::control::{CancelToken, Progress};
use crate::math::color::luminance;

/// Side of a tile in pixels: small enough to balance two threads to the end, large enough that handing one out costs nothing.
const TILE_SIDE: u32 = 32;

/// Most samples of a pixel that are summed before they meet the film: one pass over the picture. Passes grow to this size, so
/// that a whole picture is soon there. Their sizes are part of the picture's definition: they fix the order of additions.
const MOST_SAMPLES_PER_PASS: u32 = 16;

/// Side of the blocks of pixels whose rays are traced together.
const PACKET_SIDE: u32 = 4;
const _: () = assert!(
    (PACKET_SIDE * PACKET_SIDE) as usize == Packet::MOST_RAYS,
    "full packets"
);

/// Side of the blocks of the coarse picture, in pixels.
const COARSE_BLOCK: u32 = 8;

/// How to run a render; it never changes the picture.
#[derive(Clone, Debug, Default)]
pub struct RunConfig {
    /// Threads to use; 0 is one per core.
    pub threads: usize,
    /// Asked between samples.
    pub cancel: CancelToken,
    /// Whether to keep the parts of the picture, see [`Layer`]; those the scene can have.
    pub layers: bool,
    /// Whether to deliver a picture of one sample per block of pixels first, whose rays are not counted: for whoever waits.
    pub coarse_first: bool,
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
    /// Its parts and factors, where asked for.
    pub layers: Vec<(Layer, Image)>,
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
    /// What `render.clamp` took away.
    pub clamped: Clamped,
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

/// Renders `region` of the picture, or all of it, and shows the tiles to `on_tile`, if anybody watches. `None` when cancelled.
///
/// The pixels of a region are those of the full picture, bit for bit.
///
/// # Panics
/// When the region does not lie in the picture.
#[must_use]
pub fn render(
    scene: &PreparedScene,
    region: Option<Region>,
    run: &RunConfig,
    progress: &RenderProgress,
    on_tile: Option<OnTile<'_>>,
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
    let layers = if run.layers { scene.layers() } else { &[] };
    let shared = Mutex::new(Shared {
        film: Film::new(region, layers),
        counts: SampleCounts::default(),
        first_tile_seconds: None,
    });
    let tiles = region.tiles(TILE_SIDE);
    // Hands out every tile once; a worker that returns `None` was cancelled.
    let for_each_tile = |work: &(dyn Fn(Region) -> Option<()> + Sync)| {
        let next_tile = AtomicUsize::new(0);
        pool.broadcast(|_| {
            while let Some(&tile) = tiles.get(next_tile.fetch_add(1, Ordering::Relaxed)) {
                if work(tile).is_none() {
                    return;
                }
            }
        });
        !run.cancel.is_cancelled()
    };

    if let Some(on_tile) = on_tile
        && run.coarse_first
    {
        for_each_tile(&|tile| {
            let rgb = coarse_tile(scene, tile, &run.cancel)?;
            on_tile(&TilePixels {
                region: tile,
                rgb: &rgb,
                layers: &[],
            });
            Some(())
        });
    }
    for samples in passes(settings.samples_per_pixel) {
        let completed = for_each_tile(&|tile| {
            let block = sample_tile(scene, tile, samples.clone(), layers, run, progress)?;
            let mut shared = shared.lock().expect("no thread panicked");
            shared.add(tile, &block, samples.len(), started);
            if let Some(on_tile) = on_tile {
                let means = shared.film.means(tile);
                drop(shared);
                on_tile(&TilePixels {
                    region: tile,
                    rgb: &means[0],
                    layers: &means[1..],
                });
            }
            Some(())
        });
        if !completed {
            return None;
        }
    }

    let Shared {
        film,
        counts,
        first_tile_seconds,
    } = shared.into_inner().expect("no thread panicked");
    Some(RenderOutcome {
        image: film.image(),
        layers: film.layer_images(),
        stats: RenderStats {
            render_seconds: started.elapsed().as_secs_f64(),
            first_tile_seconds: first_tile_seconds.unwrap_or_default(),
            threads,
            rays: counts.rays,
            non_finite_samples: counts.non_finite,
            clamped: counts.clamped(),
        },
    })
}

/// The samples of each pass.
fn passes(samples_per_pixel: u32) -> impl Iterator<Item = Range<u32>> {
    let mut start = 0;
    std::iter::from_fn(move || {
        let size = start.clamp(1, MOST_SAMPLES_PER_PASS);
        let pass = start..samples_per_pixel.min(start + size);
        start = pass.end;
        (!pass.is_empty()).then_some(pass)
    })
}

/// What the threads of a render add to.
struct Shared {
    film: Film,
    counts: SampleCounts,
    first_tile_seconds: Option<f64>,
}

impl Shared {
    /// Takes in a tile.
    fn add(&mut self, tile: Region, block: &TileBlock, samples: usize, started: Instant) {
        let samples = u32::try_from(samples).expect("a pass is short");
        self.film.add(tile, &block.sums, samples);
        self.counts.add(&block.counts);
        self.first_tile_seconds
            .get_or_insert_with(|| started.elapsed().as_secs_f64());
    }
}

/// What is counted about samples.
#[derive(Clone, Copy, Debug, Default)]
struct SampleCounts {
    rays: RayCounts,
    non_finite: u64,
    clamped: u64,
    /// Luminance of all samples, and of what clamping took from them.
    luminance: f64,
    removed: f64,
}

impl SampleCounts {
    fn add(&mut self, other: &Self) {
        self.rays.add(&other.rays);
        self.non_finite += other.non_finite;
        self.clamped += other.clamped;
        self.luminance += other.luminance;
        self.removed += other.removed;
    }

    fn clamped(&self) -> Clamped {
        Clamped {
            samples: self.clamped,
            energy_share: if self.removed > 0.0 {
                self.removed / self.luminance
            } else {
                0.0
            },
        }
    }

    /// Scales a sample down to `most` in its brightest channel, and keeps account of what that removes.
    fn clamp(&mut self, sample: &mut Gathered, most: f32) {
        let before = f64::from(luminance(sample.radiance));
        self.luminance += before;
        let brightest = sample.radiance.max_element();
        if brightest > most {
            sample.scale(most / brightest);
            self.clamped += 1;
            self.removed += before - f64::from(luminance(sample.radiance));
        }
    }
}

/// One pass over one tile.
struct TileBlock {
    sums: TileSums,
    counts: SampleCounts,
}

/// Sums `samples` of every pixel of `tile`; `None` when cancelled.
fn sample_tile(
    scene: &PreparedScene,
    tile: Region,
    samples: Range<u32>,
    layers: &[Layer],
    run: &RunConfig,
    progress: &RenderProgress,
) -> Option<TileBlock> {
    let mut sums = TileSums::new(layers, tile.pixel_count());
    let mut counts = SampleCounts::default();
    for block in tile.cut(PACKET_SIDE) {
        let traced_before = counts.rays.total();
        let mut pixels = [(0, 0); Packet::MOST_RAYS];
        let count = block.pixel_count();
        for (pixel, number) in pixels.iter_mut().zip(0..) {
            *pixel = (
                block.x + number % block.width,
                block.y + number / block.width,
            );
        }
        let pixels = &pixels[..count];
        for index in samples.clone() {
            let begun = scene.camera_samples(pixels, index);
            for (&(x, y), begun) in pixels.iter().zip(begun.iter().flatten()) {
                if run.cancel.is_cancelled() {
                    return None;
                }
                let mut sample = scene.gathered(begun, &mut counts.rays);
                counts.non_finite += u64::from(!sample.radiance.is_finite());
                if let Some(most) = scene.clamp() {
                    counts.clamp(&mut sample, most);
                }
                let place = (y - tile.y) * tile.width + x - tile.x;
                sums.add(place as usize, layers, &sample);
            }
        }
        progress
            .samples
            .advance(count as u64 * samples.len() as u64);
        progress
            .rays
            .fetch_add(counts.rays.total() - traced_before, Ordering::Relaxed);
    }
    Some(TileBlock { sums, counts })
}

/// A picture of `tile` from the first sample of the middle pixel of each block; `None` when cancelled.
fn coarse_tile(scene: &PreparedScene, tile: Region, cancel: &CancelToken) -> Option<Vec<[f32; 3]>> {
    let width = tile.width as usize;
    let mut rgb = vec![[0.0; 3]; tile.pixel_count()];
    for top in (0..tile.height).step_by(COARSE_BLOCK as usize) {
        for left in (0..tile.width).step_by(COARSE_BLOCK as usize) {
            if cancel.is_cancelled() {
                return None;
            }
            let (right, bottom) = (
                tile.width.min(left + COARSE_BLOCK),
                tile.height.min(top + COARSE_BLOCK),
            );
            let (x, y) = (
                tile.x + u32::midpoint(left, right - 1),
                tile.y + u32::midpoint(top, bottom - 1),
            );
            let [begun, ..] = scene.camera_samples(&[(x, y)], 0);
            let begun = begun.expect("there is one pixel");
            let sample = scene.gathered(&begun, &mut RayCounts::default());
            for row in top..bottom {
                let start = row as usize * width;
                rgb[start + left as usize..start + right as usize].fill(sample.radiance.to_array());
            }
        }
    }
    Some(rgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn passes_grow_and_cover_every_sample_once() {
        let sizes = |samples| passes(samples).map(|pass| pass.len()).collect::<Vec<_>>();
        assert_eq!(sizes(1), [1]);
        assert_eq!(sizes(7), [1, 1, 2, 3]);
        assert_eq!(sizes(50), [1, 1, 2, 4, 8, 16, 16, 2]);
        let covered: Vec<u32> = passes(100).flatten().collect();
        assert_eq!(covered, (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn what_clamping_removes_is_accounted_for() {
        let mut counts = SampleCounts::default();
        for value in [1.0, 3.0, 10.0] {
            let mut sample = Gathered::seen(Vec3::splat(value));
            counts.clamp(&mut sample, 4.0);
            assert!((sample.radiance.x - value.min(4.0)).abs() < 1e-6);
        }
        let Clamped {
            samples,
            energy_share,
        } = counts.clamped();
        assert_eq!(samples, 1);
        assert!((energy_share - 6.0 / 14.0).abs() < 1e-6);
    }
}
