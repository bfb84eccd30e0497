//! Scenes and pictures to files, and what waits for unsaved work.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::App;
use super::opening::what;
use super::reloading::absolute;
use crate::control::CancelToken;
use crate::gui::commands::Stoppable;
use crate::gui::dialogs::files::FilePurpose;
use crate::gui::dialogs::question::{self, Decision};
use crate::gui::dialogs::{Dialog, Intent};
use crate::gui::event::Event;
use crate::gui::jobs::Lane;
use crate::gui::picture::{Outcome, Picture};
use crate::gui::picture_buffer::PictureId;
use crate::gui::worker;
use crate::io::{Origin, Values};
use crate::scene::Scene;

/// What a banner says until the scene is saved.
const CANNOT_SAVE: &str = "Cannot save the scene";

/// A picture that is being written, or waits for one to be written before it.
#[derive(Debug)]
pub(super) struct PictureSave {
    path: PathBuf,
    /// Not that of its job, which also says that the window closes: a picture is written all the same.
    cancel: CancelToken,
}

/// What runs that somebody asked for, and ends with the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunningWork {
    pub what: Stoppable,
    /// The done part, `0..=1`, where it is known.
    pub share: Option<f64>,
}

impl App {
    /// Writes the scene to its file, or asks for one; it is asked, too, where that is not what was last read from it or written to it.
    pub(super) fn save_scene(&mut self) {
        match self.document.path().map(Path::to_owned) {
            Some(path) => self.write_scene(path, false),
            None => self.ask_for_path(FilePurpose::SaveScene),
        }
    }

    /// Writes the scene to `path`; `is_sure`: whatever is there.
    pub(super) fn write_scene(&mut self, path: PathBuf, is_sure: bool) {
        let scene = self.document.scene.clone();
        let file = self.document.file_number();
        self.messages.news("Saving the scene…");
        self.scene_saves.push_back(scene.clone());
        // What is written before this one may be there, too, and this one itself would lose nothing.
        let known = self.scene_saves.iter().chain([self.document.saved()]);
        let known: Option<Vec<Scene>> = (!is_sure).then(|| known.cloned().collect());
        self.jobs.start(Lane::SaveScene, move |job| {
            worker::save_scene(job, scene, file, path, known.as_deref());
        });
    }

    /// `file`: which of what was opened the scene belongs to. What waits for the scene to be saved waits for the last of several files.
    pub(super) fn scene_saved(
        &mut self,
        ctx: &egui::Context,
        file: usize,
        path: PathBuf,
        result: Result<Option<Box<Scene>>, String>,
    ) {
        self.scene_saves.pop_front();
        let is_last = self.scene_saves.is_empty();
        let result = match result {
            Ok(None) if file == self.document.file_number() => {
                self.messages.news("");
                return self.ask_to_overwrite_scene(path);
            }
            Ok(None) => Err(format!("another program has written to {}", path.display())),
            Ok(Some(scene)) => Ok(scene),
            Err(error) => Err(error),
        };
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
                match self.after_saving.take_if(|_| is_last) {
                    // Edited since it was handed to the writer.
                    Some(intent) if self.document.is_modified() => {
                        self.ask(Dialog::Unsaved(intent));
                    }
                    Some(intent) => self.go_on(ctx, intent),
                    None => {}
                }
            }
            Err(error) => {
                self.after_saving.take_if(|_| is_last);
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
        let mut scene = picture.scene_to_repeat();
        scene.output = self.document.scene.output;
        let is_final = !picture.is_running();
        let last = picture.errors().last();
        let measured = last.map(|point| (&point.error).into());
        let (is_whole, error) = match picture.outcome {
            Outcome::Opened { error, .. } => (true, error),
            Outcome::Finished { .. } => (true, measured),
            _ => (false, measured),
        };
        let rounded = match &picture.outcome {
            Outcome::Opened {
                hash: None,
                hash_before,
                ..
            } => Some(hash_before.clone()),
            _ => None,
        };
        self.messages.news("");
        let cancel = CancelToken::new();
        self.picture_saves.push_back(PictureSave {
            path: path.clone(),
            cancel: cancel.clone(),
        });
        self.jobs.start(Lane::SavePicture, move |job| {
            let rounded = rounded.as_ref();
            let origin = Origin {
                scene: &scene,
                error,
                region: buffer.part().region(),
                values: rounded.map_or(Values::Rendered, |hash| Values::Rounded(hash.as_deref())),
            };
            let result = worker::save_picture(&buffer, &origin, &path, &cancel);
            job.send(Event::PictureSaved {
                path,
                picture: buffer.id(),
                is_whole,
                is_final,
                result,
            });
        });
    }

