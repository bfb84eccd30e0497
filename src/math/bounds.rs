//! Axis-aligned boxes: of the prepared scene in `f32`, of the description in `f64`. The empty box is inverted, so that growing it
//! by points or boxes needs no special case.

use super::{DVec3, Vec3};

/// Defines an axis-aligned box over one vector type; `f32` and `f64` boxes differ in nothing else.
macro_rules! axis_aligned_box {
    ($(#[$doc:meta])* $name:ident, $vector:ty, $scalar:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            /// Smallest corner.
            pub min: $vector,
            /// Largest corner.
            pub max: $vector,
        }

        impl $name {
            /// The box that holds nothing: growing it by a point gives that point.
            pub const EMPTY: Self = Self {
                min: <$vector>::INFINITY,
                max: <$vector>::NEG_INFINITY,
            };

            /// The smallest box around `points`; [`Self::EMPTY`] when there are none.
            #[must_use]
            pub fn of_points(points: impl IntoIterator<Item = $vector>) -> Self {
                points.into_iter().fold(Self::EMPTY, Self::with_point)
            }

            /// The smallest box around this one and `point`.
            #[must_use]
            pub fn with_point(self, point: $vector) -> Self {
                Self { min: self.min.min(point), max: self.max.max(point) }
            }

            /// The smallest box around both.
            #[must_use]
            pub fn union(self, other: Self) -> Self {
                Self { min: self.min.min(other.min), max: self.max.max(other.max) }
            }

            /// The part common to both; empty when they do not touch.
            #[must_use]
            pub fn intersection(self, other: Self) -> Self {
                Self { min: self.min.max(other.min), max: self.max.min(other.max) }
            }

            /// Whether no point lies inside. A single point, or a flat box, is not empty.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                !self.min.cmple(self.max).all()
            }

            /// Whether `point` lies inside or on the surface.
            #[must_use]
            pub fn contains(&self, point: $vector) -> bool {
                self.min.cmple(point).all() && point.cmple(self.max).all()
            }

            /// Edge lengths; not meaningful for an empty box.
            #[must_use]
            pub fn size(&self) -> $vector {
                self.max - self.min
            }

            /// The middle; not meaningful for an empty box.
            #[must_use]
            pub fn center(&self) -> $vector {
                // Halves first: the sum of two large corners may overflow.
                self.min * 0.5 + self.max * 0.5
            }

            /// Length of the space diagonal; 0 for an empty box.
            #[must_use]
            pub fn diagonal(&self) -> $scalar {
                if self.is_empty() { 0.0 } else { self.size().length() }
            }

            /// Half the surface area, the measure the surface area heuristic compares.
            #[must_use]
            pub fn half_area(&self) -> $scalar {
                let size = self.size();
                size.x * size.y + size.y * size.z + size.z * size.x
            }
        }
    };
}

axis_aligned_box! {
    /// An axis-aligned box in the prepared scene (`f32`).
    Bounds, Vec3, f32
}
axis_aligned_box! {
    /// An axis-aligned box of the description (`f64`).
    DBounds, DVec3, f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_a_box_and_nothing_is_not() {
        assert!(Bounds::EMPTY.is_empty());
        let point = Bounds::of_points([Vec3::ONE]);
        assert!(!point.is_empty());
        assert!(point.contains(Vec3::ONE));
        assert_eq!(point.diagonal().to_bits(), 0);
    }

    #[test]
    fn the_center_of_huge_corners_does_not_overflow() {
        let corner = DVec3::splat(f64::MAX);
        let bounds = DBounds {
            min: corner,
            max: corner,
        };
        assert_eq!(bounds.center(), corner);
    }
}
