//! Normals of faces and shading normals of corners.
//!
//! Directions depend on shape alone: before anything is multiplied, lengths from 1e−300 to 1e300 are brought near 1 by an
//! exact power of two. The functions here expect valid meshes and panic on indices out of range.

use super::{TriangleMesh, Welded};
use crate::math::{DVec3, Degrees};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Shading normals, one for each way a vertex is seen by the faces around it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerNormals {
    /// Unit vectors.
    pub normals: Vec<DVec3>,
    /// Three indices into `normals` per triangle, in the order of its corners.
    pub corners: Vec<[u32; 3]>,
}

/// The unit normal of a triangle, on the side from which its corners run counter-clockwise; `None` when it has no area.
///
/// "No area" means that the corners lie on one line within the rounding of their coordinates, as decimal numbers in a
/// file do: the digits of such a triangle's cross product are noise.
#[must_use]
pub fn face_normal(corners: [DVec3; 3]) -> Option<DVec3> {
    let cross = significant_cross(corners)?;
    let cross = cross * scale_to_one(cross.abs().max_element());
    Some(cross / cross.length())
}

/// A positive multiple of the face normal, `None` when rounding may account for all of it.
fn significant_cross(corners: [DVec3; 3]) -> Option<DVec3> {
    const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;
    let [a, b, c] = corners;
    let edges = edges_of(corners);
    let longest = edges
        .iter()
        .fold(0.0, |longest, edge| edge.abs().max_element().max(longest));
    if longest == 0.0 {
        return None;
    }
    if longest == f64::INFINITY {
        // Differences of the largest numbers overflow; those of their quarters do not.
        return significant_cross(corners.map(|corner| corner * 0.25));
    }
    let scale = scale_to_one(longest);
    let edges = edges.map(|edge| edge * scale);
    // Of the three cross products, which are the same but for rounding, that of the two shorter edges loses least.
    let opposite = longest_edge(edges);
    let [p, q] = [edges[(opposite + 1) % 3], edges[(opposite + 2) % 3]];
    let cross = p.cross(q);

    // A coordinate of an edge is off by the roundings of two corners and of the subtraction; |coordinate| ≤ 2 |corner|.
    let edge_error = a.abs().max(b.abs()).max(c.abs()) * scale * (4.0 * UNIT_ROUNDOFF);
    let (p, q) = (p.abs(), q.abs());
    let from_edges = absolute_cross(edge_error, p + q);
    let from_products = absolute_cross(p, q) * (2.0 * UNIT_ROUNDOFF);
    // Bounds that overflow are NaN, and nothing is above those.
    let is_significant = cross.abs().cmpgt(from_edges + from_products).any();
    is_significant.then_some(cross)
}

/// The edges of a triangle; edge i leads from corner i + 1 to corner i + 2 and lies opposite corner i.
fn edges_of([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    [c - b, a - c, b - a]
}

fn longest_edge(edges: [DVec3; 3]) -> usize {
    let [a, b, c] = edges.map(|edge| edge.abs().max_element());
    let scale = scale_to_one(a.max(b).max(c));
    let [a, b, c] = edges.map(|edge| (edge * scale).length_squared());
    if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    }
}

/// The cross product with sums in place of differences, which bounds its terms; both vectors non-negative.
fn absolute_cross(p: DVec3, q: DVec3) -> DVec3 {
    DVec3::new(
        p.y * q.z + p.z * q.y,
        p.z * q.x + p.x * q.z,
        p.x * q.y + p.y * q.x,
    )
}

/// A power of two that brings `magnitude`, finite and not negative, near 1: into `[1, 2)` unless it is subnormal.
pub(super) fn scale_to_one(magnitude: f64) -> f64 {
    const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    // Biased exponents add up to 2 · 1023 when powers of two multiply to 1; 0 and 2047 are not powers of two.
    let exponent = magnitude.to_bits() >> MANTISSA_BITS;
    f64::from_bits(2046_u64.saturating_sub(exponent).max(1) << MANTISSA_BITS)
}

/// `vector` with its largest coordinate brought near 1.
fn near_one(vector: DVec3) -> DVec3 {
    vector * scale_to_one(vector.abs().max_element())
}

