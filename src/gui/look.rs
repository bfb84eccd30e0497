//! How values become colours on the screen.

use egui::Color32;

use super::error_colors;
use crate::render::display;
use crate::scene::Display;

/// What pixels look like that are infinite or not a number. Files are written without it.
pub const NOT_FINITE: Color32 = Color32::from_rgb(255, 0, 255);

/// How values become colours.
#[derive(Clone, Copy, Debug)]
pub enum Look {
    /// As light.
    Light(Display),
    /// As an error on a scale up to this one.
    Error(f32),
}

impl Look {
    /// The colour of a value.
    #[must_use]
    pub fn color(self, rgb: [f32; 3]) -> Color32 {
        match self {
            // Nothing else is of this colour by chance.
            Self::Light(_) if rgb.iter().any(|channel| !channel.is_finite()) => NOT_FINITE,
            Self::Light(display) => {
                let [r, g, b] = display::encode_8(rgb, &display);
                Color32::from_rgb(r, g, b)
            }
            Self::Error(scale) => error_colors::color(rgb, scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_stands_out() {
        let light = Look::Light(Display::default());
        assert_eq!(light.color([1.0; 3]), Color32::WHITE);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(light.color([0.5, bad, 0.5]), NOT_FINITE);
        }
    }
}
