//! Following a ray through the boxes of the tree.

use super::WideTree;
use super::node::{Child, ChildKind, RaySlabs, WIDTH};
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
                    waiting.make_room();
                    let (enter, passed) = slabs.enter(node, limit);
                    let mut passed = passed.into_iter();
                    let first = waiting.count;
                    let Some(lane) = passed.next() else {
                        let Some(child) = waiting.pop::<V>(limit) else {
                            return;
                        };
                        next = child;
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
                    let mut nearest = Waiting::new(enter[lane], node.children[lane]);
                    for lane in passed {
                        let mut other = Waiting::new(enter[lane], node.children[lane]);
                        if V::NEAREST_FIRST && other < nearest {
                            std::mem::swap(&mut nearest, &mut other);
                        }
                        waiting.push::<V>(first, other);
                    }
                    next = nearest.child();
                }
                ChildKind::Leaf(blocks) => {
                    match visitor.visit(&self.blocks[blocks]) {
                        Some(t) => limit = later(t),
                        None => return,
                    }
                    let Some(child) = waiting.pop::<V>(limit) else {
                        return;
                    };
                    next = child;
                }
            }
        }
    }
}

const STACK_SIZE: usize = 32;

/// The children that wait for their turn, the nearest of each node on top.
struct Stack {
    /// All but the deepest trees need this array alone, which is small, as every ray clears one.
    top: [Waiting; STACK_SIZE],
    count: usize,
    /// What was in the array when it was full.
    below: Vec<Waiting>,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self {
            top: [Waiting(0); STACK_SIZE],
            count: 0,
            below: Vec::new(),
        }
    }

    /// Makes room for the children of one node.
    #[inline(always)]
    fn make_room(&mut self) {
        if self.count > STACK_SIZE - WIDTH {
            self.set_aside();
        }
    }

    #[cold]
    #[inline(never)]
    fn set_aside(&mut self) {
        self.below.extend_from_slice(&self.top[..self.count]);
        self.count = 0;
    }

    /// Adds a child to those from `first` on, in order where order matters.
    #[inline(always)]
    fn push<V: Visitor>(&mut self, first: usize, waiting: Waiting) {
        let mut at = self.count;
        while V::NEAREST_FIRST && at > first && self.top[at - 1] < waiting {
            self.top[at] = self.top[at - 1];
            at -= 1;
        }
        self.top[at] = waiting;
        self.count += 1;
    }

    /// The next child that begins before `limit`.
    #[inline(always)]
    fn pop<V: Visitor>(&mut self, limit: f32) -> Option<Child> {
        loop {
            if self.count == 0 {
                if self.below.is_empty() {
                    return None;
                }
                self.take_back();
            }
            self.count -= 1;
            let waiting = self.top[self.count];
            if !V::NEAREST_FIRST || waiting.enter() <= limit {
                return Some(waiting.child());
            }
        }
    }

    /// Moves as much as fits back onto the empty array.
    #[cold]
    #[inline(never)]
    fn take_back(&mut self) {
        self.count = self.below.len().min(STACK_SIZE - WIDTH);
        let rest = self.below.len() - self.count;
        self.top[..self.count].copy_from_slice(&self.below[rest..]);
        self.below.truncate(rest);
    }
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
