//! Following a ray through the boxes of the tree.

use super::WideTree;
use super::node::{Child, ChildKind, RaySlabs, WIDTH, later};
use crate::accel::block::TriangleBlock;
use crate::math::Ray;

/// What a walk does with the leaves it meets.
pub(super) trait Visitor {
    /// Whether the children of each node are visited in the order in which the ray enters them.
    const NEAREST_FIRST: bool;

    /// Visits a leaf. Returns the `t` beyond which nothing matters any more, `None` to stop.
    fn visit(&mut self, blocks: &[TriangleBlock]) -> Option<f32>;
}

impl WideTree {
    /// Visits the leaves whose boxes `ray` may pass in `0 < t < t_max`, except those beyond the `t` of the last visit.
    #[inline(always)]
    pub(super) fn walk<V: Visitor>(&self, ray: &Ray, t_max: f32, visitor: &mut V) {
        let slabs = RaySlabs::new(ray, self.reach);
        let mut limit = later(t_max);
        let mut stack = Stack::new();
        let mut next = self.root;
        loop {
            match next.kind() {
                ChildKind::Node(index) => {
                    let node = &self.nodes[index];
                    let (enter, passed) = slabs.enter(node, limit);
                    let first = stack.make_room();
                    for lane in passed {
                        let waiting = Waiting::new(enter[lane], node.children[lane]);
                        if V::NEAREST_FIRST {
                            stack.insert(first, waiting);
                        } else {
                            stack.push(waiting);
                        }
                    }
                }
                ChildKind::Leaf(blocks) => match visitor.visit(&self.blocks[blocks]) {
                    Some(t) => limit = later(t),
                    None => return,
                },
            }
            next = loop {
                let Some(waiting) = stack.pop() else {
                    return;
                };
                if waiting.enter() <= limit {
                    break waiting.child();
                }
            };
        }
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

/// What waits on a walk. All but the deepest trees need the array alone, which is small, as every ray clears one.
struct Stack {
    top: [Waiting; Self::SIZE],
    count: usize,
    /// What was below the array when it was full.
    rest: Vec<Waiting>,
}

impl Stack {
    const SIZE: usize = 64;

    #[inline(always)]
    fn new() -> Self {
        Self {
            top: [Waiting(0); Self::SIZE],
            count: 0,
            rest: Vec::new(),
        }
    }

    /// Makes room for the children of a node; returns where they begin.
    #[inline(always)]
    fn make_room(&mut self) -> usize {
        if self.count > Self::SIZE - WIDTH {
            self.rest.extend_from_slice(&self.top[..self.count]);
            self.count = 0;
        }
        self.count
    }

    #[inline(always)]
    fn push(&mut self, waiting: Waiting) {
        self.top[self.count] = waiting;
        self.count += 1;
    }

    /// Adds one to those from `first` on, of which the nearest is on top.
    #[inline(always)]
    fn insert(&mut self, first: usize, waiting: Waiting) {
        let mut at = self.count;
        while at > first && self.top[at - 1] < waiting {
            self.top[at] = self.top[at - 1];
            at -= 1;
        }
        self.top[at] = waiting;
        self.count += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Waiting> {
        if self.count == 0 {
            return self.rest.pop();
        }
        self.count -= 1;
        Some(self.top[self.count])
    }
}
