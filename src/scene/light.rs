use super::Rgb;
use crate::math::DVec3;

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines equally in all directions from one point; not seen itself.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity in W/sr: the irradiance at distance `d` is `intensity · cos θ / d²`.
        intensity: Rgb,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self::Point {
            position: DVec3::ZERO,
            intensity: Rgb::ONE,
        }
    }
}
