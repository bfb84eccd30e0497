//! A render that is kept on disk while it runs, to be gone on with when the program is killed.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::event::Event;
use super::jobs::Job;
use super::keeping::KeptRender;
use super::worker::RenderRequest;
use crate::io::describe_render;
use crate::render::{Checkpoint, Layer, PictureMemory, PreparedScene};

/// The least time between two checkpoints.
const LEAST_INTERVAL: Duration = Duration::from_secs(1);

/// The most that they may take of a render's time.
pub const MOST_SHARE: f64 = 0.01;

/// What is thought to be copied, packed and written in a second, until it is known how long the first takes: 240 MB were measured.
const BYTES_PER_SECOND: f64 = 200e6;

/// What a checkpoint may hold beside the picture's sums, such as how the error fell.
const MOST_OTHER_BYTES: u64 = 1 << 24;

/// Keeps the checkpoints of one render.
pub struct RenderKeeper<'a> {
    job: &'a Job<Event>,
    request: &'a RenderRequest,
    kept: &'a KeptRender,
    layers: &'a [Layer],
    /// What the render takes with checkpoints.
    memory: PictureMemory,
    description: OnceLock<String>,
    /// Whether it was told that one cannot be kept.
    is_told: AtomicBool,
}

impl<'a> RenderKeeper<'a> {
    /// Of the render that is asked for, if it is one to be kept. `layers`: those that it keeps; `memory`: what it takes without
    /// checkpoints.
    pub fn new(
        job: &'a Job<Event>,
        request: &'a RenderRequest,
        layers: &'a [Layer],
        memory: PictureMemory,
    ) -> Option<Self> {
        let memory = PictureMemory {
            has_checkpoint: true,
            ..memory
        };
        let keeper = Self {
            job,
            request,
            kept: request.kept.as_deref()?,
            layers,
            memory,
            description: OnceLock::new(),
            is_told: AtomicBool::new(false),
        };
        if let Err(short) = memory.require() {
            keeper.tell(short.0.to_string());
            return None;
        }
        Some(keeper)
    }

    /// How long to wait before the first checkpoint, and at least between others.
    pub fn interval(&self, threads: usize) -> Duration {
        let seconds = self.memory.checkpoint_bytes() as f64 / BYTES_PER_SECOND;
        let seconds = seconds / (MOST_SHARE * threads as f64);
        Duration::try_from_secs_f64(seconds).map_or(Duration::MAX, |time| time.max(LEAST_INTERVAL))
    }

    /// What to go on from.
    pub fn start(&self, prepared: &PreparedScene) -> Result<Checkpoint, String> {
        let description = self.description();
        // Small numbers take up to a quarter more in the file than in memory.
        let most = 2 * self.memory.bytes() + description.len() as u64 + MOST_OTHER_BYTES;
        let loaded = self.kept.checkpoint(description, most);
        let checkpoint = loaded.map_err(|error| error.reason)?;
        if checkpoint.fits(prepared, self.kept.about().region, self.layers) {
            Ok(checkpoint)
        } else {
            Err("its parts do not fit the render".to_owned())
        }
    }

    /// Keeps `checkpoint`. That it cannot be is told once.
    pub fn keep(&self, checkpoint: &Checkpoint) {
        let scene = &self.request.scene;
        if let Err(error) = self.kept.keep(scene, self.description(), checkpoint) {
            self.tell(error);
        }
    }

    fn description(&self) -> &str {
        self.description.get_or_init(|| {
            let region = self.kept.about().region;
            describe_render(&self.request.scene, region, self.layers)
        })
    }

    fn tell(&self, reason: String) {
        if !self.is_told.swap(true, Ordering::Relaxed) {
            self.job.send(Event::RenderNotKept(reason));
        }
    }
}
