//! Finding what a ray hits among many triangles: the wide tree, which is the fastest, the kd-tree, and brute force as
//! their reference.
//!
//! All answer with the same bits: which hit is nearest is decided by the shared kernel's `t`, then by the smaller
//! triangle id, never by the structure. Triangles and rays live in the prepared scene; ids are positions in the order
//! the triangles were given in.
//!
//! An [`Accelerator`] is a structure over the triangles of one mesh. An [`Assembly`] is what rays of a scene meet: one such
//! structure over everything that occurs once, and placed copies of shared ones.

mod assembly;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod block;
mod box_tree;
mod boxes;
mod brute_force;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod fan;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod full;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod kd;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod leaf;
mod packet;
mod placed;
mod quality;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod query;
#[expect(clippy::inline_always, reason = "its documentation says why")]
mod simd;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod slabs;
#[cfg(test)]
mod tests;
#[expect(clippy::inline_always, reason = "`simd` says why")]
mod wide;

pub use assembly::{Assembly, Copies, Part};
pub use box_tree::BoxTree;
pub use boxes::LevelBoxes;
pub use brute_force::BruteForce;
pub use fan::Fan;
pub use kd::{KdParameters, KdStatistics, KdTree};
pub use packet::{Packet, PacketHits};
pub use placed::{AimingError, PlacedTriangle};
pub use quality::{StructureQuality, Visits, bytes_for_counts};
pub use wide::{BuildQuality, WideTree};

use std::ops::Range;

use crate::geometry::{Triangle, TriangleHit};
use crate::math::{Bounds, Ray};

/// The nearest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in multiples of the ray's direction.
    pub t: f32,
    /// Index of the triangle in the order given to the builder.
    pub triangle: u32,
    /// Weights of the triangle's three corners at the hit point: none negative, sum 1 up to rounding.
    pub barycentrics: [f32; 3],
}

impl Hit {
    /// The nearer of a hit so far and a new one; the smaller id among equals, so that no order of tests matters.
    fn nearer(best: Option<Self>, id: u32, new: TriangleHit) -> Self {
        match best {
            Some(best) if best.t < new.t || (best.t <= new.t && best.triangle < id) => best,
            _ => Self {
                t: new.t,
                triangle: id,
                barycentrics: new.barycentrics,
            },
        }
    }
}

/// A structure over triangles that answers ray queries.
#[derive(Clone, Debug)]
pub enum Accelerator {
    /// The tree of eight-wide nodes.
    Wide(WideTree),
    /// The surface area heuristic kd-tree.
    KdTree(KdTree),
    /// Every triangle, one after the other.
    BruteForce(BruteForce),
}

impl Accelerator {
    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        match self {
            Self::Wide(tree) => tree.intersect(ray, t_max),
            Self::KdTree(tree) => tree.intersect(ray, t_max),
            Self::BruteForce(all) => all.intersect(ray, t_max),
        }
    }

    /// The nearest hit of each ray of `packet`, in their order: [`Self::intersect`] of each, but faster.
    #[must_use]
    #[inline]
    pub fn intersect_packet(&self, packet: &Packet) -> PacketHits {
        match self {
            Self::Wide(tree) => tree.intersect_packet(packet),
            Self::KdTree(tree) => packet.each(|ray, t_max| tree.intersect(ray, t_max)),
            Self::BruteForce(all) => packet.each(|ray, t_max| all.intersect(ray, t_max)),
        }
    }

    /// Whether anything is hit with `0 < t < t_max`; stops at the first such hit.
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        match self {
            Self::Wide(tree) => tree.occluded(ray, t_max),
            Self::KdTree(tree) => tree.occluded(ray, t_max),
            Self::BruteForce(all) => all.occluded(ray, t_max),
        }
    }

    /// Which rays of `fan` are occluded, as bits in their order: [`Self::occluded`] of each up to 1, but faster.
    #[must_use]
    #[inline]
    pub fn occluded_fan(&self, fan: &Fan<'_>) -> u64 {
        match self {
            Self::Wide(tree) => tree.occluded_fan(fan),
            Self::KdTree(tree) => fan.each(|ray| tree.occluded(ray, 1.0)),
            Self::BruteForce(all) => fan.each(|ray| all.occluded(ray, 1.0)),
        }
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        match self {
            Self::Wide(tree) => tree.triangle_count(),
            Self::KdTree(tree) => tree.triangle_count(),
            Self::BruteForce(all) => all.triangles().len(),
        }
    }

    /// The triangle with that position in the order given.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: usize) -> Triangle {
        match self {
            Self::Wide(tree) => tree.triangle(id),
            Self::KdTree(tree) => tree.triangle(id),
            Self::BruteForce(all) => all.triangles()[id],
        }
    }

    /// The triangles in the order given.
    #[must_use]
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = Triangle> {
        (0..self.triangle_count()).map(|id| self.triangle(id))
    }

    /// The box around all triangles; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Wide(tree) => tree.bounds(),
            Self::KdTree(tree) => tree.bounds(),
            Self::BruteForce(all) => all.bounds(),
        }
    }

    /// The structure without the triangles `ids`, which are still counted, and one of these alone, numbered from 0: made of this one,
    /// which is quicker than building. `None` where the kind of structure does not lend itself to that.
    #[must_use]
    pub fn parted(&self, ids: &Range<u32>) -> Option<[Self; 2]> {
        let Self::Wide(tree) = self else {
            return None;
        };
        Some([tree.without(ids), tree.only(ids)].map(Self::Wide))
    }

    /// The structure's name as people write it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Wide(_) => "wide",
            Self::KdTree(_) => "kd-tree",
            Self::BruteForce(_) => "brute-force",
        }
    }

    /// Memory the structure takes, with the triangles.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Wide(tree) => tree.bytes(),
            Self::KdTree(tree) => tree.bytes(),
            Self::BruteForce(all) => size_of_val(all.triangles()),
        }
    }
}

/// Triangle ids are `u32`, and one value is kept for "none".
///
/// # Panics
/// When there are more triangles than ids.
fn assert_ids_suffice(triangles: &[Triangle]) {
    assert!(
        u32::try_from(triangles.len()).is_ok_and(|count| count < u32::MAX),
        "{} triangles are more than 2^32 - 2",
        triangles.len()
    );
}

/// Half the surface area of a box, in `f64` so that small boxes keep theirs.
fn half_area(bounds: &Bounds) -> f64 {
    let size = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    size.x * size.y + size.y * size.z + size.z * size.x
}
