//! Normals of faces.
//!
//! Directions depend on shape alone: before anything is multiplied, lengths from 1e−300 to 1e300 are brought near 1 by an
//! exact power of two.

use crate::math::DVec3;

/// The unit normal of a triangle, on the side from which its corners run counter-clockwise; `None` when it has no area.
///
/// "No area" means that the corners lie on one line within the rounding of their coordinates, as decimal numbers in a
/// file do: the digits of such a triangle's cross product are noise.
#[must_use]
pub fn face_normal(corners: [DVec3; 3]) -> Option<DVec3> {
    let cross = significant_cross(corners)?;
    let cross = cross * scale_to_one(cross.abs().max_element());
    Some(cross / cross.length())
}

/// Whether [`face_normal`] finds one: most triangles are far from having none, which takes less to tell.
#[must_use]
pub fn has_area(corners: [DVec3; 3]) -> bool {
    is_clear(corners) || significant_cross(corners).is_some()
}

/// Whether a triangle has so much area that [`significant_cross`] need not be asked.
///
/// Edges are at most twice the largest coordinate m long, so that what rounding may account for there is at most 48 u·m², and as much
/// may lie between two ways to compute the cross product (u: the unit roundoff, half an epsilon).
fn is_clear([a, b, c]: [DVec3; 3]) -> bool {
    const CLEAR: f64 = 128.0 * f64::EPSILON;
    /// Squares of these neither overflow nor vanish.
    const USUAL: std::ops::Range<f64> = 1e-100..1e100;
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let cross = (b - a).cross(c - a).abs().max_element();
    USUAL.contains(&largest) && cross > CLEAR * largest * largest
}

/// A positive multiple of the face normal, `None` when rounding may account for all of it.
fn significant_cross(corners: [DVec3; 3]) -> Option<DVec3> {
    const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;
    let [a, b, c] = corners;
    let edges = edges_of(corners);
    let longest = edges
        .iter()
        .fold(0.0, |longest, edge| edge.abs().max_element().max(longest));
    if longest == 0.0 {
        return None;
    }
    if longest == f64::INFINITY {
        // Differences of the largest numbers overflow; those of their quarters do not.
        return significant_cross(corners.map(|corner| corner * 0.25));
    }
    let scale = scale_to_one(longest);
    let edges = edges.map(|edge| edge * scale);
    // Of the three cross products, which are the same but for rounding, that of the two shorter edges loses least.
    let opposite = longest_edge(edges);
    let [p, q] = [edges[(opposite + 1) % 3], edges[(opposite + 2) % 3]];
    let cross = p.cross(q);

    // A coordinate of an edge is off by the roundings of two corners and of the subtraction; |coordinate| ≤ 2 |corner|.
    let edge_error = a.abs().max(b.abs()).max(c.abs()) * scale * (4.0 * UNIT_ROUNDOFF);
    let (p, q) = (p.abs(), q.abs());
    let from_edges = absolute_cross(edge_error, p + q);
    let from_products = absolute_cross(p, q) * (2.0 * UNIT_ROUNDOFF);
    // Bounds that overflow are NaN, and nothing is above those.
    let is_significant = cross.abs().cmpgt(from_edges + from_products).any();
    is_significant.then_some(cross)
}

/// The edges of a triangle; edge i leads from corner i + 1 to corner i + 2 and lies opposite corner i.
pub(super) fn edges_of([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    [c - b, a - c, b - a]
}

pub(super) fn longest_edge(edges: [DVec3; 3]) -> usize {
    let [a, b, c] = edges.map(|edge| edge.abs().max_element());
    let scale = scale_to_one(a.max(b).max(c));
    let [a, b, c] = edges.map(|edge| (edge * scale).length_squared());
    if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    }
}

/// The cross product with sums in place of differences, which bounds its terms; both vectors non-negative.
fn absolute_cross(p: DVec3, q: DVec3) -> DVec3 {
    DVec3::new(
        p.y * q.z + p.z * q.y,
        p.z * q.x + p.x * q.z,
        p.x * q.y + p.y * q.x,
    )
}

/// A power of two that brings `magnitude`, finite and not negative, near 1: into `[1, 2)` unless it is subnormal.
pub(super) fn scale_to_one(magnitude: f64) -> f64 {
    const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    // Biased exponents add up to 2 · 1023 when powers of two multiply to 1; 0 and 2047 are not powers of two.
    let exponent = magnitude.to_bits() >> MANTISSA_BITS;
    f64::from_bits(2046_u64.saturating_sub(exponent).max(1) << MANTISSA_BITS)
}

/// `vector` with its largest coordinate brought near 1.
pub(super) fn near_one(vector: DVec3) -> DVec3 {
    vector * scale_to_one(vector.abs().max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// Triangles from well shaped to none at all, of every size and far from the origin.
    #[test]
    fn area_is_told_as_normals_are() {
        let mut random = Random::new(3);
        let mut clear = 0;
        for round in 0..200_000 {
            let mut point = || DVec3::new(random.unit(), random.unit(), random.unit()) - 0.5;
            let (a, b, aside) = (point(), point(), point());
            let thinness = 10_f64.powi(-(round % 20));
            let along = random.unit() * 3.0 - 1.0;
            let c = a + (b - a) * along + aside * thinness;
            let scale = 10_f64.powi(round % 37 * 12 - 216);
            let offset = DVec3::splat(if round % 3 == 0 { 1e6 } else { 0.0 });
            let corners = [a, b, c].map(|corner| (corner + offset) * scale);
            assert_eq!(
                has_area(corners),
                face_normal(corners).is_some(),
                "{corners:?}"
            );
            clear += u32::from(is_clear(corners));
        }
        assert!((20_000..180_000).contains(&clear), "{clear}");
        for corners in [[DVec3::ZERO; 3], [DVec3::MAX, DVec3::MIN, DVec3::X]] {
            assert_eq!(has_area(corners), face_normal(corners).is_some());
        }
    }
}
