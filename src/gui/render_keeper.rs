//! A render that is kept on disk while it runs, to be gone on with when the program is killed.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::event::Event;
use super::jobs::Job;
use super::keeping::KeptRender;
use super::worker::RenderRequest;
use crate::io::{LoggedBlocks, block_record, describe_render};
use crate::render::{
    Block, BlockHeader, BlockStore, Checkpoint, CheckpointKeeper, Layer, PictureMemory,
    PreparedScene,
};

/// The least time between two checkpoints.
const LEAST_INTERVAL: Duration = Duration::from_secs(1);

/// The most that they may take of a render's time.
const MOST_SHARE: f64 = 0.01;

/// The most that blocks of samples may take of it, beside [`BLOCK_CREDIT`]. From passes of a few samples on, all fit in; before, those that
/// do not are taken anew when the render goes on, which takes no longer than they took at first.
const MOST_BLOCK_SHARE: f64 = 0.02;

/// What blocks may take beyond their share, so that those of a render's first seconds are kept.
const BLOCK_CREDIT: Duration = Duration::from_millis(200);

/// Bytes of blocks that are written in any case, and in every second of a render beside: the last seconds of one that takes hours are not
/// worth wearing out a disk.
const FREE_BLOCK_BYTES: f64 = 1e9;
const BLOCK_BYTES_PER_SECOND: f64 = 4e6;

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
    /// `None` when cancelled before it was there.
    description: OnceLock<Option<String>>,
    threads: usize,
    started: Instant,
    /// Whether the first log of blocks is being begun, and is there.
    is_beginning: AtomicBool,
    has_log: AtomicBool,
    /// Nanoseconds that keeping blocks took, and their bytes.
    spent: AtomicU64,
    written: AtomicU64,
    /// The blocks that were there when the render went on.
    known: OnceLock<LoggedBlocks>,
    /// Whether it was told that one cannot be kept.
    is_told: AtomicBool,
}

/// Where a render goes on.
pub struct Start {
    pub checkpoint: Checkpoint,
    /// The share of the samples that need not be taken again, `0..=1`.
    pub share_done: f64,
    /// When the last of them was there, in seconds of wall time of the render.
    pub seconds: f64,
}

