//! Following a ray through the boxes of the tree.

use super::WideTree;
use super::node::{Child, ChildKind, RaySlabs, WIDTH};
use super::stack::{Stack, Waiting};
use crate::accel::leaf::Visitor;
use crate::accel::query::Tree;
use crate::accel::simd::Simd;
use crate::accel::slabs::later;
use crate::math::Ray;

impl Tree for WideTree {
    #[inline(always)]
    fn walk<S: Simd, V: Visitor>(&self, simd: S, ray: &Ray, t_max: f32, visitor: &mut V) {
        let slabs = RaySlabs::new(simd, ray, self.reach);
        let mut limit = later(t_max);
        let mut waiting = Stack::new();
        let mut next = self.root;
        loop {
            match next.kind() {
                ChildKind::Node(index) => {
                    let node = &self.nodes[index];
                    visitor.enter_node();
                    let first = waiting.make_room();
                    let (enter, passed) = slabs.enter(node, limit);
                    let mut passed = passed.into_iter();
                    let Some(lane) = passed.next() else {
                        let Some(child) = waiting.pop::<V>(limit) else {
                            return;
                        };
                        next = Child::from_bits(child.what());
                        continue;
                    };
                    if passed.is_empty() {
                        next = node.children[lane];
                        continue;
                    }
                    // Where the order does not matter, no beginning is asked for again.
                    let enter = if V::NEAREST_FIRST {
                        simd.store(enter).0
                    } else {
                        [0.0; WIDTH]
                    };
                    let mut nearest = Waiting::new(enter[lane], node.children[lane].to_bits());
                    for lane in passed {
                        let mut other = Waiting::new(enter[lane], node.children[lane].to_bits());
                        if V::NEAREST_FIRST && other < nearest {
                            std::mem::swap(&mut nearest, &mut other);
                        }
                        waiting.push::<V>(first, other);
                    }
                    next = Child::from_bits(nearest.what());
                }
                ChildKind::Leaf(blocks) => {
                    match visitor.visit(&self.blocks[blocks]) {
                        Some(t) => limit = later(t),
                        None => return,
                    }
                    let Some(child) = waiting.pop::<V>(limit) else {
                        return;
                    };
                    next = Child::from_bits(child.what());
                }
            }
        }
    }
}
