//! How long a render still takes, as it foresees it itself.

use crate::render::{ErrorPoint, Interval, NOISE_TARGETS};
use crate::scene::Stop;

/// By how much the ends of an interval must differ from the value to be worth a word.
const NOTABLE: f64 = 1.1;

/// What is known of the time that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Left {
    /// In seconds.
    Foreseen(Interval),
    /// Nothing but how much is done.
    AtThisPace,
    /// Not even what there is to do in all.
    Unknown,
}

/// The time left of a render that ends by `stop` and has rendered for `elapsed` seconds, when `point` is the last that is known of its error.
pub(super) fn left(point: Option<&ErrorPoint>, stop: &Stop, elapsed: f64) -> Left {
    let limit = stop.seconds.unwrap_or(f64::INFINITY);
    let until = |seconds: f64| (seconds.min(limit) - elapsed).max(0.0);
    let foreseen = point.and_then(|point| point.time_to_stop);
    match foreseen {
        Some(end) => Left::Foreseen(Interval {
            value: until(end.value),
            low: until(end.low),
            high: until(end.high),
        }),
        None if stop.noise.is_some() && point.is_none() => Left::Unknown,
        None => Left::AtThisPace,
    }
}

/// Seconds as people say them, with their interval where it is wide.
pub(super) fn in_words(seconds: Interval) -> String {
    let Interval { value, low, high } = seconds;
    if high > value * NOTABLE || low < value / NOTABLE {
        format!(
            "{} ({} to {})",
            duration(value),
            duration(low),
            duration(high)
        )
    } else {
        duration(value)
    }
}

/// When noise falls to the levels that are still to come, from the start of rendering on.
pub(super) fn to_levels(point: &ErrorPoint) -> Vec<String> {
    let levels = NOISE_TARGETS.iter().zip(point.time_to);
    levels
        .filter_map(|(&noise, time)| Some(to_level(noise, time?)))
        .collect()
}

/// When noise falls to the next level.
pub(super) fn to_next_level(point: &ErrorPoint) -> Option<String> {
    let level = to_levels(point).into_iter().next()?;
    Some(format!("noise of {level}"))
}

fn to_level(noise: f64, seconds: Interval) -> String {
    format!("{:.0} % at {}", 100.0 * noise, in_words(seconds))
}

/// A time in the two largest units.
fn duration(seconds: f64) -> String {
    let units = |large: f64, small: f64, names: [&str; 2]| {
        let rounded = (seconds / small).round();
        let (more, less) = ((rounded * small / large).floor(), rounded % (large / small));
        format!("{more:.0} {} {less:.0} {}", names[0], names[1])
    };
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 119.5 => format!("{s:.0} s"),
        s if s < 7170.0 => units(60.0, 1.0, ["min", "s"]),
        s if s < 172_000.0 => units(3600.0, 60.0, ["h", "min"]),
        s if s < 8.64e8 => units(86400.0, 3600.0, ["d", "h"]),
        _ => "years".to_owned(),
    }
}

/// What is left at the pace so far, of which the part `done`, `0..=1`, took `elapsed` seconds; nothing while that is a guess.
pub(super) fn at_this_pace(done: f64, elapsed: f64) -> String {
    if done > 0.01 && elapsed > 0.2 {
        duration(elapsed * (1.0 - done) / done)
    } else {
        "?".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::ErrorEstimate;

    fn interval(value: f64, low: f64, high: f64) -> Interval {
        Interval { value, low, high }
    }

    fn point(time_to_stop: Option<Interval>) -> ErrorPoint {
        let exactly = interval(0.0016, 0.0016, 0.0016);
        ErrorPoint {
            seconds: 10.0,
            cpu_seconds: 20.0,
            error: ErrorEstimate {
                samples_per_pixel: 8.0,
                rmse: exactly,
                relmse: exactly,
                percentile_999: exactly,
                unmeasured_pixels: 0,
            },
            time_to: [
                None,
                Some(interval(18.0, 17.5, 18.5)),
                Some(interval(150.0, 100.0, 300.0)),
            ],
            time_to_stop,
        }
    }

    #[test]
    fn what_is_left_is_what_the_render_foresees() {
        let stop = Stop {
            noise: Some(0.03),
            ..Stop::default()
        };
        assert_eq!(left(None, &stop, 1.0), Left::Unknown);
        assert_eq!(left(None, &Stop::default(), 1.0), Left::AtThisPace);
        let foreseen = point(Some(interval(40.0, 30.0, 60.0)));
        let expected = Left::Foreseen(interval(25.0, 15.0, 45.0));
        assert_eq!(left(Some(&foreseen), &stop, 15.0), expected);
        let timed = Stop {
            seconds: Some(32.0),
            ..stop
        };
        let expected = Left::Foreseen(interval(17.0, 15.0, 17.0));
        assert_eq!(left(Some(&foreseen), &timed, 15.0), expected);
        let late = Left::Foreseen(interval(0.0, 0.0, 0.0));
        assert_eq!(left(Some(&foreseen), &stop, 61.0), late);
        assert_eq!(left(Some(&point(None)), &stop, 15.0), Left::AtThisPace);
    }

    #[test]
    fn times_are_said_as_people_say_them() {
        for (seconds, expected) in [
            (0.04, "0.0 s"),
            (9.94, "9.9 s"),
            (9.96, "10 s"),
            (119.0, "119 s"),
            (119.7, "2 min 0 s"),
            (3599.6, "60 min 0 s"),
            (7300.0, "2 h 2 min"),
            (259_200.0, "3 d 0 h"),
            (f64::INFINITY, "years"),
        ] {
            assert_eq!(duration(seconds), expected);
        }
        assert_eq!(in_words(interval(20.0, 19.0, 21.0)), "20 s");
        assert_eq!(in_words(interval(20.0, 15.0, 90.0)), "20 s (15 s to 90 s)");
        assert_eq!(at_this_pace(0.25, 10.0), "30 s");
        assert_eq!(at_this_pace(0.0, 10.0), "?");
    }

    #[test]
    fn levels_to_come_are_told_with_their_times() {
        let levels = to_levels(&point(None));
        assert_eq!(
            levels,
            ["3 % at 18 s", "1 % at 2 min 30 s (100 s to 5 min 0 s)"]
        );
        let next = to_next_level(&point(None));
        assert_eq!(next.as_deref(), Some("noise of 3 % at 18 s"));
    }
}
