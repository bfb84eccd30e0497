//! Rays that go almost the same way, as those of neighbouring pixels do.

use super::Hit;
use super::simd::{WIDE_LANES, WideLanes};
use crate::math::{Ray, Vec3};

/// Up to sixteen rays and how far each is traced: its `t_max`. That they go almost the same way saves time and changes no hit.
#[derive(Clone, Debug)]
pub struct Packet {
    /// By axis. Lanes without a ray hold a copy of the first.
    pub(super) origins: [WideLanes; 3],
    /// By axis, likewise.
    pub(super) directions: [WideLanes; 3],
    /// −∞ in lanes without a ray.
    pub(super) t_max: WideLanes,
    count: usize,
}

/// The hits of a packet's rays, in their order; `None` beyond the last ray.
pub type PacketHits = [Option<Hit>; Packet::MOST_RAYS];

impl Packet {
    /// The most rays of a packet: those of 4 × 4 pixels.
    pub const MOST_RAYS: usize = WIDE_LANES;

    /// A packet without rays.
    #[must_use]
    pub fn empty() -> Self {
        const NOTHING: WideLanes = WideLanes([0.0; WIDE_LANES]);
        Self {
            origins: [NOTHING; 3],
            directions: [NOTHING; 3],
            t_max: WideLanes([f32::NEG_INFINITY; WIDE_LANES]),
            count: 0,
        }
    }

    /// These rays, each with its `t_max`.
    ///
    /// # Panics
    /// When there are more than [`Packet::MOST_RAYS`].
    #[must_use]
    pub fn new(rays: &[(Ray, f32)]) -> Self {
        let mut packet = Self::empty();
        for (ray, t_max) in rays {
            packet.push(ray, *t_max);
        }
        packet
    }

    /// Adds a ray, to be traced up to `t_max`.
    ///
    /// # Panics
    /// When there are [`Packet::MOST_RAYS`] already.
    #[inline]
    pub fn push(&mut self, ray: &Ray, t_max: f32) {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        if self.count == 0 {
            self.origins = origin.map(|x| WideLanes([x; WIDE_LANES]));
            self.directions = direction.map(|x| WideLanes([x; WIDE_LANES]));
        }
        for axis in 0..3 {
            self.origins[axis].0[self.count] = origin[axis];
            self.directions[axis].0[self.count] = direction[axis];
        }
        self.t_max.0[self.count] = t_max;
        self.count += 1;
    }

    /// How many rays there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The rays, each with its `t_max`.
    pub fn rays(&self) -> impl Iterator<Item = (Ray, f32)> {
        (0..self.count).map(|index| self.ray(index))
    }

    /// The ray in a lane, with its `t_max`.
    #[inline]
    pub(super) fn ray(&self, lane: usize) -> (Ray, f32) {
        let of_lane = |numbers: &[WideLanes; 3]| {
            let [x, y, z] = numbers;
            Vec3::new(x.0[lane], y.0[lane], z.0[lane])
        };
        let ray = Ray::new(of_lane(&self.origins), of_lane(&self.directions));
        (ray, self.t_max.0[lane])
    }

    /// What `intersect` says of each ray.
    pub(super) fn each(&self, intersect: impl Fn(&Ray, f32) -> Option<Hit>) -> PacketHits {
        let mut hits = [None; Self::MOST_RAYS];
        for ((ray, t_max), hit) in self.rays().zip(&mut hits) {
            *hit = intersect(&ray, t_max);
        }
        hits
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::accel::BruteForce;
    use crate::accel::tests::{bits, narrowed, rays, scenes, trees, whole};
    use crate::geometry::shapes::Random;

    /// Up to sixteen rays: almost parallel from one point or from a lens, along axes, or anywhere.
    pub(in crate::accel) fn packet_rays(
        random: &mut Random,
        kind: usize,
        ray: &Ray,
    ) -> Vec<(Ray, f32)> {
        let count = 1 + whole(random) % Packet::MOST_RAYS;
        let length = ray.direction.length();
        let spread = length * 2_f32.powi(-i32::try_from(whole(random) % 12).unwrap());
        (0..count)
            .map(|index| {
                let any = narrowed(random.in_cube());
                let direction = match kind {
                    0 | 1 => ray.direction + any * spread,
                    2 => Vec3::AXES[index % 3],
                    _ => any,
                };
                let origin = match kind {
                    1 => ray.origin + narrowed(random.in_cube()) * spread,
                    _ => ray.origin,
                };
                let t_max =
                    [f32::INFINITY, 0.9, 0.0][if index % 5 == 4 { 1 + index % 2 } else { 0 }];
                (Ray::new(origin, direction), t_max)
            })
            .filter(|(ray, _)| ray.direction != Vec3::ZERO)
            .collect()
    }

    #[test]
    fn packets_hold_the_rays_they_are_given() {
        let ray = |x: f32| Ray::new(Vec3::new(x, 1.0, 2.0), Vec3::new(3.0, -x, 0.5));
        let rays = [(ray(4.0), 7.0), (ray(-5.0), f32::INFINITY), (ray(6.0), 0.0)];
        let packet = Packet::new(&rays);
        assert_eq!(packet.count(), 3);
        assert!(packet.rays().eq(rays));
        assert_eq!(Packet::empty().rays().count(), 0);
    }

    #[test]
    fn packets_are_answered_as_ray_by_ray() {
        let (mut hits, mut misses) = (0, 0);
        for (name, triangles) in scenes() {
            let all = BruteForce::new(triangles.clone());
            let trees = trees(&triangles);
            let mut random = Random::new(41);
            for (turn, ray) in rays(&triangles, 42).iter().enumerate().step_by(9) {
                let rays = packet_rays(&mut random, turn % 4, ray);
                let packet = Packet::new(&rays);
                let expected = packet.each(|ray, t_max| all.intersect(ray, t_max));
                hits += expected.iter().flatten().count();
                misses += rays.len() - expected.iter().flatten().count();
                for tree in &trees {
                    let found = tree.intersect_packet(&packet);
                    assert_eq!(
                        found.map(bits),
                        expected.map(bits),
                        "{name}, {}: {packet:?}",
                        tree.name()
                    );
                }
            }
        }
        assert!(hits > 5000 && misses > 5000, "{hits}, {misses}");
    }
}
