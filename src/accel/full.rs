//! The full test of pairs of a ray and a triangle side by side.

use super::simd::{Doubles, LaneSet, Lanes};
use crate::geometry::{RayKernel, TriangleHit};

/// What [`RayKernel`] holds of the rays of pairs, a ray per lane.
#[derive(Clone, Copy)]
pub(super) struct KernelRays<R> {
    pub origin: [R; 3],
    pub shear: [R; 2],
    pub direction_z: R,
}

impl<R: Copy> KernelRays<R> {
    /// One ray in all lanes.
    #[inline(always)]
    pub fn one<S: Doubles<R>>(simd: S, kernel: &RayKernel) -> Self {
        let [x, y, z] = kernel.origin;
        let [shear_x, shear_y] = kernel.shear;
        Self {
            origin: [
                simd.splat_double(x),
                simd.splat_double(y),
                simd.splat_double(z),
            ],
            shear: [simd.splat_double(shear_x), simd.splat_double(shear_y)],
            direction_z: simd.splat_double(kernel.direction_z),
        }
    }

    /// Corners as [`RayKernel`] sees them, by renamed axis: moved and sheared.
    #[inline(always)]
    fn sheared<S: Doubles<R>>(&self, simd: S, [x, y, z]: [R; 3]) -> [R; 3] {
        let x = simd.sub(x, self.origin[0]);
        let y = simd.sub(y, self.origin[1]);
        let z = simd.sub(z, self.origin[2]);
        [
            simd.sub(x, simd.mul(self.shear[0], z)),
            simd.sub(y, simd.mul(self.shear[1], z)),
            z,
        ]
    }
}

/// What [`RayKernel::intersect`] says of pairs, for any `t_max`.
///
/// Lane by lane the same arithmetic, so the same bits, but for pairs that need exact sums: those are told to ask the kernel.
pub(super) struct FullTests<S, R> {
    simd: S,
    /// Lanes where the ray, or the line it is part of, meets the triangle for certain.
    pub met: LaneSet,
    /// Lanes where it may.
    pub undecided: LaneSet,
    t: R,
    edges: [R; 3],
    determinant: R,
}

impl<R: Copy, S: Doubles<R>> FullTests<S, R> {
    /// Tests pairs, of which those in `lanes` count. `corners`: their coordinates in the order of the rays' axes.
    #[inline(always)]
    pub fn new(simd: S, rays: &KernelRays<R>, corners: &[[R; 3]; 3], lanes: LaneSet) -> Self {
        let [ax, ay, az] = rays.sheared(simd, corners[0]);
        let [bx, by, bz] = rays.sheared(simd, corners[1]);
        let [cx, cy, cz] = rays.sheared(simd, corners[2]);
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));

        let zero = simd.splat_double(0.0);
        let four = simd.splat_double(4.0);
        let extent_of_two = simd.larger(larger(simd, ax, ay), larger(simd, bx, by));
        let extent = simd.larger(extent_of_two, larger(simd, cx, cy));
        let depth = simd.larger(larger(simd, az, bz), simd.abs(cz));
        let h = simd.mul(
            simd.splat_double(RayKernel::EDGE_ERROR),
            simd.add(extent, depth),
        );
        let edge_error = simd.add(
            simd.mul(simd.mul(four, h), simd.add(extent, h)),
            simd.splat_double(f64::MIN_POSITIVE),
        );
        let minus_edge_error = simd.sub(zero, edge_error);
        let lowest = simd.smaller(simd.smaller(u, v), w);
        let highest = simd.larger(simd.larger(u, v), w);
        let is_beside = simd
            .less(lowest, minus_edge_error)
            .and(simd.less(edge_error, highest));

        let determinant = simd.add(simd.add(u, v), w);
        let weighted_z = simd.add(simd.add(simd.mul(u, az), simd.mul(v, bz)), simd.mul(w, cz));
        let size = simd.abs(determinant);
        let four_edge_errors = simd.mul(four, edge_error);
        let z_error = simd.mul(
            depth,
            simd.add(
                four_edge_errors,
                simd.mul(simd.splat_double(4.0 * f64::EPSILON), size),
            ),
        );
        let denominator = simd.mul(determinant, rays.direction_z);
        let size_of_z = simd.abs(weighted_z);
        let is_behind = simd
            .less(simd.mul(weighted_z, denominator), zero)
            .and(simd.less(four_edge_errors, size))
            .and(simd.less(z_error, size_of_z));

        let is_inside = simd
            .less(edge_error, lowest)
            .or(simd.less(highest, minus_edge_error));
        let certain_z = simd.mul(simd.splat_double(RayKernel::CERTAIN_T), z_error);
        let is_certain = is_inside.and(simd.less(certain_z, size_of_z));
        let left = lanes.and_not(is_beside).and_not(is_behind);
        Self {
            simd,
            met: left.and(is_certain),
            undecided: left.and_not(is_certain),
            t: simd.div(weighted_z, denominator),
            edges: [u, v, w],
            determinant,
        }
    }

    /// The hits in the lanes of [`Self::met`], by lane.
    #[inline(always)]
    pub fn hits(&self) -> FullHits {
        let simd = self.simd;
        let share = simd.div(simd.splat_double(1.0), self.determinant);
        let [u, v, w] = self.edges;
        FullHits {
            t: simd.store_rounded(self.t),
            weights: [
                simd.store_rounded(simd.mul(u, share)),
                simd.store_rounded(simd.mul(v, share)),
                simd.store_rounded(simd.mul(w, share)),
            ],
        }
    }
}

