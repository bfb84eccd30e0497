//! Scenes and pictures to files, and what waits for unsaved work.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::App;
use crate::gui::dialogs::files::FilePurpose;
use crate::gui::dialogs::question::{self, Decision};
use crate::gui::dialogs::{Dialog, Intent};
use crate::gui::event::Event;
use crate::gui::jobs::Lane;
use crate::gui::picture::Outcome;
use crate::gui::worker;
use crate::scene::Scene;

/// What a banner says until the scene is saved.
const CANNOT_SAVE: &str = "Cannot save the scene";

impl App {
    /// Writes the scene to its file, or asks for one.
    pub(super) fn save_scene(&mut self) {
        match self.document.path().map(Path::to_owned) {
            Some(path) => self.write_scene(path),
            None => self.ask_for_path(FilePurpose::SaveScene),
        }
    }

    pub(super) fn write_scene(&mut self, path: PathBuf) {
        let scene = self.document.scene.clone();
        let file = self.document.file_number();
        self.messages.news("Saving the scene…");
        self.jobs.start(Lane::SaveScene, move |job| {
            worker::save_scene(job, scene, file, path);
        });
    }

    /// `file`: which of what was opened the scene belongs to.
    pub(super) fn scene_saved(
        &mut self,
        ctx: &egui::Context,
        file: usize,
        path: PathBuf,
        result: Result<Box<Scene>, String>,
    ) {
        match result {
            Ok(scene) => {
                self.messages.withdraw(CANNOT_SAVE);
                self.messages.news(format!("Saved {}", path.display()));
                self.remember(&path);
                self.reloading
                    .watch
                    .accept(&std::path::absolute(&path).unwrap_or_else(|_| path.clone()));
                self.document.set_saved(file, *scene, path);
                if file != self.document.file_number() {
                    return;
                }
                self.forget_stale_scene();
                match self.after_saving.take() {
                    // Edited since it was handed to the writer.
                    Some(intent) if self.document.is_modified() => {
                        self.ask(Dialog::Unsaved(intent));
                    }
                    Some(intent) => self.go_on(ctx, intent),
                    None => {}
                }
            }
            Err(error) => {
                self.after_saving = None;
                self.messages.news("");
                let text = format!("{error}\nThe scene is not saved. Try another folder or name.");
                self.messages.error(CANNOT_SAVE, text);
            }
        }
    }

    pub(super) fn write_picture(&mut self, path: PathBuf) {
        let Some(picture) = self.shown_picture() else {
            return;
        };
        let buffer = Arc::clone(&picture.buffer);
        let mut scene = picture.scene.clone();
        scene.output = self.document.scene.output;
        let (number, is_final) = (picture.number, !picture.is_running());
        let last = picture.errors().last();
        let (is_whole, error) = match picture.outcome {
            Outcome::Opened { error, .. } => (true, error),
            Outcome::Finished { .. } => (true, last.map(|point| (&point.error).into())),
            _ => (false, last.map(|point| (&point.error).into())),
        };
        self.messages.news("Saving the picture…");
        self.jobs.start(Lane::SavePicture, move |job| {
            let result = worker::save_picture(&buffer, &scene, error, &path);
            job.send(Event::PictureSaved {
                path,
                number,
                is_whole,
                is_final,
                result,
            });
        });
    }

    /// A file has all there will be of the picture of render `number`.
    pub(super) fn picture_is_saved(&mut self, number: usize) {
        if let Some(picture) = self.picture_of_mut(number) {
            picture.set_saved();
        }
    }

    /// `is_whole`: whether the picture was finished.
    pub(super) fn picture_saved(
        &mut self,
        path: &Path,
        is_whole: bool,
        result: Result<(), String>,
    ) {
        match result {
            Ok(()) => {
                let what = if is_whole {
                    "Saved"
                } else {
                    "Saved what there is to"
                };
                self.messages.news(format!("{what} {}", path.display()));
            }
            Err(error) => {
                self.messages.news("");
                self.messages.error("Cannot save the picture", error);
            }
        }
    }

