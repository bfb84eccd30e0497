//! The walk for a packet of rays.
//!
//! Nodes are tested once for all rays, by intervals that hold where any of them may be; of the boxes that are left, one at a
//! time is tested with all rays side by side, and only those that meet it go on to what is inside.

use super::WideTree;
use super::node::{ChildKind, Node};
use super::stack::{Stack, Waiting};
use crate::accel::leaf::{Nearest, Visitor};
use crate::accel::packet::{Packet, PacketHits};
use crate::accel::query::NearestHit;
use crate::accel::simd::{LANES, LaneSet, Lanes, Query, Simd};
use crate::accel::slabs::{are_ordinary, later, may_hold_hits};
use crate::math::Vec3;

/// Fewer rays walk by themselves.
const FEWEST_RAYS: usize = 4;

/// The nearest hit of each ray.
pub(super) struct NearestHits<'a> {
    pub tree: &'a WideTree,
    pub packet: &'a Packet<'a>,
}

impl Query for NearestHits<'_> {
    type Answer = PacketHits;

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> PacketHits {
        let Self { tree, packet } = *self;
        let rays = packet.rays();
        let mut hits = [None; Packet::MOST_RAYS];
        if rays.len() >= FEWEST_RAYS
            && let Some(mut walk) = PacketWalk::new(simd, tree, packet)
        {
            let (first, t_max) = &rays[0];
            let mut nearest = [Nearest::new(simd, first, *t_max); Packet::MOST_RAYS];
            for ((ray, t_max), nearest) in rays.iter().zip(&mut nearest) {
                *nearest = Nearest::new(simd, ray, *t_max);
            }
            walk.run(&mut nearest[..rays.len()]);
            for (hit, nearest) in hits.iter_mut().zip(&nearest[..rays.len()]) {
                *hit = nearest.best;
            }
            return hits;
        }
        for ((ray, t_max), hit) in rays.iter().zip(&mut hits) {
            let t_max = *t_max;
            *hit = NearestHit { tree, ray, t_max }.answer(simd);
        }
        hits
    }
}

/// Two times eight numbers, one per ray.
type PerRay = [Lanes; Packet::MOST_RAYS / LANES];

/// What the rays of a packet lie between.
struct Ranges {
    least_origin: Vec3,
    most_origin: Vec3,
    /// Of the reciprocals of the directions.
    least_inverse: Vec3,
    most_inverse: Vec3,
    /// Along which axes all rays go backward: 1 for those.
    backward: [usize; 3],
}

impl Ranges {
    /// `None` where the rays differ in the sign of a direction, or are out of the ordinary.
    #[inline(always)]
    fn of(packet: &Packet<'_>) -> Option<Self> {
        let mut ranges = Self {
            least_origin: Vec3::INFINITY,
            most_origin: Vec3::NEG_INFINITY,
            least_inverse: Vec3::INFINITY,
            most_inverse: Vec3::NEG_INFINITY,
            backward: [0; 3],
        };
        for (ray, _) in packet.rays() {
            if !are_ordinary(ray.direction) {
                return None;
            }
            let inverse = ray.direction.recip();
            ranges.least_origin = ranges.least_origin.min(ray.origin);
            ranges.most_origin = ranges.most_origin.max(ray.origin);
            ranges.least_inverse = ranges.least_inverse.min(inverse);
            ranges.most_inverse = ranges.most_inverse.max(inverse);
        }
        for axis in 0..3 {
            let [least, most] = [ranges.least_inverse[axis], ranges.most_inverse[axis]];
            if least.is_sign_negative() != most.is_sign_negative() {
                return None;
            }
            ranges.backward[axis] = usize::from(least.is_sign_negative());
        }
        Some(ranges)
    }
}

/// The rays of a packet side by side, and intervals that hold all of them.
struct PacketWalk<'a, S: Simd> {
    simd: S,
    tree: &'a WideTree,
    /// By axis.
    origins: [PerRay; 3],
    /// By axis, reciprocals of the directions.
    inverses: [PerRay; 3],
    /// Where each ray ends so far, moved outwards; before its start where there is no ray.
    limits: PerRay,
    /// The origin from which boxes are entered soonest, and that from which they are left latest.
    nearest_origin: [f32; 3],
    farthest_origin: [f32; 3],
    /// The least and greatest reciprocal.
    inverse_range: [[f32; 2]; 3],
    /// Which side of a box is entered by: 1 for the upper.
    backward: [usize; 3],
}

impl<'a, S: Simd> PacketWalk<'a, S> {
    /// `None` where the rays differ in the sign of a direction, or are out of the ordinary.
    #[inline(always)]
    fn new(simd: S, tree: &'a WideTree, packet: &Packet<'_>) -> Option<Self> {
        let rays = packet.rays();
        let Ranges {
            least_origin,
            most_origin,
            least_inverse,
            most_inverse,
            backward,
        } = Ranges::of(packet)?;
        let farthest = least_origin.abs().max(most_origin.abs());
        if !(farthest.element_sum() + tree.reach).is_finite() {
            return None;
        }
        let mut origins = [[Lanes([0.0; LANES]); 2]; 3];
        let mut inverses = [[Lanes([1.0; LANES]); 2]; 3];
        let mut limits = [Lanes([-1.0; LANES]); 2];
        for (index, (ray, t_max)) in rays.iter().enumerate() {
            let (half, lane) = (index / LANES, index % LANES);
            let (origin, inverse) = (ray.origin.to_array(), ray.direction.recip().to_array());
            for axis in 0..3 {
                origins[axis][half].0[lane] = origin[axis];
                inverses[axis][half].0[lane] = inverse[axis];
            }
            limits[half].0[lane] = later(*t_max);
        }
        let (least_origin, most_origin) = (least_origin.to_array(), most_origin.to_array());
        let mut nearest_origin = most_origin;
        let mut farthest_origin = least_origin;
        for axis in 0..3 {
            if backward[axis] == 1 {
                nearest_origin[axis] = least_origin[axis];
                farthest_origin[axis] = most_origin[axis];
            }
        }
        let (least, most) = (least_inverse.to_array(), most_inverse.to_array());
        Some(Self {
            simd,
            tree,
            origins,
            inverses,
            limits,
            nearest_origin,
            farthest_origin,
            inverse_range: [
                [least[0], most[0]],
                [least[1], most[1]],
                [least[2], most[2]],
            ],
            backward,
        })
    }

