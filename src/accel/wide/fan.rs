//! The walk for a whole fan of rays.
//!
//! Nodes are tested once for all rays, by what any of them can meet; of the boxes that are left, one at a time is tested with
//! all rays side by side, and only those that meet it go on to what is inside.

use super::WideTree;
use super::node::{ChildKind, Node};
use super::stack::{Stack, Waiting};
use crate::accel::block::{BlockFilter, TriangleBlock};
use crate::accel::fan::{Fan, FanCull};
use crate::accel::leaf::{Any, LeafTest};
use crate::accel::query::AnyHit;
use crate::accel::simd::{LANES, LaneSet, Lanes, Query, Simd};
use crate::accel::slabs::{are_ordinary, later, may_hold_hits};
use crate::geometry::RayKernel;

/// Fewer rays walk by themselves.
const FEWEST_RAYS: u32 = 3;

/// Which rays of a fan are occluded, as bits.
pub(super) struct FanHits<'a> {
    pub tree: &'a WideTree,
    pub fan: &'a Fan<'a>,
}

impl Query for FanHits<'_> {
    type Answer = u64;

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> u64 {
        let Self { tree, fan } = *self;
        let rising = fan.rising();
        let mut occluded = 0;
        let mut alone = rising;
        if rising.count_ones() >= FEWEST_RAYS
            && let Some(mut walk) = FanWalk::new(simd, tree, fan, rising)
        {
            occluded = walk.run();
            alone = 0;
        }
        alone |= !rising;
        for (index, ray) in fan.rays().enumerate() {
            if alone >> index & 1 != 0 {
                let t_max = 1.0;
                let ray = &ray;
                let is_hit = AnyHit { tree, ray, t_max }.answer(simd);
                occluded |= u64::from(is_hit) << index;
            }
        }
        occluded
    }
}

/// What the filter of triangles needs of a ray of a fan beside the origin.
#[derive(Clone, Copy)]
struct Shear {
    /// In few bytes, as room for the most rays is cleared for every fan.
    axes: [u8; 3],
    unshear: [f32; 2],
}

const GROUPS: usize = Fan::MOST_RAYS / LANES;

/// The rising rays of a fan side by side.
struct FanWalk<'a, S: Simd> {
    simd: S,
    tree: &'a WideTree,
    cull: FanCull<S>,
    fan: &'a Fan<'a>,
    /// Rays that nothing is known to be in the way of, as bits.
    free: u64,
    /// How many groups of lanes hold rays.
    groups: usize,
    /// By axis, reciprocals of the directions, NaN where they bound nothing.
    inverses: [[Lanes; GROUPS]; 3],
    shears: [Shear; Fan::MOST_RAYS],
}

impl<'a, S: Simd> FanWalk<'a, S> {
    /// `None` where differences between coordinates may overflow.
    #[inline(always)]
    fn new(simd: S, tree: &'a WideTree, fan: &'a Fan<'a>, rising: u64) -> Option<Self> {
        let cull = FanCull::new(simd, fan, rising, tree.reach)?;
        let mut inverses = [[Lanes([f32::NAN; LANES]); GROUPS]; 3];
        let no_shear = Shear {
            axes: [0; 3],
            unshear: [0.0; 2],
        };
        let mut shears = [no_shear; Fan::MOST_RAYS];
        for (index, ray) in fan.rays().enumerate() {
            let axes = RayKernel::axes_of(&ray);
            let [x, y, z] = axes;
            #[expect(clippy::cast_possible_truncation, reason = "0, 1 or 2")]
            let short = [x as u8, y as u8, z as u8];
            shears[index] = Shear {
                axes: short,
                unshear: BlockFilter::<S>::unshear_of(&ray, axes),
            };
            if are_ordinary(ray.direction) {
                let inverse = ray.direction.recip().to_array();
                for axis in 0..3 {
                    inverses[axis][index / LANES].0[index % LANES] = inverse[axis];
                }
            }
        }
        Some(Self {
            simd,
            tree,
            cull,
            fan,
            free: rising,
            groups: fan.rays().len().div_ceil(LANES).min(GROUPS),
            inverses,
            shears,
        })
    }

