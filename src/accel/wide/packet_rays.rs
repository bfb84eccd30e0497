//! The rays of a packet side by side, and their tests against boxes and triangles.
//!
//! In a leaf, a triangle is tested with all rays at once where many of them may meet it, as rays of one packet mostly meet the
//! same few triangles. Lane by lane this is the arithmetic of a ray by itself.

use super::node::Node;
use super::span::Span;
use crate::accel::Hit;
use crate::accel::block::{Filter, TriangleBlock};
use crate::accel::four::{FourRays, FourTests};
use crate::accel::leaf::decide;
use crate::accel::packet::{Packet, PacketHits};
use crate::accel::simd::{Half, LANES, LaneSet, Lanes, Simd, splat_all};
use crate::accel::slabs::{later, may_hold_hits, ordinary};
use crate::geometry::{RayKernel, TriangleHit};
use crate::math::Ray;

/// Registers that hold a number of each ray.
const REGISTERS: usize = Packet::MOST_RAYS / LANES;

/// A number of each ray.
type PerRay = [Lanes; REGISTERS];

const NOTHING: PerRay = [Lanes([0.0; LANES]); REGISTERS];

/// For fewer rays it is not asked which triangles of a block they can meet together.
const MANY_RAYS: usize = 4;

/// The rays of a packet side by side. Lanes without a ray hold a copy of the last one that ends before its start.
pub(super) struct PacketRays<'a, S: Simd> {
    simd: S,
    rays: &'a [(Ray, f32)],
    pub span: Span<S>,
    /// By axis.
    origins: [PerRay; 3],
    /// By axis.
    directions: [PerRay; 3],
    /// By axis, reciprocals of the directions.
    inverses: [PerRay; 3],
    /// Where each ray ends so far, moved outwards. No NaN.
    limits: PerRay,
    /// By axis, the rays whose [`RayKernel`] calls it z: rays of one such axis are tested together.
    longest: [LaneSet; 3],
    /// By that axis, the [`Filter::unshear`] of its rays.
    unshears: [[PerRay; 2]; 3],
    pub hits: PacketHits,
}

impl<'a, S: Simd> PacketRays<'a, S> {
    /// For boxes whose coordinates are at most `reach` in magnitude. `None` where the rays differ in the sign of a direction, where
    /// one is out of the ordinary, and where there is none.
    #[inline(always)]
    pub fn new(simd: S, packet: &Packet<'a>, reach: f32) -> Option<Self> {
        let rays = packet.rays();
        let (last, _) = rays.last()?;
        let [mut origins, mut directions] = [[NOTHING; 3]; 2];
        let mut limits = [Lanes([-1.0; LANES]); REGISTERS];
        for index in 0..Packet::MOST_RAYS {
            let (register, lane) = (index / LANES, index % LANES);
            let ray = match rays.get(index) {
                Some((ray, t_max)) => {
                    limits[register].0[lane] = later(*t_max).max(-1.0);
                    ray
                }
                None => last,
            };
            let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
            for axis in 0..3 {
                origins[axis][register].0[lane] = origin[axis];
                directions[axis][register].0[lane] = direction[axis];
            }
        }

        let mut inverses = [NOTHING; 3];
        let mut all_ordinary = LaneSet::first(LANES);
        for (directions, inverses) in directions.iter().zip(&mut inverses) {
            for (direction, inverse) in directions.iter().zip(inverses) {
                let direction = simd.load(direction);
                all_ordinary = all_ordinary.and(ordinary(simd, direction));
                *inverse = simd.store(simd.div(simd.splat(1.0), direction));
            }
        }
        let mut farthest = reach;
        let [mut origin_range, mut inverse_range] = [[[0.0; 2]; 3]; 2];
        for axis in 0..3 {
            let [least, most] = range(simd, &origins[axis]);
            farthest += least.abs() + most.abs();
            origin_range[axis] = [least, most];
            inverse_range[axis] = range(simd, &inverses[axis]);
        }
        // Where the difference between a plane and the origin may overflow, no distance can be trusted.
        if all_ordinary != LaneSet::first(LANES) || !farthest.is_finite() {
            return None;
        }

        let mut rays = Self {
            simd,
            rays,
            span: Span::new(simd, origin_range, inverse_range)?,
            origins,
            directions,
            inverses,
            limits,
            longest: [LaneSet::NONE; 3],
            unshears: [[NOTHING; 2]; 3],
            hits: [None; Packet::MOST_RAYS],
        };
        for register in 0..REGISTERS {
            rays.name_axes(register);
        }
        Some(rays)
    }