    #[inline(always)]
    fn run(&mut self, nearest: &mut [Nearest<'_, S>]) {
        let tree = self.tree;
        let mut limit = self.last_limit();
        let mut waiting = Stack::new();
        let mut node = match tree.root.kind() {
            ChildKind::Node(index) => index,
            ChildKind::Leaf(blocks) => {
                for nearest in nearest {
                    nearest.visit(&tree.blocks[blocks.clone()]);
                }
                return;
            }
        };
        loop {
            let first = waiting.make_room();
            let (enter, passed) = self.enter(&tree.nodes[node], limit);
            let enter = self.simd.store(enter).0;
            for lane in passed {
                let place = node * LANES + lane;
                #[expect(clippy::cast_possible_truncation, reason = "less than 2^32 lanes")]
                let waiting_lane = Waiting::new(enter[lane], place as u32);
                waiting.push::<Nearest<'_, S>>(first, waiting_lane);
            }
            node = loop {
                let Some(next) = waiting.pop::<Nearest<'_, S>>(limit) else {
                    return;
                };
                let place = next.what() as usize;
                let (parent, lane) = (&tree.nodes[place / LANES], place % LANES);
                let meeting = self.meeting(parent, lane);
                if meeting.is_empty() {
                    continue;
                }
                match parent.children[lane].kind() {
                    ChildKind::Node(index) => break index,
                    ChildKind::Leaf(blocks) => {
                        let blocks = &tree.blocks[blocks];
                        for ray in meeting {
                            if let Some(t) = nearest[ray].visit(blocks) {
                                self.limits[ray / LANES].0[ray % LANES] = later(t);
                            }
                        }
                        limit = self.last_limit();
                    }
                }
            };
        }
    }

    /// The greatest of the rays' limits.
    #[inline(always)]
    fn last_limit(&self) -> f32 {
        let simd = self.simd;
        let halves = [simd.load(&self.limits[0]), simd.load(&self.limits[1])];
        let mut last = 0.0;
        for limit in simd.store(simd.larger(halves[0], halves[1])).0 {
            if limit > last {
                last = limit;
            }
        }
        last
    }

    /// Where the first ray may enter each box, and which boxes some may pass before `limit`. Rounding is monotonic, so each ray
    /// computes nothing outside these intervals.
    #[inline(always)]
    fn enter(&self, node: &Node, limit: f32) -> (S::F32x8, LaneSet) {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.splat(limit);
        for axis in 0..3 {
            let planes = &node.planes[axis];
            let backward = self.backward[axis] & 1;
            let [least, most] = self.inverse_range[axis];
            let (least, most) = (simd.splat(least), simd.splat(most));
            let nearer = simd.sub(
                simd.load(&planes[backward]),
                simd.splat(self.nearest_origin[axis]),
            );
            let farther = simd.sub(
                simd.load(&planes[1 - backward]),
                simd.splat(self.farthest_origin[axis]),
            );
            let soonest = simd.smaller(simd.mul(nearer, least), simd.mul(nearer, most));
            let latest = simd.larger(simd.mul(farther, least), simd.mul(farther, most));
            start = simd.larger(soonest, start);
            end = simd.smaller(latest, end);
        }
        (start, may_hold_hits(simd, start, end))
    }

    /// Which rays meet the box in a lane of a node before their limits: what a ray by itself would say of it.
    #[inline(always)]
    fn meeting(&self, node: &Node, lane: usize) -> LaneSet {
        let lower = self.meeting_half(node, lane, 0);
        lower.or(self.meeting_half(node, lane, 1).beyond(LANES))
    }

    #[inline(always)]
    fn meeting_half(&self, node: &Node, lane: usize, half: usize) -> LaneSet {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.load(&self.limits[half]);
        for axis in 0..3 {
            let planes = &node.planes[axis];
            let backward = self.backward[axis] & 1;
            let origin = simd.load(&self.origins[axis][half]);
            let inverse = simd.load(&self.inverses[axis][half]);
            let nearer = simd.sub(simd.splat(planes[backward].0[lane]), origin);
            let farther = simd.sub(simd.splat(planes[1 - backward].0[lane]), origin);
            start = simd.larger(simd.mul(nearer, inverse), start);
            end = simd.smaller(simd.mul(farther, inverse), end);
        }
        may_hold_hits(simd, start, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::packet::tests::packet_rays;
    use crate::accel::simd::{self, Portable};
    use crate::accel::tests::{rays, scenes, wide_tree};
    use crate::geometry::shapes::Random;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        let mut random = Random::new(5);
        for (name, triangles) in scenes() {
            let tree = &wide_tree(&triangles);
            for ray in rays(&triangles, 17).iter().step_by(20) {
                let rays = packet_rays(&mut random, 1, ray);
                let packet = &Packet::new(&rays);
                let query = NearestHits { tree, packet };
                assert_eq!(
                    simd::answer(&query),
                    query.answer(Portable),
                    "{name}: {packet:?}"
                );
            }
        }
    }
}
