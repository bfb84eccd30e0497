//! The job of a render: its scene is prepared where it is not by now, it goes on from what is there of it, and every tile is sent.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::{Gpu, Placed, encode, prepare};
use crate::analysis::pilot;
use crate::control::{Progress, Throttle};
use crate::gui::event::Event;
use crate::gui::first_look::FirstLook;
use crate::gui::jobs::{Job, drop_elsewhere};
use crate::gui::keeping::KeptRender;
use crate::gui::picture_buffer::PictureBuffer;
use crate::gui::reached::{self, Reached, TakenUp};
use crate::gui::render_keeper::{RenderKeeper, Start};
use crate::render::{
    self, BlockStore, Checkpoint, CoarsePicture, Image, Layer, LiveRules, OnCoarse, OnRound,
    PictureMemory, PreparedScene, PrimaryHitStore, RenderOutcome, RenderProgress, Round, RunConfig,
    Sketch, SketchStore, TilePixels, Watch,
};
use crate::scene::{Scene, SceneError};

/// What a render job works with.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// Its number.
    pub number: usize,
    /// The scene as it is now.
    pub scene: Scene,
    /// What was prepared last.
    pub previous: Option<PreparedScene>,
    /// How to prepare the scene, where its triangles are others by now.
    pub preparation: Option<Preparation>,
    /// Where to wait until the first look is drawn; `None` where the render goes on meanwhile.
    pub first_look: Option<FirstLook>,
    /// What is known of the rays from the eye.
    pub primary_hits: PrimaryHitStore,
    /// Render threads; 0 is one per core.
    pub threads: usize,
    /// How many of them may work.
    pub throttle: Throttle,
    /// Where the picture goes. What it keeps is what is rendered.
    pub buffer: Arc<PictureBuffer>,
    /// What the window watches.
    pub progress: RenderProgress,
    /// How far what is on disk of it is read.
    pub reading: Progress,
    /// How long tiles may wait to be shown together.
    pub tile_delay: Duration,
    /// Where it is kept on disk.
    pub kept: Option<Arc<KeptRender>>,
    /// Whether it goes on from what is kept there.
    pub goes_on: bool,
    /// By which rules it ends, as the window has them.
    pub rules: LiveRules,
    /// Mean samples of a pixel that it takes, as far as that is known.
    pub expected_samples: Option<f64>,
    /// What it goes on from, where it takes up another that has ended.
    pub continues: Option<TakenUp>,
    /// Where what it has reached is left at its end; `None` where nobody will go on from there.
    pub reached: Option<Reached>,
}

/// How a render prepares its scene itself: a picture that follows what moves shows where that is first.
#[derive(Clone, Debug)]
pub struct Preparation {
    /// What was placed last.
    pub placed: Placed,
    /// What is kept from one sketch to the next.
    pub sketches: SketchStore,
    /// What uploads go to.
    pub gpu: Option<Gpu>,
    /// How far the structure is.
    pub progress: Progress,
    /// Whether something is held that moves on: before it rests, preparing would be in vain.
    pub is_held: bool,
}

/// How long something that is held must rest to be rendered as it is.
const HELD_REST: Duration = Duration::from_millis(150);

/// The share of a render's time that the error of each pixel may take while nobody looks at it.
const ERROR_LAYER_SHARE: f64 = 0.02;

/// Renders a scene, or goes on with that, sending every tile.
pub fn render(job: &Job<Event>, request: &RenderRequest) {
    prepare_and_render(job, request);
    // Where it was cancelled before it took that up.
    leave_for_another(request);
}

/// Leaves what the render was to take up, and has not, for one that is asked for after it.
fn leave_for_another(request: &RenderRequest) {
    if let (Some(taken_up), Some(reached)) = (&request.continues, &request.reached) {
        taken_up.reached.hand_on_to(reached);
    }
}

fn prepare_and_render(job: &Job<Event>, request: &RenderRequest) {
    let run = RunConfig {
        threads: request.threads,
        cancel: job.cancel.clone(),
        throttle: request.throttle.clone(),
        layers: !request.buffer.layers().is_empty(),
        rules: Some(request.rules.clone()),
        ..RunConfig::default()
    };
    let on_coarse = |coarse: &CoarsePicture| {
        if let Some(texels) = request.buffer.accept_coarse(coarse) {
            job.send(Event::Coarse(texels));
            if let Some(look) = &request.first_look {
                look.wait(&job.cancel);
            }
        }
    };
    let Some((prepared, is_sketched)) = prepared_to_render(job, request, &run, &on_coarse) else {
        return;
    };
    let memory = memory_of(request, &prepared, &run);
    let run = RunConfig {
        has_room: request.reached.is_some() && has_room(memory),
        ..run
    };
    if let Err(short) = memory.require() {
        request.primary_hits.clear();
        leave_for_another(request);
        return job.send(Event::RenderFailed {
            text: short.to_string(),
            is_short_of_memory: true,
        });
    }
    let prepared = prepared.with_primary_hits(&request.primary_hits);
    let layers = run.layers_of(&prepared);
    let keeper = RenderKeeper::new(job, request, layers, memory, run.thread_count());
    let start = match start(request, keeper.as_ref(), &prepared, layers) {
        Ok(start) => start,
        Err(reason) => return job.send(Event::RenderLost(reason)),
    };
    // Where it was to go on, it is offered again.
    if job.cancel.is_cancelled() {
        return;
    }
    let ready = Ready {
        prepared: &prepared,
        run: &run,
        keeper,
        start,
        on_coarse: (!is_sketched).then_some(&on_coarse as OnCoarse<'_>),
    };
    carry_out(job, request, ready);
    // A window on another scene by now holds nothing of it.
    drop_elsewhere(prepared);
}

/// A render that can begin.
struct Ready<'a> {
    prepared: &'a PreparedScene,
    run: &'a RunConfig,
    keeper: Option<RenderKeeper<'a>>,
    start: Option<Start>,
    on_coarse: Option<OnCoarse<'a>>,
}

