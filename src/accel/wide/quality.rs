//! What the tree is expected to cost.

use super::WideTree;
use super::build::{BLOCK_COST, NODE_COST};
use super::node::{Child, ChildKind};
use crate::accel::block::TriangleBlock;
use crate::accel::{StructureQuality, half_area};
use crate::math::Bounds;

impl WideTree {
    /// Counts references and computes the expected cost, in the unit of the builder's costs.
    #[must_use]
    pub fn quality(&self) -> StructureQuality {
        let mut quality = StructureQuality {
            triangles: self.triangle_count() as u64,
            ..StructureQuality::default()
        };
        // Of the root, whose box is in no node.
        let root_box = self.nodes.first().map_or(Bounds::EMPTY, |root| {
            (0..root.children.len()).fold(Bounds::EMPTY, |all, lane| all.union(root.bounds(lane)))
        });
        let whole = half_area(&root_box);
        let chance = |bounds: &Bounds| {
            if bounds.is_empty() {
                0.0
            } else if whole > 0.0 {
                half_area(bounds) / whole
            } else {
                1.0
            }
        };
        let mut open = vec![(self.root, 1.0, 0)];
        while let Some((child, chance_of_child, depth)) = open.pop() {
            quality.depth = quality.depth.max(depth);
            match child.kind() {
                ChildKind::Node(index) => {
                    quality.nodes += 1;
                    quality.sah_cost += chance_of_child * NODE_COST;
                    let node = &self.nodes[index];
                    for (lane, &child) in node.children.iter().enumerate() {
                        if child != Child::NONE {
                            open.push((child, chance(&node.bounds(lane)), depth + 1));
                        }
                    }
                }
                ChildKind::Leaf(blocks) => {
                    quality.leaves += 1;
                    quality.empty_leaves += u64::from(blocks.is_empty());
                    quality.blocks += blocks.len() as u64;
                    quality.sah_cost += chance_of_child * BLOCK_COST * blocks.len() as f64;
                    let ids = self.blocks[blocks].iter().flat_map(|block| block.ids);
                    let references = ids.filter(|&id| id != TriangleBlock::NO_TRIANGLE);
                    quality.references += references.count() as u64;
                }
            }
        }
        quality
    }
}
