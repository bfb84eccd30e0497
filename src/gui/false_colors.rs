//! Luminance as colours that stand for stops: how bright each place is, also where the screen shows mere black or white.
//!
//! From dark blue over green to yellow each colour is brighter than the one before, up to the white of the screen; orange and red are what is
//! brighter than that, and is cut off unless a tone curve bends it.

use egui::{Color32, Rect, Ui};

use super::legend::Legend;
use super::widgets::format_number;
use crate::render::display::exposure_factor;
use crate::scene::Display;

/// Stops below and above the white of the screen that the scale ends at.
const BELOW: f32 = 8.0;
const ABOVE: f32 = 4.0;
/// The colours, and the stops that they stand for.
const COLORS: [(f32, [u8; 3]); 7] = [
    (-BELOW, [0x0a, 0x0e, 0x3a]),
    (-6.0, [0x2a, 0x48, 0x9a]),
    (-4.0, [0x2f, 0x8f, 0x9c]),
    (-2.0, [0x8f, 0xc0, 0x5a]),
    (0.0, [0xfd, 0xe9, 0x4b]),
    (2.0, [0xf2, 0x86, 0x2e]),
    (ABOVE, [0xc8, 0x1e, 0x2a]),
];
/// Stops that are written under the legend.
const MARKS: [f32; 4] = [-6.0, -3.0, 0.0, 3.0];

/// The colour of a luminance, in W/m²/sr, at the exposure of `display`.
#[must_use]
pub fn color(luminance: f32, display: &Display) -> Color32 {
    color_of_stops(stops(luminance, display))
}

/// How many stops a luminance is above the white of the screen; infinitely few where it is black.
#[must_use]
pub fn stops(luminance: f32, display: &Display) -> f32 {
    libm::log2f((luminance * exposure_factor(display)).max(0.0))
}

/// Where so many stops lie on the scale, `0..=1` from its dark end.
#[must_use]
pub fn share_of(stops: f32) -> f32 {
    ((stops + BELOW) / (BELOW + ABOVE)).clamp(0.0, 1.0)
}

/// The colour of so many stops above the white of the screen, infinitely few included.
fn color_of_stops(stops: f32) -> Color32 {
    let of = |[r, g, b]: [u8; 3]| Color32::from_rgb(r, g, b);
    let next = COLORS.iter().position(|&(at, _)| stops < at);
    match next {
        Some(0) => of(COLORS[0].1),
        Some(next) => {
            let ((low, from), (high, to)) = (COLORS[next - 1], COLORS[next]);
            of(from).lerp_to_gamma(of(to), (stops - low) / (high - low))
        }
        None => of(COLORS[COLORS.len() - 1].1),
    }
}

/// Draws what the colours mean into the lower left corner of the picture in `frame`; `is_radiance`: whether values have its unit.
pub fn legend_ui(ui: &Ui, frame: Rect, display: &Display, is_radiance: bool) {
    let marks = MARKS.map(|stops| {
        let mark = match stops {
            0.0 => "white".to_owned(),
            _ => format!("{stops:+}"),
        };
        (share_of(stops), mark.replace('-', "−"))
    });
    let white = format_number(f64::from(1.0 / exposure_factor(display)), 3);
    let unit = if is_radiance { " W/m²/sr" } else { "" };
    let end = format!("white is {white}{unit}");
    let legend = Legend {
        start: "Stops",
        end: &end,
        marks: &marks,
        name: format!("Colours of luminance in stops, {end}"),
        explanation: "How bright each place is, in stops below and above the white of the screen: each is twice the luminance. Orange and \
             red are brighter than the screen can show. The exposure moves the scale",
    };
    legend.show_ui(ui, frame, |share| {
        color_of_stops(share * (BELOW + ABOVE) - BELOW)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_stand_for_stops_and_the_exposure_moves_them() {
        let plain = Display::default();
        for (stops, [r, g, b]) in COLORS {
            let luminance = stops.exp2();
            assert_eq!(color(luminance, &plain), Color32::from_rgb(r, g, b));
            let brighter = Display {
                exposure: 3.0,
                ..plain
            };
            assert_eq!(color(luminance / 8.0, &brighter), color(luminance, &plain));
        }
        assert_ne!(color(0.5, &plain), color(0.25, &plain));
    }

    #[test]
    fn up_to_white_brighter_is_brighter_and_nothing_breaks() {
        let brightness = |stops: f32| {
            let [r, g, b, _] = color_of_stops(stops).to_array();
            u32::from(r) * 2 + u32::from(g) * 5 + u32::from(b)
        };
        let steps: Vec<u32> = (-32..=0_i16)
            .map(|i| brightness(f32::from(i) / 4.0))
            .collect();
        assert!(steps.is_sorted(), "{steps:?}");
        let plain = Display::default();
        assert_eq!(color(0.0, &plain), color_of_stops(-BELOW));
        assert_eq!(color(-1.0, &plain), color_of_stops(-BELOW));
        assert_eq!(color(f32::MAX, &plain), color_of_stops(ABOVE));
    }
}
