//! How well renders know their own error.

use serde::Serialize;

use super::summary::SummaryPoint;

/// Samples from which renders are taken at their word.
const HONEST_FROM: f64 = 16.0;

/// Relative errors below this are of numbers of 32 bits, not of sampling: each is rounded by up to 6e-8 of itself, a sum of many by more.
const ROUNDING: f64 = 1e-6;

/// How many intervals of a hundred are to hold the truth.
const CONFIDENCE: f64 = 0.95;

/// So rarely as few intervals as are called too few hold the truth where each does with [`CONFIDENCE`] and none depends on others.
const TOO_RARE: f64 = 0.01;

/// What the renders say of themselves against the truth, at all points from 16 samples on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Honesty {
    /// The smallest and the largest estimate over the truth, medians over the seeds, of RMSE and noise; `None` where all are as exact as
    /// numbers are.
    pub estimated_over_true: Option<[f64; 2]>,
    /// How many of the 95 % intervals hold the truth, of RMSE and relmse of every render.
    pub intervals_held: usize,
    /// Number of these intervals.
    pub intervals: usize,
    /// Pairs of an estimate and a truth that are both no more than rounding, and so are not compared.
    pub as_exact_as_numbers: usize,
}

/// Whether a mean squared relative error is no more than that of rounding.
pub(super) fn is_rounding(relmse: f64) -> bool {
    relmse < ROUNDING * ROUNDING
}

impl Honesty {
    /// That of `renders` renders with these points; `None` where none tells of its error from 16 samples on.
    pub(super) fn of(points: &[SummaryPoint], renders: usize) -> Option<Self> {
        let late = points.iter().filter(|p| p.samples_per_pixel >= HONEST_FROM);
        let pairs = late.filter_map(|point| Some((point, point.estimated?)));
        let at_points = pairs.map(|(point, estimated)| {
            let ratios = [
                estimated.rmse.median / point.true_rmse.median,
                (estimated.relmse.median / point.true_relmse.median).sqrt(),
            ];
            let range = [ratios[0].min(ratios[1]), ratios[0].max(ratios[1])];
            Self {
                estimated_over_true: (!point.is_exact()).then_some(range),
                intervals_held: estimated.intervals_held.iter().sum(),
                intervals: 2 * (renders - estimated.as_exact_as_numbers),
                as_exact_as_numbers: 2 * estimated.as_exact_as_numbers,
            }
        });
        at_points.reduce(|a, b| Self {
            estimated_over_true: match (a.estimated_over_true, b.estimated_over_true) {
                (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
                (a, b) => a.or(b),
            },
            intervals_held: a.intervals_held + b.intervals_held,
            intervals: a.intervals + b.intervals,
            as_exact_as_numbers: a.as_exact_as_numbers + b.as_exact_as_numbers,
        })
    }

    /// The range of the ratios, where they are numbers.
    #[must_use]
    pub fn ratios(&self) -> Option<[f64; 2]> {
        let are_numbers = |ratios: &[f64; 2]| ratios.iter().all(|ratio| ratio.is_finite());
        self.estimated_over_true.filter(are_numbers)
    }

    /// Whether fewer intervals hold the truth than is likely where each does with 95 %: where they were independent, fewer than one report
    /// in a hundred would have so few.
    #[must_use]
    pub fn holds_too_few(&self) -> bool {
        likelihood_of_missing(self.intervals - self.intervals_held, self.intervals) < TOO_RARE
    }

    /// What came out, in a line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut parts = Vec::new();
        if let Some([least, most]) = self.ratios() {
            parts.push(format!(
                "estimated / true error {least:.2} to {most:.2} from 16 samples on"
            ));
        }
        if self.intervals > 0 {
            let few = if self.holds_too_few() {
                ", too few for 95 %"
            } else {
                ""
            };
            parts.push(format!(
                "{} of {} intervals held the truth{few}",
                self.intervals_held, self.intervals
            ));
        }
        if self.as_exact_as_numbers > 0 {
            parts.push(format!(
                "{} pairs of estimated and true error are as exact as numbers are",
                self.as_exact_as_numbers
            ));
        }
        parts.join(", ")
    }
}

