//! Scenes, meshes and images from files. The present scene stays until the new one is whole.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use super::reloading::absolute;
use super::{App, Loading, WaitingRender};
use crate::control::Progress;
use crate::gui::commands::TextureUse;
use crate::gui::costs::CostState;
use crate::gui::dialogs::{Dialog, Intent, Opened};
use crate::gui::document::{Document, name_of};
use crate::gui::jobs::Lane;
use crate::gui::panels::with_image;
use crate::gui::picture::{Outcome, Picture};
use crate::gui::selection::Selection;
use crate::gui::top_bar::View;
use crate::gui::worker;
use crate::io::{self, RadianceFile, TextureFile};
use crate::render::SketchStore;
use crate::scene::{Material, Scene};

impl App {
    /// Reads `paths`, to open them in place of the scene once unsaved work is decided about; of meshes it is asked first whether they are to
    /// join the scene.
    pub(super) fn open(&mut self, paths: Vec<PathBuf>) {
        let is_whole = |path: &PathBuf| io::is_scene_file(path) || io::is_render_file(path);
        if !self.document.scene.objects.is_empty() && !paths.iter().any(is_whole) {
            self.import(paths, !self.document.is_modified());
        } else {
            self.load(paths);
        }
    }

    /// Loads `paths`, or the demo when there are none.
    pub(super) fn load(&mut self, paths: Vec<PathBuf>) {
        let progress = self.begin_loading(what(&paths));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_scene(job, paths, &progress);
        });
    }

    /// Loads an image and makes it the background.
    pub(super) fn set_background(&mut self, path: PathBuf) {
        let progress = self.begin_loading(what(std::slice::from_ref(&path)));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_image(job, path, &progress);
        });
    }

    /// Opens an image that was dropped on the window where it tells what was rendered, and makes any other the background.
    pub(super) fn take_dropped_image(&mut self, path: PathBuf) {
        let progress = self.begin_loading(what(std::slice::from_ref(&path)));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_dropped_image(job, path, &progress);
        });
    }

    /// A file that was dropped turned out to tell what was rendered.
    pub(super) fn dropped_render(&mut self, path: PathBuf) {
        self.loading = None;
        self.open(vec![path]);
    }

    /// Loads an image and lays it on the selected material, or that of the selected object.
    pub(super) fn set_texture(&mut self, path: PathBuf, texture: TextureUse) {
        let scene = &self.document.scene;
        let material = match &self.selection {
            Selection::Material(name) => Some(name.clone()),
            Selection::Object(index) => scene
                .objects
                .get(*index)
                .and_then(|object| object.material.clone()),
            _ => None,
        };
        let Some(material) = material else {
            return;
        };
        let progress = self.begin_loading(what(std::slice::from_ref(&path)));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_texture(job, path, (material, texture), &progress);
        });
    }

    pub(super) fn texture_loaded(
        &mut self,
        path: &Path,
        material: &str,
        texture: TextureUse,
        result: Result<TextureFile, String>,
    ) {
        let shown = what(&[path.to_owned()]);
        let file = match result {
            Ok(file) => file,
            Err(error) => {
                let title = format!("Cannot use {shown}");
                let text = format!("{error}\nThe material is as it was.");
                self.messages.error(title, text);
                return;
            }
        };
        let warnings = io::texture_warnings(&path.display().to_string(), &file);
        if !warnings.is_empty() {
            let title = format!("{shown} is used, with remarks");
            self.messages.warning(title, warnings.join("\n"));
        }
        // What was edited while it was read is a step of its own.
        self.document.record_edit(&self.selection);
        let scene = &mut self.document.scene;
        let textures = scene.materials.get_mut(material);
        // Removed meanwhile, or of another kind now.
        let Some(textures) = textures.and_then(Material::textures_mut) else {
            return;
        };
        let image = io::absolute_image(&path.to_string_lossy(), Path::new("."));
        match texture {
            TextureUse::Diffuse => textures.diffuse_image = Some(image.clone()),
            TextureUse::Normals => textures.normal_image = Some(image.clone()),
        }
        scene.textures.insert(image, Arc::new(file.image));
        // Large, and not coming back on their own.
        let names = scene.texture_names();
        scene.textures.retain(|name, _| names.contains(name));
        self.messages.news(format!("{shown} is on {material}"));
    }

    pub(super) fn begin_loading(&mut self, what: String) -> Progress {
        let progress = Progress::new();
        self.reloading.began = Some(SystemTime::now());
        self.loading = Some(Loading {
            what,
            progress: progress.clone(),
        });
        progress
    }

    /// A scene was read from `paths`, or why not.
    pub(super) fn scene_loaded(&mut self, paths: &[PathBuf], result: Result<Opened, String>) {
        self.loading = None;
        let opened = match result {
            Ok(opened) => opened,
            Err(error) => return self.not_opened(paths, &error),
        };
        if self.document.is_modified() {
            self.ask(Dialog::Unsaved(Intent::Open(Box::new(opened))));
        } else {
            self.put_opened(opened);
        }
    }

    /// Says that `paths` cannot be opened, for the reason `error`.
    pub(super) fn not_opened(&mut self, paths: &[PathBuf], error: &str) {
        let stays = if self.has_scene() {
            "\nThe scene you had is still here."
        } else {
            ""
        };
        let text = format!("{error}{stays}");
        self.messages.error(cannot_open(paths), text);
    }

    /// Whether there is a scene, or was one that undoing brings back.
    fn has_scene(&self) -> bool {
        let undone = self.document.undo_history().next_undo();
        !self.document.scene.objects.is_empty() || undone.is_some()
    }

    /// Puts what was read in place of the scene.
    pub(super) fn put_opened(&mut self, opened: Opened) {
        let Opened {
            paths,
            loaded,
            picture,
            moved,
        } = opened;
        let paths = &paths[..];
        let file = match paths {
            [path] if io::is_scene_file(path) => Some(path.clone()),
            _ => None,
        };
        let name = match paths {
            [] => "Demo".to_owned(),
            [first, ..] => name_of(first),
        };
        let before = self.open_document(loaded.scene, name, file, None);
        if let Some(before) = before {
            self.messages.news(format!("Undo brings {before} back"));
        }
        self.take_moved(moved);
        if !loaded.warnings.is_empty() {
            let title = format!("Opened {} with remarks", what(paths));
            self.messages.warning(title, loaded.warnings.join("\n"));
        }
        if let [path] = paths {
            self.remember(path);
            if let Some(picture) = picture {
                self.show_opened(path, picture);
            }
        }
    }

    /// Puts another scene in place of the present one; `saved`: what its file holds, where it is not the scene itself. Returns the name of the one before,
    /// which undoing brings back; `None` where there was none.
    pub(super) fn open_document(
        &mut self,
        scene: Scene,
        name: String,
        path: Option<PathBuf>,
        saved: Option<Scene>,
    ) -> Option<String> {
        let before = self.document.name().to_owned();
        let is_first = self.document.scene.objects.is_empty()
            && self.document.undo_history().next_undo().is_none();
        let selection = std::mem::take(&mut self.selection);
        match (is_first, saved) {
            (true, None) => self.document = Document::new(scene, name, path),
            (true, Some(saved)) => self.document = Document::restored(scene, name, path, saved),
            (false, None) => self.document.open(scene, name, path, &selection),
            (false, Some(saved)) => {
                let document = &mut self.document;
                document.open_restored(scene, (name, path), saved, &selection);
            }
        }
        self.show_other_scene();
        if let Some(path) = self.document.path() {
            let began = self.reloading.began;
            self.reloading.watch.forget(&absolute(path), began);
        }
        self.messages.clear();
        self.messages.news("");
        (!is_first).then_some(before)
    }

    /// Forgets what belonged to the scene that was shown before: the document has another one now. A render that was asked for goes on as it
    /// does beside any other edit, and what it has reached stays on disk.
    pub(super) fn show_other_scene(&mut self) {
        self.jobs.cancel(Lane::Prepare);
        self.jobs.cancel(Lane::Encode);
        self.jobs.cancel(Lane::Reload);
        self.jobs.cancel(Lane::Trace);
        self.reloading.forget();
        self.viewport.release();
        self.rays = None;
        self.selection = Selection::Camera;
        self.view = View::Preview;
        self.prepared = None;
        self.primary_hits.clear();
        self.sketches = SketchStore::default();
        self.cancel_measuring_costs();
        self.costs = CostState::Unknown;
        self.stop_estimating_time();
        self.preparing = None;
        self.unwanted_preparation = None;
        self.problem = None;
        self.hide_past_render();
        let goes_on = |picture: &Picture| picture.is_running() && !picture.is_preparing;
        if self.is_live || !self.picture.as_ref().is_some_and(goes_on) {
            self.put_picture_away();
        }
        // What follows every change follows this one, but for the times of a report, which it would spoil.
        let is_followed = self.is_live && !self.report.is_running();
        self.waiting_render = is_followed.then(|| WaitingRender {
            follows: true,
            ..WaitingRender::new()
        });
    }

    /// Ends the present picture, where it is not ended, and puts it among the renders where it is one to remember.
    fn put_picture_away(&mut self) {
        self.jobs.cancel(Lane::Render);
        if !self.is_live || self.picture.as_ref().is_some_and(Picture::is_long) {
            // What a render has reached stays among the renders.
            self.end_picture(Outcome::Cancelled);
        }
        if let Some(picture) = self.picture.take() {
            self.keep_render(picture);
        }
    }

    pub(super) fn image_loaded(&mut self, path: &Path, result: Result<RadianceFile, String>) {
        let shown = what(&[path.to_owned()]);
        let file = match result {
            Ok(file) => file,
            Err(error) => {
                let title = format!("Cannot use {shown} as the background");
                let text = format!("{error}\nThe background is as it was.");
                self.messages.error(title, text);
                return;
            }
        };
        let warnings = io::image_warnings(&path.display().to_string(), &file);
        if !warnings.is_empty() {
            let title = format!("The background is {shown}, with remarks");
            self.messages.warning(title, warnings.join("\n"));
        }
        // What was edited while it was read is a step of its own.
        self.document.record_edit(&self.selection);
        let scene = &mut self.document.scene;
        let image = io::absolute_image(&path.to_string_lossy(), Path::new("."));
        // Large, and not coming back on its own.
        scene.images.clear();
        scene.images.insert(image.clone(), Arc::new(file.map));
        scene.background = with_image(&scene.background, image, scene.camera.up);
        self.selection = Selection::Background;
        self.show_camera_view();
        self.messages.news(format!("The background is {shown}"));
    }
}

