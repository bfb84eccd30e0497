//! The report in the window: what to measure, how far it is, and what came out. It floats over the rest, which stays usable.
//!
//! - `form`: what the user wants measured, in the words of [`crate::analysis::report::ReportOptions`]
//! - `findings`: what is known, as a chart and figures
//!
//! A report measures times, so nothing else of this program's may render meanwhile: a running render is stopped before it begins,
//! and none can be started until it ends.

mod chart;
mod findings;
mod form;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::{Align2, RichText, ScrollArea, Ui};

pub use findings::Findings;
use form::Form;

use super::dialogs::{buttons_ui, files::FilePurpose};
use super::picture::time_left;
use super::status_bar::{duration, progress_ui};
use super::widgets::primary_button;
use crate::analysis::report::{REPORT_FILES, ReportError, ReportOptions, ReportProgress};
use crate::scene::Scene;

/// Widths of the form and of what came out, in points.
const FORM_WIDTH: f32 = 500.0;
/// See [`FORM_WIDTH`].
const FINDINGS_WIDTH: f32 = 860.0;
/// Height that the window's frame and the bars need, in points.
const FRAME_HEIGHT: f32 = 150.0;

/// What the user asks for in the window of the report.
#[derive(Debug)]
pub enum Asked {
    /// Measure this, and write it to the folder.
    Start {
        /// The folder.
        folder: PathBuf,
        /// What to measure.
        options: ReportOptions,
    },
    /// Choose a path for this.
    Path(FilePurpose),
    /// Stop measuring.
    Cancel,
    /// Show the folder as the desktop does.
    ShowFolder(PathBuf),
}

/// The scene that a report would be of.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// As the window shows it.
    pub scene: &'a Scene,
    /// What people call it.
    pub name: &'a str,
    /// Whether it has changed since it was saved.
    pub is_modified: bool,
    /// Whether a render is going on.
    pub is_rendering: bool,
}

/// The window of the report.
#[derive(Debug, Default)]
pub struct ReportWindow {
    /// Whether it shows.
    pub open: bool,
    form: Form,
    run: Option<Run>,
}

/// A report that is being made or has been.
#[derive(Debug)]
pub struct Run {
    /// Where its files are.
    pub folder: PathBuf,
    /// How far it is.
    pub progress: ReportProgress,
    /// What came of it.
    pub outcome: Outcome,
    started: Instant,
    findings: Option<Box<Findings>>,
    /// Why the desktop did not open the folder.
    folder_problem: Option<String>,
}

/// What came of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing yet.
    Running,
    /// All was measured.
    Finished,
    /// The user stopped it.
    Cancelled,
    /// It could not go on, for this reason.
    Failed(String),
}

impl Run {
    /// Time since it began.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// What is known by now.
    #[must_use]
    pub fn findings(&self) -> Option<&Findings> {
        self.findings.as_deref()
    }

    /// What is being rendered, and the time left where that is known.
    #[must_use]
    pub fn describe(&self) -> String {
        let (share, mut what) = self.progress.how_far();
        if what.is_empty() {
            "preparing".clone_into(&mut what);
        }
        match time_left(share, self.elapsed()) {
            Some(left) => format!("{what}  ·  {} left", duration(left)),
            None => what,
        }
    }
}

impl ReportWindow {
    /// Shows the window; where no folder is named yet, `folder` is offered.
    pub fn show(&mut self, folder: &Path) {
        self.open = true;
        self.form.suggest(folder);
    }

