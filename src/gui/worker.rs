//! What the window has done in the background: loading, preparing, rendering, measuring, saving. Each function here is the body of
//! one job (see [`super::jobs`]); what it finds travels back as an [`Event`].
//!
//! Preparing runs right after loading and after every edit of geometry, so that a render finds its tree ready and its
//! first tile is a matter of milliseconds. A render works on its own copy of the scene: editing goes on meanwhile.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use eframe::wgpu;

use super::app::Stale;
use super::commands::TextureUse;
use super::costs::PAIRS;
use super::event::{Event, Reloaded};
use super::first_look::FirstLook;
use super::jobs::Job;
use super::keeping::KeptRender;
use super::opened_picture::{self, OpenedPicture};
use super::picture_buffer::PictureBuffer;
use super::preview::geometry::GpuGeometry;
use super::preview::least_triangles;
pub use super::preview::pack::preview_mesh;
use super::preview::sky::GpuSky;
use super::render_keeper::{RenderKeeper, Start};
use super::report::Findings;
use super::time_estimate::Subject;
use crate::analysis::cost::{Costs, Trial};
use crate::analysis::pilot;
use crate::analysis::report::{ReportError, ReportOptions, ReportPlan, ReportProgress};
use crate::control::{CancelToken, Progress, Throttle};
use crate::io::{self, LoadedScene, WrittenOrigin};
use crate::math::DBounds;
use crate::render::{
    self, BlockStore, Checkpoint, CoarsePicture, Image, Layer, OnCoarse, OnRound, PictureMemory,
    PreparedGeometry, PreparedScene, PrimaryHitStore, RenderOutcome, RenderProgress, Round,
    RunConfig, Sketch, SketchStore, TilePixels, Watch,
};
use crate::scene::{Object, Scene, SceneError};

/// What the preview draws of a scene, and what the mouse meets in it.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The triangles: without a structure at first, in that of the render as soon as it is there.
    pub geometry: Arc<PreparedGeometry>,
    /// The same on the GPU; `None` without one.
    pub triangles: Option<Arc<GpuGeometry>>,
    /// The background's image for the preview; `None` where the background is none, or without a GPU.
    pub sky: Option<Arc<GpuSky>>,
    /// The world box of each object.
    pub object_bounds: Arc<[DBounds]>,
    /// The box of each object's mesh, in its own coordinates.
    pub object_boxes: Arc<[DBounds]>,
    /// Which device triangles and image are on, see [`Gpu::number`].
    pub device: Option<u64>,
}

impl Placed {
    /// The same where the device may be another one, which has nothing yet.
    #[must_use]
    pub fn on(self, device: Option<u64>) -> Self {
        if self.device == device {
            return self;
        }
        Self {
            triangles: None,
            sky: None,
            device,
            ..self
        }
    }
}

/// What uploads go to.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Holds the data.
    pub device: wgpu::Device,
    /// Takes it there.
    pub queue: wgpu::Queue,
    /// Its number among the devices of this program: the library that knows them gives several the same name.
    pub number: u64,
}

/// Loads a scene file, or one or several meshes as a scene; the demo where `paths` is empty.
pub fn load_scene(job: &Job<Event>, paths: Vec<PathBuf>, progress: &Progress) {
    let render = match &paths[..] {
        [path] if io::is_render_file(path) => Some(path),
        _ => None,
    };
    if let Some(path) = render {
        opened_picture::announce(path, progress);
    }
    let loaded = match paths.as_slice() {
        [] => Ok(Some(LoadedScene {
            scene: io::demo_scene(),
            warnings: Vec::new(),
        })),
        paths => io::load_scenes(paths, &job.cancel, progress),
    };
    let Some(mut result) = unless_cancelled(loaded) else {
        return;
    };
    let picture = match (render, &mut result) {
        (Some(path), Ok(loaded)) => OpenedPicture::of(path, loaded, &job.cancel, progress),
        _ => None,
    };
    let result = result.map(Box::new);
    job.send(Event::SceneLoaded {
        paths,
        result,
        picture,
    });
}

/// Loads files of meshes of which it is to be decided what becomes of them. `replaces`: whether they are likely to take the place of
/// the scene.
pub fn load_models(job: &Job<Event>, paths: Vec<PathBuf>, replaces: bool, progress: &Progress) {
    let loaded = unless_cancelled(io::load_models(&paths, &job.cancel, progress));
    if let Some(result) = loaded {
        job.send(Event::ModelsLoaded {
            paths,
            replaces,
            result,
        });
    }
}

/// Loads an image for the background.
pub fn load_image(job: &Job<Event>, path: PathBuf, progress: &Progress) {
    let Some(result) = unless_cancelled(io::load_image(&path, &job.cancel, progress)) else {
        return;
    };
    job.send(Event::ImageLoaded { path, result });
}

