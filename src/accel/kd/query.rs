//! The two questions a ray asks, as code that is compiled for several kinds of vector instructions.

use super::KdTree;
use crate::accel::Hit;
use crate::accel::block::BlockFilter;
use crate::accel::simd::Query;
use crate::geometry::RayKernel;
use crate::math::Ray;

/// [`KdTree::intersect`].
pub(super) struct NearestHit<'a> {
    pub tree: &'a KdTree,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl Query for NearestHit<'_> {
    type Answer = Option<Hit>;

    #[inline(always)]
    fn answer(&self) -> Option<Hit> {
        let kernel = RayKernel::new(self.ray);
        let filter = BlockFilter::new(self.ray, &kernel);
        let mut best: Option<Hit> = None;
        self.tree.walk(self.ray, self.t_max, |blocks| {
            for block in blocks {
                for lane in filter.may_hit(block) {
                    if let Some(new) = kernel.intersect(&block.triangle(lane), self.t_max) {
                        best = Some(Hit::nearer(best, block.ids[lane], new));
                    }
                }
            }
            Some(best.map_or(self.t_max, |hit| hit.t))
        });
        best
    }
}

/// [`KdTree::occluded`].
pub(super) struct AnyHit<'a> {
    pub tree: &'a KdTree,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl Query for AnyHit<'_> {
    type Answer = bool;

    #[inline(always)]
    fn answer(&self) -> bool {
        let kernel = RayKernel::new(self.ray);
        let filter = BlockFilter::new(self.ray, &kernel);
        let mut found = false;
        self.tree.walk(self.ray, self.t_max, |blocks| {
            for block in blocks {
                for lane in filter.may_hit(block) {
                    let hit = kernel.intersect(&block.triangle(lane), self.t_max);
                    if hit.is_some() {
                        found = true;
                        return None;
                    }
                }
            }
            Some(self.t_max)
        });
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::tests::{rays, scenes};
    use crate::accel::{KdParameters, simd};
    use crate::control::CancelToken;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        for (name, triangles) in scenes() {
            let parameters = KdParameters::default();
            let tree = KdTree::build(&triangles, &parameters, &CancelToken::new());
            let tree = &tree.expect("nobody cancels");
            for ray in &rays(&triangles, 9) {
                for t_max in [f32::INFINITY, 0.7] {
                    let nearest = NearestHit { tree, ray, t_max };
                    let bits = |hit: Hit| {
                        let weights = hit.barycentrics.map(f32::to_bits);
                        (hit.triangle, hit.t.to_bits(), weights)
                    };
                    let (plain, wide) = (nearest.answer(), simd::answer(&nearest));
                    assert_eq!(plain.map(bits), wide.map(bits), "{name}: {ray:?}");
                    let any = AnyHit { tree, ray, t_max };
                    assert_eq!(any.answer(), plain.is_some(), "{name}: {ray:?}");
                    assert_eq!(simd::answer(&any), plain.is_some(), "{name}: {ray:?}");
                }
            }
        }
    }
}
