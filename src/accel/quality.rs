//! What a structure came out like, and what a ray meets in it: numbers to compare structures by, besides time.

use std::ops::AddAssign;

use super::leaf::{Counting, LeafTest, Nearest};
use super::query::CountVisits;
use super::simd::{self, LANES, Portable};
use super::{Accelerator, Assembly, BruteForce, Hit};
use crate::geometry::RayKernel;
use crate::math::Ray;

/// What a ray visits in a structure on its way to the answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Nodes with children: planes of a kd-tree, nodes of eight boxes of a wide tree, and boxes of placed copies.
    pub nodes: u64,
    /// Blocks of up to eight triangles, of whole leaves.
    pub blocks: u64,
}

impl AddAssign for Visits {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.blocks += other.blocks;
    }
}

/// Bytes that the search for the nearest hit keeps for counts, beside the ray's test and the best hit: as rendering asks, and as
/// [`Accelerator::visits`] asks.
#[must_use]
pub fn bytes_for_counts() -> [usize; 2] {
    type Looking<'a> = Nearest<'a, Portable>;
    let needed = size_of::<(LeafTest<'_, Portable>, Option<Hit>)>();
    [size_of::<Looking<'_>>(), size_of::<Counting<Looking<'_>>>()].map(|bytes| bytes - needed)
}

/// What a structure came out like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StructureQuality {
    /// Triangles stored; those of a shared mesh once.
    pub triangles: u64,
    /// Triangles in leaves, counted once per leaf.
    pub references: u64,
    /// Nodes with children: planes of a kd-tree, nodes of eight boxes of a wide tree.
    pub nodes: u64,
    /// Leaves, empty ones included.
    pub leaves: u64,
    /// Leaves without a triangle.
    pub empty_leaves: u64,
    /// Blocks of up to eight triangles in leaves.
    pub blocks: u64,
    /// Nodes above the deepest leaf.
    pub depth: u32,
    /// Expected cost of a random ray that passes the box around everything, by the surface area heuristic, in the
    /// structure's own unit: visiting one node, or testing one block by brute force. The tree over copies is left out.
    pub sah_cost: f64,
}

impl Accelerator {
    /// What [`Accelerator::intersect`], or [`Accelerator::occluded`] where `any_hit`, visits.
    #[must_use]
    pub fn visits(&self, ray: &Ray, t_max: f32, any_hit: bool) -> Visits {
        self.counted(ray, t_max, any_hit).0
    }

    /// [`Accelerator::intersect`], and what it visits.
    #[must_use]
    pub fn intersect_counting(&self, ray: &Ray, t_max: f32) -> (Visits, Option<Hit>) {
        self.counted(ray, t_max, false)
    }

    fn counted(&self, ray: &Ray, t_max: f32, any_hit: bool) -> (Visits, Option<Hit>) {
        match self {
            Self::Wide(tree) => simd::answer(&CountVisits {
                tree,
                ray,
                t_max,
                any_hit,
            }),
            Self::KdTree(tree) => simd::answer(&CountVisits {
                tree,
                ray,
                t_max,
                any_hit,
            }),
            Self::BruteForce(all) => {
                let hit = if any_hit {
                    None
                } else {
                    all.intersect(ray, t_max)
                };
                (all.visits_along(ray, t_max, any_hit), hit)
            }
        }
    }

    /// What the structure came out like.
    #[must_use]
    pub fn quality(&self) -> StructureQuality {
        match self {
            Self::Wide(tree) => tree.quality(),
            Self::KdTree(tree) => tree.quality(),
            Self::BruteForce(all) => all.quality(),
        }
    }
}

impl BruteForce {
    /// Eight triangles count as a block.
    fn visits_along(&self, ray: &Ray, t_max: f32, any_hit: bool) -> Visits {
        let kernel = RayKernel::new(ray);
        let hit = |triangle| kernel.intersect(triangle, t_max).is_some();
        let first_hit = any_hit.then(|| self.triangles().iter().position(hit));
        let tested = first_hit
            .flatten()
            .map_or(self.triangles().len(), |index| index + 1);
        Visits {
            nodes: 0,
            blocks: tested.div_ceil(LANES) as u64,
        }
    }

