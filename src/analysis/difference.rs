//! Pictures of where two pictures differ.

use super::metrics::{SizesDiffer, check_sizes, is_finite};
use crate::render::Image;

/// What marks a pixel that is not finite in one of the pictures: magenta.
const NO_DIFFERENCE: [f32; 3] = [1.0, 0.0, 1.0];

/// A − B, with its sign, as it comes out: infinite and not a number too.
///
/// # Errors
/// When the sizes differ.
pub fn signed_difference(a: &Image, b: &Image) -> Result<Image, SizesDiffer> {
    per_pixel(a, b, |a, b| std::array::from_fn(|i| a[i] - b[i]))
}

/// |A − B| per channel, so bright that a difference of `white` is 1; what is larger is more than 1. A pixel with a value that
/// is not finite is magenta.
///
/// `white`: above 0.
///
/// # Errors
/// When the sizes differ.
pub fn scaled_difference(a: &Image, b: &Image, white: f64) -> Result<Image, SizesDiffer> {
    #[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
    let scaled = |a: f32, b: f32| ((f64::from(a) - f64::from(b)).abs() / white) as f32;
    per_pixel(a, b, |a, b| {
        if is_finite(a) && is_finite(b) {
            std::array::from_fn(|i| scaled(a[i], b[i]))
        } else {
            NO_DIFFERENCE
        }
    })
}

fn per_pixel(
    a: &Image,
    b: &Image,
    pixel: impl Fn([f32; 3], [f32; 3]) -> [f32; 3],
) -> Result<Image, SizesDiffer> {
    check_sizes(a, b)?;
    let pairs = a.pixels.iter().zip(&b.pixels);
    Ok(Image {
        width: a.width,
        height: a.height,
        pixels: pairs.map(|(&a, &b)| pixel(a, b)).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_signed_or_scaled_and_marked() {
        let image = |pixels: [[f32; 3]; 2]| Image {
            width: 2,
            height: 1,
            pixels: pixels.to_vec(),
        };
        let a = image([[1.0, 0.25, 7.0], [0.0, f32::INFINITY, 0.0]]);
        let b = image([[0.5, 0.5, 7.0], [0.0, 0.0, 2.0]]);
        let signed = signed_difference(&a, &b).expect("are of one size");
        assert_eq!(
            signed.pixels,
            [[0.5, -0.25, 0.0], [0.0, f32::INFINITY, -2.0]]
        );
        let scaled = scaled_difference(&a, &b, 0.25).expect("are of one size");
        assert_eq!(scaled.pixels, [[2.0, 1.0, 0.0], [1.0, 0.0, 1.0]]);
        let other = Image::black(1, 2);
        assert!(signed_difference(&a, &other).is_err());
        assert!(scaled_difference(&other, &b, 1.0).is_err());
    }
}
