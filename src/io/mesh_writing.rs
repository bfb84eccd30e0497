//! What writers of mesh formats share: numbers in text, and colours as screens know them.

use crate::math::DVec3;
use crate::math::color::{linear_from_srgb, srgb_from_linear};
use std::fmt::{self, Display, Formatter};

/// Numbers in text with spaces between them, each the shortest that reads back as the same `f64`.
pub struct Decimals<'a>(pub &'a [f64]);

impl Display for Decimals<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        for (index, &value) in self.0.iter().enumerate() {
            if index > 0 {
                out.write_str(" ")?;
            }
            write_number(value, out)?;
        }
        Ok(())
    }
}

/// Writes a number; plain digits would be hundreds long for the extreme ones.
fn write_number(value: f64, out: &mut Formatter<'_>) -> fmt::Result {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) {
        write!(out, "{value}")
    } else {
        write!(out, "{value:e}")
    }
}

/// Whether `f32` holds all these numbers as they are.
pub fn fit_f32<'a>(vectors: impl IntoIterator<Item = &'a DVec3>) -> bool {
    let mut vectors = vectors.into_iter();
    vectors.all(|vector| vector.as_vec3().as_dvec3() == *vector)
}

/// The byte that stands for a linear value in sRGB, where one stands for exactly that.
pub fn srgb_byte(linear: f32) -> Option<u8> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 255"
    )]
    let byte = (srgb_from_linear(linear) * 255.0).round() as u8;
    (linear_from_srgb(f32::from(byte) / 255.0) == linear).then_some(byte)
}

/// A linear value in sRGB, from 0 to 1, that reads back as the same where any `f32` does, as it does for all that came from a file.
pub fn encoded(linear: f32) -> f32 {
    /// Neighbours that are tried: rounding there and back moves a value by less.
    const MOST_STEPS: usize = 8;
    if let Some(byte) = srgb_byte(linear) {
        return f32::from(byte) / 255.0;
    }
    let nearest = srgb_from_linear(linear);
    let above = std::iter::successors(Some(nearest), |value| Some(value.next_up()));
    let below = std::iter::successors(Some(nearest), |value| Some(value.next_down()));
    let mut tried = above.take(MOST_STEPS).chain(below.take(MOST_STEPS));
    let exact = tried.find(|&value| linear_from_srgb(value) == linear);
    exact.unwrap_or(nearest)
}
