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
