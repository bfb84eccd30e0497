//! Meshes of cells, tetrahedra and others, that fill a body: the faces around them, and those between them.

use rayon::prelude::*;

use super::face_normal::scale_to_one;
use crate::math::DVec3;

/// The cells of a mesh, by their corners: indices of vertices in the order of VTK, Gmsh and Medit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    tetrahedra: Vec<[u32; 4]>,
    pyramids: Vec<[u32; 5]>,
    prisms: Vec<[u32; 6]>,
    hexahedra: Vec<[u32; 8]>,
}

/// The corners of a face by their places in its cell, counter-clockwise seen from outside.
type Face = &'static [usize];

/// The faces of a tetrahedron whose fourth corner lies on the side from which the first three turn counter-clockwise.
const OF_TETRAHEDRON: [Face; 4] = [&[0, 2, 1], &[0, 1, 3], &[0, 3, 2], &[1, 2, 3]];
/// The faces of a pyramid: four corners of its base, and the top.
const OF_PYRAMID: [Face; 5] = [
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];
/// The faces of a prism: three corners of its base, and those above them.
const OF_PRISM: [Face; 5] = [
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
/// The faces of a hexahedron: four corners of its base, and those above them.
const OF_HEXAHEDRON: [Face; 6] = [
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[3, 0, 4, 7],
];
/// The most faces of a cell.
const MOST_FACES: usize = 6;

impl Cells {
    /// Most cells whose faces can be numbered.
    pub const MOST: usize = 1 << 29;

    /// Cells that are all tetrahedra.
    #[must_use]
    pub fn of_tetrahedra(tetrahedra: Vec<[u32; 4]>) -> Self {
        Self {
            tetrahedra,
            ..Self::default()
        }
    }

    /// Adds a cell of four corners (a tetrahedron), five (a pyramid), six (a prism) or eight (a hexahedron).
    ///
    /// # Panics
    /// When it has another number of corners.
    pub fn push(&mut self, corners: &[u32]) {
        match *corners {
            [a, b, c, d] => self.tetrahedra.push([a, b, c, d]),
            [a, b, c, d, e] => self.pyramids.push([a, b, c, d, e]),
            [a, b, c, d, e, f] => self.prisms.push([a, b, c, d, e, f]),
            _ => {
                let corners = corners.try_into().expect("4, 5, 6 or 8 corners");
                self.hexahedra.push(corners);
            }
        }
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        let others = self.pyramids.len() + self.prisms.len() + self.hexahedra.len();
        self.tetrahedra.len() + others
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether all are tetrahedra.
    #[must_use]
    pub fn are_tetrahedra(&self) -> bool {
        self.len() == self.tetrahedra.len()
    }

    /// The corners of a cell, and its faces.
    fn cell(&self, mut index: usize) -> (&[u32], &'static [Face]) {
        if let Some(corners) = self.tetrahedra.get(index) {
            return (corners, &OF_TETRAHEDRON);
        }
        index -= self.tetrahedra.len();
        if let Some(corners) = self.pyramids.get(index) {
            return (corners, &OF_PYRAMID);
        }
        index -= self.pyramids.len();
        if let Some(corners) = self.prisms.get(index) {
            return (corners, &OF_PRISM);
        }
        index -= self.prisms.len();
        (&self.hexahedra[index], &OF_HEXAHEDRON)
    }
}

/// The faces of cells, each once.
#[derive(Clone, Debug, PartialEq)]
pub struct CellFaces<'a> {
    cells: &'a Cells,
    positions: &'a [DVec3],
    /// The numbers of the faces that belong to one cell alone, ascending.
    outside: Vec<u32>,
    /// The numbers of all faces, ascending: of those that belong to several cells, one.
    all: Vec<u32>,
    /// The corners of triangles, and of the halves of quadrilaterals, ascending.
    triangles: Vec<[u32; 3]>,
    /// Cells whose corners are given inside out, as in a mirror.
    pub inverted: u64,
    /// Cells without volume.
    pub flat: u64,
}

/// A face by its corners, ascending, and its number: [`MOST_FACES`] times that of its cell, plus its own within the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Numbered<const N: usize> {
    corners: [u32; N],
    number: u32,
}

