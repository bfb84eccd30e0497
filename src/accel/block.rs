//! Eight triangles side by side, and the `f32` filter that spares most of them the full test.

use crate::geometry::{RayKernel, Triangle};
use crate::math::{Ray, Vec3};

/// Triangles per block.
pub(super) const LANES: usize = 8;

/// One number per lane.
type Lanes = [f32; LANES];

/// Up to eight triangles, stored by corner, axis and lane so that a loop over lanes becomes vector instructions.
///
/// Lanes without a triangle hold NaN, which no filter passes.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct TriangleBlock {
    corners: [[Lanes; 3]; 3],
    /// The triangles' ids; [`TriangleBlock::NO_TRIANGLE`] in lanes that hold none.
    pub ids: [u32; LANES],
}

impl TriangleBlock {
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// The block of the triangles with these ids, at most eight.
    pub fn new(ids: &[u32], triangles: &[Triangle]) -> Self {
        let mut block = Self {
            corners: [[[f32::NAN; LANES]; 3]; 3],
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
                    value[lane] = corner[axis];
                }
            }
        }
        block
    }

    /// The triangle in `lane`.
    #[inline]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let corner = |i: usize| {
            let [x, y, z] = &self.corners[i];
            Vec3::new(x[lane], y[lane], z[lane])
        };
        Triangle {
            corners: [corner(0), corner(1), corner(2)],
        }
    }
}

/// [`RayKernel`] in `f32`, for many triangles at once. It may pass a triangle the ray misses, but never rejects a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockFilter {
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
}

/// `h / (P + Z)` of the bound derived at [`RayKernel::EDGE_ERROR_PER_ROUNDOFF`] for `f32` arithmetic. The shear is rounded twice, to
/// `f64` and then to `f32`; the second order of the first rounding is far below the bound's reserve.
#[expect(clippy::cast_possible_truncation, reason = "a constant")]
const EDGE_ERROR: f32 = RayKernel::EDGE_ERROR_PER_ROUNDOFF as f32 * (f32::EPSILON * 0.5);

impl BlockFilter {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the bound counts this rounding"
    )]
    pub fn new(ray: &Ray, kernel: &RayKernel) -> Self {
        let axes = kernel.axes();
        Self {
            axes,
            origin: axes.map(|axis| ray.origin[axis]),
            shear: kernel.shear().map(|s| s as f32),
        }
    }

    /// The lanes whose triangle may be hit; never one without a triangle.
    ///
    /// A lane is rejected when its edge functions have different signs for certain. Numbers too large for `f32` make the
    /// bound infinite or NaN, and a lane with such a bound passes: (P + h)(P + Z) is at least as large as every product
    /// in the edge functions, so they cannot overflow unless it does. The smallest normal number covers underflow.
    #[inline(always)]
    pub fn may_hit(&self, block: &TriangleBlock) -> LaneSet {
        let [ax, ay, az] = self.sheared(&block.corners[0]);
        let [bx, by, bz] = self.sheared(&block.corners[1]);
        let [cx, cy, cz] = self.sheared(&block.corners[2]);
        let mut passed = [0; LANES];
        for i in 0..LANES {
            let u = cx[i] * by[i] - cy[i] * bx[i];
            let v = ax[i] * cy[i] - ay[i] * cx[i];
            let w = bx[i] * ay[i] - by[i] * ax[i];
            let ab = max(max(ax[i].abs(), ay[i].abs()), max(bx[i].abs(), by[i].abs()));
            let extent = max(ab, max(cx[i].abs(), cy[i].abs()));
            let depth = max(max(az[i].abs(), bz[i].abs()), cz[i].abs());
            let sum = extent + depth;
            let h = EDGE_ERROR * sum;
            let error = (extent + h) * sum * (4.0 * EDGE_ERROR) + f32::MIN_POSITIVE;
            let rejected = (min(min(u, v), w) < -error) & (max(max(u, v), w) > error);
            passed[i] = u8::from(!rejected & !az[i].is_nan());
        }
        LaneSet::from_bytes(passed)
    }

    #[inline(always)]
    fn sheared(&self, corner: &[Lanes; 3]) -> [Lanes; 3] {
        let [x, y, z] = self.axes.map(|axis| &corner[axis]);
        let mut result = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let z = z[i] - self.origin[2];
            result[0][i] = (x[i] - self.origin[0]) - self.shear[0] * z;
            result[1][i] = (y[i] - self.origin[1]) - self.shear[1] * z;
            result[2][i] = z;
        }
        result
    }
}

/// Lanes of a block or a node, in ascending order: a byte each, 0 or 1, as comparing vectors gives them.
#[derive(Debug)]
pub(super) struct LaneSet(u64);

impl LaneSet {
    /// The lanes with a 1.
    #[inline(always)]
    pub fn from_bytes(bytes: [u8; LANES]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }
}

impl Iterator for LaneSet {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        (self.0 != 0).then(|| {
            let lane = self.0.trailing_zeros() as usize / 8;
            self.0 &= self.0 - 1;
            lane
        })
    }
}

/// The smaller number; `f32::min` treats NaN differently and costs three instructions.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger number; see [`min`].
#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
