//! Turns a field into a mesh by marching tetrahedra, and polishes the result.
//!
//! Marching tetrahedra after Doi and Koide, "An Efficient Method of Triangulating Equi-Valued
//! Surfaces by Using Tetrahedral Cells", 1991, on Kuhn's six tetrahedra per cube: unlike marching
//! cubes it has no ambiguous case, so its mesh is always a closed manifold. Its many slivers are
//! dealt with afterwards, by [`crate::simplify`] and [`relax`]; [`project`] then takes the vertices
//! from the lattice's linear estimate to the true surface.

use crate::mesh::Mesh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

pub trait Field: Fn(DVec3) -> f64 + Sync {}
impl<F: Fn(DVec3) -> f64 + Sync> Field for F {}

/// Counts along the three axes, or the place of a node or a cube in the lattice.
type Index = [usize; 3];

/// The field sampled on the nodes of a cubic lattice.
struct Lattice {
    origin: DVec3,
    step: f64,
    size: Index,
    values: Vec<f64>,
}

impl Lattice {
    /// Nodes along the side of a block.
    const BLOCK: usize = 8;

    /// Samples the field: node by node near the skin, block by block away from it, where only
    /// the sign will matter.
    fn sample(field: &impl Field, [low, high]: [DVec3; 2], step: f64) -> Self {
        // Half a step off, so that no node lies in the ground plane the soles are cut along.
        let origin = low - 0.5 * step;
        let size = ((high - origin) / step)
            .to_array()
            .map(|steps| whole(steps) + 2);
        let side = step * Self::BLOCK as f64;
        let middle = origin + 0.5 * (side - step);
        let blocks = Self::fill(middle, side, size.map(|n| n / Self::BLOCK + 1), |_, p| {
            field(p)
        });
        // Twice a block's outer radius, as fields may overstate distances.
        let far = 3.0_f64.sqrt() * side;
        Self::fill(origin, step, size, |index, p| {
            let coarse = blocks.values[blocks.node(index.map(|i| i / Self::BLOCK))];
            if coarse.abs() > far { coarse } else { field(p) }
        })
    }

    fn fill(
        origin: DVec3,
        step: f64,
        size: Index,
        value: impl Fn(Index, DVec3) -> f64 + Sync,
    ) -> Self {
        let mut lattice = Self {
            origin,
            step,
            size,
            values: Vec::new(),
        };
        let at_node = |node| value(lattice.index(node), lattice.position(node));
        lattice.values = (0..size.iter().product())
            .into_par_iter()
            .map(at_node)
            .collect();
        lattice
    }

    fn node(&self, [x, y, z]: Index) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    fn index(&self, node: usize) -> Index {
        let row = node / self.size[0];
        [node % self.size[0], row % self.size[1], row / self.size[1]]
    }

    fn position(&self, node: usize) -> DVec3 {
        self.origin + self.step * DVec3::from(self.index(node).map(|i| i as f64))
    }

    fn inside(&self, node: usize) -> bool {
        self.values[node] < 0.0
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few hundred"
)]
fn whole(steps: f64) -> usize {
    steps.ceil() as usize
}

/// Meshes the zero set of `field` between the corners of a box, on a lattice of the given step.
pub fn march(field: &impl Field, corners: [DVec3; 2], step: f64) -> Mesh {
    let lattice = Lattice::sample(field, corners, step);
    let mut marcher = Marcher {
        lattice: &lattice,
        crossings: HashMap::new(),
        mesh: Mesh {
            vertices: Vec::new(),
            faces: Vec::new(),
        },
    };
    for z in 1..lattice.size[2] {
        for y in 1..lattice.size[1] {
            for x in 1..lattice.size[0] {
                marcher.cube([x - 1, y - 1, z - 1]);
            }
        }
    }
    marcher.mesh
}

struct Marcher<'a> {
    lattice: &'a Lattice,
    /// The vertex on each lattice edge that crosses the skin.
    crossings: HashMap<(usize, usize), usize>,
    mesh: Mesh,
}

/// Kuhn's tetrahedra: each walks from a cube's lowest to its highest corner along the three axes
/// in one of six orders. Corners are numbered by bits; even orders of the axes come first.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 2, 6, 7],
    [0, 4, 5, 7],
    [0, 2, 3, 7],
    [0, 1, 5, 7],
    [0, 4, 6, 7],
];

