//! The rays of a packet side by side, and their tests against boxes and triangles.
//!
//! In a leaf, a triangle is tested with all rays at once where many of them may meet it, as rays of one packet mostly meet the
//! same few triangles. Lane by lane this is the arithmetic of a ray by itself.

use super::node::Node;
use super::span::Span;
use crate::accel::Hit;
use crate::accel::block::{Filter, TriangleBlock};
use crate::accel::full::{FullTests, KernelRays};
use crate::accel::leaf::decide;
use crate::accel::packet::{Packet, PacketHits};
use crate::accel::simd::{LANES, LaneSet, Places, Simd, WIDE_LANES, WideLanes, splat_all};
use crate::accel::slabs::{MARGIN, later, may_hold_hits, ordinary};
use crate::geometry::{RayKernel, TriangleHit};

const NOTHING: WideLanes = WideLanes([0.0; WIDE_LANES]);

/// For fewer rays it is not asked which triangles of a block they can meet together.
const MANY_RAYS: usize = 4;

/// What is known of a packet's rays, side by side.
pub(super) struct PacketRays<'a, S: Simd> {
    simd: S,
    packet: &'a Packet,
    pub span: Span<S>,
    /// By axis, reciprocals of the directions.
    inverses: [WideLanes; 3],
    /// Where each ray ends so far, moved outwards; before its start in lanes without a ray. No NaN.
    limits: WideLanes,
    /// By axis, the rays whose [`RayKernel`] calls it z: rays of one such axis are tested together.
    longest: [LaneSet; 3],
    /// By that axis, the [`Filter::unshear`] of its rays.
    unshears: [[WideLanes; 2]; 3],
    pub hits: PacketHits,
}

impl<'a, S: Simd> PacketRays<'a, S> {
    /// For boxes whose coordinates are at most `reach` in magnitude. `None` where the rays differ in the sign of a direction, where
    /// one is out of the ordinary, and where there is none.
    #[inline(always)]
    pub fn new(simd: S, packet: &'a Packet, reach: f32) -> Option<Self> {
        if packet.count() == 0 {
            return None;
        }
        let Packet {
            origins,
            directions,
            ..
        } = packet;
        let mut inverses = [NOTHING; 3];
        let mut all_ordinary = LaneSet::first(WIDE_LANES);
        for (direction, inverse) in directions.iter().zip(&mut inverses) {
            let direction = simd.load_wide(direction);
            all_ordinary = all_ordinary.and(ordinary(simd, direction));
            *inverse = simd.store_wide(simd.div(simd.splat(1.0), direction));
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
        if all_ordinary != LaneSet::first(WIDE_LANES) || !farthest.is_finite() {
            return None;
        }

        // As `later` computes it.
        let limits = simd.mul(simd.load_wide(&packet.t_max), simd.splat(1.0 + MARGIN));
        let limits = simd.add(limits, simd.splat(f32::MIN_POSITIVE));
        let limits = simd.larger(limits, simd.splat(-1.0));
        let mut rays = Self {
            simd,
            packet,
            span: Span::new(simd, origin_range, inverse_range)?,
            inverses,
            limits: simd.store_wide(limits),
            longest: [LaneSet::NONE; 3],
            unshears: [[NOTHING; 2]; 3],
            hits: [None; Packet::MOST_RAYS],
        };
        rays.name_axes();
        Some(rays)
    }

    /// Renames the axes of the rays as [`RayKernel::axes_of`] does, and shears them.
    #[inline(always)]
    fn name_axes(&mut self) {
        let simd = self.simd;
        let direction = self.in_order(&self.packet.directions, [0, 1, 2]);
        let [x, y, z] = [
            simd.abs(direction[0]),
            simd.abs(direction[1]),
            simd.abs(direction[2]),
        ];
        let along_z = simd.less(simd.larger(y, x), z);
        let along_y = simd.less(x, y).and_not(along_z);
        let along_x = LaneSet::first(WIDE_LANES).and_not(along_y).and_not(along_z);
        for (longest, lanes) in [along_x, along_y, along_z].into_iter().enumerate() {
            if lanes.is_empty() {
                continue;
            }
            self.longest[longest] = lanes;
            let [x, y, z] = RayKernel::axes_along(longest);
            let minus_z = simd.sub(simd.splat(0.0), direction[z]);
            let [unshear_x, unshear_y] = &mut self.unshears[longest];
            *unshear_x = simd.store_wide(simd.div(direction[x], minus_z));
            *unshear_y = simd.store_wide(simd.div(direction[y], minus_z));
        }
    }

    /// All rays.
    #[inline(always)]
    pub fn all(&self) -> LaneSet {
        LaneSet::first(self.packet.count())
    }

    /// The greatest of the rays' limits.
    #[inline(always)]
    pub fn last_limit(&self) -> f32 {
        let [_, last] = range(self.simd, &self.limits);
        last
    }

    /// Numbers of the rays, in the order of `axes`.
    #[inline(always)]
    fn in_order(&self, numbers: &[WideLanes; 3], axes: [usize; 3]) -> [S::F32x16; 3] {
        let simd = self.simd;
        let [x, y, z] = axes;
        [
            simd.load_wide(&numbers[x]),
            simd.load_wide(&numbers[y]),
            simd.load_wide(&numbers[z]),
        ]
    }

    /// Which rays meet the box in a lane of a node before their limits: what a ray by itself would say of it.
    #[inline(always)]
    pub fn meeting(&self, node: &Node, lane: usize) -> LaneSet {
        let simd = self.simd;
        let mut start = simd.splat(0.0);
        let mut end = simd.load_wide(&self.limits);
        for axis in 0..3 {
            let planes = &node.planes[axis];
            let backward = self.span.backward[axis] & 1;
            let origin = simd.load_wide(&self.packet.origins[axis]);
            let inverse = simd.load_wide(&self.inverses[axis]);
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
                let mut left = self.passed(longest, rays, block);
                let mut lane = 0;
                loop {
                    let pairs = Pairs::take(&mut left, &mut lane, S::DOUBLES_PER_REGISTER);
                    if pairs.count == 0 {
                        break;
                    }
                    self.test(longest, block, pairs);
                }
            }
        }
    }

