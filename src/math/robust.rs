//! Error bounds and offsets for rays that start on a surface. No absolute epsilon appears here: every bound follows from
//! the sizes of the numbers that were rounded.

use super::Vec3;

/// Bound on the relative error of `n` chained `f32` operations: `n·u / (1 − n·u)` with `u = 2⁻²⁴`.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms; used for ray tracing by Pharr et al., Physically Based
/// Rendering (4th ed.), section on managing rounding error.
#[must_use]
pub const fn gamma(n: u32) -> f32 {
    const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;
    #[expect(clippy::cast_precision_loss, reason = "n counts a few operations")]
    let n_u = n as f32 * UNIT_ROUNDOFF;
    n_u / (1.0 - n_u)
}

/// Moves `point` along `normal` to the side `direction` points to, just beyond the box `point ± error` in which the true
/// surface point lies, so that a ray from there cannot meet the surface it left.
///
/// `normal`: the geometric normal, unit length. `error`: per-coordinate absolute bound.
/// Source: Pharr et al., Physically Based Rendering (4th ed.), section on robust spawned ray origins.
#[must_use]
#[inline]
pub fn offset_origin(point: Vec3, error: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    let distance = normal.abs().dot(error + point.abs() * gamma(2)) * AS_COMPUTED;
    point + normal * (distance + f32::MIN_POSITIVE).copysign(normal.dot(direction))
}

/// By how much more than `distance` one has to go to have gone as far, with u the unit roundoff and beside u |point| per
/// coordinate for rounding the sum: 3u for the length of a rounded normal, 2u for the product and the sum, 5u for computing the
/// distance; the rest is for terms of second order.
const AS_COMPUTED: f32 = 1.0 + 8.0 * f32::EPSILON;

/// `cosine` raised to `exponent` for a cosine given as the half squared chord `q = |a − b|²/2 = 1 − cos`, which keeps the
/// digits that `1 − q` would lose near the peak of a sharp lobe: `exp(exponent · ln(1 − q))`.
///
/// Returns 0 for `q ≥ 1` (the far hemisphere of the lobe).
#[must_use]
pub fn sharp_power(q: f32, exponent: f32) -> f32 {
    if q >= 1.0 {
        0.0
    } else {
        #[cfg(test)]
        POWERS.set(POWERS.get() + 1);
        libm::expf(exponent * libm::log1pf(-q))
    }
}

#[cfg(test)]
thread_local! {
    /// The powers that [`sharp_power`] took, for tests of what is left out.
    pub static POWERS: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_leaves_the_error_box_on_the_side_of_the_ray() {
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        for magnitude in [1e-10_f32, 1.0, 1e6] {
            let point = Vec3::new(0.3, -1.0, 0.7) * magnitude;
            let error = point.abs() * gamma(7);
            for direction in [normal, -normal] {
                let origin = offset_origin(point, error, normal, direction);
                let distance = (origin - point).as_dvec3().dot(direction.as_dvec3());
                assert!(
                    distance >= f64::from(normal.abs().dot(error)) * 0.999,
                    "{magnitude}: {distance}"
                );
            }
        }
    }

    /// References: the half-power angle of cosⁿ at n = 1e7, where a power of an f32 cosine is off by half.
    #[test]
    fn sharp_power_is_right_at_exponent_ten_million() {
        for exponent in [1e4_f64, 1e6, 1e7] {
            let cosine = libm::pow(0.5, 1.0 / exponent);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "narrowing the inputs is what is tested"
            )]
            let value = sharp_power((1.0 - cosine) as f32, exponent as f32);
            assert!((value - 0.5).abs() < 1e-5, "{exponent}: {value}");
        }
        assert_eq!(sharp_power(1.0, 0.0).to_bits(), 0);
    }
}
