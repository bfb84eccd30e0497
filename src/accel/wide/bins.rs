//! Dividing a large set by objects: each triangle goes to the side its box's centre is on.

use super::binning::{self, Bin};
use super::build::Job;
use super::item::{Extent, Item};
use super::split::{Split, cost, folded};
use crate::math::Vec4;

/// Divisions are tried between this many slices along each axis.
const BINS: usize = 32;

/// Items whose boxes' centres are in a slice.
#[derive(Clone, Copy)]
struct Centered {
    extent: Extent,
    count: usize,
}

impl Bin for Centered {
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

/// Which slice along each axis a box's centre lies in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slices {
    /// Twice where the first slice starts, by axis.
    start: Vec4,
    per_length: Vec4,
    /// The axes along which divisions are tried.
    axes: &'static [usize],
}

impl Slices {
    fn new(job: &Job, items: &[Item]) -> Self {
        let centers = folded(
            job.cancel,
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
        let size = centers.high - centers.low;
        Self {
            start: centers.low,
            // Infinite for centres that coincide: 0 · ∞ is NaN, which is in the first slice.
            per_length: BINS as f32 / size,
            axes: job.quality.axes(size.truncate()),
        }
    }

    #[inline]
    fn of(&self, item: &Item) -> [usize; 3] {
        let position = (item.doubled_center() - self.start) * self.per_length - 0.5;
        let position = position.max(Vec4::ZERO).min(Vec4::splat((BINS - 1) as f32));
        let [x, y, z, _] = (position + WHOLE).to_array();
        [x, y, z].map(|x| x.to_bits() as usize % BINS)
    }

    /// Whether a box's centre lies in the slices up to `last`, by the same arithmetic.
    #[inline]
    fn is_up_to(&self, axis: usize, last: f32, item: &Item) -> bool {
        let Extent { low, high } = item.extent();
        let center = low[axis] + high[axis];
        let position = (center - self.start[axis]) * self.per_length[axis] - 0.5;
        position.max(0.0) + WHOLE <= last + WHOLE
    }
}

/// The sum with this is rounded to a whole number, which is in its last bits.
const WHOLE: f32 = (1 << 23) as f32;

/// The cheapest of the divisions between slices; `None` where no axis tells the centres apart.
pub(super) fn cheapest(
    job: &Job,
    items: &[Item],
) -> Option<(Split, impl Fn(&Item) -> bool + use<>)> {
    let slices = Slices::new(job, items);
    let bins = binning::filled(job, items, |items| {
        let mut bins = [[Centered::EMPTY; BINS]; 3];
        for item in items {
            let slice_of = slices.of(item);
            for &axis in slices.axes {
                let bin = &mut bins[axis][slice_of[axis]];
                bin.extent.grow(item.extent());
                bin.count += 1;
            }
        }
        bins
    });

    let mut best: Option<(Split, usize, usize)> = None;
    for &axis in slices.axes {
        for (index, (left, right)) in binning::sides(&bins[axis]).enumerate() {
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
    let last_left = last_left as f32;
    let is_left = move |item: &Item| slices.is_up_to(axis, last_left, item);
    Some((split, is_left))
}
