//! What the tree is expected to cost.

use super::KdTree;
use crate::accel::StructureQuality;

impl KdTree {
    /// Counts references and computes the expected cost, see [`KdTree::statistics`].
    #[must_use]
    pub fn quality(&self) -> StructureQuality {
        let statistics = self.statistics();
        StructureQuality {
            triangles: self.triangle_count() as u64,
            references: statistics.references as u64,
            nodes: (statistics.nodes - statistics.leaves) as u64,
            leaves: statistics.leaves as u64,
            empty_leaves: statistics.empty_leaves as u64,
            blocks: statistics.blocks as u64,
            depth: statistics.max_depth,
            sah_cost: statistics.sah_cost,
        }
    }
}
