//! Where the next samples do most for a picture.
//!
//! Doubling a pixel's samples removes a known part of its variance ([`Decay`]) at a known price: the rays they take. The best
//! picture for a price is the one where no doubling left undone removes more for it than any that was done: one threshold for
//! all pixels. Pixels are sorted into cells by the logarithm of what a sample is worth there, so that a threshold is found
//! without looking at the pixels again.
//!
//! A pixel's own samples have no say in how many it gets: its noise and its price are judged by those neighbours that lie on the
//! other colour of a chessboard. Deciding by its own samples would stop early where they happened to miss something bright, and
//! leave the picture too dark.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Decay, ErrorEstimator};
use crate::control::CancelToken;
use crate::render::film::{CHUNK, Film};

/// Bits of an `f32` that tell a cell: the exponent's and three more, so eight cells to an octave.
const CELL_BITS: u32 = 11;
const CELLS: usize = 1 << CELL_BITS;
/// The bits below those.
const BITS_WITHIN_CELL: u32 = 31 - CELL_BITS;

/// The least share of the samples so far that a round takes: shorter ones are not worth their survey.
pub const LEAST_SHARE: f64 = 1.0 / 32.0;

/// The share of the samples so far that are handed out before it is decided again where they belong.
pub const ROUND_SHARE: f64 = 0.5;

/// The least part of what judgements promise that is counted on: less is said by chance.
const LEAST_KEPT: f64 = 0.25;

/// The need for samples over a film.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Allotment {
    decay: Decay,
    /// Per pixel: its variance, over that of the decay curve, for the price of a sample.
    worth: Vec<f32>,
    cells: Vec<Cell>,
}

/// Pixels with the same number of samples, each of which is worth about the same.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Cell {
    samples: u32,
    place: usize,
    sums: PixelSums,
}

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct PixelSums {
    /// Of their variances, each over that of the decay curve.
    noise: f64,
    /// The same by what each shows itself.
    own_noise: f64,
    /// Of the prices of a sample in each.
    price: f64,
    /// Their number.
    pixels: f64,
}

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Judgement {
    noise: f32,
    price: f32,
}

/// What it takes to reach a level of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The gain per sample below which doublings are left undone.
    threshold: f64,
    /// Samples still to take.
    pub samples: f64,
    /// How many of the mean price of those taken so far they are worth.
    pub price: f64,
    /// Whether they suffice.
    pub is_reached: bool,
}

impl Forecast {
    /// Every sample that can be taken.
    pub const ALL: Self = Self {
        threshold: 0.0,
        samples: f64::INFINITY,
        price: f64::INFINITY,
        is_reached: false,
    };
}

impl Allotment {
    /// Judges the pixels of `film`. Uses the threads of the current pool. `None` when cancelled.
    pub fn new(film: &Film, estimator: &ErrorEstimator, cancel: &CancelToken) -> Option<Self> {
        let region = film.region();
        let (width, height) = (region.width as usize, region.height as usize);
        let decay = estimator.decay();
        let falls = estimator.falls();
        let mean_rays = film.total_rays() as f64 / film.total_samples() as f64;
        #[expect(clippy::cast_possible_truncation, reason = "precise enough to compare")]
        let own: Vec<Judgement> = (0..region.pixel_count())
            .into_par_iter()
            .map(|index| {
                if cancel.is_cancelled() {
                    return Judgement::default();
                }
                let samples = film.samples(index);
                let scale = estimator.variance_over_fall(samples) / decay.variance(samples);
                let rays = f64::from(film.rays(index)) / f64::from(samples);
                Judgement {
                    noise: (f64::from(falls[index]) * scale) as f32,
                    price: (rays / mean_rays) as f32,
                }
            })
            .collect();
        let judged: Vec<Judgement> = (0..own.len())
            .into_par_iter()
            .map(|index| of_neighbours(&own, [width, height], [index % width, index / width]))
            .collect();

        let mut rows: Vec<(u32, Vec<PixelSums>)> = Vec::new();
        for (index, pixel) in judged.iter().enumerate() {
            if index % CHUNK == 0 && cancel.is_cancelled() {
                return None;
            }
            let samples = film.samples(index);
            let known = rows.iter().position(|(known, _)| *known == samples);
            let row = known.unwrap_or_else(|| {
                rows.push((samples, vec![PixelSums::default(); CELLS]));
                rows.len() - 1
            });
            let sums = &mut rows[row].1[place_of(pixel.worth())];
            sums.noise += f64::from(pixel.noise);
            sums.own_noise += f64::from(own[index].noise);
            sums.price += f64::from(pixel.price);
            sums.pixels += 1.0;
        }
        let cells = rows.into_iter().flat_map(|(samples, row)| {
            let filled = row
                .into_iter()
                .enumerate()
                .filter(|(_, sums)| sums.price > 0.0);
            filled.map(move |(place, sums)| Cell {
                samples,
                place,
                sums,
            })
        });
        Some(Self {
            decay,
            cells: cells.collect(),
            worth: judged.iter().map(|pixel| pixel.worth()).collect(),
        })
    }

