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

/// [`RayKernel`] in `f32`, for many triangles at once. It may pass a triangle the ray misses, but never rejects a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockFilter<S: Simd> {
    simd: S,
    /// As the ray's [`RayKernel`] renames them.
    pub axes: [usize; 3],
    origin: [S::F32x8; 3],
    /// Its negative, so that shearing is one multiplication with addition.
    unshear: [S::F32x8; 2],
}

/// `h / (P + Z)` of the bound derived at [`RayKernel::EDGE_ERROR_PER_ROUNDOFF`] for `f32` arithmetic. Products that are not
/// rounded before they are added only make errors smaller.
#[expect(clippy::cast_possible_truncation, reason = "a constant")]
const EDGE_ERROR: f32 = RayKernel::EDGE_ERROR_PER_ROUNDOFF as f32 * (f32::EPSILON * 0.5);

impl<S: Simd> BlockFilter<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &Ray) -> Self {
        let axes = RayKernel::axes_of(ray);
        Self::with_shear(simd, ray.origin, axes, Self::unshear_of(ray, axes))
    }

    /// The filter of a ray from `origin` with these [`RayKernel::axes_of`] and [`Self::unshear_of`].
    #[inline(always)]
    pub fn with_shear(simd: S, origin: Vec3, axes: [usize; 3], unshear: [f32; 2]) -> Self {
        let origin = origin.to_array();
        Self {
            simd,
            axes,
            origin: splat_all(simd, [origin[axes[0]], origin[axes[1]], origin[axes[2]]]),
            unshear: [simd.splat(unshear[0]), simd.splat(unshear[1])],
        }
    }

    /// What moves the ray's x and y per z to 0, by its axes.
    #[inline(always)]
    pub fn unshear_of(ray: &Ray, axes: [usize; 3]) -> [f32; 2] {
        let direction = ray.direction.to_array();
        let [x, y, z] = axes;
        [-direction[x] / direction[z], -direction[y] / direction[z]]
    }

    /// The lanes whose triangle may be hit; never one without a triangle.
    ///
    /// A lane is rejected when its edge functions have different signs for certain. Numbers too large for `f32` make the
    /// bound infinite or NaN, and a lane with such a bound passes: (P + h)(P + Z) is at least as large as every product
    /// in the edge functions, so they cannot overflow unless it does. The smallest normal number covers underflow.
    #[inline(always)]
    pub fn may_hit(&self, block: &TriangleBlock) -> LaneSet {
        let simd = self.simd;
        let [ax, ay, az] = self.sheared(&block.corners[0]);
        let [bx, by, bz] = self.sheared(&block.corners[1]);
        let [cx, cy, cz] = self.sheared(&block.corners[2]);
        let u = simd.mul_sub(cx, by, simd.mul(cy, bx));
        let v = simd.mul_sub(ax, cy, simd.mul(ay, cx));
        let w = simd.mul_sub(bx, ay, simd.mul(by, ax));
        let extent_of_two = simd.larger(self.largest(ax, ay), self.largest(bx, by));
        let extent = simd.larger(extent_of_two, self.largest(cx, cy));
        let depth = simd.larger(self.largest(az, bz), simd.abs(cz));
        let sum = simd.add(extent, depth);
        let h = simd.mul(simd.splat(EDGE_ERROR), sum);
        let error = simd.mul_add(
            simd.mul(simd.add(extent, h), sum),
            simd.splat(4.0 * EDGE_ERROR),
            simd.splat(f32::MIN_POSITIVE),
        );
        let lowest = simd.smaller(simd.smaller(u, v), w);
        let highest = simd.larger(simd.larger(u, v), w);
        let has_negative = simd.less(simd.add(lowest, error), simd.splat(0.0));
        let has_positive = simd.less(error, highest);
        block.occupied(simd).and_not(has_negative.and(has_positive))
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
