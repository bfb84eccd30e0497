//! What a running render tells other threads: how far it is, how its error falls, and which tiles it is at.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::clock::Timer;
use super::error::{ErrorEstimate, Interval};
use super::renderer::Ahead;
use super::rules::LiveRules;
use super::tiles::Region;
use crate::control::Progress;

/// The levels of noise whose time is predicted: 10, 3 and 1 per cent.
pub const NOISE_TARGETS: [f64; 3] = [0.10, 0.03, 0.01];

/// A running render's state for whoever watches; clones see the same render.
#[derive(Clone, Debug, Default)]
pub struct RenderProgress {
    /// In camera samples: their done fraction is that of the work, as far as it is known.
    pub samples: Progress,
    rays: Arc<AtomicU64>,
    errors: Arc<Mutex<Vec<ErrorPoint>>>,
    ending: Arc<Mutex<HowFar>>,
    /// The tiles that are being rendered.
    pub in_hand: TilesInHand,
}

/// What is known of the samples that a render takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sight {
    /// No more than the most there may be.
    #[default]
    Bound,
    /// What was found out before the render itself could tell.
    Guess,
    /// All there is to know.
    Known,
}

/// How far the render is beside its samples.
#[derive(Debug, Default)]
struct HowFar {
    /// The time it takes, and the rules by which it ends; `None` before it begins.
    run: Option<(Timer, LiveRules)>,
    /// What was done when it was interrupted, `0..=1`.
    before: f64,
    /// What is known of the samples it takes.
    sight: Sight,
    /// How many they are, as somebody knew before it began.
    expected: Option<u64>,
    /// Whether it ends with the pass that is going on.
    ends_with_pass: bool,
    /// What was done when it was over, `0..=1`.
    at_end: Option<f64>,
}

/// The tiles that the threads of a render are at, as far as anybody wants to see them.
#[derive(Clone, Debug, Default)]
pub struct TilesInHand(Arc<Mutex<Vec<Option<Region>>>>);

impl TilesInHand {
    /// Where they lie in the full picture, a tile for each thread that works.
    #[must_use]
    pub fn tiles(&self) -> Vec<Region> {
        self.lock().iter().copied().flatten().collect()
    }

