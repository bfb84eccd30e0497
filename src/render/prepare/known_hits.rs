//! What is kept of the rays from the eye from one render to the next.

use super::PreparedScene;
use crate::render::plan::Feature;
use crate::render::primary_hits::{PrimaryHitStore, PrimaryHits};

impl PreparedScene {
    /// The same scene, whose rays from the eye are traced only where `store` does not know what they hit, and which leaves there what
    /// it finds. All samples of a pixel must send the same ray for that; else nothing is kept, and the store is cleared.
    #[must_use]
    pub fn with_primary_hits(self, store: &PrimaryHitStore) -> Self {
        let primary_hits = if self.sends_one_ray_per_pixel() {
            Some(store.of(&self.geometry, &self.camera, self.size()))
        } else {
            store.clear();
            None
        };
        Self {
            primary_hits,
            ..self
        }
    }

    /// What is known of the rays from the eye, where that is kept.
    pub(in crate::render) fn primary_hits(&self) -> Option<&PrimaryHits> {
        self.primary_hits.as_deref()
    }

    /// The bytes that [`Self::with_primary_hits`] would ask for.
    #[must_use]
    pub fn primary_hit_bytes(&self, store: &PrimaryHitStore) -> u64 {
        if self.sends_one_ray_per_pixel() {
            store.bytes_missing(&self.geometry, &self.camera, self.size())
        } else {
            0
        }
    }

    /// The same scene, of whose rays from the eye nothing is known.
    pub(in crate::render) fn without_primary_hits(&self) -> Self {
        Self {
            primary_hits: None,
            ..self.clone()
        }
    }

    /// Whether what the rays from the eye hit is kept.
    #[must_use]
    pub fn keeps_primary_hits(&self) -> bool {
        self.primary_hits.is_some()
    }

    fn sends_one_ray_per_pixel(&self) -> bool {
        !self.needs(Feature::PixelPoints) && !self.needs(Feature::Lens)
    }
}
