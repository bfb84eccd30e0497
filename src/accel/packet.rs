//! Rays that go almost the same way, as those of neighbouring pixels do.

use super::Hit;
use crate::math::Ray;

/// Up to sixteen rays and how far each is looked along: its `t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Packet<'a> {
    rays: &'a [(Ray, f32)],
}

/// The hits of a packet's rays, in their order; `None` beyond the last ray.
pub type PacketHits = [Option<Hit>; Packet::MOST_RAYS];

impl<'a> Packet<'a> {
    /// The most rays of a packet: those of 4 × 4 pixels.
    pub const MOST_RAYS: usize = 16;

    /// These rays, each with its `t_max`. That they go almost the same way saves time and changes no hit.
    ///
    /// # Panics
    /// When there are more than [`Packet::MOST_RAYS`].
    #[must_use]
    pub fn new(rays: &'a [(Ray, f32)]) -> Self {
        assert!(rays.len() <= Self::MOST_RAYS, "too many rays");
        Self { rays }
    }

    /// The rays, each with its `t_max`.
    #[must_use]
    pub fn rays(&self) -> &'a [(Ray, f32)] {
        self.rays
    }

    /// What `intersect` says of each ray.
    pub(super) fn each(&self, intersect: impl Fn(&Ray, f32) -> Option<Hit>) -> PacketHits {
        let mut hits = [None; Self::MOST_RAYS];
        for ((ray, t_max), hit) in self.rays.iter().zip(&mut hits) {
            *hit = intersect(ray, *t_max);
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
    use crate::math::Vec3;

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
