//! Growing a kd-tree from the root down.
//!
//! The upper part is grown first, until what is left falls into many subtrees, which are grown in parallel. How the work
//! is divided depends on the triangles alone, so the tree is the same for any number of threads.
//!
//! References to triangles that a plane cuts are clipped to both sides, so each knows the box of its part of the
//! triangle. A budget of references keeps hostile scenes finite: every cell that is worth splitting waits in a queue,
//! the ones rays meet most often and with most to test first, and what the budget does not reach becomes a leaf.

use super::clip::Clipper;
use super::split::{Plane, Splitter, leaf_cost};
use super::{KdParameters, LANES, MAX_DEPTH, MAX_REFERENCES};
use crate::accel::half_area;
use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::math::{Bounds, Vec3};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// References handled at a time by one thread, and between two looks at the cancel token.
pub(super) const CHUNK: usize = 1 << 14;

/// Cells with fewer references are not divided among threads any further.
const SUBTREE_REFERENCES: usize = 1 << 12;

/// Enough subtrees to balance many threads.
const SUBTREES: usize = 256;

/// The part of a triangle inside a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// A box around that part, within the cell.
    pub bounds: Bounds,
    pub triangle: u32,
}

/// A node of the tree while it grows.
#[derive(Debug)]
pub(super) enum Node {
    /// A plane, and where in the same list its two children stand: side by side.
    Interior {
        axis: usize,
        position: f32,
        children: usize,
    },
    /// Ids in ascending order.
    Leaf(Vec<u32>),
    /// The root of another list of nodes.
    Subtree(usize),
}

/// A tree in pieces: the first list holds the root of all.
#[derive(Debug)]
pub(super) struct Pieces {
    pub nodes: Vec<Vec<Node>>,
}

/// Grows the tree over `triangles` inside `bounds`; `None` when cancelled.
pub(super) fn grow(
    triangles: &[Triangle],
    bounds: Bounds,
    parameters: &KdParameters,
    cancel: &CancelToken,
) -> Option<Pieces> {
    let references: Vec<_> = triangles
        .par_iter()
        .enumerate()
        .map(|(id, triangle)| Reference {
            bounds: triangle.bounds(),
            triangle: u32::try_from(id).expect("there are at most 2^29 triangles"),
        })
        .collect();
    let job = Job {
        triangles,
        parameters,
        max_depth: parameters.depth_limit(references.len()),
        cancel,
    };
    let budget = parameters.most_references(references.len());

    let root = Cell {
        references,
        bounds,
        depth: 0,
        halvings: 0,
    };
    let mut top = Growth::new(root, budget);
    top.split_while(&job, |growth| {
        let is_large = |w: &Waiting| w.cell.references.len() > SUBTREE_REFERENCES;
        growth.waiting.len() < SUBTREES && growth.waiting.iter().any(is_large)
    })?;

    // What is left of the budget goes to the subtrees in proportion to their references.
    let waiting = std::mem::take(&mut top.waiting).into_sorted_vec();
    let waiting_references: usize = waiting.iter().map(|w| w.cell.references.len()).sum();
    let spare = budget.saturating_sub(top.references) as f64;
    let mut tasks = Vec::new();
    for (index, Waiting { slot, cell, .. }) in waiting.into_iter().enumerate() {
        top.nodes[slot] = Node::Subtree(index + 1);
        tasks.push(cell);
    }
    let grown = tasks.into_par_iter().map(|cell| {
        let count = cell.references.len();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of a usize"
        )]
        let share = (spare * (count as f64 / waiting_references as f64)) as usize;
        let mut subtree = Growth::new(cell, count + share);
        subtree.split_while(&job, |_| true)?;
        Some(subtree.nodes)
    });
    let subtrees: Vec<Vec<Node>> = grown.collect::<Option<_>>()?;
    let nodes = std::iter::once(top.nodes).chain(subtrees).collect();
    Some(Pieces { nodes })
}

/// What all cells of a build have in common.
struct Job<'a> {
    triangles: &'a [Triangle],
    parameters: &'a KdParameters,
    max_depth: u32,
    cancel: &'a CancelToken,
}

/// A box of space and what lies in it.
struct Cell {
    references: Vec<Reference>,
    bounds: Bounds,
    depth: u32,
    /// How often in a row it came about by halving.
    halvings: u32,
}

/// A cell that may be split further, and its place in the list of nodes.
struct Waiting {
    priority: f64,
    slot: usize,
    cell: Cell,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority
            .total_cmp(&other.priority)
            .then(other.slot.cmp(&self.slot))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

/// A list of nodes under growth.
struct Growth {
    nodes: Vec<Node>,
    waiting: BinaryHeap<Waiting>,
    /// References in leaves and waiting cells together.
    references: usize,
    budget: usize,
}

impl Growth {
    fn new(root: Cell, budget: usize) -> Self {
        let mut growth = Self {
            nodes: vec![Node::Leaf(Vec::new())],
            waiting: BinaryHeap::new(),
            references: root.references.len(),
            budget,
        };
        growth.enqueue(0, root);
        growth
    }

    fn enqueue(&mut self, slot: usize, cell: Cell) {
        self.waiting.push(Waiting {
            priority: half_area(&cell.bounds) * cell.references.len() as f64,
            slot,
            cell,
        });
    }

