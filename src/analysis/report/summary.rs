//! What the trials of a variant say together.

use serde::Serialize;

use super::digits::samples;
use super::fit::{TimeTo, log_slope, time_to};
use super::honesty::{Honesty, is_rounding};
use super::reference::Reference;
use super::study::Variant;
use super::target::Target;
use super::trial::{Measurement, Trial, TrueErrors};
use crate::analysis::bench::Spread;
use crate::math::{percent, signed};
use crate::render::{Clamped, ErrorEstimate, Interval, NOISE_TARGETS};

/// Samples from which points count for slopes: with fewer, what a render does once weighs too much.
const SLOPE_FROM: f64 = 4.0;

/// Below this share of the processor time that their threads could have had, something kept renders from it.
const BUSY_SHARE: f64 = 0.7;

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
    pub noise_slope: Option<Slope>,
    /// The same of the true noise with processor time, which other programs on the machine hardly change.
    pub cpu_noise_slope: Option<Slope>,
    /// The processor time of the renders over what their threads could have had in their time, `0..=1`; `None` where that is not known.
    pub cpu_share: Option<f64>,
    /// Whether it shows another picture than the scene as it is, so that no sample brings it to the reference.
    pub shows_another_picture: bool,
    /// At the last point.
    pub efficiency: Efficiency,
    /// How well the renders know their own error; `None` where none says from 16 samples on.
    pub honesty: Option<Honesty>,
    /// Samples from which on, to the last point, more than half of the measured mean square is not the renders': it is the error of
    /// the reference, or a difference that no sample cures. `None` where the last point is not like that.
    pub reference_outweighs_from: Option<f64>,
    /// When the median of the true noise falls to each of [`NOISE_TARGETS`]: beyond the points along [`Self::cpu_noise_slope`], where
    /// nothing but noise is measured.
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

/// An exponent with which noise falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Fitted to the medians over the seeds.
    pub value: f64,
    /// The least and the largest of those fitted to one seed each.
    pub range: [f64; 2],
}

