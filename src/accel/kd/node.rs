//! Nodes as they lie in memory.

use super::build::{self, CHUNK, Pieces};
use crate::accel::block::TriangleBlock;
use crate::accel::simd::LANES;
use crate::control::CancelToken;
use crate::geometry::Triangle;
use std::ops::Range;

/// A node in eight bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The bits of the plane's position, or a leaf's number of blocks.
    payload: u32,
    /// In the lower two bits the plane's axis, or 3 for a leaf. Above them the index of the first of the two children,
    /// which are neighbours, or of the leaf's first block.
    tag: u32,
}

/// A [`Node`] unpacked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NodeKind {
    Interior {
        axis: usize,
        position: f32,
        /// Index of the child on the smaller side; the other one follows it.
        children: usize,
    },
    Leaf {
        blocks: Range<usize>,
    },
}

impl Node {
    const LEAF: u32 = 3;

    pub fn interior(axis: usize, position: f32, children: usize) -> Self {
        Self {
            payload: position.to_bits(),
            tag: Self::tag(children, u32::try_from(axis).expect("an axis is 0, 1 or 2")),
        }
    }

    fn leaf(blocks: &Range<usize>) -> Self {
        Self {
            payload: u32::try_from(blocks.len())
                .expect("a leaf has fewer blocks than there are references"),
            tag: Self::tag(blocks.start, Self::LEAF),
        }
    }

    fn tag(index: usize, kind: u32) -> u32 {
        assert!(
            index < 1 << 30,
            "the reference budget keeps indices below 2^30"
        );
        u32::try_from(index).expect("checked above") << 2 | kind
    }

    #[inline]
    pub fn kind(self) -> NodeKind {
        let index = (self.tag >> 2) as usize;
        match self.tag & 3 {
            Self::LEAF => NodeKind::Leaf {
                blocks: index..index + self.payload as usize,
            },
            axis => NodeKind::Interior {
                axis: axis as usize,
                position: f32::from_bits(self.payload),
                children: index,
            },
        }
    }
}

/// Nodes and leaf blocks in the order of a depth-first walk, so that what is visited together lies together. `None` when
/// cancelled.
pub(super) fn packed(
    pieces: &Pieces,
    triangles: &[Triangle],
    cancel: &CancelToken,
) -> Option<(Vec<Node>, Vec<TriangleBlock>)> {
    let mut nodes = vec![Node::leaf(&(0..0))];
    let mut blocks = Vec::new();
    // Piece, index in the piece, index in `nodes`.
    let mut open = vec![(0, 0, 0)];
    while let Some((piece, index, slot)) = open.pop() {
        if slot % CHUNK == 0 && cancel.is_cancelled() {
            return None;
        }
        match &pieces.nodes[piece][index] {
            build::Node::Subtree(subtree) => open.push((*subtree, 0, slot)),
            build::Node::Leaf(ids) => {
                let first = blocks.len();
                let chunks = ids.chunks(LANES);
                blocks.extend(chunks.map(|ids| TriangleBlock::new(ids, triangles)));
                nodes[slot] = Node::leaf(&(first..blocks.len()));
            }
            &build::Node::Interior {
                axis,
                position,
                children,
            } => {
                let left = nodes.len();
                nodes.extend([nodes[slot]; 2]);
                nodes[slot] = Node::interior(axis, position, left);
                open.push((piece, children + 1, left + 1));
                open.push((piece, children, left));
            }
        }
    }
    Some((nodes, blocks))
}

/// Where each triangle is for the first time: eight times its block plus its lane. Those that are in no leaf get blocks of
/// their own.
pub(super) fn places(blocks: &mut Vec<TriangleBlock>, triangles: &[Triangle]) -> Vec<u32> {
    let mut places = vec![NOWHERE; triangles.len()];
    note_places(&mut places, blocks, 0);
    let ids = (0..).zip(&places);
    let others: Vec<u32> = ids
        .filter(|&(_, &place)| place == NOWHERE)
        .map(|(id, _)| id)
        .collect();
    let first = blocks.len();
    let chunks = others.chunks(LANES);
    blocks.extend(chunks.map(|ids| TriangleBlock::new(ids, triangles)));
    note_places(&mut places, &blocks[first..], first);
    places
}

/// No place.
const NOWHERE: u32 = u32::MAX;

/// Notes the places of triangles that have none yet; `first` is the index of the first of these blocks.
fn note_places(places: &mut [u32], blocks: &[TriangleBlock], first: usize) {
    let lanes = blocks.iter().flat_map(|block| block.ids);
    for (place, id) in (first * LANES..).zip(lanes) {
        if id != TriangleBlock::NO_TRIANGLE && places[id as usize] == NOWHERE {
            places[id as usize] = u32::try_from(place)
                .ok()
                .filter(|&place| place != NOWHERE)
                .expect("the reference budget keeps blocks below 2^29");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_survive_packing() {
        assert_eq!(size_of::<Node>(), 8);
        for index in [0, 1, (1 << 30) - 1] {
            for (axis, position) in [(0, -0.0), (1, 1.5), (2, f32::MIN_POSITIVE)] {
                let NodeKind::Interior {
                    axis: a,
                    position: p,
                    children,
                } = Node::interior(axis, position, index).kind()
                else {
                    panic!("an interior node came back as a leaf");
                };
                assert_eq!(
                    (a, p.to_bits(), children),
                    (axis, position.to_bits(), index)
                );
            }
            let blocks = index..index + 7;
            assert_eq!(Node::leaf(&blocks).kind(), NodeKind::Leaf { blocks });
        }
    }
}
