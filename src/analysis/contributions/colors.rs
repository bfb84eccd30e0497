//! Changes as colours: black where nothing changes, warm where it is brighter, cold where it is darker, the brighter the larger.

use crate::render::Image;

/// Nothing changes.
const SAME: [u8; 3] = [0x12, 0x12, 0x14];
/// The two colours of each sign, half-way and at the end of the scale: as bright as each other, so that size reads without colours.
const BRIGHTER_HALF: [u8; 3] = [0xb0, 0x58, 0x14];
const DARKER_HALF: [u8; 3] = [0x1c, 0x66, 0xc0];
/// The colour of the largest change to more light.
pub const BRIGHTER: [u8; 3] = [0xff, 0xd0, 0x70];
/// The colour of the largest change to less light.
pub const DARKER: [u8; 3] = [0x86, 0xdc, 0xff];
/// A pixel that is not finite with or without.
const NOT_FINITE: [u8; 3] = [0xff, 0x00, 0xff];

/// One pixel in so many may lie beyond the scale.
const PIXELS_PER_OUTLIER: usize = 100;

/// The change of the channel that changes most, with its sign; NaN where one of them is not finite.
pub(super) fn largest_channel(change: [f32; 3]) -> f32 {
    if !change.into_iter().all(f32::is_finite) {
        return f32::NAN;
    }
    let [first, rest @ ..] = change;
    let larger = |a: f32, b: f32| if b.abs() > a.abs() { b } else { a };
    rest.into_iter().fold(first, larger)
}

/// The size of a change that has the last colour: what one pixel in a hundred exceeds, or the largest where all but a few are the same;
/// 0 where nothing changes.
#[must_use]
pub fn scale_of(change: &Image) -> f32 {
    let sizes = change.pixels.iter().map(|&pixel| largest_channel(pixel));
    let sizes = sizes.filter(|size| size.is_finite()).map(f32::abs);
    let mut sizes: Vec<f32> = sizes.collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let rank = sizes.len() - 1 - sizes.len() / PIXELS_PER_OUTLIER;
    let (_, &mut usual, beyond) = sizes.select_nth_unstable_by(rank, f32::total_cmp);
    if usual > 0.0 {
        usual
    } else {
        beyond.iter().copied().fold(0.0, f32::max)
    }
}

/// The sRGB colour of a pixel's change on a scale that ends at `scale`.
#[must_use]
pub fn color(change: [f32; 3], scale: f32) -> [u8; 3] {
    let change = largest_channel(change);
    if change.is_nan() {
        NOT_FINITE
    } else if change == 0.0 {
        SAME
    } else {
        // A scale of 0 goes with a change of 0, or is not that of this picture.
        color_of_share(if scale > 0.0 {
            change / scale
        } else {
            change.signum()
        })
    }
}

/// The sRGB colour of a change as a share of the scale, −1 to 1; what lies beyond has the last colour.
#[must_use]
pub fn color_of_share(share: f32) -> [u8; 3] {
    let [half, end] = if share < 0.0 {
        [DARKER_HALF, DARKER]
    } else {
        [BRIGHTER_HALF, BRIGHTER]
    };
    let size = share.abs().min(1.0);
    if size < 0.5 {
        between(SAME, half, 2.0 * size)
    } else {
        between(half, end, 2.0 * size - 1.0)
    }
}

fn between(from: [u8; 3], to: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|channel| {
        let [from, to] = [from, to].map(|color| f32::from(color[channel]));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two bytes"
        )]
        let byte = (from + (to - from) * share).round() as u8;
        byte
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_changes_are_brighter_whatever_their_sign() {
        let brightness = |share: f32| {
            let [r, g, b] = color_of_share(share).map(u32::from);
            2 * r + 7 * g + b
        };
        for sign in [-1.0, 1.0] {
            let steps: Vec<u32> = (0..=20_u8)
                .map(|i| brightness(sign * f32::from(i) / 20.0))
                .collect();
            assert!(steps.is_sorted(), "{steps:?}");
            assert!(steps[20] > 4 * steps[0]);
        }
        let [warm, _, blue] = color_of_share(0.6);
        assert!(warm > blue);
        let [red, _, cold] = color_of_share(-0.6);
        assert!(cold > red);
        assert_eq!(color_of_share(7.0), BRIGHTER);
        assert_eq!(color_of_share(f32::NEG_INFINITY), DARKER);
    }

    #[test]
    fn the_channel_that_changes_most_tells_and_what_is_not_finite_is_marked() {
        assert_eq!(color([0.5, -2.0, 1.0], 2.0), DARKER);
        assert_eq!(color([2.0, -0.5, 1.0], 2.0), BRIGHTER);
        assert_eq!(color([0.0; 3], 2.0), SAME);
        assert_eq!(color([0.0; 3], 0.0), SAME);
        assert_eq!(color([0.0, f32::NAN, 1.0], 2.0), NOT_FINITE);
        assert_eq!(color([f32::INFINITY, 0.0, 0.0], 2.0), NOT_FINITE);
    }

    #[test]
    fn one_pixel_in_a_hundred_is_off_the_scale_unless_only_that_changes() {
        let image = |pixels: Vec<[f32; 3]>| Image {
            width: u32::try_from(pixels.len()).unwrap(),
            height: 1,
            pixels,
        };
        let mut pixels: Vec<[f32; 3]> = (0..200_u16).map(|i| [0.0, -f32::from(i), 0.0]).collect();
        pixels.push([f32::NAN; 3]);
        assert_eq!(scale_of(&image(pixels)), 197.0);
        let mut pixels = vec![[0.0; 3]; 300];
        pixels[17] = [0.0, 0.25, -0.5];
        assert_eq!(scale_of(&image(pixels)), 0.5);
        assert_eq!(scale_of(&image(vec![[0.0; 3]; 4])), 0.0);
        assert_eq!(scale_of(&Image::default()), 0.0);
    }
}
