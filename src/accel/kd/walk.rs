//! Following a ray through the cells of the tree.

use super::node::NodeKind;
use super::{KdTree, MAX_DEPTH};
use crate::accel::leaf::Visitor;
use crate::accel::query::Tree;
use crate::accel::simd::Simd;
use crate::accel::slabs::MARGIN;
use crate::math::Ray;

impl Tree for KdTree {
    #[inline(always)]
    fn walk<S: Simd, V: Visitor>(&self, _simd: S, ray: &Ray, t_max: f32, visitor: &mut V) {
        self.walk_within(ray, t_max, visitor, MARGIN);
    }
}

/// The tree with a walk that does not pay for rounding, to see that its mistakes are noticed.
#[cfg(test)]
pub(super) struct WithoutMargin<'a>(pub &'a KdTree);

#[cfg(test)]
impl Tree for WithoutMargin<'_> {
    #[inline(always)]
    fn walk<S: Simd, V: Visitor>(&self, _simd: S, ray: &Ray, t_max: f32, visitor: &mut V) {
        self.0.walk_within(ray, t_max, visitor, 0.0);
    }
}

impl KdTree {
    /// [`Tree::walk`]; inlined, so that `margin` is a constant.
    ///
    /// A distance that bounds a stretch of the ray is moved once by the margin, for the plane it came from and for the plane it
    /// will be compared with, so no hit near a plane can fall between two cells.
    ///
    /// Leaves come nearest first for every visitor. All comparisons are written so that NaN, from a ray within a plane (0 · ∞),
    /// visits both sides.
    #[inline(always)]
    fn walk_within<V: Visitor>(&self, ray: &Ray, t_max: f32, visitor: &mut V, margin: f32) {
        let origin = ray.origin.to_array();
        let direction = ray.direction.to_array();
        let inverse = direction.map(reciprocal);
        let backward = direction.map(|d| usize::from(d.is_sign_negative()));

        // The part of the ray inside the box of the scene.
        let mut enter = 0.0;
        let mut exit = later(t_max, margin);
        for axis in 0..3 {
            let ends = [self.bounds.min[axis], self.bounds.max[axis]]
                .map(|end| (end - origin[axis]) * inverse[axis]);
            enter = larger(earlier(ends[backward[axis]], margin), enter);
            exit = smaller(later(ends[1 - backward[axis]], margin), exit);
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
                        stack[waiting] = (far, larger(earlier(t, margin), enter), exit);
                        waiting += 1;
                        exit = smaller(later(t, margin), exit);
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
#[inline(always)]
fn earlier(t: f32, margin: f32) -> f32 {
    t * (1.0 - margin) - f32::MIN_POSITIVE
}

/// A bound that no hit at `t` or before it comes after, likewise.
#[inline(always)]
fn later(t: f32, margin: f32) -> f32 {
    t * (1.0 + margin) + f32::MIN_POSITIVE
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