    /// Renames the axes of the rays in a register as [`RayKernel::axes_of`] does, and shears them.
    #[inline(always)]
    fn name_axes(&mut self, register: usize) {
        let simd = self.simd;
        let direction = self.of_register(&self.directions, [0, 1, 2], register);
        let [x, y, z] = [
            simd.abs(direction[0]),
            simd.abs(direction[1]),
            simd.abs(direction[2]),
        ];
        let along_z = simd.less(simd.larger(y, x), z);
        let along_y = simd.less(x, y).and_not(along_z);
        let along_x = LaneSet::first(LANES).and_not(along_y).and_not(along_z);
        for (longest, lanes) in [along_x, along_y, along_z].into_iter().enumerate() {
            if lanes.is_empty() {
                continue;
            }
            self.longest[longest] = self.longest[longest].or(lanes.beyond(register * LANES));
            let [x, y, z] = RayKernel::axes_along(longest);
            let minus_z = simd.sub(simd.splat(0.0), direction[z]);
            let [unshear_x, unshear_y] = &mut self.unshears[longest];
            unshear_x[register] = simd.store(simd.div(direction[x], minus_z));
            unshear_y[register] = simd.store(simd.div(direction[y], minus_z));
        }
    }

    /// All rays.
    #[inline(always)]
    pub fn all(&self) -> LaneSet {
        LaneSet::first(self.rays.len())
    }

    /// The greatest of the rays' limits.
    #[inline(always)]
    pub fn last_limit(&self) -> f32 {
        let [_, last] = range(self.simd, &self.limits);
        last
    }

    /// Numbers of the rays in a register, in the order of `axes`.
    #[inline(always)]
    fn of_register(
        &self,
        numbers: &[PerRay; 3],
        axes: [usize; 3],
        register: usize,
    ) -> [S::F32x8; 3] {
        let simd = self.simd;
        let [x, y, z] = axes;
        [
            simd.load(&numbers[x][register]),
            simd.load(&numbers[y][register]),
            simd.load(&numbers[z][register]),
        ]
    }

    /// [`Self::of_register`] of half a register, in `f64`.
    #[inline(always)]
    fn of_half(
        &self,
        numbers: &[PerRay; 3],
        axes: [usize; 3],
        register: usize,
        half: Half,
    ) -> [S::F64x4; 3] {
        let simd = self.simd;
        let [x, y, z] = axes;
        [
            simd.load_half(&numbers[x][register], half),
            simd.load_half(&numbers[y][register], half),
            simd.load_half(&numbers[z][register], half),
        ]
    }

    /// Which rays meet the box in a lane of a node before their limits: what a ray by itself would say of it.
    #[inline(always)]
    pub fn meeting(&self, node: &Node, lane: usize) -> LaneSet {
        let lower = self.meeting_half(node, lane, 0);
        let upper = self.meeting_half(node, lane, 1);
        lower.or(upper.beyond(LANES))
    }

    #[inline(always)]
    fn meeting_half(&self, node: &Node, lane: usize, half: usize) -> LaneSet {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.load(&self.limits[half]);
        for axis in 0..3 {
            let planes = &node.planes[axis];
            let backward = self.span.backward[axis] & 1;
            let origin = simd.load(&self.origins[axis][half]);
            let inverse = simd.load(&self.inverses[axis][half]);
            let nearer = simd.sub(simd.splat(planes[backward].0[lane]), origin);
            let farther = simd.sub(simd.splat(planes[1 - backward].0[lane]), origin);
            start = simd.larger(simd.mul(nearer, inverse), start);
            end = simd.smaller(simd.mul(farther, inverse), end);
        }
        may_hold_hits(simd, start, end)
    }

    /// Looks for nearer hits of these rays in a leaf.
    #[inline(always)]
    pub fn visit(&mut self, rays: LaneSet, blocks: &[TriangleBlock]) {
        for longest in 0..3 {
            let rays = rays.and(self.longest[longest]);
            if rays.is_empty() {
                continue;
            }
            for block in blocks {
                let passed = self.passed(longest, rays, block);
                for (lane, rays) in passed.into_iter().enumerate() {
                    if !rays.is_empty() {
                        self.test(longest, rays, block, lane);
                    }
                }
            }
        }
    }

    /// By triangle, which of the rays may hit it before their limits.
    #[inline(always)]
    fn passed(&self, longest: usize, rays: LaneSet, block: &TriangleBlock) -> [LaneSet; LANES] {
        if rays.count() >= MANY_RAYS {
            let met = self.span.may_meet(block, self.last_limit());
            let [lower, upper] = [rays.of_register(0), rays.of_register(1)];
            let registers = usize::from(!lower.is_empty()) + usize::from(!upper.is_empty());
            if met.count() * registers < rays.count() {
                return self.passed_by_triangle(longest, rays, block, met);
            }
        }
        self.passed_by_ray(longest, rays, block)
    }

