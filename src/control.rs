//! Watching, stopping and slowing long work from outside: values that are cloned and polled.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A request to stop that travels to whoever holds a clone.
///
/// Long work polls it often enough to answer within milliseconds. Cancelled work returns `None`; it is not an error.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token nobody has cancelled yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks everyone who holds a clone to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether stopping was asked for.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How many of the threads that share a piece of work may go on now: all of them at first, fewer where somebody else needs the
/// processor, none while it is paused. Clones are one and the same. A thread that waits uses no processor time.
#[derive(Clone, Debug, Default)]
pub struct Throttle(Arc<ThrottleState>);

#[derive(Debug)]
struct ThrottleState {
    allowed: AtomicUsize,
    pauses: Mutex<Pauses>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Pauses {
    /// When the pause began that is going on.
    since: Option<Instant>,
    /// What those before it took.
    before: Duration,
}

impl Pauses {
    /// What all of them took until `now`.
    fn until(&self, now: Instant) -> Duration {
        let present = self.since.map(|since| now.saturating_duration_since(since));
        self.before + present.unwrap_or_default()
    }
}

impl Default for ThrottleState {
    fn default() -> Self {
        Self {
            allowed: AtomicUsize::new(usize::MAX),
            pauses: Mutex::default(),
            changed: Condvar::new(),
        }
    }
}

impl Throttle {
    /// Lets so many threads go on, those with the lowest numbers; none is a pause, which threads obey at once, in the middle of what
    /// they are at.
    pub fn allow(&self, threads: usize) {
        let mut pauses = self.pauses();
        self.0.allowed.store(threads, Ordering::Relaxed);
        if threads == 0 {
            pauses.since.get_or_insert_with(Instant::now);
        } else if let Some(since) = pauses.since.take() {
            pauses.before += since.elapsed();
        }
        self.0.changed.notify_all();
    }

    /// How many threads may go on.
    #[must_use]
    pub fn allowed(&self) -> usize {
        self.0.allowed.load(Ordering::Relaxed)
    }

    /// Whether no thread may go on.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.allowed() == 0
    }

    /// What all pauses took so far.
    #[must_use]
    pub fn paused_time(&self) -> Duration {
        self.pauses().until(Instant::now())
    }

    /// The time since `started` without the pauses there ever were: it stands still in a pause.
    #[must_use]
    pub fn time_since(&self, started: Instant) -> Duration {
        let pauses = self.pauses();
        let now = Instant::now();
        now.saturating_duration_since(started)
            .saturating_sub(pauses.until(now))
    }

    /// Waits until the work is not paused.
    pub fn wait_while_paused(&self) {
        if self.is_paused() {
            let pauses = self.pauses();
            drop(self.0.changed.wait_while(pauses, |_| self.is_paused()));
        }
    }

    /// Waits until thread `number`, counted from 0, may go on, or `is_over` holds: nothing is left to do, as whoever finds that out
    /// [tells](Self::wake).
    pub fn wait_for_turn(&self, number: usize, is_over: impl Fn() -> bool) {
        if number >= self.allowed() {
            let waits = |_: &mut Pauses| number >= self.allowed() && !is_over();
            drop(self.0.changed.wait_while(self.pauses(), waits));
        }
    }

    /// Has threads that wait for their turn look whether there is still something to do.
    pub fn wake(&self) {
        // Whoever is about to wait has looked before, or looks again.
        drop(self.pauses());
        self.0.changed.notify_all();
    }

    fn pauses(&self) -> MutexGuard<'_, Pauses> {
        self.0.pauses.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How much of a known amount of work is done. The unit is the worker's own (bytes, triangles, samples).
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    done: AtomicU64,
    total: AtomicU64,
    known: Mutex<Known>,
}

/// The fraction at the moment when the total was set last, and what was done then.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    fraction: f64,
    done: u64,
    /// Whether the total is an estimate.
    is_estimate: bool,
}

/// From this part of an estimated amount of work on, it is no longer believed that no more comes.
const BELIEVED: f64 = 0.9;

/// The done part where `share` is done of what was estimated: always less than 1, and ever slower from [`BELIEVED`] on.
fn cautious(share: f64) -> f64 {
    if share < BELIEVED {
        return share;
    }
    let rest = 1.0 - BELIEVED;
    1.0 - rest * libm::exp((BELIEVED - share) / rest)
}

impl Progress {
    /// Nothing done of an amount not known yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Says how much there is to do in all. See [`Self::set_remaining`] where some of it is done.
    pub fn set_total(&self, total: u64) {
        self.0.total.store(total, Ordering::Relaxed);
    }

    /// Says that there is `more` to do than was known.
    pub fn add_to_total(&self, more: u64) {
        self.0.total.fetch_add(more, Ordering::Relaxed);
    }

    /// Says how much there is left to do, where that is learnt on the way. The fraction does not jump: it goes on from where it
    /// is, at another speed.
    pub fn set_remaining(&self, remaining: u64) {
        self.learn(remaining, false);
    }

    /// The same where it is a guess: the fraction comes near to 1 and does not reach it before the work is known to be done, however much
    /// there is.
    pub fn estimate_remaining(&self, remaining: u64) {
        self.learn(remaining, true);
    }