/// Renders what is ready, and sends what comes of it.
fn carry_out(job: &Job<Event>, request: &RenderRequest, ready: Ready<'_>) {
    let Ready {
        prepared,
        run,
        keeper,
        start,
        on_coarse,
    } = ready;
    let region = request.buffer.part().region();
    let keep = |checkpoint: Checkpoint| {
        if let Some(keeper) = &keeper {
            keeper.keep(checkpoint);
        }
    };
    let keeping_took = || keeper.as_ref().and_then(RenderKeeper::took);
    let at_end = |checkpoint: Checkpoint| {
        if let Some(reached) = &request.reached {
            reached.set(checkpoint);
        }
    };
    let is_first = AtomicBool::new(true);
    let on_tile = |tile: &TilePixels<'_>| {
        if let Some(tile) = request.buffer.accept(tile) {
            // The first tile is what the user waits for.
            let delay = if is_first.swap(false, Ordering::Relaxed) {
                Duration::ZERO
            } else {
                request.tile_delay
            };
            job.send_within(Event::Tile(tile), delay);
        }
    };
    // What the layer of the error took when it was last made, in seconds.
    let error_layer_seconds = Mutex::new(0.0);
    let on_round = |round: &Round<'_>| {
        let mut seconds = error_layer_seconds
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        show_error_of(job, request, round, &mut seconds);
    };
    let keeps_error = request.buffer.layers().contains(&Layer::Error);
    let watch = Watch {
        on_coarse: on_coarse.filter(|_| start.is_none()),
        on_tile: Some(&on_tile),
        on_round: keeps_error.then_some(&on_round as OnRound<'_>),
        checkpoints: keeper
            .as_ref()
            .map(|keeper| keeper.checkpoints(&keep, &keeping_took)),
        blocks: keeper.as_ref().map(|keeper| keeper as &dyn BlockStore),
        at_end: request
            .reached
            .is_some()
            .then_some(&at_end as &(dyn Fn(Checkpoint) + Sync)),
    };
    let progress = &request.progress;
    expect_samples(request);
    let render = || match start {
        Some(start) => {
            job.send(Event::RenderGoesOn {
                share_done: start.share_done(&request.rules.get()),
                seconds: start.seconds,
            });
            let Start {
                checkpoint,
                share_of_samples,
                ..
            } = start;
            progress.go_on_at(share_of_samples);
            checkpoint.show(&on_tile);
            render::resume(prepared, checkpoint, run, progress, watch)
        }
        None => render::render_watched(prepared, region, run, progress, watch),
    };
    let whole = request.buffer.part().region;
    let outcome = pilot::foreseeing(&request.scene, prepared, whole, progress, render);
    if let Some(keeper) = keeper {
        keeper.end(outcome.is_some());
    }
    if let Some(outcome) = outcome {
        finish(job, request, outcome);
    }
}

/// Shows the error of each pixel after a round, where it is looked at or takes little of the time. `seconds`: what it took last.
fn show_error_of(job: &Job<Event>, request: &RenderRequest, round: &Round<'_>, seconds: &mut f64) {
    let is_cheap = *seconds <= ERROR_LAYER_SHARE * round.seconds;
    if round.error.is_some() && (is_cheap || request.buffer.shows_error()) {
        let started = Instant::now();
        if let Some(errors) = round.error_image(&job.cancel) {
            show_error(job, request, errors);
        }
        *seconds = started.elapsed().as_secs_f64();
    }
}

/// Tells how many samples the render is expected to take, where an estimate is there.
fn expect_samples(request: &RenderRequest) {
    let Some(per_pixel) = request.expected_samples else {
        return;
    };
    let pixels = request.buffer.part().region.pixel_count() as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of samples"
    )]
    request.progress.expect_samples((per_pixel * pixels) as u64);
}

