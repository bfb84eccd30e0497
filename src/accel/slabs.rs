//! Bounds on distances along rays, moved outwards so that rounding loses no hit.

use super::simd::{Floats, LaneSet};
use crate::math::Vec3;
use crate::math::robust::gamma;

/// By how much the distances to a box's planes are moved outwards, relative to themselves, so that rounding loses no hit.
///
/// A computed distance is a difference, a reciprocal and a product, so it is off by a factor of at most 1 ± γ₃, and the
/// reciprocal is rounded once more when the margin goes into it. Two bounds that are compared each carry that, and a hit's
/// own distance one rounding.
/// Source: Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013; twice his margin.
pub(super) const MARGIN: f32 = 4.0 * gamma(3);

/// A bound on distances that no hit at `t` or before it comes after. The smallest normal number stands in for digits lost
/// below it.
#[inline]
pub(super) fn later(t: f32) -> f32 {
    t * (1.0 + MARGIN) + f32::MIN_POSITIVE
}

/// Where a stretch that begins at `start` and ends at `end`, both as rounded, may hold a hit: where the end, moved by the margin
/// for both, is not before the start. Nowhere NaN.
///
/// A distance below 0 is moved in the wrong direction, but its sign is right, and no more is asked of it.
#[inline(always)]
pub(super) fn may_hold_hits<R, S: Floats<R>>(simd: S, start: R, end: R) -> LaneSet {
    // The products may have lost digits below the smallest normal number.
    let end = simd.mul_add(end, simd.splat(1.0 + MARGIN), simd.splat(f32::MIN_POSITIVE));
    simd.less_or_equal(start, end)
}

/// [`reciprocal`] of each number.
#[inline]
pub(super) fn reciprocals(direction: Vec3) -> [f32; 3] {
    if are_ordinary(direction) {
        direction.recip().to_array()
    } else {
        direction.to_array().map(reciprocal)
    }
}

/// Whether all numbers are so far within the range of `f32` that nothing can go wrong with their reciprocals.
#[inline]
pub(super) fn are_ordinary(direction: Vec3) -> bool {
    let [x, y, z] = direction.abs().to_array();
    let [least, most] = ORDINARY;
    x >= least && y >= least && z >= least && x <= most && y <= most && z <= most
}

/// Which of the numbers are ordinary, as in [`are_ordinary`].
#[inline(always)]
pub(super) fn ordinary<R: Copy, S: Floats<R>>(simd: S, numbers: R) -> LaneSet {
    let [least, most] = ORDINARY;
    let size = simd.abs(numbers);
    let large = simd.less_or_equal(simd.splat(least), size);
    large.and(simd.less_or_equal(size, simd.splat(most)))
}

/// The least and the greatest magnitude of [`are_ordinary`].
const ORDINARY: [f32; 2] = [1e-30, 1e30];

/// `1 / d`; infinite for zeros. NaN, which bounds nothing, where the result would lack digits or have no room for the margin.
#[cold]
pub(super) fn reciprocal(d: f32) -> f32 {
    let inverse = d.recip();
    let has_room = (inverse * 0.5).is_normal() && (inverse * 2.0).is_normal();
    if has_room || d == 0.0 {
        inverse
    } else {
        f32::NAN
    }
}
