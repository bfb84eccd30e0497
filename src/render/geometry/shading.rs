//! Normals that prepared triangles do not have: those of smooth objects, and those of triangles that rounding to `f32` has turned.

use rayon::prelude::*;

use crate::control::CancelToken;
use crate::geometry::{CornerNormals, Triangle, face_normal};
use crate::math::{DVec3, Vec3};

/// The normals that shade one copy of an object, where they are not those of its prepared triangles.
#[derive(Debug)]
pub enum ShadingNormals {
    /// Of a smooth object: those of all corners.
    Smooth(SmoothNormals),
    /// Of a flat one: those of the triangles whose rounded corners have another normal.
    Flat(TrueNormals),
}

/// Shading normals of all corners.
#[derive(Debug)]
pub struct SmoothNormals {
    /// Unit vectors.
    normals: Vec<Vec3>,
    /// Indices into `normals` for the three corners of each triangle.
    corners: Vec<[u32; 3]>,
}

/// Normals of the few triangles that are so thin, or so small for where they are, that rounding their corners turns them.
#[derive(Debug)]
pub struct TrueNormals {
    /// Numbers of triangles within a copy, ascending.
    triangles: Vec<u32>,
    /// Unit vectors, one for each.
    normals: Vec<Vec3>,
}

impl ShadingNormals {
    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Smooth(smooth) => {
                size_of_val(&smooth.normals[..]) + size_of_val(&smooth.corners[..])
            }
            Self::Flat(flat) => size_of_val(&flat.triangles[..]) + size_of_val(&flat.normals[..]),
        }
    }

    /// The normals of the corners of the triangle number `index` of a copy; `None` where it is shaded by its own.
    #[must_use]
    #[inline]
    pub fn of_corners(&self, index: u32) -> Option<[Vec3; 3]> {
        match self {
            Self::Smooth(smooth) => {
                let corners = smooth.corners[index as usize];
                Some(corners.map(|normal| smooth.normals[normal as usize]))
            }
            Self::Flat(few) => {
                let place = few.triangles.binary_search(&index).ok()?;
                Some([few.normals[place]; 3])
            }
        }
    }
}

impl SmoothNormals {
    /// `normals` in the directions that `turned` gives them, for the corners in the order that `ordered` gives them.
    pub fn new(
        normals: CornerNormals,
        turned: impl Fn(DVec3) -> DVec3,
        ordered: impl Fn([u32; 3]) -> [u32; 3],
    ) -> Self {
        let CornerNormals { normals, corners } = normals;
        Self {
            normals: normals.into_iter().map(|n| turned(n).as_vec3()).collect(),
            corners: corners.into_iter().map(ordered).collect(),
        }
    }
}

impl TrueNormals {
    /// Looks through `rounded`, the prepared triangles of one copy or several, `per_copy` each. `exact`: the corners of a
    /// triangle of a copy before they were rounded, in the same order and orientation, of any scale. None where all normals are
    /// as they should be; `None` when cancelled.
    #[expect(
        clippy::option_option,
        reason = "there may be none, and it may be cancelled"
    )]
    pub fn of_copies(
        rounded: &[Triangle],
        per_copy: usize,
        exact: impl Fn(usize) -> [DVec3; 3] + Sync,
        cancel: &CancelToken,
    ) -> Option<Option<Self>> {
        let mut found: Vec<(u32, Vec3)> = rounded
            .par_iter()
            .enumerate()
            .filter(|(_, triangle)| !cancel.is_cancelled() && may_be_turned(triangle))
            .filter_map(|(index, triangle)| {
                let index = index % per_copy;
                let normal = face_normal(exact(index))?;
                let is_turned = triangle.normal().as_dvec3().distance(normal) > MOST_TURN;
                let index = u32::try_from(index).expect("triangles can be numbered");
                is_turned.then(|| (index, normal.as_vec3()))
            })
            .collect();
        if cancel.is_cancelled() {
            return None;
        }
        found.par_sort_unstable_by_key(|(index, _)| *index);
        found.dedup_by_key(|(index, _)| *index);
        let (triangles, normals): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        Some((!triangles.is_empty()).then_some(Self { triangles, normals }))
    }
}

/// How far, in radians, rounding may turn a triangle before it is shaded by its true normal: less than a shade of a screen shows.
const MOST_TURN: f64 = 1e-4;

/// Whether rounding its corners to `f32` may have turned `triangle` by more than [`MOST_TURN`].
fn may_be_turned(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let (ab, ac) = (b - a, c - a);
    let longest = ab.length().max(ac.length()).max(ab.distance(ac));
    // Each corner is off by at most √3 half units in the last place, the normal by the corners' errors over the heights, and
    // the least height is the doubled area over the longest edge.
    let corner_error = 3_f64.sqrt() * largest * f64::from(f32::EPSILON) / 2.0;
    3.0 * corner_error * longest > MOST_TURN * ab.cross(ac).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// Slivers of known direction: the true normals are found, and only where they are missed.
    #[test]
    fn normals_that_rounding_turned_are_replaced() {
        let mut random = Random::new(3);
        let mut turned = 0;
        for aspect in [1.0, 1e-2, 1e-4, 1e-6] {
            let exact: Vec<[DVec3; 3]> = (0..200)
                .map(|_| {
                    let along = random.in_cube().normalize();
                    let across = along.cross(random.in_cube()).normalize();
                    let corner = random.in_cube() * 0.3;
                    [
                        corner,
                        corner + along * 0.5,
                        corner + along * 0.2 + across * (0.5 * aspect),
                    ]
                })
                .collect();
            let rounded: Vec<Triangle> = exact
                .iter()
                .map(|corners| Triangle {
                    corners: corners.map(DVec3::as_vec3),
                })
                .collect();
            let exact_of = |index: usize| exact[index];
            let never = CancelToken::new();
            let found = TrueNormals::of_copies(&rounded, rounded.len(), exact_of, &never);
            let found = found.expect("nobody cancels").map(ShadingNormals::Flat);
            for (number, triangle) in (0..).zip(&rounded) {
                let [a, b, c] = exact[number as usize];
                let normal = (b - a).cross(c - a).normalize();
                let own = triangle.normal().as_dvec3();
                match found.as_ref().and_then(|found| found.of_corners(number)) {
                    Some(corners) => {
                        turned += 1;
                        assert!(own.distance(normal) > 0.99 * MOST_TURN);
                        assert!(corners[0].as_dvec3().distance(normal) < 1e-7);
                    }
                    None => assert!(own.distance(normal) < 1.01 * MOST_TURN, "{aspect}"),
                }
            }
            if aspect == 1.0 {
                assert!(found.is_none());
            }
        }
        assert!(turned > 200, "{turned} of 800 are turned");
    }
}
