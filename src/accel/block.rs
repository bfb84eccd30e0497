//! Eight triangles side by side, and the `f32` filter that spares most of them the full test.

use super::simd::{Floats, LANES, LaneSet, Lanes, Simd, splat_all};
use crate::geometry::{RayKernel, Triangle};
use crate::math::{Ray, Vec3};

/// Up to eight triangles, stored by corner, axis and lane.
///
/// Lanes without a triangle hold NaN, which no filter passes.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct TriangleBlock {
    /// By corner and axis.
    pub corners: [[Lanes; 3]; 3],
    /// The triangles' ids; [`TriangleBlock::NO_TRIANGLE`] in lanes that hold none.
    pub ids: [u32; LANES],
}

impl TriangleBlock {
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// The block of the triangles with these ids, at most eight.
    pub fn new(ids: &[u32], triangles: &[Triangle]) -> Self {
        let mut block = Self {
            corners: [[Lanes([f32::NAN; LANES]); 3]; 3],
            ids: [Self::NO_TRIANGLE; LANES],
        };
        for (lane, &id) in ids.iter().enumerate() {
            block.ids[lane] = id;
            for (corner, values) in triangles[id as usize]
                .corners
                .iter()
                .zip(&mut block.corners)
            {
                for (axis, value) in values.iter_mut().enumerate() {
                    value.0[lane] = corner[axis];
                }
            }
        }
        block
    }

    /// The lanes that hold a triangle.
    #[inline(always)]
    pub fn occupied<S: Simd>(&self, simd: S) -> LaneSet {
        let x = simd.load(&self.corners[0][0]);
        simd.less_or_equal(x, x)
    }

    /// The corners of the triangles, a triangle per lane, their coordinates in the order of `axes`.
    #[inline(always)]
    pub fn eight<S: Simd>(&self, simd: S, axes: [usize; 3]) -> [[S::F32x8; 3]; 3] {
        let mut corners = [[simd.splat(0.0); 3]; 3];
        for (corner, from) in corners.iter_mut().zip(&self.corners) {
            for (coordinates, axis) in corner.iter_mut().zip(axes) {
                *coordinates = simd.load(&from[axis]);
            }
        }
        corners
    }

    /// Four of [`Self::eight`], in `f64`, by the index of the four.
    #[inline(always)]
    pub fn four<S: Simd>(&self, simd: S, axes: [usize; 3], index: usize) -> [[S::F64x4; 3]; 3] {
        let mut corners = [[simd.splat_double(0.0); 3]; 3];
        for (corner, from) in corners.iter_mut().zip(&self.corners) {
            for (coordinates, axis) in corner.iter_mut().zip(axes) {
                *coordinates = simd.load_doubles(from[axis].four(index));
            }
        }
        corners
    }

    /// The corners of the triangle in `lane`, sixteen times, their coordinates in the order of `axes`.
    #[inline(always)]
    pub fn one_in_sixteen<S: Simd>(
        &self,
        simd: S,
        axes: [usize; 3],
        lane: usize,
    ) -> [[S::F32x16; 3]; 3] {
        let mut corners = [[simd.splat(0.0); 3]; 3];
        for (corner, from) in corners.iter_mut().zip(&self.corners) {
            for (coordinates, axis) in corner.iter_mut().zip(axes) {
                *coordinates = simd.splat(from[axis].0[lane]);
            }
        }
        corners
    }

    /// The triangle in `lane`.
    #[inline]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let corner = |i: usize| {
            let [x, y, z] = &self.corners[i];
            Vec3::new(x.0[lane], y.0[lane], z.0[lane])
        };
        Triangle {
            corners: [corner(0), corner(1), corner(2)],
        }
    }
}

/// The [`Filter`] of one ray, for the triangles of blocks.
#[derive(Clone, Copy)]
pub(super) struct BlockFilter<S: Simd> {
    /// As the ray's [`RayKernel`] renames them.
    pub axes: [usize; 3],
    filter: Filter<S, S::F32x8>,
}

