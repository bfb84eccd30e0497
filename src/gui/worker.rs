//! What the window has done in the background: loading, preparing, rendering, measuring, saving. Each function here is the body of
//! one job (see [`super::jobs`]); what it finds travels back as an [`Event`].
//!
//! Preparing runs right after loading and after every edit of geometry, so that a render finds its tree ready and its
//! first tile is a matter of milliseconds. A render works on its own copy of the scene: editing goes on meanwhile.
//!
//! - `rendering`: the job of a render

mod rendering;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use eframe::wgpu;

use super::app::Stale;
use super::commands::TextureUse;
use super::costs::PAIRS;
use super::dialogs::Opened;
use super::dialogs::missing::{Lacking, Missing};
use super::event::{Event, Reloaded};
use super::jobs::Job;
use super::keeping::{Lost, Session};
use super::opened_picture::{self, OpenedPicture};
use super::picture_buffer::PictureBuffer;
use super::preview::geometry::GpuGeometry;
use super::preview::least_triangles;
pub use super::preview::pack::preview_mesh;
use super::preview::sky::GpuSky;
use super::recovering::recover;
use super::report::Findings;
use super::time_estimate::Subject;
use crate::analysis::cost::{Costs, Trial};
use crate::analysis::pilot;
use crate::analysis::report::{ReportError, ReportOptions, ReportPlan, ReportProgress};
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadedScene, WrittenOrigin};
use crate::math::DBounds;
use crate::render::{PreparedGeometry, PreparedScene, RunConfig};
use crate::scene::{Object, Scene, SceneError};
pub use rendering::{Preparation, RenderRequest, render};

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
    if let ([path], Err(_)) = (&paths[..], &result)
        && (io::is_scene_file(path) || render.is_some())
    {
        let files = io::missing_files(path, &job.cancel);
        if !files.is_empty() {
            let of = Lacking::File(path.clone());
            return job.send(Event::FilesMissing(Missing::new(of, files)));
        }
    }
    let picture = match (render, &mut result) {
        (Some(path), Ok(loaded)) => OpenedPicture::of(path, loaded, &job.cancel, progress),
        _ => None,
    };
    let result = result.map(|loaded| {
        Box::new(Opened {
            paths: paths.clone(),
            loaded,
            picture,
            moved: None,
        })
    });
    job.send(Event::SceneLoaded { paths, result });
}

/// Loads the scene at `path`, which lacks files, with those of them that were found elsewhere. Where these are of no use, that is asked
/// again.
pub fn load_scene_without_missing(
    job: &Job<Event>,
    path: PathBuf,
    missing: Missing,
    progress: &Progress,
) {
    let is_render = io::is_render_file(&path);
    if is_render {
        opened_picture::announce(&path, progress);
    }
    let loaded = io::load_scene_without_missing(&path, &missing.found, &job.cancel, progress);
    let result = match unless_cancelled(loaded) {
        None => return,
        Some(Err(problem)) if !missing.found.is_empty() => {
            return job.send(Event::FilesMissing(missing.again(problem)));
        }
        Some(result) => result,
    };
    let paths = vec![path];
    let result = result.map(|read| {
        let warnings = read.warnings();
        let (mut loaded, moved) = (read.loaded, read.moved);
        loaded.warnings.extend(warnings);
        let picture = is_render
            .then(|| OpenedPicture::of(&paths[0], &mut loaded, &job.cancel, progress))
            .flatten();
        Box::new(Opened {
            paths: paths.clone(),
            loaded,
            picture,
            moved,
        })
    });
    job.send(Event::SceneLoaded { paths, result });
}

/// Reads lost work, with those of its `missing` files that were found elsewhere. Where these are of no use, that is asked again. Its render
/// moves to `session`.
pub fn restore(
    job: &Job<Event>,
    lost: Lost,
    missing: Missing,
    session: Option<&Arc<Session>>,
    progress: &Progress,
) {
    let recovered = recover(&lost, &missing.found, session, &job.cancel, progress);
    match recovered.transpose() {
        None => {}
        Some(Err(problem)) if !missing.found.is_empty() => {
            job.send(Event::FilesMissing(missing.again(problem)));
        }
        Some(result) => {
            let result = result.map(Box::new);
            job.send(Event::Restored { lost, result });
        }
    }
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

/// Writes a scene file. `known`: what the file there may hold, where any other scene is to be left there.
pub fn save_scene(
    job: &Job<Event>,
    scene: Scene,
    file: usize,
    path: PathBuf,
    known: Option<&[Scene]>,
) {
    let is_other = known.is_some_and(|known| io::holds_other_scene(&path, known));
    let result = if is_other {
        Ok(None)
    } else {
        let result = io::save_scene(&scene, &path);
        let result = result.map(|()| Some(Box::new(scene)));
        result.map_err(|error| error.to_string())
    };
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
