//! What the rays from the eye hit, kept from one render to the next: a new light or material changes nothing about it.

use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use super::camera::PreparedCamera;
use super::geometry::PreparedGeometry;
use crate::accel::Hit;

/// What the one ray of each pixel hits, lights aside, as far as it is known.
#[derive(Debug)]
pub(super) struct PrimaryHits {
    /// Whose hits they are: not kept alive by them.
    geometry: Weak<PreparedGeometry>,
    camera: PreparedCamera,
    size: (u32, u32),
    /// Row by row.
    hits: Vec<OnceLock<Option<Hit>>>,
}

/// Keeps what the rays from the eye hit for the next render, whatever that is of. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct PrimaryHitStore(Arc<Mutex<Option<Arc<PrimaryHits>>>>);

impl PrimaryHits {
    fn new(geometry: &Arc<PreparedGeometry>, camera: &PreparedCamera, size: (u32, u32)) -> Self {
        let pixels = size.0 as usize * size.1 as usize;
        Self {
            geometry: Arc::downgrade(geometry),
            camera: camera.clone(),
            size,
            hits: std::iter::repeat_with(OnceLock::new).take(pixels).collect(),
        }
    }

    fn are_of(
        &self,
        geometry: &Arc<PreparedGeometry>,
        camera: &PreparedCamera,
        size: (u32, u32),
    ) -> bool {
        self.geometry.as_ptr() == Arc::as_ptr(geometry)
            && self.camera == *camera
            && self.size == size
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

    /// Keeps what a pixel's ray hits.
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
        let are_these = |hits: &&Arc<PrimaryHits>| hits.are_of(geometry, camera, size);
        if let Some(hits) = kept.as_ref().filter(are_these) {
            return Arc::clone(hits);
        }
        *kept = None;
        Arc::clone(kept.insert(Arc::new(PrimaryHits::new(geometry, camera, size))))
    }

    /// The bytes that [`Self::of`] would ask for.
    pub(super) fn bytes_missing(
        &self,
        geometry: &Arc<PreparedGeometry>,
        camera: &PreparedCamera,
        size: (u32, u32),
    ) -> u64 {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let are_there = kept
            .as_ref()
            .is_some_and(|hits| hits.are_of(geometry, camera, size));
        let pixels = u64::from(size.0) * u64::from(size.1);
        let per_pixel = size_of::<OnceLock<Option<Hit>>>() as u64;
        if are_there { 0 } else { pixels * per_pixel }
    }

    /// Forgets what is kept: the memory is free when no render uses it any more.
    pub fn clear(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
