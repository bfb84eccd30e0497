//! Where the next samples do most for a picture.
//!
//! Doubling a pixel's samples removes a known part of its variance ([`Decay`]) at a known price. The best picture for a number
//! of samples is the one where no doubling left undone removes more per sample than any that was done: one threshold for all
//! pixels. Pixels are sorted into cells by the logarithm of their noise, so that a threshold is found without looking at the
//! pixels again.
//!
//! A pixel's own samples have no say in how many it gets: its noise is judged by those neighbours that lie on the other colour of
//! a chessboard. Deciding by its own samples would stop early where they happened to miss something bright, and leave the
//! picture too dark.

use rayon::prelude::*;

use super::{Decay, ErrorEstimator};
use crate::render::film::Film;
use crate::scene::RenderSettings;

/// Bits of an `f32` that tell a cell: the exponent's and three more, so eight cells to an octave.
const CELL_BITS: u32 = 11;
const CELLS: usize = 1 << CELL_BITS;
/// Those bits that do not, the sign aside.
const BITS_WITHIN_CELL: u32 = 31 - CELL_BITS;

/// The least share of the samples so far that a round takes: shorter ones are not worth their survey.
const LEAST_SHARE: f64 = 1.0 / 32.0;

/// The need for samples over a film.
#[derive(Clone, Debug)]
pub struct Allotment {
    curve: Curve,
    /// Per pixel: its variance over that of the decay curve.
    noise: Vec<f32>,
    cells: Vec<Cell>,
}

/// The variance of a pixel of noise 1, kept at every power of two, where it is asked for again and again.
#[derive(Clone, Debug)]
struct Curve {
    decay: Decay,
    at_powers: [f64; 1 + RenderSettings::MAX_SAMPLES.ilog2() as usize],
}

impl Curve {
    fn new(decay: Decay) -> Self {
        Self {
            decay,
            at_powers: std::array::from_fn(|level| decay.variance(1 << level)),
        }
    }

    fn variance(&self, samples: u32) -> f64 {
        if samples.is_power_of_two() {
            self.at_powers[samples.ilog2() as usize]
        } else {
            self.decay.variance(samples)
        }
    }
}

/// Pixels with the same number of samples and about the same noise.
#[derive(Clone, Copy, Debug)]
struct Cell {
    samples: u32,
    place: usize,
    pixels: f64,
}

/// What it takes to reach a level of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The gain per sample below which doublings are left undone.
    threshold: f64,
    /// Samples still to take.
    pub samples: f64,
    /// Whether they suffice.
    pub is_reached: bool,
}

impl Forecast {
    /// Every sample that can be taken.
    pub const ALL: Self = Self {
        threshold: 0.0,
        samples: f64::INFINITY,
        is_reached: false,
    };
}

