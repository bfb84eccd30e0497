//! Questions to the user, one at a time: files to name, and what becomes of work, meshes and renders.

use std::path::{Path, PathBuf};

use egui::RichText;

use super::{App, FileDialogs};
use crate::gui::dialogs::files::{self, Answer, FilePurpose};
use crate::gui::dialogs::overwrite::{Choice as OverwriteChoice, Overwrite};
use crate::gui::dialogs::path_field::{self, Outcome as PathOutcome, PathField};
use crate::gui::dialogs::{Dialog, buttons_ui, modal_ui, question, recovery, shortcuts_ui};
use crate::gui::event::Event;
use crate::gui::jobs::Lane;
use crate::scene::Background;

impl App {
    /// Shows `dialog`, once the one that shows now is done with: what comes from the background must not take the place of what the
    /// user is answering.
    pub(super) fn ask(&mut self, dialog: Dialog) {
        if self.dialog.is_none() {
            self.dialog = Some(dialog);
        } else {
            self.asked_later.push_back(dialog);
        }
    }

    /// Shows `dialog` now; the one that shows comes back after it.
    pub(super) fn ask_first(&mut self, dialog: Dialog) {
        if let Some(shown) = self.dialog.replace(dialog) {
            self.asked_later.push_front(shown);
        }
    }

    /// Draws the question that shows, and does what it is answered.
    pub(super) fn dialogs_ui(&mut self, ctx: &egui::Context) {
        if self.dialog.is_none() {
            self.dialog = self.asked_later.pop_front();
        }
        // Taken out while it shows, so that what it leads to may put another one in its place.
        match self.dialog.take() {
            None => {}
            Some(Dialog::Shortcuts) => self.dialog = shortcuts_ui(ctx).then_some(Dialog::Shortcuts),
            Some(Dialog::Unsaved(intent)) => {
                let name = self.document.name().to_owned();
                let decision = question::unsaved_ui(ctx, &name, &intent);
                self.decide(ctx, intent, decision);
            }
            Some(Dialog::Running) => self.running_ui(ctx),
            Some(Dialog::Pictures) => self.pictures_ui(ctx),
            Some(Dialog::Forget(number)) => self.forget_ui(ctx, number),
            Some(Dialog::Anew(number)) => self.anew_ui(ctx, number),
            Some(Dialog::Import(mut import)) => {
                let decision = import.decide_ui(ctx, &self.document.scene);
                self.decide_about_import(import, decision);
            }
            Some(Dialog::Recovery(lost)) => {
                let answer = recovery::recovery_ui(ctx, &lost);
                self.decide_about_lost_work(lost, answer);
            }
            Some(Dialog::Waiting(purpose)) => self.waiting_ui(ctx, purpose),
            Some(Dialog::Missing(missing)) => self.missing_ui(ctx, missing),
            Some(Dialog::Overwrite(overwrite)) => self.overwrite_ui(ctx, overwrite),
            Some(Dialog::Path(mut field)) => match field.show_ui(ctx) {
                PathOutcome::Cancelled => self.after_saving = None,
                PathOutcome::Chosen(path) if field.purpose.is_save() => {
                    self.write_unless_there(field.purpose, path);
                }
                PathOutcome::Chosen(path) => self.use_paths(field.purpose, vec![path]),
                outcome => {
                    if let PathOutcome::List(text) = outcome
                        && !self.jobs.is_busy(Lane::List)
                    {
                        let purpose = field.purpose;
                        self.jobs.start(Lane::List, move |job| {
                            job.send(Event::Listed(path_field::list(text, purpose)));
                        });
                    }
                    self.dialog = Some(Dialog::Path(field));
                }
            },
        }
    }

    /// While the desktop's dialog is open, typing a path is always the other way.
    fn waiting_ui(&mut self, ctx: &egui::Context, purpose: FilePurpose) {
        let response = modal_ui(ctx, "waiting", 380.0, |ui| {
            ui.heading(purpose.title());
            ui.add_space(4.0);
            let text = "The desktop shows its file dialog in a window of its own. Where none appears, type the path.";
            ui.label(RichText::new(text).weak());
            buttons_ui(ui, |ui| {
                let cancel = ui.button("Cancel").clicked();
                let type_path = ui.button("Type a path instead").clicked();
                (type_path, cancel)
            })
        });
        let (type_path, cancel) = response.inner;
        if type_path {
            self.type_path(purpose, None);
        } else if cancel {
            self.jobs.cancel(Lane::Dialog);
            self.after_saving = None;
        } else if self.jobs.is_busy(Lane::Dialog) {
            self.dialog = Some(Dialog::Waiting(purpose));
        }
    }

    /// Asks for a path: the desktop's dialog where there is one, else the path field.
    pub(super) fn ask_for_path(&mut self, purpose: FilePurpose) {
        match self.file_dialogs {
            FileDialogs::Desktop => {
                let suggestion = self.suggested_path(purpose);
                self.ask(Dialog::Waiting(purpose));
                self.jobs.start(Lane::Dialog, move |job| {
                    files::ask(job, purpose, &suggestion);
                });
            }
            FileDialogs::PathField => self.type_path(purpose, None),
        }
    }