impl Marcher<'_> {
    fn cube(&mut self, [x, y, z]: Index) {
        let corners: [usize; 8] = std::array::from_fn(|bits| {
            self.lattice
                .node([x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2)])
        });
        let inside = corners
            .iter()
            .filter(|&&node| self.lattice.inside(node))
            .count();
        if inside == 0 || inside == corners.len() {
            return;
        }
        for (i, path) in TETRAHEDRA.iter().enumerate() {
            self.tetrahedron(path.map(|corner| corners[corner]), i >= 3);
        }
    }

    /// Adds the faces between the inner and the outer corners of one tetrahedron.
    fn tetrahedron(&mut self, nodes: [usize; 4], left_handed: bool) {
        let inner = nodes.iter().filter(|&&n| self.lattice.inside(n));
        let outer = nodes.iter().filter(|&&n| !self.lattice.inside(n));
        let sorted: Vec<usize> = inner.chain(outer).copied().collect();
        let rank = |node: usize| nodes.iter().position(|&n| n == node);
        let swaps = (0..4)
            .flat_map(|i| (0..i).map(move |j| (j, i)))
            .filter(|&(j, i)| rank(sorted[j]) > rank(sorted[i]))
            .count();
        let flip = left_handed != (swaps % 2 == 1);
        let [a, b, c, d] = [sorted[0], sorted[1], sorted[2], sorted[3]];
        match nodes.iter().filter(|&&n| self.lattice.inside(n)).count() {
            1 => self.faces(&[(a, b), (a, c), (a, d)], flip),
            2 => self.faces(&[(a, c), (a, d), (b, d), (b, c)], flip),
            3 => self.faces(&[(a, d), (b, d), (c, d)], flip),
            _ => {}
        }
    }

    /// Adds a triangle, or a quadrilateral as two.
    fn faces(&mut self, edges: &[(usize, usize)], flip: bool) {
        let mut ring: Vec<usize> = edges.iter().map(|&(a, b)| self.crossing(a, b)).collect();
        if flip {
            ring.reverse();
        }
        for k in 2..ring.len() {
            self.mesh.faces.push([ring[0], ring[k - 1], ring[k]]);
        }
    }

    fn crossing(&mut self, a: usize, b: usize) -> usize {
        let lattice = self.lattice;
        let vertices = &mut self.mesh.vertices;
        *self
            .crossings
            .entry((a.min(b), a.max(b)))
            .or_insert_with(|| {
                let (fa, fb) = (lattice.values[a], lattice.values[b]);
                // Kept off the lattice nodes, where several vertices could coincide.
                let t = (fa / (fa - fb)).clamp(0.02, 0.98);
                vertices.push(lattice.position(a).lerp(lattice.position(b), t));
                vertices.len() - 1
            })
    }
}

/// Moves every vertex onto the zero set along the gradient, by no more than `limit`.
pub fn project(field: &impl Field, mesh: &mut Mesh, limit: f64) {
    mesh.vertices
        .par_iter_mut()
        .for_each(|v| *v = projected(field, *v, limit));
}

fn projected(field: &impl Field, start: DVec3, limit: f64) -> DVec3 {
    const NEWTON_STEPS: usize = 4;
    let mut p = start;
    for _ in 0..NEWTON_STEPS {
        let slope = gradient(field, p);
        p -= slope * (field(p) / slope.length_squared().max(0.1));
    }
    start + (p - start).clamp_length_max(limit)
}

/// The gradient from four samples at the corners of a small tetrahedron.
fn gradient(field: &impl Field, p: DVec3) -> DVec3 {
    const REACH: f64 = 2e-4;
    let corners = [
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::ONE,
    ];
    corners
        .iter()
        .map(|&c| c * field(p + c * REACH))
        .sum::<DVec3>()
        / (4.0 * REACH)
}

/// Evens out the triangles: vertices slide along the skin towards the middle of their
/// neighbours. Those on a crease or an edge stay, so that features keep their crispness.
pub fn relax(field: &impl Field, mesh: &mut Mesh, rounds: usize) {
    const PACE: f64 = 0.5;
    let around = mesh.faces_by_vertex();
    for _ in 0..rounds {
        let targets: Vec<Option<DVec3>> = (0..mesh.vertices.len())
            .into_par_iter()
            .map(|i| {
                let v = mesh.vertices[i];
                let normal = flat_normal(mesh, &around[i])?;
                let ring = around[i]
                    .iter()
                    .flat_map(|&f| mesh.faces[f])
                    .filter(|&c| c != i);
                let middle =
                    ring.map(|c| mesh.vertices[c]).sum::<DVec3>() / (2 * around[i].len()) as f64;
                let slide = PACE * (middle - v).reject_from_normalized(normal);
                Some(projected(field, v + slide, slide.length()))
            })
            .collect();
        for (i, target) in targets.into_iter().enumerate() {
            if let Some(target) = target {
                move_unless_folding(mesh, i, &around[i], target);
            }
        }
    }
}

/// The mean normal of some faces, if they all lie near enough to one plane.
fn flat_normal(mesh: &Mesh, faces: &[usize]) -> Option<DVec3> {
    const FLATNESS: f64 = 0.8;
    let mean = faces
        .iter()
        .map(|&f| mesh.area_vector(mesh.faces[f]))
        .sum::<DVec3>()
        .try_normalize()?;
    let is_flat = |&f: &usize| {
        mesh.area_vector(mesh.faces[f])
            .normalize_or_zero()
            .dot(mean)
            > FLATNESS
    };
    faces.iter().all(is_flat).then_some(mean)
}

fn move_unless_folding(mesh: &mut Mesh, vertex: usize, around: &[usize], target: DVec3) {
    let before: Vec<DVec3> = around
        .iter()
        .map(|&f| mesh.area_vector(mesh.faces[f]))
        .collect();
    let home = std::mem::replace(&mut mesh.vertices[vertex], target);
    let folds = around.iter().zip(before).any(|(&f, old)| {
        let new = mesh.area_vector(mesh.faces[f]);
        new.dot(old) < 0.5 * new.length() * old.length() || new.length() < 0.1 * old.length()
    });
    if folds {
        mesh.vertices[vertex] = home;
    }
}