/// Says that the image in `path` tells what was rendered, which is for the window to open; any other is loaded for the background.
pub fn load_dropped_image(job: &Job<Event>, path: PathBuf, progress: &Progress) {
    // What cannot be read is told by who reads all of it.
    let is_render = io::is_render_file(&path)
        && WrittenOrigin::of_file(&path).is_ok_and(|origin| origin.scene.is_some());
    if is_render {
        job.send(Event::RenderDropped(path));
    } else {
        load_image(job, path, progress);
    }
}

/// Loads an image for the material of that name.
pub fn load_texture(
    job: &Job<Event>,
    path: PathBuf,
    (material, texture): (String, TextureUse),
    progress: &Progress,
) {
    progress.set_total(std::fs::metadata(&path).map_or(0, |file| 2 * file.len()));
    let Some(result) = unless_cancelled(io::load_texture(&path, &job.cancel, progress)) else {
        return;
    };
    job.send(Event::TextureLoaded {
        path,
        material,
        texture,
        result,
    });
}

/// Reads again what has changed on disk. `names`: of the meshes or textures in the file; `known`: the scene whose meshes and images a scene file
/// keeps.
pub fn reload(job: &Job<Event>, stale: Stale, names: &[String], known: Scene) {
    let (path, progress) = (stale.path(), Progress::new());
    let result = match &stale {
        Stale::Meshes(_) => unless_cancelled(io::load_again(path, names, &job.cancel))
            .map(|result| result.map(|read| Reloaded::meshes(read, &known))),
        Stale::Image(_) => unless_cancelled(io::load_image(path, &job.cancel, &progress))
            .map(|result| result.map(|file| Reloaded::image(path, file, &known))),
        Stale::Textures(_) => unless_cancelled(io::load_textures_again(names, &job.cancel))
            .map(|result| result.map(|files| Reloaded::textures(files, &known))),
        Stale::Scene { .. } => unless_cancelled(io::reload_scene(path, &known, &job.cancel))
            .map(|result| result.map(|loaded| Reloaded::Scene(Box::new(loaded)))),
    };
    drop(known);
    if let Some(result) = result {
        job.send(Event::Reloaded { stale, result });
    }
}

/// Prepares `scene`, keeping what is the same of what was placed and prepared before. It is told of twice: when it can be drawn, and when
/// it can be rendered, which takes a tree. `progress` counts triangles that structures are built over. Returns what can be rendered.
pub fn prepare(
    job: &Job<Event>,
    scene: &Scene,
    placed_before: Option<Placed>,
    prepared_before: Option<&PreparedScene>,
    gpu: Option<&Gpu>,
    progress: &Progress,
) -> Option<PreparedScene> {
    let geometry = placed_before.as_ref().map(|placed| &placed.geometry);
    let placed = scene
        .validate()
        .and_then(|()| PreparedGeometry::place(scene, geometry, &job.cancel));
    let geometry = match unless_cancelled(placed)? {
        Ok(geometry) => geometry,
        Err(problem) => {
            job.send(Event::Prepared(Err(problem)));
            return None;
        }
    };
    let sky = preview_sky(scene, placed_before.as_ref(), gpu);
    let painted_before = placed_before
        .as_ref()
        .and_then(|before| before.triangles.clone());
    // What a lost device held is brought to the new one.
    let is_drawn = |placed: &Placed| placed.triangles.is_some() || gpu.is_none();
    let unchanged =
        placed_before.filter(|before| Arc::ptr_eq(&before.geometry, &geometry) && is_drawn(before));
    let mut placed = match unchanged {
        Some(placed) => placed,
        None => new_geometry(scene, Arc::clone(&geometry), gpu, &job.cancel)?,
    };
    if let Some((triangles, gpu)) = placed.triangles.as_mut().zip(gpu) {
        *triangles = triangles.painted(gpu, scene, painted_before.as_deref(), &job.cancel)?;
    }
    job.send(Event::Placed(Box::new(Placed { sky, ..placed })));

    let (cancel, known) = (&job.cancel, prepared_before);
    let prepared = PreparedScene::prepare_placed(scene, &geometry, known, cancel, progress);
    let result = unless_cancelled(prepared)?;
    let prepared = result.as_ref().ok().cloned();
    job.send(Event::Prepared(result.map(Box::new)));
    prepared
}

/// The image of the background of `scene` on the GPU: that of `previous` where it is the same.
fn preview_sky(scene: &Scene, previous: Option<&Placed>, gpu: Option<&Gpu>) -> Option<Arc<GpuSky>> {
    let map = scene.background_image().ok().flatten()?;
    let known = previous.and_then(|previous| previous.sky.as_ref());
    match known.filter(|sky| Arc::ptr_eq(sky.source(), map)) {
        Some(known) => Some(Arc::clone(known)),
        None => gpu.map(|Gpu { device, queue, .. }| Arc::new(GpuSky::upload(device, queue, map))),
    }
}

