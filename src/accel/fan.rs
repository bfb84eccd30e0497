//! Rays from one point: what is in the way of any of them is looked for once.
//!
//! Where many rays leave a surface point, to the points of a light or into the hemisphere, most of the scene is out of reach of
//! all of them: beside the span of their directions, or behind the surface they leave. A [`FanCull`] tells, for certain, what
//! is. So a walk for the whole fan leaves few triangles, often none, and the answer is that of one ray after the other.

use super::block::TriangleBlock;
use super::simd::{LaneSet, Lanes, Simd, splat_all};
use super::slabs::{MARGIN, later, reciprocal};
use crate::math::robust::gamma;
use crate::math::{Bounds, Ray, Vec3};

/// Rays from a common origin that end where their parameter is 1.
#[derive(Clone, Copy, Debug)]
pub struct Fan<'a> {
    origin: Vec3,
    normal: Vec3,
    directions: &'a [Vec3],
}

impl<'a> Fan<'a> {
    /// The most rays of a fan.
    pub const MOST_RAYS: usize = 64;

    /// Rays from `origin` to `origin + direction` for each of `directions`, none of them zero. Most of them should lead to the
    /// side that `normal`, of any length, points to.
    ///
    /// # Panics
    /// When there are more than [`Fan::MOST_RAYS`].
    #[must_use]
    pub fn new(origin: Vec3, normal: Vec3, directions: &'a [Vec3]) -> Self {
        assert!(directions.len() <= Self::MOST_RAYS, "too many rays");
        Self {
            origin,
            normal,
            directions,
        }
    }

    /// Where all rays start.
    #[inline(always)]
    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Ray number `index`.
    #[inline(always)]
    pub(super) fn ray(&self, index: usize) -> Ray {
        Ray::new(self.origin, self.directions[index])
    }

    /// The rays, in the order of the directions.
    #[must_use]
    pub fn rays(&self) -> impl ExactSizeIterator<Item = Ray> {
        self.directions
            .iter()
            .map(|&direction| Ray::new(self.origin, direction))
    }

    /// A box around all rays.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        // Rounded sums: a last digit further out is enough.
        let ends = self.directions.iter().map(|&d| self.origin + d);
        let rounded = Bounds::of_points(ends);
        let all = Bounds {
            min: rounded.min.map(f32::next_down),
            max: rounded.max.map(f32::next_up),
        };
        all.union(Bounds::of_points([self.origin]))
    }

    /// The rays of which `occluded` holds, as bits.
    #[must_use]
    pub fn each(&self, occluded: impl Fn(&Ray) -> bool) -> u64 {
        let mut bits = 0;
        for (index, ray) in self.rays().enumerate() {
            bits |= u64::from(occluded(&ray)) << index;
        }
        bits
    }

    /// The rays that lead to the side of the normal for certain, as bits.
    pub(super) fn rising(&self) -> u64 {
        self.each(|ray| {
            let products = self.normal * ray.direction;
            // Three products and two sums are rounded, and so is the bound.
            products.element_sum() > products.abs().element_sum() * gamma(8)
        })
    }

    /// The least and the greatest coordinates of the directions of the rays in `bits`, at least one.
    #[inline(always)]
    fn span(&self, bits: u64) -> (Vec3, Vec3) {
        let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (index, &direction) in self.directions.iter().enumerate() {
            if bits >> index & 1 != 0 {
                least = least.min(direction);
                most = most.max(direction);
            }
        }
        (least, most)
    }
}

/// A bound on where some rays of a fan are along one axis, by one side of a box.
#[derive(Clone, Copy, Debug)]
struct Limit<S: Simd> {
    /// By how much the parameter grows per distance of that side from the origin; NaN where it bounds nothing.
    per_length: S::F32x8,
    /// Whether the rays are before the box until there, or beyond it from there on.
    is_entry: bool,
}

impl<S: Simd> Limit<S> {
    /// The limit by one side of boxes, as a ray meets it that goes along the axis as `direction` says; `is_entry_if_positive`: whether rays
    /// are before the box until then, if `direction` is positive.
    #[inline(always)]
    fn new(simd: S, direction: f32, is_entry_if_positive: bool) -> Self {
        let is_entry = (direction > 0.0) == is_entry_if_positive;
        let inverse = if direction == 0.0 {
            f32::NAN
        } else {
            reciprocal(direction)
        };
        let margin = if is_entry { 1.0 - MARGIN } else { 1.0 + MARGIN };
        Self {
            per_length: simd.splat(inverse * margin),
            is_entry,
        }
    }
}

