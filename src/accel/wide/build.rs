//! Growing a binary tree over triangles, and choosing how it folds into wide nodes.
//!
//! Large sets are divided in parallel; small ones grow into subtrees of one thread each. How the work is divided depends on
//! the triangles alone, so the tree is the same for any number of threads.
//!
//! A set that is divided by a plane gains references. How many there may be is limited from the start, and what is left of that is shared
//! by both parts in proportion to their triangles.

use super::forest::{Binary, Forest, ForestCosts, Link, Slot, Subtree, cheapest_forests};
use super::item::{Extent, Item};
use super::node::WIDTH;
use super::split::{CHUNK, Divided, divide, halved};
use super::sweep::{self, Sorted};
use super::{BuildQuality, LARGEST_LEAF, number, spatial};
use crate::accel::half_area;
use crate::accel::simd::LANES;
use crate::control::{CancelToken, Progress};
use crate::geometry::Triangle;
use std::ops::Range;

/// Cost, in the surface area heuristic, of testing the boxes of one node.
pub(super) const NODE_COST: f64 = 1.0;
/// The same of testing one block of up to eight triangles.
pub(super) const BLOCK_COST: f64 = 0.6;

/// From this depth on sets are halved, so that no tree is much deeper.
const HALVED_FROM: u32 = 40;

/// Sets of this many items fit into one block and are not divided.
const SMALLEST: usize = LANES;

/// Sets with fewer items grow on one thread.
const PARALLEL_FROM: usize = 1 << 12;

/// What all sets of a build have in common.
pub(super) struct Job<'a> {
    pub triangles: &'a [Triangle],
    pub quality: BuildQuality,
    pub cancel: &'a CancelToken,
    /// Counts the triangles whose part of the tree is grown.
    pub progress: &'a Progress,
}

/// Grows the tree over the items, which lie in `extent`; cutting adds at most `most_added`. Not meaningful when cancelled.
pub(super) fn grow(job: &Job, items: Vec<Item>, extent: Extent, most_added: usize) -> Forest {
    let set = Set {
        start: 0,
        extent,
        depth: 0,
        spare: most_added,
        triangles: items.len(),
    };
    let (grown, _) = grow_large(job, items, &set);
    let mut pieces = vec![Subtree::default()];
    let root = flatten(grown, &mut pieces);
    Forest { pieces, root }
}

/// Items to grow a tree over: all from `start` on.
#[derive(Clone, Copy)]
struct Set {
    start: usize,
    extent: Extent,
    depth: u32,
    /// How many items cutting may add.
    spare: usize,
    /// How many triangles it counts for in the progress.
    triangles: usize,
}

impl Set {
    fn divide(&self, job: &Job, items: &mut Vec<Item>) -> Divided {
        if self.depth >= HALVED_FROM {
            halved(job, &mut items[self.start..], self.start, &self.extent)
        } else {
            divide(job, items, self.start, &self.extent, self.spare)
        }
    }

    /// Both parts, in the order of the items.
    fn parts(&self, divided: &Divided, end: usize) -> [Self; 2] {
        let (count, left) = (end - self.start, divided.middle - self.start);
        // Neither has more than 2²⁹ or 2³⁰.
        let shares = |whole: usize| {
            let of_left = whole * left / count;
            [of_left, whole - of_left]
        };
        let spare = shares(self.spare - divided.added);
        let triangles = shares(self.triangles);
        [0, 1].map(|side| Self {
            start: [self.start, divided.middle][side],
            extent: divided.sides[side],
            depth: self.depth + 1,
            spare: spare[side],
            triangles: triangles[side],
        })
    }
}

/// A set's expected cost as one leaf.
fn leaf_cost(area: f64, count: usize) -> f64 {
    if count <= LARGEST_LEAF {
        area * BLOCK_COST * count.div_ceil(LANES) as f64
    } else {
        f64::INFINITY
    }
}

