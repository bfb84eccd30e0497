//! What rays see that hit nothing: radiance by direction, and which pixel of an image lies in which direction.

use super::Rgb;
use crate::math::{DVec3, Degrees, direction_of};

/// Radiance arriving from where no object is. It is seen and it lights the scene.
#[derive(Clone, Debug, PartialEq)]
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
    /// An equirectangular image; [`ImageAxes`] says which pixel is where.
    Image {
        /// The image file; its pixels are in [`Scene::images`](super::Scene::images).
        image: String,
        /// Which way the image's top is; the camera's `up` in files that do not say.
        up: DVec3,
        /// How far the image is turned about `up`, counter-clockwise as seen from above.
        rotation: Degrees,
        /// Factor to the radiance of the pixels.
        scale: f64,
    },
}

impl Background {
    /// Whether it gives no light at all, whatever the pixels of an image are.
    #[must_use]
    pub fn is_black(&self) -> bool {
        match *self {
            Self::Constant { radiance } => radiance == Rgb::ZERO,
            Self::Image { scale, .. } => scale == 0.0,
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

/// Where an image background has its pixels: three unit vectors at right angles.
///
/// The image is seen from inside and not mirrored: who stands upright along `up` and looks at its centre sees its right
/// half at the right. With `width × height` pixels, the centre of pixel `(x, y)` from the top left lies at the angle
/// `π (y + ½) / height` from `up`, and `2π (½ − (x + ½) / width)` from `front` towards `left`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageAxes {
    /// Towards the middle between left and right, at the horizon.
    pub front: DVec3,
    /// Towards what is a quarter of the width to the left of that.
    pub left: DVec3,
    /// Towards the top.
    pub up: DVec3,
}

impl ImageAxes {
    /// The axes of an image whose top is `up`, of any length, turned by `rotation` about it, right-handed. `None` where
    /// `up` is no direction.
    ///
    /// Unturned, `front` is the world's X axis, made level: +X for the usual ups +Z and +Y. Where `up` itself is within 45°
    /// of ±X, it is the Y axis.
    #[must_use]
    pub fn new(up: DVec3, rotation: Degrees) -> Option<Self> {
        let up = direction_of(up)?;
        let ahead = if 2.0 * up.x * up.x > 1.0 {
            DVec3::Y
        } else {
            DVec3::X
        };
        let front = (ahead - up * ahead.dot(up)).try_normalize()?;
        let left = up.cross(front);
        // Reduced in degrees, which is exact, so that whole turns change no bit.
        let angle = Degrees(rotation.0.rem_euclid(360.0)).radians();
        let (sine, cosine) = libm::sincos(angle);
        Some(Self {
            front: front * cosine + left * sine,
            left: left * cosine - front * sine,
            up,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(up: DVec3, rotation: f64) -> ImageAxes {
        ImageAxes::new(up, Degrees(rotation)).expect("a direction")
    }

    #[test]
    fn the_centre_is_along_x_and_the_left_is_at_the_left() {
        let sky = axes(DVec3::Z * 3.0, 0.0);
        assert_eq!(
            [sky.front, sky.left, sky.up],
            [DVec3::X, DVec3::Y, DVec3::Z]
        );
        let sky = axes(DVec3::Y, 0.0);
        assert_eq!(
            [sky.front, sky.left, sky.up],
            [DVec3::X, -DVec3::Z, DVec3::Y]
        );
        let sky = axes(-DVec3::X, 0.0);
        assert_eq!([sky.front, sky.left], [DVec3::Y, -DVec3::Z]);
    }

    #[test]
    fn turning_is_counter_clockwise_from_above_and_four_quarters_are_none() {
        let sky = axes(DVec3::Z, 90.0);
        assert!(sky.front.abs_diff_eq(DVec3::Y, 1e-15) && sky.left.abs_diff_eq(-DVec3::X, 1e-15));
        let up = DVec3::new(0.1, -0.3, 0.8);
        for turns in [-720.0, 360.0, 3.6e6] {
            assert_eq!(axes(up, 33.0 + turns), axes(up, 33.0), "{turns}");
        }
    }

    #[test]
    fn axes_are_at_right_angles_for_any_up() {
        for up in [
            DVec3::ONE,
            DVec3::new(1.0, 1e-9, 0.0),
            DVec3::new(0.7, 0.0, -0.72),
        ] {
            let ImageAxes { front, left, up } = axes(up, 12.0);
            assert!(front.cross(left).abs_diff_eq(up, 1e-14));
            assert!((front.length() - 1.0).abs() < 1e-14 && front.dot(up).abs() < 1e-14);
        }
        assert_eq!(ImageAxes::new(DVec3::ZERO, Degrees(0.0)), None);
    }
}