/// Tells what no ray of a fan, or of a part of it that rises, can meet.
///
/// Along each axis the rays are, at parameter t, between t times the least and t times the greatest of their directions. They
/// can meet a box only where that span meets the box's along all axes at once: the slab test of one ray, with intervals in
/// place of numbers. Rounding is paid for as in that test.
pub(super) struct FanCull<S: Simd> {
    simd: S,
    origin: [S::F32x8; 3],
    /// By axis, then by the lower and the upper side of boxes.
    limits: [[Limit<S>; 2]; 3],
    normal: [S::F32x8; 3],
    /// Which side of a box is farther along the normal: 1 for the upper.
    farther: [usize; 3],
}

impl<S: Simd> FanCull<S> {
    /// For the rays of `fan` in `bits`, all of them rising; for boxes whose coordinates are at most `reach` in magnitude. `None` where
    /// differences between coordinates may overflow.
    #[inline(always)]
    pub fn new(simd: S, fan: &Fan<'_>, bits: u64, reach: f32) -> Option<Self> {
        if !(fan.origin.abs().max_element() + reach).is_finite() {
            return None;
        }
        let (least, most) = fan.span(bits);
        let (least, most) = (least.to_array(), most.to_array());
        // Rays have passed the lower side where the greatest direction has, and the upper side where the least one has.
        let axis = |axis: usize| (least[axis], most[axis]);
        let [x, y, z] = [axis(0), axis(1), axis(2)];
        Some(Self {
            simd,
            origin: splat_all(simd, fan.origin.to_array()),
            limits: [
                [Limit::new(simd, x.1, true), Limit::new(simd, x.0, false)],
                [Limit::new(simd, y.1, true), Limit::new(simd, y.0, false)],
                [Limit::new(simd, z.1, true), Limit::new(simd, z.0, false)],
            ],
            normal: splat_all(simd, fan.normal.to_array()),
            farther: fan.normal.to_array().map(|n| usize::from(n > 0.0)),
        })
    }

    /// Which of eight boxes, given by axis and then by their lower and upper sides, the rays may meet.
    #[inline(always)]
    pub fn may_meet(&self, planes: &[[Lanes; 2]; 3]) -> LaneSet {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.splat(later(1.0));
        let mut height = simd.splat(0.0);
        let mut magnitude = simd.splat(0.0);
        for (axis, [lower, upper]) in planes.iter().enumerate() {
            let lower = simd.sub(simd.load(lower), self.origin[axis]);
            let upper = simd.sub(simd.load(upper), self.origin[axis]);
            let [by_lower, by_upper] = &self.limits[axis];
            (start, end) = self.limited(by_lower, lower, start, end);
            (start, end) = self.limited(by_upper, upper, start, end);
            let farther = if self.farther[axis] == 1 {
                upper
            } else {
                lower
            };
            (height, magnitude) = self.raised(axis, farther, height, magnitude);
        }
        let end = simd.add(end, simd.splat(f32::MIN_POSITIVE));
        let met = simd.less_or_equal(start, end);
        met.and_not(self.is_below(height, magnitude))
    }

    /// Which of a block's triangles the rays may meet: those not behind the surface that the rays leave.
    #[inline(always)]
    pub fn may_meet_triangles(&self, block: &TriangleBlock) -> LaneSet {
        let below = self.corner_is_below(&block.corners[0]);
        let below = below.and(self.corner_is_below(&block.corners[1]));
        let below = below.and(self.corner_is_below(&block.corners[2]));
        block.occupied(self.simd).and_not(below)
    }

    #[inline(always)]
    fn corner_is_below(&self, corner: &[Lanes; 3]) -> LaneSet {
        let simd = self.simd;
        let (mut height, mut magnitude) = (simd.splat(0.0), simd.splat(0.0));
        for (axis, lanes) in corner.iter().enumerate() {
            let offset = simd.sub(simd.load(lanes), self.origin[axis]);
            (height, magnitude) = self.raised(axis, offset, height, magnitude);
        }
        self.is_below(height, magnitude)
    }

    #[inline(always)]
    fn limited(
        &self,
        limit: &Limit<S>,
        offset: S::F32x8,
        start: S::F32x8,
        end: S::F32x8,
    ) -> (S::F32x8, S::F32x8) {
        let parameter = self.simd.mul(offset, limit.per_length);
        if limit.is_entry {
            (self.simd.larger(parameter, start), end)
        } else {
            (start, self.simd.smaller(parameter, end))
        }
    }

    /// Adds what `offset` from the origin along an axis raises a point along the normal, and its magnitude.
    #[inline(always)]
    fn raised(
        &self,
        axis: usize,
        offset: S::F32x8,
        height: S::F32x8,
        magnitude: S::F32x8,
    ) -> (S::F32x8, S::F32x8) {
        let simd = self.simd;
        let product = simd.mul(offset, self.normal[axis]);
        (
            simd.add(height, product),
            simd.add(magnitude, simd.abs(product)),
        )
    }

