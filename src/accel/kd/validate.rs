//! Looking at a finished tree: its statistics, and whether it is one.

use super::clip::{Clipper, magnitude};
use super::node::NodeKind;
use super::{KdStatistics, KdTree, MAX_DEPTH};
use crate::accel::block::TriangleBlock;
use crate::accel::half_area;
use crate::accel::simd::LANES;
use crate::math::{Bounds, DVec3};
use std::ops::Range;

/// A node met on a walk over the whole tree.
struct Visit {
    index: usize,
    depth: u32,
    cell: Bounds,
}

impl KdTree {
    /// Counts nodes and references, and computes the expected cost.
    #[must_use]
    pub fn statistics(&self) -> KdStatistics {
        let mut statistics = KdStatistics::default();
        // A box that holds nothing has no area to take a share of.
        let whole = if self.bounds.is_empty() {
            0.0
        } else {
            half_area(&self.bounds)
        };
        for Visit { index, depth, cell } in self.visits() {
            statistics.nodes += 1;
            statistics.max_depth = statistics.max_depth.max(depth);
            // The chance that a ray through the scene's box passes this cell.
            let chance = if whole > 0.0 {
                half_area(&cell) / whole
            } else {
                1.0
            };
            match self.nodes[index].kind() {
                NodeKind::Interior { .. } => {
                    statistics.sah_cost += chance * self.parameters.traversal_cost;
                }
                NodeKind::Leaf { blocks } => {
                    statistics.leaves += 1;
                    statistics.empty_leaves += usize::from(blocks.is_empty());
                    statistics.blocks += blocks.len();
                    statistics.references += self.leaf_ids(blocks.clone()).count();
                    statistics.sah_cost +=
                        chance * self.parameters.intersection_cost * blocks.len() as f64;
                }
            }
        }
        statistics
    }

    /// Checks what the walk relies on: every node is reached once and no deeper than allowed, planes cut their cells,
    /// every triangle is where its place says and has the same corners wherever it is, and it is in each leaf whose cell
    /// holds a part of it. Lying on a cell's side does not count: the neighbour may have it.
    ///
    /// # Errors
    /// A sentence about the first thing found wrong.
    pub fn validate(&self) -> Result<(), String> {
        let mut reached = vec![false; self.nodes.len()];
        let mut next_block = 0;
        for visit in self.visits() {
            let Visit { index, depth, cell } = visit;
            if std::mem::replace(&mut reached[index], true) {
                return Err(format!("node {index} is reached twice"));
            }
            match self.nodes[index].kind() {
                NodeKind::Interior {
                    axis,
                    position,
                    children,
                } => {
                    if depth >= MAX_DEPTH {
                        return Err(format!("interior node {index} is at depth {depth}"));
                    }
                    if children + 1 >= self.nodes.len() {
                        return Err(format!(
                            "node {index} has children {children} and next of {}",
                            self.nodes.len()
                        ));
                    }
                    if !(cell.min[axis] < position && position < cell.max[axis]) {
                        return Err(format!(
                            "node {index} splits {cell:?} at {position} across axis {axis}"
                        ));
                    }
                }
                NodeKind::Leaf { blocks } => {
                    if blocks.start != next_block && !blocks.is_empty()
                        || blocks.end > self.blocks.len()
                    {
                        return Err(format!(
                            "leaf {index} has blocks {blocks:?}, {next_block} was to follow"
                        ));
                    }
                    next_block += blocks.len();
                    self.validate_leaf(index, blocks)?;
                }
            }
        }
        if let Some(index) = reached.iter().position(|reached| !reached) {
            return Err(format!("node {index} is never reached"));
        }
        let places = self.places.iter();
        let in_no_leaf = places.filter(|&&place| place as usize >= next_block * LANES);
        let others = self.leaf_ids(next_block..self.blocks.len());
        if others.count() != in_no_leaf.count() {
            return Err(format!(
                "only {next_block} of {} blocks belong to leaves",
                self.blocks.len()
            ));
        }
        self.validate_places()?;
        self.validate_completeness()
    }

    /// All nodes below the root, parents first, small sides before large ones, in cells that the planes above cut out.
    fn visits(&self) -> impl Iterator<Item = Visit> {
        let mut open = vec![Visit {
            index: 0,
            depth: 0,
            cell: self.bounds,
        }];
        std::iter::from_fn(move || {
            let visit = open.pop()?;
            if let NodeKind::Interior { children, .. } = self.nodes[visit.index].kind()
                && children + 1 < self.nodes.len()
            {
                let [left, right] = self.children(&visit);
                open.extend([right, left]);
            }
            Some(visit)
        })
    }

