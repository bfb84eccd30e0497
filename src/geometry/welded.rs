//! Vertices at exactly the same place count as one, as meshes repeat a vertex wherever normals or texture coordinates differ.

use std::hash::BuildHasher;

use foldhash::fast::RandomState;
use rayon::prelude::*;

use super::TriangleMesh;

/// Which vertices of a mesh are at the same place, exactly.
pub struct Welded {
    /// For each vertex the first one at its place.
    firsts: Vec<u32>,
}

impl Welded {
    /// Finds them.
    ///
    /// # Panics
    /// When there are 2³² vertices; indices of triangles reach no further.
    #[must_use]
    pub fn new(mesh: &TriangleMesh) -> Self {
        let positions = &mesh.positions;
        let count = u32::try_from(positions.len()).expect("fewer than 2^32 vertices");
        // A sum with 0 makes 0 of −0, which is at the same place.
        let place = |vertex: u32| (positions[vertex as usize] + 0.0).to_array();
        // Numbers side by side are sorted in a quarter of the time that places far apart take.
        let hasher = RandomState::default();
        let hash = |vertex| (hasher.hash_one(place(vertex).map(f64::to_bits)), vertex);
        let mut sorted: Vec<(u64, u32)> = (0..count).into_par_iter().map(hash).collect();
        sorted.par_sort_unstable();
        let mut firsts: Vec<u32> = (0..count).collect();
        for alike in sorted.chunk_by_mut(|a, b| a.0 == b.0) {
            if alike.len() < 2 {
                continue;
            }
            let mut first = alike[0].1;
            if !alike
                .iter()
                .all(|&(_, vertex)| place(vertex) == place(first))
            {
                alike.sort_unstable_by(|&(_, a), &(_, b)| {
                    let (pa, pb) = (place(a), place(b));
                    let by_axis = |axis: usize| pa[axis].total_cmp(&pb[axis]);
                    by_axis(0)
                        .then_with(|| by_axis(1))
                        .then_with(|| by_axis(2))
                        .then(a.cmp(&b))
                });
                first = alike[0].1;
            }
            for &mut (_, vertex) in alike {
                if place(vertex) != place(first) {
                    first = vertex;
                }
                firsts[vertex as usize] = first;
            }
        }
        Self { firsts }
    }

    /// The three corners of a triangle, each by the first vertex at its place.
    #[must_use]
    pub fn corners(&self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|vertex| self.firsts[vertex as usize])
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.firsts.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    #[test]
    fn vertices_at_one_place_are_one() {
        let mesh = TriangleMesh {
            positions: vec![
                DVec3::X,
                DVec3::ZERO,
                DVec3::X,
                DVec3::new(-0.0, 0.0, -0.0),
                DVec3::new(1.0, 0.0, 1e-300),
            ],
            ..TriangleMesh::default()
        };
        let welded = Welded::new(&mesh);
        assert_eq!(welded.corners([0, 1, 2]), [0, 1, 0]);
        assert_eq!(welded.corners([3, 4, 0]), [1, 4, 0]);
        assert_eq!(welded.vertices(), 5);
    }
}