/// A tree that was grown.
enum Grown {
    Fork(Binary, Box<[Grown; 2]>),
    Subtree(Subtree),
}

fn grow_large(job: &Job, mut items: Vec<Item>, set: &Set) -> (Grown, ForestCosts) {
    let count = items.len();
    if count < PARALLEL_FROM || job.cancel.is_cancelled() {
        let mut growing = Growing {
            job,
            items,
            subtree: Subtree::default(),
        };
        let costs = growing.grow(set);
        job.progress.advance(set.triangles as u64);
        return (Grown::Subtree(growing.subtree), costs);
    }
    let divided = set.divide(job, &mut items);
    let [left, right] = set.parts(&divided, items.len());
    let right_items = taken_off(&mut items, divided.middle, job.cancel);
    let right = Set { start: 0, ..right };
    let ((left, left_costs), (right, right_costs)) = rayon::join(
        || grow_large(job, items, &left),
        || grow_large(job, right_items, &right),
    );
    let bounds = set.extent.bounds();
    let area = half_area(&bounds);
    let children = [left_costs, right_costs];
    let (costs, choices) = cheapest_forests(leaf_cost(area, count), area * NODE_COST, &children);
    let fork = Binary {
        bounds,
        first: 0,
        count: number(count),
        second: 0,
        choices,
    };
    (Grown::Fork(fork, Box::new([left, right])), costs)
}

/// The items from `middle` on, taken off the others; not all of them when cancelled.
fn taken_off(items: &mut Vec<Item>, middle: usize, cancel: &CancelToken) -> Vec<Item> {
    let mut rest = Vec::with_capacity(items.len() - middle);
    let chunks = items[middle..].chunks(CHUNK);
    for chunk in chunks.take_while(|_| !cancel.is_cancelled()) {
        rest.extend_from_slice(chunk);
    }
    items.truncate(middle);
    items.shrink_to_fit();
    rest
}

/// Adds a tree to the pieces, of which the first is the top.
fn flatten(grown: Grown, pieces: &mut Vec<Subtree>) -> Slot {
    match grown {
        Grown::Subtree(subtree) => {
            pieces.push(subtree);
            Slot {
                piece: number(pieces.len() - 1),
                index: 0,
            }
        }
        Grown::Fork(fork, children) => {
            let index = pieces[0].nodes.len();
            pieces[0].nodes.push(fork);
            let [first, second] = children.map(|child| Link::of(flatten(child, pieces)));
            pieces[0].nodes[index].first = first;
            pieces[0].nodes[index].second = second;
            Slot {
                piece: 0,
                index: number(index),
            }
        }
    }
}

/// A subtree that one thread grows.
struct Growing<'a> {
    job: &'a Job<'a>,
    /// The sets that wait, and the one being worked on last.
    items: Vec<Item>,
    subtree: Subtree,
}