    /// The two children of an interior node.
    fn children(&self, parent: &Visit) -> [Visit; 2] {
        let NodeKind::Interior {
            axis,
            position,
            children,
        } = self.nodes[parent.index].kind()
        else {
            unreachable!("only interior nodes are asked for their children");
        };
        let (mut left, mut right) = (parent.cell, parent.cell);
        left.max[axis] = position;
        right.min[axis] = position;
        [(children, left), (children + 1, right)].map(|(index, cell)| Visit {
            index,
            depth: parent.depth + 1,
            cell,
        })
    }

    /// Checks that every triangle has a place that names it.
    fn validate_places(&self) -> Result<(), String> {
        for (id, &place) in (0..).zip(&self.places) {
            let place = place as usize;
            let there = self.blocks.get(place / LANES);
            if there.map(|block| block.ids[place % LANES]) != Some(id) {
                return Err(format!("triangle {id} is not at its place {place}"));
            }
        }
        Ok(())
    }

    fn leaf_ids(&self, blocks: Range<usize>) -> impl Iterator<Item = u32> {
        let ids = self.blocks[blocks].iter().flat_map(|block| block.ids);
        ids.filter(|&id| id != TriangleBlock::NO_TRIANGLE)
    }

    /// Checks that a leaf's blocks hold the triangles they name, in ascending order and without gaps.
    fn validate_leaf(&self, index: usize, blocks: Range<usize>) -> Result<(), String> {
        let ids: Vec<_> = self.leaf_ids(blocks.clone()).collect();
        if !ids.is_sorted_by(|a, b| a < b) {
            return Err(format!("the ids of leaf {index} are not in order: {ids:?}"));
        }
        let chunks = ids.chunks(LANES);
        if chunks.len() != blocks.len() {
            return Err(format!(
                "leaf {index} has {} blocks for {} triangles",
                blocks.len(),
                ids.len()
            ));
        }
        for (block, ids) in self.blocks[blocks].iter().zip(chunks) {
            if block.ids[..ids.len()] != *ids {
                return Err(format!("leaf {index} has a gap in {:?}", block.ids));
            }
            for (lane, &id) in ids.iter().enumerate() {
                let place = self.places.get(id as usize).map(|&p| p as usize);
                let there = place.and_then(|place| {
                    let block = self.blocks.get(place / LANES)?;
                    Some(block.triangle(place % LANES))
                });
                if there != Some(block.triangle(lane)) {
                    return Err(format!("leaf {index} has other corners than triangle {id}"));
                }
            }
            for lane in ids.len()..LANES {
                if !block
                    .triangle(lane)
                    .corners
                    .iter()
                    .all(|corner| corner.is_nan_mask().all())
                {
                    return Err(format!(
                        "leaf {index} has an empty lane {lane} that is not NaN"
                    ));
                }
            }
        }
        Ok(())
    }

