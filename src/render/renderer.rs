//! A render that is going on.
//!
//! At first all pixels get the same number of samples, in passes that end at powers of two and in the middle between them. A render that
//! may stop early then doubles the samples of those pixels where that helps most, in rounds: passes over the selected pixels until each has
//! its double. Decisions are made at the end of a round, from the film alone, so that the picture does not depend on threads; only a stop
//! by time depends on the clock. It falls between passes, so that a picture can be made again, but for the first: a render that has no whole
//! picture when its time is up ends all the same.
//!
//! The rules by which it ends may change on the way. They are looked at between passes, the time alone also within.
//!
//! [`rounds`] decides which pass comes next, by the lengths of [`schedule`]; [`telling`] tells how far it is to whoever watches, and what is
//! [`ahead`]; [`keeping`] has kept what a later render may go on from.

mod ahead;
mod keeping;
mod rounds;
mod schedule;
mod telling;

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::checkpoint::{Checkpoint, Course, Pass, Shared};
use super::clock::Clock;
use super::coarse::{self, CoarsePicture};
use super::crew::{Crew, Cut};
use super::error::ErrorEstimator;
use super::kernel::{Layered, Plain};
use super::layers::Layer;
use super::plan::Feature;
use super::prepare::PreparedScene;
use super::progress::RenderProgress;
use super::rules::{LiveRules, StopRules};
use super::run::{Ending, RenderOutcome, RenderStats, RunConfig, Watch};
use super::texturing::{Textured, Untextured};
use super::tile_samples::{TileBlock, sample_tile};
use super::tiles::{Region, TilePixels};
use crate::scene::RenderSettings;
pub use ahead::Ahead;
use keeping::LastKept;
use rounds::Next;
pub use schedule::{even_passes, leads_elsewhere};

/// Side of a tile in pixels: small enough to balance two threads to the end, large enough that handing one out costs nothing.
pub const TILE_SIDE: u32 = 32;

/// How far beyond its time a render may go to end with a whole pass, as a share of the time.
const MOST_DELAY: f64 = 0.25;

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
    course: Course,
    crew: Crew<'a>,
    clock: Clock,
    last_kept: Mutex<LastKept>,
    live_rules: LiveRules,
    /// Those that the pass goes by.
    rules: StopRules,
    /// Those of which it was told how much there is to do by them.
    told_rules: Mutex<StopRules>,
    /// Whether some pixels may have more samples than others.
    is_choosing: bool,
    /// What was there before a pass over all pixels that is shorter than it might be.
    before_short_pass: Option<Box<(Shared, Course)>>,
}

impl Shared {
    /// Takes in a tile.
    fn add(&mut self, number: usize, tile: Region, block: &TileBlock, clock: &Clock) {
        self.film.add(tile, &block.sums);
        self.counts.add(&block.counts);
        self.has_pass[number] = true;
        self.first_tile_seconds
            .get_or_insert_with(|| clock.seconds());
    }
}

impl<'a> Renderer<'a> {
    /// A render of `region`, which lies in the picture, before its first sample.
    pub fn new(
        scene: &'a PreparedScene,
        region: Region,
        run: &'a RunConfig,
        progress: &'a RenderProgress,
        watch: Watch<'a>,
    ) -> Self {
        let nothing = Checkpoint::before(scene, region, run.layers_of(scene));
        Self::resume(scene, nothing, run, progress, watch)
    }

    /// A render that goes on from `checkpoint`, which [fits](Checkpoint::fits).
    pub fn resume(
        scene: &'a PreparedScene,
        checkpoint: Checkpoint,
        run: &'a RunConfig,
        progress: &'a RenderProgress,
        watch: Watch<'a>,
    ) -> Self {
        let Checkpoint {
            shared,
            course,
            seconds,
            cpu_seconds,
            errors,
            expected_samples,
        } = checkpoint;
        let crew = Crew::new(run);
        let clock = Clock::start_at(seconds, cpu_seconds, crew.threads(), &run.throttle);
        let settings = scene.settings();
        let own = || LiveRules::new(StopRules::of(settings));
        let live_rules = run.rules.clone().unwrap_or_else(own);
        progress.samples.set_total(expected_samples);
        progress.samples.advance(shared.film.total_samples());
        progress.begin(clock.timer(), live_rules.clone());
        for point in errors {
            progress.note(point);
        }
        Self {
            scene,
            settings,
            run,
            progress,
            watch,
            rules: live_rules.get(),
            told_rules: Mutex::new(live_rules.get()),
            live_rules,
            is_choosing: course.has_chosen_pixels(&shared.film),
            before_short_pass: None,
            tiles: shared.film.region().tiles(TILE_SIDE),
            layers: run.layers_of(scene),
            shared: Mutex::new(shared),
            course,
            crew,
            clock,
            last_kept: Mutex::new(LastKept::none()),
        }
    }

