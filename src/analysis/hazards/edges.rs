//! Edges between faces: open ones, crowded ones, and the way round that faces turn on both sides.

use super::mesh_use::MeshUse;
use super::tally::Tally;
use super::{Hazard, HazardKind, Place, Severity, stops};
use crate::control::CancelToken;
use crate::geometry::{Edges, Shell, Shells, Side, Welded, face_normal};
use crate::math::{counted, length_of};

/// What a flat sheet may deviate from its plane, of its size: the rounding of coordinates with few digits.
const FLAT: f64 = 1e-5;

/// Examines where the faces of `mesh` meet, but for those `left_out`; corners at the same place are one. `None` when cancelled.
pub fn examine(
    mesh: &MeshUse<'_>,
    welded: &Welded,
    left_out: &[bool],
    cancel: &CancelToken,
) -> Option<Vec<Hazard>> {
    let mut found = Found::default();
    let mut shells = Shells::new(left_out.len());
    let edges = Edges::of(&mesh.mesh, welded, left_out);
    let mut at_vertex = Vec::new();
    for vertex in 0..edges.vertices() {
        if stops(cancel, vertex) {
            return None;
        }
        edges.collect_from(vertex, &mut at_vertex);
        for edge in Side::by_edge(&at_vertex) {
            let place = || place(mesh, &edges, edge);
            match *edge {
                [side] => {
                    found.open.add(place);
                    shells.open_at(side.face());
                }
                [a, b] => {
                    let both_run_the_same_way = a.runs_along(b);
                    found.disagreeing += u64::from(both_run_the_same_way);
                    shells.join(a.face(), b.face(), both_run_the_same_way);
                }
                _ => found.crowded.add(place),
            }
        }
    }
    drop(edges);
    shells.settle();
    let is_turned = shells.turned();
    let mut turned = Tally::default();
    for (face, _) in is_turned.iter().enumerate().filter(|(_, turned)| **turned) {
        turned.add(|| mesh.place_of_face(face));
    }
    let mut closed = shells.closed(&mesh.mesh, left_out, &is_turned);
    closed.retain(|shell| !shell.is_mixed);
    let mut inside_out = Tally::default();
    for shell in Shell::inside_out(&closed) {
        inside_out.add(|| mesh.place_of_face(shell.first_face));
    }
    let hazards = [
        found.open_edges(mesh),
        found.crowded_edges(mesh),
        flipped_windings(mesh, turned, found.disagreeing, shells.contradictions()),
        inside_out_shells(mesh, inside_out),
    ];
    Some(hazards.into_iter().flatten().collect())
}

#[derive(Default)]
struct Found {
    open: Tally,
    crowded: Tally,
    /// Edges whose two faces turn round in opposite ways.
    disagreeing: u64,
}

/// The place of an edge: its middle.
fn place(mesh: &MeshUse<'_>, edges: &Edges<'_>, edge: &[Side]) -> Place {
    let faces: Vec<usize> = edge.iter().map(|side| side.face()).collect();
    let ends = edges.ends(edge[0]);
    let [from, to] = ends.map(|vertex| mesh.mesh.positions[vertex as usize]);
    mesh.place(&faces, from * 0.5 + to * 0.5)
}

impl Found {
    fn open_edges(&mut self, mesh: &MeshUse<'_>) -> Option<Hazard> {
        let tally = std::mem::take(&mut self.open);
        if tally.count == 0 || (!mesh.is_glass && is_flat(mesh)) {
            return None;
        }
        let (severity, advice) = if mesh.is_glass {
            (
                Severity::Warning,
                "Close the mesh: light that enters an open body of glass may never leave it, so that it is bent once in place of \
                 twice and absorbed without end.",
            )
        } else {
            (
                Severity::Note,
                "Nothing needs to be done where a sheet or an opening is meant. Else close the mesh: light passes through the gaps.",
            )
        };
        Some(Hazard {
            message: format!(
                "{} to one face only: the surface is open there",
                tally.of("edge belongs", "edges belong")
            ),
            advice: advice.to_owned(),
            ..mesh.hazard(HazardKind::OpenEdges, severity, tally)
        })
    }

