//! What the rays from the eye hit, kept from one render to the next: a new light or material changes nothing about it.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::camera::PreparedCamera;
use super::geometry::PreparedGeometry;
use crate::accel::Hit;

/// What the one ray of each pixel hits, lights aside, as far as it is known.
#[derive(Debug)]
pub(super) struct PrimaryHits {
    geometry: Arc<PreparedGeometry>,
    camera: PreparedCamera,
    size: (u32, u32),
    /// Row by row.
    hits: Vec<OnceLock<Option<Hit>>>,
}

/// Keeps what the rays from the eye hit for the next render, whatever that is of. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct PrimaryHitStore(Arc<Mutex<Option<Arc<PrimaryHits>>>>);

impl PrimaryHits {
    /// The bytes of a pixel.
    pub const BYTES_PER_PIXEL: usize = size_of::<OnceLock<Option<Hit>>>();

    fn new(geometry: &Arc<PreparedGeometry>, camera: &PreparedCamera, size: (u32, u32)) -> Self {
        let pixels = size.0 as usize * size.1 as usize;
        Self {
            geometry: Arc::clone(geometry),
            camera: camera.clone(),
            size,
            hits: std::iter::repeat_with(OnceLock::new).take(pixels).collect(),
        }
    }

    /// Whether it is known what the ray of a pixel hits.
    #[inline]
    pub fn knows(&self, pixel: (u32, u32)) -> bool {
        self.hits[self.index(pixel)].get().is_some()
    }

    /// What the ray of a pixel hits, as far as it is known.
    #[inline]
    pub fn of(&self, pixel: (u32, u32)) -> Option<Hit> {
        self.hits[self.index(pixel)].get().copied().flatten()
    }

    /// A pixel's ray hits this.
    pub fn keep(&self, pixel: (u32, u32), hit: Option<Hit>) {
        // Whoever else has found it has found the same.
        let _ = self.hits[self.index(pixel)].set(hit);
    }

    fn index(&self, (x, y): (u32, u32)) -> usize {
        y as usize * self.size.0 as usize + x as usize
    }
}

impl PrimaryHitStore {
    /// The hits of the last render, where it had the same triangles, camera and size; else none yet, and those of the last are
    /// forgotten.
    pub(super) fn of(
        &self,
        geometry: &Arc<PreparedGeometry>,
        camera: &PreparedCamera,
        size: (u32, u32),
    ) -> Arc<PrimaryHits> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let are_these = |hits: &&Arc<PrimaryHits>| {
            Arc::ptr_eq(&hits.geometry, geometry) && hits.camera == *camera && hits.size == size
        };
        if let Some(hits) = kept.as_ref().filter(are_these) {
            return Arc::clone(hits);
        }
        *kept = None;
        Arc::clone(kept.insert(Arc::new(PrimaryHits::new(geometry, camera, size))))
    }

    /// Forgets what is kept: the memory is free when no render uses it any more.
    pub fn clear(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
