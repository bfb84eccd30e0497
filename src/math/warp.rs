//! Maps from the unit square to where samples are wanted, each with its density.

use std::f32::consts::{FRAC_PI_4, PI};
use std::hint::select_unpredictable;

use super::{Vec2, Vec3};

/// The unit square onto the unit disk, keeping area ratios and neighbours: density 1/π.
///
/// Source: Shirley & Chiu, A Low Distortion Map Between Disk and Square, 1997.
#[must_use]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let Vec2 { x, y } = 2.0 * u - 1.0;
    let is_wide = x.abs() > y.abs();
    let (radius, other) = (
        select_unpredictable(is_wide, x, y),
        select_unpredictable(is_wide, y, x),
    );
    let ratio = if radius == 0.0 { 0.0 } else { other / radius };
    let (sin, cos) = sin_cos_octant(FRAC_PI_4 * ratio);
    let (along, across) = (radius * cos, radius * sin);
    Vec2::new(
        select_unpredictable(is_wide, along, across),
        select_unpredictable(is_wide, across, along),
    )
}

/// Sine and cosine of an angle within ±π/4, right to the last digit or two: their power series, which need few terms there.
fn sin_cos_octant(angle: f32) -> (f32, f32) {
    const SIN: [f32; 4] = [1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0];
    const COS: [f32; 4] = [1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5];
    let x = angle * angle;
    let x_squared = x * x;
    // Two and two terms, so that half of the steps need not wait for the other half.
    let series = |[a, b, c, d]: [f32; 4]| (a * x + b) * x_squared + (c * x + d);
    (angle + angle * (x * series(SIN)), 1.0 + x * series(COS))
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

/// Density of [`cosine_hemisphere`] turned [`around`] the unit vector `normal`, at the unit vector `w`, per steradian.
#[must_use]
pub fn cosine_pdf_around(normal: Vec3, w: Vec3) -> f32 {
    normal.dot(w).max(0.0) / PI
}

/// The unit square onto a triangle, as weights of its corners, evenly over its area.
///
/// Source: Turk, Generating Random Points in Triangles, Graphics Gems, 1990.
#[must_use]
pub fn triangle(u: Vec2) -> [f32; 3] {
    let root = u.x.sqrt();
    [1.0 - root, root * (1.0 - u.y), root * u.y]
}

/// The unit square onto the lobe about +Z whose density is [`power_cosine_pdf`].
///
/// `1 − cos θ` is formed directly, so that sharp lobes keep their width.
/// Source: Lafortune & Willems, Using the Modified Phong Reflectance Model for Physically Based Rendering, 1994.
#[must_use]
pub fn power_cosine(u: Vec2, exponent: f32) -> Vec3 {
    // cos θ = (1 − u)^(1/(n+1)), in (0, 1].
    let log_cosine = libm::log1pf(-u.x) / (exponent + 1.0);
    let sine = (-libm::expm1f(2.0 * log_cosine)).max(0.0).sqrt();
    let angle = 2.0 * PI * u.y;
    Vec3::new(
        sine * libm::cosf(angle),
        sine * libm::sinf(angle),
        libm::expf(log_cosine),
    )
}

/// Density of [`power_cosine`], per steradian, where the cosine to the axis to the `exponent`-th power is `power`.
#[must_use]
pub fn power_cosine_pdf(power: f32, exponent: f32) -> f32 {
    (exponent + 1.0) / (2.0 * PI) * power
}

/// The unit interval onto itself with a density that runs straight from `from` at 0 to `to` at 1, up to a factor; neither is negative. The
/// density is uniform where both are 0.
///
/// Source: Pharr et al., Physically Based Rendering (4th ed.), section on sampling the linear function.
#[must_use]
pub fn linear(u: f32, from: f64, to: f64) -> f64 {
    let u = f64::from(u);
    let root = (from * from + (to * to - from * from) * u).max(0.0).sqrt();
    if from + root <= 0.0 {
        return u;
    }
    (u * (from + to) / (from + root)).min(1.0)
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

/// A right-handed frame of unit vectors.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    /// The frame of [`tangents`] about the unit vector `normal`, its Z.
    #[must_use]
    pub fn around(normal: Vec3) -> Self {
        let (x, y) = tangents(normal);
        Self { x, y, z: normal }
    }

    /// The vector that is `local` in this frame.
    #[must_use]
    pub fn world_from_local(&self, local: Vec3) -> Vec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}

/// The vector that is `local` in the frame of [`tangents`] about `normal`.
#[must_use]
pub fn around(normal: Vec3, local: Vec3) -> Vec3 {
    Frame::around(normal).world_from_local(local)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: u32 = 100_000;

    /// The R₂ sequence shifted at random would be too even for χ²; a fixed generator of independent points.
    fn points() -> impl Iterator<Item = Vec2> {
        let mut state = 2_024_u64;
        let mut next = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0
        };
        std::iter::repeat_with(move || Vec2::new(next(), next())).take(SAMPLES as usize)
    }

    /// χ² of points that should be even over the unit square, in 10 × 20 cells: 199 degrees of freedom stay below 279 with
    /// probability 0.9998, one in a thousand for five tests together.
    fn assert_even(what: &str, points: impl Iterator<Item = (f32, f32)>) {
        let mut counts = [0_u32; 200];
        for (x, y) in points {
            assert!(
                (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y),
                "{what}: ({x}, {y})"
            );
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "cell indices"
            )]
            let cell = ((x * 10.0) as usize).min(9) * 20 + ((y * 20.0) as usize).min(19);
            counts[cell] += 1;
        }
        let expected = f64::from(SAMPLES) / 200.0;
        let chi_squared: f64 = counts
            .iter()
            .map(|&n| (f64::from(n) - expected).powi(2) / expected)
            .sum();
        assert!(chi_squared < 279.0, "{what}: χ² = {chi_squared}");
    }

    /// The azimuth of a direction as a number in `[0, 1]`.
    fn turn(x: f32, y: f32) -> f32 {
        (y.atan2(x) / (2.0 * PI)).rem_euclid(1.0)
    }

    #[test]
    fn sines_and_cosines_of_small_angles_keep_their_digits() {
        for step in -1000_i16..=1000 {
            let angle = FRAC_PI_4 * f32::from(step) / 1000.0;
            let (sin, cos) = sin_cos_octant(angle);
            let (exact_sin, exact_cos) = f64::from(angle).sin_cos();
            assert!((f64::from(sin) - exact_sin).abs() <= 1.3e-7 * exact_sin.abs());
            assert!((f64::from(cos) - exact_cos).abs() <= 1.3e-7 * exact_cos);
        }
    }

    #[test]
    fn the_disk_is_covered_evenly() {
        assert_even(
            "disk",
            points()
                .map(concentric_disk)
                .map(|p| (p.length_squared(), turn(p.x, p.y))),
        );
    }

    #[test]
    fn the_hemisphere_is_covered_by_the_cosine() {
        // cos² θ is even under a density of cos θ / π.
        assert_even(
            "hemisphere",
            points()
                .map(cosine_hemisphere)
                .map(|w| (w.z * w.z, turn(w.x, w.y))),
        );
        let w = cosine_hemisphere(Vec2::new(0.3, 0.8));
        assert_eq!(cosine_hemisphere_pdf(w).to_bits(), (w.z / PI).to_bits());
        assert_eq!(cosine_hemisphere_pdf(-Vec3::Z).to_bits(), 0);
    }

    #[test]
    fn the_triangle_is_covered_evenly() {
        // The inverse of the map, from the weights: even if and only if the weights are.
        let back = |[a, _, c]: [f32; 3]| {
            (
                (1.0 - a) * (1.0 - a),
                if a < 1.0 { c / (1.0 - a) } else { 0.0 },
            )
        };
        assert_even(
            "triangle",
            points().map(triangle).map(|weights| {
                assert!(
                    (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6
                        && weights.iter().all(|&w| w >= 0.0)
                );
                let (x, y) = back(weights);
                (x, y.min(1.0))
            }),
        );
    }

    /// `1 − cosⁿ⁺¹ θ` is even under the lobe's density. For sharp lobes the cosine is taken from the sine, which has the
    /// digits.
    #[test]
    fn lobes_of_any_sharpness_have_their_width() {
        for exponent in [0.0, 1.0, 50.0, 1e4, 1e7] {
            let even = points().map(|u| power_cosine(u, exponent)).map(|w| {
                let sine_squared = f64::from(w.x).powi(2) + f64::from(w.y).powi(2);
                let log_cosine = if w.z > 0.5 {
                    0.5 * (-sine_squared).ln_1p()
                } else {
                    f64::from(w.z).ln()
                };
                #[expect(clippy::cast_possible_truncation, reason = "a share")]
                let x = -((f64::from(exponent) + 1.0) * log_cosine).exp_m1() as f32;
                (x.clamp(0.0, 1.0), turn(w.x, w.y))
            });
            assert_even(&format!("exponent {exponent}"), even);
        }
    }

    /// By the integral of the density up to the point, which is even.
    #[test]
    fn linear_densities_are_followed() {
        for (from, to) in [
            (1.0, 1.0),
            (0.0, 2.0),
            (3.0, 0.0),
            (1e38, 2.5e38),
            (1e-30, 1.0),
        ] {
            let even = points().map(|u| {
                let x = linear(u.x, from, to);
                let share = (2.0 * from * x + (to - from) * x * x) / (from + to);
                #[expect(clippy::cast_possible_truncation, reason = "a share")]
                let share = share.clamp(0.0, 1.0) as f32;
                (share, u.y)
            });
            assert_even(&format!("from {from} to {to}"), even);
        }
        assert_eq!(linear(0.25, 0.0, 0.0), 0.25);
        assert_eq!(linear(0.0, 0.0, 1.0), 0.0);
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for normal in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::X,
            Vec3::new(1.0, -2.0, 3.0).normalize(),
            Vec3::new(1e-4, 0.0, -1.0).normalize(),
        ] {
            let (x, y) = tangents(normal);
            assert!(
                x.dot(y).abs() < 1e-6 && x.dot(normal).abs() < 1e-6 && y.dot(normal).abs() < 1e-6
            );
            assert!(x.cross(y).abs_diff_eq(normal, 1e-6));
        }
    }
}
