//! Linear RGB to what a screen shows.

use super::Vec3;

/// Rec. 709 luminance of a linear RGB value.
#[must_use]
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// The sRGB transfer curve: linear `0..=1` to encoded `0..=1`; values outside are clamped, NaN becomes 0.
///
/// Source: IEC 61966-2-1.
#[must_use]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let x = clamp_to_unit(linear);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * libm::powf(x, 1.0 / 2.4) - 0.055
    }
}

/// The inverse of [`srgb_from_linear`].
#[must_use]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    let x = clamp_to_unit(encoded);
    if x <= 0.040_45 {
        x / 12.92
    } else {
        libm::powf((x + 0.055) / 1.055, 2.4)
    }
}

/// The value clamped to `0..=1`; unlike `f32::clamp`, NaN becomes 0.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
fn clamp_to_unit(value: f32) -> f32 {
    value.max(0.0).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_and_is_monotone() {
        let mut previous = -1.0;
        for step in 0..=1000_u16 {
            let x = f32::from(step) / 1000.0;
            let encoded = srgb_from_linear(x);
            assert!(encoded > previous);
            assert!((linear_from_srgb(encoded) - x).abs() < 2e-6);
            previous = encoded;
        }
        assert_eq!(srgb_from_linear(f32::NAN).to_bits(), 0);
        assert!((srgb_from_linear(f32::INFINITY) - 1.0).abs() < 1e-6);
    }

    /// Published value: linear 0.5 is sRGB 188/255.
    #[test]
    fn middle_grey_is_188() {
        assert_eq!(
            (srgb_from_linear(0.5) * 255.0).round().to_bits(),
            188.0_f32.to_bits()
        );
    }
}
