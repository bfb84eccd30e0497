//! From world units (`f64`) to prepared units: centred on the origin, and scaled by a power of two to about 1.

use super::{DBounds, DVec3, Vec3};

/// `2^exponent`, exactly, for exponents of normal numbers.
///
/// # Panics
/// When `exponent` is outside `-1022..=1023`.
#[must_use]
pub fn power_of_two(exponent: i32) -> f64 {
    assert!(
        (-1022..=1023).contains(&exponent),
        "2^{exponent} is not a normal f64"
    );
    f64::from_bits(u64::try_from(1023 + exponent).expect("the range is checked above") << 52)
}

/// The map between the world of the description and the prepared scene: `prepared = (world − center) · 2^exponent`.
///
/// The prepared scene is centred on the origin and its largest half extent lies in [½, 1). Subtracting in `f64` before
/// narrowing keeps the digits of a scene that lies far out; scaling by an exact power of two makes every result
/// independent of the scene's unit, bit for bit, under scalings by powers of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneFrame {
    center: DVec3,
    exponent: i32,
}

impl SceneFrame {
    /// The frame for objects inside `bounds`: the identity for empty bounds, no scaling for a single point.
    #[must_use]
    pub fn around(bounds: &DBounds) -> Self {
        if bounds.is_empty() {
            return Self {
                center: DVec3::ZERO,
                exponent: 0,
            };
        }
        let half_extent = (bounds.size() * 0.5).max_element();
        let exponent = if half_extent > 0.0 {
            // frexp: half_extent = mantissa · 2^e with the mantissa in [½, 1). The clamp keeps squares of the scale finite.
            -libm::frexp(half_extent).1.clamp(-500, 500)
        } else {
            0
        };
        Self {
            center: bounds.center(),
            exponent,
        }
    }

    /// Prepared units per world unit, a power of two.
    #[must_use]
    pub fn scale(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// The prepared position of a world point, before narrowing.
    #[must_use]
    pub fn prepared_from_world(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale()
    }

    /// The prepared position of a world point, rounded to `f32`.
    #[must_use]
    pub fn narrow(&self, point: DVec3) -> Vec3 {
        self.prepared_from_world(point).as_vec3()
    }

    /// The world position of a prepared point.
    #[must_use]
    pub fn world_from_prepared(&self, point: DVec3) -> DVec3 {
        point / self.scale() + self.center
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(min: DVec3, max: DVec3) -> SceneFrame {
        SceneFrame::around(&DBounds { min, max })
    }

    #[test]
    fn powers_of_two_are_exact() {
        for exponent in [-1022, -20, -1, 0, 1, 52, 1023] {
            assert_eq!(
                power_of_two(exponent).to_bits(),
                libm::ldexp(1.0, exponent).to_bits()
            );
        }
    }

    #[test]
    fn the_largest_half_extent_lies_between_a_half_and_one() {
        for size in [1e-300, 1e-20, 0.3, 0.5, 1.0, 2.0, 1e20, 1e100] {
            let frame = around(DVec3::ZERO, DVec3::new(size, size / 3.0, 0.0));
            let half = size / 2.0 * frame.scale();
            if (1e-100..1e100).contains(&size) {
                assert!((0.5..1.0).contains(&half), "size {size}: {half}");
            }
            assert!(half.is_finite());
        }
    }

    #[test]
    fn scaling_the_world_by_a_power_of_two_changes_no_prepared_bit() {
        let (min, max) = (DVec3::new(0.1, -3.7, 2.0), DVec3::new(11.3, 5.9, 2.5));
        let point = DVec3::new(4.123_456_789, 0.3, 2.2);
        let base = around(min, max).narrow(point);
        for exponent in [-60, -20, -1, 1, 20, 60] {
            let s = power_of_two(exponent);
            assert_eq!(around(min * s, max * s).narrow(point * s), base);
        }
    }

    #[test]
    fn the_way_back_returns_the_point() {
        let frame = around(DVec3::splat(1e7), DVec3::splat(1e7 + 2.0));
        let point = DVec3::new(1e7 + 0.25, 1e7 + 1.5, 1e7);
        assert_eq!(
            frame.world_from_prepared(frame.prepared_from_world(point)),
            point
        );
    }
}