/// Where a render goes on, if it does not begin; none either when cancelled.
///
/// # Errors
/// Why it cannot, in words.
fn start(
    request: &RenderRequest,
    keeper: Option<&RenderKeeper<'_>>,
    prepared: &PreparedScene,
    layers: &[Layer],
) -> Result<Option<Start>, String> {
    if let Some(taken_up) = &request.continues {
        let region = request.buffer.part().region;
        let reached = taken_up.reached.take();
        let reached = reached.filter(|reached| reached.fits(prepared, region, layers));
        // Nobody asked for one that begins anew.
        let mut reached = *reached.ok_or("What it had reached does not fit the scene any more")?;
        if taken_up.has_other_rules {
            reached = reached.with_rules_of(prepared.settings());
        }
        return Ok(Some(Start::of(reached, 0, 0.0)));
    }
    if !request.goes_on {
        return Ok(None);
    }
    let keeper = keeper.ok_or(
        "there is not the memory to go on from what was kept, which is offered again at the next start",
    )?;
    let start = keeper.start(prepared);
    if let (Err(_), Some(kept)) = (&start, &request.kept) {
        // It is of no use to anybody.
        kept.accept();
    }
    start
}

/// Whether what a render that takes `memory` has reached may be copied, beside its checkpoints.
fn has_room(memory: PictureMemory) -> bool {
    let all = PictureMemory {
        has_checkpoint: true,
        kept_bytes: memory.kept_bytes + memory.checkpoint_bytes(),
        ..memory
    };
    memory.checkpoint_bytes() <= reached::MOST_BYTES && all.require().is_ok()
}

/// What the picture of a render takes.
fn memory_of(request: &RenderRequest, prepared: &PreparedScene, run: &RunConfig) -> PictureMemory {
    PictureMemory {
        // Those that the window shows.
        copies: 1 + request.buffer.layers().len(),
        kept_bytes: prepared.primary_hit_bytes(&request.primary_hits),
        ..PictureMemory::of_render(prepared, request.buffer.part().region(), run)
    }
}

/// Tells that a render is done.
fn finish(job: &Job<Event>, request: &RenderRequest, outcome: RenderOutcome) {
    let RenderOutcome {
        image,
        layers,
        stats,
        ..
    } = outcome;
    let Some(hash) = image.hash_unless(&job.cancel) else {
        return;
    };
    if let Some((_, errors)) = layers.into_iter().find(|(l, _)| *l == Layer::Error) {
        show_error(job, request, errors);
    }
    let stats = Box::new(stats);
    job.send(Event::Rendered { hash, stats });
}

/// The scene of a render, and whether a coarse picture of it is shown already; `None` where there is no such thing, which is told, or when
/// cancelled.
fn prepared_to_render(
    job: &Job<Event>,
    request: &RenderRequest,
    run: &RunConfig,
    on_coarse: OnCoarse<'_>,
) -> Option<(PreparedScene, bool)> {
    let (scene, previous) = (&request.scene, request.previous.as_ref());
    if let Some(preparation) = &request.preparation {
        let is_sketched = sketch(request, preparation, run, on_coarse)?;
        let Preparation {
            placed,
            gpu,
            progress,
            ..
        } = preparation;
        let placed = Some(placed.clone());
        let prepared = prepare(job, scene, placed, previous, gpu.as_ref(), progress);
        return prepared.map(|prepared| (prepared, is_sketched));
    }
    match PreparedScene::prepare(scene, previous, &job.cancel) {
        Ok(prepared) => prepared.map(|prepared| (prepared, false)),
        Err(error) => {
            job.send(Event::RenderFailed {
                text: error.to_string(),
                is_short_of_memory: matches!(error, SceneError::TooLittleMemory { .. }),
            });
            None
        }
    }
}

/// Shows where things are now by a coarse picture, where that is quicker than preparing the scene, and waits for what is held to rest.
/// Returns whether it is shown; `None` when cancelled.
fn sketch(
    request: &RenderRequest,
    preparation: &Preparation,
    run: &RunConfig,
    on_coarse: OnCoarse<'_>,
) -> Option<bool> {
    let (scene, cancel) = (&request.scene, &run.cancel);
    let previous = request.previous.as_ref();
    let sketch = previous.map(|known| Sketch::new(scene, known, &preparation.sketches, cancel));
    // What is wrong with a scene is told when it is prepared.
    let Some(Ok(Some(sketch))) = sketch else {
        return (!cancel.is_cancelled()).then_some(false);
    };
    sketch.show(request.buffer.part().region(), run, on_coarse)?;
    let shown = Instant::now();
    while preparation.is_held && shown.elapsed() < HELD_REST {
        std::thread::sleep(Duration::from_millis(5));
        if cancel.is_cancelled() {
            return None;
        }
    }
    Some(true)
}

/// Keeps the error of each pixel, and shows it where it is the layer that is looked at.
fn show_error(job: &Job<Event>, request: &RenderRequest, errors: Image) {
    request.buffer.set_error(errors);
    if request.buffer.shows_error() {
        encode(job, request.number, &request.buffer);
    }
}
