//! What is told of a render while it goes on: how wrong the picture is, and how much there is to do.

use super::Renderer;
use super::schedule::{LEAST_SAMPLES, end_of_even_pass};
use crate::render::error::{ErrorEstimator, LEAST_SHARE, Outlook};
use crate::render::progress::{ErrorPoint, NOISE_TARGETS};
use crate::render::run::Round;
use crate::scene::RenderSettings;

/// By how much the samples must have grown until the error is noted again.
const NOTE_GROWTH: f64 = 1.06;

impl Renderer<'_> {
    /// Tells whoever watches how wrong the picture is, and how much there is to do. After a round it always does, else where the
    /// samples have grown enough.
    pub(super) fn tell(&mut self, is_round: bool) {
        let film = &self.shared.get_mut().expect("no thread panicked").film;
        let (samples, pixels) = (film.total_samples() as f64, film.pixels() as f64);
        let most = self.rules.samples_per_pixel;
        let seconds = self.clock.seconds();
        // As far as is known now, the render ends after so many samples, where its time is not up before.
        let mut total = pixels * f64::from(most);
        let mut is_foreseen = self.rules.stop.noise.is_none();
        let mut is_estimate = false;
        if let Some(estimator) = &self.course.estimator
            && let Some(error) = estimator.estimate()
        {
            let outlook = Outlook {
                estimator,
                allotment: self.course.allotment.as_ref(),
                samples,
                seconds,
            };
            is_foreseen = true;
            let noise = self.rules.stop.noise;
            let to_stop = noise.and_then(|noise| outlook.way_to(noise, [LEAST_SAMPLES, most]));
            let end_of_pass =
                |samples: f64| f64::from(end_of_even_pass(samples / pixels, most)) * pixels;
            let is_even = outlook.allotment.is_none();
            let to_stop = to_stop.map(|way| if is_even { way.up_to(end_of_pass) } else { way });
            if let Some(to_stop) = to_stop {
                // As long as noise is not there, another pass begins.
                let least = if is_even {
                    end_of_pass(samples + pixels)
                } else {
                    samples * (1.0 + LEAST_SHARE)
                };
                is_estimate = to_stop.samples.value < total;
                total = total.min(to_stop.samples.value.max(least));
            } else if self.is_quiet() {
                let least = pixels * f64::from(LEAST_SAMPLES.min(most));
                is_estimate = samples < least;
                total = samples.max(least);
            }
            if is_round || samples >= self.course.noted_samples * NOTE_GROWTH {
                self.progress.note(ErrorPoint {
                    seconds,
                    cpu_seconds: self.clock.cpu_seconds(),
                    error,
                    time_to: NOISE_TARGETS.map(|noise| {
                        let way = outlook.way_to(noise, [1, RenderSettings::MAX_SAMPLES])?;
                        Some(way.seconds)
                    }),
                    time_to_stop: to_stop.map(|way| way.seconds),
                });
                self.course.noted_samples = samples;
            }
        }
        if is_foreseen {
            let remaining = whole((total - samples).max(0.0));
            self.progress.foresee(remaining, is_estimate);
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

/// The nearest whole number, at least 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "limits are what is meant"
)]
pub fn whole(number: f64) -> u64 {
    number.round() as u64
}
