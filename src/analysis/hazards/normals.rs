//! Normals that the file gave, against the faces.

use super::mesh_use::MeshUse;
use super::tally::Tally;
use super::{Hazard, HazardKind, Severity, stops};
use crate::control::CancelToken;
use crate::geometry::face_normal;
use crate::math::DVec3;

/// Examines the normals in the file of `mesh`, where it has any. `None` when cancelled.
pub fn examine(mesh: &MeshUse<'_>, cancel: &CancelToken) -> Option<Vec<Hazard>> {
    let Some(normals) = &mesh.mesh.normals else {
        return Some(Vec::new());
    };
    let (mut opposed, mut zero) = (Tally::default(), Tally::default());
    let mut corners_with_area = 0_u64;
    for (face, triangle) in mesh.mesh.triangles.iter().enumerate() {
        if stops(cancel, face) {
            return None;
        }
        let corners = mesh.mesh.corners(face);
        let facing = face_normal(corners);
        for (&vertex, corner) in triangle.iter().zip(corners) {
            let normal = normals[vertex as usize];
            if normal == DVec3::ZERO {
                zero.add(|| mesh.place(&[face], corner));
            } else if let Some(facing) = facing {
                corners_with_area += 1;
                if normal.dot(facing) < 0.0 {
                    opposed.add(|| mesh.place(&[face], corner));
                }
            }
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
