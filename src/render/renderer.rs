//! A render that is going on: which pass comes next, and when it is enough.
//!
//! At first all pixels get the same number of samples, in passes that end at powers of two and in the middle between them. A
//! render that may stop early then doubles the samples of those pixels where that helps most, in rounds: passes over the selected
//! pixels until each has its double. What is decided, is decided at the end of a round, from the film alone, so that the
//! picture does not depend on threads; only a stop by time depends on the clock.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};

use super::clock::Clock;
use super::error::{Allotment, ErrorEstimator, Forecast, Outlook};
use super::film::{Film, block_after};
use super::layers::Layer;
use super::prepare::PreparedScene;
use super::progress::{ErrorPoint, NOISE_TARGETS, RenderProgress};
use super::run::{Ending, RenderOutcome, RenderStats, Round, RunConfig, Watch};
use super::tile_samples::{SampleCounts, TileBlock, Work, coarse_tile, sample_tile};
use super::tiles::{Region, TilePixels};
use crate::scene::RenderSettings;

/// Side of a tile in pixels: small enough to balance two threads to the end, large enough that handing one out costs nothing.
const TILE_SIDE: u32 = 32;

/// Most samples of a pixel that are summed before they meet the film. Passes grow to this size, so that a whole picture is soon
/// there. Their sizes are part of the picture's definition: they fix the order of additions.
const MOST_SAMPLES_PER_PASS: u32 = 16;

/// The same where only some pixels get samples: there, the picture is already there, and short passes make threads wait.
const MOST_SAMPLES_PER_ROUND_PASS: u32 = 64;

/// What every pixel gets before a render stops for its noise, or gives some pixels more than others: from fewer, what is rare
/// would be taken for absent.
const LEAST_SAMPLES: u32 = 16;

/// By how much the samples must have grown until the error is noted again.
const NOTE_GROWTH: f64 = 1.06;

/// The share of the samples so far that are handed out before it is looked again where they belong.
const ROUND_SHARE: f64 = 0.5;

/// See the module's description.
pub struct Renderer<'a> {
    scene: &'a PreparedScene,
    settings: &'a RenderSettings,
    run: &'a RunConfig,
    progress: &'a RenderProgress,
    watch: Watch<'a>,
    tiles: Vec<Region>,
    layers: &'a [Layer],
    shared: Mutex<Shared>,
    /// `None` where the error is not asked for.
    estimator: Option<ErrorEstimator>,
    /// Where samples belong; `None` where all pixels get the same number, and before there is an estimate.
    allotment: Option<Allotment>,
    pool: rayon::ThreadPool,
    threads: usize,
    clock: Clock,
    passes: u32,
    /// Samples when the error was noted last.
    noted_samples: f64,
}

/// What the threads of a render add to.
struct Shared {
    film: Film,
    counts: SampleCounts,
    first_tile_seconds: Option<f64>,
}

/// What follows on samples of all pixels.
enum Next {
    End(Ending),
    ChoosePixels,
}

impl Shared {
    /// Takes in a tile.
    fn add(&mut self, tile: Region, block: &TileBlock, clock: &Clock) {
        self.film.add(tile, &block.sums);
        self.counts.add(&block.counts);
        self.first_tile_seconds
            .get_or_insert_with(|| clock.seconds());
    }
}

impl<'a> Renderer<'a> {
    /// Nothing rendered yet of `region`, which lies in the picture.
    pub fn new(
        scene: &'a PreparedScene,
        region: Region,
        run: &'a RunConfig,
        progress: &'a RenderProgress,
        watch: Watch<'a>,
    ) -> Self {
        let settings = scene.settings();
        let clock = Clock::start();
        let pixels = region.pixel_count();
        progress
            .samples
            .set_total(pixels as u64 * u64::from(settings.samples_per_pixel));
        let threads = run.thread_count();
        let layers = if run.layers { scene.layers() } else { &[] };
        Self {
            scene,
            settings,
            run,
            progress,
            watch,
            tiles: region.tiles(TILE_SIDE),
            layers,
            shared: Mutex::new(Shared {
                film: Film::new(region, layers, settings.measures_error()),
                counts: SampleCounts::default(),
                first_tile_seconds: None,
            }),
            estimator: settings
                .measures_error()
                .then(|| ErrorEstimator::new(pixels)),
            allotment: None,
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be started"),
            threads,
            clock,
            passes: 0,
            noted_samples: 0.0,
        }
    }

