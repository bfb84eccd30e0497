//! Dividing a small set by objects: every division of the order along each axis is tried. The orders are found once and kept
//! while the set is divided further.

use super::item::{Extent, Item};
use super::split::{Split, cost};
use std::ops::Range;

/// The most items in a set.
pub(super) const LIMIT: usize = 128;

/// Numbers of a set's items, in the order of the boxes' centres along each axis.
pub(super) struct Sorted {
    by_axis: [[u8; LIMIT]; 3],
}

/// A division of a range: its first part is the first `middle` along the axis.
pub(super) struct Sweep {
    pub split: Split,
    axis: usize,
    pub middle: usize,
}

impl Sorted {
    pub fn new(items: &[Item]) -> Self {
        let mut by_axis = [[0; LIMIT]; 3];
        let mut keys = [0; LIMIT];
        let keys = &mut keys[..items.len()];
        for (axis, order) in by_axis.iter_mut().enumerate() {
            for (number, (key, item)) in (0..).zip(keys.iter_mut().zip(items)) {
                *key = u64::from(ordered(item.doubled_center()[axis])) << 32 | number;
            }
            keys.sort_unstable();
            for (place, key) in order.iter_mut().zip(&*keys) {
                *place = key.to_le_bytes()[0];
            }
        }
        Self { by_axis }
    }

    /// The numbers of the items in a range.
    pub fn numbers(&self, range: Range<usize>) -> &[u8] {
        &self.by_axis[0][range]
    }

    /// The cheapest division of a range of at least two along one of `axes`.
    pub fn cheapest(&self, items: &[Item], range: Range<usize>, axes: &[usize]) -> Sweep {
        let count = range.len();
        let mut best = (f32::INFINITY, axes[0], count / 2);
        let mut after = [0.0; LIMIT];
        for &axis in axes {
            let order = &self.by_axis[axis][range.clone()];
            let mut right = Extent::EMPTY;
            for (index, &number) in order.iter().enumerate().skip(1).rev() {
                right.grow(items[usize::from(number)].extent());
                after[index] = cost(&right, count - index);
            }
            let mut left = Extent::EMPTY;
            for (index, &number) in order[..count - 1].iter().enumerate() {
                left.grow(items[usize::from(number)].extent());
                let sum = cost(&left, index + 1) + after[index + 1];
                if sum < best.0 {
                    best = (sum, axis, index + 1);
                }
            }
        }
        let (cost, axis, middle) = best;
        let (left, right) = self.by_axis[axis][range].split_at(middle);
        let around =
            |numbers: &[u8]| Extent::around(numbers.iter().map(|&n| &items[usize::from(n)]));
        let sides = [around(left), around(right)];
        Sweep {
            split: Split { cost, sides },
            axis,
            middle,
        }
    }

    /// Divides a range: the first part is at its beginning along every axis, still in order.
    pub fn divide(&mut self, range: Range<usize>, sweep: &Sweep) {
        let mut is_left = [0; LIMIT];
        for &number in &self.by_axis[sweep.axis][range.clone()][..sweep.middle] {
            is_left[usize::from(number)] = 1;
        }
        for (axis, order) in self.by_axis.iter_mut().enumerate() {
            if axis == sweep.axis {
                continue;
            }
            let order = &mut order[range.clone()];
            let mut others = [0; LIMIT];
            let (mut left, mut right) = (0, 0);
            for index in 0..order.len() {
                let number = order[index];
                order[left] = number;
                others[right] = number;
                left += is_left[usize::from(number)];
                right = index + 1 - left;
            }
            order[left..].copy_from_slice(&others[..right]);
        }
    }
}

/// A number's bits, such that their order is that of the numbers.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if x.is_sign_negative() {
        !bits
    } else {
        bits | 1 << 31
    }
}