    /// Whether it is one over a film of `pixels` pixels, which is not certain where it was read from a file.
    pub fn is_like(&self, pixels: usize) -> bool {
        self.worth.len() == pixels && self.cells.iter().all(|cell| cell.place < CELLS)
    }

    /// Samples of all pixels when they were judged.
    pub fn samples(&self) -> f64 {
        self.sum(|cell| cell.sums.pixels * f64::from(cell.samples))
    }

    /// What brings the variance down to `share` of what it is, `0..=1`, with the fewest samples, where every pixel gets at least
    /// `least` and none more than `most`.
    pub fn for_variance(&self, share: f64, [least, most]: [u32; 2]) -> Forecast {
        let variance = |cell: &Cell, samples| cell.sums.noise * self.decay.variance(samples);
        let goal = share * self.sum(|cell| variance(cell, cell.samples));
        let target = |cell: &Cell, threshold| self.target(cell, threshold, [least, most]);
        let left = |threshold: f64| self.sum(|cell| variance(cell, target(cell, threshold)));
        let threshold = bisect(|threshold| left(threshold) <= goal);
        let missing = |cell: &Cell| target(cell, threshold) - cell.samples;
        Forecast {
            threshold,
            samples: self.sum(|cell| cell.sums.pixels * f64::from(missing(cell))),
            price: self.sum(|cell| cell.sums.price * f64::from(missing(cell))),
            is_reached: left(threshold) <= goal,
        }
    }

    /// [`Self::for_variance`] as it will be: judgements are themselves uncertain, and what they choose brings less than they promise. By how
    /// much shows in what the chosen pixels tell of themselves, which is independent of it; every round falls short like the next one.
    pub fn forecast(&self, share: f64, [least, most]: [u32; 2]) -> Forecast {
        let kept = self.kept_promise(most);
        self.for_variance(libm::pow(share, kept.recip()), [least, most])
    }

    /// Which part of the fall of the logarithm of variance that the next round promises will come, at most 1.
    fn kept_promise(&self, most: u32) -> f64 {
        let budget = ROUND_SHARE * self.sum(|cell| cell.sums.price * f64::from(cell.samples));
        let threshold = bisect(|threshold| self.price_of_doubling(threshold, most) >= budget);
        let fall = |noise: fn(&PixelSums) -> f64| {
            let variance = |cell: &Cell, samples| noise(&cell.sums) * self.decay.variance(samples);
            let before = self.sum(|cell| variance(cell, cell.samples));
            let after = self.sum(|cell| {
                let is_chosen = self.gain(cell.place, cell.samples, most) > threshold;
                let samples = if is_chosen {
                    doubled(cell.samples, most)
                } else {
                    cell.samples
                };
                variance(cell, samples)
            });
            libm::log(before / after)
        };
        let kept = fall(|sums| sums.own_noise) / fall(|sums| sums.noise);
        if kept.is_finite() {
            kept.clamp(LEAST_KEPT, 1.0)
        } else {
            1.0
        }
    }

    /// What it takes, in samples of mean price, to double the samples where it brings more than `threshold`.
    fn price_of_doubling(&self, threshold: f64, most: u32) -> f64 {
        self.sum(|cell| {
            if self.gain(cell.place, cell.samples, most) > threshold {
                cell.sums.price * f64::from(doubled(cell.samples, most) - cell.samples)
            } else {
                0.0
            }
        })
    }

    /// The pixels whose samples are to be doubled next on the way to `forecast`, or as far as `budget` more samples of mean price allow.
    /// None gets more than `most` samples; `None` when all have them, and when cancelled.
    pub fn select(
        &self,
        film: &Film,
        forecast: Forecast,
        budget: f64,
        most: u32,
        cancel: &CancelToken,
    ) -> Option<Vec<bool>> {
        let total = self.sum(|cell| cell.sums.price * f64::from(cell.samples));
        let next = |threshold: f64| self.price_of_doubling(threshold, most);
        let affordable = bisect(|threshold| next(threshold) >= budget);
        let worthwhile = bisect(|threshold| next(threshold) >= total * LEAST_SHARE);
        let threshold = forecast.threshold.max(affordable).min(worthwhile);
        let is_selected = |(index, &worth): (usize, &f32)| {
            let is_cancelled = index % CHUNK == 0 && cancel.is_cancelled();
            let gain = || self.gain(place_of(worth), film.samples(index), most);
            (!is_cancelled).then(|| gain() > threshold)
        };
        let selected = self.worth.iter().enumerate().map(is_selected);
        let selected: Vec<bool> = selected.collect::<Option<_>>()?;
        selected.contains(&true).then_some(selected)
    }

    /// By how much a pixel's variance falls per sample of mean price when its samples are doubled from `samples`; 0 where it has the most.
    fn gain(&self, place: usize, samples: u32, most: u32) -> f64 {
        let doubled = doubled(samples, most);
        if doubled == samples {
            return 0.0;
        }
        let fall = self.decay.variance(samples) - self.decay.variance(doubled);
        worth_at(place) * fall / f64::from(doubled - samples)
    }

