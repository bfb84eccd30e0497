//! Reflection and refraction at a smooth boundary between two clear media.

use crate::math::Vec3;

/// What a boundary does with light that meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Share that is reflected, the mean of both polarisations, `0..=1`.
    pub reflectance: f32,
    /// Cosine between the refracted direction and the normal on its side; 0 at total reflection.
    pub cos_transmitted: f32,
}

/// Fresnel's equations for light that arrives at `cos_incident` (`0..=1`) where `eta` is the index of refraction behind the
/// boundary over the one before it, more than 0.
///
/// In a form that is exact at `eta = 1` (no reflection, also at grazing incidence) and monotone at the critical angle.
/// Source: Born & Wolf, Principles of Optics, section on reflection and refraction of a plane wave.
#[must_use]
pub fn fresnel(cos_incident: f32, eta: f32) -> Boundary {
    if eta == 1.0 {
        return Boundary {
            reflectance: 0.0,
            cos_transmitted: cos_incident,
        };
    }
    // In f64: near the critical angle the root's argument is the difference of nearly equal numbers.
    let (cosine, eta) = (f64::from(cos_incident).clamp(0.0, 1.0), f64::from(eta));
    let cos_squared = 1.0 - (1.0 - cosine) * (1.0 + cosine) / (eta * eta);
    if cos_squared <= 0.0 {
        return Boundary {
            reflectance: 1.0,
            cos_transmitted: 0.0,
        };
    }
    let transmitted = cos_squared.sqrt();
    let parallel = (eta * cosine - transmitted) / (eta * cosine + transmitted);
    let perpendicular = (cosine - eta * transmitted) / (cosine + eta * transmitted);
    #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
    Boundary {
        reflectance: (0.5 * (parallel * parallel + perpendicular * perpendicular)) as f32,
        cos_transmitted: transmitted as f32,
    }
}

/// The mirror direction of `wo` about `normal`; both unit, pointing away from the surface.
#[must_use]
pub fn reflect(wo: Vec3, normal: Vec3) -> Vec3 {
    2.0 * normal.dot(wo) * normal - wo
}

/// The direction in which light from `wo` goes on behind the boundary. `normal` is on the side of `wo`; `eta` as in
/// [`fresnel`], whose `cos_transmitted` it takes.
#[must_use]
pub fn refract(wo: Vec3, normal: Vec3, eta: f32, cos_transmitted: f32) -> Vec3 {
    (-wo / eta + (normal.dot(wo) / eta - cos_transmitted) * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reflectance(degrees: f32, eta: f32) -> f32 {
        fresnel(degrees.to_radians().cos(), eta).reflectance
    }

    /// One face, n = 1.5.
    #[test]
    fn reflectance_matches_the_published_table() {
        let table = [
            (0.0, 0.04),
            (30.0, 0.041_522_6),
            (45.0, 0.050_239_9),
            (60.0, 0.089_186_7),
            (75.0, 0.253_060_6),
            (80.0, 0.387_704_4),
            (85.0, 0.612_799_6),
            (89.0, 0.904_184_9),
        ];
        for (degrees, expected) in table {
            let found = reflectance(degrees, 1.5);
            assert!((found - expected).abs() < 3e-6, "{degrees}°: {found}");
        }
        assert!((reflectance(0.0, 1.33) - 0.020_059_3).abs() < 1e-6);
        assert!((reflectance(0.0, 1000.0) - 0.996_008).abs() < 1e-6);
    }

    #[test]
    fn an_index_of_one_is_not_there() {
        for cosine in [0.0, 1e-7, 0.5, 1.0] {
            let boundary = fresnel(cosine, 1.0);
            assert_eq!(
                boundary,
                Boundary {
                    reflectance: 0.0,
                    cos_transmitted: cosine
                }
            );
        }
    }

    /// Nothing breaks and reflectance only grows around the critical angle.
    #[test]
    fn the_critical_angle_is_crossed_smoothly() {
        let eta = 1.0_f32 / 1.5;
        let mut cosine = (1.0 - eta * eta).sqrt();
        for _ in 0..1000 {
            cosine = cosine.next_up();
        }
        let mut previous = 0.0;
        for _ in 0..2000 {
            let found = fresnel(cosine, eta).reflectance;
            assert!(found.is_finite() && (0.0..=1.0).contains(&found) && found >= previous - 1e-3);
            previous = found;
            cosine = cosine.next_down();
        }
        assert_eq!(previous.to_bits(), 1.0_f32.to_bits());
    }

    #[test]
    fn refraction_obeys_snell() {
        let normal = Vec3::Z;
        for (degrees, eta) in [
            (10.0_f32, 1.5_f32),
            (70.0, 1.5),
            (30.0, 1.0 / 1.5),
            (80.0, 2.4),
        ] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let wo = Vec3::new(sine, 0.0, cosine);
            let wi = refract(wo, normal, eta, fresnel(cosine, eta).cos_transmitted);
            assert!(
                (wi.x + sine / eta).abs() < 1e-6 && wi.z < 0.0,
                "{degrees}°: {wi}"
            );
            assert!((wi.length() - 1.0).abs() < 1e-6);
        }
    }

    /// Where a ray parallel to the axis of an exact unit ball crosses it: published values, and their closed form.
    #[test]
    fn a_ball_bends_rays_to_where_geometry_says() {
        let table = [
            (1.5, 0.001, 1.499_999_6),
            (1.5, 0.3, 1.461_978_4),
            (1.5, 0.7, 1.277_787),
            (1.33, 0.1, 2.008_183_2),
            (1.33, 0.5, 1.832_368_4),
            (2.0, 0.1, 0.998_750_8),
            (2.0, 0.7, 0.943_733_9),
        ];
        for (ior, height, expected) in table {
            let enter = Vec3::new(height, 0.0, -(1.0_f32 - height * height).sqrt());
            let wo = -Vec3::Z;
            let boundary = fresnel(enter.dot(wo), ior);
            let inside = refract(wo, enter, ior, boundary.cos_transmitted);
            let leave = enter - inside * (2.0 * enter.dot(inside));
            let boundary = fresnel(leave.dot(inside), 1.0 / ior);
            let outside = refract(-inside, -leave, 1.0 / ior, boundary.cos_transmitted);
            let crossing = leave.z - leave.x / outside.x * outside.z;
            // Heights near the axis leave few digits of the crossing in f32.
            let tolerance = 1e-6 + 2e-7 / height;
            assert!(
                (crossing - expected).abs() < tolerance * 4.0,
                "n {ior}, height {height}: {crossing}"
            );
        }
    }
}
