//! The error of each pixel as colours: dark blue where there is none, up to yellow.
//!
//! Errors are small and differ by orders of magnitude between scenes, so the scale is that of the picture itself; the legend
//! says what it is.

use egui::{Color32, Rect, Ui};

use super::legend::Legend;
use super::widgets::format_number;
use crate::render::Image;

/// From no error to the largest on the scale, each brighter than the one before, so that it also reads without colours.
const COLORS: [[u8; 3]; 5] = [
    [0x0a, 0x0e, 0x3a],
    [0x2a, 0x48, 0x9a],
    [0x2f, 0x8f, 0x9c],
    [0x8f, 0xc0, 0x5a],
    [0xfd, 0xe9, 0x4b],
];

/// Where it is unknown: grey, as none of the others is.
const UNKNOWN: Color32 = Color32::from_gray(0x60);

/// One pixel in so many may lie beyond the scale.
const PIXELS_PER_OUTLIER: usize = 100;

/// The error of a pixel: that of its worst channel; not a number where it is unknown, which it then is in all of them.
fn worst_channel(rgb: [f32; 3]) -> f32 {
    rgb[0].max(rgb[1]).max(rgb[2])
}

/// The error that has the last colour: what one pixel in a hundred exceeds; 0 where there is no error at all.
#[must_use]
pub fn scale_of(errors: &Image) -> f32 {
    let mut worst: Vec<f32> = errors
        .pixels
        .iter()
        .map(|&rgb| worst_channel(rgb))
        .collect();
    worst.retain(|error| error.is_finite());
    if worst.is_empty() {
        return 0.0;
    }
    let rank = worst.len() - 1 - worst.len() / PIXELS_PER_OUTLIER;
    *worst.select_nth_unstable_by(rank, f32::total_cmp).1
}

/// The colour of a pixel's error on a scale that ends at `scale`.
#[must_use]
pub fn color(rgb: [f32; 3], scale: f32) -> Color32 {
    if worst_channel(rgb).is_nan() {
        return UNKNOWN;
    }
    color_of_share(share(rgb, scale))
}

/// Where a pixel's error lies on a scale that ends at `scale`, `0..=1`.
#[must_use]
pub fn share(rgb: [f32; 3], scale: f32) -> f32 {
    let error = worst_channel(rgb);
    if error > 0.0 && scale > 0.0 {
        (error / scale).min(1.0)
    } else {
        0.0
    }
}

fn color_of_share(share: f32) -> Color32 {
    let place = share * (COLORS.len() - 1) as f32;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 0 and less than the number of colours"
    )]
    let index = (place as usize).min(COLORS.len() - 2);
    let [from, to] =
        [index, index + 1].map(|i| Color32::from_rgb(COLORS[i][0], COLORS[i][1], COLORS[i][2]));
    from.lerp_to_gamma(to, place - index as f32)
}

/// Draws what the colours mean into the lower left corner of the picture in `frame`.
pub fn legend_ui(ui: &Ui, frame: Rect, scale: f32) {
    let most = format!("{} W/m²/sr or more", format_number(f64::from(scale), 4));
    let legend = Legend {
        start: "Error 0",
        end: &most,
        marks: &[],
        name: format!("Error up to {most}"),
        explanation: "Colours of the error of each pixel, in its worst channel, averaged over the pixels around it. One pixel in a hundred \
             lies beyond the scale. Grey: unknown",
    };
    legend.show_ui(ui, frame, color_of_share);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pixel_in_a_hundred_is_off_the_scale() {
        let mut pixels: Vec<[f32; 3]> = (0..200_u16).map(|i| [0.0, f32::from(i), 0.0]).collect();
        pixels.push([f32::NAN; 3]);
        let errors = Image {
            width: 201,
            height: 1,
            pixels,
        };
        assert_eq!(scale_of(&errors), 197.0);
        assert_eq!(color([0.0, 500.0, 0.0], 197.0), color_of_share(1.0));
    }

    #[test]
    fn larger_errors_are_brighter_and_nothing_breaks() {
        let brightness = |share: f32| {
            let [r, g, b, _] = color([share, 0.0, 0.0], 1.0).to_array();
            u32::from(r) * 2 + u32::from(g) * 5 + u32::from(b)
        };
        let steps: Vec<u32> = (0..=20_u8)
            .map(|i| brightness(f32::from(i) / 20.0))
            .collect();
        assert!(steps.is_sorted(), "{steps:?}");
        let darkest = color_of_share(0.0);
        assert_eq!(color([f32::NAN; 3], 1.0), UNKNOWN);
        assert_eq!(color([1.0; 3], 0.0), darkest);
        assert_eq!(color([f32::INFINITY; 3], 1.0), color_of_share(1.0));
    }
}