    /// Shows the path field.
    pub(super) fn type_path(&mut self, purpose: FilePurpose, note: Option<String>) {
        self.jobs.cancel(Lane::Dialog);
        let field = PathField::new(purpose, &self.suggested_path(purpose), note);
        self.ask(Dialog::Path(field));
    }

    /// The desktop's dialog has answered.
    pub(super) fn paths_chosen(&mut self, answer: Answer) {
        let is_other = |dialog: &Dialog| !matches!(dialog, Dialog::Waiting(_));
        self.dialog.take_if(|dialog| !is_other(dialog));
        self.asked_later.retain(is_other);
        if answer.nobody_saw_it {
            let reason = if cfg!(target_os = "linux") {
                " (no xdg-desktop-portal answers)"
            } else {
                ""
            };
            let note = format!(
                "This desktop offers no file dialog{reason}, so type the path or click your way to it."
            );
            self.file_dialogs = FileDialogs::PathField;
            self.type_path(answer.purpose, Some(note));
        } else if answer.paths.is_empty() {
            self.after_saving = None;
        } else {
            self.use_paths(answer.purpose, answer.paths);
        }
    }

    /// Does with `paths` what they were asked for; only meshes and scenes are ever several.
    fn use_paths(&mut self, purpose: FilePurpose, paths: Vec<PathBuf>) {
        match (purpose, paths.first().cloned()) {
            (FilePurpose::Open, _) => self.open(paths),
            (FilePurpose::AddMesh, _) => self.import(paths, false),
            (_, None) => {}
            (FilePurpose::SetBackground, Some(path)) => self.set_background(path),
            (FilePurpose::SetTexture(texture), Some(path)) => self.set_texture(path, texture),
            (FilePurpose::Compare, Some(path)) => self.compare_with_file(path),
            (FilePurpose::Locate(_), Some(path)) => self.locate(&path),
            (FilePurpose::ReportFolder | FilePurpose::ReportReference, Some(path)) => {
                self.report.set_path(purpose, &path);
            }
            (FilePurpose::SaveScene | FilePurpose::SavePicture, Some(path)) => {
                self.write_to(purpose, path);
            }
        }
    }

    /// Writes the scene or the picture to `path`, with the extension that it lacks.
    fn write_to(&mut self, purpose: FilePurpose, path: PathBuf) {
        let whole = purpose.with_extension(path.clone());
        if whole == path {
            self.write(purpose, path);
        } else {
            // The desktop has asked about a file of the shorter name.
            self.write_unless_there(purpose, whole);
        }
    }

    /// Writes the scene or the picture to `path`; where a file is there, it is asked first.
    fn write_unless_there(&mut self, purpose: FilePurpose, path: PathBuf) {
        if path.is_file() {
            self.ask(Dialog::Overwrite(Overwrite {
                purpose,
                path,
                has_changed: false,
            }));
        } else {
            self.write(purpose, path);
        }
    }

    fn write(&mut self, purpose: FilePurpose, path: PathBuf) {
        if purpose == FilePurpose::SaveScene {
            self.write_scene(path, true);
        } else {
            self.write_picture(path);
        }
    }

    /// The scene's own file at `path` is not what was read or saved last.
    pub(super) fn ask_to_overwrite_scene(&mut self, path: PathBuf) {
        let mut asked = self.dialog.iter().chain(&self.asked_later);
        if !asked.any(|dialog| matches!(dialog, Dialog::Overwrite(_))) {
            self.ask(Dialog::Overwrite(Overwrite {
                purpose: FilePurpose::SaveScene,
                path,
                has_changed: true,
            }));
        }
    }

    fn overwrite_ui(&mut self, ctx: &egui::Context, overwrite: Overwrite) {
        match overwrite.show_ui(ctx) {
            None => self.dialog = Some(Dialog::Overwrite(overwrite)),
            Some(OverwriteChoice::Overwrite) => self.write(overwrite.purpose, overwrite.path),
            Some(OverwriteChoice::Elsewhere) if self.file_dialogs == FileDialogs::PathField => {
                let field = PathField::new(overwrite.purpose, &overwrite.path, None);
                self.ask(Dialog::Path(field));
            }
            Some(OverwriteChoice::Elsewhere) => self.ask_for_path(overwrite.purpose),
            Some(OverwriteChoice::Cancel) => self.after_saving = None,
        }
    }

    /// Where a file dialog starts, and the name it offers.
    fn suggested_path(&self, purpose: FilePurpose) -> PathBuf {
        let here = std::env::current_dir().unwrap_or_default();
        let folder = self.document.path().and_then(Path::parent).unwrap_or(&here);
        match purpose {
            FilePurpose::Open
            | FilePurpose::AddMesh
            | FilePurpose::SetTexture(_)
            | FilePurpose::ReportReference
            | FilePurpose::Compare => folder.join(""),
            FilePurpose::Locate(_) => self.folder_of_located().unwrap_or_else(|| folder.join("")),
            FilePurpose::ReportFolder => self.report.folder(),
            FilePurpose::SetBackground => match &self.document.scene.background {
                // Others are likely beside it.
                Background::Image { image, .. } => {
                    Path::new(image).parent().unwrap_or(folder).join("")
                }
                _ => folder.join(""),
            },
            FilePurpose::SaveScene => folder.join(format!("{}.toml", self.document.name())),
            FilePurpose::SavePicture => folder.join(format!("{}.png", self.document.name())),
        }
    }
}
