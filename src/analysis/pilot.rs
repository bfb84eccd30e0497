//! How long a render will take, by some tiles of it that are rendered before: on all its threads at once, as it will be, and for
//! a fraction of a second.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use crate::control::CancelToken;
use crate::render::{Interval, PreparedScene, Region, RenderProgress, RunConfig, Sight, render};
use crate::scene::{RenderSettings, Scene, SceneError, Stop};

/// How long tiles are rendered for.
const TIME: Duration = Duration::from_millis(300);
/// How long a small picture is rendered for where the render is to stop at a noise.
const NOISE_SECONDS: f64 = 0.4;
/// Tiles that take less than this are replaced by larger ones, as starting a render would count among their time, in seconds.
const SHORT_TILE: f64 = 2e-3;
/// Pixels of the small picture about: fewer tell too little of its noise.
const NOISE_PIXELS: f64 = 4096.0;
/// What the estimate of the error takes, as a share of the rest: `raymini plan` measures 3 to 10 per cent.
const ERROR_SHARE: f64 = 0.05;
/// Samples of a pixel that a render which stops at a noise takes at least.
const LEAST_FORESEEN: f64 = 16.0;
/// However well the tiles agree, a render may take so much longer or shorter: other programs come and go.
const LEAST_DOUBT: f64 = 0.1;

/// How long a render will take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeEstimate {
    /// In seconds, without preparing the scene, as long as no other program needs the processor.
    pub seconds: Interval,
    /// Whether it may well be done sooner: it stops at a noise that a small picture did not come near enough to, to tell when.
    pub is_bound: bool,
    /// Samples of a pixel that it is for, on average.
    pub samples: f64,
}

impl TimeEstimate {
    /// As long as the same render took before, for so many samples of a pixel on average.
    #[must_use]
    pub fn as_before(time: Duration, samples: f64) -> Self {
        Self {
            seconds: exactly(time.as_secs_f64()),
            is_bound: false,
            samples,
        }
    }
}

/// Tiles of one kind.
#[derive(Clone, Copy, Debug)]
struct Grain {
    /// In pixels.
    side: u32,
    /// The most samples of a pixel.
    samples: u32,
    /// How long they are rendered.
    time: Duration,
}

/// Small tiles tell most of how a picture differs from place to place, where they take long enough.
const FINE: Grain = Grain {
    side: 8,
    samples: 4,
    time: TIME,
};
/// As many samples as a pass takes: they cost what those of the render do.
const COARSE: Grain = Grain {
    side: 16,
    samples: 16,
    time: TIME,
};
/// A few of the small ones tell which to take.
const PROBE: Grain = Grain {
    time: Duration::from_millis(30),
    ..FINE
};

/// What the tiles of a pilot took.
#[derive(Clone, Copy, Debug, Default)]
struct Tiles {
    count: f64,
    /// Their pixels and samples.
    pixels: f64,
    samples: f64,
    /// Sums over the tiles of the seconds of a sample and of their squares.
    seconds: f64,
    squares: f64,
}

/// Estimates what rendering `region` of `scene`, or all of it, takes on so many threads as `run` says. `prepared`: what was prepared of
/// the scene; its triangles and tree are used. `None` when cancelled.
///
/// # Errors
/// What about the description cannot be rendered.
pub fn estimate_time(
    scene: &Scene,
    prepared: &PreparedScene,
    region: Option<Region>,
    run: &RunConfig,
) -> Result<Option<TimeEstimate>, SceneError> {
    let settings = &scene.render;
    let region = region.unwrap_or(Region::full(settings.width, settings.height));
    let cancel = &run.cancel;
    let threads = run.thread_count();
    let tiles_of = |grain| render_tiles(scene, prepared, region, threads, grain, cancel);
    let Some(probe) = tiles_of(PROBE)? else {
        return Ok(None);
    };
    let is_short = probe.mean_seconds_of_a_tile() < SHORT_TILE;
    let grain = if is_short { COARSE } else { FINE };
    let Some(tiles) = tiles_of(grain)? else {
        return Ok(None);
    };
    let mut per_sample = tiles.seconds_per_sample(region);
    if settings.measures_error() {
        let Interval { value, low, high } = &mut per_sample;
        for seconds in [value, low, high] {
            *seconds *= 1.0 + ERROR_SHARE;
        }
    }
    let of_samples = |samples: Interval| {
        let pixels = region.pixel_count() as f64 / threads as f64;
        Interval {
            value: per_sample.value * samples.value * pixels,
            low: per_sample.low * samples.low * pixels,
            high: per_sample.high * samples.high * pixels,
        }
    };
    let most = f64::from(settings.samples_per_pixel);
    let mut estimate = TimeEstimate {
        seconds: of_samples(exactly(most)),
        is_bound: settings.stop.noise.is_some(),
        samples: most,
    };
    if settings.stop.noise.is_some() {
        let samples = samples_to_stop(scene, prepared, run)?;
        if cancel.is_cancelled() {
            return Ok(None);
        }
        if let Some(samples) = samples {
            estimate = TimeEstimate {
                seconds: of_samples(samples),
                is_bound: false,
                samples: samples.value,
            };
        }
    }
    if let Some(limit) = settings.stop.seconds {
        let Interval { value, low, high } = estimate.seconds;
        estimate.is_bound &= value < limit;
        estimate.seconds = Interval {
            value: value.min(limit),
            low: low.min(limit),
            high: high.min(limit),
        };
    }
    Ok(Some(estimate))
}