/// Shading normals of all corners: the mesh's own where it has them, else averages of the faces around a vertex.
///
/// An average weighs each face by its angle at the vertex, so that it does not depend on how a flat part is cut into
/// triangles. Faces share it where a chain of faces, each meeting the next across an edge at no more than `crease`,
/// connects them around the vertex; from 180° on, all faces of the vertex do. `crease` 0 (or negative, or NaN) joins only
/// coplanar faces. A face that is there twice, either way round, counts once, as it is seen. Where an average vanishes, as between two opposite faces, each corner has its face's normal; a corner
/// of a triangle without area takes a normal of its vertex's other faces, or +Z when there is none. Of a mesh with texture coordinates,
/// vertices at one place count as one: they are several only where the image has a seam.
///
/// Source: Thürmer & Wüthrich, Computing Vertex Normals from Polygonal Facets, Journal of Graphics Tools 3(1), 1998.
///
/// # Panics
/// When the mesh is not valid, or has more than 2³²/3 triangles.
#[must_use]
pub fn corner_normals(mesh: &TriangleMesh, crease: Degrees) -> CornerNormals {
    if mesh.normals.is_none() && mesh.texture_coordinates.is_some() {
        let welded = Welded::new(mesh);
        let triangles = mesh.triangles.par_iter();
        let seamless = TriangleMesh {
            positions: mesh.positions.clone(),
            triangles: triangles.map(|&corners| welded.corners(corners)).collect(),
            ..TriangleMesh::default()
        };
        return corner_normals(&seamless, crease);
    }
    let (faces, angles) = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|triangle| {
            let corners = mesh.corners(triangle);
            (face_normal(corners), corner_angles(corners))
        })
        .unzip();
    let mut shading = Shading {
        mesh,
        faces,
        angles,
        sharing: Sharing::up_to(crease),
        result: CornerNormals {
            normals: Vec::new(),
            corners: vec![[0; 3]; mesh.triangles.len()],
        },
    };
    let fans = Fans::of(mesh);
    let mut groups = FanGroups::default();
    for vertex in 0..mesh.positions.len() {
        let fan = fans.around(vertex);
        if fan.is_empty() {
            continue;
        }
        if let Some(normal) = own_normal(mesh, vertex) {
            let id = shading.add(normal);
            for &corner in fan {
                shading.assign(corner, id);
            }
        } else {
            shading.average(fan, &mut groups);
        }
    }
    shading.result
}

/// The normal the file gave, as a unit vector; `None` where it gave none or zero.
fn own_normal(mesh: &TriangleMesh, vertex: usize) -> Option<DVec3> {
    let normal = near_one(mesh.normals.as_ref()?[vertex]);
    (normal != DVec3::ZERO).then(|| normal / normal.length())
}

/// One corner of one triangle.
#[derive(Clone, Copy, Debug)]
struct Corner(u32);

impl Corner {
    fn triangle(self) -> usize {
        self.0 as usize / 3
    }

    fn index(self) -> usize {
        self.0 as usize % 3
    }
}

/// The corners at each vertex, in the order of the triangles.
struct Fans {
    /// Where the corners of each vertex begin in `corners`; one more entry at the end.
    starts: Vec<u32>,
    corners: Vec<Corner>,
}

impl Fans {
    fn of(mesh: &TriangleMesh) -> Self {
        let count = u32::try_from(3 * mesh.triangles.len()).expect("fewer than 2^32 corners");
        let mut starts = vec![0; mesh.positions.len() + 1];
        for &vertex in mesh.triangles.iter().flatten() {
            starts[vertex as usize] += 1;
        }
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        // Filled from the back, each start moves from the end of its part to the beginning.
        let mut corners = vec![Corner(0); count as usize];
        for corner in (0..count).rev().map(Corner) {
            let vertex = mesh.triangles[corner.triangle()][corner.index()];
            let start = &mut starts[vertex as usize];
            *start -= 1;
            corners[*start as usize] = corner;
        }
        Self { starts, corners }
    }

