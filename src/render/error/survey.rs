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

/// Sums of one row of pixels.
pub struct RowSums {
    pub groups: Vec<Group>,
    /// By the levels that pixels have just reached.
    pub reached: Vec<(u32, Measures<Drops>)>,
    /// Pixels that are infinite or not a number.
    pub unmeasured: u64,
}

/// What is written for each pixel of some rows.
pub struct PerPixel<'a> {
    /// Relative squared fall, mean over channels; 0 where it is not measured.
    pub falls: &'a mut [f32],
    /// By how much the mean of one channel moved at the last doubling, at most; not a number where it is not measured.
    pub moves: &'a mut [f64],
}

/// Squared moves of a pixel's mean from a quarter to all of its samples, from all three doublings that are seen.
fn squared_fall(halves: &Halves) -> [f64; 3] {
    let [first, second] = halves.parts;
    each(|c| halves.whole[c].powi(2) + 0.5 * (first[c].powi(2) + second[c].powi(2)))
}

/// What a pixel that is measured says by itself.
struct Seen {
    mean: [f32; 3],
    /// By how much the mean moved when samples went from a quarter to all, at the last power of two.
    moves: [f32; 3],
    halves: Halves,
}

/// `None` where the pixel number `index` is not measured: before it has two samples, and where it is infinite or not a number.
#[expect(
    clippy::inline_always,
    reason = "a fifth of a survey is copying what is seen"
)]
#[inline(always)]
fn seen(film: &Film, index: usize) -> Option<Seen> {
    let halves = film.halves(index)?;
    let mean = film.mean_at(index);
    #[expect(clippy::cast_possible_truncation, reason = "of means that are f32")]
    let moves = squared_fall(&halves).map(|square| square.sqrt() as f32);
    (is_finite(mean) && is_finite(moves)).then_some(Seen {
        mean,
        moves,
        halves,
    })
}

/// By how much the mean of each pixel moved, see [`Seen`]; not a number where that is not measured. `None` when cancelled.
pub fn moves(film: &Film, cancel: &CancelToken) -> Option<Vec<[f32; 3]>> {
    let mut moves = vec![[f32::NAN; 3]; film.pixels()];
    let parts = moves.par_chunks_mut(CHUNK).enumerate();
    parts.for_each(|(part, moves)| {
        if cancel.is_cancelled() {
            return;
        }
        for (index, moves) in (part * CHUNK..).zip(moves) {
            if let Some(seen) = seen(film, index) {
                *moves = seen.moves;
            }
        }
    });
    (!cancel.is_cancelled()).then_some(moves)
}

/// What the pixels of a row say by themselves.
#[derive(Default)]
struct Row {
    /// `None` where a pixel is not measured.
    halves: Vec<Option<Halves>>,
    /// To its neighbours, a pixel that is not measured looks black and without noise.
    means: Padded,
    /// Squares of [`Seen::moves`].
    squared_moves: Padded,
}

/// Values of a row of pixels, with a pixel more at both ends that is as the one at the edge.
type Padded = Vec<[f64; 3]>;

impl Row {
    /// Reads row `y`.
    fn read(&mut self, film: &Film, y: usize) {
        let width = film.region().width as usize;
        self.halves.clear();
        for values in [&mut self.means, &mut self.squared_moves] {
            values.clear();
            values.push([0.0; 3]);
        }
        for index in y * width..(y + 1) * width {
            if let Some(seen) = seen(film, index) {
                self.means.push(each(|c| f64::from(seen.mean[c])));
                self.squared_moves
                    .push(each(|c| f64::from(seen.moves[c]).powi(2)));
                self.halves.push(Some(seen.halves));
            } else {
                self.means.push([0.0; 3]);
                self.squared_moves.push([0.0; 3]);
                self.halves.push(None);
            }
        }
        for values in [&mut self.means, &mut self.squared_moves] {
            values[0] = values[1];
            values.push(values[width]);
        }
    }
}

/// Sums over three pixels, one above the other.
#[derive(Default)]
struct Columns {
    means: Padded,
    squared_means: Padded,
    squared_moves: Padded,
}

impl Columns {
    fn add_up(&mut self, [above, own, below]: &[Row; 3]) {
        let means = [&above.means, &own.means, &below.means];
        add_rows(&mut self.means, means, |mean| mean);
        add_rows(&mut self.squared_means, means, |mean| mean * mean);
        let moves = [above, own, below].map(|row| &row.squared_moves);
        add_rows(&mut self.squared_moves, moves, |square| square);
    }
}

