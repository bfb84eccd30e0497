//! The wide tree: nodes of eight boxes around blocks of eight triangles, so that one step tests eight of either at once.
//!
//! A binary tree is grown by the surface area heuristic and folded into wide nodes in the way that costs least by the same
//! heuristic. A set of triangles is divided by objects, each to one side, or where these overlap much by a plane that cuts
//! triangles in two: then a triangle is in several leaves, in boxes around its parts. What a box says of the triangles in it
//! holds exactly or is rounded outwards, and distances to boxes are compared with a margin for their rounding, so no ray
//! misses a hit.

mod binning;
mod bins;
mod build;
mod clip;
mod collapse;
mod fan;
mod forest;
mod item;
mod node;
mod packet;
mod packet_rays;
mod parted;
mod quality;
mod span;
mod spatial;
mod split;
mod stack;
mod sweep;
#[cfg(test)]
mod tests;
mod validate;
mod walk;

use super::Hit;
use super::block::TriangleBlock;
use super::boxes::{self, Cell, Division, LevelBoxes};
use super::fan::Fan;
use super::packet::{Packet, PacketHits};
use super::query::{AnyHit, NearestHit};
use super::simd::{self, LANES};
use crate::control::{CancelToken, Progress};
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray, Vec3};
use build::Job;
use item::{Extent, Item};
use node::{Child, ChildKind, Node};
use rayon::prelude::*;
use split::{CHUNK, folded};
use std::sync::atomic::{AtomicU32, Ordering};

/// Triangles are counted in 29 bits, and so are blocks.
const MAX_TRIANGLES: usize = 1 << 29;

/// Triangles per leaf.
const LARGEST_LEAF: usize = 2 * LANES;

/// How many references cutting may add per ten triangles. With so many, soups of all kinds take less than 80 bytes per triangle: 76 to 79,
/// where those that no plane cuts take 48.
const ADDED_PER_TEN: usize = 7;

/// How much time building takes, and how good the tree becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// For pictures: sets are divided along the best of all axes, and triangles are cut where that makes rays faster.
    #[default]
    Best,
    /// For scenes that change all the time: sets are divided along their longest side, and no triangle is cut.
    Fast,
}

impl BuildQuality {
    /// The axes along which divisions of a set of that size are tried.
    fn axes(self, size: Vec3) -> &'static [usize] {
        match self {
            Self::Best => &[0, 1, 2],
            Self::Fast => [&[0], &[1], &[2]][size.max_position()],
        }
    }

    /// How many references cutting may add per ten triangles.
    fn added_per_ten(self) -> usize {
        match self {
            Self::Best => ADDED_PER_TEN,
            Self::Fast => 0,
        }
    }
}

/// The tree of eight-wide nodes.
#[derive(Clone, Debug)]
pub struct WideTree {
    /// Where each triangle is, in the first of its leaves: eight times its block plus its lane. There is no other list of them.
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
    /// Builds the tree; `None` when cancelled. The result depends on triangles and quality alone, not on the number of threads.
    /// `progress` advances by the number of triangles altogether.
    ///
    /// Takes time in proportion to `n log n` for any `n` triangles, to which leaves refer at most 1.8 n times. Those that are
    /// not finite, which no ray hits, are in no leaf.
    ///
    /// # Panics
    /// When there are more than 2²⁹ triangles.
    #[must_use]
    pub fn build(
        triangles: &[Triangle],
        quality: BuildQuality,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        Self::build_adding(
            triangles,
            quality,
            quality.added_per_ten(),
            cancel,
            progress,
        )
    }

    /// [`Self::build`], where cutting may add that many references per ten triangles.
    fn build_adding(
        triangles: &[Triangle],
        quality: BuildQuality,
        added_per_ten: usize,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        assert!(
            triangles.len() <= MAX_TRIANGLES,
            "{} triangles are more than 2^29",
            triangles.len()
        );
        let Gathered {
            bounds,
            items,
            others,
        } = Gathered::from(triangles, cancel)?;
        let all = folded(cancel, &items, |items| Extent::around(items), Extent::grow);
        let reach = all.low.abs().max(all.high.abs()).truncate().max_element();
        progress.advance(others.len() as u64);
        let job = Job {
            triangles,
            quality,
            cancel,
            progress,
        };
        let most_added = items.len() / 10 * added_per_ten;
        let forest = build::grow(&job, items, all, most_added);
        if cancel.is_cancelled() {
            return None;
        }
        let (root, nodes, mut blocks) = collapse::collapse(&forest, triangles, cancel);
        if cancel.is_cancelled() {
            return None;
        }
        let others = others.chunks(LANES);
        blocks.extend(others.map(|others| TriangleBlock::new(others, triangles)));
        let places = places(&blocks, triangles.len());
        (!cancel.is_cancelled()).then_some(Self {
            places,
            bounds,
            reach,
            root,
            nodes,
            blocks,
        })
    }

