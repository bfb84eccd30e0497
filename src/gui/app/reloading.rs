//! Meshes, images and scene files that change on disk while they are open.
//!
//! A mesh or an image takes the place of the one that was read before, in every step to undo as well: the file is what it is, and what
//! was edited stays. One that was written again as it was before starts nothing anew. A scene file is read again at once where nothing
//! would be lost by that, and as a step to undo; else the user is asked. What cannot be read leaves everything as it is, and is tried
//! again when it changes again.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use egui::{Frame, Margin, RichText, Ui};

use super::App;
use super::opening::what;
use crate::gui::document::{Document, name_of};
use crate::gui::event::Reloaded;
use crate::gui::jobs::Lane;
use crate::gui::watching::{self, FileWatch};
use crate::gui::worker;
use crate::io::{self, LoadedScene, ReadAgain};

/// What is read again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stale {
    /// The meshes of a file.
    Meshes(PathBuf),
    /// An image of the background.
    Image(PathBuf),
    /// The images of materials that are in a file.
    Textures(PathBuf),
    /// The scene file.
    Scene {
        /// The file.
        path: PathBuf,
        /// Whether the user wants it in place of unsaved work.
        is_wanted: bool,
    },
}

impl Stale {
    /// Its file.
    #[must_use]
    pub fn path(&self) -> &Path {
        let (Self::Meshes(path)
        | Self::Image(path)
        | Self::Textures(path)
        | Self::Scene { path, .. }) = self;
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
    /// What is being read again.
    reading: Option<Stale>,
    /// What the watched files were found from.
    sources: Sources,
    /// When reading began last.
    pub(super) began: Option<SystemTime>,
    /// Whether the scene file has changed beside unsaved work.
    pub(super) asks: bool,
}

impl Reloading {
    /// Forgets what was to be read again for a scene that is not shown any more. Of its own file that is told again where undoing brings it
    /// back: nobody has decided about it.
    pub(super) fn forget(&mut self) {
        let is_scene = |stale: &Stale| matches!(stale, Stale::Scene { .. });
        let mut undone = self.stale.iter().chain(&self.reading);
        if let Some(own) = &self.sources.own
            && (self.asks || undone.any(is_scene))
        {
            self.watch.tell_again(&absolute(own));
        }
        self.stale.clear();
        self.reading = None;
        self.asks = false;
    }
}

/// A scene's file and the names of all that was ever read for it: undoing may bring back what the scene has no more.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Sources {
    own: Option<PathBuf>,
    meshes: BTreeSet<String>,
    images: BTreeSet<String>,
    textures: BTreeSet<String>,
}

impl Sources {
    /// Takes in those of `document`.
    fn add(&mut self, document: &Document) {
        let scene = &document.scene;
        self.own = document.path().map(Path::to_owned);
        self.meshes.extend(scene.meshes.keys().cloned());
        self.images.extend(scene.images.keys().cloned());
        self.textures.extend(scene.textures.keys().cloned());
    }

    /// Whether those of `document` are among them.
    fn have(&self, document: &Document) -> bool {
        let scene = &document.scene;
        self.own.as_deref() == document.path()
            && scene.meshes.keys().all(|name| self.meshes.contains(name))
            && scene.images.keys().all(|name| self.images.contains(name))
            && scene
                .textures
                .keys()
                .all(|name| self.textures.contains(name))
    }

    /// The names of what is to be read again for `stale`.
    fn names_for(&self, stale: &Stale) -> Vec<String> {
        let names = match stale {
            Stale::Meshes(_) => &self.meshes,
            Stale::Textures(_) => &self.textures,
            Stale::Image(_) | Stale::Scene { .. } => return Vec::new(),
        };
        let names = names.iter().filter(|name| is_in(name, stale.path()));
        names.cloned().collect()
    }

    /// The files, each once.
    fn files(&self) -> BTreeSet<PathBuf> {
        let names = self.meshes.iter().chain(&self.textures);
        let names = names.map(|name| io::file_and_part(name).0);
        let names = names.chain(self.images.iter().map(String::as_str));
        let paths = names.map(Path::new).filter(|path| path.is_absolute());
        let own = self.own.as_deref().map(absolute);
        paths.map(Path::to_owned).chain(own).collect()
    }
}

/// Whether what is called `name` is in the file at `path`.
fn is_in(name: &str, path: &Path) -> bool {
    Path::new(io::file_and_part(name).0) == path
}

impl App {
    /// Watches the files that the scene came from.
    pub(super) fn watch_files(&mut self) {
        if self.reloading.sources.have(&self.document) {
            return;
        }
        let Reloading {
            sources,
            watch,
            began,
            ..
        } = &mut self.reloading;
        sources.add(&self.document);
        watch.set_files(sources.files(), *began);
        if !self.jobs.is_busy(Lane::Watch) {
            let files = self.reloading.watch.clone();
            self.jobs
                .start(Lane::Watch, move |job| watching::watch(job, &files));
        }
    }

    /// Takes in that files have changed.
    pub(super) fn files_changed(&mut self, paths: Vec<PathBuf>) {
        for path in paths {
            let sources = &self.reloading.sources;
            let has_meshes = sources.meshes.iter().any(|name| is_in(name, &path));
            let has_textures = sources.textures.iter().any(|name| is_in(name, &path));
            let is_image = sources.images.contains(&*path.to_string_lossy());
            let is_own = self.is_own(&path);
            // One file may be several of them.
            if has_meshes {
                self.queue_reload(Stale::Meshes(path.clone()));
            }
            if has_textures {
                self.queue_reload(Stale::Textures(path.clone()));
            }
            if is_image {
                self.queue_reload(Stale::Image(path.clone()));
            }
            if is_own && self.document.is_modified() {
                self.reloading.asks = true;
            } else if is_own {
                let is_wanted = false;
                self.queue_reload(Stale::Scene { path, is_wanted });
            }
        }
    }