    /// Takes all samples; `None` when cancelled.
    ///
    /// # Panics
    /// With a [`RenderFault`], where the program fails at a sample.
    pub fn render(&mut self) -> Option<Ending> {
        let taken = self.take_samples();
        self.progress
            .end(taken.is_ok() || matches!(taken, Err(Cut::TimeUp)));
        match taken {
            Ok(ending) => Some(ending),
            Err(Cut::Cancelled) => None,
            Err(Cut::TimeUp) => Some(Ending::Time),
            Err(Cut::Interrupted) => {
                self.keep_last_checkpoint();
                Some(Ending::Interrupted)
            }
            Err(Cut::Failed(fault)) => {
                self.keep_last_checkpoint();
                resume_unwind(Box::new(fault))
            }
        }
    }

    fn take_samples(&mut self) -> Result<Ending, Cut> {
        if let Some(on_coarse) = self.watch.on_coarse {
            let region = self.lock().film.region();
            let watched = Mutex::new(Duration::ZERO);
            let on_coarse = |picture: &CoarsePicture| {
                let began = Instant::now();
                on_coarse(picture);
                *watched.lock().expect("no thread panics with it") += began.elapsed();
            };
            let shown = coarse::show(self.scene, region, &self.crew, &on_coarse);
            self.clock.note_lead();
            let watched = watched.into_inner().expect("no thread panics with it");
            self.clock.leave_out(watched);
            shown?;
        }
        self.tell_of_start();
        if !self.is_choosing
            && let Next::End(ending) = self.render_evenly()?
        {
            return Ok(ending);
        }
        self.render_where_it_helps()
    }

    /// The picture and what it took; `None` when cancelled.
    pub fn outcome(mut self, ending: Ending) -> Option<RenderOutcome> {
        let is_cut_short = self.settle()?;
        self.clock.note_lead();
        let (seconds, cpu_seconds) = (self.clock.seconds(), self.clock.cpu_seconds());
        let Shared {
            film,
            counts,
            first_tile_seconds,
            ..
        } = self.shared.into_inner().expect("no thread panicked");
        let estimator = self.course.estimator.as_ref();
        let stats = RenderStats {
            render_seconds: seconds,
            cpu_seconds,
            first_tile_seconds: first_tile_seconds.unwrap_or_default(),
            threads: self.crew.threads(),
            rays: counts.rays,
            samples: film.total_samples(),
            samples_per_pixel: film.mean_samples(),
            sample_range: film.sample_range(),
            passes: self.course.passes,
            is_cut_short,
            ending,
            error: estimator.and_then(ErrorEstimator::estimate),
            non_finite_samples: counts.non_finite,
            negative_samples: counts.negative,
            depth_limited_samples: counts.depth_limited,
            clamped: counts.clamped(),
        };
        let cancel = &self.run.cancel;
        // A layer of which nothing is known would say that there is no error.
        let is_known = self.run.layers && stats.error.is_some();
        let errors = match estimator.filter(|_| is_known) {
            Some(estimator) => Some((Layer::Error, estimator.image(&film, cancel)?)),
            None => None,
        };
        let (image, mut layers) = film.into_images(cancel)?;
        layers.extend(errors);
        Some(RenderOutcome {
            image,
            layers,
            stats,
            errors: self.progress.errors_from(0),
        })
    }

    /// Whether the time is up by the rules of this very moment, so that not even a pass that is going on is finished.
    fn is_too_late(&self) -> bool {
        let delay = if self.course.passes == 0 {
            0.0
        } else {
            MOST_DELAY
        };
        let limit = self.live_rules.get().stop.seconds;
        limit.is_some_and(|limit| self.clock.seconds() >= limit * (1.0 + delay))
    }

