//! Thins a mesh out by collapsing edges, cheapest first.
//!
//! The cost is the quadric error of Garland and Heckbert, "Surface Simplification Using Quadric
//! Error Metrics", 1997: triangles stay small where the skin bends and grow where it is flat. A
//! slight pull towards the original vertices keeps the flat parts evenly meshed, and collapses
//! that would fold the skin, make a sliver or pinch the manifold are refused.

use crate::mesh::Mesh;
use glam::{DMat3, DVec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The weighted sum of squared distances to a set of planes, as a function of position:
/// `p·a·p - 2 b·p + c`.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const ZERO: Self = Self {
        a: DMat3::ZERO,
        b: DVec3::ZERO,
        c: 0.0,
    };

    /// The plane through `p` across `normal`.
    fn plane(p: DVec3, normal: DVec3, weight: f64) -> Self {
        let scaled = normal * weight;
        let offset = normal.dot(p);
        let a = DMat3::from_cols(scaled * normal.x, scaled * normal.y, scaled * normal.z);
        Self {
            a,
            b: scaled * offset,
            c: weight * offset * offset,
        }
    }

    /// The squared distance to `p` itself.
    fn point(p: DVec3, weight: f64) -> Self {
        Self {
            a: DMat3::from_diagonal(DVec3::splat(weight)),
            b: p * weight,
            c: weight * p.length_squared(),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            a: self.a + other.a,
            b: self.b + other.b,
            c: self.c + other.c,
        }
    }

    fn error(&self, p: DVec3) -> f64 {
        (p.dot(self.a * p) - 2.0 * self.b.dot(p) + self.c).max(0.0)
    }

    fn minimum(&self) -> DVec3 {
        self.a.inverse() * self.b
    }
}

/// An edge waiting for collapse. Stale once either end has changed since.
struct Candidate {
    cost: f64,
    ends: [usize; 2],
    versions: [u32; 2],
}

/// Ordered for a heap that yields the cheapest first; vertex numbers break ties, so that every
/// run collapses the same edges.
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

/// Collapses edges until at most `budget` faces are left.
pub fn simplify(mesh: Mesh, budget: usize) -> Mesh {
    let mut thinner = Thinner::new(mesh);
    let mut left = thinner.mesh.faces.len();
    let mut left_before = usize::MAX;
    while left > budget {
        let Some(candidate) = thinner.heap.pop() else {
            // What was refused once may be sound by now.
            if left == left_before {
                break;
            }
            left_before = left;
            thinner.consider_all();
            continue;
        };
        if !thinner.is_current(&candidate) {
            continue;
        }
        let target = thinner.joint_quadric(candidate.ends).minimum();
        if thinner.may_collapse(candidate.ends, target) {
            thinner.collapse(candidate.ends, target);
            left -= 2;
        }
    }
    thinner.finish()
}

struct Thinner {
    mesh: Mesh,
    around: Vec<Vec<usize>>,
    quadrics: Vec<Quadric>,
    versions: Vec<u32>,
    heap: BinaryHeap<Candidate>,
}

impl Thinner {
    /// Weight of staying near the original vertices, against staying in the planes.
    const EVENNESS: f64 = 1.5e-2;
    /// Least [`shape`] of a triangle that a collapse may leave behind.
    const LEAST_SHAPE: f64 = 0.2;
    /// How much of its shape a triangle already worse than that may still lose. Without this
    /// concession the slivers of the raw mesh block each other.
    const SHAPE_KEPT: f64 = 0.7;
    /// Below this [`shape`] the direction of a triangle means nothing.
    const SLIVER: f64 = 0.1;
    /// Least cosine of the angle a triangle may turn by.
    const LEAST_COSINE: f64 = 0.3;

    fn new(mesh: Mesh) -> Self {
        let mut quadrics = vec![Quadric::ZERO; mesh.vertices.len()];
        for &face in &mesh.faces {
            let area = mesh.area_vector(face);
            let weight = area.length() / 6.0;
            for corner in face {
                let p = mesh.vertices[corner];
                let planes = Quadric::plane(p, area.normalize_or_zero(), weight);
                quadrics[corner] = quadrics[corner]
                    .plus(planes)
                    .plus(Quadric::point(p, Self::EVENNESS * weight));
            }
        }
        let versions = vec![0; mesh.vertices.len()];
        let mut thinner = Self {
            around: mesh.faces_by_vertex(),
            mesh,
            quadrics,
            versions,
            heap: BinaryHeap::new(),
        };
        thinner.consider_all();
        thinner
    }

