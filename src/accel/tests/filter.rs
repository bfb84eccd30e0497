//! The filter before the test of triangles: it passes every hit, and little else.

use super::*;
use crate::geometry::RayKernel;
use block::{BlockFilter, TriangleBlock};
use simd::{LANES, LaneSet, Query, Simd};

struct MayHit<'a> {
    ray: &'a Ray,
    t_max: f32,
    block: &'a TriangleBlock,
}

impl Query for MayHit<'_> {
    type Answer = LaneSet;

    fn answer<S: Simd>(&self, simd: S) -> LaneSet {
        BlockFilter::new(simd, self.ray).may_hit(self.block, slabs::later(self.t_max))
    }
}

/// What the filter passes by each kind of instructions.
fn may_hit(ray: &Ray, t_max: f32, block: &TriangleBlock) -> Vec<LaneSet> {
    simd::answers(&MayHit { ray, t_max, block })
}

#[test]
fn the_filter_passes_every_hit_and_no_empty_lane() {
    let mut hits = 0;
    for (name, triangles) in scenes() {
        let ids: Vec<u32> = (0..).take(triangles.len()).collect();
        let blocks: Vec<_> = ids
            .chunks(LANES)
            .map(|ids| TriangleBlock::new(ids, &triangles))
            .collect();
        for ray in rays(&triangles, 3).iter().step_by(5) {
            let kernel = RayKernel::new(ray);
            for block in &blocks {
                let passes = |t_max: f32, lane: usize| {
                    let mut passed = may_hit(ray, t_max, block).into_iter();
                    let first = passed.next().unwrap().contains(lane);
                    passed
                        .all(|other| other.contains(lane) == first)
                        .then_some(first)
                };
                for lane in 0..LANES {
                    let triangle = block.triangle(lane);
                    if block.ids[lane] == TriangleBlock::NO_TRIANGLE {
                        let passed = passes(f32::INFINITY, lane);
                        assert_eq!(passed, Some(false), "{name}: {ray:?} hits an empty lane");
                    } else if let Some(hit) = kernel.intersect(&triangle, f32::INFINITY) {
                        hits += 1;
                        for t_max in [hit.t, f32::INFINITY] {
                            let passed = passes(t_max, lane);
                            assert_eq!(passed, Some(true), "{name}: {ray:?} misses {triangle:?}");
                        }
                    }
                }
            }
        }
    }
    assert!(hits > 10_000, "only {hits} hits");
}

/// The filter's error bound must hold where `f32` overflows and underflows, too.
#[test]
fn the_filter_passes_every_hit_of_extreme_size() {
    let mut random = Random::new(5);
    let mut hits = 0;
    for i in 0..300_000 {
        // All over f32's range; where products begin to underflow; each point on its own.
        let common = [random.unit() * 270.0 - 145.0, random.unit() * 8.0 - 70.0];
        let mut extreme = || {
            let own = random.unit() * 240.0 - 120.0;
            let exponent = common.get(i % 3).copied().unwrap_or(own);
            random.in_cube() * exponent.exp2()
        };
        let corners = [extreme(), extreme(), extreme()];
        let origin = narrowed(extreme());
        let on_edge = corners[0] + (corners[1] - corners[0]) * random.unit();
        let ray = Ray::new(origin, narrowed(on_edge) - origin);
        if ray.direction == Vec3::ZERO {
            continue;
        }
        let triangle = Triangle {
            corners: corners.map(narrowed),
        };
        let kernel = RayKernel::new(&ray);
        if let Some(hit) = kernel.intersect(&triangle, f32::INFINITY) {
            hits += 1;
            let block = TriangleBlock::new(&[0], &[triangle]);
            for t_max in [hit.t, f32::INFINITY] {
                for passed in may_hit(&ray, t_max, &block) {
                    assert_eq!(passed, LaneSet::first(1), "{ray:?} misses {triangle:?}");
                }
            }
        }
    }
    assert!(hits > 20_000, "only {hits} hits");
}

/// Of all triangles on the line of a ray, those behind its start and those beyond its end are nearly all left out.
#[test]
fn the_filter_leaves_out_what_is_out_of_reach() {
    let triangles = rough_sphere(2, 3);
    let ids: Vec<u32> = (0..).take(triangles.len()).collect();
    let mut random = Random::new(12);
    let (mut within, mut passed) = (0, 0);
    for _ in 0..2000 {
        let ray = Ray::new(
            narrowed(random.in_cube() * 0.3),
            narrowed(random.in_cube().normalize()),
        );
        let kernel = RayKernel::new(&ray);
        for ids in ids.chunks(LANES) {
            let block = TriangleBlock::new(ids, &triangles);
            for t_max in [0.5, f32::INFINITY] {
                let hits = ids.iter().map(|&id| &triangles[id as usize]);
                within += hits
                    .filter(|t| kernel.intersect(t, t_max).is_some())
                    .count();
                let answers = may_hit(&ray, t_max, &block);
                passed += answers[0].count();
                assert!(answers.iter().all(|other| *other == answers[0]), "{ray:?}");
            }
        }
    }
    assert!(within > 1000, "only {within} hits");
    assert!(
        passed <= within + within / 100,
        "{passed} for {within} hits"
    );
}