    /// Says that files are not there any more from which the scene has what it shows.
    pub(super) fn files_gone(&mut self, paths: &[PathBuf]) {
        let scene = &self.document.scene;
        let names = scene.meshes.keys().chain(scene.textures.keys());
        let names: Vec<&String> = names.chain(scene.images.keys()).collect();
        let is_part = |path: &&PathBuf| names.iter().any(|name| is_in(name, path));
        let gone: Vec<PathBuf> = paths.iter().filter(is_part).cloned().collect();
        if !gone.is_empty() {
            let news = format!(
                "Not there any more: {}. What was read of it stays until the scene is closed",
                what(&gone)
            );
            self.messages.news(news);
        }
    }

    /// Whether `path` is the scene's own file.
    pub(super) fn is_own(&self, path: &Path) -> bool {
        let own = self.document.path().map(absolute);
        own.as_deref() == Some(path)
    }

    /// Takes note that the scene's file holds what was saved: what it held before is not read any more.
    pub(super) fn forget_stale_scene(&mut self) {
        let is_part = |stale: &Stale| !matches!(stale, Stale::Scene { .. });
        self.reloading.asks = false;
        self.reloading.stale.retain(is_part);
        if self
            .reloading
            .reading
            .take_if(|stale| !is_part(stale))
            .is_some()
        {
            self.jobs.cancel(Lane::Reload);
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
        let is_part = |stale: &Stale| !matches!(stale, Stale::Scene { .. });
        let first = self.reloading.stale.iter().position(is_part).unwrap_or(0);
        if let Some(stale) = self.reloading.stale.remove(first) {
            let known = self.document.scene.clone();
            let names = self.reloading.sources.names_for(&stale);
            self.reloading.reading = Some(stale.clone());
            self.jobs.start(Lane::Reload, move |job| {
                worker::reload(job, stale, &names, known);
            });
        }
    }

    pub(super) fn reloaded(&mut self, stale: &Stale, result: Result<Reloaded, String>) {
        self.reloading.reading = None;
        if let Stale::Scene { path, is_wanted } = stale {
            if !self.is_own(path) {
                return;
            }
            // Edited, or on its way to the file, since the file was found to be another.
            let is_at_risk = self.document.is_modified() || self.jobs.is_busy(Lane::SaveScene);
            if is_at_risk && !is_wanted && result.is_ok() {
                self.reloading.asks = true;
                return;
            }
        }
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
        let is_unchanged = self.has_all_of(stale, &reloaded);
        let warnings = match reloaded {
            Reloaded::Meshes(ReadAgain { meshes, warnings }) => {
                for (name, mesh) in meshes {
                    self.document.replace_mesh(&name, &mesh);
                }
                warnings
            }
            Reloaded::Image { image, warnings } => {
                let name = stale.path().to_string_lossy();
                self.document.replace_image(&name, &image);
                warnings
            }
            Reloaded::Textures { images, warnings } => {
                for (name, image) in images {
                    self.document.replace_texture(&name, &image);
                }
                warnings
            }
            Reloaded::Scene(loaded) => {
                let LoadedScene { scene, warnings } = *loaded;
                self.viewport.release();
                self.document.reload(scene, &self.selection);
                self.reloading.asks = false;
                warnings
            }
        };
        if is_unchanged {
            // Its remarks were told when it was read first.
            let news = format!("{} was written again, unchanged", stale.name());
            return self.messages.news(news);
        }
        if !warnings.is_empty() {
            let title = format!("Read {} again, with remarks", stale.name());
            self.messages.warning(title, warnings.join("\n"));
        }
        self.messages
            .news(format!("{} has changed: read again", stale.name()));
    }

    /// Whether the scene has all that was read again already, as [`Reloaded`] says.
    fn has_all_of(&self, stale: &Stale, reloaded: &Reloaded) -> bool {
        let scene = &self.document.scene;
        match reloaded {
            Reloaded::Meshes(ReadAgain { meshes, .. }) => has_all(&scene.meshes, meshes),
            Reloaded::Image { image, .. } => {
                let there = scene.images.get(&*stale.path().to_string_lossy());
                there.is_some_and(|there| Arc::ptr_eq(there, image))
            }
            Reloaded::Textures { images, .. } => has_all(&scene.textures, images),
            Reloaded::Scene(_) => false,
        }
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
                    let keep = ui.button("Keep mine").on_hover_text(
                        "Go on with what is here; saving asks before it replaces the file",
                    );
                    if reload.clicked() {
                        let (path, is_wanted) = (path.clone(), true);
                        self.queue_reload(Stale::Scene { path, is_wanted });
                    }
                    if reload.clicked() || keep.clicked() {
                        self.reloading.asks = false;
                    }
                });
            });
    }
}

/// Whether `known` has the very same things under the same names.
fn has_all<T>(known: &BTreeMap<String, Arc<T>>, things: &[(String, Arc<T>)]) -> bool {
    things.iter().all(|(name, thing)| {
        let there = known.get(name);
        there.is_some_and(|there| Arc::ptr_eq(there, thing))
    })
}

pub(super) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