impl<S: Simd> BlockFilter<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &Ray) -> Self {
        let axes = RayKernel::axes_of(ray);
        Self::with_shear(simd, ray, axes, Self::unshear_of(ray, axes))
    }

    /// The filter of a ray with these [`RayKernel::axes_of`] and [`Self::unshear_of`].
    #[inline(always)]
    pub fn with_shear(simd: S, ray: &Ray, axes: [usize; 3], unshear: [f32; 2]) -> Self {
        let origin = ray.origin.to_array();
        Self {
            axes,
            filter: Filter {
                simd,
                origin: splat_all(simd, [origin[axes[0]], origin[axes[1]], origin[axes[2]]]),
                unshear: [simd.splat(unshear[0]), simd.splat(unshear[1])],
                direction_z: simd.splat(ray.direction.to_array()[axes[2]]),
            },
        }
    }

    /// The negative of the shear: what moves the ray's x and y per z to 0, in the order of `axes`.
    #[inline(always)]
    pub fn unshear_of(ray: &Ray, axes: [usize; 3]) -> [f32; 2] {
        let direction = ray.direction.to_array();
        let [x, y, z] = axes;
        [-direction[x] / direction[z], -direction[y] / direction[z]]
    }

    /// [`Filter::may_hit`] of the block's triangles; never a lane without one.
    #[inline(always)]
    pub fn may_hit(&self, block: &TriangleBlock, limit: f32) -> LaneSet {
        let Filter { simd, .. } = self.filter;
        let corners = block.eight(simd, self.axes);
        let limit = simd.splat(limit);
        self.filter.may_hit(block.occupied(simd), &corners, limit)
    }
}

/// [`RayKernel`] in `f32`, for as many pairs of a ray and a triangle at once as a register has lanes. It may pass a triangle the ray
/// misses, but never rejects a hit before its limit.
///
/// A pair per lane: one ray may be in all of them, or one triangle. Coordinates are in the order of the rays' axes.
#[derive(Clone, Copy)]
pub(super) struct Filter<S, R> {
    pub simd: S,
    pub origin: [R; 3],
    /// The negative of the shear, so that shearing is one multiplication with addition.
    pub unshear: [R; 2],
    pub direction_z: R,
}

/// What the filter computes of eight pairs, and bounds on its errors.
struct Edges<R> {
    /// Edge functions.
    u: R,
    v: R,
    w: R,
    /// Bounds the distance of each from its exact value.
    error: R,
    /// Of the corners, from the origin along the axis called z.
    z: [R; 3],
    /// The largest magnitude of those.
    depth: R,
}

/// `h / (P + Z)` of the bound derived at [`RayKernel::EDGE_ERROR_PER_ROUNDOFF`] for `f32` arithmetic. Products that are not
/// rounded before they are added only make errors smaller.
#[expect(clippy::cast_possible_truncation, reason = "a constant")]
const EDGE_ERROR: f32 = RayKernel::EDGE_ERROR_PER_ROUNDOFF as f32 * (f32::EPSILON * 0.5);

impl<R: Copy, S: Floats<R>> Filter<S, R> {
    /// Which of `pairs` may be a hit before the ray's `limit`, a distance moved outwards by [`later`](super::slabs::later).
    ///
    /// Most rays pass beside all triangles, so only where one does not is asked how far away it is: in a room, a line through a
    /// point meets walls on both sides.
    #[inline(always)]
    pub fn may_hit(&self, pairs: LaneSet, corners: &[[R; 3]; 3], limit: R) -> LaneSet {
        let edges = self.edges(corners);
        let met = pairs.and_not(self.is_beside(&edges));
        if met.is_empty() {
            return met;
        }
        met.and_not(self.is_out_of_reach(&edges, limit))
    }

