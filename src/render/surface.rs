//! Points on surfaces as shading needs them: position, normals, and where rays that leave them start.

use super::fresnel::reflect;
use super::geometry::PreparedGeometry;
use super::light_tree::Receiver;
use crate::accel::{Fan, Hit};
use crate::math::{DVec3, Ray, Vec3, robust};

/// The point where a ray meets a surface, as shading needs it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// From the corners by barycentric weights: far closer to the surface than `origin + t · direction`.
    pub position: Vec3,
    /// Where the surface is that the triangles stand for: `position`, lifted where the object is smooth. Rays towards light start here
    /// but for rounding, so light is aimed at, and densities of aiming are told, from here.
    pub shading_position: Vec3,
    /// Bound on the rounding error of each coordinate of `position`.
    error: Vec3,
    /// Where rays on the side of `wo` start.
    start: Vec3,
    /// From the ray's origin, in prepared units; camera rays start a way from the eye.
    pub distance: f32,
    /// Towards where the ray came from; unit.
    pub wo: Vec3,
    /// Of the triangle, on the side of `wo`; unit. It decides sides and offsets.
    geometric_normal: Vec3,
    /// Interpolated where the object is smooth, on the side of the surface that `wo` is on; unit. It decides cosines.
    pub shading_normal: Vec3,
    /// The normal for mirrors, glass and lobes; unit. The shading normal, but tilted as far as needed where reflection about
    /// that would lead into the surface.
    pub specular_normal: Vec3,
    /// Whether the ray met the side that the triangle's corners turn counter-clockwise on.
    pub front: bool,
    /// Index of the object in the description.
    pub object: usize,
    /// Number of the triangle.
    pub triangle: u32,
}

impl SurfacePoint {
    /// The point where `ray` makes `hit`.
    #[must_use]
    #[inline]
    pub fn new(geometry: &PreparedGeometry, ray: &Ray, hit: &Hit) -> Self {
        let triangle = geometry.triangle(hit.triangle);
        let (position, error) = triangle.point(hit.barycentrics);
        let outward = triangle.normal();
        let length = ray.direction.length();
        let wo = ray.direction / -length;
        let front = outward.dot(wo) >= 0.0;
        let geometric_normal = if front { outward } else { -outward };

        let mut point = Self {
            position,
            shading_position: position,
            error,
            start: robust::offset_origin(position, error, geometric_normal, geometric_normal),
            distance: hit.t * length,
            wo,
            geometric_normal,
            shading_normal: geometric_normal,
            specular_normal: geometric_normal,
            front,
            object: triangle.part,
            triangle: hit.triangle,
        };
        if let Some(normals) = geometry.corner_normals(&triangle) {
            point.smooth(&triangle.in_scene().corners, normals, hit.barycentrics);
        }
        point
    }

    /// Takes the shading normal from those of the corners, and lifts the point to the smooth surface they stand for.
    fn smooth(&mut self, corners: &[Vec3; 3], normals: [Vec3; 3], weights: [f32; 3]) {
        let [u, v, w] = weights;
        let interpolated = normals[0] * u + normals[1] * v + normals[2] * w;
        let Some(normal) = interpolated.try_normalize() else {
            return;
        };
        let flip = if normal.dot(self.geometric_normal) < 0.0 {
            -1.0
        } else {
            1.0
        };
        self.shading_normal = normal * flip;
        self.specular_normal = self.reflecting_outwards(self.shading_normal);

        // Each corner's tangent plane, where it lies above the point, lifts it by its weight.
        // Source: Hanika, Hacking the Shadow Terminator, Ray Tracing Gems II, 2021.
        let lift = |corner: usize| {
            let normal = normals[corner] * flip;
            let height = (corners[corner] - self.position).dot(normal).max(0.0);
            normal * (height * weights[corner])
        };
        let lift = lift(0) + lift(1) + lift(2);
        if lift.dot(self.geometric_normal) > 0.0 {
            self.shading_position = self.position + lift;
            let error = self.error + self.shading_position.abs() * robust::gamma(1);
            let normal = self.geometric_normal;
            self.start = robust::offset_origin(self.shading_position, error, normal, normal);
        }
    }

    /// Turns the shading normal to the one that an image says: `relative` to `axes`, in which the image's coordinates grow, and to the
    /// normal of the surface's outside, so that what stands out from the front is sunk into the back. Axes and vector are of any
    /// length; where they say no direction, or one into the surface, nothing is turned.
    pub fn turn_normal(&mut self, relative: Vec3, axes: [DVec3; 2]) {
        // An even surface keeps its normal in every bit.
        if relative.x == 0.0 && relative.y == 0.0 {
            return;
        }
        let side = if self.front { 1.0 } else { -1.0 };
        let outward = self.shading_normal.as_dvec3() * side;
        let first = axes[0] - outward * outward.dot(axes[0]);
        let Some(first) = first.try_normalize() else {
            return;
        };
        // Mirrored images turn the other way.
        let across = outward.cross(first);
        let second = across * across.dot(axes[1]).signum();
        let relative = relative.as_dvec3();
        let turned = first * relative.x + second * relative.y + outward * relative.z;
        let Some(turned) = (turned * side).as_vec3().try_normalize() else {
            return;
        };
        if turned.dot(self.geometric_normal) > 0.0 {
            self.shading_normal = turned;
            self.specular_normal = self.reflecting_outwards(turned);
        }
    }

