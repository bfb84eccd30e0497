//! Brute force and the trees against another test of triangles, in double precision.

use std::sync::atomic::{AtomicU64, Ordering};

use super::aims::Surroundings;
use super::scenes::{scenes, trees};
use super::{below, count_over};
use crate::accel::BruteForce;
use crate::analysis::matrix::Effort;
use crate::analysis::matrix::meshes::narrowed;
use crate::geometry::Triangle;
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, Ray, Vec3};

/// Where a ray meets a triangle: the parameter, and the distance from the nearest edge over the longest one, negative outside.
/// Source: Möller, Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997; in `f64`, without a threshold.
pub fn by_barycentrics(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(ab);
    let v = direction.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    let edges = [(u, ac), (v, ab), (1.0 - u - v, c - b)];
    let longest = edges
        .map(|(_, edge)| edge.length())
        .into_iter()
        .fold(0.0, f64::max);
    let doubled_area = ab.cross(ac).length();
    // A weight is the distance from its edge over the height on that edge.
    let inside = edges.map(|(weight, edge)| weight * doubled_area / edge.length() / longest);
    Some((t, inside.into_iter().fold(f64::INFINITY, f64::min)))
}

pub fn unlike_double_precision(effort: Effort) -> f64 {
    /// Of the longest edge: far above the rounding of the second test for rays of the scene's size.
    const NEAR_EDGE: f64 = 1e-6;
    let meshes = [
        shapes::icosphere(2),
        shapes::soup(300, 0.2, 4),
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        shapes::axis_aligned(300, 16, 9),
    ];
    let large = meshes
        .iter()
        .map(|mesh| (narrowed(mesh), effort.pick(10_000, 1_000_000)));
    // Those with triangles.
    let small = scenes().into_iter().skip(1);
    let small = small.map(|triangles| (triangles, effort.pick(5_000, 250_000)));
    let (mut count, mut tested) = (0.0, 0);
    let hits = AtomicU64::new(0);
    for (triangles, rays) in large.chain(small) {
        let all = BruteForce::new(triangles.clone());
        let around = Surroundings::of(&triangles);
        let skipped = AtomicU64::new(0);
        count += count_over(rays, |random, count| {
            let differs = |random: &mut Random| {
                let origin = (around.center + random.in_cube() * around.size * 3.0).as_vec3();
                let target = (around.center + random.in_cube() * around.half).as_vec3();
                let ray = Ray::new(origin, target - origin);
                let mut nearest = f64::INFINITY;
                for triangle in &triangles {
                    match by_barycentrics(&ray, triangle) {
                        Some((_, inside)) if inside.abs() < NEAR_EDGE => {
                            skipped.fetch_add(1, Ordering::Relaxed);
                            return false;
                        }
                        Some((t, inside)) if inside > 0.0 && t > 0.0 => nearest = nearest.min(t),
                        _ => {}
                    }
                }
                match all.intersect(&ray, f32::INFINITY) {
                    None => nearest.is_finite(),
                    Some(hit) => {
                        hits.fetch_add(1, Ordering::Relaxed);
                        (f64::from(hit.t) - nearest).abs() > 1e-6 * nearest
                    }
                }
            };
            (0..count).map(|_| u64::from(differs(random))).sum()
        });
        tested += rays;
        let skipped = skipped.into_inner();
        assert!(
            skipped <= rays / 100,
            "{skipped} of {rays} rays pass near an edge"
        );
    }
    let hits = hits.into_inner();
    assert!(hits > tested / 20, "only {hits} of {tested} rays hit");
    count
}

pub fn slivers_unlike_double_precision(effort: Effort) -> f64 {
    let triangles = narrowed(&shapes::slivers(60, 1e-6, 6));
    let trees = trees(&triangles);
    let around = Surroundings::of(&triangles);
    let rays = effort.pick(40_000, 4_000_000);
    let hits = AtomicU64::new(0);
    let different = count_over(rays, |random, count| {
        let differs = |random: &mut Random| {
            let [a, b, c] = triangles[below(random, triangles.len())].corners;
            let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
            let mut share = || random.unit() * 1.5 - 0.25;
            let target = a + (b - a) * share() + (c - a) * share();
            let origin = (around.center + random.in_cube() * around.size * 3.0).as_vec3();
            let ray = Ray::new(origin, target.as_vec3() - origin);
            let met = triangles.iter().zip(0_u32..).filter_map(|(triangle, id)| {
                let (t, inside) = by_barycentrics(&ray, triangle)?;
                (inside >= 0.0 && t > 0.0).then_some((t, id))
            });
            let nearest = met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id);
            hits.fetch_add(u64::from(nearest.is_some()), Ordering::Relaxed);
            trees
                .iter()
                .any(|tree| tree.intersect(&ray, f32::INFINITY).map(|hit| hit.triangle) != nearest)
        };
        (0..count).map(|_| u64::from(differs(random))).sum()
    });
    let hits = hits.into_inner();
    assert!(hits > rays / 20, "only {hits} of {rays} rays hit");
    different / rays as f64
}
