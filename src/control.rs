//! Watching and stopping long work from outside: values that are cloned and polled, with no callback and no lock.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

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
}

impl Progress {
    /// Nothing done of an amount not known yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Says how much there is to do. Call it before the first [`Progress::advance`].
    pub fn set_total(&self, total: u64) {
        self.0.total.store(total, Ordering::Relaxed);
    }

    /// Says how much there is left to do, where that is learnt on the way. The fraction does not jump: it goes on from where it
    /// is, at another speed.
    pub fn set_remaining(&self, remaining: u64) {
        let fraction = self.fraction();
        let mut known = self.known();
        *known = Known {
            fraction,
            done: self.done(),
        };
        self.set_total(known.done + remaining);
    }

    fn known(&self) -> std::sync::MutexGuard<'_, Known> {
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
            0 => 1.0,
            _ => known.fraction + (1.0 - known.fraction) * (done as f64 / left as f64).min(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}