    /// `normal`, tilted as little as needed for `wo` to be reflected away from the surface.
    fn reflecting_outwards(&self, normal: Vec3) -> Vec3 {
        // The least height of the reflected direction: always below that about the geometric normal, and small, so that
        // only what would fail is tilted.
        let least = (0.9 * self.geometric_normal.dot(self.wo)).min(0.01);
        let mirror = reflect(self.wo, normal);
        let height = self.geometric_normal.dot(mirror);
        if height >= least {
            return normal;
        }
        let raised = (mirror + self.geometric_normal * (least - height)).normalize();
        (self.wo + raised)
            .try_normalize()
            .unwrap_or(self.geometric_normal)
    }

    /// Cosine between the shading normal and `wi` (unit); 0 behind it.
    ///
    /// A smooth surface may be lit from a little below its triangles: rays start where the smooth surface would be, and
    /// where the triangles really are in the way, they are met.
    #[must_use]
    pub fn cosine(&self, wi: Vec3) -> f32 {
        self.shading_normal.dot(wi).max(0.0)
    }

    /// The point as a receiver of light, for a choice among many lights.
    #[must_use]
    pub fn receiver(&self) -> Receiver {
        Receiver {
            position: self.shading_position,
            normal: self.shading_normal,
        }
    }

    /// Of the triangle, on the side of `wo`; unit.
    #[must_use]
    pub fn geometric_normal(&self) -> Vec3 {
        self.geometric_normal
    }

    /// The mirror direction of `wo` about [`Self::specular_normal`].
    #[must_use]
    pub fn mirror_direction(&self) -> Vec3 {
        reflect(self.wo, self.specular_normal)
    }

    /// A ray along `direction`, on the side of the surface that `wo` is on. It can meet the triangle it leaves only where `direction` leads
    /// below that.
    #[must_use]
    pub fn ray_above(&self, direction: Vec3) -> Ray {
        Ray::new(self.start, direction)
    }

    /// [`Self::ray_above`] that ends at `target` where its parameter is 1.
    #[must_use]
    pub fn ray_to(&self, target: Vec3) -> Ray {
        Ray::new(self.start, target - self.start)
    }

