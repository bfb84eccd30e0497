use crate::math::{Bounds, Vec3};

/// A triangle in the prepared scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, counter-clockwise seen from outside.
    pub corners: [Vec3; 3],
}

impl Triangle {
    /// The box around the corners.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(self.corners)
    }
}

/// A ray prepared for the watertight test.
#[derive(Clone, Copy, Debug)]
pub struct RayKernel;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit;