/// Uploads the triangles of a scene whose geometry is new. `None` when cancelled.
fn new_geometry(
    description: &Scene,
    geometry: Arc<PreparedGeometry>,
    gpu: Option<&Gpu>,
    cancel: &CancelToken,
) -> Option<Placed> {
    let triangles = match gpu {
        Some(Gpu { device, .. }) => {
            let is_software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
            let mesh = preview_mesh(&geometry, least_triangles(is_software), cancel)?;
            Some(Arc::new(GpuGeometry::upload(device, mesh)))
        }
        None => None,
    };
    let bounds_of = |object: &Object| {
        let mesh = description.mesh_of(object);
        mesh.map_or(DBounds::EMPTY, |mesh| object.bounds_of(mesh))
    };
    let box_of = |object: &Object| {
        let mesh = description.mesh_of(object);
        mesh.map_or(DBounds::EMPTY, |mesh| mesh.bounds())
    };
    Some(Placed {
        geometry,
        triangles,
        sky: None,
        device: gpu.map(|gpu| gpu.number),
        object_bounds: description.objects.iter().map(bounds_of).collect(),
        object_boxes: description.objects.iter().map(box_of).collect(),
    })
}

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
    let run = RunConfig {
        threads: request.threads,
        cancel: job.cancel.clone(),
        throttle: request.throttle.clone(),
        layers: !request.buffer.layers().is_empty(),
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
    let region = request.buffer.part().region();
    let memory = memory_of(request, &prepared, &run);
    if let Err(short) = memory.require() {
        request.primary_hits.clear();
        return job.send(Event::RenderFailed {
            text: short.to_string(),
            is_short_of_memory: true,
        });
    }
    let prepared = prepared.with_primary_hits(&request.primary_hits);
    let layers = run.layers_of(&prepared);
    let keeper = RenderKeeper::new(job, request, layers, memory, run.thread_count());
    let start = match start(request, keeper.as_ref(), &prepared) {
        Ok(start) => start,
        Err(reason) => return job.send(Event::RenderLost(reason)),
    };
    // Where it was to go on, it is offered again.
    if job.cancel.is_cancelled() {
        return;
    }
    let keep = |checkpoint: Checkpoint| {
        if let Some(keeper) = &keeper {
            keeper.keep(&checkpoint);
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
        let is_cheap = *seconds <= ERROR_LAYER_SHARE * round.seconds;
        if round.error.is_some() && (is_cheap || request.buffer.shows_error()) {
            let started = Instant::now();
            if let Some(errors) = round.error_image(&job.cancel) {
                show_error(job, request, errors);
            }
            *seconds = started.elapsed().as_secs_f64();
        }
    };
    let keeps_error = request.buffer.layers().contains(&Layer::Error);
    let watch = Watch {
        on_coarse: (!is_sketched && start.is_none()).then_some(&on_coarse as OnCoarse<'_>),
        on_tile: Some(&on_tile),
        on_round: keeps_error.then_some(&on_round as OnRound<'_>),
        checkpoints: keeper.as_ref().map(|keeper| keeper.checkpoints(&keep)),
        blocks: keeper.as_ref().map(|keeper| keeper as &dyn BlockStore),
    };
    let progress = &request.progress;
    let outcome = match start {
        Some(Start {
            checkpoint,
            share_done,
            seconds,
        }) => {
            job.send(Event::RenderGoesOn {
                share_done,
                seconds,
            });
            checkpoint.show(&on_tile);
            render::resume(&prepared, checkpoint, &run, progress, watch)
        }
        None => render::render_watched(&prepared, region, &run, progress, watch),
    };
    if let Some(kept) = &request.kept {
        kept.end_log();
    }
    if let Some(outcome) = outcome {
        finish(job, request, outcome);
    }
}

/// Where a render goes on, if it does not begin; none either when cancelled.
///
/// # Errors
/// Why it cannot, in words.
fn start(
    request: &RenderRequest,
    keeper: Option<&RenderKeeper<'_>>,
    prepared: &PreparedScene,
) -> Result<Option<Start>, String> {
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

/// Shows the whole picture of render `number` again, after its display settings changed.
pub fn encode(job: &Job<Event>, number: usize, buffer: &PictureBuffer) {
    buffer.encode_all(&job.cancel, |encoded| {
        job.send(Event::Encoded { number, encoded });
    });
}

/// Makes small pictures of renders, as they are shown with their displays.
pub fn make_thumbnails(job: &Job<Event>, pictures: &[Arc<PictureBuffer>]) {
    for buffer in pictures {
        job.send(Event::Thumbnail {
            picture: buffer.id(),
            image: buffer.thumbnail(),
        });
    }
}

/// Writes a scene file.
pub fn save_scene(job: &Job<Event>, scene: Scene, file: usize, path: PathBuf) {
    let result = io::save_scene(&scene, &path);
    let result = result.map(|()| Box::new(scene)).map_err(|e| e.to_string());
    job.send(Event::SceneSaved { file, path, result });
}

/// Writes a picture of that origin as the window shows it. `None` when cancelled: there is no file then, or the old one.
///
/// # Errors
/// In words.
pub fn save_picture(
    buffer: &PictureBuffer,
    origin: &io::Origin<'_>,
    path: &Path,
    cancel: &CancelToken,
) -> Result<Option<()>, String> {
    // One that waited for another to be written may be cancelled by now.
    if cancel.is_cancelled() {
        return Ok(None);
    }
    let (image, layers) = (buffer.image(), buffer.layer_images());
    io::write_render_unless(&image, &layers, origin, path, cancel)
        .map_err(|error| error.to_string())
}

/// What a report job works with.
#[derive(Clone, Debug)]
pub struct ReportRequest {
    /// The scene as it was when the report was asked for.
    pub scene: Scene,
    /// What people call it.
    pub scene_name: String,
    /// What is wanted.
    pub options: ReportOptions,
    /// Where the files go.
    pub folder: PathBuf,
    /// Render threads; 0 is one per core.
    pub threads: usize,
    /// What the window watches.
    pub progress: ReportProgress,
}

/// Measures error against run time, sending what is known after every render.
pub fn report(job: &Job<Event>, request: ReportRequest) {
    match measure(job, request) {
        Ok(None) => {}
        Ok(Some(())) => job.send(Event::Reported(Ok(()))),
        Err(error) => job.send(Event::Reported(Err(error))),
    }
}

/// The body of [`report`]; `None` when cancelled.
fn measure(job: &Job<Event>, request: ReportRequest) -> Result<Option<()>, ReportError> {
    let loaded = LoadedScene {
        scene: request.scene,
        warnings: Vec::new(),
    };
    let name = request.scene_name;
    let plan = ReportPlan::new(name, loaded, &request.options, &job.cancel)?;
    let run = RunConfig {
        threads: request.threads,
        cancel: job.cancel.clone(),
        ..RunConfig::default()
    };
    let warnings = plan.warnings.clone();
    let study = plan.carry_out(&run, &request.folder, &request.progress, |study| {
        let findings = Findings::of(study, &warnings);
        job.send(Event::ReportGrew(Box::new(findings)));
    })?;
    Ok(study.map(drop))
}

/// Measures what the effects of `scene` cost; `prepared`: what was prepared last.
pub fn measure_costs(
    job: &Job<Event>,
    scene: Scene,
    prepared: Option<&PreparedScene>,
    progress: &Progress,
) {
    let measure = || {
        let Some(trial) = Trial::new(&scene, prepared, &job.cancel)? else {
            return Ok(None);
        };
        trial.costs(PAIRS, |done, all| {
            progress.set_total(all as u64);
            progress.advance(done as u64 - progress.done());
        })
    };
    let measured: Result<Option<Costs>, SceneError> = measure();
    if let Some(result) = unless_cancelled(measured) {
        job.send(Event::CostsMeasured {
            scene: Box::new(scene),
            result: result.map(Box::new),
        });
    }
}

/// Finds out how long a render of `subject` will take; `prepared`: what was prepared of its scene.
pub fn estimate_time(job: &Job<Event>, subject: Subject, prepared: &PreparedScene) {
    let run = RunConfig {
        threads: subject.threads.count(),
        cancel: job.cancel.clone(),
        ..RunConfig::default()
    };
    let region = subject.part.region();
    let estimated = pilot::estimate_time(&subject.scene, prepared, region, &run);
    if let Some(result) = unless_cancelled(estimated) {
        let subject = Box::new(subject);
        job.send(Event::TimeEstimated { subject, result });
    }
}

/// Has the desktop show `folder`.
pub fn show_folder(job: &Job<Event>, folder: &Path) {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let status = Command::new(program)
        .arg(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let reason = match status {
        // The explorer of Windows also fails where it succeeds.
        Ok(status) if status.success() || cfg!(windows) => return,
        Ok(status) => format!("{program} says {status}"),
        Err(error) => format!("{program}: {error}"),
    };
    job.send(Event::FolderNotShown(reason));
}

/// The result in words; `None` when cancelled.
fn unless_cancelled<T, E: std::fmt::Display>(
    result: Result<Option<T>, E>,
) -> Option<Result<T, String>> {
    match result {
        Ok(value) => value.map(Ok),
        Err(error) => Some(Err(error.to_string())),
    }
}
