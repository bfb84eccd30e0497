//! The way round in which triangles turn, told and repaired.

use super::{Edges, Shell, Shells, Side, TriangleMesh, Welded};
use crate::math::DVec3;

/// What it takes for the triangles of a mesh to turn one way round on each connected surface, so that closed surfaces look outwards, and
/// inwards where they bound a hollow in another one. Vertices at one place are one; surfaces that are not closed keep the way round of most
/// of their triangles. Where more than two triangles meet at an edge, surfaces end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Winding {
    /// Triangles that turn the other way round than most of their surface.
    pub turned: u64,
    /// Closed surfaces that look inwards without bounding a hollow.
    pub inside_out: u64,
    /// Of each triangle, whether it is to be turned.
    to_turn: Vec<bool>,
}

impl Winding {
    /// Examines a mesh.
    ///
    /// # Panics
    /// When it has 2³² edges or vertices.
    #[must_use]
    pub fn of(mesh: &TriangleMesh) -> Self {
        let faces = mesh.triangles.len();
        let none_left_out = vec![false; faces];
        let welded = Welded::new(mesh);
        let edges = Edges::of(mesh, &welded, &none_left_out);
        let mut shells = Shells::new(faces);
        let mut at_vertex = Vec::new();
        for vertex in 0..edges.vertices() {
            edges.collect_from(vertex, &mut at_vertex);
            for edge in Side::by_edge(&at_vertex) {
                match *edge {
                    [side] => shells.open_at(side.face()),
                    [a, b] => shells.join(a.face(), b.face(), a.runs_along(b)),
                    _ => {}
                }
            }
        }
        drop(edges);
        shells.settle();
        let mut to_turn = shells.turned();
        let turned = to_turn.iter().filter(|&&turned| turned).count() as u64;
        let closed = shells.closed(mesh, &none_left_out, &to_turn);
        let mut looks_inwards = vec![false; faces];
        let mut inside_out = 0;
        for shell in Shell::inside_out(&closed) {
            looks_inwards[shell.root] = true;
            inside_out += 1;
        }
        if inside_out > 0 {
            for (face, to_turn) in to_turn.iter_mut().enumerate() {
                let (root, _) = shells.find(face);
                *to_turn ^= looks_inwards[root];
            }
        }
        Self {
            turned,
            inside_out,
            to_turn,
        }
    }

    /// How many triangles are to be turned.
    #[must_use]
    pub fn to_turn(&self) -> usize {
        self.to_turn.iter().filter(|&&turns| turns).count()
    }

    /// Whether nothing is to be turned.
    #[must_use]
    pub fn is_right(&self) -> bool {
        !self.to_turn.contains(&true)
    }