impl<'a> RenderKeeper<'a> {
    /// Of the render that is asked for, if it is one to be kept. `layers`: those that it keeps; `memory`: what it takes without
    /// checkpoints; `threads`: those that render.
    pub fn new(
        job: &'a Job<Event>,
        request: &'a RenderRequest,
        layers: &'a [Layer],
        memory: PictureMemory,
        threads: usize,
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
            threads,
            started: Instant::now(),
            is_beginning: AtomicBool::new(false),
            has_log: AtomicBool::new(false),
            spent: AtomicU64::new(0),
            written: AtomicU64::new(0),
            known: OnceLock::new(),
            is_told: AtomicBool::new(false),
        };
        if let Err(short) = memory.require() {
            keeper.tell(short.0.to_string());
            return None;
        }
        Some(keeper)
    }

    /// When checkpoints are kept, and that `keep` keeps them, which calls [`Self::keep`].
    pub fn checkpoints<'k>(&self, keep: &'k (dyn Fn(Checkpoint) + Sync)) -> CheckpointKeeper<'k> {
        let seconds = self.memory.checkpoint_bytes() as f64 / BYTES_PER_SECOND;
        let seconds = seconds / (MOST_SHARE * self.threads as f64);
        let every = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        CheckpointKeeper {
            every: every.max(LEAST_INTERVAL),
            most_share: MOST_SHARE,
            keep,
        }
    }

    /// What to go on from; `None` when cancelled.
    ///
    /// # Errors
    /// Why there is nothing to go on from, in words.
    pub fn start(&self, prepared: &PreparedScene) -> Result<Option<Start>, String> {
        let Some(description) = self.description() else {
            return Ok(None);
        };
        // Small numbers take up to a quarter more in the file than in memory.
        let most = 2 * self.memory.bytes() + description.len() as u64 + MOST_OTHER_BYTES;
        let region = self.kept.about().region;
        let (cancel, progress) = (&self.job.cancel, &self.request.reading);
        let read = self.kept.read(description, most, cancel, progress)?;
        let Some((checkpoint, blocks)) = read else {
            return Ok(None);
        };
        let checkpoint =
            checkpoint.unwrap_or_else(|| Checkpoint::before(prepared, region, self.layers));
        if !checkpoint.fits(prepared, region, self.layers) {
            return Err("its parts do not fit the render".to_owned());
        }
        let blocks = self
            .known
            .get_or_init(|| blocks)
            .headers()
            .iter()
            .filter(|block| checkpoint.lacks(block.pass, block.tile));
        let (mut samples, mut seconds) = (0, checkpoint.seconds());
        for BlockHeader {
            samples: more,
            seconds: end,
            ..
        } in blocks
        {
            samples += more;
            seconds = end.max(seconds);
        }
        Ok(Some(Start {
            share_done: checkpoint.share_done(samples),
            seconds,
            checkpoint,
        }))
    }

    /// Keeps `checkpoint`. That it cannot be is told once.
    pub fn keep(&self, checkpoint: &Checkpoint) {
        let Some(description) = self.description() else {
            return;
        };
        let scene = &self.request.scene;
        let known = self.known.get().map_or(&[][..], LoggedBlocks::headers);
        let mut known = known.iter();
        let needs_old = known.any(|block| checkpoint.lacks(block.pass, block.tile));
        let kept = self
            .kept
            .keep(scene, description, checkpoint, needs_old, &self.job.cancel);
        if let Err(error) = kept {
            self.tell(error);
        }
    }

    /// Begins a log of blocks. That it cannot be is not told: of a checkpoint it will be.
    fn begin_log(&self) {
        let Some(description) = self.description() else {
            return;
        };
        let begun = self.kept.begin_log(&self.request.scene, description);
        self.has_log.store(begun.is_ok(), Ordering::Relaxed);
    }

    /// What the render is of; `None` when cancelled.
    fn description(&self) -> Option<&str> {
        let description = self.description.get_or_init(|| {
            let region = self.kept.about().region;
            describe_render(&self.request.scene, region, self.layers, &self.job.cancel)
        });
        description.as_deref()
    }

    /// Whether blocks have taken all the time by now that they may, or all the room.
    fn is_spent(&self) -> bool {
        let seconds = self.request.throttle.time_since(self.started);
        let seconds = seconds.as_secs_f64();
        let share = seconds * self.threads as f64 * MOST_BLOCK_SHARE;
        let spent = Duration::from_nanos(self.spent.load(Ordering::Relaxed));
        let room = FREE_BLOCK_BYTES + seconds * BLOCK_BYTES_PER_SECOND;
        spent.as_secs_f64() > share + BLOCK_CREDIT.as_secs_f64()
            || self.written.load(Ordering::Relaxed) as f64 > room
    }

    fn tell(&self, reason: String) {
        if !self.is_told.swap(true, Ordering::Relaxed) {
            self.job.send(Event::RenderNotKept(reason));
        }
    }
}

impl BlockStore for RenderKeeper<'_> {
    fn begin_anew(&self) {
        self.is_beginning.store(true, Ordering::Relaxed);
        self.begin_log();
    }

    fn keep(&self, block: &Block<'_>) {
        // To describe a scene of large meshes takes time, for which the other threads do not wait.
        if !self.is_beginning.swap(true, Ordering::Relaxed) {
            self.begin_log();
        }
        if self.is_spent() || !self.has_log.load(Ordering::Relaxed) {
            return;
        }
        let started = Instant::now();
        let record = block_record(block);
        self.kept.log_block(&record);
        let taken = u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.spent.fetch_add(taken, Ordering::Relaxed);
        self.written
            .fetch_add(record.len() as u64, Ordering::Relaxed);
    }

    fn recall(&self, pass: u32, tile: u32) -> Option<Block<'static>> {
        self.known.get()?.find(pass, tile)
    }
}