impl Slope {
    /// The slope, and its range over the seeds.
    #[must_use]
    pub fn in_words(&self) -> String {
        let [least, most] = self.range.map(signed);
        format!("{} ({least} – {most})", signed(self.value))
    }
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
    /// How many of the renders have the truth in their intervals, that of the RMSE and that of relmse. Those that are as exact as numbers
    /// are do not count.
    pub intervals_held: [usize; 2],
    /// How many of the renders have no error but that of rounding, and say so.
    pub as_exact_as_numbers: usize,
    /// What the worst channel's error exceeds in one pixel of a thousand.
    pub percentile_999: Spread,
    /// Medians of the ends of the interval.
    pub percentile_999_interval: [f64; 2],
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
        if self.is_exact() {
            return "no noise but that of rounding".to_owned();
        }
        if noise == 0.0 && self.measured_relmse.median > 0.0 {
            return "no noise that the reference's own error would not explain".to_owned();
        }
        format!("{} noise", percent(noise))
    }

    /// Whether there is no error but that of rounding, and the renders say nothing else.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let says_so = |estimated: Estimated| is_rounding(estimated.relmse.median);
        is_rounding(self.measured_relmse.median) && self.estimated.is_none_or(says_so)
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
        let curve = |time: fn(&SummaryPoint) -> f64, error: fn(&SummaryPoint) -> f64, from: f64| {
            let late = points.iter().filter(|p| p.samples_per_pixel >= from);
            late.map(|p| (time(p), error(p))).collect::<Vec<_>>()
        };
        let seconds: fn(&SummaryPoint) -> f64 = |point| point.seconds.median;
        let cpu_seconds: fn(&SummaryPoint) -> f64 = |point| point.cpu_seconds.median;
        let noise: fn(&SummaryPoint) -> f64 = |point| point.true_noise().median;
        let noise_slope = |time: fn(&SummaryPoint) -> f64, own_time: fn(&Measurement) -> f64| {
            let value = log_slope(&curve(time, noise, SLOPE_FROM))?;
            let range = slopes_of_seeds(trials, reference, own_time);
            let range = range.map_or([value; 2], |range| [range.min, range.max]);
            Some(Slope { value, range })
        };
        let cpu_noise_slope = noise_slope(cpu_seconds, |m| m.cpu_seconds);
        let reference_outweighs_from = reference_outweighs_from(&points, reference);
        let is_noise = !variant.shows_another_picture && reference_outweighs_from.is_none();
        let followed = cpu_noise_slope
            .filter(|_| is_noise)
            .map(|slope| slope.value);
        let noise_curve = curve(seconds, noise, 0.0);
        let pixels = reference.image.pixels.len() as u64;
        Some(Self {
            build_seconds: spread(trials.iter().map(|trial| trial.build_seconds))?,
            slope: log_slope(&curve(seconds, |point| point.true_rmse.median, SLOPE_FROM)),
            noise_slope: noise_slope(seconds, |m| m.seconds),
            cpu_noise_slope,
            cpu_share: cpu_share(trials),
            shows_another_picture: variant.shows_another_picture,
            honesty: Honesty::of(&points, trials.len()),
            reference_outweighs_from,
            efficiency: efficiency(&ends.unwrap_or_default(), reference),
            time_to: NOISE_TARGETS.map(|noise| time_to(&noise_curve, noise, followed)),
            target: Target::of(variant),
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

    /// What kept the renders from the processor, where they had less of it than their threads could have had.
    #[must_use]
    pub fn load(&self) -> Option<String> {
        let share = self.cpu_share.filter(|&share| share < BUSY_SHARE)?;
        Some(format!(
            "the renders had {:.0} % of the processor time that their threads could have had: other programs were busy, or the picture is \
            too small to share among so many threads. Times are longer than they need be, and slopes against them are uncertain",
            100.0 * share
        ))
    }
}

/// The exponents with which the noise of each trial falls with its own `time`, where there are any.
fn slopes_of_seeds(
    trials: &[Trial],
    reference: &Reference,
    time: fn(&Measurement) -> f64,
) -> Option<Spread> {
    let slopes = trials.iter().filter_map(|trial| {
        let late = trial.measurements.iter();
        let late = late.filter(|m| m.samples_per_pixel >= SLOPE_FROM);
        let points = late.map(|m| (time(m), m.true_errors(reference).relmse.sqrt()));
        log_slope(&points.collect::<Vec<_>>())
    });
    spread(slopes)
}

/// The processor time of `trials` over what their threads could have had.
fn cpu_share(trials: &[Trial]) -> Option<f64> {
    let ends = || {
        trials
            .iter()
            .filter_map(|t| Some((t, t.measurements.last()?)))
    };
    let had: f64 = ends().map(|(_, end)| end.cpu_seconds).sum();
    let possible = ends().map(|(trial, end)| trial.stats.threads as f64 * end.seconds);
    let possible: f64 = possible.sum();
    (possible > 0.0).then(|| (had / possible).min(1.0))
}

pub(super) fn spread(values: impl Iterator<Item = f64>) -> Option<Spread> {
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
    let truths: Vec<_> = measurements
        .clone()
        .map(|m| m.true_errors(reference))
        .collect();
    let exact = measurements
        .zip(&estimates)
        .map(|(m, estimate)| is_rounding(m.measured.relmse) && is_rounding(estimate.relmse.value));
    let exact: Vec<bool> = exact.collect();
    let held = |interval: fn(&ErrorEstimate) -> Interval, truth: fn(&TrueErrors) -> f64| {
        let all = estimates.iter().zip(&truths).zip(&exact);
        all.filter(|((estimate, errors), is_exact)| {
            !**is_exact && interval(estimate).contains(truth(errors))
        })
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
        as_exact_as_numbers: exact.iter().filter(|is_exact| **is_exact).count(),
        percentile_999: of(&|estimate| estimate.percentile_999.value)?,
        percentile_999_interval: ends(|estimate| estimate.percentile_999)?,
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
            (summary.noise_slope.expect("is there").value, -1.0),
            (summary.cpu_noise_slope.expect("is there").value, -1.0),
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

    /// What holds the error up is not followed to a time; what is on the curve is read off it.
    #[test]
    fn nobody_foresees_when_another_picture_or_a_bad_reference_is_left_behind() {
        let mut study = test_data::study();
        study.variants[0].shows_another_picture = true;
        let [ten, three, one] = summary_of(&study).time_to;
        assert!(ten.is_some_and(|time| !time.predicted));
        assert_eq!((three, one), (None, None));
        study.variants[0].shows_another_picture = false;
        assert!(summary_of(&study).time_to[1].is_some());
        study.reference = test_data::file_reference(Some(0.002));
        assert_eq!(summary_of(&study).time_to[1], None);
    }

    /// By hand: of three seeds one is kept from the processor twice as long from 4 to 8 samples as before, so that its noise halves in four
    /// times the time; its processor time is as it was.
    #[test]
    fn slopes_have_the_range_of_the_seeds_and_processor_time_is_not_disturbed() {
        let mut study = test_data::study();
        let late = &mut study.variants[0].trials[2].measurements[3];
        late.seconds = 16.0;
        let summary = summary_of(&study);
        let [wall, cpu] =
            [summary.noise_slope, summary.cpu_noise_slope].map(|s| s.expect("is there"));
        for (found, expected) in [
            (wall.value, -1.0),
            (wall.range[0], -1.0),
            (wall.range[1], -0.5),
            (cpu.range[0], -1.0),
            (cpu.range[1], -1.0),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    /// Two processors are busy for each second of the data.
    #[test]
    fn renders_that_others_keep_from_the_processor_are_told_of() {
        let mut study = test_data::study();
        assert_eq!(summary_of(&study).cpu_share, None, "no threads are known");
        for (threads, share, is_told) in [(2, 1.0, false), (4, 0.5, true)] {
            for trial in &mut study.variants[0].trials {
                trial.stats.threads = threads;
            }
            let summary = summary_of(&study);
            assert_eq!(summary.cpu_share, Some(share));
            let said = summary.load();
            assert_eq!(said.is_some(), is_told, "{said:?}");
            assert!(said.is_none_or(|said| said.contains("had 50 % of the processor time")));
        }
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
