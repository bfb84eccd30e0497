//! How a finished picture is shown and stored. Nothing here changes the radiance that is rendered.

use super::Choice;

/// From linear radiance to what a screen shows. It changes no stored radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// In stops: radiance is multiplied by `2^exposure`.
    pub exposure: f64,
    /// How bright values are bent into the range a screen has.
    pub tone_curve: ToneCurve,
    /// Makes values between black and white brighter (above 1) or darker, after the tone curve: they are raised to `1 / gamma`. Positive.
    pub gamma: f64,
}

impl Default for Display {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            tone_curve: ToneCurve::default(),
            gamma: 1.0,
        }
    }
}

/// How values above what a screen can show are treated, before the sRGB curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ToneCurve {
    /// Clipped at 1.
    #[default]
    None,
    /// Rolled off with the shape of the ACES reference rendering.
    Aces,
}

impl Choice for ToneCurve {
    const ALL: &'static [(Self, &'static str)] = &[(Self::None, "none"), (Self::Aces, "aces")];
}

/// How pictures are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Bits per channel of PNG files.
    pub png_bits: PngBits,
    /// Whether the parts of a picture are kept, to be looked at and stored in OpenEXR files.
    pub layers: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            png_bits: PngBits::default(),
            layers: true,
        }
    }
}

/// Bits per channel of a PNG file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PngBits {
    /// 256 levels.
    #[default]
    Eight,
    /// 65,536 levels.
    Sixteen,
}
