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
use serde::Serialize;

pub use allotment::{Allotment, Forecast};
pub use decay::Decay;
pub use outlook::Outlook;

use super::Image;
use super::film::Film;

/// What is added to the square of the reference's value in relative errors, so that black pixels count little.
/// The product's definition of `relmse`.
pub const RELATIVE_FLOOR: f64 = 0.01;

/// Half the width of a 95 % interval of a normal distribution in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Most standard deviations of an interval, which few pixels would make endless.
const MOST_DEVIATIONS: f64 = 4.0;

/// Relative standard deviation of an estimated mean square for which the model of decay is to blame, not chance: for a decay
/// as of independent samples, and what is added as the decay is faster. Measured over the gallery against references.
const MODEL_DOUBT: f64 = 0.06;
const MODEL_DOUBT_OF_FAST_DECAY: f64 = 0.15;

/// The same at 4 samples, where no law holds yet, and by how much it falls each time they double.
const EARLY_DOUBT: f64 = 0.4;
const EARLY_DOUBT_FALL: f64 = 0.63;

/// A value and the interval that holds the truth in 95 of 100 cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// Mean over the pixels.
    pub samples_per_pixel: f64,
    /// Root of the mean square error over pixels and channels, in units of radiance.
    pub rmse: Interval,
    /// Mean over pixels and channels of error² / (truth² + 0.01).
    pub relmse: Interval,
    /// What the error of the worst channel exceeds in one of a thousand pixels only, in units of radiance.
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
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Squared drops over all channels, the square root of each being the move of the mean at the last doubling.
    drop: f64,
    /// Twice the same at the doubling before.
    drop_before: f64,
    /// Squares of the product of the moves within the two halves, over channels.
    products: f64,
    /// Their squares.
    squared_products: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.drop += other.drop;
        self.drop_before += other.drop_before;
        self.products += other.products;
        self.squared_products += other.squared_products;
    }
}

/// Pixels with the same number of samples.
#[derive(Clone, Copy, Debug, Default)]
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

/// Number of [`Sums`] of errors and of relative errors.
const ABSOLUTE: usize = 0;
const RELATIVE: usize = 1;

/// Estimates the error of a film, again and again while it fills.
#[derive(Clone, Debug)]
pub struct ErrorEstimator {
    /// By level: sums of drops over all pixels that have reached it, and of the drops one level below over the same pixels.
    history: [Vec<[f64; 2]>; 2],
    decays: [Decay; 2],
    groups: Vec<Group>,
    unmeasured: u64,
    /// Per pixel: relative squared drop, mean over channels.
    spreads: Vec<f32>,
    /// The largest move of a channel that one pixel in a thousand exceeds, as an error.
    percentile_999: f64,
}