/// The hits of pairs, every number rounded once.
pub(super) struct FullHits {
    t: Lanes,
    weights: [Lanes; 3],
}

impl FullHits {
    /// The hit in a lane, if it lies on the ray.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Option<TriangleHit> {
        let [u, v, w] = &self.weights;
        TriangleHit::on_ray(self.t.0[lane], [u.0[lane], v.0[lane], w.0[lane]])
    }
}

/// The larger magnitude.
#[inline(always)]
fn larger<R, S: Doubles<R>>(simd: S, a: R, b: R) -> R {
    simd.larger(simd.abs(a), simd.abs(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::block::TriangleBlock;
    use crate::accel::simd::{self, LANES, Query, Simd};
    use crate::accel::tests::{rays, scenes};
    use crate::geometry::Triangle;
    use crate::math::Ray;

    /// The hit with each triangle of a block, and how many lanes decided for themselves.
    struct EachHit<'a> {
        ray: &'a Ray,
        triangles: &'a [Triangle],
        block: &'a TriangleBlock,
    }

    impl Query for EachHit<'_> {
        type Answer = (Vec<Option<TriangleHit>>, usize);

        #[inline(always)]
        fn answer<S: Simd>(&self, simd: S) -> Self::Answer {
            let kernel = RayKernel::new(self.ray);
            let mut hits = vec![None; LANES];
            let mut decided = 0;
            for four in self.block.occupied(simd).fours() {
                let (first, lanes) = (four.first(), four.lanes);
                let corners = self.block.four(simd, kernel.axes, four.index);
                let rays = KernelRays::one(simd, &kernel);
                let four = FullTests::new(simd, &rays, &corners, lanes);
                let four_hits = four.hits();
                for lane in four.met {
                    hits[first + lane] = four_hits.get(lane);
                }
                for lane in four.undecided {
                    let lane = first + lane;
                    hits[lane] = kernel.intersect(&self.triangles[lane], f32::INFINITY);
                }
                decided += lanes.and_not(four.undecided).into_iter().count();
            }
            (hits, decided)
        }
    }

    #[test]
    fn full_tests_are_the_kernels() {
        let (mut met, mut decided, mut all) = (0, 0, 0);
        for (name, triangles) in scenes() {
            for (chunk, rays) in triangles.chunks(LANES).zip(rays(&triangles, 21).chunks(50)) {
                let ids: Vec<_> = (0..).take(chunk.len()).collect();
                let block = &TriangleBlock::new(&ids, chunk);
                for ray in rays {
                    let triangles = chunk;
                    let kernel = RayKernel::new(ray);
                    let query = EachHit {
                        ray,
                        triangles,
                        block,
                    };
                    for (hits, by_lanes) in simd::answers(&query) {
                        for (triangle, hit) in chunk.iter().zip(hits) {
                            let expected = kernel.intersect(triangle, f32::INFINITY);
                            assert_eq!(hit, expected, "{name}: {ray:?} {triangle:?}");
                            met += usize::from(hit.is_some());
                        }
                        decided += by_lanes;
                        all += chunk.len();
                    }
                }
            }
        }
        assert!(met > 100, "only {met} hits");
        assert!(decided * 10 > all * 9, "{decided} of {all} tests decided");
    }
}
