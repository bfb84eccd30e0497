//! The two questions a ray asks, as code that is compiled for several kinds of vector instructions.

use super::WideTree;
use super::walk::Visitor;
use crate::accel::Hit;
use crate::accel::block::{BlockFilter, TriangleBlock};
use crate::accel::simd::Query;
use crate::geometry::RayKernel;
use crate::math::Ray;

/// [`WideTree::intersect`].
pub(super) struct NearestHit<'a> {
    pub tree: &'a WideTree,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl Query for NearestHit<'_> {
    type Answer = Option<Hit>;

    #[inline(always)]
    fn answer(&self) -> Option<Hit> {
        let mut nearest = Nearest::new(self.ray, self.t_max);
        self.tree.walk(self.ray, self.t_max, &mut nearest);
        nearest.best
    }
}

/// Finds the nearest hit.
pub(super) struct Nearest {
    kernel: RayKernel,
    filter: BlockFilter,
    t_max: f32,
    best: Option<Hit>,
}

impl Nearest {
    #[inline(always)]
    pub fn new(ray: &Ray, t_max: f32) -> Self {
        let kernel = RayKernel::new(ray);
        Self {
            filter: BlockFilter::new(ray, &kernel),
            kernel,
            t_max,
            best: None,
        }
    }
}

impl Visitor for Nearest {
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            for lane in self.filter.may_hit(block) {
                if let Some(new) = self.kernel.intersect(&block.triangle(lane), self.t_max) {
                    self.best = Some(Hit::nearer(self.best, block.ids[lane], new));
                }
            }
        }
        Some(self.best.map_or(self.t_max, |hit| hit.t))
    }
}

/// [`WideTree::occluded`].
pub(super) struct AnyHit<'a> {
    pub tree: &'a WideTree,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl Query for AnyHit<'_> {
    type Answer = bool;

    #[inline(always)]
    fn answer(&self) -> bool {
        let mut any = Any::new(self.ray, self.t_max);
        self.tree.walk(self.ray, self.t_max, &mut any);
        any.found
    }
}

/// Finds any hit.
pub(super) struct Any {
    kernel: RayKernel,
    filter: BlockFilter,
    t_max: f32,
    found: bool,
}

impl Any {
    #[inline(always)]
    pub fn new(ray: &Ray, t_max: f32) -> Self {
        let kernel = RayKernel::new(ray);
        Self {
            filter: BlockFilter::new(ray, &kernel),
            kernel,
            t_max,
            found: false,
        }
    }
}

impl Visitor for Any {
    const NEAREST_FIRST: bool = false;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            for lane in self.filter.may_hit(block) {
                let hit = self.kernel.intersect(&block.triangle(lane), self.t_max);
                if hit.is_some() {
                    self.found = true;
                    return None;
                }
            }
        }
        Some(self.t_max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd;
    use crate::accel::tests::{rays, scenes};
    use crate::control::CancelToken;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        for (name, triangles) in scenes() {
            let tree = &WideTree::build(&triangles, &CancelToken::new()).unwrap();
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
