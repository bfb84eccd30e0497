//! The walk for a whole fan of rays.

use super::WideTree;
use super::node::{Child, ChildKind, WIDTH};
use crate::accel::block::TriangleBlock;
use crate::accel::fan::{Fan, FanCull};
use crate::accel::leaf::{Any, LeafTest, Visitor};
use crate::accel::query::Tree;
use crate::accel::simd::{LaneSet, Query, Simd};
use crate::math::Ray;

/// The most blocks that each ray of a fan is tested with. Where more are in reach, every ray walks the tree by itself.
const MOST_BLOCKS: usize = 12;

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
        let mut cull = None;
        if rising.count_ones() >= FEWEST_RAYS {
            cull = FanCull::new(simd, fan, rising, tree.reach);
        }
        let mut reached = Reached::new();
        let is_complete = match &cull {
            Some(cull) => reached.collect(tree, cull),
            None => false,
        };
        let mut occluded = 0;
        for (index, ray) in (0..).zip(fan.rays()) {
            let is_hit = match &cull {
                Some(cull) if rising >> index & 1 != 0 => {
                    if is_complete {
                        reached.is_hit(tree, simd, &ray)
                    } else {
                        let mut any = AnyRising::new(simd, &ray, cull);
                        tree.walk(simd, &ray, 1.0, &mut any);
                        any.any.found
                    }
                }
                _ => {
                    let mut any = Any::new(simd, &ray, 1.0);
                    tree.walk(simd, &ray, 1.0, &mut any);
                    any.found
                }
            };
            occluded |= u64::from(is_hit) << index;
        }
        occluded
    }
}

/// [`Any`] for a ray of a fan: spares the full test what is behind the surface that the ray leaves, above all that itself.
struct AnyRising<'a, S: Simd> {
    any: Any<'a, S>,
    cull: &'a FanCull<S>,
}

impl<'a, S: Simd> AnyRising<'a, S> {
    #[inline(always)]
    fn new(simd: S, ray: &'a Ray, cull: &'a FanCull<S>) -> Self {
        let any = Any::new(simd, ray, 1.0);
        Self { any, cull }
    }
}

impl<S: Simd> Visitor for AnyRising<'_, S> {
    const NEAREST_FIRST: bool = false;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            let lanes = self.any.test.filter.may_hit(block);
            if lanes.is_empty() {
                continue;
            }
            let lanes = lanes.and(self.cull.may_meet_triangles(block));
            if self.any.test.is_hit(block, lanes) {
                self.any.found = true;
                return None;
            }
        }
        Some(1.0)
    }
}

/// The triangles in reach of the rays of a fan.
struct Reached {
    /// Blocks, and which of their triangles.
    blocks: [(usize, LaneSet); MOST_BLOCKS],
    count: usize,
}

impl Reached {
    fn new() -> Self {
        Self {
            blocks: [(0, LaneSet::NONE); MOST_BLOCKS],
            count: 0,
        }
    }

    /// Collects all of `tree`; whether there was room.
    #[inline(always)]
    fn collect<S: Simd>(&mut self, tree: &WideTree, cull: &FanCull<S>) -> bool {
        const STACK_SIZE: usize = 64;
        let mut waiting = [Child::NONE; STACK_SIZE];
        waiting[0] = tree.root;
        let mut count = 1;
        while count > 0 {
            count -= 1;
            match waiting[count].kind() {
                ChildKind::Node(index) => {
                    if count > STACK_SIZE - WIDTH {
                        return false;
                    }
                    let node = &tree.nodes[index];
                    for lane in cull.may_meet(&node.planes) {
                        waiting[count] = node.children[lane];
                        count += 1;
                    }
                }
                ChildKind::Leaf(blocks) => {
                    for index in blocks {
                        let lanes = cull.may_meet_triangles(&tree.blocks[index]);
                        if lanes.is_empty() {
                            continue;
                        }
                        if self.count == MOST_BLOCKS {
                            return false;
                        }
                        self.blocks[self.count] = (index, lanes);
                        self.count += 1;
                    }
                }
            }
        }
        true
    }

    #[inline(always)]
    fn is_hit<S: Simd>(&self, tree: &WideTree, simd: S, ray: &Ray) -> bool {
        if self.count == 0 {
            return false;
        }
        let mut test = LeafTest::new(simd, ray, 1.0);
        for &(index, lanes) in &self.blocks[..self.count] {
            let block: &TriangleBlock = &tree.blocks[index];
            let lanes = test.filter.may_hit(block).and(lanes);
            if test.is_hit(block, lanes) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd::{self, Portable};
    use crate::accel::tests::{rays, scenes};
    use crate::control::CancelToken;
    use crate::math::Vec3;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        for (name, triangles) in scenes() {
            let tree = WideTree::build(&triangles, &CancelToken::new());
            let tree = &tree.expect("nobody cancels");
            for rays in rays(&triangles, 13).chunks(20) {
                let directions: Vec<_> = rays.iter().map(|ray| ray.direction).collect();
                let normal: Vec3 = directions.iter().sum();
                let fan = &Fan::new(rays[0].origin, normal, &directions);
                let query = FanHits { tree, fan };
                assert_eq!(
                    simd::answer(&query),
                    query.answer(Portable),
                    "{name}: {fan:?}"
                );
            }
        }
    }
}