impl Growing<'_> {
    /// Grows a tree over the set, which is taken from the items.
    fn grow(&mut self, set: &Set) -> ForestCosts {
        let count = self.items.len() - set.start;
        if count <= SMALLEST || self.job.cancel.is_cancelled() {
            let taken = self.items.drain(set.start..);
            self.subtree.ids.extend(taken.map(|item| item.triangle()));
            return self.leaf(set, count);
        }
        if count <= sweep::LIMIT && set.depth < HALVED_FROM {
            let mut sorted = Sorted::new(&self.items[set.start..]);
            let costs = self.grow_sorted(set, &mut sorted, 0..count);
            self.items.truncate(set.start);
            return costs;
        }
        let divided = set.divide(self.job, &mut self.items);
        self.grow_parts(set, count, &divided)
    }

    /// Grows a tree over a set of `count` items that was divided.
    fn grow_parts(&mut self, set: &Set, count: usize, divided: &Divided) -> ForestCosts {
        let [left, right] = set.parts(divided, self.items.len());
        self.fork(set, count, |growing| {
            // The last one first, as it is taken off the end.
            let of_right = growing.grow(&right);
            let second = growing.subtree.nodes.len();
            ([of_right, growing.grow(&left)], second)
        })
    }

    /// Grows a tree over those of the set's items that `sorted` has in `range`.
    fn grow_sorted(&mut self, set: &Set, sorted: &mut Sorted, range: Range<usize>) -> ForestCosts {
        let count = range.len();
        let Set { start, .. } = *set;
        if count <= SMALLEST {
            let numbers = sorted.numbers(range).iter();
            let items = numbers.map(|&number| &self.items[start + usize::from(number)]);
            self.subtree.ids.extend(items.map(Item::triangle));
            return self.leaf(set, count);
        }
        let axes = self.job.quality.axes(set.extent.bounds().size());
        let sweep = sorted.cheapest(&self.items[start..], range.clone(), axes);
        if set.spare > 0
            && count > LARGEST_LEAF
            && sweep.split.overlaps(
                &set.extent,
                sorted
                    .numbers(range.clone())
                    .iter()
                    .map(|&n| &self.items[start + usize::from(n)]),
            )
        {
            let first = self.items.len();
            let apart = Set {
                start: first,
                ..*set
            };
            let numbers = sorted.numbers(range.clone()).iter();
            let numbers = numbers.map(|&number| start + usize::from(number));
            numbers.for_each(|index| self.items.push(self.items[index]));
            let objects = sweep.split.cost;
            if let Some(divided) = self.divide_by_plane(&apart, objects) {
                return self.grow_parts(&apart, count, &divided);
            }
            self.items.truncate(first);
        }
        sorted.divide(range.clone(), &sweep);
        let divided = Divided {
            middle: start + sweep.middle,
            sides: sweep.split.sides,
            added: 0,
        };
        let parts = set
            .parts(&divided, start + count)
            .map(|part| Set { start, ..part });
        let middle = range.start + sweep.middle;
        self.fork(set, count, |growing| {
            let first = growing.grow_sorted(&parts[0], sorted, range.start..middle);
            let second = growing.subtree.nodes.len();
            let costs = growing.grow_sorted(&parts[1], sorted, middle..range.end);
            ([first, costs], second)
        })
    }

    fn divide_by_plane(&mut self, set: &Set, objects: f32) -> Option<Divided> {
        let Self { job, items, .. } = self;
        let Set { start, spare, .. } = *set;
        let plane = spatial::cheapest(job, &items[start..], &set.extent, spare, objects)?;
        plane.divide(job, items, start, spare)
    }

    /// A set whose ids were just added, without children.
    fn leaf(&mut self, set: &Set, count: usize) -> ForestCosts {
        let bounds = set.extent.bounds();
        self.subtree.nodes.push(Binary {
            bounds,
            first: number(self.subtree.ids.len() - count),
            count: number(count),
            second: 0,
            choices: [0; WIDTH],
        });
        [leaf_cost(half_area(&bounds), count); WIDTH - 1]
    }

    /// A set with two children that `grow` adds; it returns their costs and where the second one is.
    fn fork(
        &mut self,
        set: &Set,
        count: usize,
        grow: impl FnOnce(&mut Self) -> ([ForestCosts; 2], usize),
    ) -> ForestCosts {
        let bounds = set.extent.bounds();
        let index = self.subtree.nodes.len();
        self.subtree.nodes.push(Binary {
            bounds,
            first: number(self.subtree.ids.len()),
            count: number(count),
            second: 0,
            choices: [0; WIDTH],
        });
        let (children, second) = grow(self);
        let area = half_area(&bounds);
        let (costs, choices) =
            cheapest_forests(leaf_cost(area, count), area * NODE_COST, &children);
        let node = &mut self.subtree.nodes[index];
        node.second = number(second);
        node.choices = choices;
        costs
    }
}
