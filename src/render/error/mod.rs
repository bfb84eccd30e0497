//! How wrong a picture still is, estimated from the picture itself while it is rendered.
//!
//! Each pixel tells by how much its mean moved when its samples last doubled ([`Halves`]). One pixel says little: its two halves
//! are one observation. A picture's pixels together say how large the error is, how fast it falls ([`Decay`]), and with that
//! what the next samples are worth. No sequence is cut into pieces for it, and no sample is taken for it.
//!
//! The error is that of the very picture that is there, not that of an average one: where a rare bright sample is in one half
//! of a pixel's samples, the difference of the halves is its share in the error.

mod allotment;
mod decay;
mod measures;
mod outlook;
mod survey;

use std::borrow::Cow;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use allotment::{Allotment, Forecast, LEAST_SHARE, ROUND_SHARE};
pub use decay::Decay;
pub use outlook::Outlook;

use super::Image;
use super::film::{CHUNK, Film, each};
use crate::control::CancelToken;
use crate::scene::RenderSettings;
use measures::{Measure, Measures};
use survey::{Drops, Group, PerPixel, RowSums, Sums, Survey};

/// What is added to the square of the reference's value in relative errors, so that black pixels count little.
/// The product's definition of `relmse`.
pub const RELATIVE_FLOOR: f64 = 0.01;

/// From so many samples of each pixel on the error is told: the halves of fewer have no halves whose means could be compared.
const LEAST_SAMPLES: u32 = 4;

/// Rows that a thread surveys at once: enough that those above and below, which are read too, take little.
const ROWS_OF_BAND: usize = 16;

/// Half the width of a 95 % interval of a normal distribution in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Most standard deviations of an interval, which few pixels would make endless.
const MOST_DEVIATIONS: f64 = 4.0;

/// The most that a percentile may be said to be above the largest error that is seen, as a factor.
const MOST_RATIO: f64 = 10.0;

/// A value and the interval that holds the truth in 95 of 100 cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Nothing, for certain.
    pub(super) const ZERO: Self = Self {
        value: 0.0,
        low: 0.0,
        high: 0.0,
    };

    /// The interval of so many times the value.
    #[must_use]
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            low: self.low * factor,
            high: self.high * factor,
        }
    }

    /// Whether `truth` lies in it.
    #[must_use]
    pub fn contains(&self, truth: f64) -> bool {
        (self.low..=self.high).contains(&truth)
    }

    /// The interval of the square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self {
            value: self.value.sqrt(),
            low: self.low.sqrt(),
            high: self.high.sqrt(),
        }
    }
}

/// How wrong a picture is, without a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Mean over the pixels.
    pub samples_per_pixel: f64,
    /// Root of the mean square error over pixels and channels, in units of radiance.
    pub rmse: Interval,
    /// Mean over pixels and channels of error² / (truth² + 0.01).
    pub relmse: Interval,
    /// What the error of the worst channel exceeds in only one of a thousand pixels, in units of radiance.
    pub percentile_999: Interval,
    /// Pixels that are left out because they are infinite or not a number.
    pub unmeasured_pixels: u64,
}

impl ErrorEstimate {
    /// √relmse: 0.03 is called 3 % noise.
    #[must_use]
    pub fn noise(&self) -> Interval {
        self.relmse.sqrt()
    }
}

/// Estimates the error of a film, again and again while it fills.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ErrorEstimator {
    /// By level.
    history: Measures<Vec<Drops>>,
    /// What follows from it at the levels of the groups.
    decays: Measures<Vec<(u32, Decay)>>,
    groups: Vec<Group>,
    unmeasured: u64,
    /// Per pixel: relative squared fall, mean over channels.
    falls: Vec<f32>,
    /// What the error of the worst channel exceeds in one pixel of a thousand.
    percentile_999: Interval,
}

