//! The wide tree: nodes of eight boxes around blocks of eight triangles, so that one step tests eight of either at once.
//!
//! Every triangle is in one leaf. A binary tree is grown by the surface area heuristic and folded into wide nodes in the
//! way that costs least by the same heuristic. Boxes are exact and distances to them are compared with a margin for their
//! rounding, so no ray misses a hit.

mod build;
mod collapse;
mod fan;
mod node;
mod packet;
mod quality;
mod split;
mod stack;
mod validate;
mod walk;

use super::Hit;
use super::block::TriangleBlock;
use super::fan::Fan;
use super::packet::{Packet, PacketHits};
use super::query::{AnyHit, NearestHit};
use super::simd::{self, LANES};
use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray, Vec3};
use node::{Child, Node};
use rayon::prelude::*;
use std::cmp::Ordering;

/// Triangles are counted in 29 bits, and so are blocks.
const MAX_TRIANGLES: usize = 1 << 29;

/// Triangles per leaf.
const LARGEST_LEAF: usize = 2 * LANES;

/// A triangle while the tree grows: its box and its id.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

impl Item {
    fn center(&self) -> Vec3 {
        self.bounds.center()
    }

    /// By the boxes' centres along an axis, then by id, so that the order depends on the triangles alone.
    fn order(&self, other: &Self, axis: usize) -> Ordering {
        self.center()[axis]
            .total_cmp(&other.center()[axis])
            .then(self.triangle.cmp(&other.triangle))
    }
}

/// The tree of eight-wide nodes.
#[derive(Clone, Debug)]
pub struct WideTree {
    /// Where each triangle is: eight times its block plus its lane. There is no other list of them.
    places: Vec<u32>,
    bounds: Bounds,
    /// The largest coordinate of any box, by magnitude.
    reach: f32,
    root: Child,
    /// Parents before children.
    nodes: Vec<Node>,
    /// Those of the leaves, then those of triangles that are in none.
    blocks: Vec<TriangleBlock>,
}

impl WideTree {
    /// Builds the tree; `None` when cancelled. The result depends on the triangles alone, not on the number of threads.
    ///
    /// Takes time in proportion to `n log n` for any triangles. Those that are not finite, which no ray hits, are
    /// in no leaf.
    ///
    /// # Panics
    /// When there are more than 2²⁹ triangles.
    #[must_use]
    pub fn build(triangles: &[Triangle], cancel: &CancelToken) -> Option<Self> {
        assert!(
            triangles.len() <= MAX_TRIANGLES,
            "{} triangles are more than 2^29",
            triangles.len()
        );
        let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
        let items = triangles.par_iter().enumerate().map(|(id, triangle)| Item {
            bounds: triangle.bounds(),
            triangle: number(id),
        });
        let (mut items, others): (Vec<_>, Vec<_>) = items.partition(|item| {
            let [a, b, c] = triangles[item.triangle as usize].corners;
            a.is_finite() && b.is_finite() && c.is_finite()
        });
        let boxes = items.iter().map(|item| item.bounds);
        let all = boxes.fold(Bounds::EMPTY, Bounds::union);
        let reach = all.min.abs().max(all.max.abs()).max_element();

        let binary = build::grow(&mut items, cancel);
        if cancel.is_cancelled() {
            return None;
        }
        let (root, nodes, mut blocks) = collapse::collapse(&binary, &items, triangles);
        blocks.extend(others.chunks(LANES).map(|others| block(others, triangles)));
        (!cancel.is_cancelled()).then(|| Self {
            places: places(&blocks, triangles.len()),
            bounds,
            reach,
            root,
            nodes,
            blocks,
        })
    }

    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        simd::answer(&NearestHit {
            tree: self,
            ray,
            t_max,
        })
    }

    /// The nearest hit of each ray of `packet`, in their order.
    #[must_use]
    pub fn intersect_packet(&self, packet: &Packet<'_>) -> PacketHits {
        simd::answer(&packet::NearestHits { tree: self, packet })
    }

    /// Whether anything is hit with `0 < t < t_max`; stops at the first such hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        simd::answer(&AnyHit {
            tree: self,
            ray,
            t_max,
        })
    }

    /// Which rays of `fan` are occluded, as bits in their order.
    #[must_use]
    pub fn occluded_fan(&self, fan: &Fan<'_>) -> u64 {
        simd::answer(&fan::FanHits { tree: self, fan })
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.places.len()
    }

    /// The triangle with that position in the order given.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: usize) -> Triangle {
        let place = self.places[id] as usize;
        self.blocks[place / LANES].triangle(place % LANES)
    }

    /// The box around all triangles; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Memory of nodes, triangles and their places.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.blocks) + size_of_val(&*self.places)
    }
}

/// The block of at most eight items.
fn block(items: &[Item], triangles: &[Triangle]) -> TriangleBlock {
    let mut ids = [0; LANES];
    for (id, item) in ids.iter_mut().zip(items) {
        *id = item.triangle;
    }
    TriangleBlock::new(&ids[..items.len()], triangles)
}

/// Where in the blocks each of so many triangles is.
fn places(blocks: &[TriangleBlock], triangles: usize) -> Vec<u32> {
    let mut places = vec![0; triangles];
    let lanes = blocks.iter().flat_map(|block| block.ids);
    for (place, id) in lanes.enumerate() {
        if id != TriangleBlock::NO_TRIANGLE {
            places[id as usize] = number(place);
        }
    }
    places
}

fn number(index: usize) -> u32 {
    u32::try_from(index).expect("there are at most 2^29 triangles, and no more blocks")
}
