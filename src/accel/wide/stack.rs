//! What waits to be visited during a walk.

use std::cell::RefCell;
use std::mem;

use super::node::WIDTH;
use crate::accel::leaf::Visitor;

const STACK_SIZE: usize = 32;

thread_local! {
    /// Memory for what does not fit in the array, kept from ray to ray.
    static SET_ASIDE: RefCell<Vec<Vec<Waiting>>> = const { RefCell::new(Vec::new()) };
}

/// The boxes that wait for their turn, the nearest of each node on top.
pub(super) struct Stack {
    /// All but the deepest trees need this array alone, which is small, as every ray clears one.
    top: [Waiting; STACK_SIZE],
    count: usize,
    /// What was in the array when it was full.
    below: Vec<Waiting>,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            top: [Waiting(0); STACK_SIZE],
            count: 0,
            below: Vec::new(),
        }
    }

    /// Makes room for the children of one node; returns where they will begin.
    #[inline(always)]
    pub fn make_room(&mut self) -> usize {
        if self.count > STACK_SIZE - WIDTH {
            self.set_aside();
        }
        self.count
    }

    #[cold]
    #[inline(never)]
    fn set_aside(&mut self) {
        if self.below.capacity() == 0 {
            self.below = SET_ASIDE.with_borrow_mut(Vec::pop).unwrap_or_default();
        }
        self.below.extend_from_slice(&self.top[..self.count]);
        self.count = 0;
    }

    /// Adds a box to those from `first` on, in order where order matters to `V`.
    #[inline(always)]
    pub fn push<V: Visitor>(&mut self, first: usize, waiting: Waiting) {
        let mut at = self.count;
        while V::NEAREST_FIRST && at > first && self.top[at - 1] < waiting {
            self.top[at] = self.top[at - 1];
            at -= 1;
        }
        self.top[at] = waiting;
        self.count += 1;
    }

    /// The next box that begins before `limit`.
    #[inline(always)]
    pub fn pop<V: Visitor>(&mut self, limit: f32) -> Option<Waiting> {
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
                return Some(waiting);
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn give_back(&mut self) {
        let mut below = mem::take(&mut self.below);
        below.clear();
        // Where the thread ends, nothing is kept.
        let _ = SET_ASIDE.try_with(|kept| kept.borrow_mut().push(below));
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

impl Drop for Stack {
    #[inline(always)]
    fn drop(&mut self) {
        if self.below.capacity() > 0 {
            self.give_back();
        }
    }
}

/// A box that waits for its turn: where it begins in the upper half, what it is in the lower. As no box begins before 0, the
/// order of the numbers is that of the beginnings.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    pub fn new(enter: f32, what: u32) -> Self {
        Self(u64::from(enter.to_bits()) << 32 | u64::from(what))
    }

    #[inline(always)]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub fn what(self) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
        let what = self.0 as u32;
        what
    }
}