/// How long a render runs before [`foreseeing`] looks ahead for it: a short one knows sooner by itself.
const FORESEEING_AFTER: Duration = Duration::from_secs(1);

/// Does `work`, which is to render `region` of `scene` and tell `progress` of it. Where it stops at a noise, and nothing is known of that after a
/// second, a small picture tells meanwhile about how many samples that takes. `prepared`: the scene as it is rendered.
pub fn foreseeing<T>(
    scene: &Scene,
    prepared: &PreparedScene,
    region: Region,
    progress: &RenderProgress,
    work: impl FnOnce() -> T,
) -> T {
    if scene.render.stop.noise.is_none() {
        return work();
    }
    let run = RunConfig {
        threads: 1,
        ..RunConfig::default()
    };
    let look_ahead = |over: &Receiver<()>| {
        let is_over = over.recv_timeout(FORESEEING_AFTER) != Err(RecvTimeoutError::Timeout);
        if is_over || progress.sight() != Sight::Bound {
            return;
        }
        // What is wrong with the scene is told by who renders it.
        if let Ok(Some(samples)) = samples_to_stop(scene, prepared, &run) {
            let least = LEAST_FORESEEN.min(f64::from(scene.render.samples_per_pixel));
            let samples = samples.value.max(least) * region.pixel_count() as f64;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a number of samples"
            )]
            progress.expect_samples(samples as u64);
        }
    };
    std::thread::scope(|scope| {
        let (sender, over) = channel();
        // Also where the work panics: the scope waits for its thread.
        let ending = EndWhenDropped(&run.cancel, sender);
        let ahead = scope.spawn(move || look_ahead(&over));
        let done = work();
        drop(ending);
        // Where the program fails in it, nothing is known of the samples.
        let _ = ahead.join();
        done
    })
}

/// Cancels a token when it goes, and wakes whoever waits for that.
struct EndWhenDropped<'a>(&'a CancelToken, Sender<()>);

impl Drop for EndWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.cancel();
        // Whoever does not wait any more is over too.
        let _ = self.1.send(());
    }
}

fn exactly(value: f64) -> Interval {
    Interval {
        value,
        low: value,
        high: value,
    }
}

/// Renders tiles all over `region` of `scene`, each on one of `threads` threads, until the time is up; `None` when cancelled.
fn render_tiles(
    scene: &Scene,
    prepared: &PreparedScene,
    region: Region,
    threads: usize,
    grain: Grain,
    cancel: &CancelToken,
) -> Result<Option<Tiles>, SceneError> {
    let mut short = scene.clone();
    short.render.stop = Stop::default();
    short.render.samples_per_pixel = scene.render.samples_per_pixel.min(grain.samples);
    // What that takes for a tile is much more than a tile's share of what it takes for the picture.
    short.render.error_estimate = false;
    let Some(short) = PreparedScene::prepare(&short, Some(prepared), cancel)? else {
        return Ok(None);
    };
    let started = Instant::now();
    let next = AtomicU32::new(0);
    let tiles = Mutex::new(Tiles::default());
    let render_some = || {
        let run = RunConfig {
            threads: 1,
            cancel: cancel.clone(),
            ..RunConfig::default()
        };
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let tile = tile(region, grain.side, number);
            let progress = RenderProgress::default();
            let Some(outcome) = render(&short, Some(tile), &run, &progress, None) else {
                return;
            };
            // Processor time: what else runs holds up many short renders more than a long one.
            let seconds = outcome.stats.cpu_seconds / outcome.stats.samples as f64;
            let mut tiles = tiles.lock().expect("no thread panicked");
            tiles.count += 1.0;
            tiles.samples += outcome.stats.samples as f64;
            tiles.pixels += tile.pixel_count() as f64;
            tiles.seconds += seconds;
            tiles.squares += seconds * seconds;
            if started.elapsed() > grain.time {
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(render_some);
        }
    });
    let tiles = tiles.into_inner().expect("no thread panicked");
    Ok((!cancel.is_cancelled()).then_some(tiles))
}

