//! A render that is going on: which pass comes next, and when it is enough.
//!
//! At first all pixels get the same number of samples, in passes that end at powers of two and in the middle between them. A render that
//! may stop early then doubles the samples of those pixels where that helps most, in rounds: passes over the selected pixels until each has
//! its double. Decisions are made at the end of a round, from the film alone, so that the picture does not depend on threads; only a stop
//! by time depends on the clock. It falls between passes, so that a picture can be made again, but for the first: a render that has no whole
//! picture when its time is up ends all the same.
//!
//! The rules by which it ends may change on the way. They are looked at between passes, the time alone also within.
//!
//! [`telling`] tells how far it is to whoever watches, [`keeping`] has kept what a later render may go on from.

mod keeping;
mod telling;

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::checkpoint::{Checkpoint, Course, Pass, Shared};
use super::clock::Clock;
use super::coarse::{self, CoarsePicture};
use super::crew::{Crew, Cut};
use super::error::{Allotment, ErrorEstimator, Forecast, Outlook, ROUND_SHARE};
use super::film::block_after;
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
use keeping::LastKept;

/// Side of a tile in pixels: small enough to balance two threads to the end, large enough that handing one out costs nothing.
pub const TILE_SIDE: u32 = 32;

/// Most samples of a pixel that are summed before they meet the film. Passes grow to this size, so that a whole picture is soon
/// there. Their sizes are part of the picture's definition: they fix the order of additions.
const MOST_SAMPLES_PER_PASS: u32 = 16;

/// The same where only some pixels get samples: by then there is a whole picture, and short passes would make threads wait.
const MOST_SAMPLES_PER_ROUND_PASS: u32 = 64;

/// How many passes give every pixel that many samples, where nothing ends the render before.
#[must_use]
pub fn even_passes(samples: u32) -> u32 {
    let (mut passes, mut taken) = (0, 0);
    while taken < samples {
        taken += block_after(taken).min(MOST_SAMPLES_PER_PASS);
        passes += 1;
    }
    passes
}

/// The first number of samples, from `samples` on, at which a pass over all pixels ends, where none may get more than `most`.
fn end_of_even_pass(samples: f64, most: u32) -> u32 {
    let mut taken = 0;
    while f64::from(taken) < samples && taken < most {
        taken = (taken + block_after(taken).min(MOST_SAMPLES_PER_PASS)).min(most);
    }
    taken
}

/// What every pixel gets before a render stops for its noise, or gives some pixels more than others: from fewer, what is rare
/// would be taken for absent.
const LEAST_SAMPLES: u32 = 16;

/// Pixels get different numbers of samples only where that is foreseen to take at most so many times the samples still to come as if all got
/// the same. It is foreseen with caution, as if judgements never got better: where noise is even it is several times as much, where it is
/// uneven hardly ever more.
const MOST_PRICE_OF_CHOICE: f64 = 1.25;

/// What is aimed at where no noise is: a quarter of the variance, half the noise.
const USUAL_SHARE: f64 = 0.25;

/// How far beyond its time a render may go to end with a whole pass, as a share of the time.
const MOST_DELAY: f64 = 0.25;

/// Whether a pass that is as long as it may be ends with so many samples of every pixel.
fn is_end_of_a_pass(samples: u32) -> bool {
    let mut taken = 0;
    while taken < samples {
        taken += block_after(taken).min(MOST_SAMPLES_PER_PASS);
    }
    taken == samples
}

/// Whether a render that may end by these rules gives some pixels more samples than others.
fn chooses_pixels(settings: &RenderSettings, rules: &StopRules) -> bool {
    let stop = &rules.stop;
    settings.adaptive
        && settings.measures_error()
        && (stop.noise.is_some() || stop.seconds.is_some())
}

/// Whether rules that are changed from `before` to `after` lead to another picture than the new ones would have from the start, where they end
/// up with as many samples. `even_samples`: those that every pixel has; `has_chosen`: whether some have more.
pub fn leads_elsewhere(
    settings: &RenderSettings,
    [before, after]: [&StopRules; 2],
    even_samples: u32,
    has_chosen: bool,
) -> bool {
    let choice = |rules: &StopRules| (rules.samples_per_pixel, rules.stop.noise);
    let chooses = chooses_pixels(settings, after);
    // Whether pixels are chosen, and when from, depends on what is asked for.
    let would_choose_alike = chooses_pixels(settings, before) && choice(before) == choice(after);
    if has_chosen {
        !chooses || !would_choose_alike
    } else {
        chooses && !would_choose_alike && even_samples > LEAST_SAMPLES
    }
}

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
    /// Whether some pixels may have more samples than others.
    is_choosing: bool,
    is_cut_short: bool,
    /// What was there before a pass over all pixels that is shorter than it might be.
    before_short_pass: Option<Box<(Shared, Course)>>,
}

