//! Maps from the unit square to where samples are wanted, each with its density.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::{Vec2, Vec3};

/// The unit square onto the unit disk, keeping area ratios and neighbours: density 1/π.
///
/// Source: Shirley & Chiu, A Low Distortion Map Between Disk and Square, 1997.
#[must_use]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let offset = 2.0 * u - 1.0;
    if offset == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if offset.x.abs() > offset.y.abs() {
        (offset.x, FRAC_PI_4 * (offset.y / offset.x))
    } else {
        (offset.y, FRAC_PI_2 - FRAC_PI_4 * (offset.x / offset.y))
    };
    radius * Vec2::new(libm::cosf(angle), libm::sinf(angle))
}

/// The unit square onto the hemisphere about +Z with density [`cosine_hemisphere_pdf`].
///
/// Source: Malley's method; Pharr et al., Physically Based Rendering (4th ed.), appendix on sampling.
#[must_use]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let disk = concentric_disk(u);
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] at the unit vector `w`, per steradian: cos θ / π, and 0 below the surface.
#[must_use]
pub fn cosine_hemisphere_pdf(w: Vec3) -> f32 {
    w.z.max(0.0) / PI
}

/// Two unit vectors that make a right-handed frame with the unit vector `normal` as its Z.
///
/// Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
#[must_use]
pub fn tangents(normal: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        Vec3::new(
            1.0 + sign * normal.x * normal.x * a,
            sign * b,
            -sign * normal.x,
        ),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

/// The vector that is `local` in the frame of [`tangents`] about `normal`.
#[must_use]
pub fn around(normal: Vec3, local: Vec3) -> Vec3 {
    let (x, y) = tangents(normal);
    x * local.x + y * local.y + normal * local.z
}
