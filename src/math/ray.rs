//! Rays of the prepared scene, in `f32`. Their parameter `t` counts multiples of the direction, which need not be a unit vector.

use super::Vec3;

/// A half line `origin + t · direction`, `t ≥ 0`.
///
/// The direction need not be a unit vector: `t` is measured in multiples of it. Shadow rays use the vector to the
/// light, so that `t = 1` is the light itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3,
    /// Where it goes; finite and not zero.
    pub direction: Vec3,
}

impl Ray {
    /// A ray from `origin` along `direction`.
    #[must_use]
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction }
    }

    /// The point at parameter `t`.
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}
