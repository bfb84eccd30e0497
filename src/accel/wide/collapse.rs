//! Folding the binary tree into wide nodes and blocks.

use super::build::{Binary, children};
use super::node::{Child, Node};
use super::{Item, block};
use crate::accel::block::TriangleBlock;
use crate::accel::simd::LANES;
use crate::geometry::Triangle;
use rayon::prelude::*;

/// The root, nodes and leaf blocks of the wide tree, in the order of a depth-first walk, so that what is visited together lies
/// together.
pub(super) fn collapse(
    binary: &[Binary],
    items: &[Item],
    triangles: &[Triangle],
) -> (Child, Vec<Node>, Vec<TriangleBlock>) {
    let mut folding = Folding::default();
    let root = folding.child(&binary[0]);
    if root != Child::node(0) {
        return (root, Vec::new(), folding.blocks(items, triangles));
    }
    // Slots of nodes in the binary tree and in the wide one.
    let mut open = vec![(0, 0)];
    while let Some((slot, index)) = open.pop() {
        let (found, count) = children(binary, slot);
        let first_open = open.len();
        for (lane, &slot) in found[..count].iter().enumerate() {
            let node = &binary[slot];
            if !node.is_leaf() {
                open.push((slot, folding.nodes.len()));
            }
            let child = folding.child(node);
            folding.nodes[index].set(lane, &node.bounds, child);
        }
        open[first_open..].reverse();
    }
    let blocks = folding.blocks(items, triangles);
    (root, folding.nodes, blocks)
}

#[derive(Default)]
struct Folding {
    nodes: Vec<Node>,
    /// First item and number of items of each block.
    chunks: Vec<(usize, usize)>,
}

impl Folding {
    /// Makes room for a node or for the blocks of a leaf.
    fn child(&mut self, node: &Binary) -> Child {
        if !node.is_leaf() {
            self.nodes.push(Node::EMPTY);
            return Child::node(self.nodes.len() - 1);
        }
        let before = self.chunks.len();
        let (first, count) = (node.first as usize, node.count as usize);
        let starts = (first..first + count).step_by(LANES);
        self.chunks
            .extend(starts.map(|start| (start, LANES.min(first + count - start))));
        Child::leaf(&(before..self.chunks.len()))
    }

    fn blocks(&self, items: &[Item], triangles: &[Triangle]) -> Vec<TriangleBlock> {
        let chunks = self.chunks.par_iter();
        chunks
            .map(|&(first, count)| block(&items[first..first + count], triangles))
            .collect()
    }
}
