//! The walk for a packet of rays.
//!
//! Nodes are tested once for all rays, by intervals that hold where any of them may be; of the boxes that are left, one at a
//! time is tested with all rays side by side, and only those that meet it go on to what is inside.

use super::WideTree;
use super::node::{Child, ChildKind};
use super::packet_rays::PacketRays;
use super::stack::{Stack, Waiting};
use crate::accel::leaf::Nearest;
use crate::accel::packet::{Packet, PacketHits};
use crate::accel::query::NearestHit;
use crate::accel::simd::{LANES, Query, Simd};

/// Fewer rays walk by themselves.
const FEWEST_RAYS: usize = 4;

/// The nearest hit of each ray.
pub(super) struct NearestHits<'a> {
    pub tree: &'a WideTree,
    pub packet: &'a Packet,
}

impl Query for NearestHits<'_> {
    type Answer = PacketHits;

    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S) -> PacketHits {
        let Self { tree, packet } = *self;
        if packet.count() >= FEWEST_RAYS
            && let Some(mut walk) = PacketWalk::new(simd, tree, packet)
        {
            walk.run();
            return walk.rays.hits;
        }
        let mut hits = [None; Packet::MOST_RAYS];
        for ((ray, t_max), hit) in packet.rays().zip(&mut hits) {
            let ray = &ray;
            *hit = NearestHit { tree, ray, t_max }.answer(simd);
        }
        hits
    }
}

/// A packet on its way through a tree.
struct PacketWalk<'a, S: Simd> {
    simd: S,
    tree: &'a WideTree,
    rays: PacketRays<'a, S>,
}

impl<'a, S: Simd> PacketWalk<'a, S> {
    /// `None` where the rays differ in the sign of a direction, or are out of the ordinary.
    #[inline(always)]
    fn new(simd: S, tree: &'a WideTree, packet: &'a Packet) -> Option<Self> {
        let rays = PacketRays::new(simd, packet, tree.reach)?;
        Some(Self { simd, tree, rays })
    }

    #[inline(always)]
    fn run(&mut self) {
        let tree = self.tree;
        let mut limit = self.rays.last_limit();
        let mut waiting = Stack::new();
        let mut node = match tree.root.kind() {
            ChildKind::Node(index) => index,
            ChildKind::Leaf(blocks) => {
                self.rays.visit(self.rays.all(), &tree.blocks[blocks]);
                return;
            }
        };
        loop {
            let first = waiting.make_room();
            let (enter, passed) = self.rays.span.enter_node(&tree.nodes[node], limit);
            let enter = self.simd.store(enter).0;
            for lane in passed {
                let place = node * LANES + lane;
                self.prefetch(tree.nodes[node].children[lane]);
                #[expect(clippy::cast_possible_truncation, reason = "less than 2^32 lanes")]
                let waiting_lane = Waiting::new(enter[lane], place as u32);
                waiting.push::<Nearest<'_, S>>(first, waiting_lane);
            }
            node = loop {
                let Some(next) = waiting.pop::<Nearest<'_, S>>(limit) else {
                    return;
                };
                let place = next.what() as usize;
                let (parent, lane) = (&tree.nodes[place / LANES], place % LANES);
                let meeting = self.rays.meeting(parent, lane);
                if meeting.is_empty() {
                    continue;
                }
                match parent.children[lane].kind() {
                    ChildKind::Node(index) => break index,
                    ChildKind::Leaf(blocks) => {
                        self.rays.visit(meeting, &tree.blocks[blocks]);
                        limit = self.rays.last_limit();
                    }
                }
            };
        }
    }

    /// Large scenes are beyond the caches, and what waits is mostly visited.
    #[inline(always)]
    fn prefetch(&self, child: Child) {
        let Self { simd, tree, .. } = self;
        match child.kind() {
            ChildKind::Node(index) => simd.prefetch(&tree.nodes[index]),
            ChildKind::Leaf(blocks) => {
                if let Some(first) = tree.blocks[blocks].first() {
                    simd.prefetch(first);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::packet::tests::packet_rays;
    use crate::accel::simd;
    use crate::accel::tests::{rays, scenes, wide_tree};
    use crate::geometry::shapes::Random;

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_answer_with_the_same_bits() {
        let mut random = Random::new(5);
        for (name, triangles) in scenes() {
            let tree = &wide_tree(&triangles);
            for ray in rays(&triangles, 17).iter().step_by(20) {
                let rays = packet_rays(&mut random, 1, ray);
                let packet = &Packet::new(&rays);
                let query = NearestHits { tree, packet };
                let answers = simd::answers(&query);
                for answer in &answers[1..] {
                    assert_eq!(*answer, answers[0], "{name}: {packet:?}");
                }
            }
        }
    }
}
