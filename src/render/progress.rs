//! What a running render tells other threads: how far it is, how its error falls, and which tiles it is at.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::error::{ErrorEstimate, Interval};
use super::tiles::Region;
use crate::control::Progress;

/// The levels of noise whose time is predicted: 10, 3 and 1 per cent.
pub const NOISE_TARGETS: [f64; 3] = [0.10, 0.03, 0.01];

/// A running render's state for whoever watches; clones see the same render.
#[derive(Clone, Debug, Default)]
pub struct RenderProgress {
    /// In camera samples: their done fraction is that of the work, as far as it is known.
    pub samples: Progress,
    rays: Arc<AtomicU64>,
    errors: Arc<Mutex<Vec<ErrorPoint>>>,
    /// The tiles that are being rendered.
    pub in_hand: TilesInHand,
}

/// The tiles that the threads of a render are at, as far as anybody wants to see them.
#[derive(Clone, Debug, Default)]
pub struct TilesInHand(Arc<Mutex<Vec<Option<Region>>>>);

impl TilesInHand {
    /// Where they lie in the full picture, a tile for each thread that works.
    #[must_use]
    pub fn tiles(&self) -> Vec<Region> {
        self.lock().iter().copied().flatten().collect()
    }

    /// From now on thread number `thread` is at `tile`.
    pub(super) fn set(&self, thread: usize, tile: Option<Region>) {
        let mut tiles = self.lock();
        if tiles.len() <= thread {
            tiles.resize(thread + 1, None);
        }
        tiles[thread] = tile;
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Option<Region>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The error at a moment of a render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorPoint {
    /// Wall time since the start; that of a [`super::Watch`] does not count.
    pub seconds: f64,
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// How large it is.
    pub error: ErrorEstimate,
    /// When noise falls to each of [`NOISE_TARGETS`], in seconds since the start; `None` where it is there already, or never will
    /// be.
    pub time_to: [Option<Interval>; NOISE_TARGETS.len()],
    /// The same for the noise at which the render is to stop.
    pub time_to_stop: Option<Interval>,
}

impl RenderProgress {
    /// Rays traced so far; those before the checkpoint that a render goes on from do not count.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// What is known about the error, from point number `first` on.
    #[must_use]
    pub fn errors_from(&self, first: usize) -> Vec<ErrorPoint> {
        self.errors().get(first..).unwrap_or_default().to_vec()
    }

    /// What is known last.
    #[must_use]
    pub fn latest_error(&self) -> Option<ErrorPoint> {
        self.errors().last().copied()
    }

    pub(super) fn count_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    pub(super) fn note(&self, point: ErrorPoint) {
        self.errors().push(point);
    }

    fn errors(&self) -> MutexGuard<'_, Vec<ErrorPoint>> {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