    /// Ends the pass that was cut, if one was. Returns whether some tiles have it, and not all; the error is estimated anew then, for the samples
    /// that are there. `None` when cancelled.
    fn settle(&mut self) -> Option<bool> {
        let cut = self.course.pass.take();
        let Shared { film, has_pass, .. } = self.shared.get_mut().expect("no thread panicked");
        if cut.is_none() || !has_pass.contains(&true) {
            return Some(false);
        }
        if let Some(estimator) = &mut self.course.estimator {
            // How noise falls is learnt from whole passes.
            let learns_from = vec![false; film.pixels()];
            let cancel = &self.run.cancel;
            let update = || estimator.update(film, Some(&learns_from), cancel);
            self.crew.pool().install(update)?;
        }
        Some(true)
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().expect("no thread panicked")
    }

    /// Does `work` for every tile and its number once, or for fewer tiles when it is cut. Each thread has a block of its own.
    fn for_each_tile(
        &self,
        work: &(dyn Fn(usize, Region, &mut TileBlock) -> Option<()> + Sync),
    ) -> Result<(), Cut> {
        let in_hand = &self.progress.in_hand;
        let result = self
            .crew
            .for_each(self.tiles.len(), &|number, thread, block| {
                let tile = self.tiles[number];
                in_hand.set(thread, Some(tile));
                let done = work(number, tile, block);
                in_hand.set(thread, None);
                self.clock.note(thread);
                done
            });
        self.clock.note_lead();
        result
    }

    /// From now on `pass` is going on, and no tile has it.
    fn begin_pass(&mut self, pass: Pass) {
        let shared = self.shared.get_mut().expect("no thread panicked");
        shared.has_pass.fill(false);
        self.course.pass = Some(pass);
    }

    /// Takes the samples of the pass that is going on, of all tiles that do not have them. Returns the pass, which is over then; when
    /// it is cut, it is still going on.
    fn finish_pass(&mut self) -> Result<Pass, Cut> {
        let this = &*self;
        let pass = this.course.pass.as_ref().expect("one is going on");
        let work = pass.work(this.rules.samples_per_pixel);
        let is_late = AtomicBool::new(false);
        this.for_each_tile(&|number, tile, block| {
            this.tell_of_new_rules();
            if this.is_too_late() {
                is_late.store(true, Ordering::Relaxed);
                return None;
            }
            let shared = this.lock();
            work.of_tile(&shared.film, tile, &mut block.samples);
            if shared.has_pass[number] || block.samples.iter().all(|pixel| pixel.count == 0) {
                return Some(());
            }
            drop(shared);
            let is_new = !this.recall(number, block);
            if is_new {
                this.sample(tile, block)?;
            }
            let mut shared = this.lock();
            shared.add(number, tile, block, &this.clock);
            let means = this.watch.on_tile.map(|_| shared.film.means(tile));
            drop(shared);
            if let Some((on_tile, means)) = this.watch.on_tile.zip(means) {
                on_tile(&TilePixels {
                    region: tile,
                    rgb: &means[0],
                    layers: &means[1..],
                });
            }
            if is_new {
                this.keep(number, block);
            }
            this.keep_checkpoint_if_due();
            Some(())
        })?;
        if is_late.into_inner() {
            return Err(Cut::TimeUp);
        }
        self.course.passes += 1;
        Ok(self.course.pass.take().expect("one is going on"))
    }

    /// Takes the samples that `block` asks for; `None` when stopped.
    fn sample(&self, tile: Region, block: &mut TileBlock) -> Option<()> {
        let (scene, layers, progress) = (self.scene, self.layers, self.progress);
        let take = match (layers.is_empty(), scene.does(Feature::Textures)) {
            (true, false) => sample_tile::<Plain<Untextured>>,
            (true, true) => sample_tile::<Plain<Textured>>,
            (false, false) => sample_tile::<Layered<Untextured>>,
            (false, true) => sample_tile::<Layered<Textured>>,
        };
        self.crew
            .sample(|stops, note| take(scene, tile, block, layers, stops, progress, note))
    }
}
