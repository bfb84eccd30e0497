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
mod outlook;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use allotment::{Allotment, Forecast};
pub use decay::Decay;
pub use outlook::Outlook;

use super::Image;
use super::film::{Film, Halves, each};

/// What is added to the square of the reference's value in relative errors, so that black pixels count little.
/// The product's definition of `relmse`.
pub const RELATIVE_FLOOR: f64 = 0.01;

/// Half the width of a 95 % interval of a normal distribution in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Most standard deviations of an interval, which few pixels would make endless.
const MOST_DEVIATIONS: f64 = 4.0;

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
    pub percentile_999: f64,
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

/// What is added up over pixels with the same number of samples, once for errors and once for relative errors.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Sums {
    /// Squared moves of the mean over all channels when samples went from a quarter to all.
    fall: f64,
    /// Squares of the product of the moves within the two halves, over channels.
    products: f64,
    /// Their squares.
    squared_products: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.fall += other.fall;
        self.products += other.products;
        self.squared_products += other.squared_products;
    }
}

/// Pixels with the same number of samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Group {
    samples: u32,
    pixels: u64,
    measures: [Sums; 2],
}

impl Group {
    fn level(&self) -> u32 {
        self.samples.ilog2()
    }
}

/// Index of the [`Sums`] of errors.
const ABSOLUTE: usize = 0;
/// Index of the [`Sums`] of relative errors.
const RELATIVE: usize = 1;

/// Estimates the error of a film, again and again while it fills.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ErrorEstimator {
    /// By level: sums of drops over all pixels that have reached it, and of those of both their halves, one level below.
    history: [Vec<[f64; 2]>; 2],
    /// What follows from it at the levels of the groups.
    decays: [Vec<(u32, Decay)>; 2],
    groups: Vec<Group>,
    unmeasured: u64,
    /// Per pixel: relative squared fall, mean over channels.
    falls: Vec<f32>,
    /// What the error of the worst channel exceeds in one pixel of a thousand.
    percentile_999: f64,
}