    /// The folder that is named in the form.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.form.folder()
    }

    /// Takes the path that was chosen for `purpose`.
    pub fn set_path(&mut self, purpose: FilePurpose, path: &Path) {
        self.form.set_path(purpose, path);
    }

    /// The report that is being made or was made last; `None` while the next one is described.
    #[must_use]
    pub fn run(&self) -> Option<&Run> {
        self.run.as_ref()
    }

    /// Whether a report is being made.
    #[must_use]
    pub fn is_running(&self) -> bool {
        let outcome = self.run.as_ref().map(|run| &run.outcome);
        outcome == Some(&Outcome::Running)
    }

    /// Shows that a report is being made from now on; returns where its progress goes.
    pub fn begin(&mut self, folder: PathBuf) -> ReportProgress {
        let progress = ReportProgress::default();
        self.form.problem = None;
        self.run = Some(Run {
            folder,
            progress: progress.clone(),
            outcome: Outcome::Running,
            started: Instant::now(),
            findings: None,
            folder_problem: None,
        });
        progress
    }

    /// Shows what is known after another render.
    pub fn set_findings(&mut self, findings: Box<Findings>) {
        if let Some(run) = &mut self.run {
            run.findings = Some(findings);
        }
    }

    /// Says why the desktop did not open the folder.
    pub fn folder_not_shown(&mut self, reason: &str) {
        if let Some(run) = &mut self.run {
            run.folder_problem = Some(format!("The desktop does not open it: {reason}"));
        }
    }

    /// The report is whole.
    pub fn finish(&mut self) {
        self.end(Outcome::Finished);
    }

    /// The report was stopped. Where nothing is known yet, the form shows again.
    pub fn cancel(&mut self) {
        self.end(Outcome::Cancelled);
    }

    /// The report cannot go on. Where nothing is known yet, the form shows again, with the reason at its place.
    pub fn fail(&mut self, error: &ReportError) {
        self.form.problem = Some(form::Problem::of(error));
        self.end(Outcome::Failed(error.to_string()));
    }

    /// [`Self::fail`] by a fault of the program.
    pub fn fail_by_fault(&mut self) {
        self.end(Outcome::Failed("a fault of the program".to_owned()));
    }

    fn end(&mut self, outcome: Outcome) {
        let is_news = outcome != Outcome::Cancelled;
        self.run = self.run.take().filter(|run| run.findings.is_some());
        if let Some(run) = &mut self.run {
            run.outcome = outcome;
        }
        // What came out, or why nothing did, is what the user waits for.
        self.open |= self.run.is_some() || is_news;
    }

    /// Draws the window, where it shows.
    pub fn window_ui(&mut self, ctx: &egui::Context, subject: Subject<'_>) -> Option<Asked> {
        if !self.open {
            return None;
        }
        let mut stays_open = true;
        let mut asked = None;
        let room = ctx.content_rect();
        let style = ctx.global_style();
        // The ground of the side panel, on which fields are seen in both themes.
        let frame = egui::Frame::window(&style).fill(style.visuals.panel_fill);
        egui::Window::new("Report: error against run time")
            .frame(frame)
            .id(layer().id)
            .open(&mut stays_open)
            .collapsible(false)
            .auto_sized()
            .pivot(Align2::CENTER_CENTER)
            .default_pos(room.center())
            .show(ctx, |ui| {
                let has_findings = self.run.as_ref().is_some_and(|run| run.findings.is_some());
                let width = if has_findings {
                    FINDINGS_WIDTH
                } else {
                    FORM_WIDTH
                };
                ui.set_width(width.min(room.width() - 60.0));
                asked = match &self.run {
                    None => self.form_ui(ui, subject),
                    Some(_) => self.run_ui(ui),
                };
            });
        self.open &= stays_open;
        asked
    }

    fn form_ui(&mut self, ui: &mut Ui, subject: Subject<'_>) -> Option<Asked> {
        let wanted = scrolled_ui(ui, |ui| self.form.form_ui(ui, subject));
        let asked = self.form_buttons_ui(ui);
        asked.or(wanted.map(Asked::Path))
    }

    fn form_buttons_ui(&mut self, ui: &mut Ui) -> Option<Asked> {
        buttons_ui(ui, |ui| {
            let start = ui
                .add_enabled(self.form.has_folder(), primary_button("Start"))
                .on_disabled_hover_text("Name the folder to write to");
            if ui.button("Close").clicked() {
                self.open = false;
            }
            if !start.clicked() {
                return None;
            }
            match self.form.options() {
                Ok(options) => Some(Asked::Start {
                    folder: self.form.folder(),
                    options,
                }),
                Err(problem) => {
                    self.form.problem = Some(problem);
                    None
                }
            }
        })
    }

    fn run_ui(&mut self, ui: &mut Ui) -> Option<Asked> {
        let run = self.run.as_ref()?;
        if run.outcome == Outcome::Running {
            running_ui(ui, run);
        } else {
            ended_ui(ui, &run.outcome);
        }
        if let Some(findings) = &run.findings {
            ui.add_space(6.0);
            scrolled_ui(ui, |ui| findings.findings_ui(ui));
            ui.add_space(6.0);
            files_ui(ui, run);
        }
        let has_ended = run.outcome != Outcome::Running;
        let folder = run.folder.clone();
        buttons_ui(ui, |ui| {
            if !has_ended {
                let cancel = ui.button("Cancel report");
                if ui
                    .button("Hide")
                    .on_hover_text("The report goes on; the bar below tells how far it is")
                    .clicked()
                {
                    self.open = false;
                }
                return cancel.clicked().then_some(Asked::Cancel);
            }
            if ui.button("Close").clicked() {
                self.open = false;
            }
            if ui
                .button("New report")
                .on_hover_text("Go back to what is to be measured")
                .clicked()
            {
                self.run = None;
            }
            let show = ui
                .button("Open folder")
                .on_hover_text("Show the files as the desktop does");
            show.clicked().then_some(Asked::ShowFolder(folder))
        })
    }
}

/// Where the window of the report is drawn.
#[must_use]
pub fn layer() -> egui::LayerId {
    egui::LayerId::new(egui::Order::Middle, egui::Id::unique("report"))
}

/// What does not fit into the height is scrolled to.
fn scrolled_ui<R>(ui: &mut Ui, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let height = (ui.ctx().content_rect().height() - FRAME_HEIGHT).max(160.0);
    ScrollArea::vertical()
        .max_height(height)
        .auto_shrink([false, true])
        .show(ui, contents)
        .inner
}

fn running_ui(ui: &mut Ui, run: &Run) {
    ui.horizontal(|ui| {
        progress_ui(ui, run.progress.how_far().0);
        ui.add(egui::Label::new(run.describe()).truncate());
    });
    ui.label(
        RichText::new(
            "The bar counts samples. What this machine does meanwhile is in the times, looking around in this window too: \
             leave it alone where they matter.",
        )
        .weak(),
    );
}

fn ended_ui(ui: &mut Ui, outcome: &Outcome) {
    let warn = ui.visuals().warn_fg_color;
    match outcome {
        Outcome::Running | Outcome::Finished => {}
        Outcome::Cancelled => {
            let text = "Cancelled: this is what was measured until then.";
            ui.label(RichText::new(text).color(warn));
        }
        Outcome::Failed(reason) => {
            let text = format!("It could not go on: {reason}");
            ui.label(RichText::new(text).color(ui.visuals().error_fg_color));
        }
    }
}

/// Where the files are.
fn files_ui(ui: &mut Ui, run: &Run) {
    let text = format!("{} in", REPORT_FILES.join(", "));
    ui.label(RichText::new(text).weak());
    let path = RichText::new(run.folder.display().to_string()).monospace();
    ui.add(egui::Label::new(path).truncate().selectable(true));
    if let Some(problem) = &run.folder_problem {
        ui.label(RichText::new(problem).color(ui.visuals().error_fg_color));
    }
}
