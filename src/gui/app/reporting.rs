//! Error against run time, measured on the scene as it is.
//!
//! What is measured is time, so a report begins only when nothing else works any more: a running render is stopped, and one that is
//! being prepared is waited for.

use std::path::Path;

use super::App;
use crate::analysis::report::ReportError;
use crate::gui::jobs::Lane;
use crate::gui::report::{Asked, Subject};
use crate::gui::worker::{self, ReportRequest};

impl App {
    /// Shows the window of the report.
    pub(super) fn show_report(&mut self, ctx: &egui::Context) {
        let here = std::env::current_dir().unwrap_or_default();
        let beside = self.document.path().and_then(Path::parent).unwrap_or(&here);
        let folder = beside.join(format!("{}-report", self.document.name()));
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        self.report.show(&folder);
        // It is drawn in the next frame.
        ctx.request_repaint();
    }

    /// Draws the window of the report, and does what it asks for.
    pub(super) fn report_ui(&mut self, ctx: &egui::Context) {
        let subject = Subject {
            scene: &self.document.scene,
            name: self.document.name(),
            is_modified: self.document.is_modified(),
            is_rendering: self.is_rendering(),
        };
        match self.report.window_ui(ctx, subject) {
            None => {}
            Some(Asked::Start { folder, options }) => {
                self.cancel_render();
                self.cancel_measuring_costs();
                self.stop_estimating_time();
                self.waiting_report = Some(ReportRequest {
                    scene: self.document.scene.clone(),
                    scene_name: self.document.name().to_owned(),
                    options,
                    threads: self.threads.count(),
                    progress: self.report.begin(folder.clone()),
                    folder,
                });
            }
            Some(Asked::Path(purpose)) => self.ask_for_path(purpose),
            Some(Asked::Cancel) => self.cancel_report(),
            Some(Asked::ShowFolder(folder)) => {
                self.jobs.start(Lane::ShowFolder, move |job| {
                    worker::show_folder(job, &folder);
                });
            }
        }
    }

    /// Starts the report that was asked for as soon as nothing else works.
    pub(super) fn start_waiting_report(&mut self) {
        if self.is_settling() || self.render_threads() > 0 {
            return;
        }
        if let Some(request) = self.waiting_report.take() {
            self.jobs
                .start(Lane::Report, move |job| worker::report(job, request));
        }
    }

    pub(super) fn cancel_report(&mut self) {
        self.waiting_report = None;
        self.jobs.cancel(Lane::Report);
        self.report.cancel();
        self.messages.news("Report cancelled");
    }

    pub(super) fn reported(&mut self, result: &Result<(), ReportError>) {
        match result {
            Ok(()) => self.report.finish(),
            Err(error) => self.report.fail(error),
        }
    }
}
