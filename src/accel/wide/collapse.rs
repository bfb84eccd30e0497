//! Folding the binary tree into wide nodes and blocks.

use super::forest::{Forest, Slot};
use super::node::{Child, ChildKind, Node};
use crate::accel::block::TriangleBlock;
use crate::accel::simd::LANES;
use crate::control::CancelToken;
use crate::geometry::Triangle;
use rayon::prelude::*;

/// The root, nodes and leaf blocks of the wide tree: those of the top first, then those of subtrees, each in the order of a
/// depth-first walk, so that what is visited together lies together. Not meaningful when cancelled.
pub(super) fn collapse(
    forest: &Forest,
    triangles: &[Triangle],
    cancel: &CancelToken,
) -> (Child, Vec<Node>, Vec<TriangleBlock>) {
    let mut top = Folding::default();
    let root = if forest.node(forest.root).is_leaf() {
        top.leaf(forest, forest.root)
    } else {
        top.fold(forest, forest.root);
        Child::node(0)
    };
    let subtrees = std::mem::take(&mut top.subtrees);
    let foldings = subtrees.par_iter().map(|&(slot, ..)| {
        let mut folding = Folding::default();
        folding.fold(forest, slot);
        folding
    });
    let mut foldings: Vec<_> = foldings.collect();

    // Where the nodes and chunks of each subtree come to stand.
    let (mut nodes, mut chunks) = (top.nodes.len(), top.chunks.len());
    let mut starts = Vec::with_capacity(foldings.len());
    for (folding, &(_, parent, lane)) in foldings.iter().zip(&subtrees) {
        top.nodes[parent].children[lane] = Child::node(nodes);
        starts.push((nodes, chunks));
        nodes += folding.nodes.len();
        chunks += folding.chunks.len();
    }
    (foldings.par_iter_mut().zip(&starts)).for_each(|(folding, &start)| folding.shift(start));
    top.nodes.reserve_exact(nodes - top.nodes.len());
    top.chunks.reserve_exact(chunks - top.chunks.len());
    for folding in foldings {
        top.nodes.extend_from_slice(&folding.nodes);
        top.chunks.extend_from_slice(&folding.chunks);
    }

    let blocks = top.chunks.par_iter().map(|chunk| {
        let ids = if cancel.is_cancelled() {
            &[]
        } else {
            let Chunk {
                piece,
                first,
                count,
            } = *chunk;
            &forest.pieces[piece as usize].ids[first as usize..][..count]
        };
        TriangleBlock::new(ids, triangles)
    });
    let blocks = blocks.collect();
    (root, top.nodes, blocks)
}

/// The ids of one block.
#[derive(Clone, Copy)]
struct Chunk {
    piece: u32,
    first: u32,
    count: usize,
}

/// The wide nodes over the top of the tree or over a subtree.
#[derive(Default)]
struct Folding {
    nodes: Vec<Node>,
    chunks: Vec<Chunk>,
    /// Subtrees to be folded by themselves, and the nodes and lanes they belong to.
    subtrees: Vec<(Slot, usize, usize)>,
}

impl Folding {
    /// Adds the wide node at `root` and all below it in the same piece of the tree.
    fn fold(&mut self, forest: &Forest, root: Slot) {
        self.nodes.push(Node::EMPTY);
        let mut open = vec![(root, 0)];
        while let Some((slot, index)) = open.pop() {
            let (found, count) = forest.children(slot);
            let first_open = open.len();
            for (lane, &slot) in found[..count].iter().enumerate() {
                let node = forest.node(slot);
                let child = if node.is_leaf() {
                    self.leaf(forest, slot)
                } else if slot.piece == root.piece {
                    open.push((slot, self.nodes.len()));
                    self.nodes.push(Node::EMPTY);
                    Child::node(self.nodes.len() - 1)
                } else {
                    self.subtrees.push((slot, index, lane));
                    Child::NONE
                };
                self.nodes[index].set(lane, &node.bounds, child);
            }
            open[first_open..].reverse();
        }
    }

    /// Adds the blocks of a leaf.
    fn leaf(&mut self, forest: &Forest, slot: Slot) -> Child {
        let before = self.chunks.len();
        let node = forest.node(slot);
        for start in (0..node.count as usize).step_by(LANES) {
            self.chunks.push(Chunk {
                piece: slot.piece,
                first: node.first + u32::try_from(start).expect("leaves are small"),
                count: LANES.min(node.count as usize - start),
            });
        }
        Child::leaf(&(before..self.chunks.len()))
    }

    /// Makes room for so many nodes and chunks before those here.
    fn shift(&mut self, (nodes, chunks): (usize, usize)) {
        for child in self.nodes.iter_mut().flat_map(|node| &mut node.children) {
            *child = match child.kind() {
                ChildKind::Node(index) => Child::node(index + nodes),
                ChildKind::Leaf(blocks) if blocks.is_empty() => Child::NONE,
                ChildKind::Leaf(blocks) => {
                    Child::leaf(&(blocks.start + chunks..blocks.end + chunks))
                }
            };
        }
    }
}
