//! Whether a finished tree is one.

use super::node::{Child, ChildKind};
use super::{LARGEST_LEAF, WideTree};
use crate::accel::block::TriangleBlock;
use crate::accel::simd::LANES;
use crate::math::Bounds;

impl WideTree {
    /// Checks what the walk relies on: every node and block is reached once, boxes hold what is in them, every triangle is
    /// in one block, where its place says, and all that are finite are in leaves.
    ///
    /// # Errors
    /// A sentence about the first thing found wrong.
    pub fn validate(&self) -> Result<(), String> {
        let mut nodes_reached = vec![false; self.nodes.len()];
        let mut blocks_reached = vec![false; self.blocks.len()];
        let mut triangles_reached = vec![false; self.places.len()];
        let everywhere = Bounds {
            min: Bounds::EMPTY.max,
            max: Bounds::EMPTY.min,
        };
        let mut open = vec![(self.root, everywhere)];
        while let Some((child, bounds)) = open.pop() {
            match child.kind() {
                ChildKind::Node(index) => {
                    if std::mem::replace(&mut nodes_reached[index], true) {
                        return Err(format!("node {index} is reached twice"));
                    }
                    let node = &self.nodes[index];
                    for lane in 0..node.children.len() {
                        let (child, inner) = (node.children[lane], node.bounds(lane));
                        if child != Child::NONE && inner.union(bounds) != bounds {
                            return Err(format!("child {lane} of node {index} reaches out"));
                        }
                        open.push((child, inner));
                    }
                }
                ChildKind::Leaf(blocks) => {
                    if blocks.len() * LANES > LARGEST_LEAF {
                        return Err(format!("a leaf has blocks {blocks:?}"));
                    }
                    for index in blocks {
                        if std::mem::replace(&mut blocks_reached[index], true) {
                            return Err(format!("block {index} is reached twice"));
                        }
                        self.validate_block(index, &bounds, &mut triangles_reached)?;
                    }
                }
            }
        }
        if let Some(index) = nodes_reached.iter().position(|reached| !reached) {
            return Err(format!("node {index} is never reached"));
        }
        for index in (0..self.blocks.len()).filter(|&index| !blocks_reached[index]) {
            // A finite triangle reaches out of the box that holds nothing.
            self.validate_block(index, &Bounds::EMPTY, &mut triangles_reached)?;
        }
        let missing = triangles_reached.iter().position(|reached| !reached);
        missing.map_or(Ok(()), |id| Err(format!("triangle {id} is in no block")))
    }

    fn validate_block(
        &self,
        index: usize,
        bounds: &Bounds,
        reached: &mut [bool],
    ) -> Result<(), String> {
        let block = &self.blocks[index];
        for (lane, &id) in block.ids.iter().enumerate() {
            let triangle = block.triangle(lane);
            if id == TriangleBlock::NO_TRIANGLE {
                if !triangle.corners.iter().all(|c| c.is_nan_mask().all()) {
                    return Err(format!("empty lane {lane} of block {index} is not NaN"));
                }
                continue;
            }
            let place = self.places.get(id as usize);
            if place.map(|&place| place as usize) != Some(index * LANES + lane) {
                return Err(format!("triangle {id} is elsewhere than in block {index}"));
            }
            if std::mem::replace(&mut reached[id as usize], true) {
                return Err(format!("triangle {id} is in two blocks"));
            }
            let corners = triangle.corners;
            let is_finite = corners.iter().all(|corner| corner.is_finite());
            if is_finite && !corners.iter().all(|&c| bounds.contains(c)) {
                return Err(format!("triangle {id} reaches out of its box"));
            }
        }
        Ok(())
    }
}