    fn quality(&self) -> StructureQuality {
        let triangles = self.triangles().len();
        let blocks = triangles.div_ceil(LANES);
        StructureQuality {
            triangles: triangles as u64,
            references: triangles as u64,
            nodes: 0,
            leaves: 1,
            empty_leaves: u64::from(triangles == 0),
            blocks: blocks as u64,
            depth: 0,
            sah_cost: blocks as f64,
        }
    }
}

impl Assembly {
    /// What all structures together came out like: each counts what it is made of once, and its cost as often as there are copies, by the
    /// chance that a ray passes the copy's box. The depth is that of the deepest.
    #[must_use]
    pub fn quality(&self) -> StructureQuality {
        let whole = super::half_area(&self.bounds());
        let chance = |area: f64| if whole > 0.0 { area / whole } else { 1.0 };
        let mut all = StructureQuality::default();
        for (structure, area) in self.structures_and_areas() {
            let quality = structure.quality();
            all.triangles += quality.triangles;
            all.references += quality.references;
            all.nodes += quality.nodes;
            all.leaves += quality.leaves;
            all.empty_leaves += quality.empty_leaves;
            all.blocks += quality.blocks;
            all.depth = all.depth.max(quality.depth);
            all.sah_cost += quality.sah_cost * chance(area);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::tests::{kd_tree, rays, scenes, wide_tree};

    fn structures(triangles: &[crate::geometry::Triangle]) -> [Accelerator; 3] {
        [
            Accelerator::Wide(wide_tree(triangles)),
            Accelerator::KdTree(kd_tree(triangles)),
            Accelerator::BruteForce(BruteForce::new(triangles.to_vec())),
        ]
    }

    #[test]
    fn no_hit_is_found_without_a_block_and_an_end_never_visits_more() {
        for (name, triangles) in scenes() {
            for structure in structures(&triangles) {
                let name = format!("{name}, {}", structure.name());
                for ray in rays(&triangles, 6).iter().step_by(7) {
                    let far = structure.visits(ray, f32::INFINITY, false);
                    let hit = structure.intersect(ray, f32::INFINITY);
                    assert!(hit.is_none() || far.blocks > 0, "{name}: {ray:?}");
                    let any = structure.visits(ray, f32::INFINITY, true);
                    assert!(hit.is_none() || any.blocks > 0, "{name}: {ray:?}");
                    if let Some(hit) = hit {
                        // All that lies beyond the hit is left out.
                        let up_to = structure.visits(ray, hit.t.next_up(), false);
                        assert!(up_to.nodes <= far.nodes, "{name}: {ray:?}");
                        assert!(up_to.blocks <= far.blocks, "{name}: {ray:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn quality_counts_every_triangle() {
        for (name, triangles) in scenes() {
            for structure in structures(&triangles) {
                let quality = structure.quality();
                let name = format!("{name}, {}: {quality:?}", structure.name());
                assert_eq!(quality.triangles, triangles.len() as u64, "{name}");
                assert!(quality.references >= quality.triangles, "{name}");
                let filled = quality.leaves - quality.empty_leaves;
                assert!(filled <= quality.blocks, "{name}");
                assert!(
                    quality.references <= LANES as u64 * quality.blocks,
                    "{name}"
                );
                // A node has two children, or up to eight.
                assert!(quality.nodes < quality.leaves, "{name}");
                let most = 8_u64.saturating_pow(quality.depth);
                assert!(quality.leaves <= most, "{name}");
                assert!(u64::from(quality.depth) <= quality.nodes, "{name}");
                assert!(
                    quality.sah_cost.is_finite() && quality.sah_cost >= 0.0,
                    "{name}"
                );
                if matches!(structure, Accelerator::BruteForce(_)) {
                    assert_eq!(quality.references, quality.triangles, "{name}");
                }
            }
        }
    }
}