    fn consider_all(&mut self) {
        for face in 0..self.mesh.faces.len() {
            let [a, b, c] = self.mesh.faces[face];
            for (from, to) in [(a, b), (b, c), (c, a)] {
                // Each edge has two faces, which run along it in opposite directions.
                if from < to {
                    self.consider(from, to);
                }
            }
        }
    }

    fn consider(&mut self, a: usize, b: usize) {
        let ends = [a.min(b), a.max(b)];
        let quadric = self.joint_quadric(ends);
        let target = quadric.minimum();
        let cost = quadric.error(target);
        if target.is_finite() {
            let versions = ends.map(|end| self.versions[end]);
            self.heap.push(Candidate {
                cost,
                ends,
                versions,
            });
        }
    }

    fn joint_quadric(&self, [a, b]: [usize; 2]) -> Quadric {
        self.quadrics[a].plus(self.quadrics[b])
    }

    fn is_current(&self, candidate: &Candidate) -> bool {
        candidate.ends.map(|end| self.versions[end]) == candidate.versions
    }

    /// The vertices joined to `vertex` by an edge, in ascending order.
    fn neighbours(&self, vertex: usize) -> Vec<usize> {
        let corners = self.around[vertex].iter().flat_map(|&f| self.mesh.faces[f]);
        let mut neighbours: Vec<usize> = corners.filter(|&corner| corner != vertex).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    fn may_collapse(&self, [a, b]: [usize; 2], target: DVec3) -> bool {
        // The link condition: more common neighbours than the two faces' tips mean a pinch.
        let beside_b = self.neighbours(b);
        let beside_both = self
            .neighbours(a)
            .into_iter()
            .filter(|n| beside_b.contains(n));
        if beside_both.count() != 2 {
            return false;
        }
        let stays_sound = |kept: usize, lost: usize| {
            let faces = self.around[kept].iter().map(|&f| self.mesh.faces[f]);
            faces
                .filter(|face| !face.contains(&lost))
                .all(|face| self.stays_sound(face, kept, target))
        };
        stays_sound(a, b) && stays_sound(b, a)
    }

    /// Whether a face keeps its direction and a decent shape when one of its corners moves.
    fn stays_sound(&self, face: [usize; 3], moved: usize, target: DVec3) -> bool {
        let old = self.mesh.area_vector(face);
        let [p, q, r] = face.map(|corner| {
            if corner == moved {
                target
            } else {
                self.mesh.vertices[corner]
            }
        });
        let new = (q - p).cross(r - p);
        let old_shape = shape_of(&self.mesh, face);
        let turns = new.dot(old) < Self::LEAST_COSINE * new.length() * old.length();
        let folds = turns && old_shape > Self::SLIVER;
        !folds && shape(p, q, r) >= Self::LEAST_SHAPE.min(Self::SHAPE_KEPT * old_shape)
    }

    fn collapse(&mut self, [kept, lost]: [usize; 2], target: DVec3) {
        self.mesh.vertices[kept] = target;
        self.quadrics[kept] = self.quadrics[kept].plus(self.quadrics[lost]);
        self.versions[lost] += 1;
        for face in std::mem::take(&mut self.around[lost]) {
            if self.mesh.faces[face].contains(&kept) {
                for corner in self.mesh.faces[face] {
                    self.around[corner].retain(|&f| f != face);
                }
                self.mesh.faces[face] = [kept; 3];
            } else {
                self.mesh.faces[face] =
                    self.mesh.faces[face].map(|c| if c == lost { kept } else { c });
                self.around[kept].push(face);
            }
        }
        self.versions[kept] += 1;
        for neighbour in self.neighbours(kept) {
            self.consider(kept, neighbour);
        }
    }

    fn finish(mut self) -> Mesh {
        self.mesh.faces.retain(|[a, b, _]| a != b);
        self.mesh.drop_unused_vertices();
        self.mesh
    }
}

fn shape_of(mesh: &Mesh, [a, b, c]: [usize; 3]) -> f64 {
    shape(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c])
}

/// One for an equilateral triangle, zero for a sliver.
fn shape(p: DVec3, q: DVec3, r: DVec3) -> f64 {
    let sides = p.distance_squared(q) + q.distance_squared(r) + r.distance_squared(p);
    2.0 * 3.0_f64.sqrt() * (q - p).cross(r - p).length() / sides.max(1e-30)
}
