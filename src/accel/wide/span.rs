//! What the rays of a packet can meet together: one test for all of them, by intervals that hold where any of them may be.

use super::node::Node;
use crate::accel::block::TriangleBlock;
use crate::accel::simd::{LaneSet, Simd};
use crate::accel::slabs::may_hold_hits;

/// What the rays of a packet lie between.
pub(super) struct Span<S: Simd> {
    simd: S,
    /// The origin from which boxes are entered soonest, and that from which they are left latest.
    nearest_origin: [f32; 3],
    farthest_origin: [f32; 3],
    /// By axis, the least and the greatest reciprocal of a direction.
    inverse_range: [[f32; 2]; 3],
    /// Which side of a box is entered by: 1 for the upper.
    pub backward: [usize; 3],
}

impl<S: Simd> Span<S> {
    /// The span of rays with these least and greatest coordinates of origins and reciprocals of directions, by axis. `None` where
    /// the reciprocals differ in sign.
    #[inline(always)]
    pub fn new(simd: S, origin_range: [[f32; 2]; 3], inverse_range: [[f32; 2]; 3]) -> Option<Self> {
        let mut nearest_origin = [0.0; 3];
        let mut farthest_origin = [0.0; 3];
        let mut backward = [0; 3];
        for axis in 0..3 {
            let [least, most] = inverse_range[axis];
            if least.is_sign_negative() != most.is_sign_negative() {
                return None;
            }
            backward[axis] = usize::from(least.is_sign_negative());
            let [least, most] = origin_range[axis];
            [nearest_origin[axis], farthest_origin[axis]] = if backward[axis] == 1 {
                [least, most]
            } else {
                [most, least]
            };
        }
        Some(Self {
            simd,
            nearest_origin,
            farthest_origin,
            inverse_range,
            backward,
        })
    }

    /// [`Self::enter`] of a node's boxes.
    #[inline(always)]
    pub fn enter_node(&self, node: &Node, limit: f32) -> (S::F32x8, LaneSet) {
        let simd = self.simd;
        let mut sides = [[simd.splat(0.0); 2]; 3];
        for (axis, planes) in node.planes.iter().enumerate() {
            let backward = self.backward[axis] & 1;
            sides[axis] = [
                simd.load(&planes[backward]),
                simd.load(&planes[1 - backward]),
            ];
        }
        self.enter(&sides, limit)
    }

    /// Which of a block's triangles some rays may meet before `limit`: those whose boxes they may pass.
    #[inline(always)]
    pub fn may_meet(&self, block: &TriangleBlock, limit: f32) -> LaneSet {
        let simd = self.simd;
        let [a, b, c] = block.eight(simd, [0, 1, 2]);
        let mut sides = [[simd.splat(0.0); 2]; 3];
        for axis in 0..3 {
            let lower = simd.smaller(simd.smaller(a[axis], b[axis]), c[axis]);
            let upper = simd.larger(simd.larger(a[axis], b[axis]), c[axis]);
            sides[axis] = if self.backward[axis] == 1 {
                [upper, lower]
            } else {
                [lower, upper]
            };
        }
        let (_, met) = self.enter(&sides, limit);
        met.and(block.occupied(simd))
    }

    /// Where the first ray may enter each box, and which boxes some may pass before `limit`, a distance moved outwards by
    /// [`later`](crate::accel::slabs::later). `sides`: by axis, where boxes are entered and left.
    ///
    /// Rounding is monotonic, so each ray computes nothing outside these intervals.
    #[inline(always)]
    fn enter(&self, sides: &[[S::F32x8; 2]; 3], limit: f32) -> (S::F32x8, LaneSet) {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.splat(limit);
        for (axis, &[nearer, farther]) in sides.iter().enumerate() {
            let [least, most] = self.inverse_range[axis];
            let (least, most) = (simd.splat(least), simd.splat(most));
            let nearer = simd.sub(nearer, simd.splat(self.nearest_origin[axis]));
            let farther = simd.sub(farther, simd.splat(self.farthest_origin[axis]));
            let soonest = simd.smaller(simd.mul(nearer, least), simd.mul(nearer, most));
            let latest = simd.larger(simd.mul(farther, least), simd.mul(farther, most));
            start = simd.larger(soonest, start);
            end = simd.smaller(latest, end);
        }
        (start, may_hold_hits(simd, start, end))
    }
}
