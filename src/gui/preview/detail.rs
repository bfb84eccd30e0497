//! Triangles in fewer and fewer pieces: what is drawn of a mesh where all of it would take too long.
//!
//! Space is divided into cells. All corners in a cell become one, in the middle of them, and what then is no triangle any more is left
//! out (vertex clustering, Rossignac and Borrel 1993). Each level has cells twice as wide as the one before, and about a quarter of its
//! triangles; nothing moves further than the diagonal of a cell. Hair and leaves would vanish so, as each of their triangles lies in a
//! cell: where half of the area would be gone, a quarter of the triangles stay instead, each twice as wide (after Cook et al. 2007,
//! "Stochastic simplification of aggregate detail").
//!
//! Many triangles are divided into blocks besides, which are drawn or left out, near or far, one by one.

use std::collections::HashMap;
use std::collections::HashSet;
use std::sync::Arc;

use foldhash::fast::FixedState;
use rayon::prelude::*;

use super::ball::Ball;
use super::geometry::Vertex;
use crate::control::CancelToken;
use crate::math::{Bounds, DVec3, Vec3};

/// About how many triangles are in a block.
const BLOCK: usize = 1 << 14;
/// Fewer triangles are not made fewer.
const LEAST_TRIANGLES: usize = 8;
/// The largest share of triangles that makes a coarser level worth its memory.
const MOST_KEPT: f64 = 0.6;
/// The share of the area that must stay where corners become one.
const LEAST_AREA: f64 = 0.5;
/// Cells along the whole from which on a shape is lost anyway, and so is area.
const MOST_LOST_CELLS: f64 = 16.0;
/// Cells along an axis that are told apart.
const MOST_CELLS: f32 = 2_000_000.0;

/// Triangles, corner after corner, in blocks.
#[derive(Clone, Debug, Default)]
pub struct Level {
    /// How wide its cells are, in the units of its corners: what is smaller is left out. 0 where nothing is.
    pub cell: f64,
    /// Three corners per triangle.
    pub vertices: Vec<Vertex>,
    /// Where each block begins among the triangles, and where the last one ends.
    pub starts: Vec<usize>,
    /// For each triangle, which one of the mesh it was made of; `None` where they are those of the mesh, in their order.
    pub sources: Option<Arc<[u32]>>,
}

impl Level {
    /// Triangles as they are, in one block.
    #[must_use]
    pub fn whole(vertices: Vec<Vertex>) -> Self {
        Self {
            cell: 0.0,
            starts: vec![0, vertices.len() / 3],
            vertices,
            sources: None,
        }
    }

    fn triangles(&self) -> impl Iterator<Item = &[Vertex]> {
        self.vertices.chunks_exact(3)
    }

    fn corners(&self, triangle: usize) -> &[Vertex] {
        &self.vertices[triangle * 3..triangle * 3 + 3]
    }

    fn source(&self, triangle: usize) -> u32 {
        match &self.sources {
            Some(sources) => sources[triangle],
            None => u32::try_from(triangle).expect("triangles are numbered by 32 bits"),
        }
    }

    /// The box around the triangles from number `start` to `end`.
    fn bounds(&self, start: usize, end: usize) -> Bounds {
        let corners = &self.vertices[start * 3..end * 3];
        Bounds::of_points(corners.iter().map(Vertex::position))
    }

    /// Balls around its blocks.
    #[must_use]
    pub fn balls(&self) -> Vec<Ball> {
        let ends = self.starts.windows(2);
        ends.map(|ends| Ball::around(&self.bounds(ends[0], ends[1])))
            .collect()
    }
}

/// `whole` in blocks, and coarser and coarser. `None` when cancelled.
#[must_use]
pub fn levels_of(whole: Level, cancel: &CancelToken) -> Option<Vec<Level>> {
    let count = whole.vertices.len() / 3;
    let bounds = whole.bounds(0, count);
    let whole = if count > 2 * BLOCK {
        in_blocks(&whole, &bounds)
    } else {
        whole
    };
    let area: f64 = whole.triangles().map(area).sum();
    let size = f64::from(bounds.size().max_element());
    // As wide as two edges of a triangle of the mean area.
    let mut cell = 3.0 * (area / count as f64).sqrt();
    cell = cell.max(size / f64::from(MOST_CELLS));
    let mut levels = vec![whole];
    // NaN where there is no area.
    while cell < size {
        if cancel.is_cancelled() {
            return None;
        }
        let finer = &levels[levels.len() - 1];
        let fine_count = finer.vertices.len() / 3;
        if fine_count <= LEAST_TRIANGLES {
            break;
        }
        let mut coarse = joined(finer, bounds.min, cell);
        let has_shape = cell * MOST_LOST_CELLS < size;
        if has_shape && coarse.triangles().map(self::area).sum::<f64>() < LEAST_AREA * area {
            coarse = thinned(finer, cell);
        }
        let coarse_count = coarse.vertices.len() / 3;
        if (coarse_count as f64) < MOST_KEPT * fine_count as f64 && coarse_count > 0 {
            levels.push(coarse);
        }
        cell *= 2.0;
    }
    Some(levels)
}

