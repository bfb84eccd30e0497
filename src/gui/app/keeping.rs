//! Keeping unsaved work and what was opened last on disk, and offering what a window before left behind.
//!
//! Whatever was edited is on disk a second later: it is written at most every half second, by a job, while there is something that
//! is not saved. Restored work is kept where it was found until it is saved, beside what else this window keeps: undoing may lead from one to the
//! other.
//! A render is kept too while it runs, and if it took long until it is saved or the next begins; it goes on when it is restored.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::reloading::absolute;
use super::{App, WaitingRender};
use crate::gui::dialogs::missing::{Lacking, Missing};
use crate::gui::dialogs::recovery::Answer;
use crate::gui::dialogs::{Dialog, Intent};
use crate::gui::document::same_scene;
use crate::gui::event::Event;
use crate::gui::jobs::Lane;
use crate::gui::keeping::{self, About, Begun, Lost, Place, Session};
use crate::gui::picture::{Outcome, Picture};
use crate::gui::recovering::{Hindrance, Interrupted, Recovered, missing_files};
use crate::gui::start::Survivor as _;
use crate::gui::top_bar::View;
use crate::gui::worker;
use crate::scene::Scene;

/// Time between two writes of work that goes on changing.
const INTERVAL: Duration = Duration::from_millis(500);
/// Time until work is written again that could not be.
const RETRY_INTERVAL: Duration = Duration::from_secs(5);

/// The longest that a closing window waits for a render to end, and for what writes it.
const LETTING_GO: Duration = Duration::from_secs(1);

/// What the window keeps on disk.
#[derive(Debug, Default)]
pub struct Keeping {
    /// Where; nothing is kept without.
    data: Option<PathBuf>,
    session: Option<Arc<Session>>,
    /// The scene that is on disk, or was to be.
    kept: Option<Scene>,
    /// Whether writing it failed.
    has_failed: bool,
    /// When it was last handed over.
    started: Option<Instant>,
    /// Lost work that was not asked about yet.
    lost: VecDeque<Lost>,
    /// What else was lost when something was restored, until it is told.
    untold: Vec<String>,
    /// Restored work that is not saved yet, and the number of the file that it is in the document.
    restored: Option<(Lost, usize)>,
    /// Why nothing can be kept, until it is told.
    fault: Option<String>,
    /// The files opened or saved last, newest first.
    pub(super) recent: Vec<PathBuf>,
}

impl Keeping {
    /// The session, where there is one.
    pub(super) fn session(&self) -> Option<&Arc<Session>> {
        self.session.as_ref()
    }
}

impl App {
    /// Begins to keep work in `data`, and looks for what was lost.
    pub(super) fn begin_keeping(&mut self, data: Option<PathBuf>) {
        self.keeping.data.clone_from(&data);
        let Some(data) = data else { return };
        self.jobs.start(Lane::Begin, move |job| {
            let recent = keeping::load_recent(&data);
            let begun = keeping::begin(&data)
                .map(Box::new)
                .map_err(|error| format!("{}: {error}", data.display()));
            job.send(Event::KeepingBegun { recent, begun });
        });
    }

    pub(super) fn keeping_begun(
        &mut self,
        recent: Vec<PathBuf>,
        begun: Result<Box<Begun>, String>,
    ) {
        self.keeping.recent = recent;
        match begun {
            Ok(begun) => {
                self.keeping.session = Some(Arc::new(begun.session));
                self.keeping.lost = begun.lost.into();
            }
            Err(error) => self.keeping.fault = Some(error),
        }
    }

    /// Removes what was kept, as the window closes, where the user has decided about it. Where the desktop ends the program, as some do when their
    /// session ends, nobody was asked: then all is left for the next start.
    pub(super) fn end_keeping(&mut self) {
        if !self.may_close && self.holds_up_closing() {
            return self.give_up();
        }
        // What was to be gone on with, and is not yet, is offered again.
        self.waiting_render = None;
        (self.dialog, self.after_saving) = (None, None);
        self.asked_later.clear();
        self.jobs.cancel(Lane::Load);
        while self.jobs.next_event().is_some() {}
        self.stop_rendering();
        if let Some(picture) = &self.picture {
            picture.leave_kept();
        }
        if let Some(session) = self.keeping.session.take() {
            session.end();
        }
        // What was undone was not decided about.
        let file = self.document.file_number();
        let restored = self.keeping.restored.take();
        if let Some((lost, _)) = restored.filter(|(_, restored)| *restored == file) {
            lost.clear();
        }
    }

