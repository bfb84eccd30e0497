//! The kd-tree: cells split by axis-aligned planes chosen by the surface area heuristic.
//!
//! Every triangle is referred to by the leaves whose cells its part inside really touches, so that a ray that walks the
//! cells along its way cannot miss a hit: distances to planes are compared with a margin for their rounding, and
//! everything else about the tree is exact. See [`KdTree::validate`].

mod build;
mod clip;
mod events;
mod node;
mod quality;
mod split;
mod validate;
mod walk;

use super::Hit;
use super::block::TriangleBlock;
use super::boxes::{self, Cell, Division, LevelBoxes};
use super::query::{AnyHit, NearestHit};
use super::simd::{self, LANES};
use crate::control::{CancelToken, Progress};
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray};
use node::{Node, NodeKind, packed, places};

/// No tree has more planes above a leaf, so that the stack of a walk has a fixed size.
const MAX_DEPTH: u32 = 48;

/// Blocks and nodes are counted in 30 bits; there are at most twice as many nodes as references.
const MAX_REFERENCES: usize = 1 << 29;

/// What the builder assumes and how far it may go. Costs are relative to each other.
///
/// The default costs gave the fastest rays (camera, bounce and shadow, on smooth meshes and soups of 28,000 to 328,000
/// triangles) among `intersection_cost` 0.5 to 3, `empty_bonus` 0.05 to 0.8 and `min_gain` 0 to 0.1. The optimum is flat;
/// they are at the end of it that needs least memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdParameters {
    /// Cost of deciding at one plane which way to go.
    pub traversal_cost: f64,
    /// Cost of testing one block of up to eight triangles.
    pub intersection_cost: f64,
    /// Share by which the children of a split count as cheaper when one of them is empty, as cutting off empty space early
    /// pays more than the heuristic knows. Source: Hurley, Kapustin, Reshetov, Soupikov, Fast Ray Tracing for Modern
    /// General Purpose CPU, 2002.
    pub empty_bonus: f64,
    /// Depth limit; by default `8 + 1.3 log2 n`. Never more than 48, which the default stays
    /// below for any number of triangles allowed.
    /// Source: Pharr et al., Physically Based Rendering (3rd ed.), 4.4, after Havran.
    pub max_depth: Option<u32>,
    /// Share of the cost of a leaf that a split must save.
    pub min_gain: f64,
    /// Cells with more references than this are not given up at once when no plane saves enough: they are halved across
    /// their longest side. Where many triangles meet, the first planes rarely pay, only the cells they lead to.
    pub halved_above: usize,
    /// Halvings allowed in a row; three give each axis its turn.
    pub halvings: u32,
    /// References allowed per triangle. Ordinary scenes need one to two; it stops scenes where many triangles overlap: with more
    /// references, their rays would be little faster and their trees take longer to build in proportion.
    pub reference_budget: f64,
}

impl Default for KdParameters {
    fn default() -> Self {
        Self {
            traversal_cost: 1.0,
            intersection_cost: 0.6,
            empty_bonus: 0.15,
            max_depth: None,
            min_gain: 0.05,
            halved_above: 64,
            halvings: 3,
            reference_budget: 5.5,
        }
    }
}

/// What a tree came out like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KdStatistics {
    /// Interior nodes and leaves together.
    pub nodes: usize,
    /// Leaves, empty ones included.
    pub leaves: usize,
    /// Leaves without a triangle.
    pub empty_leaves: usize,
    /// Triangles in leaves, counted once per leaf.
    pub references: usize,
    /// Blocks of up to eight triangles in leaves.
    pub blocks: usize,
    /// Planes above the deepest leaf.
    pub max_depth: u32,
    /// Expected cost of a random ray through the scene's box, in the unit of [`KdParameters`].
    pub sah_cost: f64,
}

/// The surface area heuristic kd-tree.
#[derive(Clone, Debug)]
pub struct KdTree {
    /// Where each triangle is for the first time: eight times its block plus its lane. There is no other list of them.
    places: Vec<u32>,
    bounds: Bounds,
    /// The root is the first.
    nodes: Vec<Node>,
    /// Those of the leaves, then those of triangles that are in none, as they are not finite.
    blocks: Vec<TriangleBlock>,
    parameters: KdParameters,
}

impl KdTree {
    /// Builds the tree; `None` when cancelled. The result depends on the arguments alone, not on the number of threads.
    ///
    /// Takes time in proportion to `n log n` and a bounded number of references for any finite triangles.
    ///
    /// # Panics
    /// When there are more than 2²⁹ triangles.
    #[must_use]
    pub fn build(
        triangles: &[Triangle],
        parameters: &KdParameters,
        cancel: &CancelToken,
    ) -> Option<Self> {
        Self::build_watched(triangles, parameters, cancel, &Progress::new())
    }

    /// [`Self::build`]; `progress` advances by the number of triangles altogether.
    ///
    /// # Panics
    /// When there are more than 2²⁹ triangles.
    #[must_use]
    pub fn build_watched(
        triangles: &[Triangle],
        parameters: &KdParameters,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        assert!(
            triangles.len() <= MAX_REFERENCES,
            "{} triangles are more than 2^29",
            triangles.len()
        );
        let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
        let pieces = build::grow(triangles, bounds, parameters, cancel, progress)?;
        let (nodes, mut blocks) = packed(&pieces, triangles, cancel)?;
        Some(Self {
            places: places(&mut blocks, triangles),
            bounds,
            nodes,
            blocks,
            parameters: *parameters,
        })
    }

    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        simd::answer(&NearestHit {
            tree: self,
            ray,
            t_max,
        })
    }

    /// [`Self::intersect`] by a walk that does not pay for rounding, to see that its mistakes are noticed.
    #[cfg(test)]
    #[must_use]
    pub fn intersect_without_margin(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        simd::answer(&NearestHit {
            tree: &walk::WithoutMargin(self),
            ray,
            t_max,
        })
    }

    /// Whether anything is hit with `0 < t < t_max`; stops at the first such hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        simd::answer(&AnyHit {
            tree: self,
            ray,
            t_max,
        })
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.places.len()
    }

    /// The triangle with that position in the order given.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: usize) -> Triangle {
        let place = self.places[id] as usize;
        self.blocks[place / LANES].triangle(place % LANES)
    }

    /// The box around all triangles; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The cells below so many planes, and those that hold triangles and lie above; at most `most`.
    pub(super) fn boxes_at(&self, depth: u32, most: usize) -> LevelBoxes {
        let root = Cell {
            node: 0,
            bounds: self.bounds,
        };
        boxes::gather(root, (depth, most), |cell, parts| {
            match self.nodes[cell.node].kind() {
                NodeKind::Leaf { blocks } if blocks.is_empty() => Division::Empty,
                NodeKind::Leaf { .. } => Division::Whole,
                NodeKind::Interior {
                    axis,
                    position,
                    children,
                } => {
                    let mut halves = [cell.bounds; 2];
                    halves[0].max[axis] = position;
                    halves[1].min[axis] = position;
                    for (node, bounds) in (children..).zip(halves) {
                        parts.push(Cell { node, bounds });
                    }
                    Division::Divided
                }
            }
        })
    }

    /// Memory of nodes, leaves and the triangles' places in them.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.blocks) + size_of_val(&*self.places)
    }
}
