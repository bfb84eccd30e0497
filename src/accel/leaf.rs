//! What rays do with the leaves of a tree: look for the nearest hit, or for any.

use super::block::{BlockFilter, TriangleBlock};
use super::full::{FullTests, KernelRays};
use super::simd::{Four, LaneSet, Simd};
use super::slabs::later;
use super::{Hit, Visits};
use crate::geometry::{RayKernel, TriangleHit};
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
#[derive(Clone, Copy)]
pub(super) struct LeafTest<'a, S: Simd> {
    simd: S,
    ray: &'a Ray,
    pub filter: BlockFilter<S>,
    /// Made when the first triangle passes the filter, which many rays never see.
    kernel: Option<RayKernel>,
    t_max: f32,
}

impl<'a, S: Simd> LeafTest<'a, S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &'a Ray, t_max: f32) -> Self {
        Self::with_filter(simd, ray, t_max, BlockFilter::new(simd, ray))
    }

    /// [`Self::new`], given the ray's filter.
    #[inline(always)]
    pub fn with_filter(simd: S, ray: &'a Ray, t_max: f32, filter: BlockFilter<S>) -> Self {
        Self {
            simd,
            ray,
            filter,
            kernel: None,
            t_max,
        }
    }

    /// Tests four triangles of a block.
    #[inline(always)]
    fn four(&mut self, block: &TriangleBlock, four: Four) -> FullTests<S, S::F64x4> {
        let kernel = match self.kernel {
            Some(kernel) => kernel,
            None => RayKernel::with_axes(self.ray, self.filter.axes),
        };
        self.kernel = Some(kernel);
        let corners = block.four(self.simd, kernel.axes, four.index);
        FullTests::new(
            self.simd,
            &KernelRays::one(self.simd, &kernel),
            &corners,
            four.lanes,
        )
    }

    /// Whether one of the triangles in these lanes is hit.
    #[inline(always)]
    pub fn is_hit(&mut self, block: &TriangleBlock, lanes: LaneSet) -> bool {
        for four in lanes.fours() {
            let first = four.first();
            let four = self.four(block, four);
            let hits = four.hits();
            for lane in four.met {
                if hits.get(lane).is_some_and(|hit| hit.t < self.t_max) {
                    return true;
                }
            }
            for lane in four.undecided {
                if decide(self.ray, self.t_max, block, first + lane).is_some() {
                    return true;
                }
            }
        }
        false
    }
}

/// The test of a triangle that [`FullTests`] do not decide.
#[cold]
pub(super) fn decide(
    ray: &Ray,
    t_max: f32,
    block: &TriangleBlock,
    lane: usize,
) -> Option<TriangleHit> {
    RayKernel::new(ray).intersect(&block.triangle(lane), t_max)
}

/// Finds the nearest hit.
#[derive(Clone, Copy)]
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

    /// A bound on where anything may still become the nearest hit.
    #[inline(always)]
    fn limit(&self) -> f32 {
        later(self.best.map_or(self.test.t_max, |hit| hit.t))
    }

    #[inline(always)]
    fn consider(&mut self, id: u32, new: Option<TriangleHit>) {
        if let Some(new) = new.filter(|new| new.t < self.test.t_max) {
            self.best = Some(Hit::nearer(self.best, id, new));
        }
    }
}

impl<S: Simd> Visitor for Nearest<'_, S> {
    const NEAREST_FIRST: bool = true;

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        for block in blocks {
            for four in self.test.filter.may_hit(block, self.limit()).fours() {
                let first = four.first();
                let four = self.test.four(block, four);
                let hits = four.hits();
                for lane in four.met {
                    self.consider(block.ids[first + lane], hits.get(lane));
                }
                for lane in four.undecided {
                    let lane = first + lane;
                    let hit = decide(self.test.ray, self.test.t_max, block, lane);
                    self.consider(block.ids[lane], hit);
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
            let passed = self.test.filter.may_hit(block, later(self.test.t_max));
            if self.test.is_hit(block, passed) {
                self.found = true;
                return None;
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
