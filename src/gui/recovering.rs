//! Reading what a window before left behind: unsaved work, and the render that was interrupted.

use std::path::Path;
use std::sync::Arc;

use super::keeping::{KeptRender, Lost, RenderAbout, Session, scene_of_render};
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadError, LoadedWithout, MissingFile, Moves};
use crate::scene::Scene;

/// What is restored.
#[derive(Debug)]
pub struct Recovered {
    /// The scene as it was edited last. Something stands for files that are missing.
    pub scene: Scene,
    /// The same with files that were found elsewhere; `None` where none was.
    pub moved: Option<Scene>,
    /// What its file holds, nothing where that is not known; `None` where it is the scene itself.
    pub saved: Option<Scene>,
    /// The render to go on with, or why it cannot be.
    pub render: Option<Result<Interrupted, Hindrance>>,
    /// What is to be said of files that are missing, in sentences.
    pub warnings: Vec<String>,
}

/// A render to go on with.
#[derive(Debug)]
pub struct Interrupted {
    /// The scene as it was when the render began.
    pub scene: Scene,
    /// Where it is kept.
    pub kept: KeptRender,
}

/// Why a render does not go on, in words.
#[derive(Debug, PartialEq, Eq)]
pub enum Hindrance {
    /// It never can.
    Lost(String),
    /// It cannot now: it stays where it is, for the next start.
    Waits(String),
}

/// The files that `lost` work and its render lack.
#[must_use]
pub fn missing_files(lost: &Lost, cancel: &CancelToken) -> Vec<MissingFile> {
    let scene = lost.scene_file().or(lost.about.path.as_deref());
    let rendered = lost.render().map(scene_of_render);
    let scenes = scene.into_iter().chain(rendered.as_deref());
    let mut missing: Vec<MissingFile> = Vec::new();
    for file in scenes.flat_map(|scene| io::missing_files(scene, cancel)) {
        if missing.iter().all(|known| known.path != file.path) {
            missing.push(file);
        }
    }
    missing
}

/// Reads `lost` work, with missing files that were `found` and without the rest. Its render moves to `session`. `None` when cancelled.
///
/// # Errors
/// In words, when there is no scene to show.
pub fn recover(
    lost: &Lost,
    found: &Moves,
    session: Option<&Arc<Session>>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Recovered>, String> {
    let read = scene_of(lost, found, cancel, progress).map_err(|error| error.to_string())?;
    let Some((read, saved)) = read else {
        return Ok(None);
    };
    let edited = &read.loaded.scene;
    let render = lost.render().zip(session);
    let render = render
        .map(|(folder, session)| recover_render(lost, folder, session, (edited, found), cancel));
    if cancel.is_cancelled() {
        return Ok(None);
    }
    Ok(Some(Recovered {
        warnings: read.warnings(),
        scene: read.loaded.scene,
        moved: read.moved,
        saved,
        render,
    }))
}

/// Moves the render in `folder` of `lost` work to `session`. It shares what it can with the `edited` scene, and takes files that are not where
/// they were from where they were `found`.
fn recover_render(
    lost: &Lost,
    folder: &Path,
    session: &Arc<Session>,
    (edited, found): (&Scene, &Moves),
    cancel: &CancelToken,
) -> Result<Interrupted, Hindrance> {
    let about = RenderAbout::read(folder).map_err(Hindrance::Lost)?;
    let path = scene_of_render(folder);
    let missing = io::missing_files(&path, cancel);
    // By other names they would be another render's.
    let is_found = |file: &MissingFile| {
        let found = found.get(&file.path);
        found.is_some_and(|found| found.file_name() == file.path.file_name())
    };
    if let Some(file) = missing.iter().find(|file| !is_found(file)) {
        let path = file.path.display();
        return Err(Hindrance::Waits(format!("There is no file {path}")));
    }
    let scene = rendered_scene(&path, edited, missing.is_empty(), found, cancel);
    let scene = scene.map_err(|error| Hindrance::Lost(error.to_string()))?;
    let scene = scene.ok_or_else(|| Hindrance::Lost("cancelled".to_owned()))?;
    if !about.region.fits(scene.render.width, scene.render.height) {
        let reason = "what it is of was damaged on disk";
        return Err(Hindrance::Lost(reason.to_owned()));
    }
    let kept = lost.move_render(session, about).map_err(Hindrance::Waits)?;
    let kept = kept.ok_or_else(|| Hindrance::Lost("it is not there any more".to_owned()))?;
    Ok(Interrupted { scene, kept })
}

/// The scene of a render, which lies at `path`; `None` when cancelled. `is_whole`: whether all files are where it names them; else they are
/// where they were `found`.
fn rendered_scene(
    path: &Path,
    edited: &Scene,
    is_whole: bool,
    found: &Moves,
    cancel: &CancelToken,
) -> Result<Option<Scene>, LoadError> {
    if is_whole {
        let loaded = io::reload_scene(path, edited, cancel)?;
        return Ok(loaded.map(|loaded| loaded.scene));
    }
    let read = io::load_scene_without_missing(path, found, cancel, &Progress::new())?;
    Ok(read.map(|read| read.moved.unwrap_or(read.loaded.scene)))
}

/// The scene that `lost` was of: unsaved work, or else what its file holds; and [what that holds](Recovered::saved).
fn scene_of(
    lost: &Lost,
    found: &Moves,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<(LoadedWithout, Option<Scene>)>, LoadError> {
    let path = lost.about.path.as_deref();
    let load = |file: &Path| io::load_scene_without_missing(file, found, cancel, progress);
    if let Some(unsaved) = lost.scene_file() {
        let Some(read) = load(unsaved)? else {
            return Ok(None);
        };
        let is_as_it_was = |path: &&Path| is_older(path, unsaved);
        let path = path.filter(is_as_it_was);
        let there =
            path.and_then(|path| io::reload_scene(path, &read.loaded.scene, cancel).ok()?);
        let saved = there.map(|loaded| loaded.scene).unwrap_or_default();
        return Ok(Some((read, Some(saved))));
    }
    if let Some(Ok(read)) = path.map(load) {
        return Ok(read.map(|read| (read, None)));
    }
    let rendered = lost.render().map(scene_of_render).unwrap_or_default();
    // Where its file is gone, this is all there is of it.
    Ok(load(&rendered)?.map(|read| (read, path.map(|_| Scene::default()))))
}

/// Whether the file at `path` was written before that at `other`.
fn is_older(path: &Path, other: &Path) -> bool {
    let written = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified());
    matches!((written(path), written(other)), (Ok(path), Ok(other)) if path <= other)
}
