//! What rays do with the leaves of a tree: look for the nearest hit, or for any.

use super::block::{BlockFilter, TriangleBlock};
use super::simd::Simd;
use super::{Hit, Visits};
use crate::geometry::{RayKernel, Triangle, TriangleHit};
use crate::math::Ray;

/// What a walk through a tree does on its way.
pub(super) trait Visitor {
    /// Whether leaves are visited in the order in which the ray enters them.
    const NEAREST_FIRST: bool;

    /// Takes note of a node with children.
    #[inline(always)]
    fn enter_node(&mut self) {}

    /// Visits a leaf. Returns the `t` beyond which nothing matters any more, `None` to stop.
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32>;
}

/// One ray's tests against triangles.
pub(super) struct LeafTest<'a, S: Simd> {
    ray: &'a Ray,
    pub filter: BlockFilter<S>,
    /// Made when the first triangle passes the filter, which many rays never see.
    kernel: Option<RayKernel>,
    t_max: f32,
}

impl<'a, S: Simd> LeafTest<'a, S> {
    #[inline(always)]
    fn new(simd: S, ray: &'a Ray, t_max: f32) -> Self {
        Self {
            ray,
            filter: BlockFilter::new(simd, ray),
            kernel: None,
            t_max,
        }
    }

    #[inline(always)]
    pub fn intersect(&mut self, triangle: &Triangle) -> Option<TriangleHit> {
        let kernel = self.kernel.get_or_insert_with(|| RayKernel::new(self.ray));
        kernel.intersect(triangle, self.t_max)
    }
}

/// Finds the nearest hit.
pub(super) struct Nearest<'a, S: Simd> {
    test: LeafTest<'a, S>,
    pub best: Option<Hit>,
}

impl<'a, S: Simd> Nearest<'a, S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &'a Ray, t_max: f32) -> Self {
        Self {
            test: LeafTest::new(simd, ray, t_max),
            best: None,
        }
    }
}

impl<S: Simd> Visitor for Nearest<'_, S> {
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            for lane in self.test.filter.may_hit(block) {
                if let Some(new) = self.test.intersect(&block.triangle(lane)) {
                    self.best = Some(Hit::nearer(self.best, block.ids[lane], new));
                }
            }
        }
        Some(self.best.map_or(self.test.t_max, |hit| hit.t))
    }
}

/// Finds any hit.
pub(super) struct Any<'a, S: Simd> {
    pub test: LeafTest<'a, S>,
    pub found: bool,
}

impl<'a, S: Simd> Any<'a, S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &'a Ray, t_max: f32) -> Self {
        Self {
            test: LeafTest::new(simd, ray, t_max),
            found: false,
        }
    }
}

impl<S: Simd> Visitor for Any<'_, S> {
    const NEAREST_FIRST: bool = false;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            for lane in self.test.filter.may_hit(block) {
                if self.test.intersect(&block.triangle(lane)).is_some() {
                    self.found = true;
                    return None;
                }
            }
        }
        Some(self.test.t_max)
    }
}

/// A visitor and the account of what it was led to.
pub(super) struct Counting<V> {
    pub visitor: V,
    pub visits: Visits,
}

impl<V> Counting<V> {
    pub fn new(visitor: V) -> Self {
        Self {
            visitor,
            visits: Visits::default(),
        }
    }
}

impl<V: Visitor> Visitor for Counting<V> {
    const NEAREST_FIRST: bool = V::NEAREST_FIRST;

    #[inline(always)]
    fn enter_node(&mut self) {
        self.visits.nodes += 1;
    }

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        self.visits.blocks += blocks.len() as u64;
        self.visitor.visit(blocks)
    }
}
