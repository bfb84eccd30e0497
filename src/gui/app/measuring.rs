//! What effects cost, measured on the scene as it is. Only times are measured, so a render goes before it.

use super::App;
use crate::analysis::cost::Costs;
use crate::control::Progress;
use crate::gui::costs::CostState;
use crate::gui::jobs::Lane;
use crate::gui::worker;
use crate::scene::Scene;

impl App {
    /// Has balls of materials rendered that are missing. Not before the scene can be drawn and rendered, and not while something is
    /// measured: it would take time from that.
    pub(super) fn update_balls(&mut self) {
        self.balls.set_images(&self.document.scene.textures);
        let is_measuring =
            self.report.is_running() || self.is_measuring_costs() || self.is_estimating_time();
        let is_free = !is_measuring && !self.is_settling() && !self.jobs.is_busy(Lane::Balls);
        if let Some(request) = self.balls.next_request().filter(|_| is_free) {
            self.jobs.start(Lane::Balls, move |job| request.render(job));
        }
    }

    pub(super) fn is_measuring_costs(&self) -> bool {
        matches!(self.costs, CostState::Measuring(_))
    }

    pub(super) fn measure_costs(&mut self) {
        self.stop_estimating_time();
        let progress = Progress::new();
        self.costs = CostState::Measuring(progress.clone());
        let scene = self.document.scene.clone();
        let prepared = self.prepared.as_ref();
        let prepared = prepared.and_then(|state| state.prepared.clone());
        self.jobs.start(Lane::Costs, move |job| {
            worker::measure_costs(job, scene, prepared.as_ref(), &progress);
        });
    }

    /// Gives up measuring, where that goes on.
    pub(super) fn cancel_measuring_costs(&mut self) {
        if self.is_measuring_costs() {
            self.jobs.cancel(Lane::Costs);
            self.costs = CostState::Unknown;
        }
    }

    pub(super) fn costs_measured(&mut self, scene: Box<Scene>, result: Result<Box<Costs>, String>) {
        self.costs = match result {
            Ok(costs) => CostState::Known { scene, costs },
            Err(problem) => CostState::Failed(problem),
        };
    }
}
