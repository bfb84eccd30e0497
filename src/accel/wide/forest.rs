//! The binary tree, and how it folds into wide nodes in the way that costs least.

use super::node::WIDTH;
use crate::math::Bounds;

/// A node of the binary tree, over a set of references to triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binary {
    pub bounds: Bounds,
    /// Where the set's ids begin in those of the subtree. In the top of the tree, the first child's [`Link`].
    pub first: u32,
    pub count: u32,
    /// In subtrees the second child's index; the first one follows its parent. In the top of the tree its [`Link`].
    pub second: u32,
    /// How the cheapest forest of at most `i + 1` trees looks. For the first, 0 for a leaf and 1 for a node; for the others,
    /// how many of the trees stand for the first child, or 0 for the forest with one tree less.
    pub choices: [u8; WIDTH],
}

impl Binary {
    /// Whether the subtree is a leaf of the wide tree; a node otherwise.
    pub fn is_leaf(&self) -> bool {
        self.choices[0] == 0
    }
}

/// A part of the tree that one thread grew: the root first.
#[derive(Debug, Default)]
pub(super) struct Subtree {
    pub nodes: Vec<Binary>,
    /// Triangles in the order of leaves.
    pub ids: Vec<u32>,
}

/// The binary tree: its top, in whose place stand subtrees.
#[derive(Debug)]
pub(super) struct Forest {
    /// The top first, then the subtrees.
    pub pieces: Vec<Subtree>,
    pub root: Slot,
}

/// Where a node is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Slot {
    pub piece: u32,
    pub index: u32,
}

impl Forest {
    pub fn node(&self, slot: Slot) -> &Binary {
        &self.pieces[slot.piece as usize].nodes[slot.index as usize]
    }

    /// The subtrees that the wide node at `slot` has as children.
    pub fn children(&self, slot: Slot) -> ([Slot; WIDTH], usize) {
        let mut children = ([Slot::default(); WIDTH], 0);
        self.gather(slot, WIDTH, &mut children);
        children
    }

    /// Adds the trees of the cheapest forest of at most `trees` over the set at `slot`.
    fn gather(&self, slot: Slot, mut trees: usize, found: &mut ([Slot; WIDTH], usize)) {
        let node = self.node(slot);
        while trees > 1 && node.choices[trees - 1] == 0 {
            trees -= 1;
        }
        if trees == 1 {
            found.0[found.1] = slot;
            found.1 += 1;
            return;
        }
        let of_first = usize::from(node.choices[trees - 1]);
        let [first, second] = if slot.piece == 0 {
            [node.first, node.second].map(Link::slot)
        } else {
            [slot.index + 1, node.second].map(|index| Slot { index, ..slot })
        };
        self.gather(first, of_first, found);
        self.gather(second, trees - of_first, found);
    }
}

/// Another node of the top, or a subtree, in one number.
pub(super) struct Link;

impl Link {
    const SUBTREE: u32 = 1 << 31;

    pub fn of(slot: Slot) -> u32 {
        if slot.piece == 0 {
            slot.index
        } else {
            slot.piece | Self::SUBTREE
        }
    }

    fn slot(link: u32) -> Slot {
        if link & Self::SUBTREE == 0 {
            Slot {
                piece: 0,
                index: link,
            }
        } else {
            Slot {
                piece: link & !Self::SUBTREE,
                index: 0,
            }
        }
    }
}

/// Expected costs of the cheapest forests of at most 1 to 7 trees over a set, in the unit of the builder's costs times area.
pub(super) type ForestCosts = [f64; WIDTH - 1];

/// The forests over a set with two children, by what the forests over those cost. `leaf` is what the set costs as one leaf,
/// `node` what a node around it costs.
///
/// Source: Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, 3.1.
pub(super) fn cheapest_forests(
    leaf: f64,
    node: f64,
    [left, right]: &[ForestCosts; 2],
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
