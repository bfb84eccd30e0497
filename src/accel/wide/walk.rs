//! Following a ray through the boxes of the tree.

use super::WideTree;
use super::node::{Child, ChildKind, RaySlabs, WIDTH, later};
use crate::accel::block::TriangleBlock;
use crate::math::Ray;

/// What a walk does with the leaves it meets.
pub(super) trait Visitor {
    /// Whether the children of each node are visited in the order in which the ray enters them.
    const NEAREST_FIRST: bool;

    /// A node is about to be tested; what is done here by those who do not count costs nothing.
    #[inline(always)]
    fn enter_node(&mut self) {}

    /// Visits a leaf. Returns the `t` beyond which nothing matters any more, `None` to stop.
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32>;
}

impl WideTree {
    /// Visits the leaves whose boxes `ray` may pass in `0 < t < t_max`, except those beyond the `t` of the last visit.
    #[inline(always)]
    pub(super) fn walk<V: Visitor>(&self, ray: &Ray, t_max: f32, visitor: &mut V) {
        let slabs = RaySlabs::new(ray, self.reach);
        let mut limit = later(t_max);
        // All but the deepest trees need this array alone, which is small, as every ray clears one.
        let mut stack = [Waiting(0); STACK_SIZE];
        let mut count = 0;
        // What was in the array when it was full.
        let mut below = Vec::new();
        let mut next = self.root;
        loop {
            match next.kind() {
                ChildKind::Node(index) => {
                    visitor.enter_node();
                    let node = &self.nodes[index];
                    if count > STACK_SIZE - WIDTH {
                        set_aside(&mut below, &stack[..count]);
                        count = 0;
                    }
                    let (enter, passed) = slabs.enter(node, limit);
                    let first = count;
                    for lane in passed {
                        // Where the order does not matter, no beginning is asked for again.
                        let enter = if V::NEAREST_FIRST { enter[lane] } else { 0.0 };
                        let waiting = Waiting::new(enter, node.children[lane]);
                        let mut at = count;
                        // The nearest is on top.
                        while V::NEAREST_FIRST && at > first && stack[at - 1] < waiting {
                            stack[at] = stack[at - 1];
                            at -= 1;
                        }
                        stack[at] = waiting;
                        count += 1;
                    }
                }
                ChildKind::Leaf(blocks) => match visitor.visit(&self.blocks[blocks]) {
                    Some(t) => limit = later(t),
                    None => return,
                },
            }
            next = loop {
                if count == 0 {
                    count = take_back(&mut below, &mut stack);
                    if count == 0 {
                        return;
                    }
                }
                count -= 1;
                let waiting = stack[count];
                if !V::NEAREST_FIRST || waiting.enter() <= limit {
                    break waiting.child();
                }
            };
        }
    }
}

const STACK_SIZE: usize = 64;

#[cold]
#[inline(never)]
fn set_aside(below: &mut Vec<Waiting>, stack: &[Waiting]) {
    below.extend_from_slice(stack);
}

/// Moves as much as there is and fits back onto the empty stack; returns how much.
#[inline(always)]
fn take_back(below: &mut Vec<Waiting>, stack: &mut [Waiting; STACK_SIZE]) -> usize {
    if below.is_empty() {
        return 0;
    }
    let count = below.len().min(STACK_SIZE - WIDTH);
    stack[..count].copy_from_slice(&below[below.len() - count..]);
    below.truncate(below.len() - count);
    count
}

/// A child that waits for its turn: where it begins in the upper half, the child in the lower. As no child begins before 0,
/// the order of the numbers is that of the beginnings.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(enter: f32, child: Child) -> Self {
        Self(u64::from(enter.to_bits()) << 32 | u64::from(child.to_bits()))
    }

    #[inline(always)]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn child(self) -> Child {
        #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
        let bits = self.0 as u32;
        Child::from_bits(bits)
    }
}
