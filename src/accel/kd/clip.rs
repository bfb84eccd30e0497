//! The part of a triangle inside a box.

use crate::geometry::Triangle;
use crate::math::{Bounds, DVec3, Vec3};

/// Clips triangles to boxes; holds the polygons it works on.
#[derive(Default)]
pub(super) struct Clipper {
    polygon: Vec<DVec3>,
    next: Vec<DVec3>,
}

impl Clipper {
    /// A box around the part of `triangle` inside `region`, within `region`; empty only if they do not touch.
    ///
    /// This is Sutherland and Hodgman's clipping in `f64`. It rounds, so the region is first widened by far more than
    /// that rounding: where an edge leaves the widened region as computed, it has left the true one. The result is
    /// rounded outwards and cut back to `region`, so that exact coordinates stay exact.
    pub fn bounds(&mut self, triangle: &Triangle, region: &Bounds) -> Bounds {
        // A few dozen roundings of numbers as large as the corners.
        const MARGIN: f64 = f64::EPSILON * 64.0;
        let margin = DVec3::splat(magnitude(triangle) * MARGIN);
        let min = region.min.as_dvec3() - margin;
        let max = region.max.as_dvec3() + margin;
        let mut part = Bounds::EMPTY;
        for &vertex in self.polygon(triangle, min, max) {
            part.min = part
                .min
                .min((vertex - margin).as_vec3().map(f32::next_down));
            part.max = part.max.max((vertex + margin).as_vec3().map(f32::next_up));
        }
        part.intersection(*region)
    }

    /// The part of `triangle` inside a box, as computed; no vertices when there is none.
    pub fn polygon(&mut self, triangle: &Triangle, min: DVec3, max: DVec3) -> &[DVec3] {
        self.polygon.clear();
        self.polygon.extend(triangle.corners.map(Vec3::as_dvec3));
        for axis in 0..3 {
            self.keep(axis, min[axis], |x| x - min[axis]);
            self.keep(axis, max[axis], |x| max[axis] - x);
        }
        &self.polygon
    }

    /// Keeps the polygon's part on the side of the plane `x[axis] = position` where `height` is not negative.
    fn keep(&mut self, axis: usize, position: f64, height: impl Fn(f64) -> f64) {
        if self.polygon.iter().all(|v| height(v[axis]) >= 0.0) {
            return;
        }
        self.next.clear();
        let starts = self.polygon.iter().cycle().skip(self.polygon.len() - 1);
        for (&start, &end) in starts.zip(&self.polygon) {
            let (above_start, above_end) = (height(start[axis]), height(end[axis]));
            if (above_start < 0.0) != (above_end < 0.0) {
                let share = above_start / (above_start - above_end);
                let mut crossing = start + (end - start) * share;
                crossing[axis] = position;
                self.next.push(crossing);
            }
            if above_end >= 0.0 {
                self.next.push(end);
            }
        }
        std::mem::swap(&mut self.polygon, &mut self.next);
    }
}

/// The largest coordinate of a triangle, by magnitude.
pub(super) fn magnitude(triangle: &Triangle) -> f64 {
    let corners = triangle
        .corners
        .map(|corner| f64::from(corner.abs().max_element()));
    corners.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    #[test]
    fn a_corner_cut_off_leaves_a_tight_box() {
        let triangle = Triangle {
            corners: [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0],
        };
        let region = Bounds {
            min: Vec3::new(1.0, -1.0, -1.0),
            max: Vec3::new(2.0, 9.0, 1.0),
        };
        let part = Clipper::default().bounds(&triangle, &region);
        assert_eq!((part.min.x, part.max.x), (1.0, 2.0));
        let expected = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 3.0, 0.0)];
        assert!(
            (part.min - expected[0]).abs().max_element() < 1e-6,
            "{part:?}"
        );
        assert!(
            (part.max - expected[1]).abs().max_element() < 1e-6,
            "{part:?}"
        );
    }

    /// No point of the triangle inside the region may lie outside the result, or rays would miss it.
    #[test]
    fn the_box_holds_every_point_of_the_part() {
        let mut random = Random::new(1);
        let mut clipper = Clipper::default();
        let mut inside = 0;
        for i in 0..3000 {
            let mut point = || random.in_cube().as_vec3();
            let mut corners = [point(), point(), point()];
            if i % 3 == 0 {
                corners[2] = corners[1] + point() * 1e-6;
            }
            let region = Bounds::of_points([point(), point()]);
            let part = clipper.bounds(&Triangle { corners }, &region);
            assert!(part.is_empty() || region.contains(part.min) && region.contains(part.max));
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (min, max) = (region.min.as_dvec3(), region.max.as_dvec3());
            for _ in 0..100 {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let p = a + (b - a) * u + (c - a) * v;
                if min.cmple(p).all() && p.cmple(max).all() {
                    inside += 1;
                    let (least, most) = (part.min.as_dvec3(), part.max.as_dvec3());
                    assert!(
                        least.cmple(p).all() && p.cmple(most).all(),
                        "{p} of {corners:?}"
                    );
                }
            }
        }
        assert!(inside > 10_000, "only {inside} points");
    }
}