    /// Checks that each leaf refers to all triangles with a part clearly inside its cell.
    fn validate_completeness(&self) -> Result<(), String> {
        // Far more than the rounding of a clipped coordinate, far less than any cell.
        const CLEARLY: f64 = 1.0 / (1_u64 << 40) as f64;
        let mut clipper = Clipper::default();
        let mut is_inside = |id: u32, cell: &Bounds| {
            let triangle = &self.triangle(id as usize);
            let (min, max) = (cell.min.as_dvec3(), cell.max.as_dvec3());
            let margin = DVec3::splat(magnitude(triangle) * CLEARLY);
            // Flat cells have no inside to withdraw to.
            let margin = DVec3::select(min.cmplt(max), margin, DVec3::ZERO);
            !clipper
                .polygon(triangle, min + margin, max - margin)
                .is_empty()
        };

        let root = Visit {
            index: 0,
            depth: 0,
            cell: self.bounds,
        };
        let all: Vec<u32> = (0..u32::MAX).take(self.places.len()).collect();
        let mut open = vec![(root, all)];
        while let Some((visit, ids)) = open.pop() {
            match self.nodes[visit.index].kind() {
                NodeKind::Interior { .. } => {
                    for child in self.children(&visit) {
                        let inside = ids.iter().copied().filter(|&id| is_inside(id, &child.cell));
                        let inside = inside.collect();
                        open.push((child, inside));
                    }
                }
                NodeKind::Leaf { blocks } => {
                    let there: Vec<_> = self.leaf_ids(blocks).collect();
                    if let Some(id) = ids.iter().find(|id| there.binary_search(id).is_err()) {
                        return Err(format!(
                            "triangle {id} reaches into {:?} but is not in leaf {}",
                            visit.cell, visit.index
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::KdParameters;
    use crate::accel::kd::node::Node;
    use crate::control::CancelToken;
    use crate::geometry::Triangle;
    use crate::geometry::shapes;

    fn tree() -> KdTree {
        let mesh = shapes::soup(300, 0.2, 1);
        let corners = (0..300).map(|i| mesh.corners(i).map(DVec3::as_vec3));
        let triangles: Vec<_> = corners.map(|corners| Triangle { corners }).collect();
        KdTree::build(&triangles, &KdParameters::default(), &CancelToken::new()).unwrap()
    }

    fn assert_found(complaint: &str, damage: impl Fn(&mut KdTree)) {
        let mut tree = tree();
        tree.validate().unwrap();
        damage(&mut tree);
        let error = tree.validate().expect_err(complaint);
        assert!(error.contains(complaint), "{error} instead of {complaint}");
    }

    #[test]
    fn damage_is_found() {
        let root = |tree: &KdTree| match tree.nodes[0].kind() {
            NodeKind::Interior {
                axis,
                position,
                children,
            } => (axis, position, children),
            NodeKind::Leaf { .. } => panic!("the tree has no planes"),
        };
        assert_found("splits", |tree| {
            let (axis, _, children) = root(tree);
            tree.nodes[0] = Node::interior(axis, 7.0, children);
        });
        assert_found("reaches into", |tree| {
            let (axis, position, children) = root(tree);
            tree.nodes[0] = Node::interior(axis, position + 0.1, children);
        });
        assert_found("reached twice", |tree| {
            let (axis, position, _) = root(tree);
            tree.nodes[0] = Node::interior(axis, position, 0);
        });
        assert_found("has children", |tree| {
            let (axis, position, _) = root(tree);
            tree.nodes[0] = Node::interior(axis, position, tree.nodes.len() - 1);
        });
        assert_found("never reached", |tree| tree.nodes.push(tree.nodes[0]));
        assert_found("belong to leaves", |tree| tree.blocks.push(tree.blocks[0]));
        assert_found("was to follow", |tree| {
            tree.blocks.truncate(tree.blocks.len() - 1);
        });
        assert_found("not in order", |tree| tree.blocks[0].ids.swap(0, 1));
        assert_found("other corners", |tree| tree.places.swap(0, 1));
        assert_found("not at its place", |tree| tree.places.push(0));
        assert_found("other corners", |tree| {
            let mut triangles: Vec<_> = (0..300).map(|id| tree.triangle(id)).collect();
            let mut lanes = tree.blocks.iter().flat_map(|block| block.ids).enumerate();
            let is_again = |&(place, id): &(usize, u32)| {
                id != TriangleBlock::NO_TRIANGLE && tree.places[id as usize] as usize != place
            };
            let (place, id) = lanes.find(is_again).unwrap();
            triangles[id as usize].corners[0].x += 0.1;
            let index = place / LANES;
            let ids: Vec<_> = tree.leaf_ids(index..index + 1).collect();
            tree.blocks[index] = TriangleBlock::new(&ids, &triangles);
        });
        assert_found("not NaN", |tree| {
            let is_partial =
                |block: &TriangleBlock| block.ids[LANES - 1] == TriangleBlock::NO_TRIANGLE;
            let index = tree.blocks.iter().position(is_partial).unwrap();
            let ids = tree.blocks[index].ids;
            let filled = ids.map(|id| {
                if id == TriangleBlock::NO_TRIANGLE {
                    0
                } else {
                    id
                }
            });
            let triangles: Vec<_> = (0..300).map(|id| tree.triangle(id)).collect();
            tree.blocks[index] = TriangleBlock::new(&filled, &triangles);
            tree.blocks[index].ids = ids;
        });
    }

    #[test]
    fn statistics_count_what_is_there() {
        let tree = tree();
        let statistics = tree.statistics();
        assert_eq!(statistics.nodes, tree.nodes.len());
        assert_eq!(statistics.nodes, 2 * statistics.leaves - 1);
        assert_eq!(statistics.blocks, tree.blocks.len());
        assert!(statistics.references >= 300 && statistics.references <= LANES * statistics.blocks);
        assert!(statistics.empty_leaves < statistics.leaves);
        assert!(statistics.sah_cost > 1.0);
        let nothing = KdTree::build(&[], &KdParameters::default(), &CancelToken::new());
        let nothing = nothing.expect("nobody cancels").statistics();
        assert_eq!((nothing.nodes, nothing.sah_cost), (1, 0.0));
    }
}
