use super::fresnel::reflect;
use super::geometry::PreparedGeometry;
use super::light_tree::Receiver;
use crate::accel::Hit;
use crate::math::{Ray, Vec3, robust};

/// The point where a ray meets a surface, as shading needs it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// From the corners by barycentric weights: far closer to the surface than `origin + t · direction`.
    pub position: Vec3,
    /// Bound on the rounding error of each coordinate of `position`.
    error: Vec3,
    /// From the ray's origin, in prepared units; camera rays start a way from the eye.
    pub distance: f32,
    /// Towards where the ray came from; unit.
    pub wo: Vec3,
    /// Of the triangle, on the side of `wo`; unit. It decides sides and offsets.
    geometric_normal: Vec3,
    /// Interpolated where the object is smooth, on the side of the surface that `wo` is on; unit. It decides cosines.
    pub shading_normal: Vec3,
    /// Whether the ray met the side that the triangle's corners turn counter-clockwise on.
    pub front: bool,
    /// Index of the object in the description.
    pub object: usize,
    /// Number of the triangle.
    pub triangle: u32,
}

impl SurfacePoint {
    pub fn new(geometry: &PreparedGeometry, ray: &Ray, hit: &Hit) -> Self {
        let triangle = &geometry.triangles()[hit.triangle as usize];
        let [u, v, w] = hit.barycentrics;
        let (position, error) = triangle.point(hit.barycentrics);
        let outward = triangle.normal();
        let wo = -ray.direction.normalize();
        let front = outward.dot(wo) >= 0.0;
        let geometric_normal = if front { outward } else { -outward };

        let object = geometry.object_of(hit.triangle);
        let interpolated = geometry.objects()[object]
            .normal_corners(hit.triangle)
            .map(|[na, nb, nc]| na * u + nb * v + nc * w);
        let shading_normal = match interpolated.and_then(Vec3::try_normalize) {
            Some(normal) if normal.dot(geometric_normal) < 0.0 => -normal,
            Some(normal) => normal,
            None => geometric_normal,
        };
        Self {
            position,
            error,
            distance: hit.t * ray.direction.length(),
            wo,
            geometric_normal,
            shading_normal,
            front,
            object,
            triangle: hit.triangle,
        }
    }

    /// The point as one that light is wanted at.
    pub fn receiver(&self) -> Receiver {
        Receiver {
            position: self.position,
            normal: self.shading_normal,
        }
    }

    /// Cosine between the shading normal and `wi` (unit); 0 where `wi` leaves to the other side of the surface.
    pub fn cosine(&self, wi: Vec3) -> f32 {
        if self.geometric_normal.dot(wi) > 0.0 {
            self.shading_normal.dot(wi).max(0.0)
        } else {
            0.0
        }
    }

    /// Of the triangle, on the side of `wo`; unit.
    pub fn geometric_normal(&self) -> Vec3 {
        self.geometric_normal
    }

    /// The normal for mirrors and glass: the shading normal, but the geometric one where reflection about that would lead
    /// into the surface.
    pub fn specular_normal(&self) -> Vec3 {
        let normal = self.shading_normal;
        if normal.dot(self.wo) > 0.0 && self.is_above(reflect(self.wo, normal)) {
            normal
        } else {
            self.geometric_normal
        }
    }

    /// Whether `wi` leaves to the side of the surface that `wo` is on.
    pub fn is_above(&self, wi: Vec3) -> bool {
        self.geometric_normal.dot(wi) > 0.0
    }

    /// A ray along `direction` that cannot meet the surface it leaves.
    pub fn ray_along(&self, direction: Vec3) -> Ray {
        let origin =
            robust::offset_origin(self.position, self.error, self.geometric_normal, direction);
        Ray::new(origin, direction)
    }

    /// A ray that ends at `target` where its parameter is 1 and that cannot meet the surface it leaves.
    pub fn ray_to(&self, target: Vec3) -> Ray {
        let towards = target - self.position;
        let origin =
            robust::offset_origin(self.position, self.error, self.geometric_normal, towards);
        Ray::new(origin, target - origin)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::control::CancelToken;
    use crate::geometry::TriangleMesh;
    use crate::math::DVec3;
    use crate::scene::{Object, Scene};

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
                    normals: None,
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
                let geometry = PreparedGeometry::prepare(&scene, None, &CancelToken::new())
                    .expect("can be rendered")
                    .expect("nobody cancels");
                let [a, b, c] = geometry.triangles()[0].corners;
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
                let bounce = surface.ray_to(surface.position + wi * (20.0 * size));
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
}
