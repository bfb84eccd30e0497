//! What is still to come of a render, as far as is known.

use super::schedule::{LEAST_SAMPLES, end_of_even_pass};
use crate::render::checkpoint::{Course, Shared};
use crate::render::error::{ErrorEstimate, ErrorEstimator, Interval, LEAST_SHARE, Outlook};
use crate::render::rules::StopRules;

/// What a render has still to do by the rules as they are, where its time is not up before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ahead {
    /// Samples of all pixels together.
    pub samples: u64,
    /// Whether that is all there is to know; otherwise it is the most there may be.
    pub is_known: bool,
    /// Whether it is known by an estimate, so that there may be more.
    pub is_estimate: bool,
    /// Whether it ends with the pass that is going on, as the rules are fulfilled before it is over.
    pub ends_with_pass: bool,
    /// When the noise at which it is to stop is reached, in seconds from the start on.
    pub time_to_stop: Option<Interval>,
}

impl Ahead {
    /// Of a render that has got so far in `seconds`.
    pub fn of(course: &Course, shared: &Shared, rules: &StopRules, seconds: f64) -> Self {
        let most = rules.samples_per_pixel;
        let of_pass = course.left_of_pass(shared, most);
        let at_most = Self {
            samples: shared.film.room_up_to(most).max(of_pass),
            is_known: rules.stop.noise.is_none(),
            ..Self::default()
        };
        let known = rules.stop.noise.zip(course.outlook(shared, seconds));
        let ahead = known.map_or(at_most, |(noise, (error, outlook))| {
            at_most.to_noise(noise, &error, &outlook, shared, of_pass, most)
        });
        Self {
            ends_with_pass: of_pass > 0 && ahead.samples == of_pass,
            ..ahead
        }
    }

    /// As far as to the `noise` at which a render is to stop, where `self` is the most there may be and `of_pass` what is left of the pass that
    /// is going on.
    fn to_noise(
        self,
        noise: f64,
        error: &ErrorEstimate,
        outlook: &Outlook<'_>,
        shared: &Shared,
        of_pass: u64,
        most: u32,
    ) -> Self {
        let film = &shared.film;
        let (samples, pixels) = (film.total_samples() as f64, film.pixels() as f64);
        let end_of_pass =
            |samples: f64| f64::from(end_of_even_pass(samples / pixels, most)) * pixels;
        let is_even = outlook.allotment.is_none();
        let way = outlook.way_to(noise, [LEAST_SAMPLES, most]);
        let way = way.map(|way| if is_even { way.up_to(end_of_pass) } else { way });
        let after_pass = samples + of_pass as f64;
        let largest = samples + self.samples as f64;
        let (total, is_estimate) = if let Some(way) = way {
            // As long as noise is not there, another pass begins.
            let least = match (of_pass, is_even) {
                (0, true) => end_of_pass(samples + pixels),
                (0, false) => samples * (1.0 + LEAST_SHARE),
                _ => after_pass,
            };
            let end = way.samples.value;
            (largest.min(end.max(least)), end < largest)
        } else if error.relmse.value <= noise * noise {
            let least = pixels * f64::from(LEAST_SAMPLES.min(most));
            (after_pass.max(least), after_pass < least)
        } else {
            (largest, false)
        };
        Self {
            samples: whole((total - samples).max(0.0)),
            is_known: true,
            is_estimate,
            time_to_stop: way.map(|way| way.seconds),
            ..self
        }
    }
}

impl Course {
    /// The error, and what it says of what is to come, where so much was rendered in `seconds`; `None` while nothing is known of it.
    pub fn outlook(&self, shared: &Shared, seconds: f64) -> Option<(ErrorEstimate, Outlook<'_>)> {
        let estimator = self.estimator.as_ref()?;
        let error = ErrorEstimator::estimate(estimator)?;
        let film = &shared.film;
        let samples = film.total_samples() as f64;
        // In the middle of a pass the error is known as it was before.
        let known = match &self.pass {
            Some(_) => samples.min(error.samples_per_pixel * film.pixels() as f64),
            None => samples,
        };
        let outlook = Outlook {
            estimator,
            allotment: self.allotment.as_ref(),
            samples: known,
            seconds: seconds * known / samples,
        };
        Some((error, outlook))
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