/// The same triangles in blocks of neighbours.
fn in_blocks(whole: &Level, bounds: &Bounds) -> Level {
    let count = whole.vertices.len() / 3;
    // A surface passes some two cells for each square of the grid's side.
    let along = (count as f64 / BLOCK as f64 / 2.0).sqrt().ceil().min(64.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 64"
    )]
    let cells = along as usize;
    let width = (f64::from(bounds.size().max_element()) / along).max(f64::MIN_POSITIVE);
    let cell_of = |triangle: &[Vertex]| {
        let corner = (triangle[0].position() - bounds.min).as_dvec3() / width;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of a cell"
        )]
        let [x, y, z] = corner.to_array().map(|x| (x as usize).min(cells - 1));
        (z * cells + y) * cells + x
    };
    let cell_of_triangle: Vec<usize> = whole.vertices.par_chunks_exact(3).map(cell_of).collect();
    let mut ends = vec![0; cells * cells * cells + 1];
    for &cell in &cell_of_triangle {
        ends[cell + 1] += 1;
    }
    for cell in 1..ends.len() {
        ends[cell] += ends[cell - 1];
    }
    let mut next = ends.clone();
    let mut order = vec![0; count];
    for (triangle, &cell) in (0..).zip(&cell_of_triangle) {
        order[next[cell]] = triangle;
        next[cell] += 1;
    }
    let vertices = order.par_iter().flat_map_iter(|&triangle: &u32| {
        let first = triangle as usize * 3;
        whole.vertices[first..first + 3].iter().copied()
    });
    let vertices = vertices.collect();
    ends.dedup();
    Level {
        cell: 0.0,
        vertices,
        starts: ends,
        sources: Some(order.into()),
    }
}

/// The corners that became one.
#[derive(Clone, Copy, Default)]
struct Cluster {
    position: DVec3,
    normal: Vec3,
    count: u32,
}

/// `finer` with one corner for each cell of a grid from `origin` on.
fn joined(finer: &Level, origin: Vec3, cell: f64) -> Level {
    let mut numbers = HashMap::with_hasher(FixedState::default());
    let mut clusters: Vec<Cluster> = Vec::new();
    let cluster_of = |vertex: &Vertex| {
        let place = (vertex.position() - origin).as_dvec3() / cell;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of a cell"
        )]
        let key = place.to_array().map(|x| x as u32);
        let number = *numbers.entry(key).or_insert_with(|| {
            clusters.push(Cluster::default());
            clusters.len() - 1
        });
        let cluster = &mut clusters[number];
        cluster.position += vertex.position().as_dvec3();
        cluster.normal += vertex.normal();
        cluster.count += 1;
        u32::try_from(number).expect("no more cells than corners")
    };
    let cells: Vec<u32> = finer.vertices.iter().map(cluster_of).collect();
    let mut known = HashSet::with_hasher(FixedState::default());
    made_of(finer, cell, |triangle, _| {
        let mut corners = [0, 1, 2].map(|i| cells[triangle * 3 + i]);
        let [a, b, c] = corners;
        corners.sort_unstable();
        let is_left = a != b && b != c && c != a && known.insert(corners);
        let corner = |(i, cluster): (usize, u32)| {
            clusters[cluster as usize].vertex(finer.corners(triangle)[i].normal())
        };
        is_left.then(|| [(0, a), (1, b), (2, c)].map(corner))
    })
}

/// What `coarser` makes of the triangles of `finer`, told of each its number and that in its block; the cell is that of the result.
fn made_of(
    finer: &Level,
    cell: f64,
    mut coarser: impl FnMut(usize, usize) -> Option<[Vertex; 3]>,
) -> Level {
    let mut level = Level {
        cell,
        starts: vec![0],
        ..Level::default()
    };
    let mut sources = Vec::new();
    for block in finer.starts.windows(2) {
        for (in_block, triangle) in (block[0]..block[1]).enumerate() {
            if let Some(corners) = coarser(triangle, in_block) {
                level.vertices.extend(corners);
                sources.push(finer.source(triangle));
            }
        }
        level.starts.push(sources.len());
    }
    level.sources = Some(sources.into());
    level
}

impl Cluster {
    /// The corner in the middle, of a surface that had `normal` there.
    fn vertex(&self, normal: Vec3) -> Vertex {
        let position = (self.position / f64::from(self.count)).as_vec3();
        // The two sides of something thin have none in common.
        let mean = self.normal;
        let is_common = mean.dot(normal) > 0.0;
        Vertex::new(position, if is_common { mean } else { normal })
    }
}

