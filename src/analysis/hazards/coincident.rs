//! Faces of different objects, or of copies of one, that lie in the same place.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::mesh_use::{bounds_of_first_copy, middle_of};
use super::pair::{Pair, Shows};
use super::tally::Tally;
use super::{Hazard, HazardKind, Place};
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::math::{DBounds, DMat3, DVec3, SceneFrame, Vec3};
use crate::scene::{Scene, SceneError};

/// The most pairs of boxes that are looked at one by one; where there are more, any face may be in the way of any other.
const MOST_PAIRS: usize = 50_000_000;

/// The most faces that are compared: a quarter of a gigabyte of them.
const MOST_COMPARED: usize = 1 << 24;

/// By how much boxes are enlarged, in prepared units: several times what rounding moves.
const SLACK: f64 = 1e-6;

/// Looks for faces of different objects or copies with the same three corners, after rounding to `f32`. `None` when cancelled.
///
/// # Errors
/// Meshes and materials that are not there.
pub fn examine(
    scene: &Scene,
    frame: &SceneFrame,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let parts = parts_of(scene, frame)?;
    let Some(common) = common_boxes(&parts, cancel) else {
        return Ok(None);
    };
    let count = |(part, common): (&Part<'_>, &DBounds)| {
        let mut count = 0_usize;
        if !cancel.is_cancelled() {
            part.for_each_face_within(common, |_, _| count += 1);
        }
        count
    };
    let counts: Vec<usize> = parts.par_iter().zip(&common).map(count).collect();
    // The first faces are compared, whichever thread comes to them first.
    let mut total = 0;
    let starts = counts.iter().map(|count| {
        total += count;
        total - count
    });
    let shares: Vec<usize> = starts
        .map(|start| MOST_COMPARED.saturating_sub(start))
        .collect();
    let collect = |((part, common), &share): ((&Part<'_>, &DBounds), &usize)| {
        let mut faces = Vec::new();
        if !cancel.is_cancelled() {
            part.for_each_face_within(common, |face, corners| {
                if faces.len() < share {
                    faces.push((fingerprint(corners), part.number, face));
                }
            });
        }
        faces
    };
    let mut faces: Vec<(u64, u32, u32)> = parts
        .par_iter()
        .zip(&common)
        .zip(&shares)
        .flat_map_iter(collect)
        .collect();
    if cancel.is_cancelled() {
        return Ok(None);
    }
    faces.par_sort_unstable();
    let mut found = pairs_among(scene, frame, &parts, &faces)?;
    if total > MOST_COMPARED {
        found.push(unexamined(total));
    }
    Ok(Some(found))
}

/// One copy of an object.
struct Part<'a> {
    number: u32,
    object: usize,
    mesh: &'a TriangleMesh,
    /// From the mesh to the prepared scene.
    linear: DMat3,
    translate: DVec3,
    /// In the prepared scene, with slack.
    bounds: DBounds,
}

fn parts_of<'a>(scene: &'a Scene, frame: &SceneFrame) -> Result<Vec<Part<'a>>, SceneError> {
    let mut parts = Vec::new();
    for (object_number, object) in scene.objects.iter().enumerate() {
        let mesh = &**scene.mesh_of(object)?;
        let placement = object.placement();
        let bounds = bounds_of_first_copy(object, mesh);
        if bounds.is_empty() {
            continue;
        }
        for offset in object.copies.offsets() {
            let prepared = |p: DVec3, slack: f64| frame.prepared_from_world(p + offset) + slack;
            parts.push(Part {
                number: u32::try_from(parts.len()).expect("no more copies than triangles"),
                object: object_number,
                mesh,
                linear: placement.linear * frame.scale(),
                translate: prepared(placement.translate, 0.0),
                bounds: DBounds {
                    min: prepared(bounds.min, -SLACK),
                    max: prepared(bounds.max, SLACK),
                },
            });
        }
    }
    Ok(parts)
}

impl Part<'_> {
    /// Calls `visit` with every face that lies in `common` entirely, and its corners as the prepared scene has them.
    fn for_each_face_within(&self, common: &DBounds, mut visit: impl FnMut(u32, [Vec3; 3])) {
        if common.is_empty() {
            return;
        }
        let prepared =
            |vertex: u32| self.linear * self.mesh.positions[vertex as usize] + self.translate;
        for (face, triangle) in self.mesh.triangles.iter().enumerate() {
            if !common.contains(prepared(triangle[0])) {
                continue;
            }
            let corners = triangle.map(prepared);
            if corners.iter().all(|&corner| common.contains(corner)) {
                let face = u32::try_from(face).expect("triangles are numbered in 32 bits");
                visit(face, corners.map(DVec3::as_vec3));
            }
        }
    }
}

