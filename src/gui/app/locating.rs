//! Scenes some of whose files are not there: the question about them, where the user says they are, and what is opened then; and the same for
//! the scene that is open.

use std::path::{Path, PathBuf};

use super::App;
use super::opening::what;
use crate::gui::dialogs::Dialog;
use crate::gui::dialogs::files::FilePurpose;
use crate::gui::dialogs::missing::{Choice, Lacking, Missing};
use crate::gui::event::Event;
use crate::gui::jobs::Lane;
use crate::gui::worker;
use crate::io::{
    self, Found, MissingFile, MissingKind, Moves, READABLE_EXTENSIONS, TEXTURE_EXTENSIONS,
};
use crate::scene::Scene;

impl App {
    /// A scene lacks files. Those that were found for another are there still; lost work that lacks no others comes back without a question.
    pub(super) fn files_missing(&mut self, mut missing: Missing) {
        self.loading = None;
        let is_lacking = |from: &PathBuf| missing.files.iter().any(|file| file.path == *from);
        if missing.is_untouched() {
            let known = self.found_places.iter();
            let known = known.filter(|(from, _)| is_lacking(from));
            missing.found = known.map(|(from, to)| (from.clone(), to.clone())).collect();
            if let Lacking::Work(_) = missing.of
                && missing.lacks_nothing()
            {
                return self.open_without_missing(missing);
            }
        } else {
            // What was of no use here is of none elsewhere.
            let places = &mut self.found_places;
            places.retain(|from, _| !is_lacking(from) || missing.found.contains_key(from));
        }
        self.ask(Dialog::Missing(missing));
    }

    /// Asks about files that are not there.
    pub(super) fn missing_ui(&mut self, ctx: &egui::Context, missing: Missing) {
        match missing.show_ui(ctx) {
            None => self.dialog = Some(Dialog::Missing(missing)),
            Some(Choice::Open) => self.open_without_missing(missing),
            Some(Choice::Locate(path)) => {
                let purpose = FilePurpose::Locate(missing.kind_of(&path));
                let located = Some(path);
                // It comes back when that is answered.
                let missing = Missing { located, ..missing };
                self.asked_later.push_front(Dialog::Missing(missing));
                self.ask_for_path(purpose);
            }
            Some(Choice::Cancel) => {
                if let Lacking::Work(lost) = &missing.of {
                    let name = &lost.about.name;
                    let news =
                        format!("The unsaved work on {name} is offered again at the next start");
                    self.messages.news(news);
                }
            }
        }
    }

