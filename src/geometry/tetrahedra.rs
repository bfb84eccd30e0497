//! Meshes of tetrahedra: the faces around them.

use rayon::prelude::*;

use super::face_normal::scale_to_one;
use crate::math::DVec3;

/// The faces of tetrahedra that belong to one alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundary {
    /// The faces, each counter-clockwise seen from outside of its tetrahedron, in the order of those.
    pub triangles: Vec<[u32; 3]>,
    /// Faces that belong to several tetrahedra.
    pub inner_faces: u64,
    /// Tetrahedra whose corners are given inside out: the fourth lies on the side of the first three from which they turn clockwise.
    pub inverted: u64,
    /// Tetrahedra without volume.
    pub flat: u64,
    /// The corners of all faces, ascending, each once.
    faces: Vec<[u32; 3]>,
}

/// The corners of each face of a tetrahedron by their places, counter-clockwise seen from outside where the fourth corner lies on the
/// side from which the first three turn counter-clockwise.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

impl Boundary {
    /// That of `tetrahedra`, four indices into `positions` each. Where more than two tetrahedra share a face it is an inner one.
    ///
    /// # Panics
    /// When an index is out of range, or there are 2³⁰ tetrahedra.
    #[must_use]
    pub fn of(positions: &[DVec3], tetrahedra: &[[u32; 4]]) -> Self {
        assert!(tetrahedra.len() < 1 << 30, "faces can be numbered");
        let volumes = tetrahedra.par_iter().map(|corners| {
            let corners = corners.map(|corner| positions[corner as usize]);
            signed_volume(corners)
        });
        let (inverted, flat) = volumes
            .map(|volume| (u64::from(volume < 0.0), u64::from(volume == 0.0)))
            .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));

        let mut faces: Vec<Face> = tetrahedra
            .par_iter()
            .enumerate()
            .flat_map_iter(|(tetrahedron, corners)| {
                let number = move |face: usize| u32::try_from(4 * tetrahedron + face);
                let face = move |face: usize| Face {
                    corners: ascending(FACES[face].map(|corner| corners[corner])),
                    number: number(face).expect("faces can be numbered"),
                };
                (0..4).map(face)
            })
            .collect();
        faces.par_sort_unstable();
        let mut inner_faces = 0;
        let mut alone = Vec::new();
        for same in faces.chunk_by(|a, b| a.corners == b.corners) {
            match same {
                [face] => alone.push(face.number),
                _ => inner_faces += 1,
            }
        }
        alone.sort_unstable();
        let outside = |&number: &u32| {
            let corners = tetrahedra[number as usize / 4];
            let [a, b, c] = FACES[number as usize % 4].map(|corner| corners[corner]);
            let points = corners.map(|corner| positions[corner as usize]);
            if signed_volume(points) < 0.0 {
                [a, c, b]
            } else {
                [a, b, c]
            }
        };
        let triangles = alone.iter().map(outside).collect();
        faces.dedup_by_key(|face| face.corners);
        Self {
            triangles,
            inner_faces,
            inverted,
            flat,
            faces: faces.into_iter().map(|face| face.corners).collect(),
        }
    }

    /// Whether a triangle, either way round, is a face of one of the tetrahedra.
    #[must_use]
    pub fn has_face(&self, triangle: [u32; 3]) -> bool {
        self.faces.binary_search(&ascending(triangle)).is_ok()
    }
}

/// A face of a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    /// Ascending.
    corners: [u32; 3],
    /// Four times the number of its tetrahedron, and its own.
    number: u32,
}