    /// [`Self::passed`], one of the triangles in `lanes` after the other.
    #[inline(always)]
    fn passed_by_triangle(
        &self,
        longest: usize,
        rays: LaneSet,
        block: &TriangleBlock,
        lanes: LaneSet,
    ) -> [LaneSet; LANES] {
        let simd = self.simd;
        let axes = RayKernel::axes_along(longest);
        let [unshear_x, unshear_y] = &self.unshears[longest];
        let mut passed = [LaneSet::NONE; LANES];
        for lane in lanes {
            let corners = block.one_in_eight(simd, axes, lane);
            for register in 0..REGISTERS {
                let rays = rays.of_register(register);
                if rays.is_empty() {
                    continue;
                }
                let filter = Filter {
                    simd,
                    origin: self.of_register(&self.origins, axes, register),
                    unshear: [
                        simd.load(&unshear_x[register]),
                        simd.load(&unshear_y[register]),
                    ],
                    direction_z: simd.load(&self.directions[longest][register]),
                };
                let limits = simd.load(&self.limits[register]);
                let hit = filter.may_hit(rays, &corners, limits);
                passed[lane] = passed[lane].or(hit.beyond(register * LANES));
            }
        }
        passed
    }

    /// [`Self::passed`], one ray after the other.
    #[inline(always)]
    fn passed_by_ray(
        &self,
        longest: usize,
        rays: LaneSet,
        block: &TriangleBlock,
    ) -> [LaneSet; LANES] {
        let simd = self.simd;
        let [x, y, z] = RayKernel::axes_along(longest);
        let corners = block.eight(simd, [x, y, z]);
        let occupied = block.occupied(simd);
        let [unshear_x, unshear_y] = &self.unshears[longest];
        let mut passed = [LaneSet::NONE; LANES];
        for ray in rays {
            let (register, lane) = (ray / LANES, ray % LANES);
            let origin = [
                self.origins[x][register].0[lane],
                self.origins[y][register].0[lane],
                self.origins[z][register].0[lane],
            ];
            let filter = Filter {
                simd,
                origin: splat_all(simd, origin),
                unshear: [
                    simd.splat(unshear_x[register].0[lane]),
                    simd.splat(unshear_y[register].0[lane]),
                ],
                direction_z: simd.splat(self.directions[z][register].0[lane]),
            };
            let limit = simd.splat(self.limits[register].0[lane]);
            for triangle in filter.may_hit(occupied, &corners, limit) {
                passed[triangle].insert(ray);
            }
        }
        passed
    }

    /// The full test of these rays against the triangle in a lane.
    #[inline(always)]
    fn test(&mut self, longest: usize, rays: LaneSet, block: &TriangleBlock, lane: usize) {
        let simd = self.simd;
        let corners = block.one_in_four(simd, RayKernel::axes_along(longest), lane);
        let id = block.ids[lane];
        for register in 0..REGISTERS {
            for (half, rays) in rays.of_register(register).halves() {
                let first = register * LANES + half.first();
                let four = self.four(longest, register, half);
                let tests = FourTests::new(simd, &four, &corners, rays);
                let hits = tests.hits();
                for ray in tests.met {
                    self.consider(first + ray, id, hits.get(ray));
                }
                for ray in tests.undecided {
                    let index = first + ray;
                    let (ray, t_max) = &self.rays[index];
                    self.consider(index, id, decide(ray, *t_max, block, lane));
                }
            }
        }
    }

    /// Half of the rays in a register. Few ever come to a full test, so their shears are computed when they do.
    #[inline(always)]
    fn four(&self, longest: usize, register: usize, half: Half) -> FourRays<S> {
        let simd = self.simd;
        let axes = RayKernel::axes_along(longest);
        let [x, y, z] = self.of_half(&self.directions, axes, register, half);
        FourRays {
            origin: self.of_half(&self.origins, axes, register, half),
            shear: [simd.div(x, z), simd.div(y, z)],
            direction_z: z,
        }
    }

    #[inline(always)]
    fn consider(&mut self, ray: usize, id: u32, new: Option<TriangleHit>) {
        let (_, t_max) = self.rays[ray];
        if let Some(new) = new.filter(|new| new.t < t_max) {
            let nearest = Hit::nearer(self.hits[ray], id, new);
            self.hits[ray] = Some(nearest);
            self.limits[ray / LANES].0[ray % LANES] = later(nearest.t);
        }
    }
}