    /// Where a height is negative for certain: a difference, a product and three sums of it are rounded, and so is the bound.
    /// Where numbers overflow or vanish it is nowhere.
    #[inline(always)]
    fn is_below(&self, height: S::F32x8, magnitude: S::F32x8) -> LaneSet {
        let simd = self.simd;
        let error = simd.mul_add(
            magnitude,
            simd.splat(gamma(12)),
            simd.splat(f32::MIN_POSITIVE),
        );
        simd.less(simd.add(height, error), simd.splat(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BruteForce;
    use crate::accel::tests::{narrowed, scenes, trees, whole};
    use crate::geometry::Triangle;
    use crate::geometry::shapes::Random;
    use crate::math::{DVec3, robust};

    /// Directions from one point: into the hemisphere over `normal`, towards what `aim` spans, along axes, below the surface.
    fn fan_directions(random: &mut Random, kind: usize, normal: Vec3, aim: Vec3) -> Vec<Vec3> {
        let count = 1 + whole(random) % Fan::MOST_RAYS;
        let length = 2_f32.powi(i32::try_from(whole(random) % 12).unwrap() - 8);
        let mut direction = |index: usize| {
            let any = narrowed(random.in_cube());
            let above = if any.dot(normal) < 0.0 { -any } else { any };
            match kind {
                0 => above * length,
                1 => aim + any * 0.1 * length,
                2 => aim,
                3 if index.is_multiple_of(5) => any * length,
                // Along the surface but for a last digit.
                3 => above.reject_from_normalized(normal) + normal * 1e-7,
                _ => Vec3::AXES[index % 3] * length,
            }
        };
        let directions = (0..count).map(&mut direction);
        directions.filter(|&d| d != Vec3::ZERO).collect()
    }

    /// From points on triangles, lifted or not, and from anywhere: every ray of a fan is answered as alone by brute force.
    #[test]
    fn fans_are_answered_as_ray_by_ray() {
        let (mut occluded, mut free) = (0, 0);
        for (name, triangles) in scenes() {
            let all = BruteForce::new(triangles.clone());
            let trees = trees(&triangles);
            let mut random = Random::new(31);
            for turn in 0..if triangles.is_empty() { 5 } else { 120 } {
                let index = whole(&mut random) % triangles.len().max(1);
                let from = triangles.get(index).copied().unwrap_or(Triangle {
                    corners: [Vec3::X, Vec3::Y, Vec3::Z],
                });
                let [u, v] = [random.unit(), random.unit()].map(|x| DVec3::splat(x).as_vec3().x);
                let (point, error) = from.point([1.0 - u, u * (1.0 - v), u * v]);
                let normal = from.normal();
                let size = from.bounds().size().max_element();
                let origin = match turn % 3 {
                    0 => point,
                    1 => robust::offset_origin(point, error, normal, normal),
                    _ => point + narrowed(random.in_cube()) * size,
                };
                let aim = triangles.get(index / 2).map_or(Vec3::Z, |t| t.corners[0]) - origin;
                let directions = fan_directions(&mut random, turn % 5, normal, aim);
                let fan = Fan::new(origin, normal, &directions);
                let expected = fan.each(|ray| all.occluded(ray, 1.0));
                occluded += expected.count_ones();
                free += directions.len() - expected.count_ones() as usize;
                for tree in &trees {
                    let found = tree.occluded_fan(&fan);
                    assert_eq!(found, expected, "{name}, {}: {fan:?}", tree.name());
                }
            }
        }
        assert!(occluded > 10_000 && free > 10_000, "{occluded}, {free}");
    }

    /// The heights of its corners are lost in rounding, but it is in the way.
    #[test]
    fn fans_meet_large_triangles_close_above_where_they_start() {
        let mut random = Random::new(32);
        let mut occluded = 0;
        for _ in 0..3000 {
            let origin = narrowed(random.in_cube());
            let normal = narrowed(random.in_cube().normalize());
            let (along, across) = normal.any_orthonormal_pair();
            let above = origin.as_dvec3() + normal.as_dvec3() * (random.unit() * 1e-7);
            let corner = |x: f64, y: f64| {
                narrowed(above + along.as_dvec3() * x * 4.0 + across.as_dvec3() * y * 4.0)
            };
            let corners = [corner(1.0, 0.1), corner(-0.6, 0.8), corner(-0.5, -0.9)];
            let triangles = [Triangle { corners }];
            let directions = [normal, normal + along * 0.2, normal - across * 0.3];
            let fan = Fan::new(origin, normal, &directions);
            let expected = BruteForce::new(triangles.to_vec());
            let expected = fan.each(|ray| expected.occluded(ray, 1.0));
            occluded += expected.count_ones();
            for tree in trees(&triangles) {
                assert_eq!(tree.occluded_fan(&fan), expected, "{fan:?} {triangles:?}");
            }
        }
        assert!(occluded > 1000, "only {occluded}");
    }
}
