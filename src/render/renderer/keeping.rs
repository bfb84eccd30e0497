//! What is kept of a render while it goes on, so that another one can go on from there: checkpoints, and the samples of tiles.

use std::time::{Duration, Instant};

use super::Renderer;
use super::ahead::whole;
use crate::render::blocks::{Block, BlockHeader};
use crate::render::checkpoint::{Checkpoint, Course, Shared};
use crate::render::clock::Clock;
use crate::render::progress::RenderProgress;
use crate::render::run::CheckpointKeeper;
use crate::render::tile_samples::TileBlock;

/// Time between two looks at whether a checkpoint is kept by now.
const LOOK_INTERVAL: Duration = Duration::from_millis(2);

/// The last checkpoint.
pub struct LastKept {
    /// When it was kept, or the render began.
    at: Instant,
    /// How long keeping it took the thread that found it due; zero before the first.
    took: Duration,
}

impl LastKept {
    /// None so far, of a render that begins now.
    pub fn none() -> Self {
        Self {
            at: Instant::now(),
            took: Duration::ZERO,
        }
    }
}

impl Renderer<'_> {
    /// Has a checkpoint kept of all tiles that are done, however recent the last one is. Waits for that to be kept.
    pub(super) fn keep_last_checkpoint(&self) {
        if let Some(keeper) = self.watch.checkpoints {
            while keeper.took_in_background().is_none() && !self.run.cancel.is_cancelled() {
                std::thread::sleep(LOOK_INTERVAL);
            }
            self.take_checkpoint(keeper);
        }
    }

    /// Puts the samples that `block` asks for into it, where they were kept before the render went on. Returns whether they were.
    pub(super) fn recall(&self, tile: usize, block: &mut TileBlock) -> bool {
        let known = self.watch.blocks;
        let Some(known) = known.and_then(|known| known.recall(self.course.passes, number(tile)))
        else {
            return false;
        };
        let header = known.header;
        let is_there = known.put_into(block, self.layers);
        if is_there {
            self.progress.samples.advance(header.samples);
            let BlockHeader {
                seconds,
                cpu_seconds,
                ..
            } = header;
            self.clock.bring_forward(seconds, cpu_seconds);
        }
        is_there
    }

    /// Has the samples of a tile kept.
    pub(super) fn keep(&self, tile: usize, block: &TileBlock) {
        if let Some(store) = self.watch.blocks {
            let time = [self.clock.seconds(), self.clock.cpu_seconds()];
            store.keep(&Block::new(self.course.passes, number(tile), time, block));
        }
    }

    /// Has a checkpoint kept where the last one is old enough. The thread that calls first is busy with it; the others go on with
    /// their tiles, and wait no longer than it takes to copy the film.
    pub(super) fn keep_checkpoint_if_due(&self) {
        let Some(keeper) = self.watch.checkpoints else {
            return;
        };
        let Ok(mut last) = self.last_kept.try_lock() else {
            return;
        };
        let Some(in_background) = keeper.took_in_background() else {
            return;
        };
        let share = keeper.most_share * self.crew.threads() as f64;
        let took = last.took + in_background;
        let rest = Duration::try_from_secs_f64(took.as_secs_f64() / share);
        if last.at.elapsed() >= keeper.every.max(rest.unwrap_or(Duration::MAX)) {
            let began = Instant::now();
            self.take_checkpoint(keeper);
            *last = LastKept {
                at: Instant::now(),
                took: began.elapsed(),
            };
        }
    }

    /// Has a checkpoint kept of what is there now.
    fn take_checkpoint(&self, keeper: CheckpointKeeper<'_>) {
        if let Some(store) = self.watch.blocks {
            store.begin_anew();
        }
        if let Some(checkpoint) = self.checkpoint() {
            (keeper.keep)(checkpoint);
        }
    }

    /// The render as it is now; `None` when cancelled.
    fn checkpoint(&self) -> Option<Checkpoint> {
        let shared = self.lock().copy_unless(&self.run.cancel)?;
        let course = self.course.clone();
        Some(checkpoint_of(shared, course, &self.clock, self.progress))
    }

    /// Hands on what was reached to whoever may go on from there, where there is nothing to show for it.
    pub fn hand_on(self) {
        let Self {
            shared,
            course,
            clock,
            progress,
            watch,
            ..
        } = self;
        if let Some(at_end) = watch.at_end {
            let shared = shared.into_inner().expect("no thread panicked");
            at_end(checkpoint_of(shared, course, &clock, progress));
        }
    }

    /// [`Self::hand_on`] where the picture is still to be made of it, if there is room for a copy. Of a last pass that was shorter than it might
    /// be, what was there before is handed on: a longer render takes its samples in one pass with others.
    pub fn hand_on_copy(&mut self) {
        let Some(at_end) = self.watch.at_end.filter(|_| self.run.has_room) else {
            return;
        };
        let (shared, course) = match self.before_short_pass.take() {
            Some(before) => *before,
            None => match self.lock().copy_unless(&self.run.cancel) {
                Some(shared) => (shared, self.course.clone()),
                None => return,
            },
        };
        at_end(checkpoint_of(shared, course, &self.clock, self.progress));
    }
}

/// What a render has reached.
fn checkpoint_of(
    shared: Shared,
    course: Course,
    clock: &Clock,
    progress: &RenderProgress,
) -> Checkpoint {
    let done = shared.film.total_samples() as f64;
    let share = progress.share();
    Checkpoint {
        shared,
        course,
        seconds: clock.seconds(),
        cpu_seconds: clock.cpu_seconds(),
        errors: progress.errors_from(0),
        expected_samples: if share > 0.0 {
            whole(done / share)
        } else {
            progress.samples.total()
        },
    }
}

fn number(tile: usize) -> u32 {
    u32::try_from(tile).expect("even the largest picture has fewer tiles")
}
