//! Counting what a ray visits, and what the tree is expected to cost.

use super::KdTree;
use crate::accel::block::{BlockFilter, TriangleBlock};
use crate::accel::{StructureQuality, Visits};
use crate::geometry::RayKernel;
use crate::math::Ray;

impl KdTree {
    /// What [`KdTree::intersect`], or [`KdTree::occluded`] where `any_hit`, visits.
    #[must_use]
    pub fn visits_along(&self, ray: &Ray, t_max: f32, any_hit: bool) -> Visits {
        let kernel = RayKernel::new(ray);
        let filter = BlockFilter::new(ray, &kernel);
        let mut visits = Visits::default();
        let mut nearest = t_max;
        let visit = |blocks: &[TriangleBlock]| {
            visits.blocks += blocks.len() as u64;
            for block in blocks {
                for lane in filter.may_hit(block) {
                    if let Some(hit) = kernel.intersect(&block.triangle(lane), t_max) {
                        nearest = nearest.min(hit.t);
                    }
                }
            }
            (!any_hit || nearest >= t_max).then_some(nearest)
        };
        let mut planes = 0;
        self.walk_past(ray, t_max, || planes += 1, visit);
        visits.nodes = planes;
        visits
    }

    /// Counts references and computes the expected cost, see [`KdTree::statistics`].
    #[must_use]
    pub fn quality(&self) -> StructureQuality {
        if self.triangle_count() == 0 {
            // Its box, which holds nothing, has no area to take a share of.
            return StructureQuality::default();
        }
        let statistics = self.statistics();
        StructureQuality {
            triangles: self.triangle_count() as u64,
            references: statistics.references as u64,
            sah_cost: statistics.sah_cost,
        }
    }
}