impl<'a> CellFaces<'a> {
    /// The faces of `cells`, whose corners are indices into `positions`. Where more than two cells share a face it is an inner one.
    ///
    /// # Panics
    /// When an index is out of range, or there are more than [`Cells::MOST`] cells.
    #[must_use]
    pub fn of(positions: &'a [DVec3], cells: &'a Cells) -> Self {
        assert!(cells.len() <= Cells::MOST, "faces can be numbered");
        let volumes = (0..cells.len()).into_par_iter();
        let volumes = volumes.map(|cell| signed_volume(cells.cell(cell), positions));
        let (inverted, flat) = volumes
            .map(|volume| (u64::from(volume < 0.0), u64::from(volume == 0.0)))
            .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        let mut faces = Self {
            cells,
            positions,
            outside: Vec::new(),
            all: Vec::new(),
            triangles: Vec::new(),
            inverted,
            flat,
        };
        let triangles = faces.find::<3>();
        let quadrilaterals = faces.find::<4>();
        let without = |corners: &[u32; 4], left_out: usize| {
            let kept = (0..4).filter(|&place| place != left_out);
            let mut kept = kept.map(|place| corners[place]);
            std::array::from_fn(|_| kept.next().expect("three are kept"))
        };
        let halves = quadrilaterals
            .iter()
            .flat_map(|corners| (0..4).map(move |left_out| without(corners, left_out)));
        faces.triangles = triangles.into_iter().chain(halves).collect();
        faces.triangles.par_sort_unstable();
        faces.outside.sort_unstable();
        faces.all.sort_unstable();
        faces
    }

    /// Finds the faces of `N` corners, and returns these.
    fn find<const N: usize>(&mut self) -> Vec<[u32; N]> {
        let cells = self.cells;
        let of_cell = |index: usize| {
            let (corners, faces) = cells.cell(index);
            let faces = faces.iter().enumerate();
            faces.filter_map(move |(face, places)| {
                let places: [usize; N] = (*places).try_into().ok()?;
                let number = u32::try_from(MOST_FACES * index + face);
                Some(Numbered {
                    corners: ascending(places.map(|place| corners[place])),
                    number: number.expect("faces can be numbered"),
                })
            })
        };
        let indices = (0..cells.len()).into_par_iter();
        let mut found: Vec<Numbered<N>> = indices.flat_map_iter(of_cell).collect();
        found.par_sort_unstable();
        for same in found.chunk_by(|a, b| a.corners == b.corners) {
            self.all.push(same[0].number);
            if let [face] = same {
                self.outside.push(face.number);
            }
        }
        found.dedup_by_key(|face| face.corners);
        found.into_iter().map(|face| face.corners).collect()
    }

    /// The faces that belong to one cell alone, each counter-clockwise seen from outside of it.
    #[must_use]
    pub fn outside(&self) -> impl ExactSizeIterator<Item = Vec<u32>> {
        self.outside.iter().map(|&number| self.face(number))
    }

    /// All faces, each once and counter-clockwise seen from outside of one of its cells.
    #[must_use]
    pub fn all(&self) -> impl ExactSizeIterator<Item = Vec<u32>> {
        self.all.iter().map(|&number| self.face(number))
    }

    /// How many faces belong to several cells.
    #[must_use]
    pub fn inner(&self) -> usize {
        self.all.len() - self.outside.len()
    }

    /// The corners of a face, counter-clockwise seen from outside its cell, even where the cell is given inside out.
    fn face(&self, number: u32) -> Vec<u32> {
        let number = number as usize;
        let cell = self.cells.cell(number / MOST_FACES);
        let (corners, faces) = cell;
        let places = faces[number % MOST_FACES].iter();
        let mut face: Vec<u32> = places.map(|&place| corners[place]).collect();
        if signed_volume(cell, self.positions) < 0.0 {
            face[1..].reverse();
        }
        face
    }

    /// Whether a triangle, either way round, is a face of one of the cells, or half of one.
    #[must_use]
    pub fn has(&self, triangle: [u32; 3]) -> bool {
        self.triangles.binary_search(&ascending(triangle)).is_ok()
    }
}