    /// Whether closing the window would lose something.
    pub(super) fn holds_up_closing(&self) -> bool {
        self.document.is_modified() || self.question_to_close().is_some()
    }

    /// Asks about unsaved work, then about what runs, then about unsaved pictures, before the window closes.
    pub(super) fn ask_to_close(&mut self) {
        let is_asked = |dialog: &Dialog| {
            matches!(
                dialog,
                Dialog::Unsaved(Intent::Close) | Dialog::Running | Dialog::Pictures
            )
        };
        if self.dialog.as_ref().is_some_and(is_asked) {
            return;
        }
        let question = if self.document.is_modified() {
            Some(Dialog::Unsaved(Intent::Close))
        } else {
            self.question_to_close()
        };
        if let Some(question) = question {
            self.ask_first(question);
        }
    }

    /// What is asked before the window closes, the scene aside.
    fn question_to_close(&self) -> Option<Dialog> {
        if self.running_work().is_some() {
            return Some(Dialog::Running);
        }
        (!self.unsaved_pictures().is_empty()).then_some(Dialog::Pictures)
    }

    /// Names of the renders that took long and are in no file, oldest first.
    pub(super) fn unsaved_pictures(&self) -> Vec<&str> {
        let present = self.picture.as_ref();
        let present = present.filter(|picture| picture.is_unsaved_work());
        let present = present.map(|picture| picture.name.as_str());
        self.renders.unsaved().chain(present).collect()
    }

    /// Closes the window once nobody minds what is lost by that, the scene aside.
    fn close_unless_asked(&mut self, ctx: &egui::Context) {
        match self.question_to_close() {
            Some(question) => self.ask(question),
            None => self.close(ctx),
        }
    }

    /// Asks about what runs, as long as it does.
    pub(super) fn running_ui(&mut self, ctx: &egui::Context) {
        let Some((what, share)) = self.running_work() else {
            return self.close_unless_asked(ctx);
        };
        match question::running_ui(ctx, what, share) {
            // Who gives up what runs does not mind other pictures.
            Some(true) => self.close(ctx),
            Some(false) => {}
            None => self.dialog = Some(Dialog::Running),
        }
    }

    /// Asks about pictures that are in no file.
    pub(super) fn pictures_ui(&mut self, ctx: &egui::Context) {
        let names = self.unsaved_pictures();
        match question::pictures_ui(ctx, &names) {
            Some(true) => self.close(ctx),
            Some(false) => {}
            None => self.dialog = Some(Dialog::Pictures),
        }
    }

    /// What runs that somebody asked for, in a word, and its done part, `0..=1`.
    pub(super) fn running_work(&self) -> Option<(&'static str, f64)> {
        let picture = self.picture.as_ref();
        let picture = picture.filter(|picture| picture.is_running() && !self.is_live);
        let render = picture.map(|picture| ("render", picture.progress.samples.fraction()));
        let report = self.report.run().filter(|_| self.report.is_running());
        render.or_else(|| Some(("report", report?.progress.how_far().0)))
    }

    pub(super) fn close(&mut self, ctx: &egui::Context) {
        self.may_close = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Does what the user decided about unsaved work.
    pub(super) fn decide(&mut self, ctx: &egui::Context, intent: Intent, decision: Decision) {
        match (decision, intent) {
            (Decision::None, intent) => self.dialog = Some(Dialog::Unsaved(intent)),
            (Decision::Cancel, _) => {}
            (Decision::Save, intent) => {
                self.after_saving = Some(intent);
                self.save_scene();
            }
            (Decision::Discard, intent) => self.go_on(ctx, intent),
        }
    }

    /// Goes on with what unsaved work held up.
    fn go_on(&mut self, ctx: &egui::Context, intent: Intent) {
        match intent {
            Intent::Open(paths) => self.load(paths),
            Intent::Import(import) => self.replace_by(*import),
            Intent::Close => self.close_unless_asked(ctx),
        }
    }
}