    /// From now on thread number `thread` is at `tile`.
    pub(super) fn set(&self, thread: usize, tile: Option<Region>) {
        let mut tiles = self.lock();
        if tiles.len() <= thread {
            tiles.resize(thread + 1, None);
        }
        tiles[thread] = tile;
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Option<Region>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The error at a moment of a render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorPoint {
    /// Wall time since the start; that of a [`super::Watch`] does not count.
    pub seconds: f64,
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// How large it is.
    pub error: ErrorEstimate,
    /// When noise falls to each of [`NOISE_TARGETS`], in seconds since the start; `None` where it is there already, or never will
    /// be.
    pub time_to: [Option<Interval>; NOISE_TARGETS.len()],
    /// The same for the noise at which the render is to stop.
    pub time_to_stop: Option<Interval>,
}

impl HowFar {
    /// The seconds the render has taken, and those it may take, where the clock ends it.
    fn time(&self) -> Option<(f64, f64)> {
        let (timer, rules) = self.run.as_ref()?;
        Some((timer.seconds(), rules.get().stop.seconds?))
    }
}

impl RenderProgress {
    /// Rays traced so far; those before the checkpoint that a render goes on from do not count.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// What is known about the error, from point number `first` on.
    #[must_use]
    pub fn errors_from(&self, first: usize) -> Vec<ErrorPoint> {
        self.errors().get(first..).unwrap_or_default().to_vec()
    }

    /// What is known last.
    #[must_use]
    pub fn latest_error(&self) -> Option<ErrorPoint> {
        self.errors().last().copied()
    }

    /// The done part of the whole, `0..=1`: by the rule that is nearest to ending the render, of which time is one. It never jumps by more
    /// than what is learnt at once, and stands still when the render is over.
    #[must_use]
    pub fn share(&self) -> f64 {
        let how_far = self.how_far();
        how_far.at_end.unwrap_or_else(|| self.share_of(&how_far))
    }

    fn share_of(&self, how_far: &HowFar) -> f64 {
        let by_time = how_far
            .time()
            .map_or(0.0, |(seconds, limit)| seconds / limit);
        let by_samples = self.samples.fraction();
        by_time.max(by_samples).max(how_far.before).min(1.0)
    }

    /// Seconds until the clock ends the render, where it does.
    #[must_use]
    pub fn seconds_until_time_is_up(&self) -> Option<f64> {
        let (seconds, limit) = self.how_far().time()?;
        Some((limit - seconds).max(0.0))
    }

    /// What is known of the samples it takes: where noise may end it, little at first.
    #[must_use]
    pub fn sight(&self) -> Sight {
        let how_far = self.how_far();
        let run = how_far.run.as_ref();
        if run.is_some_and(|(_, rules)| rules.get().stop.noise.is_none()) {
            return Sight::Known;
        }
        how_far.sight
    }

    /// Says how many samples the render takes in all, as far as somebody knows before the render itself does.
    pub fn expect_samples(&self, samples: u64) {
        let mut how_far = self.how_far();
        if how_far.run.is_none() {
            how_far.expected = Some(samples);
        } else if how_far.sight != Sight::Known {
            how_far.sight = Sight::Guess;
            let done = self.samples.done();
            self.samples
                .estimate_remaining(samples.saturating_sub(done));
        }
    }

    /// Says that so much of it, `0..=1`, is done from the start, which a render that goes on takes up bit by bit.
    pub fn go_on_at(&self, share: f64) {
        self.how_far().before = share;
    }

    /// Says that other rules end the render from now on: what is done is a share of another whole. `samples`: the most it takes, until the
    /// render itself says more.
    pub fn begin_anew(&self, samples: u64) {
        self.samples.begin_anew(samples.max(self.samples.done()));
        self.forget_what_was_known();
    }

    fn forget_what_was_known(&self) {
        let mut how_far = self.how_far();
        how_far.before = 0.0;
        how_far.sight = Sight::Bound;
        how_far.ends_with_pass = false;
    }

    /// Whether it ends with the pass that is going on, as the rules were changed to some that are fulfilled by now.
    #[must_use]
    pub fn ends_with_pass(&self) -> bool {
        self.how_far().ends_with_pass
    }

    /// What is done of the samples, and what is still to be done, as far as their number is known: at the pace so far, time goes as they do,
    /// where [`Self::share`] goes on from what was thought before.
    #[must_use]
    pub fn samples_done_and_left(&self) -> [f64; 2] {
        let (done, left) = (self.samples.done() as f64, self.samples.remaining());
        // What was done when it was interrupted is taken up bit by bit.
        let known = self.how_far().before * (done + left);
        let more = (known - done).max(0.0);
        [done + more, left - more]
    }

    /// The render begins.
    pub(super) fn begin(&self, timer: Timer, rules: LiveRules) {
        let mut how_far = self.how_far();
        how_far.run = Some((timer, rules));
        how_far.at_end = None;
        if let Some(samples) = how_far.expected.take() {
            drop(how_far);
            self.expect_samples(samples);
        }
    }

    /// The render says how much there is still to do, where it knows.
    pub(super) fn foresee(&self, ahead: &Ahead) {
        if !ahead.is_known {
            return;
        }
        if ahead.is_estimate {
            self.samples.estimate_remaining(ahead.samples);
        } else {
            self.samples.set_remaining(ahead.samples);
        }
        let mut how_far = self.how_far();
        how_far.sight = Sight::Known;
        how_far.ends_with_pass = ahead.ends_with_pass;
    }

    /// The same by other rules than before: what is done is a share of another whole.
    pub(super) fn foresee_anew(&self, ahead: &Ahead) {
        self.samples.begin_anew(self.samples.done() + ahead.samples);
        self.forget_what_was_known();
        self.how_far().ends_with_pass = ahead.ends_with_pass;
        self.foresee(ahead);
    }

    /// The render is over. `is_whole`: as its rules wanted.
    pub(super) fn end(&self, is_whole: bool) {
        let mut how_far = self.how_far();
        let share = if is_whole {
            1.0
        } else {
            self.share_of(&how_far)
        };
        how_far.at_end = Some(share);
    }

    fn how_far(&self) -> MutexGuard<'_, HowFar> {
        self.ending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn count_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    pub(super) fn note(&self, point: ErrorPoint) {
        self.errors().push(point);
    }

    fn errors(&self) -> MutexGuard<'_, Vec<ErrorPoint>> {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
