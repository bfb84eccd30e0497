//! Dividing a large set by objects: each triangle goes to the side its box's centre is on.

use super::item::{Extent, Item};
use super::split::{Split, cost, folded};
use crate::math::Vec4;

/// Divisions are tried between this many slices along each axis.
const BINS: usize = 32;

#[derive(Clone, Copy)]
struct Bin {
    extent: Extent,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self {
        extent: Extent::EMPTY,
        count: 0,
    };

    #[inline]
    fn add(&mut self, other: &Self) {
        self.extent.grow(&other.extent);
        self.count += other.count;
    }
}

/// What lies in each slice, by axis.
type Bins = [[Bin; BINS]; 3];

/// Which slice along each axis a box's centre lies in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slices {
    /// Twice where the first one starts.
    start: Vec4,
    per_length: Vec4,
}

impl Slices {
    fn new(items: &[Item]) -> Self {
        let centers = folded(
            items,
            |items| {
                let mut centers = Extent::EMPTY;
                for item in items {
                    centers.grow_by_point(item.doubled_center());
                }
                centers
            },
            Extent::grow,
        );
        Self {
            start: centers.low,
            // Infinite for centres that coincide: 0 · ∞ is NaN, which is in the first slice.
            per_length: BINS as f32 / (centers.high - centers.low),
        }
    }

    #[inline]
    fn of(&self, item: &Item) -> [usize; 3] {
        // The sum with this is rounded to a whole number, which is in its last bits.
        const WHOLE: f32 = (1 << 23) as f32;
        let position = (item.doubled_center() - self.start) * self.per_length - 0.5;
        let position = position.max(Vec4::ZERO).min(Vec4::splat((BINS - 1) as f32));
        let [x, y, z, _] = (position + WHOLE).to_array();
        [x, y, z].map(|x| x.to_bits() as usize % BINS)
    }
}

/// The cheapest of the divisions between slices; `None` where no axis tells the centres apart.
pub(super) fn cheapest(items: &[Item]) -> Option<(Split, impl Fn(&Item) -> bool + use<>)> {
    let slices = Slices::new(items);
    let bins = folded(
        items,
        |items| {
            let mut bins = [[Bin::EMPTY; BINS]; 3];
            for item in items {
                for (bins, slice) in bins.iter_mut().zip(slices.of(item)) {
                    let bin = &mut bins[slice];
                    bin.extent.grow(item.extent());
                    bin.count += 1;
                }
            }
            bins
        },
        |all: &mut Bins, other| {
            for (all, other) in all.iter_mut().flatten().zip(other.iter().flatten()) {
                all.add(other);
            }
        },
    );

    let mut best: Option<(Split, usize, usize)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut after = [Bin::EMPTY; BINS];
        let mut right = Bin::EMPTY;
        for (index, bin) in bins.iter().enumerate().rev() {
            right.add(bin);
            after[index] = right;
        }
        let mut left = Bin::EMPTY;
        for (index, bin) in bins[..BINS - 1].iter().enumerate() {
            left.add(bin);
            let right = &after[index + 1];
            if left.count == 0 || right.count == 0 {
                continue;
            }
            let cost = cost(&left.extent, left.count) + cost(&right.extent, right.count);
            if best.as_ref().is_none_or(|(best, ..)| cost < best.cost) {
                let sides = [left.extent, right.extent];
                best = Some((Split { cost, sides }, axis, index));
            }
        }
    }
    let (split, axis, last_left) = best?;
    Some((split, move |item: &Item| slices.of(item)[axis] <= last_left))
}