    /// Which rays are occluded, as bits.
    #[inline(always)]
    fn run(&mut self) -> u64 {
        let tree = self.tree;
        let rising = self.free;
        let mut waiting = Stack::new();
        let mut node = match tree.root.kind() {
            ChildKind::Node(index) => index,
            ChildKind::Leaf(blocks) => {
                self.visit(rising, &tree.blocks[blocks]);
                return rising & !self.free;
            }
        };
        loop {
            waiting.make_room();
            for lane in self.cull.may_meet(&tree.nodes[node].planes) {
                let place = node * LANES + lane;
                #[expect(clippy::cast_possible_truncation, reason = "less than 2^32 lanes")]
                waiting.push::<Any<'_, S>>(0, Waiting::new(0.0, place as u32));
            }
            node = loop {
                let Some(next) = waiting.pop::<Any<'_, S>>(f32::INFINITY) else {
                    return rising & !self.free;
                };
                let place = next.what() as usize;
                let (parent, lane) = (&tree.nodes[place / LANES], place % LANES);
                let meeting = self.meeting(parent, lane);
                if meeting == 0 {
                    continue;
                }
                match parent.children[lane].kind() {
                    ChildKind::Node(index) => break index,
                    ChildKind::Leaf(blocks) => {
                        self.visit(meeting, &tree.blocks[blocks]);
                        if self.free == 0 {
                            return rising;
                        }
                    }
                }
            };
        }
    }

    /// Which of the free rays meet the box in a lane of a node.
    #[inline(always)]
    fn meeting(&self, node: &Node, lane: usize) -> u64 {
        let simd = self.simd;
        let origin = self.fan.origin().to_array();
        let mut offsets = [[0.0; 2]; 3];
        for (axis, [lower, upper]) in offsets.iter_mut().enumerate() {
            *lower = node.planes[axis][0].0[lane] - origin[axis];
            *upper = node.planes[axis][1].0[lane] - origin[axis];
        }
        let mut meeting = 0;
        for group in 0..self.groups {
            let free = self.free >> (group * LANES) & ((1 << LANES) - 1);
            if free == 0 {
                continue;
            }
            let mut start = simd.splat(0.0);
            let mut end = simd.splat(later(1.0));
            for (offsets, inverses) in offsets.iter().zip(&self.inverses) {
                let inverse = simd.load(&inverses[group]);
                let lower = simd.mul(simd.splat(offsets[0]), inverse);
                let upper = simd.mul(simd.splat(offsets[1]), inverse);
                start = simd.larger(simd.smaller(lower, upper), start);
                end = simd.smaller(simd.larger(lower, upper), end);
            }
            meeting |= may_hold_hits(simd, start, end).bits() << (group * LANES);
        }
        meeting & self.free
    }

    /// Looks for what is in the way of these rays.
    #[inline(always)]
    fn visit(&mut self, rays: u64, blocks: &[TriangleBlock]) {
        for block in blocks {
            let lanes = self.cull.may_meet_triangles(block);
            if lanes.is_empty() {
                continue;
            }
            let mut left = rays & self.free;
            while left != 0 {
                let index = left.trailing_zeros() as usize;
                left &= left - 1;
                if self.is_hit(index, block, lanes) {
                    self.free &= !(1 << index);
                }
            }
        }
    }

    #[inline(always)]
    fn is_hit(&self, index: usize, block: &TriangleBlock, lanes: LaneSet) -> bool {
        let Shear { axes, unshear } = self.shears[index];
        let [x, y, z] = axes;
        let axes = [usize::from(x), usize::from(y), usize::from(z)];
        let ray = self.fan.ray(index);
        let filter = BlockFilter::with_shear(self.simd, &ray, axes, unshear);
        let lanes = filter.may_hit(block, later(1.0)).and(lanes);
        !lanes.is_empty()
            && LeafTest::with_filter(self.simd, &ray, 1.0, filter).is_hit(block, lanes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd;
    use crate::accel::tests::{rays, scenes, wide_tree};
    use crate::math::Vec3;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        for (name, triangles) in scenes() {
            let tree = &wide_tree(&triangles);
            for rays in rays(&triangles, 13).chunks(20) {
                let directions: Vec<_> = rays.iter().map(|ray| ray.direction).collect();
                let normal: Vec3 = directions.iter().sum();
                let fan = &Fan::new(rays[0].origin, normal, &directions);
                let query = FanHits { tree, fan };
                let answers = simd::answers(&query);
                for answer in &answers[1..] {
                    assert_eq!(*answer, answers[0], "{name}: {fan:?}");
                }
            }
        }
    }
}