    /// Takes all samples; `None` when cancelled.
    pub fn render(&mut self) -> Option<Ending> {
        if self.run.coarse_first {
            self.deliver_coarse_picture()?;
        }
        match self.render_evenly()? {
            Next::End(ending) => Some(ending),
            Next::ChoosePixels => self.render_where_it_helps(),
        }
    }

    /// The picture and what it took.
    pub fn outcome(self, ending: Ending) -> RenderOutcome {
        let (seconds, cpu_seconds) = (self.clock.seconds(), self.clock.cpu_seconds());
        let Shared {
            film,
            counts,
            first_tile_seconds,
        } = self.shared.into_inner().expect("no thread panicked");
        let stats = RenderStats {
            render_seconds: seconds,
            cpu_seconds,
            first_tile_seconds: first_tile_seconds.unwrap_or_default(),
            threads: self.threads,
            rays: counts.rays,
            samples_per_pixel: film.mean_samples(),
            sample_range: film.sample_range(),
            passes: self.passes,
            ending,
            error: self.estimator.as_ref().and_then(ErrorEstimator::estimate),
            non_finite_samples: counts.non_finite,
            negative_samples: counts.negative,
            depth_limited_samples: counts.depth_limited,
            clamped: counts.clamped(),
        };
        let estimator = self.estimator.as_ref().filter(|_| self.run.layers);
        let errors = estimator.map(|estimator| (Layer::Error, estimator.image(&film)));
        let (image, mut layers) = film.into_images();
        layers.extend(errors);
        RenderOutcome {
            image,
            layers,
            stats,
            errors: self.progress.errors_from(0),
        }
    }

    /// Whether some pixels may get more samples than others.
    fn is_adaptive(&self) -> bool {
        let stop = &self.settings.stop;
        self.settings.adaptive
            && self.estimator.is_some()
            && (stop.noise.is_some() || stop.seconds.is_some())
    }

    /// Gives all pixels the same number of samples: all they may get, unless the time is up or the noise low enough before, or
    /// from some number on the error decides who gets more. `None` when cancelled.
    fn render_evenly(&mut self) -> Option<Next> {
        let most = self.settings.samples_per_pixel;
        let mut samples = 0;
        let mut seconds_per_sample = 0.0;
        while samples < most {
            let block = block_after(samples)
                .min(MOST_SAMPLES_PER_PASS)
                .min(most - samples);
            // The last pass takes what the clock leaves. A render of as many samples would end with the same pass.
            let taken = match samples {
                0 => block,
                _ => whole_below(self.time_left() / seconds_per_sample).min(block),
            };
            if taken == 0 {
                return Some(Next::End(Ending::Time));
            }
            let started = self.clock.seconds();
            self.pass(&Work {
                selected: None,
                begins_round: true,
                longest: taken,
                most,
            })?;
            if self.run.interrupt.is_cancelled() {
                return Some(Next::End(Ending::Interrupted));
            }
            seconds_per_sample = (self.clock.seconds() - started) / f64::from(taken);
            samples += taken;

            let is_round = samples.is_power_of_two();
            if is_round {
                self.update_estimate(None);
            } else if let Some(estimator) = &mut self.estimator {
                estimator.advance(samples);
            }
            self.tell(is_round);
            if is_round || samples == most {
                self.show_round();
            }
            if samples >= LEAST_SAMPLES && self.is_quiet() {
                return Some(Next::End(Ending::Noise));
            }
            if taken < block {
                return Some(Next::End(Ending::Time));
            }
            if self.has_all_passes() {
                return Some(Next::End(Ending::Samples));
            }
            if is_round && samples >= LEAST_SAMPLES && self.is_adaptive() {
                return Some(Next::ChoosePixels);
            }
        }
        Some(Next::End(Ending::Samples))
    }