    fn around(&self, vertex: usize) -> &[Corner] {
        &self.corners[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// Which faces share a normal.
#[derive(Clone, Copy, Debug)]
enum Sharing {
    /// All that meet in a vertex.
    All,
    /// Those whose unit normals are no further apart than this, a chord of the unit circle.
    WithinChord(f64),
}

impl Sharing {
    fn up_to(crease: Degrees) -> Self {
        /// Coplanar faces have normals this close, up to the rounding of their coordinates.
        const COPLANAR: f64 = 1e-9;
        if crease.0 >= 180.0 {
            return Self::All;
        }
        // `max` also makes 0 of NaN.
        Self::WithinChord(2.0 * libm::sin(crease.radians().max(0.0) * 0.5) + COPLANAR)
    }
}

/// The normals made so far, and what they are made of.
struct Shading<'a> {
    mesh: &'a TriangleMesh,
    /// The normal of each triangle that has one.
    faces: Vec<Option<DVec3>>,
    /// The angles of each triangle at its corners.
    angles: Vec<[f64; 3]>,
    sharing: Sharing,
    result: CornerNormals,
}

impl Shading<'_> {
    fn add(&mut self, normal: DVec3) -> u32 {
        let id = u32::try_from(self.result.normals.len()).expect("no more normals than corners");
        self.result.normals.push(normal);
        id
    }

    fn assign(&mut self, corner: Corner, id: u32) {
        self.result.corners[corner.triangle()][corner.index()] = id;
    }

    /// Gives the corners around one vertex the averages of their groups.
    fn average(&mut self, fan: &[Corner], groups: &mut FanGroups) {
        groups.find_repeats(fan, self.mesh);
        groups.find(fan, self.mesh, &self.faces, self.sharing);
        groups.sums.clear();
        groups.sums.resize(fan.len(), GroupSum::default());
        for (place, &corner) in fan.iter().enumerate() {
            if groups.is_repeat[place] {
                continue;
            }
            if let Some(normal) = self.faces[corner.triangle()] {
                let angle = self.angles[corner.triangle()][corner.index()];
                let sum = &mut groups.sums[groups.leaders[place]];
                sum.weighted += normal * angle;
                sum.weight += angle;
            }
        }
        for leader in 0..fan.len() {
            groups.sums[leader].id = groups.sums[leader].normal().map(|normal| self.add(normal));
        }
        let mut any_id = None;
        for (place, &corner) in fan.iter().enumerate() {
            if let Some(face) = self.faces[corner.triangle()] {
                let shared = groups.sums[groups.leaders[place]].id;
                let shared = shared.filter(|_| !groups.is_repeat[place]);
                let id = shared.unwrap_or_else(|| self.add(face));
                any_id.get_or_insert(id);
                self.assign(corner, id);
            }
        }
        for &corner in fan {
            if self.faces[corner.triangle()].is_none() {
                let id = *any_id.get_or_insert_with(|| self.add(DVec3::Z));
                self.assign(corner, id);
            }
        }
    }
}

/// The angles of a triangle at its corners, in radians.
fn corner_angles(corners: [DVec3; 3]) -> [f64; 3] {
    // Quarters: differences of the largest numbers overflow. Each edge by itself: a needle's short one must not vanish.
    let edges = edges_of(corners.map(|corner| corner * 0.25));
    let directions = edges.map(near_one);
    let angle = |corner: usize| {
        let (before, after) = (directions[(corner + 1) % 3], directions[(corner + 2) % 3]);
        libm::atan2(before.cross(after).length(), -before.dot(after))
    };
    // The largest angle is what the others leave; a small one would lose its digits that way.
    let largest = longest_edge(edges);
    let (next, previous) = ((largest + 1) % 3, (largest + 2) % 3);
    let mut angles = [0.0; 3];
    angles[next] = angle(next);
    angles[previous] = angle(previous);
    angles[largest] = PI - angles[next] - angles[previous];
    angles
}

/// The average of a group in the making.
#[derive(Clone, Copy, Debug, Default)]
struct GroupSum {
    weighted: DVec3,
    weight: f64,
    /// The normal's index once it is made.
    id: Option<u32>,
}

impl GroupSum {
    /// The unit average; `None` where the faces cancel each other, up to rounding.
    fn normal(&self) -> Option<DVec3> {
        /// Far above the rounding of a sum of unit vectors, far below any average that shows.
        const CANCELLED: f64 = 1e-12;
        let length = self.weighted.length();
        (length > CANCELLED * self.weight).then(|| self.weighted / length)
    }
}

/// Work space that finds which corners around a vertex share a normal; reused from vertex to vertex.
#[derive(Default)]
struct FanGroups {
    /// For each corner of the fan, whether its triangle has the vertices of one before it.
    is_repeat: Vec<bool>,
    /// The other two vertices of each corner's triangle, and its place in the fan.
    opposite: Vec<([u32; 2], usize)>,
    /// For each corner of the fan, the place of the corner that stands for its group.
    leaders: Vec<usize>,
    sums: Vec<GroupSum>,
    spokes: Vec<Spoke>,
}

/// One of the two edges of a corner, seen from the vertex.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    /// The vertex at its other end.
    to: u32,
    /// The corner's place in the fan.
    place: usize,
    /// The corner's face normal.
    normal: DVec3,
    /// The direction of `normal` around the spoke; compared only where more than two faces meet.
    turn: f64,
}

