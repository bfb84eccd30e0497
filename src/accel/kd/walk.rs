//! Following a ray through the cells of the tree.

use super::node::NodeKind;
use super::{KdTree, MAX_DEPTH};
use crate::accel::leaf::Visitor;
use crate::accel::query::Tree;
use crate::accel::simd::Simd;
use crate::accel::slabs::{MARGIN, later};
use crate::math::Ray;

impl Tree for KdTree {
    /// A distance that bounds a stretch of the ray is moved once by the margin, for the plane it came from and for the plane it
    /// will be compared with, so no hit near a plane can fall between two cells.
    ///
    /// Leaves come nearest first for every visitor. All comparisons are written so that NaN, from a ray within a plane (0 · ∞),
    /// visits both sides.
    #[inline(always)]
    fn walk<S: Simd, V: Visitor>(&self, _simd: S, ray: &Ray, t_max: f32, visitor: &mut V) {
        let origin = ray.origin.to_array();
        let direction = ray.direction.to_array();
        let inverse = direction.map(reciprocal);
        let backward = direction.map(|d| usize::from(d.is_sign_negative()));

        // The part of the ray inside the box of the scene.
        let mut enter = 0.0;
        let mut exit = later(t_max);
        for axis in 0..3 {
            let ends = [self.bounds.min[axis], self.bounds.max[axis]]
                .map(|end| (end - origin[axis]) * inverse[axis]);
            enter = larger(earlier(ends[backward[axis]]), enter);
            exit = smaller(later(ends[1 - backward[axis]]), exit);
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
                    visitor.enter_node();
                    let t = (position - origin[axis]) * inverse[axis];
                    let near = children + backward[axis];
                    let far = children + 1 - backward[axis];
                    // The plane lies before the cell's stretch of the ray, beyond it, or within it.
                    if t < enter {
                        index = far;
                    } else if t > exit {
                        index = near;
                    } else {
                        stack[waiting] = (far, larger(earlier(t), enter), exit);
                        waiting += 1;
                        exit = smaller(later(t), exit);
                        index = near;
                    }
                }
                NodeKind::Leaf { blocks } => {
                    // The margin of `enter` covers the rounding of a hit's distance, too.
                    let Some(limit) = visitor.visit(&self.blocks[blocks]) else {
                        return;
                    };
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

/// `1 / d`; infinite for zeros. NaN, which visits both sides of every plane, where the result would lack digits.
fn reciprocal(d: f32) -> f32 {
    let inverse = d.recip();
    if inverse.is_normal() || d == 0.0 {
        inverse
    } else {
        f32::NAN
    }
}

/// A bound that no hit at `t` or after it comes before. The smallest normal number stands in for digits lost below it.
#[inline]
fn earlier(t: f32) -> f32 {
    t * (1.0 - MARGIN) - f32::MIN_POSITIVE
}

/// The smaller number; `old` if `new` is NaN.
#[inline]
fn smaller(new: f32, old: f32) -> f32 {
    if new < old { new } else { old }
}

/// The larger number; `old` if `new` is NaN.
#[inline]
fn larger(new: f32, old: f32) -> f32 {
    if new > old { new } else { old }
}