impl ErrorEstimator {
    /// For a film of `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            history: Measures::default(),
            decays: Measures::default(),
            groups: Vec::new(),
            unmeasured: 0,
            falls: vec![0.0; pixels],
            percentile_999: Interval::ZERO,
        }
    }

    /// Whether it is one for a film of `pixels` pixels, none with more samples than any render may take, which is not certain where it was
    /// read from a file.
    #[must_use]
    pub fn is_like(&self, pixels: usize) -> bool {
        let is_known = |group: &Group| (1..=RenderSettings::MAX_SAMPLES).contains(&group.samples);
        self.falls.len() == pixels && self.groups.iter().all(is_known)
    }

    /// Takes in `film`, whose pixels (those `selected`, or all) have just reached another power of two of samples, or the most
    /// they may get. Uses the threads of the current pool; the result does not depend on their number. `None` when cancelled: it is of no
    /// use any more then.
    /// Of fewer than four samples nothing is learnt.
    pub fn update(
        &mut self,
        film: &Film,
        selected: Option<&[bool]>,
        cancel: &CancelToken,
    ) -> Option<()> {
        let [_, most] = film.sample_range();
        if most < LEAST_SAMPLES {
            return Some(());
        }
        let mut moves = vec![0.0; film.pixels()];
        let band = ROWS_OF_BAND * film.region().width as usize;
        let falls = self.falls.par_chunks_mut(band);
        let bands = falls.zip(moves.par_chunks_mut(band)).enumerate();
        let sums = bands.map_init(Survey::default, |survey, (number, (falls, moves))| {
            let (first, pixels) = (number * ROWS_OF_BAND, PerPixel { falls, moves });
            survey.sum_rows(film, first, pixels, selected, cancel)
        });
        let sums: Vec<Vec<RowSums>> = sums.collect::<Option<_>>()?;

        self.groups.clear();
        self.unmeasured = 0;
        for row in sums.into_iter().flatten() {
            self.take_in(row);
        }
        self.groups.sort_by_key(|group| group.samples);
        let mut levels: Vec<u32> = self.groups.iter().map(Group::level).collect();
        levels.dedup();
        self.decays = self.history.map(|history| {
            let links = links(history);
            let decay = |&level: &u32| (level, Decay::at(level, &links));
            levels.iter().map(decay).collect()
        });
        self.percentile_999 = self.percentile(film, moves, cancel)?;
        Some(())
    }

    fn take_in(&mut self, row: RowSums) {
        self.unmeasured += row.unmeasured;
        for group in row.groups {
            let known = self
                .groups
                .iter_mut()
                .find(|known| known.samples == group.samples);
            let Some(known) = known else {
                self.groups.push(group);
                continue;
            };
            known.pixels += group.pixels;
            known.sums.change_by(&group.sums, Sums::add);
        }
        for (level, drops) in row.reached {
            let level = level as usize;
            self.history.change_by(&drops, |history, drops| {
                if history.len() <= level {
                    history.resize(level + 1, Drops::default());
                }
                history[level].add(drops);
            });
        }
    }

    /// Says that every pixel has `samples` by now, where all had the same number at the last [`Self::update`].
    pub fn advance(&mut self, samples: u32) {
        if let [group] = *self.groups.as_slice() {
            let decay = self.decay_at(Measure::Absolute, group.level());
            let fall = (decay.variance(samples) / decay.variance(group.samples)).sqrt();
            self.percentile_999 = self.percentile_999.times(fall);
            self.groups[0].samples = samples;
        }
    }

    /// The error as it is now; `None` before all pixels have four samples.
    #[must_use]
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        let pixels: u64 = self.groups.iter().map(|group| group.pixels).sum();
        if pixels == 0
            || self
                .groups
                .iter()
                .any(|group| group.samples < LEAST_SAMPLES)
        {
            return None;
        }
        let samples = |group: &Group| group.pixels as f64 * f64::from(group.samples);
        let total: f64 = self.groups.iter().map(samples).sum();
        Some(ErrorEstimate {
            samples_per_pixel: total / pixels as f64,
            rmse: self.mean_square(Measure::Absolute, pixels).sqrt(),
            relmse: self.mean_square(Measure::Relative, pixels),
            percentile_999: self.percentile_999,
            unmeasured_pixels: self.unmeasured,
        })
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> f64 {
        self.falls.len() as f64
    }

    /// The error of each pixel and channel of `film`, whose state was taken in last: the root of its mean square over the
    /// 3 × 3 pixels around it, as a single one's says little. Not a number where it is measured in none of them. `None` when cancelled.
    #[must_use]
    pub fn image(&self, film: &Film, cancel: &CancelToken) -> Option<Image> {
        let region = film.region();
        let (width, height) = (region.width as usize, region.height as usize);
        let moves = survey::moves(film, cancel)?;
        let pixel = |index: usize| {
            let (x, y) = (index % width, index / width);
            let (mut sum, mut count) = ([0.0; 3], 0.0_f64);
            for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let index = row * width + column;
                    let moved = moves[index].map(f64::from);
                    if moved.iter().all(|value| value.is_finite()) {
                        let factor = self.factor(Measure::Absolute, film.samples(index));
                        sum = each(|c| sum[c] + factor * moved[c] * moved[c]);
                        count += 1.0;
                    }
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
            sum.map(|sum: f64| (sum / count).sqrt() as f32)
        };
        let mut image = Image::black(region.width, region.height);
        let parts = image.pixels.par_chunks_mut(CHUNK).enumerate();
        parts.for_each(|(part, pixels)| {
            if cancel.is_cancelled() {
                return;
            }
            for (index, value) in (part * CHUNK..).zip(pixels) {
                *value = pixel(index);
            }
        });
        (!cancel.is_cancelled()).then_some(image)
    }

    /// The decay of the relative error where most of it is.
    #[must_use]
    pub fn decay(&self) -> Decay {
        let level = self
            .noisiest_group(Measure::Relative)
            .map_or(0, Group::level);
        self.decay_at(Measure::Relative, level).into_owned()
    }

    /// The samples of the pixels where most of the relative error is.
    #[must_use]
    pub fn noisiest_samples(&self) -> Option<u32> {
        Some(self.noisiest_group(Measure::Relative)?.samples)
    }

    /// Relative squared fall of each pixel at its last power of two, mean over channels.
    #[must_use]
    pub fn falls(&self) -> &[f32] {
        &self.falls
    }

    /// What turns the fall of a pixel with `samples` into its relative variance.
    #[must_use]
    pub fn variance_over_fall(&self, samples: u32) -> f64 {
        self.factor(Measure::Relative, samples)
    }

    fn decay_at(&self, measure: Measure, level: u32) -> Cow<'_, Decay> {
        let known = self.decays.of(measure).iter().find(|(at, _)| *at == level);
        known.map_or_else(
            || Cow::Owned(Decay::independent(level)),
            |(_, decay)| Cow::Borrowed(decay),
        )
    }

    fn factor(&self, measure: Measure, samples: u32) -> f64 {
        let level = samples.max(1).ilog2();
        let decay = self.decay_at(measure, level);
        if samples.is_power_of_two() {
            return decay.variance_over_fall();
        }
        decay.variance_over_fall() * decay.variance(samples) / decay.variance(1 << level)
    }

    fn mean_square(&self, measure: Measure, pixels: u64) -> Interval {
        let (mut variance, mut products, mut squared_products) = (0.0, 0.0, 0.0);
        for group in &self.groups {
            let sums = group.sums.of(measure);
            let factor = self.factor(measure, group.samples);
            variance += factor * sums.fall;
            // From the square of a half's move to the variance of the mean of all.
            let decay = self.decay_at(measure, group.level());
            let scale = (2.0 * factor * (1.0 + decay.link())).powi(2);
            products += scale * sums.products;
            squared_products += scale * scale * sums.squared_products;
        }
        let value = variance / (3 * pixels) as f64;
        if value <= 0.0 {
            return Interval::ZERO;
        }
        // Let a and b be the errors of a pixel's halves. Its own squared error is |a + b|² / 4, and what is seen |a − b|² / 4:
        // they differ by the product a · b, whose square is estimated by that of the moves within the halves. It is large where
        // both halves are noisy, and small where one rare sample makes all the error, as that is seen in full. Half of its
        // variance is the true square's own; the estimate, which sees more than one difference but not the law, has as much.
        let chance = products / (variance * variance);
        let noisiest = self.noisiest_group(measure).map_or(0, Group::level);
        let doubt = self.decay_at(measure, noisiest).doubt();
        // Where few pixels make most of it, that variance is itself uncertain: Student's distribution, with half as many degrees
        // of freedom as there are such pixels, expanded to first order.
        let pixels_that_count = products * products / squared_products;
        let student = NORMAL_95 + (NORMAL_95.powi(3) + NORMAL_95) / (2.0 * pixels_that_count);
        let student = if student < MOST_DEVIATIONS {
            student
        } else {
            MOST_DEVIATIONS
        };
        let width = (chance.sqrt().min(1.0) * student)
            .hypot(doubt * NORMAL_95)
            .exp();
        Interval {
            value,
            low: value / width,
            high: value * width,
        }
    }

    /// The pixels with the same number of samples that make most of the error.
    fn noisiest_group(&self, measure: Measure) -> Option<&Group> {
        let variance =
            |group: &Group| self.factor(measure, group.samples) * group.sums.of(measure).fall;
        self.groups
            .iter()
            .max_by(|a, b| variance(a).total_cmp(&variance(b)))
    }

    /// What one pixel of a thousand exceeds, by the [`PerPixel::moves`] of all. Its interval has two parts: which pixels those are is chance, in what is seen as in the truth, so
    /// that the value might as well be one of those some ranks above or below; and what turns moves into errors is in doubt.
    /// `None` when cancelled.
    fn percentile(&self, film: &Film, moves: Vec<f64>, cancel: &CancelToken) -> Option<Interval> {
        // The move at one doubling is spread as errors are; moves over several are more even.
        let factor = |group: &Group| {
            let link = self.decay_at(Measure::Absolute, group.level()).link();
            let over_drop = self.factor(Measure::Absolute, group.samples) * (1.0 + 1.0 / link);
            (group.samples, over_drop.sqrt())
        };
        let factors: Vec<(u32, f64)> = self.groups.iter().map(factor).collect();
        let mut errors = moves;
        let parts = errors.par_chunks_mut(CHUNK).enumerate();
        parts.for_each(|(part, errors)| {
            if cancel.is_cancelled() {
                return;
            }
            for (index, error) in (part * CHUNK..).zip(errors) {
                let samples = film.samples(index);
                let known = factors.iter().find(|(count, _)| *count == samples);
                *error *= known.map_or(f64::NAN, |(_, factor)| *factor);
            }
        });
        errors.retain(|error| !error.is_nan());
        let Some(last) = errors.len().checked_sub(1) else {
            return Some(Interval::ZERO);
        };
        let beyond = errors.len() / 1000;
        let ranks = ranks_of_chance(beyond);
        let lowest = last.saturating_sub(beyond + ranks);
        let low = number_of_rank(&errors, lowest, cancel)?;
        let above = errors.iter().copied().filter(|&error| error > low);
        let mut above: Vec<f64> = above.collect();
        above.sort_unstable_by(f64::total_cmp);
        let from_top = |rank: usize| match above.len().checked_sub(rank + 1) {
            Some(place) => above[place],
            None => low,
        };
        let value = from_top(beyond);
        if value <= 0.0 {
            return Some(Interval::ZERO);
        }
        let below = value / low.max(value * f64::MIN_POSITIVE);
        let above = from_top(beyond.saturating_sub(ranks)) / value;
        // Nothing is seen above the largest: as far as below.
        let above = if beyond < ranks {
            above.max(below.min(MOST_RATIO))
        } else {
            above
        };
        let noisiest = self
            .noisiest_group(Measure::Absolute)
            .map_or(0, Group::level);
        let doubt = self.decay_at(Measure::Absolute, noisiest).doubt() / 2.0;
        let width = |ratio: f64| libm::exp(libm::log(ratio).hypot(doubt * NORMAL_95));
        Some(Interval {
            value,
            low: value / width(below),
            high: value * width(above),
        })
    }
}

