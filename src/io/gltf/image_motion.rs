//! The glTF extension `KHR_texture_transform`: it is applied to the texture coordinates of a mesh when that is read.

use super::document::TextureTransform;
use crate::math::DVec2;

/// How `KHR_texture_transform` moves an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageMotion {
    offset: DVec2,
    rotation: f64,
    scale: DVec2,
}

impl ImageMotion {
    /// `None` where it moves nothing, or nowhere.
    pub fn of(transform: TextureTransform) -> Option<Self> {
        let motion = Self {
            offset: DVec2::from_array(transform.offset.unwrap_or_default()),
            rotation: transform.rotation.unwrap_or_default(),
            scale: DVec2::from_array(transform.scale.unwrap_or([1.0; 2])),
        };
        let is_finite =
            motion.offset.is_finite() && motion.rotation.is_finite() && motion.scale.is_finite();
        let moves =
            (motion.offset, motion.rotation, motion.scale) != (DVec2::ZERO, 0.0, DVec2::ONE);
        (is_finite && moves).then_some(motion)
    }

    /// The same for the same motion, and for that alone.
    pub fn key(&self) -> [u64; 5] {
        let Self {
            offset,
            rotation,
            scale,
        } = self;
        [offset.x, offset.y, *rotation, scale.x, scale.y].map(f64::to_bits)
    }

    /// Where on the image a place is: scaled, turned counter-clockwise as one looks at the image, and moved, with the image's upper left
    /// corner as origin and its second coordinate downwards.
    pub fn apply(&self, DVec2 { x, y }: DVec2) -> DVec2 {
        let (sin, cos) = libm::sincos(self.rotation);
        let DVec2 { x: u, y: v } = DVec2::new(x, 1.0 - y) * self.scale;
        let moved = DVec2::new(cos * u + sin * v, cos * v - sin * u) + self.offset;
        let moved = DVec2::new(moved.x, 1.0 - moved.y);
        if moved.is_finite() {
            moved
        } else {
            DVec2::ZERO
        }
    }
}
