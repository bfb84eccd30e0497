//! Pictures too large to be held while they are rendered, in parts.

use super::Image;
use super::error::{ErrorEstimate, Interval};
use super::memory::PictureMemory;
use super::prepare::PreparedScene;
use super::progress::RenderProgress;
use super::run::{Clamped, Ending, RenderOutcome, RenderStats, RunConfig, render};
use super::tiles::Region;
use crate::math::color::luminance;

/// The most memory a picture may take and still be rendered at once, in bytes.
const LARGEST_AT_ONCE: u64 = 1 << 32;

/// The most memory a band may take while it is rendered, in bytes.
const BAND_BYTES: u64 = 1 << 29;

/// A picture that is rendered in bands from the top down, each of them whole before the next begins, so that only one has its
/// sums in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bands {
    region: Region,
    parts: Vec<Region>,
}

impl Bands {
    /// The bands of `region`, or of the whole picture; `None` where that is small enough to be rendered at once, or cannot be divided:
    /// where noise or time ends the render, as what a pixel gets then depends on the whole, or layers are kept.
    #[must_use]
    pub fn of(scene: &PreparedScene, region: Option<Region>, run: &RunConfig) -> Option<Self> {
        let settings = scene.settings();
        let region = region.unwrap_or(Region::full(settings.width, settings.height));
        let whole = PictureMemory::of_render(scene, Some(region), run);
        let is_possible =
            settings.stop.noise.is_none() && settings.stop.seconds.is_none() && !run.layers;
        (is_possible && whole.bytes() > LARGEST_AT_ONCE).then(|| {
            let count = whole.bytes().div_ceil(BAND_BYTES);
            let count = u32::try_from(count).unwrap_or(u32::MAX).min(region.height);
            Self::cut(region, region.height.div_ceil(count))
        })
    }

    fn cut(region: Region, rows: u32) -> Self {
        let tops = (0..region.height).step_by(rows as usize);
        let part = |top: u32| Region {
            y: region.y + top,
            height: rows.min(region.height - top),
            ..region
        };
        Self {
            region,
            parts: tops.map(part).collect(),
        }
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Bytes at any time: one band, and the picture.
    #[must_use]
    pub fn memory(&self, scene: &PreparedScene, run: &RunConfig) -> PictureMemory {
        let largest = self.parts.iter().max_by_key(|part| part.pixel_count());
        PictureMemory::of_render(scene, largest.copied(), run).beside(self.region)
    }

    /// [`render`] band by band: the same pixels. `begin` is asked for a place to tell the progress of each band. A render that is
    /// interrupted leaves the rest black, with no samples. The error is that of all pixels as far as the bands tell: its interval is no
    /// narrower than theirs, and its percentile that of the worst. `None` when cancelled.
    #[must_use]
    pub fn render(
        &self,
        scene: &PreparedScene,
        run: &RunConfig,
        mut begin: impl FnMut() -> RenderProgress,
    ) -> Option<RenderOutcome> {
        let mut image = Image::black(self.region.width, self.region.height);
        let mut all = Merged::default();
        for part in &self.parts {
            let outcome = render(scene, Some(*part), run, &begin(), None)?;
            let inside = Region {
                x: 0,
                y: part.y - self.region.y,
                ..*part
            };
            inside.copy_into(&outcome.image.pixels, &mut image);
            all.add(&outcome);
            if outcome.stats.ending == Ending::Interrupted {
                break;
            }
        }
        Some(RenderOutcome {
            stats: all.stats(self.region.pixel_count()),
            image,
            layers: Vec::new(),
            errors: Vec::new(),
        })
    }
}

/// The statistics of several renders as those of one.
#[derive(Default)]
struct Merged {
    stats: RenderStats,
    pixels: f64,
    samples: f64,
    /// Sums over pixels; `None` where there is no estimate.
    error: Option<ErrorSums>,
    /// Luminance that is in the picture, and that clamping took.
    kept: f64,
    removed: f64,
}

/// The value and the ends of each interval, summed over pixels.
#[derive(Clone, Copy, Default)]
struct ErrorSums {
    mse: [f64; 3],
    relmse: [f64; 3],
    percentile_999: [f64; 3],
    unmeasured_pixels: u64,
}

impl Merged {
    fn add(&mut self, outcome: &RenderOutcome) {
        let stats = &outcome.stats;
        let pixels = outcome.image.pixels.len() as f64;
        let (before, is_first) = (self.stats, self.pixels == 0.0);
        let mut rays = before.rays;
        rays.add(&stats.rays);
        self.stats = RenderStats {
            render_seconds: before.render_seconds + stats.render_seconds,
            cpu_seconds: before.cpu_seconds + stats.cpu_seconds,
            first_tile_seconds: if is_first {
                stats.first_tile_seconds
            } else {
                before.first_tile_seconds
            },
            rays,
            samples: before.samples + stats.samples,
            sample_range: if is_first {
                stats.sample_range
            } else {
                [
                    before.sample_range[0].min(stats.sample_range[0]),
                    before.sample_range[1].max(stats.sample_range[1]),
                ]
            },
            non_finite_samples: before.non_finite_samples + stats.non_finite_samples,
            negative_samples: before.negative_samples + stats.negative_samples,
            depth_limited_samples: before.depth_limited_samples + stats.depth_limited_samples,
            clamped: Clamped {
                samples: before.clamped.samples + stats.clamped.samples,
                energy_share: 0.0,
            },
            ..*stats
        };
        let error = stats.error.map(|error| {
            let sums = if is_first {
                Some(ErrorSums::default())
            } else {
                self.error
            };
            sums.map(|sums| sums.and(&error, pixels))
        });
        self.error = error.flatten();
        let light: f64 = outcome
            .image
            .pixels
            .iter()
            .map(|&rgb| f64::from(luminance(rgb.into())))
            .sum();
        let share = stats.clamped.energy_share;
        self.kept += light * stats.samples_per_pixel;
        self.removed += light * stats.samples_per_pixel * share / (1.0 - share);
        self.pixels += pixels;
        self.samples += stats.samples_per_pixel * pixels;
    }

