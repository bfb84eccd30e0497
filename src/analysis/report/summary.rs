//! What the trials of a variant say together.

use serde::Serialize;

use super::digits::samples;
use super::fit::{TimeTo, log_slope, time_to};
use super::reference::Reference;
use super::study::Variant;
use super::trial::{Measurement, Trial, TrueErrors};
use crate::analysis::bench::Spread;
use crate::math::percent;
use crate::render::{Clamped, Ending, ErrorEstimate, Interval, NOISE_TARGETS, RenderStats};

/// Samples from which points count for slopes: with fewer, what a render does once weighs too much.
const SLOPE_FROM: f64 = 4.0;

/// Samples from which renders are taken at their word.
const HONEST_FROM: f64 = 16.0;

/// What was measured of a variant, over its seeds.
#[derive(Clone, Debug)]
pub struct Summary {
    /// What it took to prepare the scene.
    pub build_seconds: Spread,
    /// The moments that all trials pass, and last the end of each.
    pub points: Vec<SummaryPoint>,
    /// Exponent with which the true RMSE falls with render time, from 4 samples on.
    pub slope: Option<f64>,
    /// The same of the true noise.
    pub noise_slope: Option<f64>,
    /// At the last point.
    pub efficiency: Efficiency,
    /// How well the renders know their own error; `None` where none says from 16 samples on.
    pub honesty: Option<Honesty>,
    /// Samples from which on, to the last point, more than half of the measured mean square is not the renders': it is the error of
    /// the reference, or a difference that no sample cures. `None` where the last point is not like that.
    pub reference_outweighs_from: Option<f64>,
    /// When the median of the true noise falls to each of [`NOISE_TARGETS`].
    pub time_to: [Option<TimeTo>; NOISE_TARGETS.len()],
    /// What it took to the noise at which the renders stop; `None` where they stop at none.
    pub target: Option<Target>,
    /// Samples that were infinite or not a number, of all trials.
    pub non_finite_samples: u64,
    /// Samples that are negative in a channel, of all trials.
    pub negative_samples: u64,
    /// Samples of all trials, and the mean of the shares.
    pub clamped: Clamped,
    /// The most pixels that could not be measured, in any trial, as a value was infinite or not a number.
    pub unmeasured_pixels: u64,
}

/// What it took renders to the noise at which they were to stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What was asked for, as √relmse.
    pub noise: f64,
    /// How many renders say that they are there.
    pub reached: usize,
    /// Of how many.
    pub renders: usize,
    /// What those took that are; `None` where none is.
    pub took: Option<Took>,
}

/// Medians over renders; what is called a range holds the least and the largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Took {
    /// Mean over the pixels.
    pub samples_per_pixel: f64,
    /// Wall time of rendering.
    pub seconds: f64,
    /// Its range.
    pub seconds_range: [f64; 2],
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// Its range.
    pub cpu_seconds_range: [f64; 2],
}

/// The same moment of all trials.
#[derive(Clone, Copy, Debug)]
pub struct SummaryPoint {
    /// Median of the trials' means over pixels.
    pub samples_per_pixel: f64,
    /// Wall time of rendering.
    pub seconds: Spread,
    /// Wall time of preparing and rendering.
    pub seconds_with_build: Spread,
    /// Processor time of the threads that render.
    pub cpu_seconds: Spread,
    /// What the renders know by themselves; `None` before all of them can tell.
    pub estimated: Option<Estimated>,
    /// Distance from the reference.
    pub measured_rmse: Spread,
    /// The same, relative.
    pub measured_relmse: Spread,
    /// Distance from the truth: [`Self::measured_rmse`] without the reference's own error.
    pub true_rmse: Spread,
    /// The same, relative.
    pub true_relmse: Spread,
    /// What the worst channel's error exceeds in one pixel of a thousand.
    pub true_percentile_999: Spread,
}

/// What renders know of their own error.
#[derive(Clone, Copy, Debug)]
pub struct Estimated {
    /// Root mean square error.
    pub rmse: Spread,
    /// Medians of the ends of the interval.
    pub rmse_interval: [f64; 2],
    /// Mean squared relative error.
    pub relmse: Spread,
    /// Medians of the ends of the interval.
    pub relmse_interval: [f64; 2],
    /// How many of the renders have the truth in their intervals, that of the RMSE and that of relmse.
    pub intervals_held: [usize; 2],
    /// What the worst channel's error exceeds in one pixel of a thousand.
    pub percentile_999: Spread,
    /// Medians of the ends of the interval.
    pub percentile_999_interval: [f64; 2],
}

