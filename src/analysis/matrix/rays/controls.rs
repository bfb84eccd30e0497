//! That the figures notice what they are there for: the same protocols with a weaker renderer.

use super::agreement::bits;
use super::aims::Surroundings;
use super::below;
use super::double_precision::by_barycentrics;
use super::escapes::RoughBody;
use super::self_hits::self_hits_of_rays;
use crate::accel::{BruteForce, KdParameters, KdTree};
use crate::analysis::matrix::Effort;
use crate::analysis::matrix::meshes::narrowed;
use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, Ray, Vec3};

/// The test that most renderers begin with, in single precision.
fn meets_by_moller_trumbore(ray: &Ray, triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.corners;
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let s = ray.origin - a;
    let q = s.cross(ab);
    let inverse = 1.0 / ab.dot(p);
    let (u, v) = (s.dot(p) * inverse, ray.direction.dot(q) * inverse);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) * inverse > 0.0
}

#[test]
fn a_leaking_test_of_triangles_is_noticed() {
    let body = RoughBody::new(|p| p);
    let meets = |ray: &Ray| {
        let mut triangles = body.triangles.iter();
        triangles.any(|triangle| meets_by_moller_trumbore(ray, triangle))
    };
    let escaped = body.escapes(4096, meets);
    assert!(escaped > 100.0, "only {escaped} of 4096");
}

#[test]
fn distances_to_planes_without_a_margin_are_noticed() {
    let triangles = narrowed(&shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE));
    let tree = KdTree::build(&triangles, &KdParameters::default(), &CancelToken::new());
    let tree = tree.expect("nobody cancels");
    let all = BruteForce::new(triangles.clone());
    let around = Surroundings::of(&triangles);
    let mut random = Random::new(1);
    let (mut without, mut with) = (0, 0);
    for _ in 0..4096 {
        let ray = around.ray(&mut random);
        let expected = bits(all.intersect(&ray, f32::INFINITY));
        let found = tree.intersect_without_margin(&ray, f32::INFINITY);
        without += u32::from(bits(found) != expected);
        with += u32::from(bits(tree.intersect(&ray, f32::INFINITY)) != expected);
    }
    assert_eq!(with, 0);
    assert!(without > 10, "only {without} of 4096");
}

#[test]
fn a_test_that_drops_slivers_is_noticed() {
    let triangles = narrowed(&shapes::slivers(60, 1e-6, 6));
    let mut random = Random::new(1);
    let missed = (0..4096).filter(|_| {
        let triangle = &triangles[below(&mut random, triangles.len())];
        let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
        let target = ((a + b + c) / 3.0).as_vec3();
        let origin = (random.in_cube() * 3.0).as_vec3();
        let ray = Ray::new(origin, target - origin);
        let exact = by_barycentrics(&ray, triangle).is_some_and(|(_, inside)| inside >= 0.0);
        exact != meets_by_moller_trumbore(&ray, triangle)
    });
    let missed = missed.count();
    assert!(missed > 100, "only {missed} of 4096");
}

#[test]
fn rays_that_start_a_fixed_distance_away_are_noticed() {
    let hits = self_hits_of_rays(Effort::Quick, |point, onward| {
        let normal = point.geometric_normal();
        let start = |side: f32| point.position + normal * (1e-7 * side);
        [Ray::new(start(1.0), onward), Ray::new(start(-1.0), -onward)]
    });
    assert!(hits > 100.0, "only {hits}");
}
