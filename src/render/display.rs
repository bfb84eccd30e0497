//! From linear radiance to what a screen shows: exposure, tone curve, gamma, sRGB, in this order, quantised once at the end.

use crate::math::{Vec3, color::srgb_from_linear};
use crate::scene::{Display, ToneCurve};

/// The sRGB-encoded value of a linear one, `0..=1` per channel.
#[must_use]
pub fn encode(rgb: [f32; 3], display: &Display) -> [f32; 3] {
    let exposed = Vec3::from_array(rgb) * exposure_factor(display);
    let toned = match display.tone_curve {
        ToneCurve::None => exposed,
        ToneCurve::Aces => exposed.map(aces),
    };
    let exponent = 1.0 / display.gamma;
    let bent = |value: f32| {
        if exponent == 1.0 {
            value
        } else {
            raised(value, exponent)
        }
    };
    toned.to_array().map(|value| srgb_from_linear(bent(value)))
}

/// [`encode`] in 8 bits per channel, rounded to nearest.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "encoded values are in 0..=1"
)]
pub fn encode_8(rgb: [f32; 3], display: &Display) -> [u8; 3] {
    encode(rgb, display).map(|value| (value * 255.0 + 0.5) as u8)
}

/// [`encode`] in 16 bits per channel, rounded to nearest.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "encoded values are in 0..=1"
)]
pub fn encode_16(rgb: [f32; 3], display: &Display) -> [u16; 3] {
    encode(rgb, display).map(|value| (value * 65_535.0 + 0.5) as u16)
}

/// What radiance is multiplied by.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
pub fn exposure_factor(display: &Display) -> f32 {
    libm::exp2(display.exposure) as f32
}

/// A value raised to `exponent`, in `0..=1` before and after; NaN becomes 0.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
#[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
fn raised(value: f32, exponent: f64) -> f32 {
    libm::pow(value.max(0.0).min(1.0).into(), exponent) as f32
}

/// The value on a filmic curve; NaN becomes 0.
///
/// Source: Narkowicz, ACES Filmic Tone Mapping Curve, 2015: a rational fit of the ACES output transform.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
fn aces(x: f32) -> f32 {
    // Beyond a million the curve is flat, and squares stay finite.
    let x = x.max(0.0).min(1e6);
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_is_in_stops() {
        let brighter = Display {
            exposure: 1.0,
            ..Display::default()
        };
        assert_eq!(
            encode([0.25; 3], &brighter),
            encode([0.5; 3], &Display::default())
        );
        assert_eq!(
            encode_8([1.0, 0.0, 0.5], &Display::default()),
            [255, 0, 188]
        );
    }

    #[test]
    fn every_value_encodes_into_range() {
        let curves = [ToneCurve::None, ToneCurve::Aces];
        let kinds = curves.map(|curve| [0.1, 1.0, 10.0].map(|gamma| (curve, gamma)));
        for (tone_curve, gamma) in kinds.into_iter().flatten() {
            let display = Display {
                exposure: 0.0,
                tone_curve,
                gamma,
            };
            for value in [-1.0, 0.0, 1e-30, 1.0, 1e30, f32::INFINITY, f32::NAN] {
                let [encoded, ..] = encode([value; 3], &display);
                assert!(
                    (0.0..=1.0).contains(&encoded),
                    "{tone_curve:?} {gamma} {value}: {encoded}"
                );
            }
        }
    }

    #[test]
    fn gamma_brightens_what_is_between_black_and_white() {
        let squared = Display {
            gamma: 0.5,
            ..Display::default()
        };
        let root = Display {
            gamma: 2.0,
            ..Display::default()
        };
        let plain = Display::default();
        // Squares and roots of these are exact.
        assert_eq!(
            encode([0.5, 0.25, 1.0], &squared),
            encode([0.25, 0.0625, 1.0], &plain)
        );
        assert_eq!(
            encode([0.25, 0.0625, 0.0], &root),
            encode([0.5, 0.25, 0.0], &plain)
        );
    }
}
