use super::Rgb;
use crate::math::DVec3;

/// Radiance arriving from where no object is. It is seen and it lights the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// The same from everywhere.
    Constant {
        /// W/m²/sr.
        radiance: Rgb,
    },
    /// A sky over a ground: with `t = direction · up`, `horizon` mixes linearly to `zenith` for `t` from 0 to 1 and to
    /// `ground` for `t` from 0 to −1.
    Gradient {
        /// Radiance straight up.
        zenith: Rgb,
        /// Radiance at the horizon.
        horizon: Rgb,
        /// Radiance straight down.
        ground: Rgb,
        /// Which way the zenith is; the camera's `up` in files that do not say.
        up: DVec3,
    },
}

impl Background {
    /// Whether it gives no light at all.
    #[must_use]
    pub fn is_black(&self) -> bool {
        match *self {
            Self::Constant { radiance } => radiance == Rgb::ZERO,
            Self::Gradient {
                zenith,
                horizon,
                ground,
                ..
            } => [zenith, horizon, ground].iter().all(|&c| c == Rgb::ZERO),
        }
    }
}

impl Default for Background {
    fn default() -> Self {
        Self::Constant {
            radiance: Rgb::ZERO,
        }
    }
}