    /// Opens what lacks files with those that were found, and without the rest.
    fn open_without_missing(&mut self, missing: Missing) {
        self.found_places.extend(missing.found.clone());
        let path = match missing.of.clone() {
            Lacking::File(path) => path,
            Lacking::Work(lost) => return self.restore_without_missing(lost, missing),
        };
        let progress = self.begin_loading(what(std::slice::from_ref(&path)));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_scene_without_missing(job, path, missing, &progress);
        });
    }

    /// The question whose file is being located.
    fn question_of_located(&mut self) -> Option<&mut Missing> {
        let asked = self.dialog.iter_mut().chain(&mut self.asked_later);
        let mut questions = asked.filter_map(|dialog| match dialog {
            Dialog::Missing(missing) => Some(missing),
            _ => None,
        });
        questions.find(|missing| missing.located.is_some())
    }

    /// The file that is being located is at `path`, as the user says.
    pub(super) fn locate(&mut self, path: &Path) {
        let to = PathBuf::from(io::absolute_image(&path.to_string_lossy(), Path::new(".")));
        let Some(missing) = self.question_of_located() else {
            return self.locate_sought(to);
        };
        let Some(from) = missing.located.clone() else {
            return;
        };
        let files = missing.files.clone();
        let kind = missing.kind_of(&from);
        self.jobs.start(Lane::Locate, move |job| {
            job.send(Event::Located(look_at((from, kind), to, &files)));
        });
    }

    /// It was looked where files are, or why not.
    pub(super) fn located(&mut self, result: Result<Moves, String>) {
        let Some(missing) = self.question_of_located() else {
            return;
        };
        match result {
            Ok(found) => missing.take_found(found),
            Err(problem) => (missing.located, missing.problem) = (None, Some(problem)),
        }
    }

    /// Asks where the file is that the open scene names at `path`, and that is not there.
    pub(super) fn seek(&mut self, path: &Path) {
        let missing = io::missing_in(&self.document.scene);
        self.sought = missing.into_iter().find(|file| file.path == path);
        if let Some(file) = &self.sought {
            self.ask_for_path(FilePurpose::Locate(file.kind));
        }
    }

    /// The file that is [sought](Self::seek) is at `to`, as the user says: it is read from there, with what moved with it.
    fn locate_sought(&mut self, to: PathBuf) {
        let Some(sought) = self.sought.take() else {
            return;
        };
        self.begin_loading(what(std::slice::from_ref(&to)));
        let scene = self.document.scene.clone();
        let file = self.document.file_number();
        self.jobs.start(Lane::Load, move |job| {
            let missing = io::missing_in(&scene);
            let found = look_at((sought.path, sought.kind), to, &missing);
            let found = found.map(|moves| Found::read(&scene, moves, &job.cancel));
            let result = match found {
                Ok(Ok(None)) => return,
                Ok(Ok(Some(found))) => Ok(Box::new(found)),
                Ok(Err(error)) => Err(error.to_string()),
                Err(problem) => Err(problem),
            };
            job.send(Event::SoughtRead { file, result });
        });
    }

    /// What was sought for the scene that belongs to [file number](crate::gui::document::Document::file_number) `file` was read, or why not.
    pub(super) fn sought_read(&mut self, file: usize, result: Result<Box<Found>, String>) {
        self.loading = None;
        if file != self.document.file_number() {
            return;
        }
        match result {
            Ok(found) => {
                self.found_places.extend(found.moves.clone());
                self.document.record_edit(&self.selection);
                let scene = found.put_into(&self.document.scene);
                self.take_moved(Some(scene));
                if !found.warnings.is_empty() {
                    let title = "Found files, with remarks";
                    self.messages.warning(title, found.warnings.join("\n"));
                }
            }
            Err(problem) => {
                let text = format!("{problem}\nThe scene is as it was.");
                self.messages.error("This is not the missing file", text);
            }
        }
    }

    /// Where the file dialog starts that looks for what is being located: what was moved is likely near what names it.
    pub(super) fn folder_of_located(&self) -> Option<PathBuf> {
        let asked = self.dialog.iter().chain(&self.asked_later);
        let mut questions = asked.filter_map(|dialog| match dialog {
            Dialog::Missing(missing) if missing.located.is_some() => Some(missing),
            _ => None,
        });
        let missing = questions.next()?;
        let scene = match &missing.of {
            Lacking::File(path) => Some(path),
            Lacking::Work(lost) => lost.about.path.as_ref(),
        };
        let file = scene.or(missing.located.as_ref())?;
        Some(super::reloading::absolute(file).parent()?.join(""))
    }

    /// Puts `moved`, the open scene with what was found elsewhere, in its place, as a step to undo.
    pub(super) fn take_moved(&mut self, moved: Option<Scene>) {
        let Some(scene) = moved else { return };
        self.document.scene = scene;
        let name = "locating files".to_owned();
        self.document.record_edit_as(&self.selection, name);
        let news = "The scene has its files where they were found; saving writes that";
        self.messages.news(news);
    }
}

/// Where the file of that `kind` that was at `from`, which is at `to` as the user says, and other `files` are that moved with it.
fn look_at(
    (from, kind): (PathBuf, MissingKind),
    to: PathBuf,
    files: &[MissingFile],
) -> Result<Moves, String> {
    if !to.is_file() {
        return Err(format!("There is no file {}", to.display()));
    }
    if is_of_other_kind(&to, kind) {
        let what = match kind {
            MissingKind::Mesh => "a mesh",
            MissingKind::Background => "an image of radiance, EXR or HDR",
            MissingKind::Texture => "an image",
        };
        return Err(format!("{} is not {what}", to.display()));
    }
    let mut moves = io::moved_along(&from, &to, files);
    moves.insert(from, to);
    Ok(moves)
}

/// Whether the name of the file at `path` says that it is nothing of that `kind`. Names that say nothing are anything, until it is read.
fn is_of_other_kind(path: &Path, kind: MissingKind) -> bool {
    let Some(extension) = path.extension().and_then(|extension| extension.to_str()) else {
        return false;
    };
    let is_among = |extensions: &[&str]| {
        let mut extensions = extensions.iter();
        extensions.any(|known| extension.eq_ignore_ascii_case(known))
    };
    let known = [READABLE_EXTENSIONS, TEXTURE_EXTENSIONS, &["toml"]];
    known.iter().any(|known| is_among(known)) && !is_among(&FilePurpose::Locate(kind).extensions())
}
