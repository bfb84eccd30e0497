//! Edges between the triangles of a mesh.

use super::buckets::Buckets;
use super::{TriangleMesh, Welded};

/// One side of an edge: a face that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// The end of the edge whose number is larger.
    upper_end: u32,
    /// Three times the number of the face, and which of its edges it is.
    half_edge: u32,
    /// Whether the face runs along it from the lower to the upper end.
    runs_up: bool,
}

impl Side {
    /// The number of the face.
    #[must_use]
    pub fn face(self) -> usize {
        self.half_edge as usize / 3
    }

    /// Whether the faces of both sides of an edge run along it the same way: then they turn round in opposite senses.
    #[must_use]
    pub fn runs_along(self, other: Self) -> bool {
        self.runs_up == other.runs_up
    }

    /// What [`Edges::collect_from`] has collected, by edges.
    pub fn by_edge(sides: &[Self]) -> impl Iterator<Item = &[Self]> {
        sides.chunk_by(|a, b| a.upper_end == b.upper_end)
    }
}

/// The edges of the faces of a mesh, by their ends; vertices at one place are one.
pub struct Edges<'a> {
    triangles: &'a [[u32; 3]],
    welded: &'a Welded,
    by_lower_end: Buckets,
}

impl<'a> Edges<'a> {
    /// The edges of a mesh, but for those of faces that are `left_out`. `welded`: its vertices.
    ///
    /// # Panics
    /// When there are 2³² edges, or `left_out` has another number of faces.
    #[must_use]
    pub fn of(mesh: &'a TriangleMesh, welded: &'a Welded, left_out: &[bool]) -> Self {
        let triangles = &mesh.triangles[..];
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

    /// How many vertices there are.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.by_lower_end.len()
    }

    /// Puts the edges whose lower end is `vertex` into `sides`, those of one edge beside each other.
    ///
    /// # Panics
    /// When there is no such vertex.
    pub fn collect_from(&self, vertex: usize, sides: &mut Vec<Side>) {
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

    /// The vertices between which the face of this side runs along its edge.
    #[must_use]
    pub fn ends(&self, side: Side) -> [u32; 2] {
        ends(self.triangles, self.welded, side.half_edge)
    }
}

fn ends(triangles: &[[u32; 3]], welded: &Welded, half_edge: u32) -> [u32; 2] {
    let corners = welded.corners(triangles[half_edge as usize / 3]);
    let first = half_edge as usize % 3;
    [corners[first], corners[(first + 1) % 3]]
}
