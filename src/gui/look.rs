//! How values become colours on the screen.

use egui::Color32;

use super::{error_colors, false_colors};
use crate::math::{Vec3, color::luminance};
use crate::render::display;
use crate::scene::Display;

/// What pixels look like that are infinite or not a number. Files are written without it.
pub const NOT_FINITE: Color32 = Color32::from_rgb(255, 0, 255);

/// Which channels of a picture are on the screen. Files are written with all, whatever is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Channels {
    /// All, as colours.
    #[default]
    All,
    /// Red alone, as grey.
    Red,
    /// Green alone, as grey.
    Green,
    /// Blue alone, as grey.
    Blue,
    /// The luminance, as grey.
    Luminance,
    /// The luminance in colours that stand for stops, see [`false_colors`].
    FalseColors,
}

impl Channels {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::All,
        Self::Red,
        Self::Green,
        Self::Blue,
        Self::Luminance,
        Self::FalseColors,
    ];

    /// What it is called on screen.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::All => "All colours",
            Self::Red => "Red",
            Self::Green => "Green",
            Self::Blue => "Blue",
            Self::Luminance => "Luminance",
            Self::FalseColors => "False colours",
        }
    }

    /// What shows of a linear value, which is finite.
    fn color(self, rgb: [f32; 3], display: &Display) -> Color32 {
        let encoded = |rgb| {
            let [r, g, b] = display::encode_8(rgb, display);
            Color32::from_rgb(r, g, b)
        };
        match self {
            Self::All => encoded(rgb),
            Self::Red => encoded([rgb[0]; 3]),
            Self::Green => encoded([rgb[1]; 3]),
            Self::Blue => encoded([rgb[2]; 3]),
            Self::Luminance => encoded([luminance(Vec3::from_array(rgb)); 3]),
            Self::FalseColors => false_colors::color(luminance(Vec3::from_array(rgb)), display),
        }
    }
}

/// How values become colours.
#[derive(Clone, Copy, Debug)]
pub enum Look {
    /// As light.
    Light(Display, Channels),
    /// As an error on a scale up to this one.
    Error(f32),
}

/// Where a value lies between what is shown darkest and brightest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Levels {
    /// Red, green and blue of the screen.
    Colors([u8; 3]),
    /// The grey of one channel, or the place of a colour on the scale of its legend.
    One(u8),
}

/// What [`Levels`] stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Red, green and blue of the screen.
    Colors,
    /// The grey of the screen.
    Grey,
    /// Luminance in stops, see [`false_colors`].
    Stops,
    /// Errors, see [`error_colors`].
    Errors,
}

impl Look {
    /// What the levels of values stand for.
    #[must_use]
    pub fn scale(self) -> Scale {
        match self {
            Self::Light(_, Channels::All) => Scale::Colors,
            Self::Light(_, Channels::FalseColors) => Scale::Stops,
            Self::Light(..) => Scale::Grey,
            Self::Error(_) => Scale::Errors,
        }
    }

    /// Where a value, which is finite, lies; and whether it is as bright as can be told apart, or brighter than the screen's white.
    #[must_use]
    pub fn levels(self, rgb: [f32; 3]) -> (Levels, bool) {
        let share_of_byte = |share: f32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of a byte"
            )]
            let level = (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            Levels::One(level)
        };
        match self {
            Self::Light(display, Channels::FalseColors) => {
                let stops = false_colors::stops(luminance(Vec3::from_array(rgb)), &display);
                (share_of_byte(false_colors::share_of(stops)), stops >= 0.0)
            }
            Self::Error(scale) => {
                let share = error_colors::share(rgb, scale);
                (share_of_byte(share), share >= 1.0)
            }
            Self::Light(_, channels) => {
                let [r, g, b, _] = self.color(rgb).to_array();
                let levels = match channels {
                    Channels::All => Levels::Colors([r, g, b]),
                    _ => Levels::One(r),
                };
                (levels, r.max(g).max(b) == 255)
            }
        }
    }

    /// The colour of a value.
    #[must_use]
    pub fn color(self, rgb: [f32; 3]) -> Color32 {
        match self {
            // Nothing else is of this colour by chance.
            Self::Light(..) if rgb.iter().any(|channel| !channel.is_finite()) => NOT_FINITE,
            Self::Light(display, channels) => channels.color(rgb, &display),
            Self::Error(scale) => error_colors::color(rgb, scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_stands_out() {
        for channels in Channels::ALL {
            let light = Look::Light(Display::default(), channels);
            assert_ne!(light.color([1.0; 3]), NOT_FINITE);
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                assert_eq!(light.color([0.5, bad, 0.5]), NOT_FINITE);
            }
        }
    }

    #[test]
    fn a_channel_alone_is_grey() {
        let seen = |channels| Look::Light(Display::default(), channels).color([1.0, 0.0, 0.25]);
        assert_eq!(seen(Channels::Red), Color32::WHITE);
        assert_eq!(seen(Channels::Green), Color32::BLACK);
        let grey = |value| Look::Light(Display::default(), Channels::All).color([value; 3]);
        assert_eq!(seen(Channels::Blue), grey(0.25));
        // The weights of Rec. 709.
        assert_eq!(seen(Channels::Luminance), grey(0.2126 + 0.25 * 0.0722));
    }
}
