//! What the pixels of a film say of its error: by how much their means moved, compared with their neighbours and added up row by row.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::RELATIVE_FLOOR;
use super::measures::Measures;
use crate::control::CancelToken;
use crate::render::film::{CHUNK, Film, Halves, each};

/// What is added up over pixels with the same number of samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Sums {
    /// Squared moves of the mean over all channels when samples went from a quarter to all.
    pub fall: f64,
    /// Squares of the product of the moves within the two halves, over channels.
    pub products: f64,
    /// Their squares.
    pub squared_products: f64,
}

impl Sums {
    pub fn add(&mut self, other: &Self) {
        self.fall += other.fall;
        self.products += other.products;
        self.squared_products += other.squared_products;
    }
}

/// Pixels with the same number of samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Group {
    pub samples: u32,
    pub pixels: u64,
    pub sums: Measures<Sums>,
}

impl Group {
    pub fn level(&self) -> u32 {
        self.samples.ilog2()
    }
}

/// Sums of drops over all pixels that have reached a level.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Drops {
    /// Of drops there.
    pub at: f64,
    /// Of those of both their halves, one level below.
    pub below: f64,
}

impl Drops {
    pub fn add(&mut self, other: &Self) {
        self.at += other.at;
        self.below += other.below;
    }
}

/// The mean of a pixel and by how much it moved, see [`Survey`].
fn mean_and_moves(film: &Film, index: usize) -> ([f32; 3], [f32; 3]) {
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
}

/// What the pixels of a film say, before it is added up.
pub struct Survey {
    pub width: usize,
    pub height: usize,
    means: Vec<[f32; 3]>,
    /// By how much the mean moved when samples went from a quarter to all, at the last power of two; not a number where it is
    /// not measured.
    pub moves: Vec<[f32; 3]>,
}

/// Of one row of pixels.
pub struct RowSums {
    pub groups: Vec<Group>,
    /// By the levels that pixels have just reached.
    pub reached: Vec<(u32, Measures<Drops>)>,
    /// Pixels that are infinite or not a number.
    pub unmeasured: u64,
}

/// Squared moves of a pixel's mean from a quarter to all of its samples, from all three doublings that are seen.
fn squared_fall(halves: &Halves) -> [f64; 3] {
    let [first, second] = halves.parts;
    each(|c| halves.whole[c].powi(2) + f64::midpoint(first[c].powi(2), second[c].powi(2)))
}

impl Survey {
    /// Of all pixels; `None` when cancelled.
    pub fn of(film: &Film, cancel: &CancelToken) -> Option<Self> {
        let region = film.region();
        let black = vec![[0.0; 3]; region.pixel_count()];
        let (mut means, mut moves) = (black.clone(), black);
        let parts = means.par_chunks_mut(CHUNK).zip(moves.par_chunks_mut(CHUNK));
        parts.enumerate().for_each(|(part, (means, moves))| {
            if cancel.is_cancelled() {
                return;
            }
            let pixels = means.iter_mut().zip(moves);
            for (index, (mean, moved)) in (part * CHUNK..).zip(pixels) {
                (*mean, *moved) = mean_and_moves(film, index);
            }
        });
        (!cancel.is_cancelled()).then_some(Self {
            width: region.width as usize,
            height: region.height as usize,
            means,
            moves,
        })
    }

    pub fn is_measured(&self, index: usize) -> bool {
        is_finite(self.moves[index])
    }

    /// Adds up row `y`, and writes the relative falls of its pixels.
    pub fn row(
        &self,
        film: &Film,
        y: usize,
        falls: &mut [f32],
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
                Measures {
                    absolute: r + g + b,
                    relative: r * weight_r + g * weight_g + b * weight_b,
                }
            };
            let product = |a: [f64; 3], b: [f64; 3]| both(each(|c| a[c] * b[c]));
            let [first, second] = halves.parts;
            let fall = both(squared_fall(&halves));
            let products = product(first, second);
            #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
            {
                falls[x] = (fall.relative / 3.0) as f32;
            }
            let group = sums.group(film.samples(index));
            group.pixels += 1;
            group.sums.change_by(&fall, |sums, fall| sums.fall += fall);
            group.sums.change_by(&products, |sums, product| {
                let product = product.powi(2);
                sums.products += product;
                sums.squared_products += product * product;
            });
            if halves.is_complete && selected.is_none_or(|selected| selected[index]) {
                let drop = product(halves.whole, halves.whole);
                let below = product(first, first) + product(second, second);
                let reached = sums.reached(halves.level);
                reached.change_by(&drop, |drops, drop| drops.at += drop);
                reached.change_by(&below, |drops, below| drops.below += below);
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

    fn reached(&mut self, level: u32) -> &mut Measures<Drops> {
        let known = self.reached.iter().position(|(known, _)| *known == level);
        let place = known.unwrap_or_else(|| {
            self.reached.push((level, Measures::default()));
            self.reached.len() - 1
        });
        &mut self.reached[place].1
    }
}

fn is_finite(rgb: [f32; 3]) -> bool {
    rgb.iter().all(|value| value.is_finite())
}
