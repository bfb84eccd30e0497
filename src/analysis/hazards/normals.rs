//! Normals that the file gave, against the faces.

use super::mesh_use::MeshUse;
use super::tally::Tally;
use super::{Hazard, HazardKind, Severity, stops};
use crate::control::CancelToken;
use crate::geometry::face_normal;
use crate::math::{DVec3, length_of};

/// The cosine of 75°, from which on normals lean far away from their face. The smooth normals of a tetrahedron lean by 70.5°, those of a
/// cube by 54.7°.
const LEANING: f64 = 0.258_819;
/// The share of faces whose normals all lean that far which is told: narrow faces at a rim do in sound files.
const NOTABLE_SHARE: f64 = 0.1;

/// Examines the normals in the file of `mesh`, where it has any. `None` when cancelled.
pub fn examine(mesh: &MeshUse<'_>, cancel: &CancelToken) -> Option<Vec<Hazard>> {
    let Some(normals) = &mesh.mesh.normals else {
        return Some(Vec::new());
    };
    let (mut opposed, mut zero) = (Tally::default(), Tally::default());
    let mut leaning = Tally::default();
    let (mut faces_with_area, mut corners_with_area) = (0_u64, 0_u64);
    for (face, triangle) in mesh.mesh.triangles.iter().enumerate() {
        if stops(cancel, face) {
            return None;
        }
        let corners = mesh.mesh.corners(face);
        let facing = face_normal(corners);
        let mut leans = facing.is_some();
        faces_with_area += u64::from(leans);
        for (&vertex, corner) in triangle.iter().zip(corners) {
            let normal = normals[vertex as usize];
            if normal == DVec3::ZERO {
                zero.add(|| mesh.place(&[face], corner));
                leans = false;
            } else if let Some(facing) = facing {
                corners_with_area += 1;
                let along = normal.dot(facing);
                if along < 0.0 {
                    opposed.add(|| mesh.place(&[face], corner));
                }
                leans &= (0.0..LEANING * length_of(normal)).contains(&along);
            }
        }
        if leans {
            leaning.add(|| mesh.place_of_face(face));
        }
    }
    let severity = if mesh.is_smooth {
        Severity::Warning
    } else {
        Severity::Note
    };
    let unused = if mesh.is_smooth {
        ""
    } else {
        " As long as no object with this mesh is smooth, they are not used."
    };
    let mut hazards = Vec::new();
    if opposed.count > 0 {
        let most = opposed.count * 2 > corners_with_area;
        let advice = if most {
            "Turn the normals or the faces round: one of both is inside out."
        } else {
            "Let the program that made the file recalculate the normals."
        };
        hazards.push(Hazard {
            message: format!(
                "{} of {corners_with_area} corners {} a normal in the file that leans away from the side its face looks to",
                opposed.count,
                if opposed.count == 1 { "has" } else { "have" }
            ),
            advice: format!("{advice}{unused}"),
            ..mesh.hazard(HazardKind::OpposedNormals, severity, opposed)
        });
    }
    if leaning.count > 0 && leaning.count as f64 >= NOTABLE_SHARE * faces_with_area as f64 {
        hazards.push(Hazard {
            message: format!(
                "{} of {faces_with_area} faces {} normals in the file that all lean more than 75° away from the face",
                leaning.count,
                if leaning.count == 1 { "has" } else { "have" }
            ),
            advice: format!(
                "They shade the surface as if it were nearly at right angles to where it is. Let the program that made the file \
                 recalculate the normals.{unused}"
            ),
            ..mesh.hazard(HazardKind::LeaningNormals, severity, leaning)
        });
    }
    if zero.count > 0 {
        hazards.push(Hazard {
            message: format!(
                "{} a normal in the file that is zero",
                zero.of("corner has", "corners have")
            ),
            advice: format!("There, the normal is averaged from the faces instead.{unused}"),
            ..mesh.hazard(HazardKind::ZeroNormals, Severity::Note, zero)
        });
    }
    Some(hazards)
}
