//! What effects and lights bring to the picture, rendered while nothing else works.

use super::App;
use crate::gui::jobs::Lane;

impl App {
    /// Has contributions rendered that are missing, as soon as the user rests. They give way to everything else that renders or measures.
    pub(super) fn update_contributions(&mut self, ctx: &egui::Context) {
        let is_other = self.contributions.follow(&self.document.scene);
        let is_measuring =
            self.report.is_running() || self.is_measuring_costs() || self.is_estimating_time();
        let is_rendering = self.is_rendering() && !self.is_paused();
        let is_ready = !self.is_settling() && self.is_prepared() && self.problem().is_none();
        let is_free = !is_measuring && !is_rendering && is_ready;
        let is_busy = self.jobs.is_busy(Lane::Contributions);
        if is_busy && (is_other || !is_free || !self.contributions.is_on()) {
            self.jobs.cancel(Lane::Contributions);
        } else if is_free && !is_busy && self.contributions.is_missing() {
            if let Some(time_left) = self.attention.time_left() {
                ctx.request_repaint_after(time_left);
                return;
            }
            let prepared = self.prepared.as_ref();
            let prepared = prepared.and_then(|state| state.prepared.clone());
            if let Some(request) = self.contributions.next_request(prepared) {
                self.jobs
                    .start(Lane::Contributions, move |job| request.render(job));
            }
        }
    }
}