    /// A file has what there will be of the picture `id`; `is_all`: with its light and its layers.
    pub(super) fn picture_is_saved(&mut self, id: PictureId, is_all: bool) {
        let present = self.picture.as_mut();
        let present = present.filter(|picture| picture.buffer.id() == id);
        if let Some(picture) = present.or_else(|| self.renders.with_id_mut(id)) {
            picture.set_saved(is_all);
        }
    }

    /// `is_whole`: whether the picture was finished.
    pub(super) fn picture_saved(
        &mut self,
        path: &Path,
        is_whole: bool,
        result: Result<Option<()>, String>,
    ) {
        self.picture_saves.pop_front();
        match result {
            Ok(None) => self.messages.news("Saving cancelled"),
            Ok(Some(())) => {
                let what = if is_whole {
                    "Saved"
                } else {
                    "Saved what there is to"
                };
                self.messages.news(format!("{what} {}", path.display()));
            }
            Err(error) => {
                self.stay_open();
                self.messages.news("");
                self.messages.error("Cannot save the picture", error);
            }
        }
    }

    /// The job that writes a picture ended by a fault of the program.
    pub(super) fn picture_save_failed(&mut self) {
        self.picture_saves.pop_front();
        self.stay_open();
    }

    /// Whether a picture is being written.
    pub(super) fn is_saving_picture(&self) -> bool {
        !self.picture_saves.is_empty()
    }

    /// Which pictures are being written, in words; `None` where none are.
    pub(super) fn pictures_being_saved(&self) -> Option<String> {
        let saves = self.picture_saves.iter();
        let paths: Vec<PathBuf> = saves.map(|save| save.path.clone()).collect();
        (!paths.is_empty()).then(|| what(&paths))
    }

    /// Has no picture written that is not whole by now. Each of them tells when it has ended.
    pub(super) fn cancel_saving(&mut self) {
        for save in &self.picture_saves {
            save.cancel.cancel();
        }
    }

