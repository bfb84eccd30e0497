//! Triangulation of polygons in space: convex, concave, with points on straight edges, touching themselves; and something
//! sensible, with a flag, for those that cross themselves.
//!
//! A polygon is looked at along the axis nearest its normal, so it may be a little warped. Convex ones are cut at once;
//! others lose their ears one by one. Which side of a line a point lies on is decided exactly, on the coordinates
//! as they are, apart from underflow. Time is O(n) for convex polygons and about O(n √n) at worst for the others.

mod blockers;
mod ears;
mod orientation;
mod spokes;

use super::face_normal::scale_to_one;
use crate::math::{DVec2, DVec3};
use orientation::orientation;

/// A polygon cut into triangles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// Indices into the polygon's corners, in the polygon's own orientation; always two fewer than it has corners.
    ///
    /// Triangles without area appear only where the polygon touches itself.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the polygon was seen to cross itself; its triangles then overlap or leave parts out.
    ///
    /// It is never set for a simple polygon. It is set for a figure of eight or a pentagram; two arms of one polygon that
    /// lie across each other may pass unseen, with the triangles of both arms.
    pub crosses_itself: bool,
}

/// Cuts the polygon with these corners, finite and in order around it, into triangles. Fewer than three give none.
///
/// Holes are allowed as they are written in files without them: a bridge, walked there and back, joins the hole's
/// border (in the opposite sense) to the outer one.
///
/// # Panics
/// When there are 2³² corners or more.
#[must_use]
pub fn triangulate(corners: &[DVec3]) -> Triangulation {
    let count = u32::try_from(corners.len()).expect("fewer than 2^32 corners");
    if count < 3 {
        return Triangulation::default();
    }
    let points = flatten(corners);
    if count == 3 || is_convex(&points) {
        return Triangulation {
            triangles: cut_convex(count),
            crosses_itself: false,
        };
    }
    ears::cut(&points)
}

/// The corners without the coordinate along which the polygon is seen best, counter-clockwise, and near 1 in size.
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let largest = corners.iter().fold(0.0, |largest, corner| {
        corner.abs().max_element().max(largest)
    });
    let scale = scale_to_one(largest);
    let normal = newell_normal(corners, scale);
    let size = normal.abs();
    let axis = if size.z >= size.x && size.z >= size.y {
        2
    } else {
        usize::from(size.y > size.x)
    };
    let (mut right, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (right, up) = (up, right);
    }
    let flat = |corner: &DVec3| DVec2::new(corner[right], corner[up]) * scale;
    corners.iter().map(flat).collect()
}

/// The direction from which the polygon shows most of its area: twice the area vector, of the polygon times `scale`.
///
/// Source: Newell's method; Sutherland, Sproull, Schumacker, A Characterization of Ten Hidden-Surface Algorithms, 1974.
fn newell_normal(corners: &[DVec3], scale: f64) -> DVec3 {
    // Seen from a corner, a polygon far from the origin keeps its digits.
    let origin = corners[0] * scale;
    let arms = corners.iter().map(|&corner| corner * scale - origin);
    let next_arms = arms.clone().skip(1);
    let (mut sum, mut largest) = (DVec3::ZERO, DVec3::ZERO);
    for (a, b) in arms.zip(next_arms) {
        let cross = a.cross(b);
        sum += cross;
        if cross.length_squared() > largest.length_squared() {
            largest = cross;
        }
    }
    // The lobes of a figure of eight cancel and leave rounding errors; one lobe knows the plane.
    let noise = corners.len() as f64 * f64::EPSILON;
    if sum.abs().max_element() > noise * largest.abs().max_element() {
        sum
    } else {
        largest
    }
}

/// Whether the polygon turns left at every corner, and once around in all.
fn is_convex(points: &[DVec2]) -> bool {
    let turns_left = corners_of(points).all(|[a, b, c]| orientation(a, b, c) > 0.0);
    // A convex polygon goes up once and down once; a pentagram does so twice.
    let changes = corners_of(points).filter(|&[a, b, c]| goes_up(a, b) != goes_up(b, c));
    turns_left && changes.count() == 2
}

/// Whether `b` is higher than `a`, or as high and further right: true for one of two opposite directions.
fn goes_up(a: DVec2, b: DVec2) -> bool {
    (a.y, a.x) < (b.y, b.x)
}

/// All corners, of which there is at least one, each with the one before and the one after it.
fn corners_of(points: &[DVec2]) -> impl Iterator<Item = [DVec2; 3]> {
    let last = points.len() - 1;
    let before = move |i: usize| if i == 0 { last } else { i - 1 };
    let after = move |i: usize| if i == last { 0 } else { i + 1 };
    (0..=last).map(move |i| [points[before(i)], points[i], points[after(i)]])
}

/// Cuts off every other corner until nothing is left, which makes fatter triangles than a fan does.
fn cut_convex(count: u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(count as usize - 2);
    let mut ring: Vec<u32> = (0..count).collect();
    while ring.len() > 2 {
        for tip in (1..ring.len()).step_by(2) {
            let after = ring[(tip + 1) % ring.len()];
            triangles.push([ring[tip - 1], ring[tip], after]);
        }
        let mut place = 0;
        ring.retain(|_| {
            place += 1;
            place % 2 == 1
        });
    }
    triangles
}

#[cfg(test)]
mod tests;