    /// How many samples a pixel ends with.
    fn target(&self, cell: &Cell, threshold: f64, [least, most]: [u32; 2]) -> u32 {
        let mut samples = cell.samples;
        while samples < least.min(most) || self.gain(cell.place, samples, most) > threshold {
            samples = doubled(samples, most);
        }
        samples
    }

    fn sum(&self, value: impl Fn(&Cell) -> f64) -> f64 {
        self.cells.iter().map(value).sum()
    }
}

fn doubled(samples: u32, most: u32) -> u32 {
    samples.saturating_mul(2).min(most).max(samples)
}

/// The nearest neighbours of a pixel, as steps in x and y: on a chessboard, they have the other colour.
const NEIGHBOURS: [[isize; 2]; 4] = [[0, -1], [-1, 0], [1, 0], [0, 1]];

impl Judgement {
    fn worth(self) -> f32 {
        self.noise / self.price
    }
}

/// The mean of the judgements of the [`NEIGHBOURS`] of a pixel, or its own where it has none.
fn of_neighbours(own: &[Judgement], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> Judgement {
    let (mut sum, mut count) = (Judgement::default(), 0.0);
    for [dx, dy] in NEIGHBOURS {
        let (Some(column), Some(row)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if column < width && row < height {
            sum.noise += own[row * width + column].noise;
            sum.price += own[row * width + column].price;
            count += 1.0;
        }
    }
    if count == 0.0 {
        return own[0];
    }
    Judgement {
        noise: sum.noise / count,
        price: sum.price / count,
    }
}

/// The cell of a worth of at least 0.
fn place_of(worth: f32) -> usize {
    (worth.to_bits() >> BITS_WITHIN_CELL) as usize
}

/// The worth in the middle of a cell.
fn worth_at(place: usize) -> f64 {
    if place == 0 {
        return 0.0;
    }
    let bits = u32::try_from(place).expect("is a cell") << BITS_WITHIN_CELL;
    f64::from(f32::from_bits(bits | 1 << (BITS_WITHIN_CELL - 1)))
}

/// The largest threshold from 2⁻²⁰⁰ to 2²⁰⁰ at which `holds`, which is true of small ones; the smallest where it never does.
fn bisect(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (-200.0, 200.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if holds(libm::exp2(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::exp2(low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::render::film::{TileSums, block_after};
    use crate::render::layers::{Gathered, NoParts};
    use crate::render::tiles::Region;

    const WIDTH: usize = 64;

    /// A film of 64 × 64 pixels of the same noise after 64 independent samples each, whose samples take 1 ray in the left half
    /// and `price` rays in the right one.
    fn film(price: u32) -> Film {
        let region = Region::full(64, 64);
        let mut film = Film::new(region, &[], true);
        let mut state = 1_u32;
        while film.samples(0) < 64 {
            let mut sums = TileSums::default();
            sums.reset(&[], region.pixel_count());
            for index in 0..region.pixel_count() {
                for _ in 0..block_after(film.samples(0)) {
                    // Source of the constants: Numerical Recipes, 3rd edition, 7.1.
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let value = if state >> 31 == 0 { 0.5 } else { 1.5 };
                    let rays = if index % WIDTH < WIDTH / 2 { 1 } else { price };
                    sums.add(
                        index,
                        &[],
                        &Gathered::<NoParts>::seen(Vec3::splat(value)),
                        rays,
                    );
                }
            }
            film.add(region, &sums);
        }
        film
    }

    /// The number of samples n that makes Σ σ²/n smallest for a given Σ c·n is as 1/√c. Doublings come within a factor of two.
    #[test]
    fn dear_samples_are_taken_where_they_pay() {
        for (price, expected) in [(1, 1.0), (16, 4.0), (64, 8.0)] {
            let film = film(price);
            let mut estimator = ErrorEstimator::new(film.pixels());
            let never = CancelToken::new();
            estimator
                .update(&film, None, &never)
                .expect("nobody cancels");
            let allotment = Allotment::new(&film, &estimator, &never).expect("nobody cancels");
            let most = 1 << 20;
            let forecast = allotment.for_variance(1.0 / 64.0, [1, most]);
            assert!(forecast.is_reached);
            let samples = |is_right: bool| {
                let of_half = |(index, _): &(usize, &f32)| (index % WIDTH >= WIDTH / 2) == is_right;
                let half = allotment.worth.iter().enumerate().filter(of_half);
                let target = |(index, &worth): (usize, &f32)| {
                    let cell = Cell {
                        samples: film.samples(index),
                        place: place_of(worth),
                        sums: PixelSums::default(),
                    };
                    f64::from(allotment.target(&cell, forecast.threshold, [1, most]))
                };
                half.map(target).sum::<f64>()
            };
            let ratio = samples(false) / samples(true) / expected;
            assert!((0.71..1.41).contains(&ratio), "{price}: {ratio}");
        }
    }
}