impl FanGroups {
    /// Fills `is_repeat`.
    fn find_repeats(&mut self, fan: &[Corner], mesh: &TriangleMesh) {
        self.is_repeat.clear();
        self.is_repeat.resize(fan.len(), false);
        self.opposite.clear();
        self.opposite
            .extend(fan.iter().enumerate().map(|(place, corner)| {
                let triangle = mesh.triangles[corner.triangle()];
                let mut others = [1, 2].map(|step| triangle[(corner.index() + step) % 3]);
                others.sort_unstable();
                (others, place)
            }));
        self.opposite.sort_unstable();
        for pair in self.opposite.windows(2) {
            let ((first, _), (second, place)) = (pair[0], pair[1]);
            self.is_repeat[place] = first == second;
        }
    }

    /// Fills `leaders`; `is_repeat` is filled. A repeat joins nothing.
    fn find(
        &mut self,
        fan: &[Corner],
        mesh: &TriangleMesh,
        faces: &[Option<DVec3>],
        sharing: Sharing,
    ) {
        self.leaders.clear();
        let chord = match sharing {
            Sharing::All => {
                self.leaders.resize(fan.len(), 0);
                return;
            }
            Sharing::WithinChord(chord) => chord,
        };
        self.leaders.extend(0..fan.len());
        self.spokes.clear();
        for (place, corner) in fan.iter().enumerate() {
            if self.is_repeat[place] {
                continue;
            }
            if let Some(normal) = faces[corner.triangle()] {
                let triangle = mesh.triangles[corner.triangle()];
                for step in [1, 2] {
                    let to = triangle[(corner.index() + step) % 3];
                    self.spokes.push(Spoke {
                        to,
                        place,
                        normal,
                        turn: 0.0,
                    });
                }
            }
        }
        self.spokes
            .sort_unstable_by_key(|spoke| (spoke.to, spoke.place));
        let mut spokes = std::mem::take(&mut self.spokes);
        for edge in spokes.chunk_by_mut(|a, b| a.to == b.to) {
            self.join_across(edge, chord);
        }
        self.spokes = spokes;
        for place in 0..fan.len() {
            self.leaders[place] = self.leader(place);
        }
    }

    /// Joins the faces that meet in one edge with those next to them.
    ///
    /// The normals all stand on the edge, hence on a circle: if two of them are within the chord, so are the neighbours
    /// between them, and comparing neighbours is enough however many faces meet.
    fn join_across(&mut self, edge: &mut [Spoke], chord: f64) {
        if edge.len() > 2 {
            sort_around(edge);
        }
        for (i, a) in edge.iter().enumerate() {
            let b = &edge[(i + 1) % edge.len()];
            if a.normal.distance(b.normal) <= chord {
                self.join(a.place, b.place);
            }
        }
    }

    fn leader(&mut self, mut place: usize) -> usize {
        while self.leaders[place] != place {
            // Halving the path on the way keeps later searches short.
            self.leaders[place] = self.leaders[self.leaders[place]];
            place = self.leaders[place];
        }
        place
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.leader(a), self.leader(b));
        self.leaders[a.max(b)] = a.min(b);
    }
}