    fn crowded_edges(&mut self, mesh: &MeshUse<'_>) -> Option<Hazard> {
        let tally = std::mem::take(&mut self.crowded);
        if tally.count == 0 {
            return None;
        }
        let (severity, advice) = if mesh.is_glass {
            (
                Severity::Warning,
                "Let exactly two faces meet at every edge: where walls within the glass meet its surface, inside and outside are \
                 mixed up.",
            )
        } else {
            (
                Severity::Note,
                "Nothing needs to be done, unless the object is to be of glass or smoothed normals look wrong there.",
            )
        };
        Some(Hazard {
            message: format!(
                "{} to more than two faces",
                tally.of("edge belongs", "edges belong")
            ),
            advice: advice.to_owned(),
            ..mesh.hazard(HazardKind::CrowdedEdges, severity, tally)
        })
    }
}

fn flipped_windings(
    mesh: &MeshUse<'_>,
    turned: Tally,
    disagreeing: u64,
    contradictions: u64,
) -> Option<Hazard> {
    if turned.count == 0 {
        return None;
    }
    let (severity, consequence) = if mesh.is_glass {
        (
            Severity::Warning,
            "Glass takes inside for outside behind them",
        )
    } else if mesh.is_smooth {
        (
            Severity::Warning,
            "Averaged with those of their neighbours, their normals cancel, which shows as dark or streaky patches",
        )
    } else {
        (
            Severity::Note,
            "Surfaces shine on both sides, so that flat shading does not show it; glass and smooth shading would",
        )
    };
    let one_sided = if contradictions > 0 {
        let edges = counted(contradictions, "edge", "edges");
        format!("; the surface has one side only, as no way round fits at {edges}")
    } else {
        String::new()
    };
    let message = format!(
        "{} the other way round than the rest of the surface, across {}{one_sided}",
        turned.of("face turns", "faces turn"),
        counted(disagreeing, "edge", "edges")
    );
    Some(Hazard {
        message,
        advice: format!(
            "{consequence}. Set repair_winding = true for its objects, or reverse the order of their corners (\"recalculate normals\" in many programs)."
        ),
        ..mesh.hazard(HazardKind::FlippedWindings, severity, turned)
    })
}

fn inside_out_shells(mesh: &MeshUse<'_>, shells: Tally) -> Option<Hazard> {
    if shells.count == 0 {
        return None;
    }
    let (severity, advice) = if mesh.is_glass {
        (
            Severity::Warning,
            "Set repair_winding = true for its objects, or reverse the order of the corners of all their faces: as it is, the air around is glass and the body is a hole in it.",
        )
    } else {
        (
            Severity::Note,
            "Nothing needs to be done: surfaces shine on both sides. It would matter for glass.",
        )
    };
    Some(Hazard {
        message: format!(
            "{} inside out: the faces look inwards",
            shells.of("closed surface is", "closed surfaces are")
        ),
        advice: advice.to_owned(),
        ..mesh.hazard(HazardKind::InsideOut, severity, shells)
    })
}

/// Whether all corners lie in one plane: such a sheet has a rim, and cannot be closed.
fn is_flat(mesh: &MeshUse<'_>) -> bool {
    let mesh = &mesh.mesh;
    let mut faces = 0..mesh.triangles.len();
    let plane = faces.find_map(|face| {
        let corners = mesh.corners(face);
        Some((corners[0], face_normal(corners)?))
    });
    let Some((origin, normal)) = plane else {
        return true;
    };
    let bounds = mesh.bounds();
    let tolerance = FLAT * length_of(bounds.size());
    let corners = mesh.triangles.iter().flatten();
    corners
        .map(|&vertex| mesh.positions[vertex as usize])
        .all(|p| normal.dot(p - origin).abs() <= tolerance)
}
