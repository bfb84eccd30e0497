//! Growing a kd-tree from the root down.
//!
//! The upper part is grown first, until what is left falls into many subtrees, which are grown in parallel; so are all
//! large cells of one generation. How the work is divided depends on the triangles alone, so the tree is the same for any
//! number of threads.
//!
//! References to triangles that a plane cuts are clipped to both sides, so each knows the box of its part of the
//! triangle. A budget of references keeps hostile scenes finite: every cell that is worth splitting waits in a queue,
//! the ones rays meet most often and with most to test first, and what the budget does not reach becomes a leaf.

use super::clip::Clipper;
use super::events::{self, Distributor, Events, Fate, Side};
use super::split::{Plane, best_plane, leaf_cost};
use super::{KdParameters, LANES, MAX_DEPTH, MAX_REFERENCES};
use crate::accel::half_area;
use crate::control::{CancelToken, Progress};
use crate::geometry::Triangle;
use crate::math::Bounds;
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

/// Grows the tree over `triangles` inside `bounds`; `None` when cancelled. `progress` advances by their number altogether.
pub(super) fn grow(
    triangles: &[Triangle],
    bounds: Bounds,
    parameters: &KdParameters,
    cancel: &CancelToken,
    progress: &Progress,
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

    let events = if job.may_split(references.len(), 0) {
        events::sorted(&references, cancel)
    } else {
        Events::default()
    };
    let root = Cell {
        references,
        events,
        bounds,
        depth: 0,
        halvings: 0,
    };
    let mut top = Growth::new(&job, root, budget);
    // Every generation handles all triangles, and there are as many as doublings lead from one to all of them.
    let count = triangles.len() as u64;
    let generation = count / u64::from(count.max(2).ilog2());
    let mut left = count;
    while top.waiting.len() < SUBTREES && top.waiting.iter().any(Waiting::is_large) {
        top.split_large()?;
        let done = generation.min(left / 2);
        progress.advance(done);
        left -= done;
    }

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
        let mut subtree = Growth::new(&job, cell, count + share);
        subtree.split_all()?;
        let done = left * count as u64 / waiting_references as u64;
        progress.advance(done);
        Some((subtree.nodes, done))
    });
    let (subtrees, done): (Vec<Vec<Node>>, Vec<u64>) =
        grown.collect::<Option<Vec<_>>>()?.into_iter().unzip();
    // What was rounded off, and all where there are no subtrees.
    progress.advance(left - done.iter().sum::<u64>());
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
    /// By ascending triangle.
    references: Vec<Reference>,
    /// Theirs; none if the cell will not be split.
    events: Events,
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

impl Waiting {
    /// Whether the cell is to be divided among threads.
    fn is_large(&self) -> bool {
        self.cell.references.len() > SUBTREE_REFERENCES
    }
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
struct Growth<'a> {
    job: &'a Job<'a>,
    nodes: Vec<Node>,
    waiting: BinaryHeap<Waiting>,
    /// References in leaves and waiting cells together.
    references: usize,
    budget: usize,
}

impl<'a> Growth<'a> {
    fn new(job: &'a Job<'a>, root: Cell, budget: usize) -> Self {
        let mut growth = Self {
            job,
            nodes: vec![Node::Leaf(Vec::new())],
            waiting: BinaryHeap::new(),
            references: root.references.len(),
            budget,
        };
        growth.add(0, root);
        growth
    }

    /// Makes a cell wait, or a leaf of it.
    fn add(&mut self, slot: usize, cell: Cell) {
        let count = cell.references.len();
        if self.job.may_split(count, cell.depth) {
            self.waiting.push(Waiting {
                priority: half_area(&cell.bounds) * count as f64,
                slot,
                cell,
            });
        } else {
            self.nodes[slot] = leaf(&cell);
        }
    }

