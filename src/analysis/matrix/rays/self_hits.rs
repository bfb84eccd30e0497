//! Rays that start on what they left.

use std::sync::atomic::{AtomicU64, Ordering};

use super::count_over;
use crate::analysis::matrix::Effort;
use crate::analysis::matrix::stage::{add, joined, mapped, phong, prepared, still};
use crate::geometry::shapes;
use crate::math::{Ray, Vec3};
use crate::render::SurfacePoint;

pub fn self_hits(effort: Effort) -> f64 {
    self_hits_of_rays(effort, |point, onward| {
        [point.ray_above(onward), point.ray_through(-onward)]
    })
}

/// How many of the rays that `leave` makes, given the point and a direction above it, meet the triangle they leave.
pub fn self_hits_of_rays(
    effort: Effort,
    leave: impl Fn(&SurfacePoint, Vec3) -> [Ray; 2] + Sync,
) -> f64 {
    let rays_each = effort.pick(100_000, 30_000_000) / 3;
    let mut count = 0.0;
    for distance in [0.0, 100.0, 1e4] {
        // Many triangles of size 1 around two places.
        let soup = shapes::soup(2000, 0.7, 9);
        let apart = joined([
            mapped(soup.clone(), |p| p + distance),
            mapped(soup, |p| p - distance),
        ]);
        let mut scene = still(1, 1);
        add(&mut scene, "soup", apart, phong(0.5, 0.0, 1.0));
        let scene = prepared(&scene);
        let accelerator = scene.geometry().accelerator();
        let scale = scene.geometry().frame().scale();
        let left = AtomicU64::new(0);
        count += count_over(rays_each, |random, count| {
            let mut hits = 0;
            for _ in 0..count {
                let id = u32::try_from(random.bits() % 4000).expect("few");
                let [a, b, c] = scene
                    .geometry()
                    .triangle(id)
                    .in_scene()
                    .corners
                    .map(Vec3::as_dvec3);
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let aim = a + (b - a) * u + (c - a) * v;
                let away = random.in_cube().normalize();
                let ray = Ray::new((aim + away * (10.0 * scale)).as_vec3(), -away.as_vec3());
                let Some(point) = scene.surface_along(&ray, f32::INFINITY) else {
                    continue;
                };
                left.fetch_add(1, Ordering::Relaxed);
                let mut onward = random.in_cube().normalize().as_vec3();
                if onward.dot(point.geometric_normal()) < 0.0 {
                    onward = -onward;
                }
                for ray in leave(&point, onward) {
                    let met = accelerator.intersect(&ray, f32::INFINITY);
                    hits += u64::from(met.is_some_and(|hit| hit.triangle == point.triangle));
                }
            }
            hits
        });
        let left = left.into_inner();
        assert!(
            left > rays_each / 2,
            "only {left} of {rays_each} rays left a triangle"
        );
    }
    count
}
