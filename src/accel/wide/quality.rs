//! Counting what a ray visits, and what the tree is expected to cost.

use super::WideTree;
use super::build::{BLOCK_COST, NODE_COST};
use super::node::ChildKind;
use super::query::{Any, Nearest};
use super::walk::Visitor;
use crate::accel::block::TriangleBlock;
use crate::accel::{StructureQuality, Visits, half_area};
use crate::math::{Bounds, Ray};

/// A visitor and the account of what it was led to.
struct Counting<V> {
    visitor: V,
    visits: Visits,
}

impl<V: Visitor> Visitor for Counting<V> {
    const NEAREST_FIRST: bool = V::NEAREST_FIRST;

    #[inline(always)]
    fn enter_node(&mut self) {
        self.visits.nodes += 1;
    }

    #[inline(always)]
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32> {
        self.visits.blocks += blocks.len() as u64;
        self.visitor.visit(blocks)
    }
}

impl WideTree {
    /// What [`WideTree::intersect`], or [`WideTree::occluded`] where `any_hit`, visits.
    #[must_use]
    pub fn visits_along(&self, ray: &Ray, t_max: f32, any_hit: bool) -> Visits {
        if any_hit {
            self.count(ray, t_max, Any::new(ray, t_max))
        } else {
            self.count(ray, t_max, Nearest::new(ray, t_max))
        }
    }

    fn count<V: Visitor>(&self, ray: &Ray, t_max: f32, visitor: V) -> Visits {
        let mut counting = Counting {
            visitor,
            visits: Visits::default(),
        };
        self.walk(ray, t_max, &mut counting);
        counting.visits
    }

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
        let mut open = vec![(self.root, 1.0)];
        while let Some((child, chance_of_child)) = open.pop() {
            match child.kind() {
                ChildKind::Node(index) => {
                    quality.sah_cost += chance_of_child * NODE_COST;
                    let node = &self.nodes[index];
                    for (lane, &child) in node.children.iter().enumerate() {
                        open.push((child, chance(&node.bounds(lane))));
                    }
                }
                ChildKind::Leaf(blocks) => {
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
