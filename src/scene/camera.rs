//! The camera of the description. Points are in the world, lengths in scene units, the field of view in degrees.

use crate::math::{DVec3, Degrees, direction_of, length_of};

/// A camera with a thin lens, or a pinhole where the aperture is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: DVec3,
    /// The point in the middle of the picture; not the eye.
    pub target: DVec3,
    /// Which way is up in the picture, of any length but 0; not parallel to the view.
    pub up: DVec3,
    /// Angle over the full height of the picture, between 0° and 180°.
    pub vertical_fov: Degrees,
    /// Radius of the lens in scene units; 0 is a pinhole.
    pub aperture_radius: f64,
    /// Distance along the view axis, in scene units, at which the picture is sharp; may be infinite. The distance to `target` where `None`.
    pub focus_distance: Option<f64>,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            eye: DVec3::new(0.0, -6.0, 2.5),
            target: DVec3::ZERO,
            up: DVec3::Z,
            vertical_fov: Degrees(40.0),
            aperture_radius: 0.0,
            focus_distance: None,
        }
    }
}

/// A camera to come back to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bookmark {
    /// What people call it.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

/// Smallest sine of the angle between view and up; below it, rounding alone would decide where right is.
const SMALLEST_SINE: f64 = 1e-12;

/// The three axes of a camera: unit vectors, right-handed (`right × up = −forward`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraAxes {
    /// To the right in the picture.
    pub right: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
}

impl Camera {
    /// Distance along the view axis at which the picture is sharp, in scene units.
    #[must_use]
    pub fn focus(&self) -> f64 {
        self.focus_distance
            .unwrap_or_else(|| length_of(self.target - self.eye))
    }

    /// The camera's axes, or `None` where eye and target coincide or `up` is parallel to the view.
    #[must_use]
    pub fn axes(&self) -> Option<CameraAxes> {
        let forward = direction_of(self.target - self.eye)?;
        let up = direction_of(self.up)?;
        let right = forward.cross(up);
        if right.length() < SMALLEST_SINE {
            return None;
        }
        let right = right.normalize();
        Some(CameraAxes {
            right,
            up: right.cross(forward),
            forward,
        })
    }
}
