//! Lengths and directions of vectors whose squares would overflow or vanish.

use super::{DVec3, power_of_two};

/// The unit vector along `v`, however long that is; `None` where it is zero or not finite.
///
/// Has the bits of [`DVec3::try_normalize`] wherever that needs no care.
#[must_use]
pub fn direction_of(v: DVec3) -> Option<DVec3> {
    let (near_one, _) = brought_near_one(v)?;
    near_one.try_normalize()
}

/// The length of `v`, with the bits of [`DVec3::length`] wherever that needs no care; 0 where `v` is zero or not finite.
#[must_use]
pub fn length_of(v: DVec3) -> f64 {
    brought_near_one(v).map_or(0.0, |(near_one, exponent)| {
        libm::ldexp(near_one.length(), exponent)
    })
}

/// `v / 2^exponent`, its largest coordinate near 1, and the exponent.
fn brought_near_one(v: DVec3) -> Option<(DVec3, i32)> {
    let largest = v.abs().max_element();
    if !v.is_finite() || largest == 0.0 {
        return None;
    }
    // Off by a few at the ends of the range, where the power itself would not be a normal number.
    let exponent = libm::frexp(largest).1.clamp(-1022, 1022);
    Some((v * power_of_two(-exponent), exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_has_a_direction_and_powers_of_two_change_no_bit() {
        let v = DVec3::new(0.3, -1.7, 0.05);
        assert_eq!(direction_of(v), v.try_normalize());
        assert_eq!(length_of(v), v.length());
        for exponent in [-900, -600, -300, 300, 600, 1022] {
            let scaled = v * power_of_two(exponent);
            assert_eq!(direction_of(scaled), v.try_normalize(), "2^{exponent}");
            assert_eq!(length_of(scaled), v.length() * power_of_two(exponent));
        }
        for size in [5e-324, 1e-310, 1e-200, 1e300, f64::MAX] {
            assert_eq!(direction_of(DVec3::Y * -size), Some(DVec3::NEG_Y), "{size}");
            assert_eq!(length_of(DVec3::Y * -size), size);
        }
    }

    #[test]
    fn what_is_no_direction_has_none() {
        for wrong in [DVec3::ZERO, DVec3::NAN, DVec3::new(0.0, f64::INFINITY, 1.0)] {
            assert_eq!(direction_of(wrong), None, "{wrong}");
        }
    }
}