    /// The same, below one more node: what it would be as a tree, where all triangles are in one leaf. To measure that.
    ///
    /// # Panics
    /// When there are nodes already.
    #[must_use]
    pub fn below_a_node(mut self) -> Self {
        assert!(self.nodes.is_empty(), "all triangles are in one leaf");
        let mut node = Node::EMPTY;
        node.set(0, &self.bounds, self.root);
        self.nodes.push(node);
        self.root = Child::node(0);
        self
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
    pub fn intersect_packet(&self, packet: &Packet) -> PacketHits {
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

    /// The boxes of nodes and leaves below so many nodes, and of leaves above; at most `most`.
    pub(super) fn boxes_at(&self, depth: u32, most: usize) -> LevelBoxes {
        let root = Cell {
            node: self.root,
            bounds: self.bounds,
        };
        boxes::gather(root, (depth, most), |cell, parts| match cell.node.kind() {
            ChildKind::Leaf(blocks) if blocks.is_empty() => Division::Empty,
            ChildKind::Leaf(_) => Division::Whole,
            ChildKind::Node(index) => {
                let node = &self.nodes[index];
                let children = node.children.iter().enumerate();
                parts.extend(children.map(|(lane, &child)| Cell {
                    node: child,
                    bounds: node.bounds(lane),
                }));
                Division::Divided
            }
        })
    }

    /// Memory of nodes, triangles and their places.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.blocks) + size_of_val(&*self.places)
    }
}

/// What the builder starts from.
struct Gathered {
    /// Around all triangles.
    bounds: Bounds,
    /// The finite triangles.
    items: Vec<Item>,
    /// Ids of the others.
    others: Vec<u32>,
}

impl Gathered {
    /// `None` when cancelled.
    fn from(triangles: &[Triangle], cancel: &CancelToken) -> Option<Self> {
        /// Triangles between two looks at the cancel token.
        const SLAB: usize = 1 << 20;
        let is_finite = |triangle: &Triangle| triangle.corners.iter().all(|c| c.is_finite());
        let around = |triangles: &[Triangle]| {
            Bounds::of_points(triangles.iter().flat_map(|triangle| triangle.corners))
        };
        let mut bounds = Bounds::EMPTY;
        let mut items = Vec::with_capacity(triangles.len());
        let mut all_finite = true;
        for slab in triangles.chunks(SLAB) {
            if cancel.is_cancelled() {
                return None;
            }
            let boxes = slab.par_chunks(CHUNK).map(around);
            bounds = bounds.union(boxes.reduce(|| Bounds::EMPTY, Bounds::union));
            all_finite &= slab.par_iter().all(is_finite);
            let first = items.len();
            let slab = slab.par_iter().enumerate();
            items.par_extend(slab.map(|(i, triangle)| Item::new(triangle, number(first + i))));
        }
        let mut others = Vec::new();
        if !all_finite {
            items.retain(|item: &Item| {
                let id = item.triangle();
                let is_finite = is_finite(&triangles[id as usize]);
                if !is_finite {
                    others.push(id);
                }
                is_finite
            });
        }
        Some(Self {
            bounds,
            items,
            others,
        })
    }
}

/// Where in the blocks each of so many triangles is; the first place of those in several.
fn places(blocks: &[TriangleBlock], triangles: usize) -> Vec<u32> {
    let mut places = Vec::new();
    places.resize_with(triangles, || AtomicU32::new(u32::MAX));
    blocks.par_iter().enumerate().for_each(|(index, block)| {
        for (lane, &id) in block.ids.iter().enumerate() {
            if id != TriangleBlock::NO_TRIANGLE {
                places[id as usize].fetch_min(number(index * LANES + lane), Ordering::Relaxed);
            }
        }
    });
    places.into_iter().map(AtomicU32::into_inner).collect()
}

fn number(index: usize) -> u32 {
    u32::try_from(index).expect("there are at most 2^29 triangles, and no more blocks")
}
