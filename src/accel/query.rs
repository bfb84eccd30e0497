//! The questions a ray asks of a tree, as code that is compiled for several kinds of vector instructions.

use super::leaf::{Any, Counting, Nearest, Visitor};
use super::simd::{Query, Simd};
use super::{Hit, Visits};
use crate::math::Ray;

/// A structure that leads rays to leaves.
pub(super) trait Tree {
    /// Visits the leaves that `ray` may meet in `0 < t < t_max`, except those beyond the `t` of the last visit.
    ///
    /// Always inlined, see [`super::simd`].
    fn walk<S: Simd, V: Visitor>(&self, simd: S, ray: &Ray, t_max: f32, visitor: &mut V);
}

/// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
pub(super) struct NearestHit<'a, T> {
    pub tree: &'a T,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl<T: Tree> Query for NearestHit<'_, T> {
    type Answer = Option<Hit>;

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> Option<Hit> {
        let mut nearest = Nearest::new(simd, self.ray, self.t_max);
        self.tree.walk(simd, self.ray, self.t_max, &mut nearest);
        nearest.best
    }
}

/// Whether anything is hit with `0 < t < t_max`.
pub(super) struct AnyHit<'a, T> {
    pub tree: &'a T,
    pub ray: &'a Ray,
    pub t_max: f32,
}

impl<T: Tree> Query for AnyHit<'_, T> {
    type Answer = bool;

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> bool {
        let mut any = Any::new(simd, self.ray, self.t_max);
        self.tree.walk(simd, self.ray, self.t_max, &mut any);
        any.found
    }
}

/// What [`NearestHit`], or [`AnyHit`] where `any_hit`, visits; the nearest hit beside it.
pub(super) struct CountVisits<'a, T> {
    pub tree: &'a T,
    pub ray: &'a Ray,
    pub t_max: f32,
    pub any_hit: bool,
}

impl<T: Tree> Query for CountVisits<'_, T> {
    type Answer = (Visits, Option<Hit>);

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> (Visits, Option<Hit>) {
        let (ray, t_max) = (self.ray, self.t_max);
        if self.any_hit {
            let mut counting = Counting::new(Any::new(simd, ray, t_max));
            self.tree.walk(simd, ray, t_max, &mut counting);
            (counting.visits, None)
        } else {
            let mut counting = Counting::new(Nearest::new(simd, ray, t_max));
            self.tree.walk(simd, ray, t_max, &mut counting);
            (counting.visits, counting.visitor.best)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd;
    use crate::accel::tests::{kd_tree, rays, scenes, wide_tree};

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        for (name, triangles) in scenes() {
            let rays = rays(&triangles, 9);
            assert_same_answers(name, &kd_tree(&triangles), &rays);
            assert_same_answers(name, &wide_tree(&triangles), &rays);
        }
    }

    fn assert_same_answers(name: &str, tree: &impl Tree, rays: &[Ray]) {
        for ray in rays {
            for t_max in [f32::INFINITY, 0.7] {
                let nearest = NearestHit { tree, ray, t_max };
                let bits = |hit: Hit| {
                    let weights = hit.barycentrics.map(f32::to_bits);
                    (hit.triangle, hit.t.to_bits(), weights)
                };
                let hits = simd::answers(&nearest);
                for hit in &hits[1..] {
                    assert_eq!(hit.map(bits), hits[0].map(bits), "{name}: {ray:?}");
                }
                for is_hit in simd::answers(&AnyHit { tree, ray, t_max }) {
                    assert_eq!(is_hit, hits[0].is_some(), "{name}: {ray:?}");
                }
            }
        }
    }
}