    /// Doubles the samples of those pixels where it helps most, again and again; `None` when cancelled.
    fn render_where_it_helps(&mut self) -> Option<Ending> {
        let most = self.settings.samples_per_pixel;
        loop {
            let Some(selected) = self.select() else {
                return Some(Ending::Samples);
            };
            let mut work = Work {
                selected: Some(&selected),
                begins_round: true,
                longest: MOST_SAMPLES_PER_ROUND_PASS,
                most,
            };
            while work.has_pixels(&self.lock().film) {
                self.pass(&work)?;
                if self.run.interrupt.is_cancelled() {
                    return Some(Ending::Interrupted);
                }
                work.begins_round = false;
                if self.time_left() <= 0.0 || self.has_all_passes() {
                    break;
                }
            }
            self.update_estimate(Some(&selected));
            self.tell(true);
            self.show_round();
            if self.is_quiet() {
                return Some(Ending::Noise);
            }
            if self.time_left() <= 0.0 {
                return Some(Ending::Time);
            }
            if self.has_all_passes() {
                return Some(Ending::Samples);
            }
        }
    }

    /// The pixels that get samples next; `None` when none can get more.
    fn select(&self) -> Option<Vec<bool>> {
        let (allotment, estimator) = self.allotment.as_ref().zip(self.estimator.as_ref())?;
        let most = self.settings.samples_per_pixel;
        let film = &self.lock().film;
        let forecast = match (self.settings.stop.noise, estimator.estimate()) {
            (Some(noise), Some(error)) => {
                allotment.for_variance((noise * noise / error.relmse.value).min(1.0), most)
            }
            _ => Forecast::ALL,
        };
        let budget = (film.total_samples() as f64 * ROUND_SHARE).min(forecast.samples / 2.0);
        allotment.select(film, forecast, budget, most)
    }

    /// Whether the noise is as low as asked for.
    fn is_quiet(&self) -> bool {
        let estimate = self.estimator.as_ref().and_then(ErrorEstimator::estimate);
        let target = self.settings.stop.noise;
        target
            .zip(estimate)
            .is_some_and(|(noise, error)| error.relmse.value <= noise * noise)
    }

    fn has_all_passes(&self) -> bool {
        let passes = self.settings.stop.passes;
        passes.is_some_and(|passes| self.passes >= passes)
    }

    /// Seconds until the render is to stop.
    fn time_left(&self) -> f64 {
        let seconds = self.settings.stop.seconds;
        seconds.map_or(f64::INFINITY, |seconds| seconds - self.clock.seconds())
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().expect("no thread panicked")
    }

    /// Does `work` for every tile once, or for fewer tiles when interrupted; `None` when cancelled.
    fn for_each_tile(&self, work: &(dyn Fn(Region) -> Option<()> + Sync)) -> Option<()> {
        let next_tile = AtomicUsize::new(0);
        self.pool.broadcast(|_| {
            while let Some(&tile) = self.tiles.get(next_tile.fetch_add(1, Ordering::Relaxed)) {
                if self.run.interrupt.is_cancelled() || work(tile).is_none() {
                    return;
                }
            }
        });
        (!self.run.cancel.is_cancelled()).then_some(())
    }

    fn deliver_coarse_picture(&self) -> Option<()> {
        let Some(on_tile) = self.watch.on_tile else {
            return Some(());
        };
        self.for_each_tile(&|tile| {
            let rgb = coarse_tile(self.scene, tile, &self.run.cancel)?;
            on_tile(&TilePixels {
                region: tile,
                rgb: &rgb,
                layers: &[],
            });
            Some(())
        })
    }

