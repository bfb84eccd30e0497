//! What is told of a render while it goes on: how wrong the picture is, and how much there is to do.

use super::Renderer;
use super::ahead::Ahead;
use crate::render::error::ErrorEstimator;
use crate::render::progress::{ErrorPoint, NOISE_TARGETS};
use crate::render::run::Round;
use crate::scene::RenderSettings;

/// By how much the samples must have grown until the error is noted again.
const NOTE_GROWTH: f64 = 1.06;

impl Renderer<'_> {
    /// Tells whoever watches how wrong the picture is, and how much there is to do. After a round it always does, else where the
    /// samples have grown enough.
    pub(super) fn tell(&mut self, is_round: bool) {
        let (seconds, cpu_seconds) = (self.clock.seconds(), self.clock.cpu_seconds());
        let shared = self.shared.get_mut().expect("no thread panicked");
        let samples = shared.film.total_samples() as f64;
        let ahead = Ahead::of(&self.course, shared, &self.rules, seconds);
        if (is_round || samples >= self.course.noted_samples * NOTE_GROWTH)
            && let Some((error, outlook)) = self.course.outlook(shared, seconds)
        {
            self.progress.note(ErrorPoint {
                seconds,
                cpu_seconds,
                error,
                time_to: NOISE_TARGETS.map(|noise| {
                    let way = outlook.way_to(noise, [1, RenderSettings::MAX_SAMPLES])?;
                    Some(way.seconds)
                }),
                time_to_stop: ahead.time_to_stop,
            });
            self.course.noted_samples = samples;
        }
        self.progress.foresee(&ahead);
    }

    /// Tells how much there is to do for a render that goes on from a checkpoint.
    pub(super) fn tell_of_start(&mut self) {
        let seconds = self.clock.seconds();
        let shared = self.shared.get_mut().expect("no thread panicked");
        if shared.film.total_samples() > 0 {
            let ahead = Ahead::of(&self.course, shared, &self.rules, seconds);
            self.progress.foresee(&ahead);
        }
    }

    /// Tells how much there is to do by rules that were set since that was told, as soon as they are: a pass may take its time.
    pub(super) fn tell_of_new_rules(&self) {
        let rules = self.live_rules.get();
        let mut told = self.told_rules.lock().expect("no thread panicked");
        if *told != rules {
            *told = rules;
            let ahead = Ahead::of(&self.course, &self.lock(), &rules, self.clock.seconds());
            self.progress.foresee_anew(&ahead);
        }
    }

    pub(super) fn show_round(&mut self) {
        let Some(on_round) = self.watch.on_round else {
            return;
        };
        let estimator = self.course.estimator.as_ref();
        let (seconds, cpu_seconds) = (self.clock.seconds(), self.clock.cpu_seconds());
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        self.clock.pause(|| {
            on_round(&Round {
                seconds,
                cpu_seconds,
                samples_per_pixel: film.mean_samples(),
                error: estimator.and_then(ErrorEstimator::estimate),
                film,
                estimator,
            });
        });
    }
}