impl ErrorEstimator {
    /// For a film of `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            history: [Vec::new(), Vec::new()],
            decays: [Vec::new(), Vec::new()],
            groups: Vec::new(),
            unmeasured: 0,
            falls: vec![0.0; pixels],
            percentile_999: 0.0,
        }
    }

    /// Whether it is one for a film of `pixels` pixels, none with more than `most` samples, which is not certain where it was read from a
    /// file.
    #[must_use]
    pub fn is_like(&self, pixels: usize, most: u32) -> bool {
        let is_known = |group: &Group| (1..=most).contains(&group.samples);
        self.falls.len() == pixels && self.groups.iter().all(is_known)
    }

    /// Takes in `film`, whose pixels (those `selected`, or all) have just reached another power of two of samples, or the most
    /// they may get. Uses the threads of the current pool; the result does not depend on their number.
    pub fn update(&mut self, film: &Film, selected: Option<&[bool]>) {
        let survey = Survey::of(film);
        let width = film.region().width as usize;
        let rows: Vec<RowSums> = self
            .falls
            .par_chunks_mut(width)
            .enumerate()
            .map(|(y, falls)| survey.row(film, y, falls, selected))
            .collect();

        self.groups.clear();
        self.unmeasured = 0;
        for row in rows {
            self.take_in(row);
        }
        self.groups.sort_by_key(|group| group.samples);
        for (decays, history) in self.decays.iter_mut().zip(&self.history) {
            let links = links(history);
            let mut levels: Vec<u32> = self.groups.iter().map(Group::level).collect();
            levels.dedup();
            let decay = |level| (level, Decay::at(level, &links));
            *decays = levels.into_iter().map(decay).collect();
        }
        self.percentile_999 = self.percentile(film, &survey);
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
            for (known, sums) in known.measures.iter_mut().zip(&group.measures) {
                known.add(sums);
            }
        }
        for (level, measures) in row.reached {
            let level = level as usize;
            for (history, [drop, before]) in self.history.iter_mut().zip(measures) {
                if history.len() <= level {
                    history.resize(level + 1, [0.0; 2]);
                }
                history[level][0] += drop;
                history[level][1] += before;
            }
        }
    }

    /// Says that every pixel has `samples` by now, where all had the same number at the last [`Self::update`].
    pub fn advance(&mut self, samples: u32) {
        if let [group] = *self.groups.as_slice() {
            let decay = self.decay_at(ABSOLUTE, group.level());
            self.percentile_999 *= (decay.variance(samples) / decay.variance(group.samples)).sqrt();
            self.groups[0].samples = samples;
        }
    }

    /// The error as it is now; `None` before pixels have four samples.
    #[must_use]
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        let pixels: u64 = self.groups.iter().map(|group| group.pixels).sum();
        if pixels == 0 || self.groups.iter().any(|group| group.samples < 4) {
            return None;
        }
        let samples = |group: &Group| group.pixels as f64 * f64::from(group.samples);
        let total: f64 = self.groups.iter().map(samples).sum();
        Some(ErrorEstimate {
            samples_per_pixel: total / pixels as f64,
            rmse: self.mean_square(ABSOLUTE, pixels).sqrt(),
            relmse: self.mean_square(RELATIVE, pixels),
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
    /// 3 × 3 pixels around it, as a single one's says little.
    #[must_use]
    pub fn image(&self, film: &Film) -> Image {
        let region = film.region();
        let survey = Survey::of(film);
        let pixel = |index: usize| {
            let (x, y) = (index % survey.width, index / survey.width);
            let (mut sum, mut count) = ([0.0; 3], 0.0_f64);
            for row in y.saturating_sub(1)..=(y + 1).min(survey.height - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(survey.width - 1) {
                    let index = row * survey.width + column;
                    let moved = survey.moves[index].map(f64::from);
                    if survey.is_measured(index) {
                        let factor = self.factor(ABSOLUTE, film.samples(index));
                        sum = each(|c| sum[c] + factor * moved[c] * moved[c]);
                        count += 1.0;
                    }
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
            sum.map(|sum: f64| (sum / count.max(1.0)).sqrt() as f32)
        };
        Image {
            width: region.width,
            height: region.height,
            pixels: (0..region.pixel_count())
                .into_par_iter()
                .map(pixel)
                .collect(),
        }
    }

    /// The decay of the relative error where most of it is.
    #[must_use]
    pub fn decay(&self) -> Decay {
        let level = self.noisiest_group(RELATIVE).map_or(0, Group::level);
        self.decay_at(RELATIVE, level)
    }

    /// The samples of the pixels where most of the relative error is.
    #[must_use]
    pub fn noisiest_samples(&self) -> Option<u32> {
        Some(self.noisiest_group(RELATIVE)?.samples)
    }

    /// Relative squared fall of each pixel at its last power of two, mean over channels.
    #[must_use]
    pub fn falls(&self) -> &[f32] {
        &self.falls
    }

    /// What turns the fall of a pixel with `samples` into its relative variance.
    #[must_use]
    pub fn variance_over_fall(&self, samples: u32) -> f64 {
        self.factor(RELATIVE, samples)
    }

    fn decay_at(&self, measure: usize, level: u32) -> Decay {
        let known = self.decays[measure].iter().find(|(at, _)| *at == level);
        known.map_or_else(|| Decay::independent(level), |(_, decay)| *decay)
    }

    fn factor(&self, measure: usize, samples: u32) -> f64 {
        let level = samples.max(1).ilog2();
        let decay = self.decay_at(measure, level);
        if samples.is_power_of_two() {
            return decay.variance_over_fall();
        }
        decay.variance_over_fall() * decay.variance(samples) / decay.variance(1 << level)
    }

    fn mean_square(&self, measure: usize, pixels: u64) -> Interval {
        let (mut variance, mut products, mut squared_products) = (0.0, 0.0, 0.0);
        for group in &self.groups {
            let sums = &group.measures[measure];
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
            return Interval {
                value: 0.0,
                low: 0.0,
                high: 0.0,
            };
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
    fn noisiest_group(&self, measure: usize) -> Option<&Group> {
        let variance =
            |group: &Group| self.factor(measure, group.samples) * group.measures[measure].fall;
        self.groups
            .iter()
            .max_by(|a, b| variance(a).total_cmp(&variance(b)))
    }

    fn percentile(&self, film: &Film, survey: &Survey) -> f64 {
        // The move at one doubling is spread as errors are; moves over several are more even.
        let factor = |group: &Group| {
            let link = self.decay_at(ABSOLUTE, group.level()).link();
            let over_drop = self.factor(ABSOLUTE, group.samples) * (1.0 + 1.0 / link);
            (group.samples, over_drop.sqrt())
        };
        let factors: Vec<(u32, f64)> = self.groups.iter().map(factor).collect();
        let mut errors: Vec<f64> = (0..self.falls.len())
            .into_par_iter()
            .filter(|&index| survey.is_measured(index))
            .filter_map(|index| {
                let samples = film.samples(index);
                let (_, factor) = factors.iter().find(|(count, _)| *count == samples)?;
                let [r, g, b] = film.halves(index)?.whole.map(f64::abs);
                Some(r.max(g).max(b) * factor)
            })
            .collect();
        if errors.is_empty() {
            return 0.0;
        }
        let rank = errors.len() - 1 - errors.len() / 1000;
        *errors.select_nth_unstable_by(rank, f64::total_cmp).1
    }
}

/// The drop at each level from 2 over that at the level before.
fn links(history: &[[f64; 2]]) -> Vec<f64> {
    let links = history.iter().skip(2);
    links.map(|[drop, before]| drop / (before / 2.0)).collect()
}

/// What the pixels of a film say, before it is added up.
struct Survey {
    width: usize,
    height: usize,
    means: Vec<[f32; 3]>,
    /// By how much the mean moved when samples went from a quarter to all, at the last power of two; not a number where it is
    /// not measured.
    moves: Vec<[f32; 3]>,
}

/// Of one row of pixels.
struct RowSums {
    groups: Vec<Group>,
    /// For each level that pixels have just reached, the sums of drops there and, of both halves, one level below.
    reached: Vec<(u32, [[f64; 2]; 2])>,
    unmeasured: u64,
}

/// Squared moves of a pixel's mean from a quarter to all of its samples, from all three doublings that are seen.
fn squared_fall(halves: &Halves) -> [f64; 3] {
    let [first, second] = halves.parts;
    each(|c| halves.whole[c].powi(2) + f64::midpoint(first[c].powi(2), second[c].powi(2)))
}

impl Survey {
    fn of(film: &Film) -> Self {
        let region = film.region();
        let values = (0..region.pixel_count()).into_par_iter().map(|index| {
            let mean = film.mean_at(index);
            let moved = film.halves(index).map(|halves| {
                #[expect(clippy::cast_possible_truncation, reason = "of means that are f32")]
                squared_fall(&halves).map(|square| square.sqrt() as f32)
            });
            match moved {
                Some(moved) if is_finite(mean) && is_finite(moved) => (mean, moved),
                // Looks black to its neighbours.
                _ => ([0.0; 3], [f32::NAN; 3]),
            }
        });
        let (means, moves) = values.unzip();
        Self {
            width: region.width as usize,
            height: region.height as usize,
            means,
            moves,
        }
    }

    fn is_measured(&self, index: usize) -> bool {
        is_finite(self.moves[index])
    }

    /// Adds up row `y`, and writes the relative falls of its pixels.
    fn row(&self, film: &Film, y: usize, falls: &mut [f32], selected: Option<&[bool]>) -> RowSums {
        let mut sums = RowSums {
            groups: Vec::new(),
            reached: Vec::new(),
            unmeasured: 0,
        };
        let columns: Vec<Column> = (0..self.width).map(|x| self.column(x, y)).collect();
        for x in 0..self.width {
            let index = y * self.width + x;
            let Some(halves) = film.halves(index).filter(|_| self.is_measured(index)) else {
                sums.unmeasured += 1;
                falls[x] = 0.0;
                continue;
            };
            let around = [
                &columns[x.saturating_sub(1)],
                &columns[x],
                &columns[(x + 1).min(self.width - 1)],
            ];
            let weights = each(|c| {
                let reference = expected(f64::from(self.means[index][c]), around, c);
                1.0 / (reference * reference + RELATIVE_FLOOR)
            });
            let both = |values: [f64; 3]| {
                let [r, g, b] = values;
                let [weight_r, weight_g, weight_b] = weights;
                [r + g + b, r * weight_r + g * weight_g + b * weight_b]
            };
            let product = |a: [f64; 3], b: [f64; 3]| both(each(|c| a[c] * b[c]));
            let [first, second] = halves.parts;
            let fall = both(squared_fall(&halves));
            let products = product(first, second);
            #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
            {
                falls[x] = (fall[RELATIVE] / 3.0) as f32;
            }
            let group = sums.group(film.samples(index));
            group.pixels += 1;
            for measure in [ABSOLUTE, RELATIVE] {
                let product = products[measure].powi(2);
                let sums = &mut group.measures[measure];
                sums.fall += fall[measure];
                sums.products += product;
                sums.squared_products += product * product;
            }
            if halves.is_complete && selected.is_none_or(|selected| selected[index]) {
                let drop = product(halves.whole, halves.whole);
                let (first, second) = (product(first, first), product(second, second));
                let reached = sums.reached(halves.level);
                for measure in [ABSOLUTE, RELATIVE] {
                    reached[measure][0] += drop[measure];
                    reached[measure][1] += first[measure] + second[measure];
                }
            }
        }
        sums
    }

    fn column(&self, x: usize, y: usize) -> Column {
        let mut column = Column::default();
        for y in [y.saturating_sub(1), y, (y + 1).min(self.height - 1)] {
            let index = y * self.width + x;
            for c in 0..3 {
                let value = f64::from(self.means[index][c]);
                let moved = f64::from(self.moves[index][c]);
                column.sum[c] += value;
                column.squares[c] += value * value;
                column.falls[c] += if moved.is_finite() {
                    moved * moved
                } else {
                    0.0
                };
            }
        }
        column
    }
}

/// Sums over three pixels, one above the other, per channel.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    sum: [f64; 3],
    squares: [f64; 3],
    falls: [f64; 3],
}

/// What a pixel's channel `c` of mean `value` most likely is in truth, from the 3 × 3 pixels around it: its own value where they
/// differ by more than their noise explains, else the mean of the others, so that a pixel with an error of its own does not
/// hide it by looking bright. Source: Lee, Digital image enhancement and noise filtering by use of local statistics, 1980.
fn expected(value: f64, around: [&Column; 3], c: usize) -> f64 {
    let [left, own, right] = around;
    let over = |of: [&[f64; 3]; 3]| of[0][c] + of[1][c] + of[2][c];
    let sum = over([&left.sum, &own.sum, &right.sum]);
    let squares = over([&left.squares, &own.squares, &right.squares]);
    // A third of the fall is the variance, if samples count as independent.
    let noise = over([&left.falls, &own.falls, &right.falls]) / 27.0;
    let others = (sum - value) / 8.0;
    let spread = squares / 9.0 - 2.0 * others * sum / 9.0 + others * others;
    let own_share = if noise < spread {
        1.0 - noise / spread
    } else {
        0.0
    };
    others + own_share * (value - others)
}

impl RowSums {
    fn group(&mut self, samples: u32) -> &mut Group {
        let known = self
            .groups
            .iter()
            .position(|group| group.samples == samples);
        let place = known.unwrap_or_else(|| {
            self.groups.push(Group {
                samples,
                ..Group::default()
            });
            self.groups.len() - 1
        });
        &mut self.groups[place]
    }

    fn reached(&mut self, level: u32) -> &mut [[f64; 2]; 2] {
        let known = self.reached.iter().position(|(known, _)| *known == level);
        let place = known.unwrap_or_else(|| {
            self.reached.push((level, [[0.0; 2]; 2]));
            self.reached.len() - 1
        });
        &mut self.reached[place].1
    }
}

fn is_finite(rgb: [f32; 3]) -> bool {
    rgb.iter().all(|value| value.is_finite())
}
