//! Generated meshes: well-behaved ones to build scenes from, and hostile ones to test with.
//!
//! Closed shapes have outward faces and share their vertices. Random shapes are the same for the same seed everywhere.

use super::TriangleMesh;
use crate::math::DVec3;
use std::collections::HashMap;

/// A unit sphere of `20 · 4^subdivisions` triangles: an icosahedron whose faces are cut in four and pushed out.
#[must_use]
pub fn icosphere(subdivisions: u32) -> TriangleMesh {
    let mut mesh = icosahedron();
    for _ in 0..subdivisions {
        let mut midpoints = HashMap::new();
        let mut triangles = Vec::with_capacity(mesh.triangles.len() * 4);
        for [a, b, c] in mesh.triangles {
            let mut midpoint = |p: u32, q: u32| {
                *midpoints.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let sum = mesh.positions[p as usize] + mesh.positions[q as usize];
                    mesh.positions.push(sum.normalize());
                    last_index(&mesh.positions)
                })
            };
            let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
            triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        mesh.triangles = triangles;
    }
    mesh
}

fn icosahedron() -> TriangleMesh {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut positions = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            positions.extend([
                DVec3::new(0.0, a, b),
                DVec3::new(a, b, 0.0),
                DVec3::new(b, 0.0, a),
            ]);
        }
    }
    // The faces are the triples of vertices two units apart, turned outwards.
    let edge =
        |p: usize, q: usize| (positions[p].distance_squared(positions[q]) - 4.0).abs() < 1e-9;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if edge(a, b) && edge(b, c) && edge(c, a) {
                    let outwards = positions[a].dot(positions[b].cross(positions[c])) > 0.0;
                    let [b, c] = if outwards { [b, c] } else { [c, b] };
                    triangles.push([a, b, c].map(|i| u32::try_from(i).expect("below 12")));
                }
            }
        }
    }
    TriangleMesh {
        positions: positions.into_iter().map(DVec3::normalize).collect(),
        triangles,
        ..TriangleMesh::default()
    }
}

/// The box between two corners, of twelve triangles.
#[must_use]
pub fn cuboid(min: DVec3, max: DVec3) -> TriangleMesh {
    let corner = |i: u32| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    // Bit k of a corner's index says which end of axis k it is at.
    let sides = [
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
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..TriangleMesh::default()
    }
}

/// The square `[-1, 1]²` in the plane z = 0, facing +z, of `2 · cells²` triangles.
#[must_use]
pub fn grid(cells: u32) -> TriangleMesh {
    let vertex = |row: u32, column: u32| row * (cells + 1) + column;
    let coordinate = |i: u32| 2.0 * f64::from(i) / f64::from(cells) - 1.0;
    let mut mesh = TriangleMesh::default();
    for row in 0..=cells {
        for column in 0..=cells {
            mesh.positions
                .push(DVec3::new(coordinate(column), coordinate(row), 0.0));
        }
    }
    for row in 0..cells {
        for column in 0..cells {
            let [a, b] = [vertex(row, column), vertex(row, column + 1)];
            let [c, d] = [vertex(row + 1, column + 1), vertex(row + 1, column)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// `count` unconnected triangles in the cube `[-1, 1]³`, with corners up to `size` from their middle along each axis.
#[must_use]
pub fn soup(count: u32, size: f64, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |_| {
        let middle = random.in_cube();
        [(); 3].map(|()| middle + random.in_cube() * size)
    })
}

/// `count` unconnected triangles with edges of about 1 and `aspect`.
#[must_use]
pub fn slivers(count: u32, aspect: f64, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |_| {
        let (start, end) = (random.in_cube(), random.in_cube());
        [start, end, end + random.in_cube() * aspect]
    })
}

/// `count` triangles around one common vertex at the origin, in all directions.
#[must_use]
pub fn vertex_fan(count: u32, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |_| [DVec3::ZERO, random.in_cube(), random.in_cube()])
}

/// `count` large triangles that overlap each other in the plane z = 0.
#[must_use]
pub fn flat_overlap(count: u32, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |_| [(); 3].map(|()| random.in_cube().with_z(0.0)))
}

/// `count` triangles that all contain a neighbourhood of the origin, in random planes through it.
#[must_use]
pub fn one_spot(count: u32, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |_| {
        let (a, b) = (random.in_cube(), random.in_cube());
        [a, b, -(a + b)]
    })
}

/// `count` triangles in axis-aligned planes, with all corners on a lattice of `steps` cells per side.
#[must_use]
pub fn axis_aligned(count: u32, steps: u32, seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    unconnected(count, |i| {
        let mut corners = [(); 3].map(|()| {
            let lattice = (random.in_cube() + 1.0) * (f64::from(steps) / 2.0);
            lattice.round() * (2.0 / f64::from(steps)) - 1.0
        });
        let axis = (i % 3) as usize;
        corners[1][axis] = corners[0][axis];
        corners[2][axis] = corners[0][axis];
        corners
    })
}

fn unconnected(count: u32, mut corners: impl FnMut(u32) -> [DVec3; 3]) -> TriangleMesh {
    TriangleMesh {
        positions: (0..count).flat_map(&mut corners).collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..TriangleMesh::default()
    }
}

fn last_index(positions: &[DVec3]) -> u32 {
    u32::try_from(positions.len() - 1).expect("generated meshes are small")
}

/// Random numbers that are the same on every machine. Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number
/// Generators, 2014 (`SplitMix64`).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers that follow from `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `0..1`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the cube `[-1, 1]³`.
    pub fn in_cube(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Closed: every edge is used once in each direction. Outward: Euler's formula and a positive volume.
    fn assert_closed(mesh: &TriangleMesh, volume: f64) {
        mesh.validate().unwrap();
        let mut edges = HashSet::new();
        for &[a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert(edge), "edge {edge:?} is used twice");
            }
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
        assert_eq!(
            mesh.positions.len() + mesh.triangles.len(),
            edges.len() / 2 + 2
        );
        let corners = (0..mesh.triangles.len()).map(|i| mesh.corners(i));
        let sum: f64 = corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        assert!(
            (sum - volume).abs() < 0.01 * volume,
            "volume {sum}, expected {volume}"
        );
    }

    #[test]
    fn closed_shapes_are_closed_and_face_outwards() {
        let sphere = icosphere(4);
        assert_eq!(sphere.triangles.len(), 20 << 8);
        assert_closed(&sphere, 4.0 / 3.0 * std::f64::consts::PI);
        assert_closed(&cuboid(DVec3::NEG_ONE, DVec3::new(1.0, 2.0, 3.0)), 24.0);
    }

    #[test]
    fn a_grid_covers_its_square_facing_up() {
        let mesh = grid(5);
        mesh.validate().unwrap();
        let corners = (0..50).map(|i| mesh.corners(i));
        for (a, b, c) in corners.map(|[a, b, c]| (a, b, c)) {
            let double_area = (b - a).cross(c - a);
            assert!((double_area - DVec3::Z * 0.16).length() < 1e-12);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_soup() {
        assert_eq!(soup(10, 0.1, 7), soup(10, 0.1, 7));
        assert_ne!(soup(10, 0.1, 7), soup(10, 0.1, 8));
    }
}