    /// [`Self::ray_above`] along each of `directions`, as long as they are.
    #[must_use]
    pub fn fan<'a>(&self, directions: &'a [Vec3]) -> Fan<'a> {
        Fan::new(self.start, self.geometric_normal, directions)
    }

    /// A ray that goes on behind the surface along `direction`, and cannot meet the triangle it leaves.
    #[must_use]
    pub fn ray_through(&self, direction: Vec3) -> Ray {
        Ray::new(self.start_behind(), direction)
    }

    /// [`Self::ray_through`] that ends at `target` where its parameter is 1.
    #[must_use]
    pub fn ray_through_to(&self, target: Vec3) -> Ray {
        let start = self.start_behind();
        Ray::new(start, target - start)
    }

    fn start_behind(&self) -> Vec3 {
        let behind = -self.geometric_normal;
        robust::offset_origin(self.position, self.error, behind, behind)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::control::{CancelToken, Progress};
    use crate::geometry::TriangleMesh;
    use crate::geometry::shapes::{self, Random};
    use crate::scene::{Copies, Object, Scene};

    /// Triangles of size 1 moved by K, a ray from ten away, a bounce to the same side. No bounce may hit
    /// the triangle it left, and the push off the surface stays of the order of the rounding error.
    #[test]
    fn no_ray_hits_the_surface_it_leaves() {
        let mut state = 99_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        #[expect(clippy::cast_possible_truncation, reason = "rays are f32")]
        let narrow = |x: f64| x as f32;
        for k in [0.0, 100.0, 1e4] {
            let mut pushed = 0.0;
            let count = 20_000;
            for _ in 0..count {
                let mut point = || DVec3::new(next(), next(), next());
                let mesh = TriangleMesh {
                    positions: vec![point(), point(), point(), -DVec3::splat(k)],
                    // The degenerate second triangle keeps the origin in the scene, so that centring does not undo K.
                    triangles: vec![[0, 1, 2], [3, 3, 3]],
                    ..TriangleMesh::default()
                };
                let moved = TriangleMesh {
                    positions: mesh
                        .positions
                        .iter()
                        .enumerate()
                        .map(|(i, &p)| if i < 3 { p + k } else { p })
                        .collect(),
                    ..mesh
                };
                let mut scene = Scene::default();
                scene.meshes.insert("t".into(), Arc::new(moved));
                scene.objects.push(Object {
                    mesh: "t".into(),
                    ..Object::default()
                });
                let geometry =
                    PreparedGeometry::prepare(&scene, None, &CancelToken::new(), &Progress::new())
                        .expect("can be rendered")
                        .expect("nobody cancels");
                let [a, b, c] = geometry.triangle(0).in_scene().corners;
                let (u, v) = (narrow(next()), narrow(next()));
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let aim = a * (1.0 - u - v) + b * u + c * v;
                let size = (b - a).length().max((c - a).length());
                let away = Vec3::new(
                    narrow(next()) - 0.5,
                    narrow(next()) - 0.5,
                    narrow(next()) - 0.5,
                )
                .normalize();
                let ray = Ray::new(aim + away * (10.0 * size), -away);
                let Some(hit) = geometry.accelerator().intersect(&ray, f32::INFINITY) else {
                    continue;
                };

                let surface = SurfacePoint::new(&geometry, &ray, &hit);
                let mut wi = Vec3::new(
                    narrow(next()) - 0.5,
                    narrow(next()) - 0.5,
                    narrow(next()) - 0.5,
                )
                .normalize();
                if wi.dot(surface.geometric_normal) < 0.0 {
                    wi = -wi;
                }
                let bounce = surface.ray_above(wi * (20.0 * size));
                assert!(
                    geometry
                        .accelerator()
                        .intersect(&bounce, f32::INFINITY)
                        .is_none(),
                    "K = {k}: {bounce:?}"
                );
                pushed += f64::from((bounce.origin - surface.position).length() / size);
            }
            // Table: 5e-7 at K = 0, 7e-5 at 100, 7.7e-3 at 10⁴ for the bound of seven roundings; ours counts four.
            let mean = pushed / f64::from(count);
            assert!(
                mean < 1e-6 * (1.0 + k),
                "K = {k}: pushed {mean} of the triangle's size"
            );
        }
    }

    /// The same for copies, whose points and rays are rounded on the way between their own space and the scene's: turned,
    /// scaled, mirrored, far from the middle; rays that leave along the surface as well.
    #[test]
    fn no_ray_hits_the_copy_it_leaves() {
        let mut random = Random::new(7);
        let placements = [
            (DVec3::ZERO, 1.0),
            (DVec3::new(90.0, 0.0, 180.0), 1.0),
            (DVec3::new(10.0, -70.0, 33.0), 1.0),
            (DVec3::new(123.0, 5.0, -61.0), 0.37),
            (DVec3::new(-40.0, 80.0, 7.0), -29.0),
        ];
        for ((rotate, scale), k) in placements
            .into_iter()
            .flat_map(|placement| [2.0, 100.0, 1e4].map(|k| (placement, k)))
        {
            let mut scene = Scene::default();
            let mesh = Arc::new(shapes::soup(600, 0.4, 5));
            scene.meshes.insert("t".into(), mesh);
            scene.objects.push(Object {
                mesh: "t".into(),
                rotate,
                scale,
                copies: Copies {
                    count: [2, 2, 3],
                    step: DVec3::new(1.0, -0.7, 0.9) * k * scale,
                },
                ..Object::default()
            });
            let geometry =
                PreparedGeometry::prepare(&scene, None, &CancelToken::new(), &Progress::new())
                    .expect("can be rendered")
                    .expect("nobody cancels");
            let accelerator = geometry.accelerator();
            assert!(accelerator.copies_of(0).is_some());
            let size = geometry.frame().scale() * scale.abs();

            let (mut met, mut pushed) = (0, 0.0);
            for turn in 0..12_000_u32 {
                let aimed_at = geometry.triangle(turn * 7919 % accelerator.triangle_count());
                let [a, b, c] = aimed_at.in_scene().corners.map(Vec3::as_dvec3);
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let aim = a * (1.0 - u - v) + b * u + c * v;
                let away = random.in_cube().normalize();
                let ray = Ray::new((aim + away * (10.0 * size)).as_vec3(), -away.as_vec3());
                let Some(hit) = accelerator.intersect(&ray, f32::INFINITY) else {
                    continue;
                };
                met += 1;
                let surface = SurfacePoint::new(&geometry, &ray, &hit);
                pushed += surface.error.as_dvec3().length() / size;
                let mut wi = random.in_cube().as_vec3().normalize();
                if turn % 2 == 0 {
                    // Along the surface but for a few digits.
                    let height = wi.dot(surface.geometric_normal);
                    wi -= surface.geometric_normal * height * (1.0 - 1e-6);
                }
                let is_above = |wi: Vec3| surface.geometric_normal.dot(wi) > 0.0;
                if !is_above(wi) {
                    wi = -wi;
                }
                if !is_above(wi) {
                    continue;
                }
                for bounce in [surface.ray_above(wi), surface.ray_above(wi * 1e-3)] {
                    let again = accelerator.intersect(&bounce, f32::INFINITY);
                    assert!(
                        again.is_none_or(|again| again.triangle != hit.triangle),
                        "{rotate}, {scale}, {k}: {bounce:?} meets {again:?}"
                    );
                }
            }
            assert!(met > 8000, "only {met} hits");
            let mean = pushed / f64::from(met);
            assert!(
                mean < 2e-6 * (1.0 + k),
                "{rotate}, {scale}, {k}: pushed {mean}"
            );
        }
    }
}