/// By how many ranks a value with so many `beyond` it may differ from one that is as rare: both numbers are Poisson's.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number"
)]
fn ranks_of_chance(beyond: usize) -> usize {
    (NORMAL_95 * (2.0 * (beyond as f64 + 1.0)).sqrt()).ceil() as usize
}

/// The one of `numbers`, none below 0, that `rank` of them come before where they are sorted; `None` when cancelled.
///
/// # Panics
/// When there are no more than `rank`.
fn number_of_rank(numbers: &[f64], rank: usize, cancel: &CancelToken) -> Option<f64> {
    /// Sixteen cells to an octave: those of one are few among many.
    const CELLS: usize = 1 << 16;
    // Bits of such numbers are in their order.
    let cell_of = |number: f64| (number.to_bits() >> 48) as usize;
    let mut counts = vec![0; CELLS];
    for numbers in numbers.chunks(CHUNK) {
        if cancel.is_cancelled() {
            return None;
        }
        for &number in numbers {
            counts[cell_of(number)] += 1;
        }
    }
    let (mut cell, mut before) = (0, 0);
    while before + counts[cell] <= rank {
        before += counts[cell];
        cell += 1;
    }
    let in_cell = numbers.iter().copied().filter(|&n| cell_of(n) == cell);
    let mut in_cell: Vec<f64> = in_cell.collect();
    Some(
        *in_cell
            .select_nth_unstable_by(rank - before, f64::total_cmp)
            .1,
    )
}