    /// By triangle, which of the rays may hit it before their limits.
    #[inline(always)]
    fn passed(&self, longest: usize, rays: LaneSet, block: &TriangleBlock) -> [LaneSet; LANES] {
        if rays.count() >= MANY_RAYS {
            let met = self.span.may_meet(block, self.last_limit());
            if met.count() * S::REGISTERS_PER_PACKET < rays.count() {
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
        let filter = Filter {
            simd,
            origin: self.in_order(&self.packet.origins, axes),
            unshear: [simd.load_wide(unshear_x), simd.load_wide(unshear_y)],
            direction_z: simd.load_wide(&self.packet.directions[longest]),
        };
        let limits = simd.load_wide(&self.limits);
        let mut passed = [LaneSet::NONE; LANES];
        for lane in lanes {
            let corners = block.one_in_sixteen(simd, axes, lane);
            passed[lane] = filter.may_hit(rays, &corners, limits);
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
            let origin = [
                self.packet.origins[x].0[ray],
                self.packet.origins[y].0[ray],
                self.packet.origins[z].0[ray],
            ];
            let filter = Filter {
                simd,
                origin: splat_all(simd, origin),
                unshear: [simd.splat(unshear_x.0[ray]), simd.splat(unshear_y.0[ray])],
                direction_z: simd.splat(self.packet.directions[z].0[ray]),
            };
            let limit = simd.splat(self.limits.0[ray]);
            for triangle in filter.may_hit(occupied, &corners, limit) {
                passed[triangle].insert(ray);
            }
        }
        passed
    }

    /// The full test of pairs of rays and triangles of a block.
    #[inline(always)]
    fn test(&mut self, longest: usize, block: &TriangleBlock, pairs: Pairs) {
        let simd = self.simd;
        let [x, y, z] = RayKernel::axes_along(longest);
        let Packet {
            origins,
            directions,
            ..
        } = self.packet;
        // Few rays ever come to a full test, so their shears are computed when they do.
        let direction_z = simd.pick_wide(&directions[z], pairs.rays);
        let rays = KernelRays {
            origin: [
                simd.pick_wide(&origins[x], pairs.rays),
                simd.pick_wide(&origins[y], pairs.rays),
                simd.pick_wide(&origins[z], pairs.rays),
            ],
            shear: [
                simd.div(simd.pick_wide(&directions[x], pairs.rays), direction_z),
                simd.div(simd.pick_wide(&directions[y], pairs.rays), direction_z),
            ],
            direction_z,
        };
        let mut corners = [[direction_z; 3]; 3];
        for (corner, from) in corners.iter_mut().zip(&block.corners) {
            for (coordinates, axis) in corner.iter_mut().zip([x, y, z]) {
                *coordinates = simd.pick(&from[axis], pairs.lanes);
            }
        }
        let tests = FullTests::new(simd, &rays, &corners, LaneSet::first(pairs.count));
        let hits = tests.hits();
        for pair in tests.met {
            let id = block.ids[pairs.lanes.get(pair) % LANES];
            self.consider(pairs.rays.get(pair), id, hits.get(pair));
        }
        for pair in tests.undecided {
            let (index, lane) = (pairs.rays.get(pair), pairs.lanes.get(pair) % LANES);
            let (ray, t_max) = self.packet.ray(index);
            self.consider(index, block.ids[lane], decide(&ray, t_max, block, lane));
        }
    }

    #[inline(always)]
    fn consider(&mut self, ray: usize, id: u32, new: Option<TriangleHit>) {
        let t_max = self.packet.t_max.0[ray];
        if let Some(new) = new.filter(|new| new.t < t_max) {
            let nearest = Hit::nearer(self.hits[ray], id, new);
            self.hits[ray] = Some(nearest);
            self.limits.0[ray] = later(nearest.t);
        }
    }
}

/// Pairs of a ray and a triangle of a block that are tested side by side.
#[derive(Clone, Copy, Default)]
struct Pairs {
    rays: Places,
    /// Of the triangles.
    lanes: Places,
    count: usize,
}

impl Pairs {
    /// Takes up to `most` pairs out of the rays that are left by triangle, from `lane` on.
    #[inline(always)]
    fn take(left: &mut [LaneSet; LANES], lane: &mut usize, most: usize) -> Self {
        let mut pairs = Self::default();
        while pairs.count < most && *lane < LANES {
            if let Some(ray) = left[*lane].take_first() {
                pairs.rays.put(pairs.count, ray);
                pairs.lanes.put(pairs.count, *lane);
                pairs.count += 1;
            } else {
                *lane += 1;
            }
        }
        pairs
    }
}

/// The least and the greatest of the numbers.
#[inline(always)]
fn range<S: Simd>(simd: S, numbers: &WideLanes) -> [f32; 2] {
    let numbers = simd.load_wide(numbers);
    [simd.least(numbers), simd.greatest(numbers)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::packet::tests::packet_rays;
    use crate::accel::simd::{self, Query};
    use crate::accel::tests::{rays, scenes};
    use crate::geometry::Triangle;
    use crate::geometry::shapes::Random;
    use crate::math::{Bounds, Ray};

    /// What a packet finds in a block, and by triangle, which rays each of the filters lets pass.
    struct InBlock<'a> {
        packet: &'a Packet,
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
                let answers = simd::answers(&query);
                let is_packet = |found: &Option<_>| found.is_some() == answers[0].is_some();
                assert!(answers.iter().all(is_packet), "{name}: {packet:?}");
                packets += usize::from(answers[0].is_some());
                for (index, (ray, t_max)) in rays.iter().enumerate() {
                    let kernel = RayKernel::new(ray);
                    let mut nearest = None;
                    for (lane, &id) in ids.iter().enumerate() {
                        let Some(hit) = kernel.intersect(&triangles[id as usize], *t_max) else {
                            continue;
                        };
                        nearest = Some(Hit::nearer(nearest, id, hit));
                        for passed in answers.iter().flatten().flat_map(|(_, passed)| passed) {
                            let passes = passed[lane].contains(index);
                            assert!(passes, "{name}: {ray:?} misses triangle {id}");
                        }
                        hits += 1;
                    }
                    for (found, _) in answers.iter().flatten() {
                        assert_eq!(found[index], nearest, "{name}: {ray:?}");
                    }
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
            for (hits, _) in simd::answers(&query).into_iter().flatten() {
                for (index, hit) in hits.iter().enumerate() {
                    assert_eq!(hit.is_some(), index != nowhere);
                }
            }
        }
    }
}
