//! Nodes as they lie in memory, and the test of a ray against the eight boxes of one.

use crate::accel::simd::{LANES, LaneSet, Lanes, Simd, splat_all};
use crate::accel::slabs::{may_hold_hits, reciprocals};
use crate::math::{Bounds, Ray};
use std::ops::Range;

/// Children per node.
pub(super) const WIDTH: usize = LANES;

/// The boxes of up to eight children, stored by axis, side and lane.
///
/// Lanes without a child hold a box that is entered at +∞ and left at −∞, and [`Child::NONE`] for rays that miss no box.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    /// By axis, then the lower and the upper sides.
    pub planes: [[Lanes; 2]; 3],
    pub children: [Child; WIDTH],
}

impl Node {
    /// A node without children.
    pub const EMPTY: Self = Self {
        planes: [[
            Lanes([f32::INFINITY; WIDTH]),
            Lanes([f32::NEG_INFINITY; WIDTH]),
        ]; 3],
        children: [Child::NONE; WIDTH],
    };

    /// Sets the child in `lane`.
    pub fn set(&mut self, lane: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0].0[lane] = bounds.min[axis];
            self.planes[axis][1].0[lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    /// The box in `lane`.
    pub fn bounds(&self, lane: usize) -> Bounds {
        let corner = |side: usize| [0, 1, 2].map(|axis: usize| self.planes[axis][side].0[lane]);
        Bounds {
            min: corner(0).into(),
            max: corner(1).into(),
        }
    }
}

/// What a lane of a node leads to, in four bytes: a node's index, or a flag, the number of blocks in two bits and the index
/// of the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

/// A [`Child`] unpacked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ChildKind {
    Node(usize),
    /// Blocks of triangles.
    Leaf(Range<usize>),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_SHIFT: u32 = 29;

    /// A leaf without triangles.
    pub const NONE: Self = Self(Self::LEAF);

    pub fn node(index: usize) -> Self {
        let index = u32::try_from(index).ok().filter(|i| i & Self::LEAF == 0);
        Self(index.expect("less nodes than triangles"))
    }

    /// A leaf of one to three blocks.
    pub fn leaf(blocks: &Range<usize>) -> Self {
        let first = u32::try_from(blocks.start)
            .ok()
            .filter(|first| first >> Self::COUNT_SHIFT == 0)
            .expect("no more blocks than triangles");
        let count = u32::try_from(blocks.len()).expect("leaves are small");
        assert!(count < 4, "leaves are small");
        Self(Self::LEAF | count << Self::COUNT_SHIFT | first)
    }

    #[inline]
    pub fn kind(self) -> ChildKind {
        if self.0 & Self::LEAF == 0 {
            return ChildKind::Node(self.0 as usize);
        }
        let first = (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize;
        let count = (self.0 >> Self::COUNT_SHIFT & 3) as usize;
        ChildKind::Leaf(first..first + count)
    }

    /// The bits, for packing into a larger number.
    #[inline]
    pub fn to_bits(self) -> u32 {
        self.0
    }

    /// The inverse of [`Self::to_bits`].
    #[inline]
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// A ray prepared for tests against the boxes of many nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySlabs<S: Simd> {
    simd: S,
    origin: [S::F32x8; 3],
    /// Reciprocals of the direction.
    inverse: [S::F32x8; 3],
    /// Which side of a box is entered by: 1 for the upper.
    backward: [usize; 3],
}

impl<S: Simd> RaySlabs<S> {
    /// For boxes whose coordinates are at most `reach` in magnitude.
    #[inline(always)]
    pub fn new(simd: S, ray: &Ray, reach: f32) -> Self {
        let direction = ray.direction.to_array();
        // Where the difference between a plane and the origin may overflow, no distance can be trusted.
        let [x, y, z] = ray.origin.abs().to_array();
        let fits = (x + y + z + reach).is_finite();
        let inverse = if fits {
            reciprocals(ray.direction)
        } else {
            [f32::NAN; 3]
        };
        Self {
            simd,
            origin: splat_all(simd, ray.origin.to_array()),
            inverse: splat_all(simd, inverse),
            backward: direction.map(|d| usize::from(d.is_sign_negative())),
        }
    }

    /// Where the ray enters each box, as rounded, not before its start, and which boxes it may pass before `limit`, a distance
    /// moved outwards by [`later`](crate::accel::slabs::later).
    ///
    /// NaN, from a ray within a plane (0 · ∞) or from [`reciprocals`], bounds nothing.
    #[inline(always)]
    pub fn enter(&self, node: &Node, limit: f32) -> (S::F32x8, LaneSet) {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.splat(limit);
        for axis in 0..3 {
            let planes = &node.planes[axis];
            let backward = self.backward[axis] & 1;
            let nearer = simd.sub(simd.load(&planes[backward]), self.origin[axis]);
            let farther = simd.sub(simd.load(&planes[1 - backward]), self.origin[axis]);
            start = simd.larger(simd.mul(nearer, self.inverse[axis]), start);
            end = simd.smaller(simd.mul(farther, self.inverse[axis]), end);
        }
        (start, may_hold_hits(simd, start, end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_survive_packing() {
        assert_eq!(size_of::<Node>(), 256);
        for index in [0, 1, (1 << 29) - 1] {
            assert_eq!(Child::node(index).kind(), ChildKind::Node(index));
            for count in 1..=3 {
                let blocks = index..index + count;
                assert_eq!(Child::leaf(&blocks).kind(), ChildKind::Leaf(blocks));
            }
        }
        assert_eq!(Child::NONE.kind(), ChildKind::Leaf(0..0));
    }
}