/// Sorts faces that meet in one edge by the direction of their normals around it.
fn sort_around(edge: &mut [Spoke]) {
    let first = edge[0].normal;
    // Any normal not along the first one gives the axis; if there is none, all compare alike or opposite to it.
    let axis = edge
        .iter()
        .map(|spoke| first.cross(spoke.normal))
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let side = near_one(axis.unwrap_or_default()).cross(first);
    for spoke in &mut *edge {
        spoke.turn = libm::atan2(spoke.normal.dot(side), spoke.normal.dot(first));
    }
    edge.sort_unstable_by(|a, b| a.turn.total_cmp(&b.turn).then(a.place.cmp(&b.place)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec2, power_of_two};

    /// A cube of edge 2 around the origin, two triangles per side.
    fn cube() -> TriangleMesh {
        let corner = |i: u32| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            DVec3::new(sign(0), sign(1), sign(2))
        };
        let sides: [[u32; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        TriangleMesh {
            positions: (0..8).map(corner).collect(),
            triangles: sides
                .iter()
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
            ..TriangleMesh::default()
        }
    }

    /// An icosahedron, each face cut into four `levels` times, on the unit sphere.
    fn sphere(levels: u32) -> TriangleMesh {
        let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
        let mut positions: Vec<DVec3> = [[0, 1, 2], [1, 2, 0], [2, 0, 1]]
            .iter()
            .flat_map(|axes| {
                [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(u, v)| {
                    let mut point = DVec3::ZERO;
                    point[axes[1]] = u;
                    point[axes[2]] = v * golden;
                    point
                })
            })
            .collect();
        let count = 12_u32;
        let mut triangles = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                for c in b + 1..count {
                    let [p, q, r] = [a, b, c].map(|vertex| positions[vertex as usize]);
                    let is_face = [(p, q), (q, r), (r, p)]
                        .iter()
                        .all(|(p, q)| p.distance(*q) < 2.1);
                    if is_face {
                        let is_outward = (q - p).cross(r - p).dot(p) > 0.0;
                        triangles.push(if is_outward { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        for _ in 0..levels {
            let mut middles = std::collections::BTreeMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push(positions[a as usize] + positions[b as usize]);
                    u32::try_from(positions.len() - 1).expect("few")
                })
            };
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
            for position in &mut positions {
                *position /= position.length();
            }
        }
        for position in &mut positions {
            *position /= position.length();
        }
        TriangleMesh {
            positions,
            triangles,
            ..TriangleMesh::default()
        }
    }

    fn scaled(mesh: &TriangleMesh, factor: f64) -> TriangleMesh {
        let positions = mesh.positions.iter().map(|p| *p * factor).collect();
        TriangleMesh {
            positions,
            ..mesh.clone()
        }
    }

    /// A sphere whose triangles share no vertex, as each lies elsewhere on its image, has the normals of one whose triangles do.
    #[test]
    fn seams_of_images_are_not_seen_in_normals() {
        let whole = sphere(2);
        let corners = whole.triangles.iter().flatten();
        let mut apart = TriangleMesh {
            positions: corners.map(|&v| whole.positions[v as usize]).collect(),
            triangles: whole.triangles.clone(),
            ..TriangleMesh::default()
        };
        let mut next = 0..;
        for corner in apart.triangles.iter_mut().flatten() {
            *corner = next.next().expect("has no end");
        }
        apart.texture_coordinates = Some(vec![DVec2::ZERO; apart.positions.len()]);
        assert_eq!(per_corner(&apart, 180.0), per_corner(&whole, 180.0));
        apart.texture_coordinates = None;
        assert_ne!(per_corner(&apart, 180.0), per_corner(&whole, 180.0));
    }

    /// The normal of each corner, after checking that all are unit vectors.
    fn per_corner(mesh: &TriangleMesh, crease: f64) -> Vec<[DVec3; 3]> {
        let shading = corner_normals(mesh, Degrees(crease));
        for normal in &shading.normals {
            assert!((normal.length() - 1.0).abs() < 1e-14, "{normal}");
        }
        let corners = shading.corners.iter();
        corners
            .map(|corner| corner.map(|id| shading.normals[id as usize]))
            .collect()
    }

    fn assert_flat(mesh: &TriangleMesh, crease: f64) {
        for (triangle, normals) in per_corner(mesh, crease).iter().enumerate() {
            let face = face_normal(mesh.corners(triangle)).expect("an area");
            assert!(normals.iter().all(|n| n.distance(face) < 1e-14));
        }
    }

    #[test]
    fn a_cube_is_flat_up_to_89_degrees_and_round_from_91() {
        let cube = cube();
        for crease in [0.0, 30.0, 89.9, -5.0, f64::NAN] {
            assert_flat(&cube, crease);
        }
        // The two triangles of a side share their normals: 6 sides of 4 corners.
        assert_eq!(corner_normals(&cube, Degrees(30.0)).normals.len(), 24);
        for crease in [90.1, 180.0, 1000.0] {
            let normals = per_corner(&cube, crease);
            for (triangle, corners) in cube.triangles.iter().zip(normals) {
                for (&vertex, normal) in triangle.iter().zip(corners) {
                    // By symmetry along the diagonal, although some sides have two triangles there and some one.
                    let diagonal = cube.positions[vertex as usize] / 3.0_f64.sqrt();
                    assert!(normal.distance(diagonal) < 1e-14, "{normal} {diagonal}");
                }
            }
            assert_eq!(corner_normals(&cube, Degrees(crease)).normals.len(), 8);
        }
    }

    #[test]
    fn normals_of_a_sphere_are_nearly_radial() {
        let sphere = sphere(4);
        assert_eq!(sphere.triangles.len(), 20 * 256);
        for (triangle, normals) in per_corner(&sphere, 30.0).iter().enumerate() {
            let radial = sphere.corners(triangle);
            for (normal, radial) in normals.iter().zip(radial) {
                assert!(normal.distance(radial) < 4e-3, "{normal} {radial}");
            }
        }
        let shading = corner_normals(&sphere, Degrees(30.0));
        assert_eq!(shading.normals.len(), sphere.positions.len());
    }

    #[test]
    fn scale_changes_nothing() {
        let sphere = sphere(2);
        let base = corner_normals(&sphere, Degrees(40.0));
        for exponent in [-900, -60, 60, 900] {
            let factor = power_of_two(exponent);
            assert_eq!(
                corner_normals(&scaled(&sphere, factor), Degrees(40.0)),
                base
            );
        }
        for factor in [1e-300, 1e-20, 1e20, 1e300, f64::MAX] {
            let shading = corner_normals(&scaled(&sphere, factor), Degrees(40.0));
            assert_eq!(shading.corners, base.corners);
            for (normal, expected) in shading.normals.iter().zip(&base.normals) {
                assert!(normal.distance(*expected) < 1e-12, "{factor}");
            }
        }
    }

    #[test]
    fn a_sliver_has_a_normal_and_a_line_has_none() {
        let sliver = |height: f64| [DVec3::ZERO, DVec3::X, DVec3::new(0.5, height, 0.0)];
        for height in [1e-6, 1e-12, 1e-200] {
            let normal = face_normal(sliver(height)).expect("an area");
            assert!(normal.distance(DVec3::Z) < 1e-9, "{height}");
        }
        assert_eq!(face_normal(sliver(0.0)), None);
        let point = DVec3::new(0.1, 0.2, 0.3);
        assert_eq!(face_normal([point; 3]), None);
        let (far, apart) = (DVec3::X * 1e308, DVec3::new(1e308, 0.0, 1e-308));
        assert_eq!(face_normal([far, far, apart]), None);
        assert_eq!(
            face_normal([far, apart, DVec3::new(1e308, 1e-308, 0.0)]),
            Some(DVec3::NEG_X)
        );
        assert_eq!(face_normal([point, point, DVec3::X]), None);
        // 3 · 0.1 is not 0.3 in binary; as decimals the points are on a line.
        assert_eq!(
            face_normal([DVec3::ZERO, point, DVec3::new(0.3, 0.6, 0.9)]),
            None
        );
    }

    #[test]
    fn faces_back_to_back_keep_their_own_normals() {
        let mesh = TriangleMesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 1]],
            ..TriangleMesh::default()
        };
        for crease in [0.0, 90.0, 180.0] {
            let normals = per_corner(&mesh, crease);
            assert_eq!(normals, [[DVec3::Z; 3], [DVec3::NEG_Z; 3]], "{crease}");
        }
    }

    #[test]
    fn a_face_that_is_there_twice_counts_once() {
        let clean = sphere(1);
        let mut repeated = clean.clone();
        for (index, &[a, b, c]) in clean.triangles.iter().enumerate() {
            let again = [[a, b, c], [b, c, a], [a, c, b]];
            repeated.triangles.extend(&again[..index % 4]);
        }
        assert!(repeated.triangles.len() > 2 * clean.triangles.len());
        for crease in [0.0, 25.0, 40.0, 180.0] {
            let expected = per_corner(&clean, crease);
            let found = per_corner(&repeated, crease);
            assert_eq!(found[..expected.len()], expected, "{crease}");
        }
    }

    #[test]
    fn a_triangle_without_area_takes_a_neighbours_normal_or_up() {
        let mesh = TriangleMesh {
            positions: vec![
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::X * 2.0,
                DVec3::X * 3.0,
            ],
            triangles: vec![[0, 1, 3], [0, 2, 1], [3, 4, 4]],
            ..TriangleMesh::default()
        };
        for crease in [30.0, 180.0] {
            let normals = per_corner(&mesh, crease);
            assert_eq!(normals[0], [DVec3::NEG_Z, DVec3::NEG_Z, DVec3::Z]);
            assert_eq!(normals[2], [DVec3::Z; 3]);
        }
    }

    #[test]
    fn the_files_normals_win_where_they_are_not_zero() {
        let mut cube = cube();
        let own = DVec3::new(1.0, 2.0, 3.0);
        let mut normals = vec![own * 1e200; 8];
        normals[0] = DVec3::ZERO;
        normals[1] = own * 5e-324;
        cube.normals = Some(normals);
        let shading = per_corner(&cube, 30.0);
        for (triangle, corners) in cube.triangles.iter().zip(shading) {
            let face = face_normal(triangle.map(|v| cube.positions[v as usize])).expect("an area");
            for (&vertex, normal) in triangle.iter().zip(corners) {
                let expected = match vertex {
                    0 => face,
                    1 => DVec3::new(1.0, 2.0, 3.0) / 14.0_f64.sqrt(),
                    _ => own / own.length(),
                };
                assert!(normal.distance(expected) < 1e-14, "vertex {vertex}");
            }
        }
    }

    /// Pages of a book: thirty faces meet in one edge, neighbours 12° apart.
    #[test]
    fn many_faces_at_one_edge_join_their_neighbours() {
        let pages = 30;
        let mut mesh = TriangleMesh {
            positions: vec![DVec3::ZERO, DVec3::Z],
            ..TriangleMesh::default()
        };
        // The pages are not in the order of their angle.
        for page in (0..pages).map(|page| page * 7 % pages) {
            let angle = Degrees(f64::from(page) * 12.0).radians();
            mesh.positions
                .push(DVec3::new(libm::cos(angle), libm::sin(angle), 0.5));
            let outer = u32::try_from(mesh.positions.len() - 1).expect("few");
            mesh.triangles.push([0, outer, 1]);
        }
        assert_flat(&mesh, 11.0);
        // From 13° on, all join in a ring whose average vanishes.
        assert_flat(&mesh, 13.0);
        mesh.triangles.retain(|&[_, outer, _]| {
            let page = mesh.positions[outer as usize];
            page.x > 0.5
        });
        let normals = corner_normals(&mesh, Degrees(13.0)).normals;
        assert_eq!(normals.len(), 2 + mesh.triangles.len());
        assert!(normals[0].distance(DVec3::NEG_Y) < 1e-12, "{}", normals[0]);
    }

    #[test]
    fn an_empty_mesh_and_unused_vertices_have_no_normals() {
        let mut mesh = TriangleMesh::default();
        assert_eq!(
            corner_normals(&mesh, Degrees(30.0)),
            CornerNormals::default()
        );
        mesh.positions = vec![DVec3::ONE; 3];
        mesh.normals = Some(vec![DVec3::ONE; 3]);
        assert_eq!(
            corner_normals(&mesh, Degrees(30.0)),
            CornerNormals::default()
        );
    }
}
