//! How large a mesh is against the digits of its coordinates, and whether some of these were lost before its file was written.

use std::fmt;

use super::TriangleMesh;
use super::triangle::narrowed;
use crate::math::{DBounds, length_of, percent, three_digits};

/// The largest move of a corner, as a share of the median edge, that can be neglected: faces turn by about half a degree.
const MOST_OF_EDGE: f64 = 1e-2;
/// The same as a share of the mesh's size.
const MOST_OF_SIZE: f64 = 1e-3;

/// Edges of so many triangles, evenly spread over the mesh, stand for all where the median is looked for.
const MOST_MEASURED: usize = 100_000;

/// Of coordinates that have all digits of an `f32`, half have its last bit. So few may be enough where many are round.
const LEAST_SHARE_OF_LAST_BITS: f64 = 0.1;

/// How large a mesh is, in its own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSize {
    /// The box around its triangles.
    pub bounds: DBounds,
    /// The diagonal of its box; more than 0.
    pub diagonal: f64,
    /// The median length of its edges; more than 0.
    pub median_edge: f64,
}

impl MeshSize {
    /// `None` where there is nothing, or most corners are one.
    #[must_use]
    pub fn of(mesh: &TriangleMesh) -> Option<Self> {
        let bounds = mesh.bounds();
        if bounds.is_empty() {
            return None;
        }
        let diagonal = length_of(bounds.size());
        let step = mesh.triangles.len().div_ceil(MOST_MEASURED).max(1);
        let faces = (0..mesh.triangles.len()).step_by(step);
        let mut edges: Vec<f64> = faces
            .flat_map(|face| {
                let [a, b, c] = mesh.corners(face);
                [b - a, c - b, a - c].map(length_of)
            })
            .collect();
        let middle = edges.len() / 2;
        let (_, &mut median_edge, _) = edges.select_nth_unstable_by(middle, f64::total_cmp);
        (diagonal > 0.0 && median_edge > 0.0).then_some(Self {
            bounds,
            diagonal,
            median_edge,
        })
    }

    /// Whether a move by `length`, in the mesh's unit, is too much to be neglected.
    #[must_use]
    pub fn shows(&self, length: f64) -> bool {
        length > MOST_OF_EDGE * self.median_edge || length > MOST_OF_SIZE * self.diagonal
    }
}

/// A mesh whose coordinates were rounded to `f32` before they were written, too far from their origin for what it shows. Written out, it
/// is a sentence without its subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostDigits {
    /// The largest coordinate.
    pub farthest: f64,
    /// The distance of neighbouring `f32` numbers there over the median edge.
    pub of_edge: f64,
}

impl LostDigits {
    /// What `mesh` has lost, if it has. Takes one look at every triangle, and another where digits are few.
    #[must_use]
    pub fn of(mesh: &TriangleMesh) -> Option<Self> {
        Self::of_measured(mesh, &MeshSize::of(mesh)?)
    }

    /// [`Self::of`] a mesh of known size.
    #[must_use]
    pub fn of_measured(mesh: &TriangleMesh, size: &MeshSize) -> Option<Self> {
        let DBounds { min, max } = size.bounds;
        let farthest = min.abs().max(max.abs()).max_element();
        let spacing = spacing_at(farthest);
        if !size.shows(spacing) {
            return None;
        }
        let (mut numbers, mut odd, mut is_whole) = (0_u64, 0_u64, true);
        for &vertex in mesh.triangles.iter().flatten() {
            for coordinate in mesh.positions[vertex as usize].to_array() {
                let narrow = narrowed(coordinate);
                if f64::from(narrow) != coordinate {
                    return None;
                }
                // Only coordinates as far out as the figure is about tell.
                if spacing_at(coordinate) * 2.0 >= spacing {
                    numbers += 1;
                    odd += u64::from(narrow.to_bits() & 1);
                    is_whole &= coordinate.fract() == 0.0;
                }
            }
        }
        // Up to 2²⁴ whole numbers are all there: whoever counts in small units has lost nothing.
        let is_exact = is_whole && spacing <= 1.0;
        let is_lost =
            !is_exact && odd > 0 && odd as f64 >= LEAST_SHARE_OF_LAST_BITS * numbers as f64;
        is_lost.then(|| Self {
            farthest,
            of_edge: spacing / size.median_edge,
        })
    }
}

impl fmt::Display for LostDigits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the coordinates in the file were rounded to 32 bits up to {} from their origin, where these are {} of the median edge apart",
            three_digits(self.farthest),
            percent(self.of_edge)
        )
    }
}

/// The distance of the `f32` numbers around `value`.
#[must_use]
pub fn spacing_at(value: f64) -> f64 {
    let narrow = narrowed(value.abs());
    f64::from(narrow.next_up()) - f64::from(narrow)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{cuboid, icosphere};
    use crate::math::DVec3;

    fn moved(mut mesh: TriangleMesh, by: DVec3, is_narrow: bool) -> TriangleMesh {
        for p in &mut mesh.positions {
            *p += by;
            if is_narrow {
                *p = p.as_vec3().as_dvec3();
            }
        }
        mesh
    }

    #[test]
    fn digits_are_lost_far_out_and_in_single_precision() {
        let lost = |distance: f64, is_narrow: bool| {
            let ball = moved(icosphere(3), DVec3::X * distance, is_narrow);
            LostDigits::of(&ball)
        };
        assert_eq!(lost(2.0, true), None);
        assert_eq!(lost(2e5, false), None);
        let found = lost(2e5, true).expect("is lost");
        assert!((found.farthest - 200_001.0).abs() < 0.1, "{found:?}");
        // From 131072 to 262144, numbers are 1/64 apart.
        assert!((found.of_edge * 0.154 * 64.0 - 1.0).abs() < 0.2, "{found}");
        assert!(found.to_string().contains("2.00e5"), "{found}");
        // Whole numbers have all their digits.
        let cube = moved(cuboid(DVec3::ZERO, DVec3::ONE), DVec3::splat(1e6), true);
        assert_eq!(LostDigits::of(&cube), None);
        assert_eq!(LostDigits::of(&TriangleMesh::default()), None);
    }
}
