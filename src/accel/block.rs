//! Eight triangles side by side, and the `f32` filter that spares most of them the full test.

use super::simd::{LANES, LaneSet, Lanes, Simd, splat_all};
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

/// [`RayKernel`] in `f32`, for many triangles at once. It may pass a triangle the ray misses, but never rejects a hit before its
/// limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockFilter<S: Simd> {
    simd: S,
    /// As the ray's [`RayKernel`] renames them.
    pub axes: [usize; 3],
    origin: [S::F32x8; 3],
    /// Its negative, so that shearing is one multiplication with addition.
    unshear: [S::F32x8; 2],
    direction_z: f32,
}

/// What the filter computes of eight triangles, and bounds on its errors.
struct Edges<S: Simd> {
    /// Edge functions.
    u: S::F32x8,
    v: S::F32x8,
    w: S::F32x8,
    /// Bounds the distance of each from its exact value.
    error: S::F32x8,
    /// Of the corners, from the origin along the axis called z.
    z: [S::F32x8; 3],
    /// The largest magnitude of those.
    depth: S::F32x8,
}

/// `h / (P + Z)` of the bound derived at [`RayKernel::EDGE_ERROR_PER_ROUNDOFF`] for `f32` arithmetic. Products that are not
/// rounded before they are added only make errors smaller.
#[expect(clippy::cast_possible_truncation, reason = "a constant")]
const EDGE_ERROR: f32 = RayKernel::EDGE_ERROR_PER_ROUNDOFF as f32 * (f32::EPSILON * 0.5);

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
            simd,
            axes,
            origin: splat_all(simd, [origin[axes[0]], origin[axes[1]], origin[axes[2]]]),
            unshear: [simd.splat(unshear[0]), simd.splat(unshear[1])],
            direction_z: ray.direction.to_array()[axes[2]],
        }
    }

    /// What moves the ray's x and y per z to 0, by its axes.
    #[inline(always)]
    pub fn unshear_of(ray: &Ray, axes: [usize; 3]) -> [f32; 2] {
        let direction = ray.direction.to_array();
        let [x, y, z] = axes;
        [-direction[x] / direction[z], -direction[y] / direction[z]]
    }

    /// The lanes whose triangle may be hit before `limit`, a distance moved outwards by [`later`](super::slabs::later); never one
    /// without a triangle.
    ///
    /// Most rays pass beside all triangles, so only where one does not is asked how far away it is: in a room, a line through a
    /// point meets walls on both sides.
    #[inline(always)]
    pub fn may_hit(&self, block: &TriangleBlock, limit: f32) -> LaneSet {
        let edges = self.edges(block);
        let beside = self.is_beside(&edges);
        let met = block.occupied(self.simd).and_not(beside);
        if met.is_empty() {
            return met;
        }
        met.and_not(self.is_out_of_reach(&edges, limit))
    }

    #[inline(always)]
    fn edges(&self, block: &TriangleBlock) -> Edges<S> {
        let simd = self.simd;
        let [ax, ay, az] = self.sheared(&block.corners[0]);
        let [bx, by, bz] = self.sheared(&block.corners[1]);
        let [cx, cy, cz] = self.sheared(&block.corners[2]);
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
    fn is_beside(&self, edges: &Edges<S>) -> LaneSet {
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
    fn is_out_of_reach(&self, edges: &Edges<S>, limit: f32) -> LaneSet {
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

        let denominator = simd.mul(determinant, simd.splat(self.direction_z));
        let is_behind = simd
            .less(simd.mul(weighted_z, denominator), simd.splat(0.0))
            .and(simd.less(four_errors, size))
            .and(simd.less(simd.splat(0.0), certain_z));
        let depth_limit = limit * self.direction_z.abs();
        let depth_limit = if depth_limit < f32::MIN_POSITIVE {
            f32::INFINITY
        } else {
            depth_limit
        };
        let farthest = simd.mul_add(simd.splat(depth_limit), simd.add(size, four_errors), least);
        let is_beyond = simd.less(farthest, certain_z);
        let is_finite = simd.less(certain_z, simd.splat(f32::INFINITY));
        is_behind.or(is_beyond).and(is_finite)
    }

    /// The larger magnitude.
    #[inline(always)]
    fn largest(&self, a: S::F32x8, b: S::F32x8) -> S::F32x8 {
        self.simd.larger(self.simd.abs(a), self.simd.abs(b))
    }

    /// The corner's coordinate number `i` as renamed, from the origin.
    #[inline(always)]
    fn moved(&self, corner: &[Lanes; 3], i: usize) -> S::F32x8 {
        let lanes = self.simd.load(&corner[self.axes[i]]);
        self.simd.sub(lanes, self.origin[i])
    }

    #[inline(always)]
    fn sheared(&self, corner: &[Lanes; 3]) -> [S::F32x8; 3] {
        let simd = self.simd;
        let (x, y) = (self.moved(corner, 0), self.moved(corner, 1));
        let z = self.moved(corner, 2);
        [
            simd.mul_add(self.unshear[0], z, x),
            simd.mul_add(self.unshear[1], z, y),
            z,
        ]
    }
}
