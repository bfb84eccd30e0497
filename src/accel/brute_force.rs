//! Intersection without a tree, in time proportional to the number of triangles: the reference that both trees must agree with,
//! bit for bit.

use super::{Hit, assert_ids_suffice};
use crate::geometry::{RayKernel, Triangle};
use crate::math::{Bounds, Ray};

/// The reference: tests every triangle with the full kernel, with no tree and no filter that could be wrong.
#[derive(Clone, Debug)]
pub struct BruteForce {
    triangles: Vec<Triangle>,
    bounds: Bounds,
}

impl BruteForce {
    /// The reference over `triangles`.
    ///
    /// # Panics
    /// When there are more than 2³² − 2 triangles.
    #[must_use]
    pub fn new(triangles: Vec<Triangle>) -> Self {
        assert_ids_suffice(&triangles);
        let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
        Self { triangles, bounds }
    }

    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        let kernel = RayKernel::new(ray);
        let mut best = None;
        for (id, triangle) in (0..).zip(&self.triangles) {
            if let Some(new) = kernel.intersect(triangle, t_max) {
                best = Some(Hit::nearer(best, id, new));
            }
        }
        best
    }

    /// Whether anything is hit with `0 < t < t_max`.
    #[must_use]
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        let kernel = RayKernel::new(ray);
        let hit = |triangle| kernel.intersect(triangle, t_max).is_some();
        self.triangles.iter().any(hit)
    }

    /// The triangles in the order given.
    #[must_use]
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The box around all triangles; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}