/// How likely at least `missing` of `count` independent intervals miss the truth, each with one in twenty: the upper end of a binomial
/// distribution.
fn likelihood_of_missing(missing: usize, count: usize) -> f64 {
    let odds = ((1.0 - CONFIDENCE) / CONFIDENCE).ln();
    // Logarithms, as the first terms of many intervals are too small for a number.
    let mut term = count as f64 * CONFIDENCE.ln();
    let mut fewer = 0.0;
    for number in 0..missing {
        fewer += term.exp();
        term += ((count - number) as f64 / (number + 1) as f64).ln() + odds;
    }
    1.0 - fewer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::{Study, Summary, test_data};

    fn summary_of(study: &Study) -> Summary {
        Summary::of(&study.variants[0], &study.reference).expect("has trials")
    }

    /// A study whose renders have a further measurement, of 16 samples: what they say and what is true, RMSE and relmse squared.
    fn study_with(said: [f64; 2], truth: [f64; 2]) -> Study {
        let mut study = test_data::study();
        for trial in &mut study.variants[0].trials {
            let mut measurement = test_data::measurement(16.0, 16.0, said[0], said[1]);
            measurement.measured.mse = truth[0];
            measurement.measured.relmse = truth[1];
            trial.measurements.push(measurement);
        }
        study
    }

    /// By hand: an RMSE of 0.1 with the interval from 0.08 to 0.125 where 0.1 / 1.1 is true, and a relmse of 0.04 with that from
    /// 0.032 to 0.05 where four times as much is.
    #[test]
    fn estimates_are_held_against_the_truth() {
        let early = summary_of(&test_data::study());
        assert_eq!(early.honesty, None, "fewer than 16 samples");
        let study = study_with([0.01, 0.04], [0.01 / 1.21, 0.16]);
        let honesty = summary_of(&study).honesty.expect("is there");
        let [least, most] = honesty.ratios().expect("are numbers");
        assert!((least - 0.5).abs() < 1e-9 && (most - 1.1).abs() < 1e-9);
        assert_eq!((honesty.intervals_held, honesty.intervals), (3, 6));
        assert_eq!(honesty.as_exact_as_numbers, 0);
    }

    /// A render that is exact but for rounding, and says so, is right, whatever the ratio of two such numbers is.
    #[test]
    fn renders_as_exact_as_numbers_are_counted_apart() {
        for truth in [[0.0, 0.0], [1e-16, 1e-15]] {
            let study = study_with([2e-18, 2e-18], truth);
            let summary = summary_of(&study);
            let honesty = summary.honesty.expect("is there");
            assert_eq!(honesty.estimated_over_true, None);
            assert_eq!((honesty.intervals_held, honesty.intervals), (0, 0));
            assert_eq!(honesty.as_exact_as_numbers, 6);
            assert!(!honesty.holds_too_few());
            let said = honesty.in_words();
            let expected = "6 pairs of estimated and true error are as exact as numbers are";
            assert_eq!(said, expected);
            assert!(summary.points[4].is_exact() && !summary.points[3].is_exact());
        }
        // A large estimate of no error is wrong, and so is a small one of a large error.
        for (said, truth) in [([0.01, 0.04], [0.0, 0.0]), ([0.0, 0.0], [0.01, 0.04])] {
            let study = study_with(said, truth);
            let honesty = summary_of(&study).honesty.expect("is there");
            assert_eq!((honesty.intervals_held, honesty.intervals), (0, 6));
            assert_eq!(honesty.as_exact_as_numbers, 0);
            assert!(!honesty.in_words().contains("inf") && honesty.holds_too_few());
        }
    }

    /// By hand: of 3 intervals all miss with 0.05³, and any does with 1 − 0.95³. Of 50, 36 or fewer hold in far less than one report of a
    /// hundred, 46 in 24 of them (table of the binomial distribution: 1 − 0.7604).
    #[test]
    fn too_few_intervals_are_those_that_chance_does_not_explain() {
        for (missing, count, expected) in [
            (0, 3, 1.0),
            (1, 3, 1.0 - 0.95_f64.powi(3)),
            (3, 3, 0.05_f64.powi(3)),
            (4, 50, 1.0 - 0.7604),
        ] {
            let found = likelihood_of_missing(missing, count);
            assert!(
                (found - expected).abs() < 1e-4,
                "{missing} of {count}: {found}"
            );
        }
        let with = |intervals_held, intervals| Honesty {
            estimated_over_true: None,
            intervals_held,
            intervals,
            as_exact_as_numbers: 0,
        };
        assert!(with(36, 50).holds_too_few() && !with(46, 50).holds_too_few());
        assert!(with(36, 50).in_words().contains("too few"));
        // About 2000 of 40,000 miss, give or take 44.
        assert!(!with(37_950, 40_000).holds_too_few() && with(37_800, 40_000).holds_too_few());
    }
}