impl Allotment {
    /// Judges the pixels of `film`. Uses the threads of the current pool.
    pub fn new(film: &Film, estimator: &ErrorEstimator) -> Self {
        let region = film.region();
        let (width, height) = (region.width as usize, region.height as usize);
        let curve = Curve::new(estimator.decay());
        let falls = estimator.falls();
        let own: Vec<f32> = (0..region.pixel_count())
            .into_par_iter()
            .map(|index| {
                let samples = film.samples(index);
                let scale = estimator.variance_over_fall(samples) / curve.variance(samples);
                #[expect(clippy::cast_possible_truncation, reason = "precise enough to compare")]
                {
                    (f64::from(falls[index]) * scale) as f32
                }
            })
            .collect();
        let mut noise = vec![0.0; own.len()];
        noise
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, noise) in row.iter_mut().enumerate() {
                    *noise = of_neighbours(&own, [width, height], [x, y]);
                }
            });

        let mut counts: Vec<(u32, Vec<u64>)> = Vec::new();
        for (index, &noise) in noise.iter().enumerate() {
            let samples = film.samples(index);
            let known = counts.iter().position(|(known, _)| *known == samples);
            let row = known.unwrap_or_else(|| {
                counts.push((samples, vec![0; CELLS]));
                counts.len() - 1
            });
            counts[row].1[place_of(noise)] += 1;
        }
        let cells = counts.into_iter().flat_map(|(samples, row)| {
            let filled = row
                .into_iter()
                .enumerate()
                .filter(|(_, pixels)| *pixels > 0);
            filled.map(move |(place, pixels)| Cell {
                samples,
                place,
                pixels: pixels as f64,
            })
        });
        Self {
            curve,
            cells: cells.collect(),
            noise,
        }
    }

    /// What brings the variance down to `share` of what it is, `0..=1`, with the fewest samples, where no pixel gets more than
    /// `most`.
    pub fn for_variance(&self, share: f64, most: u32) -> Forecast {
        let variance = |cell: &Cell, samples| noise_at(cell.place) * self.curve.variance(samples);
        let goal = share * self.sum(|cell| variance(cell, cell.samples));
        let left =
            |threshold: f64| self.sum(|cell| variance(cell, self.target(cell, threshold, most)));
        let threshold = bisect(|threshold| left(threshold) <= goal);
        Forecast {
            threshold,
            samples: self.sum(|cell| f64::from(self.target(cell, threshold, most) - cell.samples)),
            is_reached: left(threshold) <= goal,
        }
    }

    /// The pixels whose samples are to be doubled next on the way of `forecast`, or as far as `budget` more samples allow.
    /// None gets more than `most` samples; `None` when all have them.
    pub fn select(
        &self,
        film: &Film,
        forecast: Forecast,
        budget: f64,
        most: u32,
    ) -> Option<Vec<bool>> {
        let total = self.sum(|cell| f64::from(cell.samples));
        let next = |threshold: f64| {
            self.sum(|cell| {
                if self.gain(cell, cell.samples, most) > threshold {
                    f64::from(doubled(cell.samples, most) - cell.samples)
                } else {
                    0.0
                }
            })
        };
        let affordable = bisect(|threshold| next(threshold) >= budget);
        let worthwhile = bisect(|threshold| next(threshold) >= total * LEAST_SHARE);
        let threshold = forecast.threshold.max(affordable).min(worthwhile);
        let is_selected = |(index, &noise): (usize, &f32)| {
            let samples = film.samples(index);
            let cell = Cell {
                samples,
                place: place_of(noise),
                pixels: 1.0,
            };
            self.gain(&cell, samples, most) > threshold
        };
        let selected: Vec<bool> = self.noise.iter().enumerate().map(is_selected).collect();
        selected.contains(&true).then_some(selected)
    }

    /// By how much a pixel's variance falls per sample, when its number is doubled from `samples`; 0 where it has the most.
    fn gain(&self, cell: &Cell, samples: u32, most: u32) -> f64 {
        let doubled = doubled(samples, most);
        if doubled == samples {
            return 0.0;
        }
        let fall = self.curve.variance(samples) - self.curve.variance(doubled);
        noise_at(cell.place) * fall / f64::from(doubled - samples)
    }

    /// How many samples a pixel ends with.
    fn target(&self, cell: &Cell, threshold: f64, most: u32) -> u32 {
        let mut samples = cell.samples;
        while self.gain(cell, samples, most) > threshold {
            samples = doubled(samples, most);
        }
        samples
    }

    fn sum(&self, value: impl Fn(&Cell) -> f64) -> f64 {
        self.cells
            .iter()
            .map(|cell| cell.pixels * value(cell))
            .sum()
    }
}

fn doubled(samples: u32, most: u32) -> u32 {
    samples.saturating_mul(2).min(most).max(samples)
}

/// The nearest neighbours of a pixel, as steps in x and y: on a chessboard, they have the other colour.
const NEIGHBOURS: [[isize; 2]; 4] = [[0, -1], [-1, 0], [1, 0], [0, 1]];

/// The mean of `values` over the [`NEIGHBOURS`] of one.
fn of_neighbours(values: &[f32], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for [dx, dy] in NEIGHBOURS {
        let (Some(column), Some(row)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if column < width && row < height {
            sum += values[row * width + column];
            count += 1.0;
        }
    }
    if count > 0.0 { sum / count } else { values[0] }
}

/// The cell of a noise of at least 0.
fn place_of(noise: f32) -> usize {
    (noise.to_bits() >> BITS_WITHIN_CELL) as usize
}

/// The noise in the middle of a cell.
fn noise_at(place: usize) -> f64 {
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