    /// Has the render let go of its files: on some systems what is open can neither be moved nor removed.
    fn stop_rendering(&mut self) {
        self.jobs.cancel(Lane::Render);
        if let Some(picture) = &self.picture {
            picture.throttle().allow(usize::MAX);
            picture.stop_keeping();
        }
        self.renders.stop_keeping();
        let is_held =
            |app: &Self| app.jobs.running_threads(Lane::Render) > 0 || app.is_keeping_render();
        let end = Instant::now() + LETTING_GO;
        while is_held(self) && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Where unsaved work is kept, if it is.
    fn place_of_work(&self) -> Option<Place> {
        let session = self.keeping.session.as_ref()?;
        let restored = self.keeping.restored.as_ref();
        let restored = restored.filter(|(_, file)| *file == self.document.file_number());
        Some(match restored {
            Some((lost, _)) => Place::Found(lost.clone()),
            None => Place::Session(Arc::clone(session)),
        })
    }

    /// Where the window keeps what outlives it; `None` where it keeps nothing.
    pub(super) fn keeping_folder(&self) -> Option<PathBuf> {
        self.keeping.data.clone()
    }

    fn not_kept(&mut self, error: &str) {
        let text = format!(
            "{error}\nWere the program to end now, what you have not saved would be lost: save often."
        );
        self.messages.warning("Unsaved work is not kept", text);
    }

    /// Has unsaved work written where it changed since the last time, and removed where it is saved.
    pub(super) fn keep_work(&mut self, ctx: &egui::Context) {
        if self.jobs.is_busy(Lane::Keep) {
            return;
        }
        let Some(place) = self.place_of_work() else {
            return;
        };
        let document = &self.document;
        if !document.is_modified() {
            let is_found = matches!(place, Place::Found(_));
            if self.keeping.kept.take().is_some() || is_found {
                self.keeping.has_failed = false;
                self.keeping.restored.take_if(|_| is_found);
                self.jobs.start(Lane::Keep, move |_| place.clear());
            }
            return;
        }
        let has_failed = self.keeping.has_failed;
        let kept = self.keeping.kept.as_ref();
        if !has_failed && kept.is_some_and(|kept| same_scene(kept, &document.scene)) {
            return;
        }
        let interval = if has_failed { RETRY_INTERVAL } else { INTERVAL };
        let since = self.keeping.started.map(|started| started.elapsed());
        if let Some(rest) = since.and_then(|since| interval.checked_sub(since)) {
            ctx.request_repaint_after(rest);
            return;
        }
        let scene = document.scene.clone();
        self.keeping.kept = Some(scene.clone());
        self.keeping.started = Some(Instant::now());
        let about = About {
            name: document.name().to_owned(),
            path: document.path().map(Path::to_owned),
        };
        self.jobs.start(Lane::Keep, move |job| {
            job.send(Event::WorkKept(place.keep(&scene, &about)));
        });
    }

    /// [`Self::keep_work`], however short a time ago the last write was.
    pub(super) fn keep_work_at_once(&mut self, ctx: &egui::Context) {
        self.keeping.started = None;
        self.keep_work(ctx);
    }

    pub(super) fn work_kept(&mut self, result: Result<(), String>) {
        let had_failed = std::mem::replace(&mut self.keeping.has_failed, result.is_err());
        match result {
            // It is tried again and again, and told once.
            Err(error) if !had_failed => self.not_kept(&error),
            _ => {}
        }
    }

    /// The job that writes unsaved work, or removes it, ended by a fault of the program: what was to be on disk is written again.
    pub(super) fn keep_failed(&mut self) {
        self.keeping.has_failed = self.keeping.kept.is_some();
    }

    /// Whether unsaved work is kept on disk, as soon as there is some.
    #[must_use]
    pub fn is_keeping(&self) -> bool {
        self.keeping.session.is_some()
    }

    /// Whether all that is not saved is on disk.
    #[must_use]
    pub fn is_work_kept(&self) -> bool {
        let kept = self.keeping.kept.as_ref();
        let is_newest = kept.is_some_and(|kept| same_scene(kept, &self.document.scene));
        is_newest == self.document.is_modified()
            && !self.keeping.has_failed
            && !self.jobs.is_busy(Lane::Keep)
    }

    /// Whether a thread takes a render to disk: one that runs, or has ended and is not there as a whole yet.
    #[must_use]
    pub fn is_keeping_render(&self) -> bool {
        let session = self.keeping.session();
        session.is_some_and(|session| session.has_writers())
    }

    /// Asks about lost work, once what was opened is there; and tells why nothing can be kept.
    pub(super) fn ask_about_lost_work(&mut self) {
        if self.loading.is_some() {
            return;
        }
        if let Some(fault) = self.keeping.fault.take() {
            self.not_kept(&fault);
        }
        // What a file lacks may be of no interest once its lost work is back.
        let may_wait = |dialog: &Dialog| match dialog {
            Dialog::Missing(missing) => missing.is_untouched(),
            _ => false,
        };
        if self.dialog.as_ref().is_none_or(may_wait)
            && let Some(lost) = self.keeping.lost.pop_front()
        {
            self.ask_first(Dialog::Recovery(lost));
        }
    }

    /// Does what the user decided about lost work.
    pub(super) fn decide_about_lost_work(&mut self, lost: Lost, answer: Answer) {
        match answer {
            Answer::None => self.dialog = Some(Dialog::Recovery(lost)),
            // Other work would take the place of what is restored now: it is offered at the next start.
            Answer::Later => self.keeping.lost.clear(),
            Answer::Restore => {
                let others = self.keeping.lost.drain(..);
                let mut names: Vec<String> = others.map(|other| other.about.name).collect();
                names.dedup();
                self.keeping.untold = names;
                self.forget_questions_about(&lost);
                self.restore(lost);
            }
            Answer::Discard => {
                self.jobs.start(Lane::Discard, move |_| lost.discard());
            }
        }
    }

    /// Does not ask any more what the file lacks whose `lost` work takes its place.
    fn forget_questions_about(&mut self, lost: &Lost) {
        let file = lost.about.path.as_deref().map(absolute);
        self.asked_later.retain(|dialog| match dialog {
            Dialog::Missing(Missing {
                of: Lacking::File(path),
                ..
            }) => Some(absolute(path)) != file,
            _ => true,
        });
    }

    /// Says what else was lost, and is not asked about now.
    fn tell_of_other_lost_work(&mut self) {
        let names = std::mem::take(&mut self.keeping.untold);
        if !names.is_empty() {
            let text = format!(
                "What was not saved of {} is offered again at the next start.",
                names.join(", ")
            );
            self.messages.warning("Other lost work waits", text);
        }
    }

    /// Reads lost work. Where it lacks files, it is asked about those first.
    fn restore(&mut self, lost: Lost) {
        let progress = self.begin_loading(lost.about.name.clone());
        let session = self.keeping.session.clone();
        self.jobs.start(Lane::Load, move |job| {
            let files = missing_files(&lost, &job.cancel);
            let missing = Missing::new(Lacking::Work(lost.clone()), files);
            if missing.files.is_empty() {
                worker::restore(job, lost, missing, session.as_ref(), &progress);
            } else {
                job.send(Event::FilesMissing(missing));
            }
        });
    }

    /// Reads lost work with what was found of its missing files, and without the rest.
    pub(super) fn restore_without_missing(&mut self, lost: Lost, missing: Missing) {
        let progress = self.begin_loading(lost.about.name.clone());
        let session = self.keeping.session.clone();
        self.jobs.start(Lane::Load, move |job| {
            worker::restore(job, lost, missing, session.as_ref(), &progress);
        });
    }

    /// Lost work was read. What was edited meanwhile is asked about, as before another scene is opened.
    pub(super) fn restored(&mut self, lost: Lost, result: Result<Box<Recovered>, String>) {
        self.loading = None;
        match result {
            Ok(recovered) if self.document.is_modified() => {
                self.ask(Dialog::Unsaved(Intent::Restore(lost, recovered)));
            }
            Ok(recovered) => self.put_restored(lost, *recovered),
            Err(error) => {
                let folder = lost.folder().display();
                let text = format!(
                    "{error}\nThe work stays in {folder}, and is offered again at the next start."
                );
                self.messages.error("Cannot restore the unsaved work", text);
                self.tell_of_other_lost_work();
            }
        }
    }

    /// Puts lost work in place of the scene, and goes on with its render.
    pub(super) fn put_restored(&mut self, mut lost: Lost, recovered: Recovered) {
        let Recovered {
            scene,
            moved,
            saved,
            render,
            warnings,
        } = recovered;
        let About { name, path } = lost.about.clone();
        let is_saved = saved.is_none();
        let title = format!("Restored {name} with remarks");
        let before = self.open_document(scene, name, path, saved);
        // What was told before went with the scene that was there.
        self.tell_of_other_lost_work();
        if !warnings.is_empty() {
            self.messages.warning(title, warnings.join("\n"));
        }
        if matches!(render, Some(Err(Hindrance::Lost(_)))) {
            lost.give_up_render();
        }
        if is_saved {
            self.jobs.start(Lane::Discard, move |_| lost.clear());
        } else {
            self.keeping.restored = Some((lost, self.document.file_number()));
            let undo = before.map_or_else(String::new, |it| format!(". Undo brings {it} back"));
            let news = format!("Restored what was not saved{undo}");
            self.messages.news(news);
        }
        self.take_moved(moved);
        match render {
            Some(Ok(interrupted)) => self.go_on_with(interrupted),
            Some(Err(Hindrance::Lost(reason))) => self.tell_lost_render(&reason),
            Some(Err(Hindrance::Waits(reason))) => self.tell_waiting_render(&reason),
            None => {}
        }
    }

    /// Goes on with a render that was interrupted, as soon as its scene is prepared.
    fn go_on_with(&mut self, interrupted: Interrupted) {
        if self.picture.as_ref().is_some_and(Picture::is_running) {
            // One that nobody goes on with stays on disk.
            drop(interrupted);
            return self.tell_waiting_render("Another one runs");
        }
        self.is_live = false;
        self.waiting_render = Some(WaitingRender {
            interrupted: Some(interrupted),
            ..WaitingRender::new()
        });
    }

    pub(super) fn render_goes_on(&mut self, share_done: f64, seconds: f64) {
        if let Some(picture) = &mut self.picture {
            let time = Duration::try_from_secs_f64(seconds).unwrap_or_default();
            picture.go_on_after(time, share_done);
        }
    }

    /// What is left of an interrupted render is of no use.
    pub(super) fn render_lost(&mut self, reason: &str) {
        self.end_picture(Outcome::Failed);
        self.view = View::Preview;
        self.tell_lost_render(reason);
    }

    fn tell_lost_render(&mut self, reason: &str) {
        let text = format!("{reason}.\nThe scene is here: Render begins anew.");
        let title = "The interrupted render cannot go on";
        self.messages.warning(title, text);
    }

    fn tell_waiting_render(&mut self, reason: &str) {
        let text = format!("{reason}. It is offered again at the next start.");
        self.messages.warning("The interrupted render waits", text);
    }

    pub(super) fn render_not_kept(&mut self, reason: &str) {
        let text = format!(
            "{reason}\nThe render goes on. Were the program to end before it is done, it would begin anew."
        );
        self.messages
            .warning("The running render is not kept on disk", text);
    }

    /// Takes note that `path` was opened or saved.
    pub(super) fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.change_recent(Some(path));
    }