    /// Takes one block of samples of every pixel that `work` names; `None` when cancelled.
    fn pass(&mut self, work: &Work<'_>) -> Option<()> {
        let this = &*self;
        this.for_each_tile(&|tile| {
            let samples = work.of_tile(&this.lock().film, tile);
            if samples.iter().all(|pixel| pixel.count == 0) {
                return Some(());
            }
            let block = sample_tile(
                this.scene,
                tile,
                &samples,
                this.layers,
                &this.run.cancel,
                this.progress,
            )?;
            let mut shared = this.lock();
            shared.add(tile, &block, &this.clock);
            if let Some(on_tile) = this.watch.on_tile {
                let means = shared.film.means(tile);
                drop(shared);
                on_tile(&TilePixels {
                    region: tile,
                    rgb: &means[0],
                    layers: &means[1..],
                });
            }
            Some(())
        })?;
        self.passes += 1;
        Some(())
    }

    /// Estimates the error anew, after the pixels, those `selected` or all, have doubled their samples.
    fn update_estimate(&mut self, selected: Option<&[bool]>) {
        let is_adaptive = self.is_adaptive();
        let Some(estimator) = &mut self.estimator else {
            return;
        };
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        self.allotment = self.pool.install(|| {
            estimator.update(film, selected);
            (is_adaptive && film.mean_samples() * 2.0 >= f64::from(LEAST_SAMPLES))
                .then(|| Allotment::new(film, estimator))
        });
    }

    /// Tells whoever watches how wrong the picture is, and how much there is to do. After a round it always does, else where the
    /// samples have grown enough.
    fn tell(&mut self, is_round: bool) {
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        let (samples, pixels) = (film.total_samples() as f64, film.pixels() as f64);
        let most = self.settings.samples_per_pixel;
        let seconds = self.clock.seconds();
        // As far as is known now, the render ends after so many samples.
        let mut total = pixels * f64::from(most);
        if let Some(limit) = self.settings.stop.seconds {
            total = total.min((samples * limit / seconds).max(samples));
        }
        if let Some(estimator) = &self.estimator
            && let Some(error) = estimator.estimate()
        {
            let outlook = Outlook {
                estimator,
                allotment: self.allotment.as_ref(),
                samples,
                seconds,
            };
            let noise = self.settings.stop.noise;
            let to_stop = noise.and_then(|noise| outlook.samples_to(noise, most));
            if let Some(to_stop) = to_stop {
                total = total.min(to_stop.value);
            } else if self.is_quiet() {
                total = samples.max(pixels * f64::from(LEAST_SAMPLES.min(most)));
            }
            if is_round || samples >= self.noted_samples * NOTE_GROWTH {
                self.progress.note(ErrorPoint {
                    seconds,
                    cpu_seconds: self.clock.cpu_seconds(),
                    error,
                    time_to: NOISE_TARGETS.map(|noise| outlook.time_to(noise)),
                    time_to_stop: to_stop.map(|samples| outlook.seconds_for(samples)),
                });
                self.noted_samples = samples;
            }
        }
        self.progress.samples.set_remaining(whole(total - samples));
    }

    fn show_round(&mut self) {
        let Some(on_round) = self.watch.on_round else {
            return;
        };
        let estimator = self.estimator.as_ref();
        let (seconds, cpu_seconds) = (self.clock.seconds(), self.clock.cpu_seconds());
        let shared = self.shared.get_mut().expect("no thread panicked");
        self.clock.pause(|| {
            on_round(&Round {
                seconds,
                cpu_seconds,
                samples_per_pixel: shared.film.mean_samples(),
                error: estimator.and_then(ErrorEstimator::estimate),
                film: &shared.film,
                estimator,
            });
        });
    }
}

/// The whole part of a number of at least 0; what is more than the largest gives that.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "limits are what is meant"
)]
fn whole_below(number: f64) -> u32 {
    number as u32
}

/// The nearest whole number, at least 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "limits are what is meant"
)]
fn whole(number: f64) -> u64 {
    number.round() as u64
}