    /// Turns the triangles of the mesh that was examined. A normal turns too where all triangles of its vertex do and it was on their side.
    ///
    /// # Panics
    /// When it is another mesh.
    pub fn repair(&self, mesh: &mut TriangleMesh) {
        if let Some(normals) = &mut mesh.normals {
            // Of the triangles at each vertex as they are, all of which turn; nothing where one stays.
            let mut turning = vec![Some(DVec3::ZERO); normals.len()];
            for (triangle, &turns) in mesh.triangles.iter().zip(&self.to_turn) {
                let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
                let side = (b - a).cross(c - a);
                for &vertex in triangle {
                    let sum = &mut turning[vertex as usize];
                    *sum = sum.filter(|_| turns).map(|sum| sum + side);
                }
            }
            for (normal, side) in normals.iter_mut().zip(turning) {
                if side.is_some_and(|side| normal.dot(side) > 0.0) {
                    *normal = -*normal;
                }
            }
        }
        assert_eq!(mesh.triangles.len(), self.to_turn.len(), "the same mesh");
        for (triangle, _) in mesh
            .triangles
            .iter_mut()
            .zip(&self.to_turn)
            .filter(|(_, turns)| **turns)
        {
            triangle.swap(1, 2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{Random, icosphere};

    /// Six times the volume within.
    fn volume(mesh: &TriangleMesh) -> f64 {
        let corners = (0..mesh.triangles.len()).map(|face| mesh.corners(face));
        corners.map(|[a, b, c]| a.dot(b.cross(c))).sum()
    }

    fn repaired(mesh: &TriangleMesh) -> (Winding, TriangleMesh) {
        let winding = Winding::of(mesh);
        let mut mesh = mesh.clone();
        winding.repair(&mut mesh);
        (winding, mesh)
    }

    /// The mesh with its triangles before, each beginning with its least vertex.
    fn normalised(mesh: &TriangleMesh) -> Vec<[u32; 3]> {
        let mut triangles = mesh.triangles.clone();
        for triangle in &mut triangles {
            let least = (0..3).min_by_key(|&i| triangle[i]).expect("three");
            triangle.rotate_left(least);
        }
        triangles
    }

    #[test]
    fn a_ball_whose_triangles_turn_any_way_becomes_the_ball_it_was() {
        let ball = icosphere(2);
        assert!(Winding::of(&ball).is_right());
        let mut random = Random::new(5);
        for share in [2, 3, 20] {
            let mut mixed = ball.clone();
            let mut turned = 0;
            for triangle in &mut mixed.triangles {
                if random.bits().is_multiple_of(share) {
                    triangle.swap(0, 1);
                    turned += 1;
                }
            }
            let (winding, repaired) = repaired(&mixed);
            assert_eq!(normalised(&repaired), normalised(&ball));
            let all = ball.triangles.len() as u64;
            assert_eq!(winding.turned, turned.min(all - turned));
            assert_eq!(winding.inside_out, u64::from(2 * turned > all));
        }
    }

    /// Vertices of their own for each triangle, as STL has them.
    #[test]
    fn triangles_that_share_no_vertices_share_edges() {
        let ball = icosphere(1);
        let mut loose = TriangleMesh::default();
        for face in 0..ball.triangles.len() {
            let first = u32::try_from(loose.positions.len()).expect("few");
            loose.positions.extend(ball.corners(face));
            loose.triangles.push([first, first + 1, first + 2]);
        }
        loose.triangles[7].swap(1, 2);
        let (winding, repaired) = repaired(&loose);
        assert_eq!((winding.turned, winding.inside_out), (1, 0));
        assert!(volume(&repaired) > 0.99 * volume(&ball));
    }

    #[test]
    fn a_hollow_stays_and_what_is_inside_out_turns_with_its_normals() {
        let ball = icosphere(1);
        let count = u32::try_from(ball.positions.len()).expect("few");
        let inside_out = |[a, b, c]: [u32; 3]| [a, c, b].map(|vertex| vertex + count);
        let mut shell = ball.clone();
        shell
            .positions
            .extend(ball.positions.iter().map(|&p| p * 0.5));
        shell
            .triangles
            .extend(ball.triangles.iter().map(|&triangle| inside_out(triangle)));
        assert!(Winding::of(&shell).is_right());

        let mut apart = shell.clone();
        for position in &mut apart.positions[count as usize..] {
            position.x += 9.0;
        }
        // Those of the first ball look inwards, those of the second as its triangles do.
        let normal = |p: &DVec3| DVec3::new(if p.x > 4.0 { 9.0 } else { 0.0 }, 0.0, 0.0) - *p;
        apart.normals = Some(apart.positions.iter().map(normal).collect());
        let (winding, repaired) = repaired(&apart);
        assert_eq!((winding.turned, winding.inside_out), (0, 1));
        let ([before, after], first) = ([&apart, &repaired], count as usize);
        let normals = [before, after].map(|mesh| mesh.normals.clone().expect("some"));
        assert_eq!(normals[0][..first], normals[1][..first]);
        let turned: Vec<_> = normals[0][first..].iter().map(|&normal| -normal).collect();
        assert_eq!(normals[1][first..], turned);
        assert!(volume(&repaired) > volume(&apart));
    }

    /// Two triangles back to back, in a box without a width, which rounding gives a volume.
    #[test]
    fn a_sheet_folded_on_itself_has_no_inside() {
        let mut random = Random::new(8);
        for _ in 0..100 {
            let corners = [0; 3].map(|_| random.in_cube().with_x(0.1));
            let mut folded = TriangleMesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2], [1, 0, 2]],
                ..TriangleMesh::default()
            };
            // A body far away moves the middle of the mesh.
            let ball = icosphere(0);
            folded
                .positions
                .extend(ball.positions.iter().map(|&p| p + 1e3));
            folded
                .triangles
                .extend(ball.triangles.iter().map(|t| t.map(|vertex| vertex + 3)));
            assert_eq!(Winding::of(&folded).inside_out, 0);
        }
    }

    #[test]
    fn an_open_sheet_follows_most_of_its_triangles() {
        let mut sheet = TriangleMesh {
            positions: (0..10_u32)
                .map(|i| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0))
                .collect(),
            triangles: (0..8)
                .map(|i| {
                    if i % 2 == 0 {
                        [i, i + 2, i + 1]
                    } else {
                        [i, i + 1, i + 2]
                    }
                })
                .collect(),
            ..TriangleMesh::default()
        };
        assert!(Winding::of(&sheet).is_right());
        let right = sheet.clone();
        for turned in [1, 4, 6] {
            sheet.triangles[turned].swap(0, 2);
        }
        let (winding, repaired) = repaired(&sheet);
        assert_eq!((winding.turned, winding.inside_out), (3, 0));
        assert_eq!(normalised(&repaired), normalised(&right));
        assert!(Winding::of(&TriangleMesh::default()).is_right());
    }
}