/// For each part a box around all it has in common with the boxes of others, empty where that is nothing. `None` when cancelled.
fn common_boxes(parts: &[Part<'_>], cancel: &CancelToken) -> Option<Vec<DBounds>> {
    let all = parts
        .iter()
        .fold(DBounds::EMPTY, |all, part| all.union(part.bounds));
    let axis = if all.is_empty() {
        0
    } else {
        all.size().max_position()
    };
    let mut order: Vec<usize> = (0..parts.len()).collect();
    let start = |&part: &usize| parts[part].bounds.min[axis];
    order.sort_by(|a, b| start(a).total_cmp(&start(b)));
    let mut common = vec![DBounds::EMPTY; parts.len()];
    let mut pairs = 0;
    for (index, &a) in order.iter().enumerate() {
        if cancel.is_cancelled() {
            return None;
        }
        let overlapping = |b: &&usize| start(b) <= parts[a].bounds.max[axis];
        for &b in order[index + 1..].iter().take_while(overlapping) {
            pairs += 1;
            let both = parts[a].bounds.intersection(parts[b].bounds);
            if !both.is_empty() {
                common[a] = common[a].union(both);
                common[b] = common[b].union(both);
            }
        }
        if pairs > MOST_PAIRS {
            return Some(parts.iter().map(|part| part.bounds).collect());
        }
    }
    Some(common)
}

/// A number that is the same for faces with the same corners in any order; among all faces that are compared, any two others share theirs
/// with a probability below 10⁻⁵.
fn fingerprint(corners: [Vec3; 3]) -> u64 {
    // A sum with 0 makes 0 of −0.
    let mut corners = corners.map(|corner| (corner + 0.0).to_array().map(f32::to_bits));
    corners.sort_unstable();
    corners.iter().flatten().fold(0, |hash: u64, &bits| {
        // The finalizer of splitmix64: every bit of the input reaches every bit of the output.
        let mut mixed = hash
            .wrapping_add(u64::from(bits))
            .wrapping_add(0x9E37_79B9_7F4A_7C15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    })
}

/// The hazards among `faces`: fingerprint, number of the part, number of the triangle, in this order.
fn pairs_among(
    scene: &Scene,
    frame: &SceneFrame,
    parts: &[Part<'_>],
    faces: &[(u64, u32, u32)],
) -> Result<Vec<Hazard>, SceneError> {
    let mut tallies: BTreeMap<[usize; 2], Tally> = BTreeMap::new();
    for group in faces.chunk_by(|a, b| a.0 == b.0) {
        let (_, first, first_face) = group[0];
        let mut previous = first;
        for &(_, other, face) in group {
            // Doubles within one part are told of elsewhere.
            if other == previous {
                continue;
            }
            previous = other;
            let [a, b] = [first, other].map(|number| &parts[number as usize]);
            let place = || {
                let middle = middle_of(a.mesh.corners(first_face as usize));
                let middle = frame.world_from_prepared(a.linear * middle + a.translate);
                Place {
                    faces: vec![first_face as usize, face as usize],
                    position: Some(middle.to_array()),
                    pixel: None,
                }
            };
            tallies.entry([a.object, b.object]).or_default().add(place);
        }
    }
    let hazard = |(numbers, tally)| hazard(scene, numbers, tally);
    tallies.into_iter().map(hazard).collect()
}

fn hazard(scene: &Scene, numbers: [usize; 2], tally: Tally) -> Result<Hazard, SceneError> {
    let pair = Pair::of(scene, numbers)?;
    let advice = match pair.shows {
        Shows::Glass => {
            "Let only one of them have the face, or move them apart or into each other a little: light that crosses both at once is \
             bent by one of them only."
        }
        Shows::Alike => {
            "Nothing needs to be done: both look the same there. One of them can be removed."
        }
        Shows::Either => {
            "Remove one of them, or move one a little: the one that comes first in the scene is seen, unless rounding decides \
             otherwise."
        }
    };
    let who = if numbers[0] == numbers[1] {
        "of two copies"
    } else {
        "of both"
    };
    Ok(Hazard {
        message: format!(
            "{} {who} in the same place, all three corners",
            tally.of("face lies", "faces lie")
        ),
        advice: advice.to_owned(),
        ..pair.hazard(HazardKind::CoincidentFaces, tally)
    })
}

fn unexamined(candidates: usize) -> Hazard {
    let message = format!(
        "of {candidates} faces that may lie in the same place as others, {MOST_COMPARED} were compared"
    );
    Hazard::unexamined(candidates - MOST_COMPARED, message)
}