    /// Does not close the window as soon as nothing runs any more: there is something to be read in it.
    fn stay_open(&mut self) {
        self.after_saving
            .take_if(|intent| matches!(intent, Intent::Close));
        let is_other = |dialog: &Dialog| !matches!(dialog, Dialog::Running);
        self.dialog.take_if(|dialog| !is_other(dialog));
        self.asked_later.retain(is_other);
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
        let Some(RunningWork { what, share }) = self.running_work() else {
            return self.close_unless_asked(ctx);
        };
        match question::running_ui(ctx, what, share) {
            Some(true) => self.give_up_and_close(ctx, what),
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

    /// What runs that somebody asked for, the first where it is several things.
    pub(super) fn running_work(&self) -> Option<RunningWork> {
        let picture = self.picture.as_ref();
        // One that follows every change is asked about when it has taken long over the last.
        let is_asked_for = |picture: &&Picture| !self.is_live || picture.is_long();
        let picture = picture.filter(|picture| picture.is_running() && is_asked_for(picture));
        let render = picture.map(|picture| RunningWork {
            what: Stoppable::Render,
            share: Some(picture.progress.share()),
        });
        let report = self.report.run().filter(|_| self.report.is_running());
        let report = report.map(|run| RunningWork {
            what: Stoppable::Report,
            share: Some(run.progress.how_far().0),
        });
        let saving = self.is_saving_picture().then_some(RunningWork {
            what: Stoppable::Saving,
            share: None,
        });
        render.or(report).or(saving)
    }

    /// Gives `what` up so that the window can close, which it does unless something else runs that is to be asked about.
    pub(super) fn give_up_and_close(&mut self, ctx: &egui::Context, what: Stoppable) {
        self.stop(what);
        let is_given_up =
            |picture: &Picture| what == Stoppable::Render && picture.is_unsaved_work();
        let given_up = usize::from(self.picture.as_ref().is_some_and(is_given_up));
        match self.running_work() {
            // It ends as soon as its job takes notice, with the window or before.
            Some(next) if next.what != what => self.ask(Dialog::Running),
            _ if self.unsaved_pictures().len() > given_up => self.ask(Dialog::Pictures),
            _ => self.close(ctx),
        }
    }

    pub(super) fn close(&mut self, ctx: &egui::Context) {
        self.may_close = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Does what the user decided about unsaved work.
    pub(super) fn decide(&mut self, ctx: &egui::Context, intent: Intent, decision: Decision) {
        match (decision, intent) {
            (Decision::None, intent) => self.dialog = Some(Dialog::Unsaved(intent)),
            (Decision::Cancel, Intent::Restore(lost, _)) => {
                let name = &lost.about.name;
                let news =
                    format!("What was restored of {name} is offered again at the next start");
                self.messages.news(news);
            }
            (Decision::Cancel, _) => {}
            (Decision::Save, intent) => {
                self.after_saving = Some(intent);
                self.save_scene();
            }
            (Decision::Discard, intent) => self.go_on(ctx, intent),
        }
    }

    /// Whether `path` is the scene's own file, and holds it as it is.
    fn is_just_saved(&self, path: &Path) -> bool {
        !self.document.is_modified() && self.is_own(&absolute(path))
    }

    /// Goes on with what unsaved work held up.
    fn go_on(&mut self, ctx: &egui::Context, intent: Intent) {
        match intent {
            // Saved just now, it is not what was read.
            Intent::Open(opened) if opened.paths.iter().any(|path| self.is_just_saved(path)) => {
                self.load(opened.paths);
            }
            Intent::Open(opened) => self.put_opened(*opened),
            Intent::Import(import) => self.replace_by(*import),
            Intent::Restore(lost, recovered) => self.put_restored(lost, *recovered),
            Intent::Close => self.close_unless_asked(ctx),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::app::testing;

    /// The window closes when what runs has ended, unless there is something to be read in it.
    #[test]
    fn a_picture_that_cannot_be_saved_keeps_the_window_open() {
        let mut window = testing::window(None);
        let app = window.state_mut();
        app.picture_saves.push_back(PictureSave {
            path: PathBuf::from("full/a.png"),
            cancel: CancelToken::new(),
        });
        assert_eq!(app.pictures_being_saved().as_deref(), Some("a.png"));
        app.ask_to_close();
        assert!(matches!(app.dialog, Some(Dialog::Running)));
        let failure = Err("the disk is full".to_owned());
        app.picture_saved(Path::new("full/a.png"), true, failure);
        window.run_steps(2);
        let app = window.state();
        assert!(app.dialog.is_none() && !app.may_close);
        assert_eq!(app.messages().banners()[0].text, "the disk is full");
        assert!(app.running_work().is_none());
    }

    /// What waits for the scene to be saved does not go on when only an older file is written.
    #[test]
    fn what_waits_for_several_files_waits_for_the_last() {
        let mut window = testing::window(None);
        let ctx = window.ctx.clone();
        let app = window.state_mut();
        let (scene, file) = (app.document.scene.clone(), app.document.file_number());
        app.scene_saves = [scene.clone(), scene.clone()].into();
        app.after_saving = Some(Intent::Close);
        let failure = Err("the disk is full".to_owned());
        app.scene_saved(&ctx, file, PathBuf::from("a.toml"), failure);
        assert_eq!(app.messages().banners()[0].title, CANNOT_SAVE);
        assert!(app.after_saving.is_some() && !app.may_close);
        app.scene_saved(
            &ctx,
            file,
            PathBuf::from("b.toml"),
            Ok(Some(Box::new(scene))),
        );
        assert!(app.may_close);
    }
}
