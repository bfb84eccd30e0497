//! Balls around what is drawn: whether any of it is in sight, and how near it is, without looking at triangles.

use crate::math::{Bounds, DVec3, ScaledRotation, Vec3};

/// A ball in the prepared scene, or in the coordinates of a shared mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub center: DVec3,
    /// Not negative.
    pub radius: f64,
}

impl Ball {
    /// A ball around a box; a point where the box is empty.
    #[must_use]
    pub fn around(bounds: &Bounds) -> Self {
        if bounds.is_empty() {
            return Self {
                center: DVec3::ZERO,
                radius: 0.0,
            };
        }
        let [min, max] = [bounds.min, bounds.max].map(Vec3::as_dvec3);
        let center = (min + max) * 0.5;
        Self {
            center,
            radius: center.distance(max),
        }
    }

    /// A ball around what is in this one, turned and scaled by `turn` and then moved by `shift`.
    #[must_use]
    pub fn moved(self, turn: &ScaledRotation, shift: DVec3) -> Self {
        Self {
            center: turn.apply(self.center) + shift,
            radius: self.radius * turn.scale(),
        }
    }

    /// A ball around this one wherever its middle is moved by a place in `places`.
    #[must_use]
    pub fn at_places(self, places: &Self) -> Self {
        Self {
            center: self.center + places.center,
            radius: self.radius + places.radius,
        }
    }
}
