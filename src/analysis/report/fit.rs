//! Laws drawn through points of error against time, on logarithmic axes.

use serde::Serialize;

/// The shallowest slope that is followed beyond a curve: independent samples fall with −0.5, and what falls by less than half of that is
/// held up by something that samples do not cure.
pub(super) const SHALLOWEST: f64 = -0.25;

/// How many times as far as it was measured a curve is followed: beyond, a slope that is off by a tenth is off by years.
const FARTHEST: f64 = 100.0;

/// When a curve is down to a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeTo {
    /// Seconds of rendering.
    pub seconds: f64,
    /// Whether the curve ends before, and its slope was followed.
    pub predicted: bool,
    /// Whether it was there by then, and nobody saw when it got there.
    pub at_most: bool,
}

/// The slope of the straight line that is nearest to `points` in the sense of least squares, both coordinates taken as
/// logarithms: the exponent p of y = c·xᵖ. Points without a logarithm are left out; `None` where no two are left with different x.
#[must_use]
pub fn log_slope(points: &[(f64, f64)]) -> Option<f64> {
    let has_logarithm = |value: f64| value > 0.0 && value.is_finite();
    let logarithms: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| has_logarithm(*x) && has_logarithm(*y))
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = logarithms.len() as f64;
    let mean_x = logarithms.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = logarithms.iter().map(|(_, y)| y).sum::<f64>() / count;
    let (mut squares, mut products) = (0.0, 0.0);
    for (x, y) in logarithms {
        squares += (x - mean_x) * (x - mean_x);
        products += (x - mean_x) * (y - mean_y);
    }
    (squares > 0.0).then(|| products / squares)
}

/// When a curve of (seconds, noise) falls to `level`: between two points along the straight line on logarithmic axes, after the
/// last along `slope`. `None` where there is no curve, or a slope that does not lead there or is too shallow to trust, and where it leads
/// more than a hundred times as far as the curve goes.
#[must_use]
pub fn time_to(curve: &[(f64, f64)], level: f64, slope: Option<f64>) -> Option<TimeTo> {
    let Some(reached) = curve.iter().position(|&(_, noise)| noise <= level) else {
        let &(seconds, noise) = curve.last()?;
        let slope = slope.filter(|&slope| slope <= SHALLOWEST)?;
        let times = (level / noise).powf(slope.recip());
        return (times <= FARTHEST).then_some(TimeTo {
            seconds: seconds * times,
            predicted: true,
            at_most: false,
        });
    };
    let (late, low) = curve[reached];
    let before = reached.checked_sub(1).map(|before| curve[before]);
    Some(match before {
        // An error of 0 has no place on the axis.
        Some((early, high)) if low > 0.0 && early > 0.0 && high.is_finite() => {
            let share = (high / level).ln() / (high / low).ln();
            TimeTo {
                seconds: early * (late / early).powf(share),
                predicted: false,
                at_most: false,
            }
        }
        _ => TimeTo {
            seconds: late,
            predicted: false,
            at_most: true,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<f64>, expected: f64) -> bool {
        found.is_some_and(|found| (found - expected).abs() < 1e-12 * expected.abs())
    }

    /// By hand: over log₂ x = 0, 1, 2 the logarithms 0, −1, −1 give a slope of −1/2.
    #[test]
    fn a_slope_is_that_of_least_squares() {
        assert!(near(log_slope(&[(1.0, 1.0), (2.0, 0.5), (4.0, 0.5)]), -0.5));
        let law: Vec<_> = [0.1, 0.3, 5.0]
            .map(|x: f64| (x, 7.0 * x.powf(-0.75)))
            .into();
        assert!(near(log_slope(&law), -0.75));
        let spoilt = [(1.0, 4.0), (2.0, 0.0), (3.0, f64::NAN), (4.0, 1.0)];
        assert!(near(log_slope(&spoilt), -1.0));
        for few in [&[][..], &[(1.0, 1.0)], &[(1.0, 1.0), (1.0, 2.0)]] {
            assert_eq!(log_slope(few), None);
        }
    }

    /// By hand: from (1 s, 40 %) to (16 s, 10 %) noise falls as t^−1/2, so it is 20 % after 4 s, and 5 % after 64 s.
    #[test]
    fn a_level_is_found_between_before_and_after_the_points() {
        let curve = [(1.0, 0.4), (16.0, 0.1)];
        let between = time_to(&curve, 0.2, None).expect("is there");
        assert!(near(Some(between.seconds), 4.0) && !between.predicted && !between.at_most);
        let after = time_to(&curve, 0.05, Some(-0.5)).expect("is ahead");
        assert!(near(Some(after.seconds), 64.0) && after.predicted && !after.at_most);
        let before = time_to(&curve, 0.5, Some(-0.5)).expect("is past");
        assert_eq!((before.seconds, before.at_most), (1.0, true));
        assert!(!before.predicted);
        let at_a_point = time_to(&curve, 0.1, None).expect("is there");
        assert!(near(Some(at_a_point.seconds), 16.0) && !at_a_point.at_most);
    }

    #[test]
    fn a_level_that_is_never_reached_has_no_time() {
        let curve = [(1.0, 0.4), (16.0, 0.1)];
        assert_eq!(time_to(&curve, 0.05, Some(0.1)), None);
        assert_eq!(time_to(&curve, 0.05, None), None);
        assert_eq!(time_to(&curve, 1e-300, Some(-1e-6)), None);
        assert_eq!(time_to(&curve, 0.09, Some(-0.24)), None);
        // By hand: a ninth of the noise takes 81 times as long, an eleventh 121 times.
        assert!(time_to(&curve, 0.1 / 9.0, Some(-0.5)).is_some());
        assert_eq!(time_to(&curve, 0.1 / 11.0, Some(-0.5)), None);
        assert_eq!(time_to(&[], 0.05, Some(-0.5)), None);
        assert_eq!(time_to(&[(1.0, f64::NAN)], 0.05, Some(-0.5)), None);
        // Where the error vanishes at once, the way there is not known.
        let exact = time_to(&[(1.0, 0.4), (2.0, 0.0)], 0.1, None).expect("is there");
        assert_eq!((exact.seconds, exact.at_most), (2.0, true));
    }
}