/// What follows the passes over all pixels.
enum Next {
    End(Ending),
    ChoosePixels,
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
            live_rules,
            is_choosing: course.has_chosen_pixels(&shared.film),
            is_cut_short: false,
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
            Err(Cut::TimeUp) => {
                self.is_cut_short = true;
                Some(Ending::Time)
            }
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
        if !self.is_choosing
            && let Next::End(ending) = self.render_evenly()?
        {
            return Ok(ending);
        }
        self.render_where_it_helps()
    }

    /// The picture and what it took; `None` when cancelled.
    pub fn outcome(self, ending: Ending) -> Option<RenderOutcome> {
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
            is_cut_short: self.is_cut_short,
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

    /// Whether some pixels may get more samples than others.
    fn is_adaptive(&self) -> bool {
        self.is_choosing || chooses_pixels(self.settings, &self.rules)
    }

    /// Takes over the rules as they are now. Returns whether they were changed.
    fn look_at_rules(&mut self) -> bool {
        let rules = self.live_rules.get();
        let before = std::mem::replace(&mut self.rules, rules);
        let course = &self.course;
        if leads_elsewhere(
            self.settings,
            [&before, &rules],
            course.even_samples,
            self.is_choosing,
        ) {
            self.live_rules.set_lead_elsewhere();
        }
        rules != before
    }

    /// Remembers what is there, where there is room for it, as a pass begins that other rules would have made longer.
    fn note_short_pass(&mut self) {
        let shared = self.shared.get_mut().expect("no thread panicked");
        self.before_short_pass =
            (self.run.has_room).then(|| Box::new((shared.clone(), self.course.clone())));
    }

    /// Goes back to what was there before the pass, so that the next is as long as it would have been by the rules as they are now. Returns
    /// whether it was known.
    fn undo_short_pass(&mut self) -> bool {
        let Some(before) = self.before_short_pass.take() else {
            return false;
        };
        let (shared, course) = *before;
        self.shared = Mutex::new(shared);
        self.course = course;
        true
    }

    /// Gives all pixels the same number of samples: all they may get, unless the time is up or the noise low enough before, or
    /// from some number on the error decides who gets more.
    fn render_evenly(&mut self) -> Result<Next, Cut> {
        let mut is_shown = true;
        // What was decided by other rules, when it went on from a checkpoint.
        let mut is_changed = true;
        loop {
            is_changed |= self.look_at_rules();
            let (samples, most) = (self.course.even_samples, self.rules.samples_per_pixel);
            if self.course.pass.is_none() {
                if samples >= most {
                    return Ok(Next::End(Ending::Samples));
                }
                if samples.is_power_of_two() && samples >= LEAST_SAMPLES && self.is_adaptive() {
                    if is_changed && self.course.allotment.is_none() {
                        self.allot()?;
                    }
                    if self.course.allotment.is_some() {
                        return Ok(Next::ChoosePixels);
                    }
                }
            }
            let whole = block_after(samples).min(MOST_SAMPLES_PER_PASS);
            let block = whole.min(most.saturating_sub(samples));
            if self.course.pass.is_none() {
                // The last pass takes what the clock leaves. A render of as many samples would end with the same pass.
                let taken = match samples {
                    0 => block,
                    _ => self.block_in_time(samples, block),
                };
                if taken == 0 {
                    if !is_shown {
                        self.show_round();
                    }
                    return Ok(Next::End(Ending::Time));
                }
                if !is_end_of_a_pass(samples) {
                    self.live_rules.set_lead_elsewhere();
                }
                self.before_short_pass = None;
                if taken < whole {
                    self.note_short_pass();
                }
                self.begin_pass(Pass {
                    selected: None,
                    begins_round: true,
                    longest: taken,
                    started: self.clock.seconds(),
                });
            }
            let Pass {
                longest: taken,
                started,
                ..
            } = self.finish_pass()?;
            is_changed = self.look_at_rules();
            let samples = samples + taken;
            let most = self.rules.samples_per_pixel;
            let goes_on = is_changed && samples < most && self.time_left() > 0.0;
            if goes_on && taken < whole && self.undo_short_pass() {
                continue;
            }
            self.course.even_samples = samples;
            self.course.seconds_per_sample = (self.clock.seconds() - started) / f64::from(taken);

            let is_round = samples.is_power_of_two();
            if is_round {
                self.update_estimate(None)?;
            } else if let Some(estimator) = &mut self.course.estimator {
                estimator.advance(samples);
            }
            self.tell(is_round);
            let ending = if samples >= LEAST_SAMPLES && self.is_quiet() {
                Some(Ending::Noise)
            } else if taken < block && !goes_on {
                Some(Ending::Time)
            } else {
                self.has_all_passes().then_some(Ending::Samples)
            };
            is_shown = is_round || samples >= most || ending.is_some();
            if is_shown {
                self.show_round();
            }
            if let Some(ending) = ending {
                return Ok(Next::End(ending));
            }
        }
    }

    /// How many samples of a `block` for each pixel that has `samples` are taken before the time is up. Where the error might have decided who
    /// gets more, all of them or none, whichever ends nearer to the time: the number of passes reproduces the picture then.
    fn block_in_time(&self, samples: u32, block: u32) -> u32 {
        let there_is_time_for = self.time_left() / self.course.seconds_per_sample;
        if samples < LEAST_SAMPLES || !self.is_adaptive() {
            whole_below(there_is_time_for).min(block)
        } else if there_is_time_for >= f64::from(block) / 2.0 {
            block
        } else {
            0
        }
    }

    /// Doubles the samples of those pixels where it helps most, again and again.
    fn render_where_it_helps(&mut self) -> Result<Ending, Cut> {
        self.is_choosing = true;
        if self.course.allotment.is_none() {
            self.allot()?;
        }
        loop {
            self.look_at_rules();
            if self.course.pass.is_none() {
                let unfinished = self.pixels_of_unfinished_round();
                let begins_round = unfinished.is_none();
                let Some(selected) = unfinished.or_else(|| self.select()) else {
                    return Ok(Ending::Samples);
                };
                let pass = Pass {
                    selected: Some(selected),
                    begins_round,
                    longest: MOST_SAMPLES_PER_ROUND_PASS,
                    started: self.clock.seconds(),
                };
                if !self.has_time_for(&pass) {
                    return Ok(Ending::Time);
                }
                self.begin_pass(pass);
            }
            let last = self.finish_round()?;
            self.update_estimate(last.selected.as_deref())?;
            self.tell(true);
            self.show_round();
            if self.is_quiet() {
                return Ok(Ending::Noise);
            }
            if self.time_left() <= 0.0 {
                return Ok(Ending::Time);
            }
            if self.has_all_passes() {
                return Ok(Ending::Samples);
            }
        }
    }

    /// The pixels that a round which ended early, or that they may get no more, left on the way to double their samples; `None` where there
    /// are none. Other rules may take them there.
    fn pixels_of_unfinished_round(&self) -> Option<Vec<bool>> {
        let (film, most) = (&self.lock().film, self.rules.samples_per_pixel);
        let is_unfinished = |index: usize| {
            let samples = film.samples(index);
            samples < most && !samples.is_power_of_two()
        };
        let pixels: Vec<bool> = (0..film.pixels()).map(is_unfinished).collect();
        pixels.contains(&true).then_some(pixels)
    }

    /// Whether `pass` ends nearer to the end of the time than the render does without it, as far as can be told.
    fn has_time_for(&self, pass: &Pass) -> bool {
        let left = self.time_left();
        if left.is_infinite() {
            return true;
        }
        let film = &self.lock().film;
        let samples = pass.work(self.rules.samples_per_pixel).samples(film) as f64;
        let seconds = samples * self.clock.seconds() / film.total_samples() as f64;
        seconds / 2.0 < left
    }

    /// Goes on with passes until the pixels selected have doubled their samples, or it is time to end. Returns the last pass.
    fn finish_round(&mut self) -> Result<Pass, Cut> {
        loop {
            let next = Pass {
                begins_round: false,
                ..self.finish_pass()?
            };
            self.look_at_rules();
            let work = next.work(self.rules.samples_per_pixel);
            if !self.has_time_for(&next)
                || self.has_all_passes()
                || !work.has_pixels(&self.lock().film)
            {
                return Ok(next);
            }
            self.begin_pass(next);
        }
    }

    /// Whether it saves enough to give some pixels more samples than others, as `allotment` would.
    fn is_choice_worthwhile(&self, allotment: &Allotment) -> bool {
        let Some(estimator) = &self.course.estimator else {
            return false;
        };
        // What the clock ends is worth the most that its time allows.
        let Some(noise) = self.rules.stop.noise else {
            return true;
        };
        let share = estimator.estimate().map_or(USUAL_SHARE, |error| {
            (noise * noise / error.relmse.value).min(1.0)
        });
        let outlook = Outlook {
            estimator,
            allotment: Some(allotment),
            samples: self.lock().film.total_samples() as f64,
            seconds: self.clock.seconds(),
        };
        let limits = [LEAST_SAMPLES, self.rules.samples_per_pixel];
        outlook.price_of_choice(share, limits) <= MOST_PRICE_OF_CHOICE
    }

    /// The pixels that get samples next; `None` when none can get more, and when cancelled.
    fn select(&self) -> Option<Vec<bool>> {
        let (allotment, estimator) = self
            .course
            .allotment
            .as_ref()
            .zip(self.course.estimator.as_ref())?;
        let most = self.rules.samples_per_pixel;
        let film = &self.lock().film;
        let forecast = match (self.rules.stop.noise, estimator.estimate()) {
            (Some(noise), Some(error)) => {
                allotment.for_variance((noise * noise / error.relmse.value).min(1.0), [1, most])
            }
            _ => Forecast::ALL,
        };
        let budget = (film.total_samples() as f64 * ROUND_SHARE).min(forecast.price / 2.0);
        allotment.select(film, forecast, budget, most, &self.run.cancel)
    }

    /// Whether the noise is as low as asked for.
    fn is_quiet(&self) -> bool {
        let estimator = self.course.estimator.as_ref();
        let estimate = estimator.and_then(ErrorEstimator::estimate);
        let target = self.rules.stop.noise;
        target
            .zip(estimate)
            .is_some_and(|(noise, error)| error.relmse.value <= noise * noise)
    }

    fn has_all_passes(&self) -> bool {
        let passes = self.rules.stop.passes;
        passes.is_some_and(|passes| self.course.passes >= passes)
    }

    /// Seconds until the render is to stop.
    fn time_left(&self) -> f64 {
        let seconds = self.rules.stop.seconds;
        seconds.map_or(f64::INFINITY, |seconds| seconds - self.clock.seconds())
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

    /// Estimates the error anew, after the pixels, those `selected` or all, have doubled their samples.
    fn update_estimate(&mut self, selected: Option<&[bool]>) -> Result<(), Cut> {
        let is_adaptive = self.is_adaptive();
        let Some(estimator) = &mut self.course.estimator else {
            return Ok(());
        };
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        let cancel = &self.run.cancel;
        let updated = self.crew.pool().install(|| {
            estimator.update(film, selected, cancel)?;
            if is_adaptive && film.mean_samples() * 2.0 >= f64::from(LEAST_SAMPLES) {
                Allotment::new(film, estimator, cancel).map(Some)
            } else {
                Some(None)
            }
        });
        // Once pixels differ, it goes on.
        self.course.allotment = updated
            .ok_or(Cut::Cancelled)?
            .filter(|allotment| selected.is_some() || self.is_choice_worthwhile(allotment));
        self.crew
            .pool()
            .broadcast(|thread| self.clock.note(thread.index()));
        self.clock.note_lead();
        Ok(())
    }

    /// Finds out where samples belong, by the estimate as it is; as long as all pixels have the same, only where it is worth its price.
    fn allot(&mut self) -> Result<(), Cut> {
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        let estimator = self.course.estimator.as_ref();
        let (pool, cancel) = (self.crew.pool(), &self.run.cancel);
        let allotment = match estimator {
            Some(estimator) => {
                let allotment = pool.install(|| Allotment::new(film, estimator, cancel));
                Some(allotment.ok_or(Cut::Cancelled)?)
            }
            None => None,
        };
        let is_choosing = self.is_choosing;
        self.course.allotment =
            allotment.filter(|allotment| is_choosing || self.is_choice_worthwhile(allotment));
        Ok(())
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
