use crate::math::{SceneFrame, Vec3};
use crate::scene::Light;

/// A light in the prepared scene.
#[derive(Clone, Copy, Debug)]
pub struct PreparedLight {
    pub position: Vec3,
    /// Radiant intensity × (prepared units per world unit)², so that dividing by the prepared distance squared gives the
    /// irradiance of the world.
    pub intensity: Vec3,
}

impl PreparedLight {
    pub fn new(light: &Light, frame: &SceneFrame) -> Self {
        match *light {
            Light::Point {
                position,
                intensity,
            } => Self {
                position: frame.narrow(position),
                intensity: (intensity * (frame.scale() * frame.scale())).as_vec3(),
            },
        }
    }
}