    /// Splits waiting cells, or makes leaves of them, until there are none. `None` when cancelled.
    fn split_all(&mut self) -> Option<()> {
        let mut distributor = Distributor::default();
        while let Some(Waiting { slot, cell, .. }) = self.waiting.pop() {
            let split = self.job.split(&mut distributor, &cell);
            if self.job.cancel.is_cancelled() {
                return None;
            }
            self.settle(slot, &cell, split);
        }
        Some(())
    }

    /// Splits all large waiting cells once, or makes leaves of them. `None` when cancelled.
    fn split_large(&mut self) -> Option<()> {
        let waiting = std::mem::take(&mut self.waiting).into_sorted_vec();
        let (large, small): (Vec<_>, Vec<_>) = waiting.into_iter().partition(Waiting::is_large);
        self.waiting = small.into();
        let split = |w: &Waiting| self.job.split(&mut Distributor::default(), &w.cell);
        let splits: Vec<_> = large.par_iter().map(split).collect();
        if self.job.cancel.is_cancelled() {
            return None;
        }
        // The most urgent is last.
        for (Waiting { slot, cell, .. }, split) in large.into_iter().zip(splits).rev() {
            self.settle(slot, &cell, split);
        }
        Some(())
    }

    /// Puts a plane in the cell's slot, and makes the two cells it leads to wait, if there is a split and the budget allows it;
    /// a leaf otherwise.
    fn settle(&mut self, slot: usize, cell: &Cell, split: Option<(Plane, [Cell; 2])>) {
        let split = split.filter(|(_, children)| {
            let kept: usize = children.iter().map(|child| child.references.len()).sum();
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
                self.add(children, left);
                self.add(children + 1, right);
                Node::Interior {
                    axis: plane.axis,
                    position: plane.position,
                    children,
                }
            }
            None => leaf(cell),
        };
    }
}

fn leaf(cell: &Cell) -> Node {
    Node::Leaf(cell.references.iter().map(|r| r.triangle).collect())
}

impl Job<'_> {
    /// Whether a cell with so many references at that depth may be worth splitting.
    fn may_split(&self, count: usize, depth: u32) -> bool {
        // One block needs no tree around it.
        let is_whole_scene = depth == 0 && count <= LANES;
        !is_whole_scene
            && leaf_cost(self.parameters, count) > self.parameters.traversal_cost
            && depth < self.max_depth
    }

    /// The plane to split `cell` with and the two cells that result; `None` when a leaf is better, and when cancelled.
    fn split(&self, distributor: &mut Distributor, cell: &Cell) -> Option<(Plane, [Cell; 2])> {
        let count = cell.references.len();
        let unsplit = leaf_cost(self.parameters, count);
        let best = best_plane(self.parameters, &cell.events, count, &cell.bounds)?;
        let may_halve =
            count > self.parameters.halved_above && cell.halvings < self.parameters.halvings;
        let (plane, halvings) = if best.cost < unsplit * (1.0 - self.parameters.min_gain) {
            (best, 0)
        } else if may_halve {
            (Plane::halving(&cell.bounds)?, cell.halvings + 1)
        } else {
            return None;
        };
        let Divided { sides, fates } = self.divide(cell, &plane);
        if self.cancel.is_cancelled() || sides.iter().all(|side| side.references.len() == count) {
            return None;
        }
        let depth = cell.depth + 1;
        let with_events = sides
            .each_ref()
            .map(|side| Some(side).filter(|side| self.may_split(side.references.len(), depth)));
        let [left_events, right_events] = distributor.distribute(&cell.events, &fates, with_events);
        let (mut left_bounds, mut right_bounds) = (cell.bounds, cell.bounds);
        left_bounds.max[plane.axis] = plane.position;
        right_bounds.min[plane.axis] = plane.position;
        let [left, right] = sides;
        let child = |side: Side, events, bounds| Cell {
            references: side.references,
            events,
            bounds,
            depth,
            halvings,
        };
        let children = [
            child(left, left_events, left_bounds),
            child(right, right_events, right_bounds),
        ];
        Some((plane, children))
    }

    /// The references on the left and on the right of `plane`. Not meaningful when cancelled.
    fn divide(&self, cell: &Cell, plane: &Plane) -> Divided {
        let parts = cell.references.par_chunks(CHUNK).map(|chunk| {
            if self.cancel.is_cancelled() {
                Divided::default()
            } else {
                self.divide_chunk(chunk, plane)
            }
        });
        parts.reduce(Divided::default, Divided::followed_by)
    }

    fn divide_chunk(&self, references: &[Reference], plane: &Plane) -> Divided {
        let mut clipper = Clipper::default();
        let mut divided = Divided::default();
        for reference in references {
            let start = reference.bounds.min[plane.axis];
            let end = reference.bounds.max[plane.axis];
            let in_plane = start >= plane.position && end <= plane.position;
            let is_left = if in_plane {
                plane.planar_goes_left
            } else {
                end <= plane.position
            };
            let is_right = !is_left && (in_plane || start >= plane.position);
            let fate = if is_left || is_right {
                let side = &mut divided.sides[usize::from(is_right)].references;
                side.push(*reference);
                Fate::whole(is_right, number(side.len() - 1))
            } else {
                let triangle = &self.triangles[reference.triangle as usize];
                let (mut left, mut right) = (reference.bounds, reference.bounds);
                left.max[plane.axis] = plane.position;
                right.min[plane.axis] = plane.position;
                for (side, region) in divided.sides.iter_mut().zip([left, right]) {
                    let bounds = clipper.bounds(triangle, &region);
                    if !bounds.is_empty() {
                        side.cut.push(number(side.references.len()));
                        side.references.push(Reference {
                            bounds,
                            ..*reference
                        });
                    }
                }
                Fate::CUT
            };
            divided.fates.push(fate);
        }
        divided
    }
}