/// What the renders say of themselves against the truth, at all points from 16 samples on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Honesty {
    /// The smallest and the largest estimate over the truth, medians over the seeds, of RMSE and noise.
    pub estimated_over_true: [f64; 2],
    /// How many of the 95 % intervals hold the truth, of RMSE and relmse of every render.
    pub intervals_held: usize,
    /// Number of these intervals.
    pub intervals: usize,
}

/// What time buys: 1 / (relMSE · seconds), median. Four times as much halves the noise after the same time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Efficiency {
    /// Of wall time.
    pub wall: f64,
    /// Of the processor time.
    pub cpu: f64,
}

impl SummaryPoint {
    /// The true noise, √relmse.
    #[must_use]
    pub fn true_noise(&self) -> Spread {
        root(self.true_relmse)
    }

    /// The median of the true noise, in words.
    #[must_use]
    pub fn noise_in_words(&self) -> String {
        let noise = self.true_noise().median;
        if noise == 0.0 && self.measured_relmse.median > 0.0 {
            return "no noise that the reference's own error would not explain".to_owned();
        }
        format!("{} noise", percent(noise))
    }

    /// The estimated noise.
    #[must_use]
    pub fn estimated_noise(&self) -> Option<Spread> {
        Some(root(self.estimated?.relmse))
    }
}

fn root(Spread { median, min, max }: Spread) -> Spread {
    Spread {
        median: median.sqrt(),
        min: min.sqrt(),
        max: max.sqrt(),
    }
}

impl Summary {
    /// The summary of the trials of `variant`. Where some have more moments than others, only what comes before the end of the shortest is
    /// compared moment by moment, and the last point is the end of each. `None` without a trial.
    #[must_use]
    pub fn of(variant: &Variant, reference: &Reference) -> Option<Self> {
        let trials = &variant.trials;
        let moments = trials.iter().map(|trial| trial.measurements.len()).min()?;
        let before = (0..moments.saturating_sub(1)).filter_map(|moment| {
            let at: Vec<_> = trials
                .iter()
                .map(|t| (t, &t.measurements[moment]))
                .collect();
            point(&at, reference)
        });
        let ends = trials.iter().map(|t| Some((t, t.measurements.last()?)));
        let ends: Option<Vec<_>> = ends.collect();
        let end = ends.as_ref().and_then(|ends| point(ends, reference));
        let points: Vec<_> = before.chain(end).collect();
        let curve = |error: fn(&SummaryPoint) -> f64, from: f64| -> Vec<(f64, f64)> {
            let late = points.iter().filter(|p| p.samples_per_pixel >= from);
            late.map(|p| (p.seconds.median, error(p))).collect()
        };
        let noise: fn(&SummaryPoint) -> f64 = |point| point.true_noise().median;
        let noise_slope = log_slope(&curve(noise, SLOPE_FROM));
        let noise_curve = curve(noise, 0.0);
        let pixels = reference.image.pixels.len() as u64;
        Some(Self {
            build_seconds: spread(trials.iter().map(|trial| trial.build_seconds))?,
            slope: log_slope(&curve(|point| point.true_rmse.median, SLOPE_FROM)),
            noise_slope,
            honesty: honesty(&points, trials.len()),
            reference_outweighs_from: reference_outweighs_from(&points, reference),
            efficiency: efficiency(&ends.unwrap_or_default(), reference),
            time_to: NOISE_TARGETS.map(|noise| time_to(&noise_curve, noise, noise_slope)),
            target: target(variant),
            non_finite_samples: trials.iter().map(|t| t.stats.non_finite_samples).sum(),
            negative_samples: trials.iter().map(|t| t.stats.negative_samples).sum(),
            clamped: Clamped {
                samples: trials.iter().map(|t| t.stats.clamped.samples).sum(),
                energy_share: {
                    let shares = trials.iter().map(|t| t.stats.clamped.energy_share);
                    shares.sum::<f64>() / trials.len() as f64
                },
            },
            unmeasured_pixels: {
                let measurements = trials.iter().flat_map(|trial| &trial.measurements);
                let unmeasured = measurements.map(|m| pixels - m.measured.compared_pixels);
                unmeasured.max().unwrap_or_default()
            },
            points,
        })
    }
}

