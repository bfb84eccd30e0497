//! What the window knows of how long a render will take, before it is begun: measured when somebody asks.

use std::time::Duration;

use super::part::Part;
use super::status_bar::duration;
use super::threads::Threads;
use crate::analysis::pilot::TimeEstimate;
use crate::scene::Scene;

/// What was asked about.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The scene.
    pub scene: Scene,
    /// What of its picture is rendered.
    pub part: Part,
    /// By whom.
    pub threads: Threads,
}

/// What is known.
#[derive(Clone, Debug, Default)]
pub enum TimeState {
    /// Nothing.
    #[default]
    Unknown,
    /// It is being found out.
    Measuring,
    /// It was found out.
    Known {
        /// Of this.
        subject: Box<Subject>,
        /// The time.
        estimate: TimeEstimate,
    },
}

/// An estimate in a few words.
#[must_use]
pub fn in_short(estimate: &TimeEstimate) -> String {
    let about = if estimate.is_bound { "up to" } else { "about" };
    format!("{about} {}", rounded(estimate.seconds.value))
}

/// An estimate and how far it may be off.
#[must_use]
pub fn in_words(estimate: &TimeEstimate) -> String {
    let [low, high] = [estimate.seconds.low, estimate.seconds.high].map(rounded);
    let range = if low == high {
        String::new()
    } else {
        format!(" ({low} to {high})")
    };
    let note = if estimate.is_bound {
        ", or until the noise is low enough"
    } else {
        ""
    };
    format!("The render takes {}{range}{note}", in_short(estimate))
}

/// So many seconds with no more digits than an estimate has.
#[must_use]
pub fn rounded(seconds: f64) -> String {
    let unit = 10.0_f64.powf(seconds.abs().max(1e-3).log10().floor() - 1.0);
    let seconds = (seconds / unit).round() * unit;
    let time = Duration::try_from_secs_f64(seconds).map_or_else(|_| "ages".to_owned(), duration);
    time.replace(".0 s", " s")
        .trim_end_matches(" 00 s")
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Interval;

    #[test]
    fn estimates_have_two_digits() {
        let mut estimate = TimeEstimate {
            seconds: Interval {
                value: 12.345,
                low: 11.2,
                high: 13.4,
            },
            is_bound: false,
            samples: 16.0,
        };
        assert_eq!(in_short(&estimate), "about 12 s");
        assert_eq!(
            in_words(&estimate),
            "The render takes about 12 s (11 s to 13 s)"
        );
        estimate.is_bound = true;
        estimate.seconds.value = 0.0123;
        assert_eq!(in_short(&estimate), "up to 12 ms");
        estimate.seconds.value = 181.0;
        assert_eq!(in_short(&estimate), "up to 3 min");
        estimate.seconds.value = 4567.0;
        assert_eq!(in_short(&estimate), "up to 1 h 16 min");
        estimate.seconds.value = f64::INFINITY;
        assert_eq!(in_short(&estimate), "up to ages");
    }
}