/// The title of the banner about files that cannot be opened.
pub(super) fn cannot_open(paths: &[PathBuf]) -> String {
    format!("Cannot open {}", what(paths))
}

/// What is being opened, in words.
pub(super) fn what(paths: &[PathBuf]) -> String {
    let name = |path: &PathBuf| {
        path.file_name().map_or_else(
            || path.display().to_string(),
            |n| n.to_string_lossy().into_owned(),
        )
    };
    match paths {
        [] => "the demo scene".to_owned(),
        [path] => name(path),
        [first, rest @ ..] => format!("{} and {} more", name(first), rest.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::app::testing;
    use crate::io::{Origin, Values};
    use crate::render::{Image, Layer};

    /// Each byte counts once as it is read and once as it is understood; one that was read again would count again.
    #[test]
    fn a_render_is_read_once_and_its_progress_ends_with_it() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("render.exr");
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = (64, 48);
        let origin = Origin {
            scene: &scene,
            error: None,
            region: None,
            values: Values::Rendered,
        };
        let layers = [(Layer::Emission, Image::black(64, 48))];
        io::write_render(&Image::black(64, 48), &layers, &origin, &path).expect("is written");
        let scene_file = folder.path().join("scene.toml");
        io::save_scene(&scene, &scene_file).expect("is saved");

        let mut window = testing::window(None);
        let progress_of = |window: &mut egui_kittest::Harness<'static, App>, path: &Path| {
            window.state_mut().load(vec![path.to_owned()]);
            let loading = window.state().loading.as_ref().expect("it is read");
            let progress = loading.progress.clone();
            testing::until(window, |app| app.loading.is_none());
            assert_eq!(progress.done(), progress.total());
            progress.total()
        };
        let scene = progress_of(&mut window, &scene_file);
        let render = progress_of(&mut window, &path);
        let file = std::fs::metadata(&path).expect("is there").len();
        assert_eq!(render, scene + 2 * file);
        let picture = window.state().picture_on_screen().expect("it is shown");
        assert_eq!(picture.buffer.layers(), [Layer::Emission]);
    }
}