/// Whether lists of four vertices are tetrahedra rather than quadrilaterals: there are several, none holds a vertex twice, each has three
/// vertices in common with another one whose fourth differs, and no three vertices are in more than two. Quadrilaterals of a surface have
/// two vertices in common, or all four.
#[must_use]
pub fn are_tetrahedra(fours: &[[u32; 4]]) -> bool {
    let Some((first, others)) = fours.split_first() else {
        return false;
    };
    let in_common = |other: &[u32; 4]| other.iter().filter(|v| first.contains(v)).count();
    // Of a surface, the first one tells.
    if !others.iter().any(|other| in_common(other) == 3) {
        return false;
    }
    let is_body = |four: &[u32; 4]| ascending(*four).array_windows().all(|[a, b]| a < b);
    if !fours.iter().all(is_body) {
        return false;
    }
    let cells = Cells::of_tetrahedra(fours.to_vec());
    let faces = (0..cells.len()).flat_map(|index| {
        let (corners, faces) = cells.cell(index);
        faces.iter().enumerate().map(move |(face, places)| {
            let corners: [u32; 3] = std::array::from_fn(|place| corners[places[place]]);
            (ascending(corners), 4 * index + face)
        })
    });
    let mut faces: Vec<_> = faces.collect();
    faces.par_sort_unstable();
    let mut meets = vec![false; fours.len()];
    for same in faces.chunk_by(|(a, _), (b, _)| a == b) {
        match same {
            [_] => {}
            [(_, a), (_, b)] if ascending(fours[a / 4]) != ascending(fours[b / 4]) => {
                meets[a / 4] = true;
                meets[b / 4] = true;
            }
            _ => return false,
        }
    }
    !meets.contains(&false)
}

fn ascending<const N: usize>(mut corners: [u32; N]) -> [u32; N] {
    corners.sort_unstable();
    corners
}

