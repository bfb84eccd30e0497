//! A render that is kept on disk while it runs, to be gone on with when the program is killed.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use super::event::Event;
use super::jobs::Job;
use super::keeping::{KeptRender, MOST_WAITING_BYTES, RenderWriter, Subject};
use super::worker::RenderRequest;
use crate::io::LoggedBlocks;
use crate::render::{
    Block, BlockHeader, BlockStore, Checkpoint, CheckpointKeeper, Layer, PictureMemory,
    PreparedScene, StopRules,
};

/// The least time between two checkpoints.
const LEAST_INTERVAL: Duration = Duration::from_secs(1);

/// The most that they may take of a render's time.
const MOST_SHARE: f64 = 0.01;

/// The most that blocks of samples may take of it in processor time, beside [`BLOCK_CREDIT`]. From passes of a few samples on, all fit in;
/// before, those that do not are taken anew when the render goes on, which takes no longer than they took at first.
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
    kept: &'a Arc<KeptRender>,
    layers: &'a [Layer],
    /// What the render takes with checkpoints.
    memory: PictureMemory,
    subject: Arc<Subject>,
    writer: RenderWriter,
    threads: usize,
    started: Instant,
    /// The blocks that were there when the render went on.
    known: OnceLock<LoggedBlocks>,
    /// By which rules it ends, as far as that was handed over.
    rules: Mutex<StopRules>,
}

/// Where a render goes on.
pub struct Start {
    pub checkpoint: Checkpoint,
    /// The share of the samples that need not be taken again, `0..=1`.
    pub share_of_samples: f64,
    /// When the last of them was there, in seconds of wall time of the render.
    pub seconds: f64,
}

impl Start {
    /// At `checkpoint`, and what is known beside: so many `samples`, the last after so many `seconds`.
    pub fn of(checkpoint: Checkpoint, samples: u64, seconds: f64) -> Self {
        Self {
            share_of_samples: checkpoint.share_done(samples),
            seconds: seconds.max(checkpoint.seconds()),
            checkpoint,
        }
    }

    /// The done part of a render that ends by `rules`, `0..=1`, as [`RenderProgress::share`](crate::render::RenderProgress::share) tells it:
    /// by samples or by the clock, whichever is nearer to ending it.
    pub fn share_done(&self, rules: &StopRules) -> f64 {
        let by_time = rules.stop.seconds.map(|limit| self.seconds / limit);
        by_time.unwrap_or(0.0).max(self.share_of_samples).min(1.0)
    }
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
        let kept = request.kept.as_ref()?;
        let memory = PictureMemory {
            has_checkpoint: true,
            kept_bytes: memory.kept_bytes + MOST_WAITING_BYTES,
            ..memory
        };
        if let Err(short) = memory.require() {
            job.send(Event::RenderNotKept(format!(
                "What is written to disk is copied in memory first. With the render itself that takes {} of memory, {}. A smaller \
                 picture or a region of it takes less, and so does one without layers (Keep layers).",
                short.0.needed_in_words(),
                short.0.why()
            )));
            return None;
        }
        let (scene, rules) = (request.scene.clone(), request.rules.clone());
        let region = kept.about().region;
        let subject = Arc::new(Subject::new(scene, region, layers.to_vec(), rules));
        let teller = job.clone();
        let tell = move |reason| teller.send(Event::RenderNotKept(reason));
        Some(Self {
            job,
            request,
            kept,
            layers,
            memory,
            writer: RenderWriter::begin(Arc::clone(kept), Arc::clone(&subject), tell),
            subject,
            threads,
            started: Instant::now(),
            known: OnceLock::new(),
            rules: Mutex::new(request.rules.get()),
        })
    }

    /// When checkpoints are kept, and that `keep` keeps them, which calls [`Self::keep`], as does `took` [`Self::took`].
    pub fn checkpoints<'k>(
        &self,
        keep: &'k (dyn Fn(Checkpoint) + Sync),
        took: &'k (dyn Fn() -> Option<Duration> + Sync),
    ) -> CheckpointKeeper<'k> {
        let seconds = self.memory.checkpoint_bytes() as f64 / BYTES_PER_SECOND;
        let seconds = seconds / (MOST_SHARE * self.threads as f64);
        let every = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        CheckpointKeeper {
            every: every.max(LEAST_INTERVAL),
            most_share: MOST_SHARE,
            keep,
            in_background: Some(took),
        }
    }

    /// What to go on from; `None` when cancelled.
    ///
    /// # Errors
    /// Why there is nothing to go on from, in words.
    pub fn start(&self, prepared: &PreparedScene) -> Result<Option<Start>, String> {
        let Some(description) = self.subject.description(&self.job.cancel) else {
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
        let (mut samples, mut seconds) = (0, 0.0_f64);
        for BlockHeader {
            samples: more,
            seconds: end,
            ..
        } in blocks
        {
            samples += more;
            seconds = end.max(seconds);
        }
        Ok(Some(Start::of(checkpoint, samples, seconds)))
    }

    /// Has `checkpoint` kept. That it cannot be is told once.
    pub fn keep(&self, checkpoint: Checkpoint) {
        let known = self.known.get().map_or(&[][..], LoggedBlocks::headers);
        let mut known = known.iter();
        let needs_old = known.any(|block| checkpoint.lacks(block.pass, block.tile));
        self.writer.keep(checkpoint, needs_old);
    }

    /// How long writing the last checkpoint took; `None` while it goes on.
    pub fn took(&self) -> Option<Duration> {
        self.writer.checkpoint_took()
    }

    /// Ends with the render. What it has reached last is still written where it `is_done`; where it is cancelled, nothing is any more.
    pub fn end(self, is_done: bool) {
        if !is_done {
            self.kept.give_up();
        }
    }

    /// Has the rules taken to disk, where they are others than those that were.
    fn keep_rules(&self) {
        let rules = self.request.rules.get();
        let mut known = self.rules.lock().unwrap_or_else(PoisonError::into_inner);
        if *known != rules {
            self.writer.keep_rules();
            *known = rules;
        }
    }

    /// Whether blocks have taken all the time by now that they may, or all the room.
    fn is_spent(&self) -> bool {
        let seconds = self.request.throttle.time_since(self.started);
        let seconds = seconds.as_secs_f64();
        let share = seconds * self.threads as f64 * MOST_BLOCK_SHARE;
        let (spent, written) = self.writer.spent_on_blocks();
        let room = FREE_BLOCK_BYTES + seconds * BLOCK_BYTES_PER_SECOND;
        spent.as_secs_f64() > share + BLOCK_CREDIT.as_secs_f64() || written as f64 > room
    }
}

impl BlockStore for RenderKeeper<'_> {
    fn begin_anew(&self) {
        self.writer.begin_log();
    }

    fn keep(&self, block: &Block<'_>) {
        self.keep_rules();
        if !self.is_spent() {
            self.writer.log(block);
        }
    }

    fn recall(&self, pass: u32, tile: u32) -> Option<Block<'static>> {
        self.known.get()?.find(pass, tile)
    }
}
