//! Shading normals of corners, from the faces around them.
//!
//! Directions depend on shape alone, see [`super::face_normal`]. The functions here expect valid meshes and panic on indices out of range.

use super::buckets::Buckets;
use super::face_normal::{edges_of, face_normal, longest_edge, near_one};
use super::{TriangleMesh, Welded};
use crate::control::CancelToken;
use crate::math::{DVec3, Degrees};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Corners, or vertices, between two looks at the cancel token.
const CHUNK: usize = 1 << 12;

/// Shading normals, one for each way a vertex is seen by the faces around it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerNormals {
    /// Unit vectors.
    pub normals: Vec<DVec3>,
    /// Three indices into `normals` per triangle, in the order of its corners.
    pub corners: Vec<[u32; 3]>,
}

/// Shading normals of all corners: the mesh's own where it has them, else averages of the faces around a vertex.
///
/// An average weighs each face by its angle at the vertex, so that it does not depend on how a flat part is cut into triangles. Faces share
/// it where a chain of faces, each meeting the next across an edge at no more than `crease`, connects them around the vertex; from 180° on,
/// all faces of the vertex do. `crease` 0 (or negative, or NaN) joins only coplanar faces. A face that is there twice, either way round,
/// counts once. Where an average vanishes, as between two opposite faces, each corner has its face's normal; a corner of a triangle without
/// area takes a normal of its vertex's other faces, or +Z when there is none. Of a mesh with texture coordinates, vertices at one place
/// count as one: they are several only where the image has a seam. `None` when cancelled.
///
/// Source: Thürmer & Wüthrich, Computing Vertex Normals from Polygonal Facets, Journal of Graphics Tools 3(1), 1998.
///
/// # Panics
/// When the mesh is not valid, or has more than 2³²/3 triangles.
#[must_use]
pub fn corner_normals(
    mesh: &TriangleMesh,
    crease: Degrees,
    cancel: &CancelToken,
) -> Option<CornerNormals> {
    if mesh.normals.is_none() && mesh.texture_coordinates.is_some() {
        let welded = Welded::new(mesh);
        let triangles = mesh.triangles.par_iter();
        let seamless = TriangleMesh {
            positions: mesh.positions.clone(),
            triangles: triangles.map(|&corners| welded.corners(corners)).collect(),
            ..TriangleMesh::default()
        };
        return corner_normals(&seamless, crease, cancel);
    }
    let (faces, angles) = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|triangle| {
            if cancel.is_cancelled() {
                return Default::default();
            }
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
    let vertices = mesh.triangles.iter().flatten().copied();
    let corners = vertices.zip((0..).map(Corner));
    let corners = corners.take_while(|(_, corner)| {
        !(corner.0 as usize).is_multiple_of(CHUNK) || !cancel.is_cancelled()
    });
    let fans = Buckets::new(mesh.positions.len(), corners);
    let mut groups = FanGroups::default();
    for vertex in 0..mesh.positions.len() {
        if vertex % CHUNK == 0 && cancel.is_cancelled() {
            return None;
        }
        let fan = fans.of(vertex);
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
    (!cancel.is_cancelled()).then_some(shading.result)
}

/// The normal the file gave, as a unit vector; `None` where it gave none or zero.
fn own_normal(mesh: &TriangleMesh, vertex: usize) -> Option<DVec3> {
    let normal = near_one(mesh.normals.as_ref()?[vertex]);
    (normal != DVec3::ZERO).then(|| normal / normal.length())
}

/// One corner of one triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Corner(u32);

impl Corner {
    fn triangle(self) -> usize {
        self.0 as usize / 3
    }

    fn index(self) -> usize {
        self.0 as usize % 3
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
mod tests;