/// A positive multiple of the volume, negative for corners that are given inside out.
fn signed_volume((corners, faces): (&[u32], &[Face]), positions: &[DVec3]) -> f64 {
    let corner = |place: usize| positions[corners[place] as usize];
    let edges = (1..corners.len()).map(|place| corner(place) - corner(0));
    let longest = edges.map(|edge| edge.abs().max_element());
    let scale = scale_to_one(longest.fold(0.0, f64::max));
    let scaled = |place: usize| (corner(place) - corner(0)) * scale;
    // Of the tetrahedra between the first corner and the triangles around.
    let of_face = |face: &Face| -> f64 {
        let [a, rest @ ..] = face else {
            return 0.0;
        };
        let triangles = rest.array_windows();
        triangles
            .map(|&[b, c]| scaled(*a).dot(scaled(b).cross(scaled(c))))
            .sum()
    };
    faces.iter().map(of_face).sum()
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
                let cells = Cells::of_tetrahedra(vec![order]);
                let faces = CellFaces::of(&positions, &cells);
                assert_eq!((faces.inverted, faces.flat), (inverted, 0));
                assert_eq!(faces.outside().len(), 4);
                let (area, volume) = measures(&CORNER, &outside(&faces));
                assert!((volume - 1.0).abs() < 1e-15, "{order:?}: {volume}");
                assert!((area - 3.0 - 3.0_f64.sqrt()).abs() < 1e-14);
            }
        }
    }

    /// The triangles outside; of quadrilaterals, which are flat, both halves.
    fn outside(faces: &CellFaces<'_>) -> Vec<[u32; 3]> {
        let halves = |face: Vec<u32>| {
            let halves = face[1..].array_windows();
            let halves = halves.map(|&[b, c]| [face[0], b, c]);
            halves.collect::<Vec<_>>()
        };
        faces.outside().flat_map(halves).collect()
    }

    /// A cube of two prisms, one given inside out, under a pyramid, beside a hexahedron: each face is met by one of the same kind.
    #[test]
    fn cells_of_all_kinds_meet() {
        let place = |[x, y, z]: [f64; 3]| DVec3::new(x, y, z);
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [0.0, 1.0, 1.0],
            [0.5, 0.5, 2.0],
            [3.0, 0.0, 0.0],
            [3.0, 1.0, 0.0],
            [3.0, 0.0, 1.0],
            [3.0, 1.0, 1.0],
        ]
        .map(place);
        let cell: [&[u32]; 4] = [
            &[0, 1, 2, 4, 5, 6],
            &[4, 6, 7, 0, 2, 3],
            &[4, 5, 6, 7, 8],
            &[1, 9, 10, 2, 5, 11, 12, 6],
        ];
        let body = |kept: &[usize]| {
            let mut cells = Cells::default();
            for &kept in kept {
                cells.push(cell[kept]);
            }
            cells
        };
        for (kept, faces_outside, inner, six_volumes) in [
            (&[0, 1][..], 8, 1, 6.0),
            (&[3], 6, 0, 12.0),
            (&[0, 1, 3], 12, 2, 18.0),
            (&[2], 5, 0, 2.0),
        ] {
            let cells = body(kept);
            let faces = CellFaces::of(&positions, &cells);
            assert_eq!(
                (faces.outside().len(), faces.inner()),
                (faces_outside, inner)
            );
            assert_eq!(faces.inverted, u64::from(kept.contains(&1)));
            let (_, volume) = measures(&positions, &outside(&faces));
            assert!((volume - six_volumes).abs() < 1e-14, "{kept:?} {volume}");
        }
        let cells = body(&[3]);
        let faces = CellFaces::of(&positions, &cells);
        assert!(faces.has([9, 1, 10]) && faces.has([2, 1, 9]) && !faces.has([1, 9, 12]));
    }

    #[test]
    fn quadrilaterals_are_no_tetrahedra() {
        // The sides of a cube; the same from both sides; and strips around.
        let cube = [
            [0, 3, 2, 1],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ];
        assert!(!are_tetrahedra(&cube));
        let both = cube.map(|[a, b, c, d]| [d, c, b, a]);
        assert!(!are_tetrahedra(&[cube, both].concat()));
        assert!(!are_tetrahedra(&[]) && !are_tetrahedra(&[[0, 1, 2, 3]]));
        assert!(are_tetrahedra(&[[0, 1, 2, 3], [4, 2, 1, 3]]));
        assert!(!are_tetrahedra(&[[0, 1, 2, 3], [4, 2, 1, 3], [5, 6, 7, 8]]));
        assert!(!are_tetrahedra(&[[0, 1, 2, 3], [4, 2, 1, 3], [5, 2, 1, 3]]));
        // A triangle as a quadrilateral that repeats a corner.
        assert!(!are_tetrahedra(&[[0, 1, 2, 3], [1, 2, 3, 3]]));
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
            assert!(are_tetrahedra(&tetrahedra));
            let body = Cells::of_tetrahedra(tetrahedra);
            let faces = CellFaces::of(&positions, &body);
            let triangles = outside(&faces);
            let count = u64::from(cells);
            assert_eq!(triangles.len() as u64, 12 * count * count);
            let inner = (4 * 6 * count.pow(3) - 12 * count * count) / 2;
            assert_eq!(faces.inner() as u64, inner);
            assert_eq!(faces.all().len() as u64, inner + 12 * count * count);
            assert_eq!((faces.inverted, faces.flat), (3 * count.pow(3), 0));
            let (area, volume) = measures(&positions, &triangles);
            assert!((area - 12.0).abs() < 1e-12 && (volume - 6.0).abs() < 1e-12);
            // Each edge is walked once in each direction: it is closed and turned one way.
            let edges = triangles.iter();
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
            let cells = Cells::of_tetrahedra(tetrahedra.to_vec());
            let mut faces: Vec<_> = outside(&CellFaces::of(&positions, &cells))
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
        let cells = Cells::of_tetrahedra(vec![[0, 1, 2, 3], [0, 0, 1, 2]]);
        let flat = CellFaces::of(&positions, &cells);
        assert_eq!((flat.inverted, flat.flat), (0, 2));
        let cells = Cells::of_tetrahedra(vec![[0, 1, 2, 3], [3, 2, 1, 0]]);
        let twice = CellFaces::of(&CORNER, &cells);
        assert_eq!((twice.outside().len(), twice.inner()), (0, 4));
        assert!(twice.has([3, 1, 2]) && !twice.has([0, 0, 1]));
    }
}