/// Every fourth triangle of `finer`, twice as wide.
fn thinned(finer: &Level, cell: f64) -> Level {
    made_of(finer, cell, |triangle, in_block| {
        let corners = finer.corners(triangle);
        let middle = corners.iter().map(Vertex::position).sum::<Vec3>() / 3.0;
        let wider = |vertex: &Vertex| vertex.at(vertex.position() * 2.0 - middle);
        in_block
            .is_multiple_of(4)
            .then(|| [0, 1, 2].map(|i| wider(&corners[i])))
    })
}

fn area(triangle: &[Vertex]) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|i| triangle[i].position().as_dvec3());
    (b - a).cross(c - a).length() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, shapes};

    /// Places on a ball of radius 1 have 32 bits: some of their last digits.
    const ROUNDING: f64 = 1e-6;

    fn whole(mesh: &TriangleMesh) -> Level {
        let corners = |triangle: &[u32; 3]| {
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize].as_vec3());
            corners.map(|corner| Vertex::new(corner, corner))
        };
        Level::whole(mesh.triangles.iter().flat_map(corners).collect())
    }

    fn levels(whole: Level) -> Vec<Level> {
        levels_of(whole, &CancelToken::new()).expect("nobody cancels")
    }

    fn total_area(level: &Level) -> f64 {
        level.triangles().map(area).sum()
    }

    #[test]
    fn levels_of_a_ball_stay_near_it_and_say_what_they_were_made_of() {
        let mesh = shapes::icosphere(6);
        let count = mesh.triangles.len();
        assert!(count > 2 * BLOCK, "{count}: blocks are made");
        let levels = levels(whole(&mesh));
        assert_eq!(levels[0].vertices.len(), 3 * count);
        assert!(levels[0].starts.len() > 5);
        assert!(levels.last().unwrap().vertices.len() <= 3 * 2 * LEAST_TRIANGLES);
        for pair in levels.windows(2) {
            let [finer, coarser] = pair else { panic!() };
            assert!((coarser.vertices.len() as f64) < MOST_KEPT * finer.vertices.len() as f64);
            assert!(coarser.cell >= 2.0 * finer.cell);
        }
        for level in &levels {
            assert_eq!(level.starts.len(), levels[0].starts.len());
            let reach = level.cell * 3.0_f64.sqrt();
            let sources = level.sources.as_ref().unwrap();
            for (triangle, &source) in level.triangles().zip(&**sources) {
                let fine = mesh.corners(source as usize);
                for (corner, fine) in triangle.iter().zip(fine) {
                    let moved = corner.position().as_dvec3().distance(fine);
                    // From each level to the next, and twice the first cell is more than all before it.
                    assert!(
                        moved <= 2.0 * reach + ROUNDING,
                        "{moved} with {}",
                        level.cell
                    );
                }
            }
            if level.cell < 0.2 {
                let area = total_area(level) / (4.0 * std::f64::consts::PI);
                assert!((0.9..1.01).contains(&area), "{area} with {}", level.cell);
            }
        }
    }

    #[test]
    fn every_triangle_is_in_one_block() {
        let mesh = shapes::icosphere(6);
        let levels = levels(whole(&mesh));
        let mut sources = levels[0].sources.as_ref().unwrap().to_vec();
        sources.sort_unstable();
        assert!(sources.into_iter().eq(0..20 * 4096));
        for (ball, ends) in levels[0].balls().iter().zip(levels[0].starts.windows(2)) {
            let corners = &levels[0].vertices[ends[0] * 3..ends[1] * 3];
            let is_inside = |corner: &Vertex| {
                corner.position().as_dvec3().distance(ball.center) <= ball.radius + ROUNDING
            };
            assert!(corners.iter().all(is_inside));
            // Half of the whole is in a larger one.
            assert!(ball.radius < 0.9, "{}", ball.radius);
        }
    }

    #[test]
    fn leaves_stay_a_crown() {
        // Tiny triangles far from each other.
        let mesh = shapes::icosphere(5);
        let mut vertices = Vec::new();
        for corner in &mesh.positions {
            let corner = corner.as_vec3();
            let leaf = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| corner + axis * 1e-3);
            vertices.extend(leaf.map(|place| Vertex::new(place, Vec3::Z)));
        }
        let levels = levels(Level::whole(vertices));
        let area = total_area(&levels[0]);
        let mut few = levels.iter().filter(|level| level.cell * 20.0 < 2.0);
        let few = few.next_back().unwrap();
        assert!(few.vertices.len() * 10 < levels[0].vertices.len());
        assert!((0.5..2.0).contains(&(total_area(few) / area)));
    }

    #[test]
    fn what_has_no_area_stays_as_it_is() {
        let point = Vertex::new(Vec3::ONE, Vec3::Z);
        for vertices in [vec![], vec![point; 30], vec![point; 3 * 40_000]] {
            let count = vertices.len();
            let levels = levels(Level::whole(vertices));
            assert_eq!(levels[0].vertices.len(), count);
            assert_eq!(levels[0].balls().len(), levels[0].starts.len() - 1);
        }
    }
}
