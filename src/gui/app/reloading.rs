//! Meshes, images and scene files that change on disk while they are open.
//!
//! A mesh or an image takes the place of the one that was read before, in every step to undo as well: the file is what it is, and what
//! was edited stays. A scene file is read again at once where nothing would be lost by that, and as a step to undo; else the user is
//! asked. What cannot be read leaves everything as it is, and is tried again when it changes again.

use std::collections::{BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Frame, Margin, RichText, Ui};

use super::App;
use crate::gui::document::name_of;
use crate::gui::event::Reloaded;
use crate::gui::jobs::Lane;
use crate::gui::watching::{self, FileWatch};
use crate::gui::worker;
use crate::io::{self, LoadedScene, ReadAgain};
use crate::scene::Scene;

/// What is read again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stale {
    /// The meshes of a file.
    Meshes(PathBuf),
    /// An image of the background.
    Image(PathBuf),
    /// The scene file.
    Scene(PathBuf),
}

impl Stale {
    /// Its file.
    #[must_use]
    pub fn path(&self) -> &Path {
        let (Self::Meshes(path) | Self::Image(path) | Self::Scene(path)) = self;
        path
    }

    /// What its file is called.
    fn name(&self) -> String {
        let path = self.path();
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// What is said where it cannot be read.
    fn complaint(&self) -> String {
        format!("{} has changed and cannot be read", self.name())
    }
}

/// What is watched, and what has changed.
#[derive(Debug, Default)]
pub struct Reloading {
    pub(super) watch: FileWatch,
    /// What was not read again yet.
    pub(super) stale: VecDeque<Stale>,
    /// Whether the scene file has changed beside unsaved work.
    pub(super) asks: bool,
}

/// The files that `scene` was read from, but for its own, each once.
fn parts_of(scene: &Scene) -> BTreeSet<&Path> {
    let meshes = scene.meshes.keys().map(|name| io::file_and_part(name).0);
    let names = meshes.chain(scene.images.keys().map(String::as_str));
    let paths = names.map(Path::new);
    paths.filter(|path| path.is_absolute()).collect()
}

impl App {
    /// Watches the files that the scene came from.
    pub(super) fn watch_files(&mut self) {
        let own = self.document.path().map(absolute);
        let parts = parts_of(&self.document.scene);
        let parts = || parts.iter().copied().chain(own.as_deref());
        if self.reloading.watch.has_files(parts()) {
            return;
        }
        self.reloading.watch.set_files(parts().map(Path::to_owned));
        if !self.jobs.is_busy(Lane::Watch) {
            let files = self.reloading.watch.clone();
            self.jobs
                .start(Lane::Watch, move |job| watching::watch(job, &files));
        }
    }

    /// Takes in that files have changed.
    pub(super) fn files_changed(&mut self, paths: Vec<PathBuf>) {
        for path in paths {
            let scene = &self.document.scene;
            let name = path.to_string_lossy();
            let is_own = self.document.path().map(absolute) == Some(path.clone());
            let mut meshes = scene.meshes.keys();
            let stale = if meshes.any(|mesh| io::file_and_part(mesh).0 == name) {
                Stale::Meshes(path)
            } else if scene.images.contains_key(&*name) {
                Stale::Image(path)
            } else if is_own && self.document.is_modified() {
                self.reloading.asks = true;
                continue;
            } else if is_own {
                Stale::Scene(path)
            } else {
                continue;
            };
            self.queue_reload(stale);
        }
    }

    fn queue_reload(&mut self, stale: Stale) {
        if !self.reloading.stale.contains(&stale) {
            self.reloading.stale.push_back(stale);
        }
    }

    /// Reads the next changed file, if one waits. A scene goes after its meshes, which it keeps where they are the same.
    pub(super) fn reload_next(&mut self) {
        if self.jobs.is_busy(Lane::Reload) || self.jobs.is_busy(Lane::Load) {
            return;
        }
        let is_part = |stale: &Stale| !matches!(stale, Stale::Scene(_));
        let first = self.reloading.stale.iter().position(is_part).unwrap_or(0);
        if let Some(stale) = self.reloading.stale.remove(first) {
            let known = self.document.scene.clone();
            self.jobs
                .start(Lane::Reload, move |job| worker::reload(job, stale, known));
        }
    }

    pub(super) fn reloaded(&mut self, stale: &Stale, result: Result<Reloaded, String>) {
        self.messages.withdraw(&stale.complaint());
        let reloaded = match result {
            Ok(reloaded) => reloaded,
            Err(error) => {
                let text = format!(
                    "{error}\nWhat was read before is still here. The file is read again as soon as it changes."
                );
                return self.messages.error(stale.complaint(), text);
            }
        };
        let name = stale.path().to_string_lossy().into_owned();
        let warnings = match reloaded {
            Reloaded::Meshes(ReadAgain { meshes, warnings }) => {
                for (name, mesh) in meshes {
                    self.document.replace_mesh(&name, &mesh);
                }
                warnings
            }
            Reloaded::Image(file) => {
                let warnings = io::image_warnings(&name, &file);
                self.document.replace_image(&name, &Arc::new(file.map));
                warnings
            }
            Reloaded::Scene(loaded) => {
                let LoadedScene { scene, warnings } = *loaded;
                self.document.reload(scene, &self.selection);
                self.reloading.asks = false;
                warnings
            }
        };
        if !warnings.is_empty() {
            let title = format!("Read {} again, with remarks", stale.name());
            self.messages.warning(title, warnings.join("\n"));
        }
        self.messages
            .news(format!("{} has changed: read again", stale.name()));
    }

    /// Whether the scene file has changed beside unsaved work, and nothing was decided about that.
    #[must_use]
    pub fn asks_to_reload(&self) -> bool {
        self.reloading.asks
    }

    /// Asks whether to give up unsaved changes for a scene file that has changed.
    pub(super) fn reload_question_ui(&mut self, ui: &mut Ui) {
        let Some(path) = self.document.path().filter(|_| self.reloading.asks) else {
            return;
        };
        let path = absolute(path);
        let color = ui.visuals().warn_fg_color;
        Frame::new()
            .fill(ui.visuals().panel_fill.lerp_to_gamma(color, 0.16))
            .inner_margin(Margin::symmetric(12, 8))
            .show(ui, |ui| {
                ui.set_width(ui.available_width());
                let title = format!("{} has changed on disk", name_of(&path));
                ui.label(RichText::new(title).strong().color(color));
                ui.horizontal(|ui| {
                    ui.label("It is not what you edit here, which is not saved.");
                    let reload = ui.button("Read it again").on_hover_text(
                        "Take the file's scene in place of yours; Undo brings yours back",
                    );
                    let keep = ui
                        .button("Keep mine")
                        .on_hover_text("Go on with what is here; saving replaces the file");
                    if reload.clicked() {
                        self.queue_reload(Stale::Scene(path.clone()));
                    }
                    if reload.clicked() || keep.clicked() {
                        self.reloading.asks = false;
                    }
                });
            });
    }
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