/// Adds up what `value` makes of three rows. Channels are all alike to it, so that the processor takes several at once.
fn add_rows(sums: &mut Padded, rows: [&Padded; 3], value: impl Fn(f64) -> f64) {
    let [above, own, below] = rows.map(|row| row.as_flattened());
    sums.resize(rows[0].len(), [0.0; 3]);
    let values = above.iter().zip(own).zip(below);
    for (sum, ((above, own), below)) in sums.as_flattened_mut().iter_mut().zip(values) {
        *sum = value(*above) + value(*own) + value(*below);
    }
}

/// Sums over three columns side by side, channel by channel, from the first pixel of the row to the last.
fn over_three(columns: &Padded) -> impl Iterator<Item = f64> {
    let [left, own, right] = [0, 3, 6];
    let channels = columns.as_flattened().windows(right + 1);
    channels.map(move |channels| channels[left] + channels[own] + channels[right])
}

/// Surveys a film row by row, downwards, and keeps its memory from one to the next.
#[derive(Default)]
pub struct Survey {
    /// The row above, the one that is surveyed, and that below; at the edge of the film, it is its own neighbour.
    rows: [Row; 3],
    columns: Columns,
    /// What makes squares of errors relative, per pixel and channel.
    weights: Vec<[f64; 3]>,
}

impl Survey {
    /// Adds up rows, each by itself: from number `first` on, as many as `pixels` has room for. `None` when cancelled.
    pub fn sum_rows(
        &mut self,
        film: &Film,
        first: usize,
        pixels: PerPixel<'_>,
        selected: Option<&[bool]>,
        cancel: &CancelToken,
    ) -> Option<Vec<RowSums>> {
        let (width, height) = (film.region().width as usize, film.region().height as usize);
        let [_, above, own] = &mut self.rows;
        above.read(film, first.saturating_sub(1));
        own.read(film, first);
        let PerPixel { falls, moves } = pixels;
        let pixels = falls.chunks_mut(width).zip(moves.chunks_mut(width));
        let rows = (first..).zip(pixels);
        let sums = rows.map(|(y, (falls, moves))| {
            self.rows.rotate_left(1);
            self.rows[2].read(film, (y + 1).min(height - 1));
            self.weigh();
            let sums = self.sum_row(film, y, PerPixel { falls, moves }, selected);
            (!cancel.is_cancelled()).then_some(sums)
        });
        sums.collect()
    }

    /// Finds the weights of the row that is surveyed.
    fn weigh(&mut self) {
        self.columns.add_up(&self.rows);
        let means = &self.rows[1].means;
        self.weights.resize(means.len() - 2, [0.0; 3]);
        let weights = self.weights.as_flattened_mut().iter_mut();
        let pixels = weights.zip(means[1..].as_flattened());
        let around = over_three(&self.columns.means)
            .zip(over_three(&self.columns.squared_means))
            .zip(over_three(&self.columns.squared_moves));
        for ((weight, &mean), ((means, squared_means), squared_moves)) in pixels.zip(around) {
            let reference = expected(mean, means, squared_means, squared_moves);
            *weight = 1.0 / (reference * reference + RELATIVE_FLOOR);
        }
    }

