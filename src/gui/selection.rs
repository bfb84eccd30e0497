//! What the panels show the properties of.

use crate::scene::Scene;

/// A part of the scene.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Selection {
    /// The camera.
    #[default]
    Camera,
    /// What is behind everything.
    Background,
    /// The object at this place in the scene.
    Object(usize),
    /// The light at this place in the scene.
    Light(usize),
    /// The material of this name.
    Material(String),
}

impl Selection {
    /// Whether it is a part that has a name to change.
    #[must_use]
    pub fn has_name(&self) -> bool {
        matches!(self, Self::Object(_) | Self::Light(_) | Self::Material(_))
    }

    /// The place of the object, where it is one.
    #[must_use]
    pub fn object(&self) -> Option<usize> {
        match *self {
            Self::Object(index) => Some(index),
            _ => None,
        }
    }

    /// The place of the light, where it is one.
    #[must_use]
    pub fn light(&self) -> Option<usize> {
        match *self {
            Self::Light(index) => Some(index),
            _ => None,
        }
    }

    /// The same part if `scene` has it, else the camera.
    #[must_use]
    pub fn within(self, scene: &Scene) -> Self {
        let exists = match &self {
            Self::Camera | Self::Background => true,
            Self::Object(index) => *index < scene.objects.len(),
            Self::Light(index) => *index < scene.lights.len(),
            Self::Material(name) => scene.materials.contains_key(name),
        };
        if exists { self } else { Self::Camera }
    }
}
