//! Which pass comes next, and when it is enough.

use super::Renderer;
use super::schedule::{
    LEAST_SAMPLES, MOST_SAMPLES_PER_PASS, chooses_pixels, is_end_of_a_pass, leads_elsewhere,
};
use crate::render::checkpoint::Pass;
use crate::render::crew::Cut;
use crate::render::error::{Allotment, ErrorEstimator, Forecast, Outlook, ROUND_SHARE};
use crate::render::film::block_after;
use crate::render::run::Ending;
use std::sync::Mutex;

/// The same where only some pixels get samples: by then there is a whole picture, and short passes would make threads wait.
const MOST_SAMPLES_PER_ROUND_PASS: u32 = 64;

/// Pixels get different numbers of samples only where that is foreseen to take at most so many times the samples still to come as if all got
/// the same. It is foreseen with caution, as if judgements never got better: where noise is even it is several times as much, where it is
/// uneven hardly ever more.
const MOST_PRICE_OF_CHOICE: f64 = 1.25;

/// What is aimed at where no noise is: a quarter of the variance, half the noise.
const USUAL_SHARE: f64 = 0.25;

/// What follows the passes over all pixels.
pub(super) enum Next {
    End(Ending),
    ChoosePixels,
}

impl Renderer<'_> {
    /// Whether some pixels may get more samples than others.
    fn is_adaptive(&self) -> bool {
        self.is_choosing || chooses_pixels(self.settings, &self.rules)
    }

    /// Takes over the rules as they are now. Returns whether they were changed.
    fn look_at_rules(&mut self) -> bool {
        self.tell_of_new_rules();
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
    pub(super) fn render_evenly(&mut self) -> Result<Next, Cut> {
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
    pub(super) fn render_where_it_helps(&mut self) -> Result<Ending, Cut> {
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
            // Noise falls in a round: one that was low enough before it is.
            let is_quiet = self.look_at_rules() && self.is_quiet();
            let work = next.work(self.rules.samples_per_pixel);
            if is_quiet
                || !self.has_time_for(&next)
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
    pub(super) fn is_quiet(&self) -> bool {
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