    fn learn(&self, remaining: u64, is_estimate: bool) {
        let fraction = self.fraction();
        let mut known = self.known();
        *known = Known {
            fraction,
            done: self.done(),
            is_estimate,
        };
        self.set_total(known.done + remaining);
    }

    /// Says that there is another amount to do in all than was thought: the fraction is what is done of that.
    pub fn begin_anew(&self, total: u64) {
        *self.known() = Known::default();
        self.set_total(total);
    }

    /// Work still to be done, as far as its amount is known: where that is a guess, never none before it is known to be done.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        let known = *self.known();
        let left = self.total().saturating_sub(known.done) as f64;
        let done = self.done().saturating_sub(known.done) as f64;
        if known.is_estimate && left > 0.0 {
            left * (1.0 - cautious(done / left))
        } else {
            (left - done).max(0.0)
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds work done.
    pub fn advance(&self, amount: u64) {
        self.0.done.fetch_add(amount, Ordering::Relaxed);
    }

    /// Work done so far.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.0.done.load(Ordering::Relaxed)
    }

    /// All the work there is; 0 while it is not known.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.total.load(Ordering::Relaxed)
    }

    /// The done part of the whole, `0..=1`; 0 while the whole is not known.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let known = *self.known();
        let left = self.total().saturating_sub(known.done);
        let done = self.done().saturating_sub(known.done);
        match left {
            0 if self.total() == 0 => 0.0,
            0 if known.is_estimate => known.fraction,
            0 => 1.0,
            _ => {
                let share = done as f64 / left as f64;
                let share = if known.is_estimate {
                    cautious(share)
                } else {
                    share.min(1.0)
                };
                known.fraction + (1.0 - known.fraction) * share
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_wait_for_their_turn_until_it_comes_or_nothing_is_left() {
        let throttle = Throttle::default();
        throttle.wait_while_paused();
        throttle.wait_for_turn(1_000, || false);
        throttle.allow(1);
        throttle.wait_for_turn(0, || false);
        let is_over = AtomicBool::new(false);
        let passed = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            let wait = |number: usize| {
                let (throttle, is_over, passed) = (&throttle, &is_over, &passed);
                scope.spawn(move || {
                    throttle.wait_for_turn(number, || is_over.load(Ordering::Relaxed));
                    passed.fetch_add(1, Ordering::Relaxed);
                });
            };
            wait(1);
            wait(2);
            std::thread::sleep(Duration::from_millis(20));
            assert_eq!(passed.load(Ordering::Relaxed), 0);
            throttle.allow(2);
            while passed.load(Ordering::Relaxed) < 1 {
                std::thread::yield_now();
            }
            std::thread::sleep(Duration::from_millis(20));
            assert_eq!(passed.load(Ordering::Relaxed), 1, "it is the turn of one");
            is_over.store(true, Ordering::Relaxed);
            throttle.wake();
        });
        assert_eq!(passed.load(Ordering::Relaxed), 2);
    }

    #[test]
    fn pauses_are_timed_and_the_time_between_them_is_not() {
        let throttle = Throttle::default();
        assert_eq!(throttle.paused_time(), Duration::ZERO);
        let (pause, started) = (Duration::from_millis(30), Instant::now());
        for _ in 0..2 {
            throttle.allow(0);
            throttle.allow(0);
            assert!(throttle.is_paused());
            let time = throttle.time_since(started);
            std::thread::sleep(pause);
            assert_eq!(throttle.time_since(started), time);
            throttle.allow(1);
            let so_far = throttle.paused_time();
            std::thread::sleep(pause);
            assert_eq!(throttle.paused_time(), so_far);
        }
        let paused = throttle.paused_time();
        assert!(paused >= 2 * pause);
        assert!(throttle.time_since(started) >= 2 * pause);
        assert!(throttle.time_since(started) + paused <= started.elapsed());
    }

    #[test]
    fn what_is_estimated_is_never_done() {
        let progress = Progress::new();
        progress.estimate_remaining(100);
        progress.advance(90);
        assert!((progress.fraction() - 0.9).abs() < 1e-12);
        let mut last = progress.fraction();
        for _ in 0..10 {
            progress.advance(5);
            let fraction = progress.fraction();
            assert!(fraction > last && fraction < 1.0, "{fraction}");
            last = fraction;
        }
        for estimate in [0, 100] {
            progress.estimate_remaining(estimate);
            assert_eq!(progress.fraction(), last);
        }
        progress.set_remaining(0);
        assert_eq!(progress.fraction(), 1.0);
    }

    #[test]
    fn the_fraction_goes_on_without_a_jump_when_more_is_learnt() {
        let progress = Progress::new();
        assert_eq!(progress.fraction(), 0.0);
        progress.set_total(100);
        progress.advance(20);
        assert_eq!(progress.fraction(), 0.2);
        progress.set_remaining(40);
        assert_eq!(progress.fraction(), 0.2);
        progress.advance(20);
        assert!((progress.fraction() - 0.6).abs() < 1e-12);
        progress.set_remaining(1000);
        assert!((progress.fraction() - 0.6).abs() < 1e-12);
        progress.advance(1000);
        assert_eq!(progress.fraction(), 1.0);
        progress.set_remaining(0);
        assert_eq!(progress.fraction(), 1.0);
        progress.begin_anew(2 * progress.done());
        assert_eq!(progress.fraction(), 0.5);
    }
}
