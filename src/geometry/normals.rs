//! Normals of faces and shading normals of corners.
//!
//! Directions depend on shape alone: before anything is multiplied, lengths from 1e−300 to 1e300 are brought near 1 by an
//! exact power of two. The functions here expect valid meshes and panic on indices out of range.

use super::TriangleMesh;
use crate::math::{DVec3, Degrees, power_of_two};

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
    let edges = [b - a, c - b, a - c];
    let longest = edges
        .iter()
        .fold(0.0, |longest, edge| edge.abs().max_element().max(longest));
    if longest == f64::INFINITY {
        // Differences of the largest numbers overflow; those of their quarters do not.
        return significant_cross(corners.map(|corner| corner * 0.25));
    }
    let scale = scale_to_one(longest);
    let [p, q] = two_shorter(edges.map(|edge| edge * scale));
    let cross = p.cross(q);

    // A coordinate of an edge is off by the roundings of two corners and of the subtraction; |coordinate| ≤ 2 |corner|.
    let edge_error = a.abs().max(b.abs()).max(c.abs()) * scale * (4.0 * UNIT_ROUNDOFF);
    let (p, q) = (p.abs(), q.abs());
    let from_edges = absolute_cross(edge_error, p + q);
    let from_products = absolute_cross(p, q) * (2.0 * UNIT_ROUNDOFF);
    let is_noise = cross.abs().cmple(from_edges + from_products).all();
    (!is_noise).then_some(cross)
}

/// The two edges, of three that form a triangle, whose cross product loses the fewest digits, in cyclic order.
fn two_shorter(edges: [DVec3; 3]) -> [DVec3; 2] {
    let [a, b, c] = edges.map(DVec3::length_squared);
    if a >= b && a >= c {
        [edges[1], edges[2]]
    } else if b >= c {
        [edges[2], edges[0]]
    } else {
        [edges[0], edges[1]]
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

/// A power of two that brings `magnitude` near 1; 1 for zero.
fn scale_to_one(magnitude: f64) -> f64 {
    if magnitude > 0.0 {
        power_of_two(-libm::frexp(magnitude).1.clamp(-1022, 1022))
    } else {
        1.0
    }
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
/// coplanar faces. Where an average vanishes, as between two opposite faces, each corner has its face's normal; a corner
/// of a triangle without area takes a normal of its vertex's other faces, or +Z when there is none.
///
/// Source: Thürmer & Wüthrich, Computing Vertex Normals from Polygonal Facets, Journal of Graphics Tools 3(1), 1998.
///
/// # Panics
/// When the mesh is not valid, or has more than 2³²/3 triangles.
#[must_use]
pub fn corner_normals(mesh: &TriangleMesh, crease: Degrees) -> CornerNormals {
    let faces = (0..mesh.triangles.len())
        .map(|triangle| face_normal(mesh.corners(triangle)))
        .collect();
    let mut shading = Shading {
        mesh,
        faces,
        sharing: Sharing::up_to(crease),
        result: CornerNormals {
            normals: Vec::new(),
            corners: vec![[0; 3]; mesh.triangles.len()],
        },
    };
    let fans = Fans::of(mesh);
    let mut fan_groups = FanGroups::default();
    for vertex in 0..mesh.positions.len() {
        let fan = fans.around(vertex);
        match own_normal(mesh, vertex) {
            Some(normal) if !fan.is_empty() => {
                let id = shading.add(normal);
                fan.iter().for_each(|&corner| shading.assign(corner, id));
            }
            _ => shading.average(fan, &mut fan_groups),
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
        groups.find(fan, self.mesh, &self.faces, self.sharing);
        groups.sums.clear();
        groups.sums.resize(fan.len(), GroupSum::default());
        for (place, &corner) in fan.iter().enumerate() {
            if let Some(normal) = self.faces[corner.triangle()] {
                let angle = corner_angle(self.mesh, corner);
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

/// The angle of a triangle at one of its corners, in radians.
fn corner_angle(mesh: &TriangleMesh, corner: Corner) -> f64 {
    let points = mesh.corners(corner.triangle()).map(|point| point * 0.25);
    let here = points[corner.index()];
    let to_next = near_one(points[(corner.index() + 1) % 3] - here);
    let to_previous = near_one(points[(corner.index() + 2) % 3] - here);
    libm::atan2(
        to_next.cross(to_previous).length(),
        to_next.dot(to_previous),
    )
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
    /// Fills `leaders`.
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