    /// Splits waiting cells, or makes leaves of them, as long as there are any and `go_on` holds. `None` when cancelled.
    fn split_while(&mut self, job: &Job, go_on: impl Fn(&Self) -> bool) -> Option<()> {
        let mut splitter = Splitter::new(job.parameters, job.cancel);
        while go_on(self)
            && let Some(Waiting { slot, cell, .. }) = self.waiting.pop()
        {
            let split = job.split(&mut splitter, &cell);
            if job.cancel.is_cancelled() {
                return None;
            }
            let split = split.filter(|(_, children)| {
                let kept = children
                    .iter()
                    .map(|child| child.references.len())
                    .sum::<usize>();
                let references = self.references - cell.references.len() + kept;
                let within_budget = references <= self.budget && self.nodes.len() < 2 * self.budget;
                if within_budget {
                    self.references = references;
                }
                within_budget
            });
            self.nodes[slot] = match split {
                Some((plane, [left, right])) => {
                    let children = self.nodes.len();
                    self.nodes
                        .extend([Node::Leaf(Vec::new()), Node::Leaf(Vec::new())]);
                    self.enqueue(children, left);
                    self.enqueue(children + 1, right);
                    Node::Interior {
                        axis: plane.axis,
                        position: plane.position,
                        children,
                    }
                }
                None => Node::Leaf(cell.references.iter().map(|r| r.triangle).collect()),
            };
        }
        Some(())
    }
}

impl Job<'_> {
    /// The plane to split `cell` with and the two cells that result; `None` when a leaf is better.
    fn split(&self, splitter: &mut Splitter, cell: &Cell) -> Option<(Plane, [Cell; 2])> {
        let count = cell.references.len();
        let unsplit = leaf_cost(self.parameters, count);
        // One block needs no tree around it.
        let is_whole_scene = cell.depth == 0 && count <= LANES;
        if is_whole_scene
            || unsplit <= self.parameters.traversal_cost
            || cell.depth >= self.max_depth
        {
            return None;
        }
        let best = splitter.best_plane(&cell.references, &cell.bounds)?;
        let may_halve =
            count > self.parameters.halved_above && cell.halvings < self.parameters.halvings;
        let (plane, halvings) = if best.cost < unsplit * (1.0 - self.parameters.min_gain) {
            (best, 0)
        } else if may_halve {
            (Plane::halving(&cell.bounds)?, cell.halvings + 1)
        } else {
            return None;
        };
        let children = self.divide(cell, &plane);
        if children.iter().all(|references| references.len() == count) {
            return None;
        }
        let mut side = 0;
        let children = children.map(|references| {
            let mut bounds = cell.bounds;
            let cut = if side == 0 {
                &mut bounds.max
            } else {
                &mut bounds.min
            };
            cut[plane.axis] = plane.position;
            side += 1;
            Cell {
                references,
                bounds,
                depth: cell.depth + 1,
                halvings,
            }
        });
        Some((plane, children))
    }

    /// The references on the left and on the right of `plane`.
    fn divide(&self, cell: &Cell, plane: &Plane) -> [Vec<Reference>; 2] {
        let parts = cell.references.par_chunks(CHUNK).map(|chunk| {
            if self.cancel.is_cancelled() {
                [Vec::new(), Vec::new()]
            } else {
                self.divide_chunk(chunk, plane)
            }
        });
        parts.reduce(
            || [Vec::new(), Vec::new()],
            |[mut left, mut right], [more_left, more_right]| {
                if left.is_empty() && right.is_empty() {
                    return [more_left, more_right];
                }
                left.extend(more_left);
                right.extend(more_right);
                [left, right]
            },
        )
    }

    fn divide_chunk(&self, references: &[Reference], plane: &Plane) -> [Vec<Reference>; 2] {
        let mut clipper = Clipper::default();
        let [mut left, mut right] = [Vec::new(), Vec::new()];
        for reference in references {
            let start = reference.bounds.min[plane.axis];
            let end = reference.bounds.max[plane.axis];
            let in_plane = start >= plane.position && end <= plane.position;
            let side = if in_plane {
                plane.planar_goes_left
            } else {
                end <= plane.position
            };
            if side {
                left.push(*reference);
            } else if in_plane || start >= plane.position {
                right.push(*reference);
            } else {
                let triangle = &self.triangles[reference.triangle as usize];
                let mut clip = |list: &mut Vec<Reference>,
                                mut region: Bounds,
                                cut: fn(&mut Bounds) -> &mut Vec3| {
                    cut(&mut region)[plane.axis] = plane.position;
                    let bounds = clipper.bounds(triangle, &region);
                    if !bounds.is_empty() {
                        list.push(Reference {
                            bounds,
                            ..*reference
                        });
                    }
                };
                clip(&mut left, reference.bounds, |b| &mut b.max);
                clip(&mut right, reference.bounds, |b| &mut b.min);
            }
        }
        [left, right]
    }
}

impl KdParameters {
    /// The deepest a tree over this many triangles may be.
    fn depth_limit(&self, triangles: usize) -> u32 {
        let automatic = || {
            let depth = 8.0 + 1.3 * (triangles.max(1) as f64).log2();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "below 50"
            )]
            let depth = depth.round() as u32;
            depth
        };
        self.max_depth.unwrap_or_else(automatic).min(MAX_DEPTH)
    }

    /// The most references all leaves together may hold.
    fn most_references(&self, triangles: usize) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates"
        )]
        let budget = (self.reference_budget * triangles as f64) as usize;
        budget.min(MAX_REFERENCES).max(triangles)
    }
}
