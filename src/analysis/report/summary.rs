//! What the trials of a variant say together.

use serde::Serialize;

use super::digits::samples;
use super::fit::{SHALLOWEST, TimeTo, log_slope, time_to};
use super::honesty::{Honesty, is_rounding};
use super::reference::{Reference, Seen};
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
    /// Exponent with which the true RMSE falls with render time, from 4 samples on: the median of the seeds'.
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
    /// nothing but noise is measured, and up to where `render.stop` ends the renders.
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

/// An exponent with which noise falls, fitted to each seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The median of the seeds'.
    pub value: f64,
    /// The least and the largest of them.
    pub range: [f64; 2],
}

impl From<Spread> for Slope {
    fn from(Spread { median, min, max }: Spread) -> Self {
        Self {
            value: median,
            range: [min, max],
        }
    }
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
        let noise_slope = |time: fn(&Measurement) -> f64| {
            let slopes = slopes_of_seeds(trials, reference, time, |errors| errors.relmse.sqrt());
            slopes.map(Slope::from)
        };
        let seconds: fn(&Measurement) -> f64 = |m| m.seconds;
        let cpu_noise_slope = noise_slope(|m| m.cpu_seconds);
        let reference_outweighs_from = reference_outweighs_from(&points, reference);
        let is_noise = !variant.shows_another_picture && reference_outweighs_from.is_none();
        let followed = cpu_noise_slope
            .filter(|_| is_noise)
            .map(|slope| slope.value);
        let noise_curve = points.iter();
        let noise_curve = noise_curve.map(|p| (p.seconds.median, p.true_noise().median));
        let noise_curve: Vec<_> = noise_curve.collect();
        let stop = &variant.scene.render.stop;
        let reached = |noise: f64| {
            // Nobody gets to see what comes after the end.
            let is_after_end = |time: &TimeTo| {
                let is_late = stop.seconds.is_some_and(|most| time.seconds > most);
                time.predicted && (is_late || stop.noise.is_some_and(|enough| noise < enough))
            };
            time_to(&noise_curve, noise, followed).filter(|time| !is_after_end(time))
        };
        let pixels = reference.image.pixels.len() as u64;
        Some(Self {
            build_seconds: spread(trials.iter().map(|trial| trial.build_seconds))?,
            slope: slopes_of_seeds(trials, reference, seconds, |errors| errors.mse.sqrt())
                .map(|slopes| slopes.median),
            noise_slope: noise_slope(seconds),
            cpu_noise_slope,
            cpu_share: cpu_share(trials),
            shows_another_picture: variant.shows_another_picture,
            honesty: Honesty::of(&points, trials.len()),
            reference_outweighs_from,
            efficiency: efficiency(&ends.unwrap_or_default(), reference),
            time_to: NOISE_TARGETS.map(reached),
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

/// The exponents with which the `error` of each trial falls with its own `time`, where there are any.
fn slopes_of_seeds(
    trials: &[Trial],
    reference: &Reference,
    time: fn(&Measurement) -> f64,
    error: fn(&TrueErrors) -> f64,
) -> Option<Spread> {
    let slopes = trials.iter().filter_map(|trial| {
        let late = trial.measurements.iter();
        let late = late.filter(|m| m.samples_per_pixel >= SLOPE_FROM);
        let points = late.map(|m| (time(m), error(&m.true_errors(reference))));
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
    let late = points.iter().filter(|p| p.samples_per_pixel >= SLOPE_FROM);
    let late = late.map(|p| (p.samples_per_pixel, p.measured_relmse.median.sqrt()));
    let slope = log_slope(&late.collect::<Vec<_>>());
    let outweighed = points.iter().rev().take_while(|point| {
        reference.outweighs(&Seen {
            relmse: point.measured_relmse.median,
            most: (point.estimated).map(|estimated| estimated.relmse_interval[1]),
            samples_per_pixel: point.samples_per_pixel,
            falls: slope.is_none_or(|slope| slope <= SHALLOWEST),
        })
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
    use crate::scene::Stop;

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

    /// By hand: the noise of three seeds is that of the data, that to the power of 1/4, and that to the power of 1/2, crossing on the way, so that
    /// medians of different seeds follow one another.
    #[test]
    fn a_slope_is_one_of_a_seed_and_lies_in_their_range() {
        let mut study = test_data::study();
        for (trial, power) in study.variants[0].trials.iter_mut().zip([1.0, 0.25, 0.5]) {
            let scale = if power < 0.5 { 0.5 } else { 1.0 };
            for m in &mut trial.measurements {
                m.measured.relmse = scale * (4.0 / m.samples_per_pixel).powf(2.0 * power);
                m.measured.mse = m.measured.relmse;
            }
        }
        let summary = summary_of(&study);
        let slope = summary.noise_slope.expect("is there");
        let found = [slope.value, slope.range[0], slope.range[1]];
        for (found, expected) in found.into_iter().zip([-0.5, -1.0, -0.25]) {
            assert!((found - expected).abs() < 1e-9, "{slope:?}");
        }
        assert!((summary.slope.expect("is there") + 0.5).abs() < 1e-9);
    }

    /// The data reach 5 % after 8 s, and would reach 3 % after 13.3 s and 1 % after 40.
    #[test]
    fn nothing_is_foreseen_beyond_the_end_of_a_render() {
        let mut study = test_data::study();
        let stop = |study: &mut Study, stop| study.variants[0].scene.render.stop = stop;
        let foreseen = |study: &Study| summary_of(study).time_to.map(|time| time.is_some());
        let [noise, seconds] = [Some(0.03), Some(14.0)];
        let none = Stop::default();
        for (rule, expected) in [
            (none, [true; 3]),
            (Stop { noise, ..none }, [true, true, false]),
            (Stop { seconds, ..none }, [true, true, false]),
            (
                Stop {
                    noise: Some(0.2),
                    ..none
                },
                [true, false, false],
            ),
            // What was seen was seen.
            (
                Stop {
                    seconds: Some(1.0),
                    ..none
                },
                [true, false, false],
            ),
        ] {
            stop(&mut study, rule);
            assert_eq!(foreseen(&study), expected, "{rule:?}");
        }
    }

    /// A picture of other light: what is measured stays as it is.
    #[test]
    fn an_exact_answer_of_another_picture_is_told_of() {
        let mut study = test_data::study();
        for trial in &mut study.variants[0].trials {
            for measurement in &mut trial.measurements {
                measurement.measured.relmse += 1.0;
            }
        }
        assert_eq!(summary_of(&study).reference_outweighs_from, Some(4.0));
        assert!(summary_of(&study).doubt().is_some());
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
