//! Edges between faces: open ones, crowded ones, and the way round that faces turn on both sides.

use super::buckets::Buckets;
use super::mesh_use::MeshUse;
use super::shells::Shells;
use super::tally::{Tally, counted};
use super::{Hazard, HazardKind, Place, Severity, stops};
use crate::control::CancelToken;
use crate::geometry::Welded;
use crate::geometry::face_normal;
use crate::math::length_of;

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
    let edges = Edges::of(mesh, welded, left_out);
    let mut at_vertex = Vec::new();
    for vertex in 0..edges.by_lower_end.len() {
        if stops(cancel, vertex) {
            return None;
        }
        edges.collect_from(vertex, &mut at_vertex);
        for edge in at_vertex.chunk_by(|a, b| a.upper_end == b.upper_end) {
            let place = || edges.place(mesh, edge);
            match *edge {
                [side] => {
                    found.open.add(place);
                    shells.open_at(side.face());
                }
                [a, b] => {
                    let both_run_the_same_way = a.runs_up == b.runs_up;
                    found.disagreeing += u64::from(both_run_the_same_way);
                    shells.join(a.face(), b.face(), both_run_the_same_way);
                }
                _ => found.crowded.add(place),
            }
        }
    }
    drop(edges);
    shells.settle();
    let turned = shells.turned(|face| mesh.place_of_face(face));
    let inside_out = shells.inside_out(mesh.mesh, left_out, |face| mesh.place_of_face(face));
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

/// One side of an edge: a face that has it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The end of the edge whose number is larger.
    upper_end: u32,
    /// Three times the number of the face, and which of its edges it is.
    half_edge: u32,
    /// Whether the face runs along it from the lower to the upper end.
    runs_up: bool,
}

impl Side {
    fn face(self) -> usize {
        self.half_edge as usize / 3
    }
}

/// The edges of the faces of a mesh, by their ends.
struct Edges<'a> {
    triangles: &'a [[u32; 3]],
    welded: &'a Welded,
    by_lower_end: Buckets,
}

impl<'a> Edges<'a> {
    fn of(mesh: &'a MeshUse<'_>, welded: &'a Welded, left_out: &[bool]) -> Self {
        let triangles = &mesh.mesh.triangles[..];
        let count = u32::try_from(triangles.len() * 3).expect("fewer than 2^32 edges");
        let counted = (0..count).filter(|&half_edge| !left_out[half_edge as usize / 3]);
        let lower_end = |half_edge| {
            let [from, to] = ends(triangles, welded, half_edge);
            (from.min(to), half_edge)
        };
        Self {
            triangles,
            welded,
            by_lower_end: Buckets::new(welded.vertices(), counted.map(lower_end)),
        }
    }

    /// Puts the edges whose lower end is `vertex` into `sides`, those of one edge beside each other.
    fn collect_from(&self, vertex: usize, sides: &mut Vec<Side>) {
        let side = |&half_edge: &u32| {
            let [from, to] = ends(self.triangles, self.welded, half_edge);
            Side {
                upper_end: from.max(to),
                half_edge,
                runs_up: from < to,
            }
        };
        sides.clear();
        sides.extend(self.by_lower_end.of(vertex).iter().map(side));
        sides.sort_unstable();
    }

    fn place(&self, mesh: &MeshUse<'_>, edge: &[Side]) -> Place {
        let faces: Vec<usize> = edge.iter().map(|side| side.face()).collect();
        let [from, to] = ends(self.triangles, self.welded, edge[0].half_edge);
        let [from, to] = [from, to].map(|vertex| mesh.mesh.positions[vertex as usize]);
        mesh.place(&faces, from * 0.5 + to * 0.5)
    }
}

fn ends(triangles: &[[u32; 3]], welded: &Welded, half_edge: u32) -> [u32; 2] {
    let corners = welded.corners(triangles[half_edge as usize / 3]);
    let first = half_edge as usize % 3;
    [corners[first], corners[(first + 1) % 3]]
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
            "{consequence}. Reverse the order of their corners (\"recalculate normals\" in many programs)."
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
            "Reverse the order of the corners of all their faces: as it is, the air around is glass and the body is a hole in it.",
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
    let mesh = mesh.mesh;
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