/// The drop at each level from 2 over that at the level before.
fn links(history: &[Drops]) -> Vec<f64> {
    let links = history.iter().skip(2);
    links.map(|drops| drops.at / (drops.below / 2.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::Vec3;
    use crate::render::film::{TileSums, block_after};
    use crate::render::layers::{Gathered, NoParts};
    use crate::render::tiles::Region;

    /// Twenty pictures of 64 × 64 pixels, each the mean of 64 independent values of 0.5 or 1.5: all that differs from 1 is error. What its
    /// thousandth part exceeds is within a third, and in the interval, 95 of 100 times by its word, 17 of 20 times at least.
    #[test]
    fn the_percentile_of_independent_errors_is_known() {
        let region = Region::full(64, 64);
        let (never, mut held) = (CancelToken::new(), 0);
        for seed in 0..20 {
            let mut random = Random::new(seed);
            let mut film = Film::new(region, &[], true);
            let mut estimator = ErrorEstimator::new(film.pixels());
            while film.samples(0) < 64 {
                let mut sums = TileSums::default();
                sums.reset(&[], region.pixel_count());
                for index in 0..region.pixel_count() {
                    for _ in 0..block_after(film.samples(0)) {
                        let value = if random.unit() < 0.5 { 0.5 } else { 1.5 };
                        let seen = Gathered::<NoParts>::seen(Vec3::splat(value));
                        sums.add(index, &[], &seen, 1);
                    }
                }
                film.add(region, &sums);
                if film.samples(0).is_power_of_two() {
                    let updated = estimator.update(&film, None, &never);
                    updated.expect("nobody cancels");
                }
            }
            let error = |index: usize| f64::from((film.mean_at(index)[0] - 1.0).abs());
            let mut errors: Vec<f64> = (0..film.pixels()).map(error).collect();
            errors.sort_by(f64::total_cmp);
            let truth = errors[errors.len() - 1 - errors.len() / 1000];
            let found = estimator.estimate().expect("has 64 samples").percentile_999;
            let ratio = found.value / truth;
            assert!((0.75..1.33).contains(&ratio), "{seed}: {found:?}, {truth}");
            held += u32::from(found.contains(truth));
        }
        assert!(held >= 17, "{held} of 20");
    }

    #[test]
    fn the_number_of_a_rank_is_the_one_of_sorted_numbers() {
        let (never, mut random) = (CancelToken::new(), Random::new(5));
        for count in [1, 2, 1000, 30_000] {
            // Of all sizes, and some of them often.
            let number = |turn: u32| match turn % 3 {
                0 => 0.25,
                1 => random.unit(),
                _ => random.unit().powi(40),
            };
            let numbers: Vec<f64> = (0..count).map(number).collect();
            let mut sorted = numbers.clone();
            sorted.sort_by(f64::total_cmp);
            for rank in [0, sorted.len() / 3, sorted.len() / 2, sorted.len() - 1] {
                let found = number_of_rank(&numbers, rank, &never);
                assert_eq!(found, Some(sorted[rank]), "{rank} of {count}");
            }
        }
        never.cancel();
        assert_eq!(number_of_rank(&[1.0], 0, &never), None);
    }

    /// A row whose first two pixels are not finite: the second has a neighbour that is measured.
    #[test]
    fn an_error_that_is_measured_nowhere_near_is_not_zero() {
        let region = Region::full(4, 1);
        let mut film = Film::new(region, &[], true);
        while film.samples(0) < 4 {
            let mut sums = TileSums::default();
            sums.reset(&[], region.pixel_count());
            for index in 0..region.pixel_count() {
                for _ in 0..block_after(film.samples(0)) {
                    let value = if index < 2 { f32::INFINITY } else { 0.5 };
                    let seen = Gathered::<NoParts>::seen(Vec3::splat(value));
                    sums.add(index, &[], &seen, 1);
                }
            }
            film.add(region, &sums);
        }
        let mut estimator = ErrorEstimator::new(film.pixels());
        let never = CancelToken::new();
        estimator.update(&film, None, &never);
        let errors = estimator.image(&film, &never);
        let errors = errors.expect("nobody cancels");
        assert!(errors.pixel(0, 0).iter().all(|error| error.is_nan()));
        assert_eq!(errors.pixels[1..], [[0.0; 3]; 3], "the others are even");
    }
}
