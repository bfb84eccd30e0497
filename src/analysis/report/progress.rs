//! How far a series of renders is.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::render::RenderProgress;

/// How far a report is, for whoever holds a clone.
#[derive(Clone, Debug, Default)]
pub struct ReportProgress(Arc<Mutex<Steps>>);

/// All numbers are samples per pixel, of any render.
#[derive(Debug, Default)]
struct Steps {
    total: f64,
    /// Of the renders that are done.
    before: f64,
    /// Of the render that goes on.
    own: f64,
    name: String,
    progress: RenderProgress,
}

impl ReportProgress {
    /// Says how much there is to do in all.
    pub(super) fn set_total(&self, samples: f64) {
        self.steps().total = samples;
    }

    /// Says that there is more to do than was known.
    pub(super) fn add_to_total(&self, samples: f64) {
        self.steps().total += samples;
    }

    /// Begins the next render, which is called `name`.
    pub(super) fn begin(&self, name: String, samples: f64) -> RenderProgress {
        let mut steps = self.steps();
        steps.before += steps.own;
        steps.own = samples;
        steps.name = name;
        steps.progress = RenderProgress::default();
        steps.progress.clone()
    }

    /// The done part of all samples, `0..=1`, and what is being rendered; 0 and nothing before the first render.
    #[must_use]
    pub fn how_far(&self) -> (f64, String) {
        let steps = self.steps();
        let done = steps.before + steps.own * steps.progress.samples.fraction();
        let share = if steps.total > 0.0 {
            done / steps.total
        } else {
            0.0
        };
        (share, steps.name.clone())
    }

    fn steps(&self) -> MutexGuard<'_, Steps> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_all_samples() {
        let progress = ReportProgress::default();
        assert_eq!(progress.how_far(), (0.0, String::new()));
        progress.set_total(400.0);
        let reference = progress.begin("reference".to_owned(), 300.0);
        reference.samples.set_total(10);
        reference.samples.advance(5);
        assert_eq!(progress.how_far(), (0.375, "reference".to_owned()));
        progress.begin("seed 1".to_owned(), 100.0);
        assert_eq!(progress.how_far(), (0.75, "seed 1".to_owned()));
    }
}
