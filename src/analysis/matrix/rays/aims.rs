//! Rays of the kinds that find mistakes: alone, in packets and in fans.

use super::below;
use crate::accel::Packet;
use crate::geometry::Triangle;
use crate::geometry::shapes::Random;
use crate::math::{Bounds, DVec3, Ray, Vec3, robust};

/// Where rays to a scene may start and aim.
pub struct Surroundings<'a> {
    triangles: &'a [Triangle],
    /// Of the box around the triangles.
    pub center: DVec3,
    /// Half of that box's sides.
    pub half: DVec3,
    /// The longest of these halves, above 0.
    pub size: f64,
}

impl<'a> Surroundings<'a> {
    pub fn of(triangles: &'a [Triangle]) -> Self {
        let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
        let (center, half) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ONE)
        } else {
            (bounds.center().as_dvec3(), bounds.size().as_dvec3() * 0.5)
        };
        let size = half.max_element().max(f64::from(f32::MIN_POSITIVE));
        Self {
            triangles,
            center,
            half,
            size,
        }
    }

    /// One of the kinds of rays that find mistakes.
    pub fn ray(&self, random: &mut Random) -> Ray {
        loop {
            let ray = self.candidate(random);
            if ray.direction.is_finite() && ray.direction != Vec3::ZERO {
                return ray;
            }
        }
    }

    fn candidate(&self, random: &mut Random) -> Ray {
        let reach = [0.9, 3.0, 100.0][below(random, 3)];
        let origin = (self.center + random.in_cube() * self.size * reach).as_vec3();
        if self.triangles.is_empty() {
            return Ray::new(origin, random.in_cube().as_vec3());
        }
        let corners = self.triangles[below(random, self.triangles.len())].corners;
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let beside =
            a + (b - a) * (random.unit() * 6.0 - 3.0) + (c - a) * (random.unit() * 6.0 - 3.0);
        match below(random, 9) {
            0 => Ray::new(origin, random.in_cube().as_vec3()),
            1 => {
                let target = self.center + random.in_cube() * self.half;
                Ray::new(origin, target.as_vec3() - origin)
            }
            // At corners, at edges.
            2 => Ray::new(origin, corners[0] - origin),
            3 => Ray::new(origin, (a + (b - a) * random.unit()).as_vec3() - origin),
            // In the plane of a triangle, and from it.
            4 => Ray::new(beside.as_vec3(), (b - beside).as_vec3()),
            5 => Ray::new(beside.as_vec3(), (c - b).as_vec3()),
            6 => Ray::new(corners[0], (c - b).as_vec3()),
            7 => Ray::new(corners[0], random.in_cube().as_vec3()),
            // Along the lattice, with both zeros, from coordinates of corners, where planes are likely.
            _ => {
                let mut of_corner =
                    || self.triangles[below(random, self.triangles.len())].corners[0];
                let mut origin = Vec3::new(of_corner().x, of_corner().y, of_corner().z);
                let direction = lattice_direction(below(random, 64));
                if below(random, 2) == 0 {
                    origin -= (direction.as_dvec3() * (self.size * 4.0)).as_vec3();
                }
                Ray::new(origin, direction)
            }
        }
    }

    /// Sixteen rays that go almost the same way, the first of them one of [`Self::ray`]: from its origin, from a lens around it, or beside
    /// each other. Every fifth goes not much further than the first aims.
    pub fn packet(&self, random: &mut Random) -> Vec<(Ray, f32)> {
        let first = self.ray(random);
        let spread = [1.0, 0.1, 1e-2, 1e-4, 1e-6][below(random, 5)];
        let [on_lens, in_direction] =
            [[0.0, spread], [spread, spread], [spread, 0.0]][below(random, 3)];
        let length = f64::from(first.direction.abs().max_element());
        let others = (1..Packet::MOST_RAYS).map(|index| {
            let offset = random.in_cube() * self.size * on_lens;
            let turn = random.in_cube() * length * in_direction;
            let ray = Ray::new(
                first.origin + offset.as_vec3(),
                first.direction + turn.as_vec3(),
            );
            let t_max = if index % 5 == 0 { 1.1 } else { f32::INFINITY };
            (ray, t_max)
        });
        let rays = std::iter::once((first, f32::INFINITY)).chain(others);
        rays.filter(|(ray, _)| ray.direction.is_finite() && ray.direction != Vec3::ZERO)
            .collect()
    }

    /// A point, the normal there, and directions to where rays from it end: on a triangle, just above one as where rendering looks for
    /// light and occlusion, or anywhere; into the hemisphere, to corners and beyond them.
    pub fn fan(&self, random: &mut Random) -> (Vec3, Vec3, Vec<Vec3>) {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z];
        let nothing = Triangle { corners };
        let any = |random: &mut Random| {
            let index = below(random, self.triangles.len().max(1));
            self.triangles.get(index).copied().unwrap_or(nothing)
        };
        let from = any(random);
        let normal = from.normal();
        let (u, v) = (random.unit(), random.unit());
        let weights = DVec3::new(1.0 - u, u * (1.0 - v), u * v).as_vec3();
        let (point, error) = from.point(weights.to_array());
        let origin = match below(random, 3) {
            0 => point,
            1 => robust::offset_origin(point, error, normal, normal),
            _ => self.ray(random).origin,
        };
        let kind = below(random, 3);
        let mut direction = || {
            if kind > 0 {
                let aim = any(random).corners[0] - origin;
                return if kind == 1 { aim } else { aim * 2.0 };
            }
            let direction = (random.in_cube() * self.size).as_vec3();
            if direction.dot(normal) < 0.0 {
                -direction
            } else {
                direction
            }
        };
        let directions = (0..16).map(|_| direction());
        let directions = directions.filter(|d| d.is_finite() && *d != Vec3::ZERO);
        (origin, normal, directions.collect())
    }
}

/// Number `number` below 64 of the vectors of −1, −0, 0 and 1.
pub fn lattice_direction(number: usize) -> Vec3 {
    let values = [-1.0, -0.0, 0.0, 1.0];
    Vec3::new(
        values[number % 4],
        values[number / 4 % 4],
        values[number / 16],
    )
}