/// The least and the greatest of the numbers.
#[inline(always)]
fn range<S: Simd>(simd: S, numbers: &PerRay) -> [f32; 2] {
    let (a, b) = (simd.load(&numbers[0]), simd.load(&numbers[1]));
    [
        simd.least(simd.smaller(a, b)),
        simd.greatest(simd.larger(a, b)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::packet::tests::packet_rays;
    use crate::accel::simd::{self, Portable, Query};
    use crate::accel::tests::{rays, scenes};
    use crate::geometry::Triangle;
    use crate::geometry::shapes::Random;
    use crate::math::Bounds;

    /// What a packet finds in a block, and by triangle, which rays each of the filters lets pass.
    struct InBlock<'a> {
        packet: &'a Packet<'a>,
        block: &'a TriangleBlock,
        reach: f32,
    }

    impl Query for InBlock<'_> {
        type Answer = Option<(PacketHits, [[LaneSet; LANES]; 2])>;

        fn answer<S: Simd>(&self, simd: S) -> Self::Answer {
            let Self {
                packet,
                block,
                reach,
            } = *self;
            let mut rays = PacketRays::new(simd, packet, reach)?;
            let met = rays.span.may_meet(block, rays.last_limit());
            let mut passed = [[LaneSet::NONE; LANES]; 2];
            for longest in 0..3 {
                let group = rays.longest[longest].and(rays.all());
                let both = [
                    rays.passed_by_triangle(longest, group, block, met),
                    rays.passed_by_ray(longest, group, block),
                ];
                for (all, new) in passed.iter_mut().flatten().zip(both.into_iter().flatten()) {
                    *all = all.or(new);
                }
            }
            rays.visit(rays.all(), std::slice::from_ref(block));
            Some((rays.hits, passed))
        }
    }

    #[test]
    fn packets_find_in_a_block_what_the_kernel_finds() {
        let mut random = Random::new(61);
        let (mut hits, mut packets) = (0, 0);
        for (name, triangles) in scenes() {
            let ids: Vec<u32> = (0..).take(triangles.len()).collect();
            let bounds = Bounds::of_points(triangles.iter().flat_map(|triangle| triangle.corners));
            let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
            let chunks = ids.chunks(LANES).cycle();
            for (turn, (ray, ids)) in rays(&triangles, 62).iter().zip(chunks).enumerate() {
                let rays = packet_rays(&mut random, turn % 2, ray);
                let packet = &Packet::new(&rays);
                let block = &TriangleBlock::new(ids, &triangles);
                let query = InBlock {
                    packet,
                    block,
                    reach,
                };
                let found = simd::answer(&query);
                let portable = query.answer(Portable);
                assert_eq!(
                    found.as_ref().map(|(hits, _)| hits),
                    portable.as_ref().map(|(hits, _)| hits)
                );
                let Some((found, passed)) = found else {
                    continue;
                };
                packets += 1;
                for (index, (ray, t_max)) in rays.iter().enumerate() {
                    let kernel = RayKernel::new(ray);
                    let mut nearest = None;
                    for (lane, &id) in ids.iter().enumerate() {
                        let Some(hit) = kernel.intersect(&triangles[id as usize], *t_max) else {
                            continue;
                        };
                        nearest = Some(Hit::nearer(nearest, id, hit));
                        for passed in &passed {
                            let passes = passed[lane].into_iter().any(|ray| ray == index);
                            assert!(passes, "{name}: {ray:?} misses triangle {id}");
                        }
                        hits += 1;
                    }
                    assert_eq!(found[index], nearest, "{name}: {ray:?}");
                }
            }
        }
        assert!(hits > 1000 && packets > 1000, "{hits}, {packets}");
    }

    #[test]
    fn a_ray_that_ends_nowhere_hits_nothing_and_leaves_the_others_their_hits() {
        let triangle = Triangle {
            corners: [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]].map(Into::into),
        };
        let block = &TriangleBlock::new(&[0], &[triangle]);
        let ray = Ray::new([0.1, 0.1, 2.0].into(), [0.01, 0.01, -1.0].into());
        for nowhere in 0..Packet::MOST_RAYS {
            let mut rays = [(ray, f32::INFINITY); Packet::MOST_RAYS];
            rays[nowhere].1 = f32::NAN;
            let packet = &Packet::new(&rays);
            let query = InBlock {
                packet,
                block,
                reach: 3.0,
            };
            let (hits, _) = simd::answer(&query).unwrap();
            for (index, hit) in hits.iter().enumerate() {
                assert_eq!(hit.is_some(), index != nowhere);
            }
        }
    }
}