impl Summary {
    /// Why the errors are not those of the renders, where that is so.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let from = self.reference_outweighs_from?;
        let plural = if from == 1.0 { "" } else { "s" };
        Some(format!(
            "from {} sample{plural} per pixel on, more than half of the mean square that is measured is not the noise of the renders: it is \
            the reference's own error, or a difference that no sample cures",
            samples(from)
        ))
    }
}

fn spread(values: impl Iterator<Item = f64>) -> Option<Spread> {
    Spread::of(values.collect())
}

/// A trial and a moment of it.
type Moment<'a> = (&'a Trial, &'a Measurement);

/// What was measured at a moment of each trial.
fn point(moments: &[Moment<'_>], reference: &Reference) -> Option<SummaryPoint> {
    let of = |value: &dyn Fn(&Measurement) -> f64| spread(moments.iter().map(|(_, m)| value(m)));
    let truth = |m: &Measurement| m.true_errors(reference);
    let with_build = moments.iter().map(|(t, m)| t.build_seconds + m.seconds);
    Some(SummaryPoint {
        samples_per_pixel: of(&|m| m.samples_per_pixel)?.median,
        seconds: of(&|m| m.seconds)?,
        seconds_with_build: spread(with_build)?,
        cpu_seconds: of(&|m| m.cpu_seconds)?,
        estimated: estimated(moments, reference),
        measured_rmse: of(&|m| m.measured.rmse())?,
        measured_relmse: of(&|m| m.measured.relmse)?,
        true_rmse: of(&|m| truth(m).mse.sqrt())?,
        true_relmse: of(&|m| truth(m).relmse)?,
        true_percentile_999: of(&|m| truth(m).percentile_999)?,
    })
}

fn estimated(moments: &[Moment<'_>], reference: &Reference) -> Option<Estimated> {
    let measurements = moments.iter().map(|(_, measurement)| *measurement);
    let estimates: Option<Vec<ErrorEstimate>> = measurements.clone().map(|m| m.estimated).collect();
    let estimates = estimates?;
    let truths: Vec<_> = measurements.map(|m| m.true_errors(reference)).collect();
    let held = |interval: fn(&ErrorEstimate) -> Interval, truth: fn(&TrueErrors) -> f64| {
        let both = estimates.iter().zip(&truths);
        both.filter(|(estimate, errors)| interval(estimate).contains(truth(errors)))
            .count()
    };
    let of = |value: &dyn Fn(&ErrorEstimate) -> f64| spread(estimates.iter().map(value));
    let ends = |interval: fn(&ErrorEstimate) -> Interval| {
        let low = of(&|estimate| interval(estimate).low)?;
        let high = of(&|estimate| interval(estimate).high)?;
        Some([low.median, high.median])
    };
    Some(Estimated {
        rmse: of(&|estimate| estimate.rmse.value)?,
        rmse_interval: ends(|estimate| estimate.rmse)?,
        relmse: of(&|estimate| estimate.relmse.value)?,
        relmse_interval: ends(|estimate| estimate.relmse)?,
        intervals_held: [
            held(|estimate| estimate.rmse, |truth| truth.mse.sqrt()),
            held(|estimate| estimate.relmse, |truth| truth.relmse),
        ],
        percentile_999: of(&|estimate| estimate.percentile_999.value)?,
        percentile_999_interval: ends(|estimate| estimate.percentile_999)?,
    })
}

fn honesty(points: &[SummaryPoint], trials: usize) -> Option<Honesty> {
    let late = points.iter().filter(|p| p.samples_per_pixel >= HONEST_FROM);
    let pairs = late.filter_map(|point| Some((point, point.estimated?)));
    let honesty = pairs.map(|(point, estimated)| {
        let ratios = [
            estimated.rmse.median / point.true_rmse.median,
            (estimated.relmse.median / point.true_relmse.median).sqrt(),
        ];
        Honesty {
            estimated_over_true: [ratios[0].min(ratios[1]), ratios[0].max(ratios[1])],
            intervals_held: estimated.intervals_held.iter().sum(),
            intervals: 2 * trials,
        }
    });
    honesty.reduce(|a, b| Honesty {
        estimated_over_true: [
            a.estimated_over_true[0].min(b.estimated_over_true[0]),
            a.estimated_over_true[1].max(b.estimated_over_true[1]),
        ],
        intervals_held: a.intervals_held + b.intervals_held,
        intervals: a.intervals + b.intervals,
    })
}

fn reference_outweighs_from(points: &[SummaryPoint], reference: &Reference) -> Option<f64> {
    let outweighed = points.iter().rev().take_while(|point| {
        let most = point
            .estimated
            .map(|estimated| estimated.relmse_interval[1]);
        reference.outweighs(point.measured_relmse.median, most)
    });
    outweighed.last().map(|point| point.samples_per_pixel)
}

/// Efficiency at the `ends` of trials.
fn efficiency(ends: &[Moment<'_>], reference: &Reference) -> Efficiency {
    let of = |seconds: fn(&Measurement) -> f64| {
        let each = ends
            .iter()
            .map(|(_, end)| (end.true_errors(reference).relmse * seconds(end)).recip());
        spread(each).map_or(f64::NAN, |spread| spread.median)
    };
    Efficiency {
        wall: of(|m| m.seconds),
        cpu: of(|m| m.cpu_seconds),
    }
}

fn target(variant: &Variant) -> Option<Target> {
    let trials = &variant.trials;
    let reached = || trials.iter().filter(|t| t.stats.ending == Ending::Noise);
    let of = |value: fn(&RenderStats) -> f64| spread(reached().map(|t| value(&t.stats)));
    let took = || {
        let (seconds, cpu_seconds) = (of(|s| s.render_seconds)?, of(|s| s.cpu_seconds)?);
        Some(Took {
            samples_per_pixel: of(|s| s.samples_per_pixel)?.median,
            seconds: seconds.median,
            seconds_range: [seconds.min, seconds.max],
            cpu_seconds: cpu_seconds.median,
            cpu_seconds_range: [cpu_seconds.min, cpu_seconds.max],
        })
    };
    Some(Target {
        noise: variant.scene.render.stop.noise?,
        reached: reached().count(),
        renders: trials.len(),
        took: took(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::{Study, test_data};

    /// The data halve the noise when time doubles: 40 % after 1 s with 1 sample, 5 % after 8 s with 8, times a factor per seed.
    #[test]
    fn a_summary_has_the_medians_and_ends_over_the_seeds() {
        let study = test_data::study();
        let summary = Summary::of(&study.variants[0], &study.reference).expect("has trials");
        assert_eq!(summary.points.len(), 4);
        let last = summary.points[3];
        assert_eq!(last.samples_per_pixel, 8.0);
        assert_eq!(last.seconds.median, 8.0);
        assert_eq!(last.seconds_with_build.median, 8.5);
        assert_eq!(last.cpu_seconds.median, 16.0);
        let noise = last.true_noise();
        for (found, expected) in [
            (noise.median, 0.05),
            (noise.min, 0.04),
            (noise.max, 0.06),
            (summary.slope.expect("is there"), -1.0),
            (summary.noise_slope.expect("is there"), -1.0),
            (summary.efficiency.wall, 50.0),
            (summary.efficiency.cpu, 25.0),
            (last.estimated_noise().expect("is there").median, 0.05),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
        assert!(summary.points[1].estimated.is_none());
        // 10 % is a point, 3 % and 1 % are ahead.
        let times = summary.time_to.map(|time| time.expect("falls"));
        for (time, expected) in times.iter().zip([4.0, 40.0 / 3.0, 40.0]) {
            assert!((time.seconds / expected - 1.0).abs() < 1e-9, "{time:?}");
        }
        assert_eq!(times.map(|time| time.predicted), [false, true, true]);
        assert_eq!(summary.non_finite_samples, 6);
        assert_eq!(summary.unmeasured_pixels, 0);
    }

    /// By hand: an RMSE of 0.1 with the interval from 0.08 to 0.125 where 0.1 / 1.1 is true, and a relmse of 0.04 with that from
    /// 0.032 to 0.05 where four times as much is.
    #[test]
    fn estimates_are_held_against_the_truth() {
        let mut study = test_data::study();
        assert_eq!(summary_of(&study).honesty, None, "fewer than 16 samples");
        for trial in &mut study.variants[0].trials {
            let mut measurement = test_data::measurement(16.0, 16.0, 0.01, 0.04);
            measurement.measured.mse = 0.01 / 1.21;
            measurement.measured.relmse = 0.16;
            trial.measurements.push(measurement);
        }
        let honesty = summary_of(&study).honesty.expect("is there");
        let [least, most] = honesty.estimated_over_true;
        assert!((least - 0.5).abs() < 1e-9 && (most - 1.1).abs() < 1e-9);
        assert_eq!((honesty.intervals_held, honesty.intervals), (3, 6));
    }

    /// The noise of the data after 1, 2, 4 and 8 samples has the squares 0.16, 0.04, 0.01 and 0.0025. A reference with as much as the
    /// render of 4 samples makes half of what is measured there, and more of it after 8.
    #[test]
    fn the_reference_outweighs_the_renders_from_some_samples_on() {
        let mut study = test_data::study();
        let from = |study: &Study| summary_of(study).reference_outweighs_from;
        assert_eq!(from(&study), None, "exact");
        study.reference = test_data::file_reference(None);
        assert_eq!(
            from(&study),
            None,
            "all that is measured is what the renders say"
        );
        for own in [0.01, 0.011] {
            let mut study = study.clone();
            let of_trials = study.variants[0].trials.iter_mut();
            for measurement in of_trials.flat_map(|trial| &mut trial.measurements) {
                measurement.measured.relmse += own;
            }
            // The interval of an estimate reaches a quarter above it, and must be below half of what is measured.
            assert_eq!(from(&study), Some(8.0), "{own}");
            study.reference = test_data::file_reference(Some(own));
            assert_eq!(from(&study), Some(if own > 0.01 { 4.0 } else { 8.0 }));
            study.reference = test_data::rendered_reference(0.1, own);
            assert_eq!(from(&study), Some(if own > 0.01 { 4.0 } else { 8.0 }));
        }
    }

    #[test]
    fn the_time_to_the_noise_that_was_asked_for_is_that_of_the_renders_that_reached_it() {
        let mut study = test_data::study();
        let variant = &mut study.variants[0];
        assert_eq!(target(variant), None);
        variant.scene.render.stop.noise = Some(0.05);
        let nobody = target(variant).expect("is asked for");
        assert_eq!((nobody.reached, nobody.took), (0, None));
        for (trial, seconds) in variant.trials.iter_mut().zip([8.0, 6.0]) {
            trial.stats.ending = Ending::Noise;
            trial.stats.render_seconds = seconds;
            trial.stats.cpu_seconds = 2.0 * seconds;
        }
        let target = target(variant).expect("is asked for");
        assert_eq!((target.noise, target.reached, target.renders), (0.05, 2, 3));
        let took = target.took.expect("two are there");
        assert_eq!((took.seconds, took.seconds_range), (7.0, [6.0, 8.0]));
        assert_eq!(took.cpu_seconds_range, [12.0, 16.0]);
    }

    fn summary_of(study: &Study) -> Summary {
        Summary::of(&study.variants[0], &study.reference).expect("has trials")
    }

    #[test]
    fn the_ends_of_trials_that_stop_early_are_one_point() {
        let mut study = test_data::study();
        study.variants[0].trials[1].measurements.pop();
        let summary = summary_of(&study);
        let samples: Vec<f64> = summary.points.iter().map(|p| p.samples_per_pixel).collect();
        assert_eq!(samples, [1.0, 2.0, 8.0]);
        let end = summary.points[2];
        assert_eq!((end.seconds.min, end.seconds.max), (4.0, 8.0));
        // After 8, 4 and 8 s noise is 5 %, 8 % and 6 %.
        let noise = end.true_noise();
        assert!((noise.median - 0.06).abs() < 1e-9 && (noise.max - 0.08).abs() < 1e-9);
        let expected = (0.08 * 0.08 * 4.0_f64).recip();
        assert!((summary.efficiency.wall / expected - 1.0).abs() < 1e-9);
        study.variants[0].trials.clear();
        assert!(Summary::of(&study.variants[0], &study.reference).is_none());
    }
}