fn ascending(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// A positive multiple of six times the volume, negative for corners that are given inside out.
fn signed_volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    let edges = [b - a, c - a, d - a];
    let longest = edges.iter().map(|edge| edge.abs().max_element());
    let scale = scale_to_one(longest.fold(0.0, f64::max));
    let [b, c, d] = edges.map(|edge| edge * scale);
    b.cross(c).dot(d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    const CORNER: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];

    /// Twice the area, and six times the volume inside, of a closed surface.
    fn measures(positions: &[DVec3], triangles: &[[u32; 3]]) -> (f64, f64) {
        let corners = triangles
            .iter()
            .map(|t| t.map(|corner| positions[corner as usize]));
        corners.fold((0.0, 0.0), |(area, volume), [a, b, c]| {
            let normal = (b - a).cross(c - a);
            (area + normal.length(), volume + a.dot(b.cross(c)))
        })
    }

    #[test]
    fn a_tetrahedron_is_turned_outwards_however_it_is_given() {
        let orders: [([u32; 4], u64); 4] = [
            ([0, 1, 2, 3], 0),
            ([1, 0, 2, 3], 1),
            ([3, 0, 2, 1], 0),
            ([0, 2, 1, 3], 1),
        ];
        for scale in [1.0, 1e-200, 1e200] {
            let positions = CORNER.map(|corner| corner * scale);
            for (order, inverted) in orders {
                let boundary = Boundary::of(&positions, &[order]);
                assert_eq!((boundary.inverted, boundary.flat), (inverted, 0));
                assert_eq!(boundary.triangles.len(), 4);
                let (area, volume) = measures(&CORNER, &boundary.triangles);
                assert!((volume - 1.0).abs() < 1e-15, "{order:?}: {volume}");
                assert!((area - 3.0 - 3.0_f64.sqrt()).abs() < 1e-14);
            }
        }
    }

    /// The six tetrahedra between the planes x ≤ y ≤ z and their permutations fill a cell of a grid, and those of neighbours meet.
    fn grid(cells: u32) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let side = cells + 1;
        let number = |[x, y, z]: [u32; 3]| (z * side + y) * side + x;
        let all = |count: u32| {
            (0..count)
                .flat_map(move |z| (0..count).flat_map(move |y| (0..count).map(move |x| [x, y, z])))
        };
        let positions = all(side).map(|place| DVec3::from(place.map(f64::from)) / f64::from(cells));
        let paths = [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ];
        let tetrahedra = all(cells).flat_map(|cell| {
            paths.map(|path| {
                let mut place = cell;
                let mut corners = [number(place); 4];
                for (corner, axis) in corners[1..].iter_mut().zip(path) {
                    place[axis] += 1;
                    *corner = number(place);
                }
                corners
            })
        });
        (positions.collect(), tetrahedra.collect())
    }

    /// A cube of edge 1: area 6, volume 1; of n³ cells, 12 n² faces outside. Every second path turns the other way.
    #[test]
    fn a_cube_of_tetrahedra_has_the_surface_of_a_cube() {
        for cells in [1, 2, 5] {
            let (positions, tetrahedra) = grid(cells);
            let boundary = Boundary::of(&positions, &tetrahedra);
            let count = u64::from(cells);
            assert_eq!(boundary.triangles.len() as u64, 12 * count * count);
            let faces = 4 * 6 * count.pow(3);
            assert_eq!(boundary.inner_faces, (faces - 12 * count * count) / 2);
            assert_eq!((boundary.inverted, boundary.flat), (3 * count.pow(3), 0));
            let (area, volume) = measures(&positions, &boundary.triangles);
            assert!((area - 12.0).abs() < 1e-12 && (volume - 6.0).abs() < 1e-12);
            // Each edge is walked once in each direction: it is closed and turned one way.
            let edges = boundary.triangles.iter();
            let edges = edges.flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
            let mut edges: Vec<_> = edges.collect();
            edges.sort_unstable();
            let all = edges.len();
            edges.dedup();
            assert_eq!(edges.len(), all);
            assert!(
                edges
                    .iter()
                    .all(|&(a, b)| edges.binary_search(&(b, a)).is_ok())
            );
        }
    }

    #[test]
    fn order_of_tetrahedra_and_corners_changes_no_face() {
        let (positions, mut tetrahedra) = grid(3);
        let sorted = |tetrahedra: &[[u32; 4]]| {
            let mut faces: Vec<_> = Boundary::of(&positions, tetrahedra)
                .triangles
                .into_iter()
                .map(|mut face| {
                    let least = (0..3).min_by_key(|&i| face[i]).expect("three");
                    face.rotate_left(least);
                    face
                })
                .collect();
            faces.sort_unstable();
            faces
        };
        let expected = sorted(&tetrahedra);
        let mut random = Random::new(3);
        for corners in &mut tetrahedra {
            corners.rotate_left(usize::try_from(random.bits() % 4).expect("is small"));
        }
        tetrahedra.reverse();
        assert_eq!(sorted(&tetrahedra), expected);
    }

    #[test]
    fn flat_and_repeated_tetrahedra_are_counted() {
        let positions = [CORNER[0], CORNER[1], CORNER[2], DVec3::new(1.0, 1.0, 0.0)];
        let flat = Boundary::of(&positions, &[[0, 1, 2, 3], [0, 0, 1, 2]]);
        assert_eq!((flat.inverted, flat.flat), (0, 2));
        let twice = Boundary::of(&CORNER, &[[0, 1, 2, 3], [3, 2, 1, 0]]);
        assert_eq!((twice.triangles.len(), twice.inner_faces), (0, 4));
        assert!(twice.has_face([3, 1, 2]) && !twice.has_face([0, 0, 1]));
    }
}
