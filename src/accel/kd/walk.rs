//! Following a ray through the cells of the tree.

use super::node::NodeKind;
use super::{KdTree, MAX_DEPTH};
use crate::accel::block::TriangleBlock;
use crate::math::Ray;

/// Bound on the relative error of a computed distance to a plane: a difference, a reciprocal, a product and the product
/// with this bound, at half an [`f64::EPSILON`] each, doubled.
///
/// Cells are walked as if each plane were this much thicker, so no hit near a plane falls between two cells.
/// Source: Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013, for boxes; here for planes, and in `f64`.
const PLANE_ERROR: f64 = 4.0 * f64::EPSILON;

impl KdTree {
    /// Visits the leaves whose cells `ray` passes in `0 < t < t_max`, nearest first, until they begin beyond the `t` that
    /// the last call of `visit` returned.
    ///
    /// All comparisons are written so that NaN, from a ray within a plane (0 · ∞), visits both sides.
    #[inline]
    pub(super) fn walk(
        &self,
        ray: &Ray,
        t_max: f32,
        mut visit: impl FnMut(&[TriangleBlock]) -> f32,
    ) {
        let origin = ray.origin.as_dvec3().to_array();
        let direction = ray.direction.as_dvec3().to_array();
        let inverse = direction.map(f64::recip);
        let backward = direction.map(|d| usize::from(d.is_sign_negative()));

        // The part of the ray inside the box of the scene.
        let mut enter = 0.0;
        let mut exit = not_before(t_max);
        for axis in 0..3 {
            let ends = [self.bounds.min[axis], self.bounds.max[axis]]
                .map(|end| (f64::from(end) - origin[axis]) * inverse[axis]);
            let first = ends[backward[axis]] * (1.0 - PLANE_ERROR);
            let last = ends[1 - backward[axis]] * (1.0 + PLANE_ERROR);
            enter = if first > enter { first } else { enter };
            exit = if last < exit { last } else { exit };
        }
        if enter > exit {
            return;
        }

        let mut stack = [(0_usize, 0.0, 0.0); MAX_DEPTH as usize];
        let mut waiting = 0;
        let mut index = 0;
        loop {
            match self.nodes[index].kind() {
                NodeKind::Interior {
                    axis,
                    position,
                    children,
                } => {
                    let t = (f64::from(position) - origin[axis]) * inverse[axis];
                    let (first, last) = (t * (1.0 - PLANE_ERROR), t * (1.0 + PLANE_ERROR));
                    let near = children + backward[axis];
                    let far = children + 1 - backward[axis];
                    // The plane lies behind the cell's stretch of the ray, beyond it, or within it.
                    if last < enter {
                        index = far;
                    } else if first > exit {
                        index = near;
                    } else {
                        stack[waiting] = (far, if first > enter { first } else { enter }, exit);
                        waiting += 1;
                        exit = if last < exit { last } else { exit };
                        index = near;
                    }
                }
                NodeKind::Leaf { blocks } => {
                    let limit = not_before(visit(&self.blocks[blocks]));
                    loop {
                        if waiting == 0 {
                            return;
                        }
                        waiting -= 1;
                        (index, enter, exit) = stack[waiting];
                        if enter <= limit {
                            break;
                        }
                    }
                }
            }
        }
    }
}

/// A bound on the exact distance of a hit whose rounded distance is `t`; see [`crate::geometry::RayKernel::intersect`].
fn not_before(t: f32) -> f64 {
    f64::from(t.next_up())
}