    /// The statistics of a picture of `pixels` pixels; those that were not added have no samples.
    fn stats(self, pixels: usize) -> RenderStats {
        let pixels = pixels as f64;
        let mut stats = self.stats;
        stats.samples_per_pixel = self.samples / pixels;
        if self.pixels < pixels {
            stats.sample_range[0] = 0;
        }
        if self.removed > 0.0 {
            stats.clamped.energy_share = self.removed / (self.kept + self.removed);
        }
        stats.error = self.error.map(|sums| ErrorEstimate {
            samples_per_pixel: stats.samples_per_pixel,
            rmse: mean(sums.mse, self.pixels).sqrt(),
            relmse: mean(sums.relmse, self.pixels),
            percentile_999: mean(sums.percentile_999, 1.0),
            unmeasured_pixels: sums.unmeasured_pixels,
        });
        stats
    }
}

impl ErrorSums {
    fn and(self, error: &ErrorEstimate, pixels: f64) -> Self {
        let ends = |interval: Interval| [interval.value, interval.low, interval.high];
        let squares = ends(error.rmse).map(|rmse| rmse * rmse);
        let add = |sums: [f64; 3], more: [f64; 3]| [0, 1, 2].map(|i| sums[i] + more[i] * pixels);
        Self {
            mse: add(self.mse, squares),
            relmse: add(self.relmse, ends(error.relmse)),
            percentile_999: worst(self.percentile_999, ends(error.percentile_999)),
            unmeasured_pixels: self.unmeasured_pixels + error.unmeasured_pixels,
        }
    }
}

/// The larger of each.
fn worst(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i].max(b[i]))
}

fn mean(sums: [f64; 3], pixels: f64) -> Interval {
    let [value, low, high] = sums.map(|sum| sum / pixels);
    Interval { value, low, high }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::CancelToken;
    use crate::io;

    #[test]
    fn bands_are_the_picture() {
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = (40, 30);
        scene.render.samples_per_pixel = 8;
        scene.render.clamp = Some(0.5);
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let prepared = prepared.expect("can be rendered").expect("nobody cancels");
        let run = RunConfig::default();
        assert_eq!(Bands::of(&prepared, None, &run), None);
        for region in [
            Region::full(40, 30),
            Region {
                x: 5,
                y: 7,
                width: 21,
                height: 17,
            },
        ] {
            let whole = render(
                &prepared,
                Some(region),
                &run,
                &RenderProgress::default(),
                None,
            );
            let whole = whole.expect("nobody cancels");
            let bands = Bands::cut(region, 7);
            assert_eq!(bands.count(), region.height.div_ceil(7) as usize);
            let parts = bands.render(&prepared, &run, RenderProgress::default);
            let parts = parts.expect("nobody cancels");
            assert_eq!(parts.image, whole.image);
            let (a, b) = (&parts.stats, &whole.stats);
            assert_eq!((a.rays, a.sample_range), (b.rays, b.sample_range));
            assert_eq!(
                (a.samples_per_pixel, a.passes),
                (b.samples_per_pixel, b.passes)
            );
            assert_eq!(a.depth_limited_samples, b.depth_limited_samples);
            assert_eq!(a.clamped.samples, b.clamped.samples);
            let lost = a.clamped.energy_share / b.clamped.energy_share;
            assert!((lost - 1.0).abs() < 1e-5 && b.clamped.samples > 0, "{lost}");
            // Laws are found by each band alone; what has moved is the same in all.
            let (a, b) = (
                a.error.expect("is estimated"),
                b.error.expect("is estimated"),
            );
            let ratio = a.rmse.value / b.rmse.value;
            assert!((ratio - 1.0).abs() < 0.3, "{ratio}");
        }
    }

    #[test]
    fn the_largest_picture_takes_less_than_4_gigabytes_in_bands() {
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = (16_384, 16_384);
        for samples in [1, 16] {
            scene.render.samples_per_pixel = samples;
            let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
            let prepared = prepared.expect("can be rendered").expect("nobody cancels");
            let run = RunConfig::default();
            let whole = PictureMemory::of_render(&prepared, None, &run).bytes();
            let bands = Bands::of(&prepared, None, &run).expect("is rendered in bands");
            let bytes = bands.memory(&prepared, &run).bytes();
            assert!(bytes <= 4_000_000_000 && bytes <= whole / 2, "{bytes}");
            // What a picture with a stop or layers takes is that of the whole.
            let layers = RunConfig {
                layers: true,
                ..RunConfig::default()
            };
            assert_eq!(Bands::of(&prepared, None, &layers), None);
        }
    }

    #[test]
    fn what_was_not_rendered_has_no_samples() {
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = (8, 8);
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let prepared = prepared.expect("can be rendered").expect("nobody cancels");
        let run = RunConfig::default();
        run.interrupt.cancel();
        let bands = Bands::cut(Region::full(8, 8), 4);
        let outcome = bands.render(&prepared, &run, RenderProgress::default);
        let stats = outcome.expect("nobody cancels").stats;
        assert_eq!(
            (stats.ending, stats.sample_range[0]),
            (Ending::Interrupted, 0)
        );
    }
}
