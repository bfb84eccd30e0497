//! What the builder divides: boxes in the registers of vector instructions, and the triangles in them.

use crate::geometry::Triangle;
use crate::math::{Bounds, Vec3, Vec4};

/// A box as the builder works with it. The fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub low: Vec4,
    pub high: Vec4,
}

impl Extent {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self {
        low: Vec4::INFINITY,
        high: Vec4::NEG_INFINITY,
    };

    #[inline]
    pub fn grow(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    #[inline]
    pub fn grow_by_point(&mut self, point: Vec4) {
        self.low = self.low.min(point);
        self.high = self.high.max(point);
    }

    /// The box around several.
    pub fn around<'a>(items: impl IntoIterator<Item = &'a Item>) -> Self {
        let mut all = Self::EMPTY;
        for item in items {
            all.grow(&item.extent);
        }
        all
    }

    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }

    /// Half the surface area, in `f32`: infinite or 0 for boxes whose sides are beyond 2^±63. Not meaningful for an empty box.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let [x, y, z, _] = (self.high - self.low).to_array();
        x * y + y * z + z * x
    }

    pub fn bounds(&self) -> Bounds {
        Bounds {
            min: self.low.truncate(),
            max: self.high.truncate(),
        }
    }
}

/// The part of a triangle inside some region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// A box around that part. The triangle's id is in the fourth lane of the lower corner.
    extent: Extent,
}

impl Item {
    /// Makes the bits of an id those of an ordinary number, with which arithmetic is not slower than with others.
    const ID_FLAG: u32 = 1 << 30;

    /// All of the triangle. Ids are below 2²⁹.
    pub fn new(triangle: &Triangle, id: u32) -> Self {
        let [a, b, c] = triangle.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        Self {
            extent: Extent {
                low: low.extend(f32::from_bits(id | Self::ID_FLAG)),
                high: high.extend(0.0),
            },
        }
    }

    /// The part of the same triangle in another box.
    pub fn with_bounds(&self, min: Vec3, max: Vec3) -> Self {
        Self {
            extent: Extent {
                low: min.extend(self.extent.low.w),
                high: max.extend(0.0),
            },
        }
    }

    #[inline]
    pub fn triangle(&self) -> u32 {
        self.extent.low.w.to_bits() & !Self::ID_FLAG
    }

    #[inline]
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// Twice the box's centre.
    #[inline]
    pub fn doubled_center(&self) -> Vec4 {
        self.extent.low + self.extent.high
    }
}