/// The references of a cell on both sides of a plane, and how they came there.
#[derive(Default)]
struct Divided {
    sides: [Side; 2],
    fates: Vec<Fate>,
}

impl Divided {
    /// Both parts of a cell together.
    fn followed_by(mut self, next: Self) -> Self {
        if self.fates.is_empty() {
            return next;
        }
        let before = self.sides.each_ref().map(|s| number(s.references.len()));
        let fates = next.fates.into_iter();
        self.fates.extend(fates.map(|fate| fate.behind(before)));
        for (i, (side, next)) in self.sides.iter_mut().zip(next.sides).enumerate() {
            side.references.extend(next.references);
            side.cut.extend(next.cut.into_iter().map(|c| c + before[i]));
        }
        self
    }
}

/// An index of a reference in a cell.
fn number(index: usize) -> u32 {
    u32::try_from(index).expect("a cell has at most 2^29 references")
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes;
    use crate::math::{DVec3, Vec3};

    /// References that were not looked at any more have no place on either side.
    #[test]
    fn cancelling_during_a_split_leaves_no_half_divided_cell() {
        let mesh = shapes::soup(100, 0.2, 1);
        let corners = (0..100).map(|i| mesh.corners(i).map(DVec3::as_vec3));
        let triangles: Vec<_> = corners.map(|corners| Triangle { corners }).collect();
        let references: Vec<_> = (0..)
            .zip(&triangles)
            .map(|(triangle, t)| Reference {
                bounds: t.bounds(),
                triangle,
            })
            .collect();
        let cancel = CancelToken::new();
        let job = Job {
            triangles: &triangles,
            parameters: &KdParameters::default(),
            max_depth: 20,
            cancel: &cancel,
        };
        let cell = Cell {
            events: events::sorted(&references, &cancel),
            references,
            bounds: Bounds::of_points([Vec3::splat(-1.2), Vec3::splat(1.2)]),
            depth: 0,
            halvings: 0,
        };
        let mut distributor = Distributor::default();
        assert!(job.split(&mut distributor, &cell).is_some());
        cancel.cancel();
        assert!(job.split(&mut distributor, &cell).is_none());
    }
}