    /// Adds up row `y`, whose weights are known.
    fn sum_row(
        &self,
        film: &Film,
        y: usize,
        pixels: PerPixel<'_>,
        selected: Option<&[bool]>,
    ) -> RowSums {
        let mut sums = RowSums {
            groups: Vec::new(),
            reached: Vec::new(),
            unmeasured: 0,
        };
        let known = self.rows[1].halves.iter().zip(&self.weights);
        let written = pixels.falls.iter_mut().zip(pixels.moves);
        for (index, ((halves, weights), (fall, moved))) in
            (y * self.weights.len()..).zip(known.zip(written))
        {
            let Some(halves) = halves else {
                sums.unmeasured += 1;
                (*fall, *moved) = (0.0, f64::NAN);
                continue;
            };
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
            let squared_fall = both(squared_fall(halves));
            let products = product(first, second);
            #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
            {
                *fall = (squared_fall.relative / 3.0) as f32;
            }
            let [r, g, b] = halves.whole.map(f64::abs);
            *moved = r.max(g).max(b);
            let group = sums.group(film.samples(index));
            group.pixels += 1;
            group
                .sums
                .change_by(&squared_fall, |sums, fall| sums.fall += fall);
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
}

/// What a pixel's channel of mean `value` most likely is in truth, from the 3 × 3 pixels around it, over which means, their squares and those
/// of moves are added up: its own value where they differ by more than their noise explains, else the mean of the others, so that a pixel with an
/// error of its own does not hide it by looking bright. Source: Lee, Digital image enhancement and noise filtering by use of local
/// statistics, 1980.
fn expected(value: f64, sum: f64, squares: f64, squared_moves: f64) -> f64 {
    // A third of the fall is the variance, if samples count as independent.
    let noise = squared_moves / 27.0;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::Vec3;
    use crate::render::film::{TileSums, block_after};
    use crate::render::layers::{Gathered, NoParts};
    use crate::render::tiles::Region;

    /// A film of four samples of any brightness in each pixel, a pixel of the last column but one in every seven rows infinite.
    fn film(width: u32, height: u32) -> Film {
        let region = Region::full(width, height);
        let (mut film, mut random) = (Film::new(region, &[], true), Random::new(3));
        while film.samples(0) < 4 {
            let mut sums = TileSums::default();
            sums.reset(&[], region.pixel_count());
            for (index, (x, y)) in region.pixels().enumerate() {
                for _ in 0..block_after(film.samples(0)) {
                    #[expect(clippy::cast_possible_truncation, reason = "any value will do")]
                    let color = [0; 3].map(|_| random.unit() as f32);
                    let is_infinite = x + 2 == width && y % 7 == 0;
                    let value = if is_infinite {
                        [f32::INFINITY; 3]
                    } else {
                        color
                    };
                    let seen = Gathered::<NoParts>::seen(Vec3::from(value));
                    sums.add(index, &[], &seen, 1);
                }
            }
            film.add(region, &sums);
        }
        film
    }

    /// The relative squared fall of a pixel, from the 3 × 3 pixels around it one by one.
    fn relative_fall(film: &Film, x: usize, y: usize) -> f64 {
        let (width, height) = (film.region().width as usize, film.region().height as usize);
        let inside = |at: usize, step: usize, end: usize| (at + step).clamp(1, end) - 1;
        let mut sums = [[0.0; 3]; 3];
        for step in 0..9 {
            let (column, row) = (inside(x, step % 3, width), inside(y, step / 3, height));
            if let Some(seen) = seen(film, row * width + column) {
                for c in 0..3 {
                    let (mean, moved) = (f64::from(seen.mean[c]), f64::from(seen.moves[c]));
                    for (sum, value) in sums.iter_mut().zip([mean, mean * mean, moved * moved]) {
                        sum[c] += value;
                    }
                }
            }
        }
        let Some(seen) = seen(film, y * width + x) else {
            return 0.0;
        };
        let [means, squares, moves] = sums;
        let fall = each(|c| {
            let mean = f64::from(seen.mean[c]);
            let reference = expected(mean, means[c], squares[c], moves[c]);
            squared_fall(&seen.halves)[c] / (reference * reference + RELATIVE_FLOOR)
        });
        fall.iter().sum::<f64>() / 3.0
    }

    /// Films of one row, of one column, and of more rows than are surveyed at once: pixel by pixel, at edges and seams and beside what is
    /// not finite, the same as without anything kept.
    #[test]
    fn rows_are_surveyed_as_their_pixels_one_by_one() {
        for (width, height) in [(1, 1), (5, 1), (1, 5), (2, 2), (9, 40)] {
            let film = film(width, height);
            let (width, pixels) = (width as usize, film.pixels());
            let (mut falls, mut moves) = (vec![-1.0; pixels], vec![-1.0; pixels]);
            let (mut survey, never) = (Survey::default(), CancelToken::new());
            let mut unmeasured = 0;
            for first in (0..height as usize).step_by(16) {
                let from = first * width;
                let to = pixels.min(from + 16 * width);
                let written = PerPixel {
                    falls: &mut falls[from..to],
                    moves: &mut moves[from..to],
                };
                let sums = survey.sum_rows(&film, first, written, None, &never);
                let sums = sums.expect("nobody cancels");
                assert_eq!(sums.len(), (to - from) / width);
                unmeasured += sums.iter().map(|row| row.unmeasured).sum::<u64>();
            }
            for (index, (fall, moved)) in falls.into_iter().zip(moves).enumerate() {
                let (x, y) = (index % width, index / width);
                let expected = relative_fall(&film, x, y);
                let ratio = f64::from(fall) / expected;
                let is_infinite = x + 2 == width && y % 7 == 0;
                let is_same = if is_infinite {
                    fall == 0.0
                } else {
                    (ratio - 1.0).abs() < 1e-6
                };
                assert!(
                    is_same,
                    "({x}, {y}) of {width} × {height}: {fall}, {expected}"
                );
                assert_eq!(moved.is_nan(), is_infinite, "({x}, {y})");
                unmeasured -= u64::from(is_infinite);
            }
            assert_eq!(unmeasured, 0);
        }
    }
}
