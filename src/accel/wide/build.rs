//! Growing a binary tree over the triangles' boxes, and choosing how it folds into wide nodes.
//!
//! Large subtrees grow in parallel. Each has slots of its own, as many as its triangles can need, so the tree is the same
//! for any number of threads.

use super::node::WIDTH;
use super::split::divide;
use super::{Item, LARGEST_LEAF, number};
use crate::accel::half_area;
use crate::accel::simd::LANES;
use crate::control::CancelToken;
use crate::math::Bounds;

/// Costs of the surface area heuristic: testing the boxes of one node, and testing one block of up to eight triangles.
pub(super) const NODE_COST: f64 = 1.0;
pub(super) const BLOCK_COST: f64 = 0.6;

/// Sets this small are not divided: their triangles fill part of one block.
const SMALLEST: usize = 4;

/// From this depth on sets are halved, so that no tree is much deeper.
const HALVED_FROM: u32 = 40;

/// Sets with fewer triangles grow on one thread.
const PARALLEL_FROM: usize = 1 << 12;

/// A node of the binary tree: the items `first..first + count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binary {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
    /// Slot of the second child; the first one follows its parent. 0 in sets that are not divided.
    second: u32,
    /// How the cheapest forest of at most `i + 1` trees looks. For the first, 0 for a leaf and 1 for a node; for the others,
    /// how many of the trees stand for the first child, or 0 for the forest with one tree less.
    choices: [u8; WIDTH],
}

impl Binary {
    pub const NONE: Self = Self {
        bounds: Bounds::EMPTY,
        first: 0,
        count: 0,
        second: 0,
        choices: [0; WIDTH],
    };

    /// Whether the subtree is a leaf of the wide tree; a node otherwise.
    pub fn is_leaf(&self) -> bool {
        self.choices[0] == 0
    }
}

/// Expected costs of the cheapest forests of at most 1 to 7 trees over a set, in the unit of [`NODE_COST`] times area.
type ForestCosts = [f64; WIDTH - 1];

/// Grows the tree over the items, the root first, and rearranges them. Not meaningful when cancelled.
pub(super) fn grow(items: &mut [Item], cancel: &CancelToken) -> Vec<Binary> {
    let mut nodes = vec![Binary::NONE; (2 * items.len()).max(2) - 1];
    let place = Place {
        slot: 0,
        first: 0,
        depth: 0,
    };
    grow_subtree(items, &mut nodes, place, cancel);
    nodes
}

/// The subtrees that the wide node at `slot` has as children.
pub(super) fn children(nodes: &[Binary], slot: usize) -> ([usize; WIDTH], usize) {
    let mut children = ([0; WIDTH], 0);
    gather(nodes, slot, WIDTH, &mut children);
    children
}

/// Adds the trees of the cheapest forest of at most `trees` over the set at `slot`; of exactly that choice where it is a node's.
fn gather(nodes: &[Binary], slot: usize, mut trees: usize, found: &mut ([usize; WIDTH], usize)) {
    let node = &nodes[slot];
    while trees > 1 && node.choices[trees - 1] == 0 {
        trees -= 1;
    }
    if trees == 1 {
        found.0[found.1] = slot;
        found.1 += 1;
    } else {
        let first = usize::from(node.choices[trees - 1]);
        gather(nodes, slot + 1, first, found);
        gather(nodes, node.second as usize, trees - first, found);
    }
}

/// Where a subtree belongs.
#[derive(Clone, Copy)]
struct Place {
    /// Its first slot in the whole tree.
    slot: usize,
    /// Its first item among all.
    first: usize,
    depth: u32,
}

fn grow_subtree(
    items: &mut [Item],
    nodes: &mut [Binary],
    place: Place,
    cancel: &CancelToken,
) -> ForestCosts {
    let count = items.len();
    let boxes = items.iter().map(|item| item.bounds);
    let bounds = boxes.fold(Bounds::EMPTY, Bounds::union);
    let mut node = Binary {
        bounds,
        first: number(place.first),
        count: number(count),
        ..Binary::NONE
    };
    let area = half_area(&bounds);
    let leaf = if count <= LARGEST_LEAF {
        area * BLOCK_COST * count.div_ceil(LANES) as f64
    } else {
        f64::INFINITY
    };
    if count <= SMALLEST || cancel.is_cancelled() {
        nodes[0] = node;
        return [leaf; WIDTH - 1];
    }

    let middle = divide(items, place.depth >= HALVED_FROM);
    let (left, right) = items.split_at_mut(middle);
    let (parent, rest) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = rest.split_at_mut(2 * middle - 1);
    let at_left = Place {
        slot: place.slot + 1,
        depth: place.depth + 1,
        ..place
    };
    let at_right = Place {
        slot: place.slot + 2 * middle,
        first: place.first + middle,
        depth: place.depth + 1,
    };
    node.second = number(at_right.slot);
    let mut grow_left = || grow_subtree(left, left_nodes, at_left, cancel);
    let mut grow_right = || grow_subtree(right, right_nodes, at_right, cancel);
    let (left, right) = if count >= PARALLEL_FROM {
        rayon::join(grow_left, grow_right)
    } else {
        (grow_left(), grow_right())
    };

    let (costs, choices) = cheapest_forests(leaf, area * NODE_COST, &left, &right);
    node.choices = choices;
    parent[0] = node;
    costs
}

/// The forests over a set with two children, by what the forests over those cost.
///
/// Source: Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, 3.1.
fn cheapest_forests(
    leaf: f64,
    node: f64,
    left: &ForestCosts,
    right: &ForestCosts,
) -> (ForestCosts, [u8; WIDTH]) {
    let mut choices = [0; WIDTH];
    // For at least two trees: so many for the first child, the others for the second.
    let mut split = |trees: usize| {
        let mut best = f64::INFINITY;
        for of_left in 1..trees {
            let cost = left[of_left - 1] + right[trees - of_left - 1];
            if cost < best || of_left == 1 {
                best = cost;
                choices[trees - 1] = u8::try_from(of_left).expect("at most eight");
            }
        }
        best
    };
    let mut costs = [0.0; WIDTH - 1];
    for trees in 2..WIDTH {
        costs[trees - 1] = split(trees);
    }
    let node = node + split(WIDTH);
    costs[0] = leaf.min(node);
    choices[0] = u8::from(leaf > node || leaf == f64::INFINITY);
    for trees in 2..WIDTH {
        if costs[trees - 1] >= costs[trees - 2] {
            costs[trees - 1] = costs[trees - 2];
            choices[trees - 1] = 0;
        }
    }
    (costs, choices)
}