    #[inline(always)]
    fn edges(&self, corners: &[[R; 3]; 3]) -> Edges<R> {
        let simd = self.simd;
        let [ax, ay, az] = self.sheared(corners[0]);
        let [bx, by, bz] = self.sheared(corners[1]);
        let [cx, cy, cz] = self.sheared(corners[2]);
        let extent_of_two = simd.larger(self.largest(ax, ay), self.largest(bx, by));
        let extent = simd.larger(extent_of_two, self.largest(cx, cy));
        let depth = simd.larger(self.largest(az, bz), simd.abs(cz));
        let sum = simd.add(extent, depth);
        let h = simd.mul(simd.splat(EDGE_ERROR), sum);
        Edges {
            u: simd.mul_sub(cx, by, simd.mul(cy, bx)),
            v: simd.mul_sub(ax, cy, simd.mul(ay, cx)),
            w: simd.mul_sub(bx, ay, simd.mul(by, ax)),
            error: simd.mul_add(
                simd.mul(simd.add(extent, h), sum),
                simd.splat(4.0 * EDGE_ERROR),
                simd.splat(f32::MIN_POSITIVE),
            ),
            z: [az, bz, cz],
            depth,
        }
    }

    /// Where edge functions have different signs for certain.
    ///
    /// Numbers too large for `f32` make the bound infinite or NaN, and a lane with such a bound is not told: (P + h)(P + Z) is at
    /// least as large as every product in the edge functions, so they cannot overflow unless it does. The smallest normal number
    /// covers underflow.
    #[inline(always)]
    fn is_beside(&self, edges: &Edges<R>) -> LaneSet {
        let simd = self.simd;
        let &Edges { u, v, w, error, .. } = edges;
        let lowest = simd.smaller(simd.smaller(u, v), w);
        let highest = simd.larger(simd.larger(u, v), w);
        let has_negative = simd.less(simd.add(lowest, error), simd.splat(0.0));
        let has_positive = simd.less(error, highest);
        has_negative.and(has_positive)
    }

    /// Where the line of the ray meets the triangle's plane behind the origin or beyond `limit` for certain, if it is not beside
    /// the triangle. Bounds and their reasons are those of [`RayKernel::intersect`], with the unit roundoff of `f32`.
    ///
    /// t is beyond `limit` where |z| exceeds the limit's z along the ray, times the largest determinant there can be; the margin
    /// of the limit, twelve roundings, covers the five of this comparison. Where that z vanishes, nothing is beyond it.
    ///
    /// Where numbers are too large for `f32`, z along the ray or its bound is infinite or NaN, and nothing is certain. The
    /// smallest normal number covers underflow again.
    #[inline(always)]
    fn is_out_of_reach(&self, edges: &Edges<R>, limit: R) -> LaneSet {
        let simd = self.simd;
        let &Edges { u, v, w, error, .. } = edges;
        let [az, bz, cz] = edges.z;
        let determinant = simd.add(simd.add(u, v), w);
        let weighted_z = simd.mul_add(u, az, simd.mul_add(v, bz, simd.mul(w, cz)));
        let size = simd.abs(determinant);
        let four_errors = simd.mul(simd.splat(4.0), error);
        let relative = simd.splat(4.0 * f32::EPSILON);
        let least = simd.splat(f32::MIN_POSITIVE);
        let z_error = simd.mul_add(
            edges.depth,
            simd.mul_add(relative, size, four_errors),
            least,
        );
        let certain_z = simd.sub(simd.abs(weighted_z), z_error);

        let denominator = simd.mul(determinant, self.direction_z);
        let is_behind = simd
            .less(simd.mul(weighted_z, denominator), simd.splat(0.0))
            .and(simd.less(four_errors, size))
            .and(simd.less(simd.splat(0.0), certain_z));
        let depth_limit = simd.mul(limit, simd.abs(self.direction_z));
        let farthest = simd.mul_add(depth_limit, simd.add(size, four_errors), least);
        let is_beyond = simd
            .less(farthest, certain_z)
            .and(simd.less_or_equal(least, depth_limit));
        let is_finite = simd.less(certain_z, simd.splat(f32::INFINITY));
        is_behind.or(is_beyond).and(is_finite)
    }

    /// The larger magnitude.
    #[inline(always)]
    fn largest(&self, a: R, b: R) -> R {
        self.simd.larger(self.simd.abs(a), self.simd.abs(b))
    }

    #[inline(always)]
    fn sheared(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        let simd = self.simd;
        let z = simd.sub(z, self.origin[2]);
        [
            simd.mul_add(self.unshear[0], z, simd.sub(x, self.origin[0])),
            simd.mul_add(self.unshear[1], z, simd.sub(y, self.origin[1])),
            z,
        ]
    }
}
