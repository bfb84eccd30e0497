//! Whether a finished tree is one.

use super::node::{Child, ChildKind};
use super::{LARGEST_LEAF, WideTree};
use crate::accel::block::TriangleBlock;
use crate::accel::simd::LANES;
use crate::geometry::Triangle;
use crate::math::{Bounds, DVec3, Vec3};

impl WideTree {
    /// Checks what the walk relies on: every node and block is reached once, boxes hold what is in them, every triangle is
    /// where its place says, and all that are finite are covered by the boxes of the leaves they are in, as far as many points
    /// of them tell.
    ///
    /// # Errors
    /// A sentence about the first thing found wrong.
    pub fn validate(&self) -> Result<(), String> {
        let mut nodes_reached = vec![false; self.nodes.len()];
        let mut blocks_reached = vec![false; self.blocks.len()];
        let everywhere = Bounds {
            min: Bounds::EMPTY.max,
            max: Bounds::EMPTY.min,
        };
        // Which triangles are in which leaf boxes.
        let mut parts = Vec::new();
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
                    let first = parts.len();
                    for index in blocks {
                        if std::mem::replace(&mut blocks_reached[index], true) {
                            return Err(format!("block {index} is reached twice"));
                        }
                        self.validate_block(index)?;
                        let ids = self.blocks[index].ids.iter();
                        let ids = ids.filter(|&&id| id != TriangleBlock::NO_TRIANGLE);
                        parts.extend(ids.map(|&id| (id, bounds)));
                    }
                    let of_leaf = &mut parts[first..];
                    of_leaf.sort_unstable_by_key(|&(id, _)| id);
                    if let Some(pair) = of_leaf.windows(2).find(|pair| pair[0].0 == pair[1].0) {
                        return Err(format!("triangle {} is in a leaf twice", pair[0].0));
                    }
                }
            }
        }
        if let Some(index) = nodes_reached.iter().position(|reached| !reached) {
            return Err(format!("node {index} is never reached"));
        }
        for index in (0..self.blocks.len()).filter(|&index| !blocks_reached[index]) {
            self.validate_block(index)?;
        }
        self.validate_places()?;
        parts.sort_by_key(|&(id, _)| id);
        let mut parts = &parts[..];
        for id in 0..self.triangle_count() {
            let count = parts.partition_point(|&(other, _)| other as usize <= id);
            let (of_this, rest) = parts.split_at(count);
            parts = rest;
            if !is_covered(&self.triangle(id), of_this) {
                return Err(format!("triangle {id} reaches out of its boxes"));
            }
        }
        Ok(())
    }

    fn validate_block(&self, index: usize) -> Result<(), String> {
        let block = &self.blocks[index];
        for (lane, &id) in block.ids.iter().enumerate() {
            let triangle = block.triangle(lane);
            if id == TriangleBlock::NO_TRIANGLE {
                if !triangle.corners.iter().all(|c| c.is_nan_mask().all()) {
                    return Err(format!("empty lane {lane} of block {index} is not NaN"));
                }
            } else if id as usize >= self.places.len() {
                return Err(format!("there is no triangle {id}"));
            } else {
                let bits = |t: &Triangle| t.corners.map(|c| c.to_array().map(f32::to_bits));
                if bits(&triangle) != bits(&self.triangle(id as usize)) {
                    return Err(format!("triangle {id} differs in block {index}"));
                }
            }
        }
        Ok(())
    }

    fn validate_places(&self) -> Result<(), String> {
        for (id, &place) in self.places.iter().enumerate() {
            let (block, lane) = (place as usize / LANES, place as usize % LANES);
            let found = self.blocks.get(block).map(|block| block.ids[lane] as usize);
            if found != Some(id) {
                return Err(format!("triangle {id} is not where its place says"));
            }
        }
        Ok(())
    }
}

/// Whether points all over a triangle lie in one of the boxes each. Triangles that are not finite need none.
fn is_covered(triangle: &Triangle, boxes: &[(u32, Bounds)]) -> bool {
    /// Points per edge.
    const POINTS: u32 = 12;
    /// The points are off by a few roundings, far less than the boxes would be if they were rounded inwards.
    const MARGIN: f64 = f64::EPSILON * 8.0;
    let corners = triangle.corners;
    if !corners.iter().all(|corner| corner.is_finite()) {
        return true;
    }
    let magnitude = corners.iter().map(|corner| corner.abs().max_element());
    let margin = DVec3::splat(f64::from(magnitude.fold(0.0, f32::max)) * MARGIN);
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let shares = (0..=POINTS).flat_map(|i| (0..=POINTS - i).map(move |j| (i, j)));
    shares.into_iter().all(|(i, j)| {
        let [i, j] = [i, j].map(|k| f64::from(k) / f64::from(POINTS));
        let point = a + (b - a) * i + (c - a) * j;
        boxes.iter().any(|(_, part)| {
            let (min, max) = (part.min.as_dvec3() - margin, part.max.as_dvec3() + margin);
            min.cmple(point).all() && point.cmple(max).all()
        })
    })
}
