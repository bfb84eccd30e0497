use super::geometry::PreparedGeometry;
use crate::accel::Hit;
use crate::math::{Ray, Vec3, robust};

/// The point where a ray meets a surface, as shading needs it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// From the corners by barycentric weights: far closer to the surface than `origin + t · direction`.
    pub position: Vec3,
    /// Bound on the rounding error of each coordinate of `position`.
    error: Vec3,
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
}

impl SurfacePoint {
    pub fn new(geometry: &PreparedGeometry, ray: &Ray, hit: &Hit) -> Self {
        let [a, b, c] = geometry.triangles()[hit.triangle as usize].corners;
        let [u, v, w] = hit.barycentrics;
        let position = a * u + b * v + c * w;
        // Each coordinate is rounded four times: its weight, the product, two sums.
        let error = ((a * u).abs() + (b * v).abs() + (c * w).abs()) * robust::gamma(4);

        // In f64, so that slivers have a normal too. Edges of f32 corners are exact there but for a last digit.
        let (origin, along_b, along_c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let outward = (along_b - origin)
            .cross(along_c - origin)
            .normalize_or_zero()
            .as_vec3();
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
            wo,
            geometric_normal,
            shading_normal,
            front,
            object,
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

    /// A ray that ends at `target` where its parameter is 1 and that cannot meet the surface it leaves.
    pub fn ray_to(&self, target: Vec3) -> Ray {
        let towards = target - self.position;
        let origin =
            robust::offset_origin(self.position, self.error, self.geometric_normal, towards);
        Ray::new(origin, target - origin)
    }
}
