//! Where the mouse points in the world: the maths behind dragging along a line, in a plane and about an axis.

use crate::gui::orbit::{self, PictureSize};
use crate::math::{DVec2, DVec3};
use crate::scene::Camera;

/// Smallest squared sine of the angle between a line of sight and an axis to move along: below it, a pixel is a leap.
const LEAST_SINE_SQUARED: f64 = 1e-3;
/// Smallest cosine of the angle between a line of sight and the normal of a plane to move in, for the same reason.
const LEAST_COSINE: f64 = 0.02;

/// The half line through a place of the picture, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it begins.
    pub eye: DVec3,
    /// Unit.
    pub direction: DVec3,
}

impl Sight {
    /// The line of sight through `position` of a picture of `size`; `None` where the camera has no direction.
    #[must_use]
    pub fn through(camera: &Camera, size: PictureSize, position: DVec2) -> Option<Self> {
        let direction = orbit::view_direction(camera, size, position)?;
        Some(Self {
            eye: camera.eye,
            direction: direction.try_normalize()?,
        })
    }

    /// How far from `origin` along the unit vector `axis` the line through both comes nearest to the line of sight; `None` where they
    /// run the same way, or that is behind the eye.
    #[must_use]
    pub fn along(&self, origin: DVec3, axis: DVec3) -> Option<f64> {
        let offset = origin - self.eye;
        let cosine = axis.dot(self.direction);
        let sine_squared = 1.0 - cosine * cosine;
        if sine_squared < LEAST_SINE_SQUARED {
            return None;
        }
        let ahead = offset.dot(self.direction);
        let place = (cosine * ahead - offset.dot(axis)) / sine_squared;
        let is_ahead = ahead + place * cosine > 0.0;
        (is_ahead && place.is_finite()).then_some(place)
    }

    /// Where the line of sight meets the plane through `origin` with the unit vector `normal`; `None` where it runs along it, or that is
    /// behind the eye.
    #[must_use]
    pub fn in_plane(&self, origin: DVec3, normal: DVec3) -> Option<DVec3> {
        let cosine = self.direction.dot(normal);
        if cosine.abs() < LEAST_COSINE {
            return None;
        }
        let distance = (origin - self.eye).dot(normal) / cosine;
        let point = self.eye + self.direction * distance;
        (distance > 0.0 && point.is_finite()).then_some(point)
    }
}

/// The angle in radians, within ±π, by which a turn about the unit vector `axis` brings `from` to where `to` points.
#[must_use]
pub fn angle_about(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let sine = axis.dot(from.cross(to));
    let cosine = from.dot(to) - from.dot(axis) * to.dot(axis);
    sine.atan2(cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: PictureSize = PictureSize {
        width: 640.0,
        height: 480.0,
    };

    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(3.0, -6.0, 2.5),
            target: DVec3::new(0.5, 0.0, 0.3),
            ..Camera::default()
        }
    }

    /// A point that is drawn, and looked at where it is drawn, is found again.
    #[test]
    fn what_is_pointed_at_is_found_on_lines_and_in_planes() {
        let camera = camera();
        let origin = DVec3::new(0.4, -0.2, 0.6);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE.normalize()];
        for axis in axes {
            for place in [-1.5, 0.0, 0.25, 2.0] {
                let point = origin + axis * place;
                let (position, _) = orbit::project(&camera, SIZE, point).unwrap();
                let sight = Sight::through(&camera, SIZE, position).unwrap();
                assert!((sight.along(origin, axis).unwrap() - place).abs() < 1e-9);

                let across = axis.any_orthonormal_vector();
                let in_plane = origin + across * place;
                let (position, _) = orbit::project(&camera, SIZE, in_plane).unwrap();
                let sight = Sight::through(&camera, SIZE, position).unwrap();
                let found = sight.in_plane(origin, axis).unwrap();
                assert!(found.distance(in_plane) < 1e-9);
            }
        }
    }

    #[test]
    fn an_axis_seen_from_its_end_and_a_plane_from_its_side_give_nothing() {
        let sight = Sight {
            eye: DVec3::new(0.0, -5.0, 0.0),
            direction: DVec3::Y,
        };
        assert_eq!(sight.along(DVec3::ZERO, DVec3::Y), None);
        assert_eq!(sight.in_plane(DVec3::ZERO, DVec3::Z), None);
        assert_eq!(sight.in_plane(DVec3::ZERO, DVec3::Y), Some(DVec3::ZERO));
        let behind = DVec3::new(0.0, -9.0, 0.0);
        assert_eq!(sight.in_plane(behind, DVec3::Y), None);
        assert_eq!(sight.along(behind, DVec3::X), None);
    }

    #[test]
    fn angles_have_the_sign_of_the_right_hand() {
        let angle = angle_about(DVec3::Z, DVec3::X, DVec3::Y * 3.0);
        assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((angle_about(-DVec3::Z, DVec3::X, DVec3::Y) + angle).abs() < 1e-15);
        // What of the vectors lies along the axis does not count.
        let lifted = angle_about(DVec3::Z, DVec3::X + DVec3::Z, DVec3::Y - DVec3::Z);
        assert!((lifted - angle).abs() < 1e-15);
    }
}
