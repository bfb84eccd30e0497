//! Where to divide a set in two, and doing so.

use super::build::Job;
use super::item::{Extent, Item};
use super::{bins, spatial};
use crate::accel::simd::LANES;
use crate::control::CancelToken;
use rayon::prelude::*;

/// Items handled at a time by one thread, and between two looks at the cancel token.
pub(super) const CHUNK: usize = 1 << 14;

/// The least share of the set's box, along every axis, that the two halves of the best division by objects must have in common before a
/// division of space is tried.
const SHARE_FROM: f32 = 0.02;

/// What that share, times the number of item boxes that a ray through the set's box is expected to meet, must exceed as well. Such a ray
/// meets about 2 boxes on smooth meshes, hundreds in soups.
const SHARE_OF_BOXES_FROM: f32 = 1.0;

/// A division of a set, and what the surface area heuristic expects of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    /// In half areas times blocks.
    pub cost: f32,
    /// The boxes of both parts.
    pub sides: [Extent; 2],
}

impl Split {
    /// Whether dividing space may be better: where the boxes of both parts have much in common, and a ray through the set meets the boxes
    /// of many items.
    pub fn overlaps<'a>(&self, whole: &Extent, items: impl Iterator<Item = &'a Item>) -> bool {
        let [left, right] = &self.sides;
        let shared = left.intersection(right);
        let shares = (shared.high - shared.low) / (whole.high - whole.low);
        // NaN along an axis across which all is flat.
        let share = shares.truncate().to_array().into_iter().fold(1.0, f32::min);
        if share < SHARE_FROM {
            return false;
        }
        let areas: f32 = items.map(|item| item.extent().half_area()).sum();
        share * areas > SHARE_OF_BOXES_FROM * whole.half_area()
    }
}

/// What a set of `count` items in `extent` costs by the heuristic, up to a factor: blocks are tested as a whole.
#[inline]
pub(super) fn cost(extent: &Extent, count: usize) -> f32 {
    extent.half_area() * count.div_ceil(LANES) as f32
}

/// Folds large sets in parallel, always in the same order; not all of them when cancelled.
pub(super) fn folded<T: Send>(
    cancel: &CancelToken,
    items: &[Item],
    fold: impl Fn(&[Item]) -> T + Send + Sync,
    join: impl Fn(&mut T, &T),
) -> T {
    if items.len() <= CHUNK {
        return fold(items);
    }
    let parts = items.par_chunks(CHUNK).map(|items| {
        let is_wanted = !cancel.is_cancelled();
        fold(if is_wanted { items } else { &[] })
    });
    let parts: Vec<T> = parts.collect();
    let mut parts = parts.into_iter();
    let mut all = parts.next().expect("there are items");
    parts.for_each(|part| join(&mut all, &part));
    all
}

/// A set that was divided: where its second part begins, both boxes, and how many items came to it.
pub(super) struct Divided {
    pub middle: usize,
    pub sides: [Extent; 2],
    pub added: usize,
}

/// Divides the items from `start` on; cutting may add `spare` items.
pub(super) fn divide(
    job: &Job,
    items: &mut Vec<Item>,
    start: usize,
    extent: &Extent,
    spare: usize,
) -> Divided {
    let set = &mut items[start..];
    let Some((split, is_left)) = bins::cheapest(job, set) else {
        return halved(job, set, start, extent);
    };
    if spare > 0 && split.overlaps(extent, set.iter()) {
        let plane = spatial::cheapest(job, set, extent, spare, split.cost);
        if let Some(divided) = plane.and_then(|plane| plane.divide(job, items, start, spare)) {
            return divided;
        }
    }
    Divided {
        middle: start + partition(job.cancel, &mut items[start..], is_left),
        sides: split.sides,
        added: 0,
    }
}

/// Divides a set into two equally large ones, by the boxes' centres along the set's longest side.
pub(super) fn halved(job: &Job, set: &mut [Item], start: usize, extent: &Extent) -> Divided {
    let middle = set.len() / 2;
    if job.cancel.is_cancelled() {
        return Divided {
            middle: start + middle,
            sides: [*extent; 2],
            added: 0,
        };
    }
    let axis = extent.bounds().size().max_position();
    set.select_nth_unstable_by(middle, |a, b| {
        let [a_center, b_center] = [a, b].map(|item| item.doubled_center()[axis]);
        a_center
            .total_cmp(&b_center)
            .then(a.triangle().cmp(&b.triangle()))
    });
    let (left, right) = set.split_at(middle);
    Divided {
        middle: start + middle,
        sides: [Extent::around(left), Extent::around(right)],
        added: 0,
    }
}

/// Moves the items for which `is_left` holds to the front; returns how many there are. Half of all when cancelled.
fn partition(cancel: &CancelToken, items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for index in 0..items.len() {
        if index % CHUNK == 0 && cancel.is_cancelled() {
            return items.len() / 2;
        }
        // Without a branch, which could not be foreseen.
        let goes_left = is_left(&items[index]);
        items.swap(index, middle);
        middle += usize::from(goes_left);
    }
    middle
}