    /// Empties the list of files opened last.
    pub(super) fn forget_recent(&mut self) {
        self.change_recent(None);
    }

    fn change_recent(&mut self, newest: Option<PathBuf>) {
        let Some(data) = self.keeping.data.clone() else {
            return;
        };
        self.jobs.start(Lane::Recent, move |job| {
            // A list that cannot be written is no loss to stop anybody for.
            if let Ok(recent) = keeping::save_recent(&data, newest.as_deref()) {
                job.send(Event::RecentChanged(recent));
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::gui::app::testing;

    /// What is on disk of a render may take seconds to read.
    #[test]
    fn how_far_an_interrupted_render_is_read_is_told_until_it_goes_on() {
        let mut window = testing::window(None);
        let app = window.state_mut();
        let picture = testing::picture(app);
        picture.reading.set_total(1000);
        picture.reading.advance(420);
        app.picture = Some(picture);
        window.run_steps(2);
        let told = "Reading what was rendered before";
        assert!(window.query_by_label_contains(told).is_some());
        assert!(window.query_by_label("42 %").is_some());
        window.state_mut().render_goes_on(0.25, 9.0);
        window.run_steps(2);
        assert!(window.query_by_label_contains(told).is_none());
        let goes_on = "interrupted at 25 %, goes on";
        assert!(window.query_by_label_contains(goes_on).is_some());
        // Nobody renders it.
        window.state_mut().picture = None;
    }

    #[test]
    fn work_is_written_again_after_a_fault_of_the_program() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut window = testing::window(Some(folder.path().to_owned()));
        testing::until(&mut window, |app| app.keeping.session.is_some());
        let ctx = window.ctx.clone();
        let app = window.state_mut();
        app.document.scene.camera.eye.x += 1.0;
        // What hands the work over, with a job that fails.
        app.keeping.kept = Some(app.document.scene.clone());
        app.jobs.start(Lane::Keep, |_| panic!("as the test wants"));
        let deadline = Instant::now() + Duration::from_mins(1);
        let wait = |app: &mut App, holds: fn(&App) -> bool| {
            while !holds(app) {
                assert!(Instant::now() < deadline, "waited in vain");
                app.take_news(&ctx);
                std::thread::sleep(Duration::from_millis(2));
            }
        };
        wait(app, |app| !app.works_in(Lane::Keep));
        assert!(!app.is_work_kept(), "it is not on disk");
        app.keep_work_at_once(&ctx);
        wait(app, App::is_work_kept);
    }
}