impl ErrorEstimator {
    /// For a film of `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            history: [Vec::new(), Vec::new()],
            decays: [Decay::HALVING; 2],
            groups: Vec::new(),
            unmeasured: 0,
            spreads: vec![0.0; pixels],
            percentile_999: 0.0,
        }
    }

    /// Takes in `film`, whose pixels (those `selected`, or all) have just reached another power of two of samples, or the most
    /// they may get. Uses the threads of the current pool; the result does not depend on their number.
    pub fn update(&mut self, film: &Film, selected: Option<&[bool]>) {
        let survey = Survey::of(film);
        let width = film.region().width as usize;
        let rows: Vec<RowSums> = self
            .spreads
            .par_chunks_mut(width)
            .enumerate()
            .map(|(y, spreads)| survey.row(film, y, spreads, selected))
            .collect();

        self.groups.clear();
        self.unmeasured = 0;
        for row in rows {
            self.unmeasured += row.unmeasured;
            for group in row.groups {
                let known = self.groups.iter_mut().find(|g| g.samples == group.samples);
                match known {
                    Some(known) => {
                        known.pixels += group.pixels;
                        for (known, sums) in known.measures.iter_mut().zip(&group.measures) {
                            known.add(sums);
                        }
                    }
                    None => self.groups.push(group),
                }
            }
            for (level, measures) in row.reached {
                for (history, [drop, before]) in self.history.iter_mut().zip(measures) {
                    let level = level as usize;
                    if history.len() <= level {
                        history.resize(level + 1, [0.0; 2]);
                    }
                    history[level][0] += drop;
                    history[level][1] += before;
                }
            }
        }
        self.groups.sort_by_key(|group| group.samples);
        for (decay, history) in self.decays.iter_mut().zip(&self.history) {
            *decay = Decay::fit(&links(history));
        }
        self.percentile_999 = self.percentile(film, &survey);
    }

    /// Says that every pixel has `samples` by now, where all had the same number at the last [`Self::update`].
    pub fn advance(&mut self, samples: u32) {
        if let [group] = self.groups.as_mut_slice() {
            let decay = &self.decays[ABSOLUTE];
            self.percentile_999 *= (decay.variance(samples) / decay.variance(group.samples)).sqrt();
            group.samples = samples;
        }
    }

    /// The error as it is now; `None` before pixels have four samples.
    #[must_use]
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        let pixels: u64 = self.groups.iter().map(|group| group.pixels).sum();
        if pixels == 0 || self.groups.iter().any(|group| group.samples < 4) {
            return None;
        }
        let total: f64 = self
            .groups
            .iter()
            .map(|group| group.pixels as f64 * f64::from(group.samples))
            .sum();
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
        self.spreads.len() as f64
    }

    /// The error of each pixel and channel of `film`, whose state was taken in last: the root of its mean square over the
    /// 3 × 3 pixels around it, as a single one's says little.
    #[must_use]
    pub fn image(&self, film: &Film) -> Image {
        let region = film.region();
        let survey = Survey::of(film);
        let factor = |x: usize, y: usize| {
            let samples = film.samples(y * survey.width + x);
            if samples < 2 {
                return 0.0;
            }
            self.factor(ABSOLUTE, samples)
        };
        let pixel = |index: usize| {
            let (x, y) = (index % survey.width, index / survey.width);
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for row in y.saturating_sub(1)..=(y + 1).min(survey.height - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(survey.width - 1) {
                    let moved = survey.moves[row * survey.width + column].map(f64::from);
                    if moved.iter().all(|value| value.is_finite()) {
                        let factor = factor(column, row);
                        sum = [0, 1, 2].map(|c| sum[c] + factor * moved[c] * moved[c]);
                        count += 1.0;
                    }
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
            sum.map(|sum: f64| (sum / f64::max(count, 1.0)).sqrt() as f32)
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

    /// The fall of the relative error.
    #[must_use]
    pub fn decay(&self) -> &Decay {
        &self.decays[RELATIVE]
    }

    /// Relative squared drop of each pixel at its last power of two, mean over channels.
    #[must_use]
    pub fn spreads(&self) -> &[f32] {
        &self.spreads
    }

    /// Variance over drop for pixels with `samples`.
    fn factor(&self, measure: usize, samples: u32) -> f64 {
        variance_over_drop(&self.decays[measure], samples)
    }

    fn mean_square(&self, measure: usize, pixels: u64) -> Interval {
        let (mut variance, mut products, mut squared_products) = (0.0, 0.0, 0.0);
        for group in &self.groups {
            let sums = &group.measures[measure];
            let factor = self.factor(measure, group.samples);
            variance += factor * sums.drop;
            let scale = (2.0 * factor * self.decays[measure].ratio(group.level())).powi(2);
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
        // both halves are noisy, and small where one rare sample makes all the error, as that is seen in full. Either of the two
        // squares has half of the difference's variance.
        let chance = products / (variance * variance) / 2.0;
        let steepness = self.steepness(measure);
        let of_drop = (1.0 + steepness).powi(2);
        let of_drop_before = steepness.powi(2) / 2.0;
        let level = self.largest_group().map_or(0, Group::level);
        let settled = self.decays[measure].variance_over_drop(level);
        let doubt = MODEL_DOUBT
            + MODEL_DOUBT_OF_FAST_DECAY * (1.0 - settled).max(0.0)
            + EARLY_DOUBT * EARLY_DOUBT_FALL.powi(level.cast_signed() - 2);
        let chance = chance * (1.0 + of_drop + of_drop_before);
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

    /// By how many per cent the factor from drop to variance grows with one per cent of the last link.
    fn steepness(&self, measure: usize) -> f64 {
        const STEP: f64 = 1.05;
        let mut links = links(&self.history[measure]);
        let Some((last, group)) = links.last_mut().zip(self.largest_group()) else {
            return 0.0;
        };
        *last *= STEP;
        let moved = Decay::fit(&links).variance_over_drop(group.level());
        let present = self.decays[measure].variance_over_drop(group.level());
        // No power law is steeper than the slowest and the next one in balance.
        ((moved / present).ln() / STEP.ln()).clamp(0.0, 1.5)
    }

    fn largest_group(&self) -> Option<&Group> {
        self.groups.iter().max_by_key(|group| group.pixels)
    }

    fn percentile(&self, film: &Film, survey: &Survey) -> f64 {
        let factors: Vec<(u32, f64)> = self
            .groups
            .iter()
            .map(|group| (group.samples, self.factor(ABSOLUTE, group.samples).sqrt()))
            .collect();
        let mut errors: Vec<f64> = (0..self.spreads.len())
            .filter_map(|index| {
                let samples = film.samples(index);
                let (_, factor) = factors.iter().find(|(count, _)| *count == samples)?;
                let moved = survey.moves[index].map(f32::abs);
                Some(f64::from(moved[0].max(moved[1]).max(moved[2])) * factor)
            })
            .collect();
        if errors.is_empty() {
            return 0.0;
        }
        let rank = errors.len() - 1 - errors.len() / 1000;
        *errors.select_nth_unstable_by(rank, f64::total_cmp).1
    }
}

/// What the drop at the last power of two must be multiplied with to give the variance after `samples`.
fn variance_over_drop(decay: &Decay, samples: u32) -> f64 {
    let level = samples.ilog2();
    decay.variance_over_drop(level) * decay.variance(samples) / decay.variance(1 << level)
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
    /// Mean of all samples minus mean of the first half, at the last power of two.
    moves: Vec<[f32; 3]>,
}

/// Of one row of pixels.
struct RowSums {
    groups: Vec<Group>,
    /// For each level that pixels have just reached, the sums of drops there and, twice, one level below.
    reached: Vec<(u32, [[f64; 2]; 2])>,
    unmeasured: u64,
}

impl Survey {
    fn of(film: &Film) -> Self {
        let region = film.region();
        let values = (0..region.pixel_count()).into_par_iter().map(|index| {
            let mean = film.mean_at(index);
            #[expect(clippy::cast_possible_truncation, reason = "a difference of f32")]
            let moved = film
                .halves(index)
                .map_or([0.0; 3], |halves| halves.whole.map(|value| value as f32));
            if is_finite(mean) && is_finite(moved) {
                (mean, moved)
            } else {
                // Marks the pixel, and looks black to its neighbours.
                ([0.0; 3], [f32::NAN; 3])
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

    /// Adds up row `y`, and writes the relative spread of its pixels.
    fn row(
        &self,
        film: &Film,
        y: usize,
        spreads: &mut [f32],
        selected: Option<&[bool]>,
    ) -> RowSums {
        let mut sums = RowSums {
            groups: Vec::new(),
            reached: Vec::new(),
            unmeasured: 0,
        };
        let columns: Vec<Column> = (0..self.width).map(|x| self.column(x, y)).collect();
        for x in 0..self.width {
            let index = y * self.width + x;
            let moved = self.moves[index].map(f64::from);
            let Some(halves) = film.halves(index).filter(|_| is_finite(self.moves[index])) else {
                sums.unmeasured += 1;
                spreads[x] = 0.0;
                continue;
            };
            let around = [
                &columns[x.saturating_sub(1)],
                &columns[x],
                &columns[(x + 1).min(self.width - 1)],
            ];
            let weights = [0, 1, 2].map(|c| {
                let reference = expected(f64::from(self.means[index][c]), around, c);
                1.0 / (reference * reference + RELATIVE_FLOOR)
            });
            let weighted = |a: [f64; 3], b: [f64; 3]| {
                [
                    a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
                    a[0] * b[0] * weights[0] + a[1] * b[1] * weights[1] + a[2] * b[2] * weights[2],
                ]
            };
            let drop = weighted(moved, moved);
            #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
            {
                spreads[x] = (drop[RELATIVE] / 3.0) as f32;
            }
            // Between powers of two the parts are gone; the whole stands for both.
            let [first, second] = halves.parts.unwrap_or([moved, moved]);
            let products = weighted(first, second);
            let group = sums.group(film.samples(index));
            group.pixels += 1;
            for measure in [ABSOLUTE, RELATIVE] {
                let product = products[measure].powi(2);
                let sums = &mut group.measures[measure];
                sums.drop += drop[measure];
                sums.products += product;
                sums.squared_products += product * product;
            }
            if halves.parts.is_some() && selected.is_none_or(|selected| selected[index]) {
                let (first, second) = (weighted(first, first), weighted(second, second));
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
                column.drops[c] += if moved.is_finite() {
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
    drops: [f64; 3],
}

/// What a pixel's channel `c` of mean `value` most likely is in truth, from the 3 × 3 pixels around it: its own value where they
/// differ by more than their noise explains, else the mean of the others, so that a pixel with an error of its own does not
/// hide it by looking bright. Source: Lee, Digital image enhancement and noise filtering by use of local statistics, 1980.
fn expected(value: f64, around: [&Column; 3], c: usize) -> f64 {
    let over = |field: fn(&Column) -> &[f64; 3]| -> f64 {
        around.iter().map(|column| field(column)[c]).sum()
    };
    let (sum, squares) = (over(|column| &column.sum), over(|column| &column.squares));
    let noise = over(|column| &column.drops) / 9.0;
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