/// Tile `number` of those spread evenly over `region`, however many they become.
///
/// Source: Roberts, The Unreasonable Effectiveness of Quasirandom Sequences (2018): the R2 sequence.
fn tile(region: Region, side: u32, number: u32) -> Region {
    const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053_3];
    let place = |step: f64, start: u32, length: u32| {
        let side = side.min(length);
        let share = (0.5 + f64::from(number) * step).fract();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the region"
        )]
        let offset = (share * f64::from(length - side + 1)) as u32;
        (start + offset, side)
    };
    let (x, width) = place(STEPS[0], region.x, region.width);
    let (y, height) = place(STEPS[1], region.y, region.height);
    Region {
        x,
        y,
        width,
        height,
    }
}

impl Tiles {
    fn mean_seconds_of_a_tile(&self) -> f64 {
        self.seconds * self.samples / (self.count * self.count)
    }

    /// The mean, and where that of all tiles of `region` lies.
    fn seconds_per_sample(&self, region: Region) -> Interval {
        let mean = self.seconds / self.count;
        let variance = (self.squares / self.count - mean * mean).max(0.0);
        // Those that were rendered leave no doubt about themselves.
        let left = (1.0 - self.pixels / region.pixel_count() as f64).max(0.0);
        let deviation = (variance / (self.count - 1.0).max(1.0) * left).sqrt();
        // Of few of them the deviation itself is in doubt.
        let few = 1.0 + 3.0 / self.count;
        let doubt = (2.0 * few * deviation / mean).clamp(LEAST_DOUBT, 0.9);
        Interval {
            value: mean,
            low: mean * (1.0 - doubt),
            high: mean * (1.0 + doubt),
        }
    }
}

/// Samples of a pixel until the noise is low enough for `scene` to stop, by a small picture of it; `None` where that cannot be
/// told, or when cancelled.
fn samples_to_stop(
    scene: &Scene,
    prepared: &PreparedScene,
    run: &RunConfig,
) -> Result<Option<Interval>, SceneError> {
    let mut small = scene.clone();
    let shrunk = (NOISE_PIXELS / scene.render.pixel_count() as f64)
        .sqrt()
        .min(1.0);
    let side = |side: u32| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a smaller side"
        )]
        let side = (f64::from(side) * shrunk).ceil() as u32;
        side.max(1)
    };
    let RenderSettings { width, height, .. } = scene.render;
    (small.render.width, small.render.height) = (side(width), side(height));
    small.render.stop.seconds = Some(NOISE_SECONDS);
    let Some(small) = PreparedScene::prepare(&small, Some(prepared), &run.cancel)? else {
        return Ok(None);
    };
    let Some(outcome) = render(&small, None, run, &RenderProgress::default(), None) else {
        return Ok(None);
    };
    let taken = outcome.stats.samples_per_pixel;
    let most = f64::from(scene.render.samples_per_pixel);
    let target = scene.render.stop.noise.unwrap_or_default();
    let reached = outcome.stats.error.map(|error| error.noise());
    Ok(match outcome.errors.last() {
        _ if reached.is_some_and(|noise| noise.value <= target) => Some(exactly(taken)),
        Some(point) => point.time_to_stop.map(|seconds| {
            let samples = |seconds: f64| (taken * seconds / point.seconds).clamp(taken, most);
            Interval {
                value: samples(seconds.value),
                low: samples(seconds.low),
                high: samples(seconds.high),
            }
        }),
        None => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_in_the_region_and_all_over_it() {
        let region = Region {
            x: 7,
            y: 3,
            width: 100,
            height: 9,
        };
        let mut columns = [false; 4];
        for number in 0..64 {
            let tile = tile(region, 16, number);
            assert!(tile.x >= 7 && tile.x + tile.width <= 107 && tile.width == 16);
            assert_eq!((tile.y, tile.height), (3, 9));
            columns[((tile.x - 7) / 22) as usize] = true;
        }
        assert_eq!(columns, [true; 4]);
    }

    #[test]
    fn the_mean_is_the_surer_the_more_tiles_there_are() {
        let doubt = |count: f64| {
            // Half of them take three times as long as the others.
            let tiles = Tiles {
                count,
                pixels: count,
                samples: count,
                seconds: count * 2.0,
                squares: count * 5.0,
            };
            let Interval { value, low, high } = tiles.seconds_per_sample(Region::full(4096, 4096));
            assert_eq!(value, 2.0);
            assert!((low + high - 4.0).abs() < 1e-12);
            high - value
        };
        assert!(doubt(10.0) > 2.0 * doubt(100.0));
        assert!((doubt(1e5) - 0.2).abs() < 1e-12, "never surer than that");
        let all = Tiles {
            count: 4.0,
            pixels: 1024.0,
            samples: 1024.0,
            seconds: 8.0,
            squares: 20.0,
        };
        let known = all.seconds_per_sample(Region::full(32, 32));
        assert!((known.high - 2.2).abs() < 1e-12, "all tiles are known");
    }
}
