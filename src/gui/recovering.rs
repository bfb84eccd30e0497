//! Reading what a window before left behind: unsaved work, and the render that was interrupted.

use std::path::Path;
use std::sync::Arc;

use super::keeping::{KeptRender, Lost, RenderAbout, Session, scene_of_render};
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadError};
use crate::scene::Scene;

/// What is restored.
#[derive(Debug)]
pub struct Recovered {
    /// The scene as it was edited last.
    pub scene: Scene,
    /// What its file holds, nothing where that is not known; `None` where it is the scene itself.
    pub saved: Option<Scene>,
    /// The render to go on with, or why it cannot be.
    pub render: Option<Result<Interrupted, String>>,
}

/// A render to go on with.
#[derive(Debug)]
pub struct Interrupted {
    /// The scene as it was when the render began.
    pub scene: Scene,
    /// Where it is kept.
    pub kept: KeptRender,
}

/// Reads `lost` work. Its render moves to `session`. `None` when cancelled.
///
/// # Errors
/// In words, when there is no scene to show.
pub fn recover(
    lost: &Lost,
    session: Option<&Arc<Session>>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Recovered>, String> {
    let read = scene_of(lost, cancel, progress).map_err(|error| error.to_string())?;
    let Some((scene, saved)) = read else {
        return Ok(None);
    };
    let edited = &scene;
    let render = lost.render().zip(session).map(|(folder, session)| {
        let about = RenderAbout::read(folder)?;
        let scene = scene_of_render(folder);
        let loaded = io::reload_scene(&scene, edited, cancel);
        let loaded = loaded.map_err(|error| error.to_string())?;
        let scene = loaded.ok_or("cancelled")?.scene;
        let settings = &scene.render;
        if !about.region.fits(settings.width, settings.height) {
            return Err("what it is of was damaged on disk".to_owned());
        }
        let kept = lost.move_render(session, about)?;
        let kept = kept.ok_or("it is not there any more")?;
        Ok(Interrupted { scene, kept })
    });
    if cancel.is_cancelled() {
        return Ok(None);
    }
    Ok(Some(Recovered {
        scene,
        saved,
        render,
    }))
}

/// The scene that `lost` was of: unsaved work, or else what its file holds; and [what that holds](Recovered::saved).
fn scene_of(
    lost: &Lost,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<(Scene, Option<Scene>)>, LoadError> {
    let path = lost.about.path.as_deref();
    let load = |file: &Path| -> Result<Option<Scene>, LoadError> {
        let loaded = io::load_scene(file, cancel, progress)?;
        Ok(loaded.map(|loaded| loaded.scene))
    };
    if let Some(unsaved) = lost.scene_file() {
        let Some(scene) = load(unsaved)? else {
            return Ok(None);
        };
        let is_as_it_was = |path: &&Path| is_older(path, unsaved);
        let path = path.filter(is_as_it_was);
        let read = path.and_then(|path| io::reload_scene(path, &scene, cancel).ok()?);
        let saved = read.map(|loaded| loaded.scene).unwrap_or_default();
        return Ok(Some((scene, Some(saved))));
    }
    if let Some(Ok(scene)) = path.map(load) {
        return Ok(scene.map(|scene| (scene, None)));
    }
    let rendered = lost.render().map(scene_of_render).unwrap_or_default();
    // Where its file is gone, this is all there is of it.
    Ok(load(&rendered)?.map(|scene| (scene, path.map(|_| Scene::default()))))
}

/// Whether the file at `path` was written before that at `other`.
fn is_older(path: &Path, other: &Path) -> bool {
    let written = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified());
    matches!((written(path), written(other)), (Ok(path), Ok(other)) if path <= other)
}
