//! Faces by themselves: without area, thin, doubled.

use super::mesh_use::MeshUse;
use super::tally::Tally;
use super::{Figure, Hazard, HazardKind, Severity, stops};
use crate::control::CancelToken;
use crate::geometry::{Buckets, Welded, face_normal};
use crate::math::{DVec3, three_digits};

/// Height over longest edge below which a face is a sliver. A face of a well-made mesh has more than a hundredth; from here on,
/// the seventh digit of a coordinate turns a face by more than 0.05°.
const SLIVER: f64 = 1e-4;

/// Examines the faces of `mesh` by themselves. Also tells for each face whether its edges are to be left out of account: two of its
/// corners are one, or an earlier face has the same three. `None` when cancelled.
pub fn examine(
    mesh: &MeshUse<'_>,
    welded: &Welded,
    cancel: &CancelToken,
) -> Option<(Vec<Hazard>, Vec<bool>)> {
    let mut hazards = shapes(mesh, cancel)?;
    let (duplicates, left_out) = duplicates(mesh, welded, cancel)?;
    if duplicates.count > 0 {
        let severity = if mesh.is_glass {
            Severity::Warning
        } else {
            Severity::Note
        };
        let message = format!(
            "{} the same three corners as an earlier one",
            duplicates.of("face has", "faces have")
        );
        let advice = if mesh.is_glass {
            "Remove them: light crosses such a face twice where it should cross it once."
        } else {
            "Remove them: they cost time and memory. Only the earlier one is seen."
        };
        hazards.push(Hazard {
            message,
            advice: advice.to_owned(),
            ..mesh.hazard(HazardKind::DuplicateFaces, severity, duplicates)
        });
    }
    Some((hazards, left_out))
}

/// Faces without area, and slivers.
fn shapes(mesh: &MeshUse<'_>, cancel: &CancelToken) -> Option<Vec<Hazard>> {
    let (mut flat, mut slivers) = (Tally::default(), Tally::default());
    let mut thinnest = f64::INFINITY;
    for face in 0..mesh.mesh.triangles.len() {
        if stops(cancel, face) {
            return None;
        }
        let corners = mesh.mesh.corners(face);
        let aspect = aspect(corners);
        if aspect >= SLIVER {
            continue;
        }
        if face_normal(corners).is_none() {
            flat.add(|| mesh.place_of_face(face));
        } else {
            slivers.add(|| mesh.place_of_face(face));
            thinnest = thinnest.min(aspect);
        }
    }
    let mut hazards = Vec::new();
    if flat.count > 0 {
        hazards.push(Hazard {
            message: format!("{} no area", flat.of("face has", "faces have")),
            advice: "Remove them, and join the corners they connect: where one lies between two faces, the surface may have a crack."
                .to_owned(),
            ..mesh.hazard(HazardKind::ZeroArea, Severity::Note, flat)
        });
    }
    if slivers.count > 0 {
        hazards.push(Hazard {
            figure: Some(Figure {
                value: thinnest,
                of: "least height over longest edge",
            }),
            message: format!(
                "{}, the thinnest {} times as high as long",
                slivers.of("face is a sliver", "faces are slivers"),
                three_digits(thinnest)
            ),
            advice: "They are rendered as they are, but the last digits in the file decide which way they face. Remesh, or merge \
                     corners that nearly coincide."
                .to_owned(),
            ..mesh.hazard(HazardKind::Slivers, Severity::Note, slivers)
        });
    }
    Some(hazards)
}

/// The least height of a triangle over its longest edge, 0.87 at most; 0 where all corners are one.
fn aspect([a, b, c]: [DVec3; 3]) -> f64 {
    let edges = [b - a, c - b, a - c];
    let largest = edges.map(|edge| edge.abs().max_element());
    let unit = largest[0].max(largest[1]).max(largest[2]);
    if unit == 0.0 {
        return 0.0;
    }
    let edges = edges.map(|edge| edge / unit);
    let squares = edges.map(DVec3::length_squared);
    let longest = squares[0].max(squares[1]).max(squares[2]);
    // The cross product of the two shorter edges loses fewest digits.
    let cross = if squares[0] == longest {
        edges[1].cross(edges[2])
    } else if squares[1] == longest {
        edges[2].cross(edges[0])
    } else {
        edges[0].cross(edges[1])
    };
    cross.length() / longest
}

/// Faces with the same three corners as an earlier one; and which faces are to be left out of account as edges go.
fn duplicates(
    mesh: &MeshUse<'_>,
    welded: &Welded,
    cancel: &CancelToken,
) -> Option<(Tally, Vec<bool>)> {
    let triangles = &mesh.mesh.triangles;
    let sorted = |face: u32| {
        let mut corners = welded.corners(triangles[face as usize]);
        corners.sort_unstable();
        corners
    };
    let count = u32::try_from(triangles.len()).expect("fewer than 2^32 triangles");
    let by_first = Buckets::new(
        welded.vertices(),
        (0..count).map(|face| (sorted(face)[0], face)),
    );
    let mut tally = Tally::default();
    let mut left_out = vec![false; triangles.len()];
    let mut around = Vec::new();
    for vertex in 0..by_first.len() {
        if stops(cancel, vertex) {
            return None;
        }
        around.clear();
        around.extend(by_first.of(vertex).iter().map(|&face| (sorted(face), face)));
        around.sort_unstable();
        for (index, &([a, b, c], face)) in around.iter().enumerate() {
            let has_two_corners = a == b || b == c;
            let repeats = index > 0 && around[index - 1].0 == [a, b, c];
            left_out[face as usize] = has_two_corners || repeats;
            if repeats && !has_two_corners {
                tally.add(|| mesh.place_of_face(face as usize));
            }
        }
    }
    Some((tally, left_out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aspects_are_those_of_the_shape_at_any_size() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::new(3.0, 0.5, 0.0)];
        for size in [1e-200, 1.0, 1e200] {
            for turn in 0..3 {
                let corner = |index: usize| corners[(index + turn) % 3] * size;
                let found = aspect([0, 1, 2].map(corner));
                assert!((found - 0.125).abs() < 1e-15, "{size} {turn}: {found}");
            }
        }
        assert_eq!(aspect([DVec3::ONE; 3]), 0.0);
    }
}
