//! Where to divide a set of boxes in two.

use super::Item;
use crate::accel::half_area;
use crate::accel::simd::LANES;
use crate::math::Bounds;

/// Sets of up to this many try every division along each axis; larger ones those between [`BINS`] slices.
const EXACT_LIMIT: usize = 256;

const BINS: usize = 64;

/// Rearranges at least two items and returns where to divide them: where the surface area heuristic, with what the blocks
/// cost that the triangles fill, is least among divisions by the boxes' centres. In the middle where all centres coincide
/// or `halve` asks for it.
#[inline(never)]
pub(super) fn divide(items: &mut [Item], halve: bool) -> usize {
    if halve {
        let centers = Bounds::of_points(items.iter().map(Item::center));
        let (axis, middle) = (centers.size().max_position(), items.len() / 2);
        items.select_nth_unstable_by(middle, |a, b| a.order(b, axis));
        middle
    } else if items.len() <= EXACT_LIMIT {
        divide_sorted(items)
    } else {
        divide_binned(items).unwrap_or(items.len() / 2)
    }
}

/// What a set of `count` triangles in `bounds` costs by the heuristic, up to a factor: blocks are tested as a whole.
fn cost(bounds: &Bounds, count: usize) -> f64 {
    half_area(bounds) * count.div_ceil(LANES) as f64
}

fn divide_sorted(items: &mut [Item]) -> usize {
    let count = items.len();
    let mut best = (f64::INFINITY, 2, count / 2);
    let mut after = [0.0; EXACT_LIMIT];
    for axis in 0..3 {
        items.sort_unstable_by(|a, b| a.order(b, axis));
        let mut right = Bounds::EMPTY;
        for (index, item) in items.iter().enumerate().rev() {
            right = right.union(item.bounds);
            after[index] = cost(&right, count - index);
        }
        let mut left = Bounds::EMPTY;
        for (index, item) in items[..count - 1].iter().enumerate() {
            left = left.union(item.bounds);
            let sum = cost(&left, index + 1) + after[index + 1];
            if sum < best.0 {
                best = (sum, axis, index + 1);
            }
        }
    }
    let (_, axis, middle) = best;
    if axis != 2 {
        items.sort_unstable_by(|a, b| a.order(b, axis));
    }
    middle
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self {
        bounds: Bounds::EMPTY,
        count: 0,
    };

    fn union(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            count: self.count + other.count,
        }
    }

    fn cost(&self) -> f64 {
        cost(&self.bounds, self.count)
    }
}

/// Which slice along an axis a box's centre lies in.
struct Slices {
    start: f32,
    per_length: f32,
}

impl Slices {
    fn bin(&self, center: f32) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and the centre is not before the start"
        )]
        let bin = ((center - self.start) * self.per_length) as usize;
        bin.min(BINS - 1)
    }
}

/// `None` where no axis tells the centres apart.
fn divide_binned(items: &mut [Item]) -> Option<usize> {
    let centers = Bounds::of_points(items.iter().map(Item::center));
    let slices = [0, 1, 2].map(|axis: usize| Slices {
        start: centers.min[axis],
        // Infinite for centres that coincide: 0 · ∞ is NaN, which is in the first slice.
        per_length: BINS as f32 / (centers.max[axis] - centers.min[axis]),
    });
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for item in &*items {
        let center = item.center();
        for axis in 0..3 {
            let bin = &mut bins[axis][slices[axis].bin(center[axis])];
            bin.bounds = bin.bounds.union(item.bounds);
            bin.count += 1;
        }
    }

    let mut best = (f64::INFINITY, None);
    for (axis, bins) in bins.iter().enumerate() {
        let mut after = [Bin::EMPTY; BINS];
        let mut right = Bin::EMPTY;
        for (index, bin) in bins.iter().enumerate().rev() {
            right = right.union(*bin);
            after[index] = right;
        }
        let mut left = Bin::EMPTY;
        for (index, bin) in bins[..BINS - 1].iter().enumerate() {
            left = left.union(*bin);
            let right = &after[index + 1];
            if left.count == 0 || right.count == 0 {
                continue;
            }
            let sum = left.cost() + right.cost();
            if sum < best.0 {
                best = (sum, Some((axis, index)));
            }
        }
    }
    let (axis, last_left) = best.1?;
    Some(partition(items, |item| {
        slices[axis].bin(item.center()[axis]) <= last_left
    }))
}

/// Moves the items for which `is_left` holds to the front; returns how many there are.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for index in 0..items.len() {
        if is_left(&items[index]) {
            items.swap(index, middle);
            middle += 1;
        }
    }
    middle
}
