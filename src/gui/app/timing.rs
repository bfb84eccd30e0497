//! How long a render will take, found out when somebody asks, or points at the button that starts it.

use super::App;
use crate::analysis::pilot::TimeEstimate;
use crate::gui::document::same_picture;
use crate::gui::jobs::Lane;
use crate::gui::picture::Outcome;
use crate::gui::time_estimate::{Subject, TimeState};
use crate::gui::worker;
use crate::render::PreparedScene;

impl App {
    /// What a render of the scene as it is takes, as far as that is known: as it was found out, or as long as the last one took, where
    /// it was of the same scene.
    #[must_use]
    pub fn estimated_time(&self) -> Option<TimeEstimate> {
        if let TimeState::Known { subject, estimate } = &self.time
            && self.is_present(subject)
        {
            return Some(*estimate);
        }
        let last = self.picture.as_ref()?;
        let Outcome::Finished { stats, .. } = &last.outcome else {
            return None;
        };
        // One that came there by other rules is not what would be rendered now.
        let is_same = !self.is_outdated(last) && !last.is_continued();
        let is_same = is_same && !last.rules().lead_elsewhere();
        is_same.then(|| TimeEstimate::as_before(last.elapsed(), stats.samples_per_pixel))
    }

    fn is_present(&self, subject: &Subject) -> bool {
        subject.part == self.wanted_part()
            && subject.threads == self.threads
            && same_picture(&subject.scene, &self.document.scene)
    }

    /// What was prepared of the scene, once it can be rendered.
    fn scene_to_render(&self) -> Option<&PreparedScene> {
        self.prepared.as_ref()?.prepared.as_ref()
    }

    /// Whether the time is being found out.
    pub(super) fn is_estimating_time(&self) -> bool {
        matches!(self.time, TimeState::Measuring)
    }

    /// Whether it can be found out now: nothing works that would spoil it.
    pub(super) fn can_estimate_time(&self) -> bool {
        let is_free = !self.is_rendering() && !self.report.is_running();
        is_free
            && !self.is_measuring_costs()
            && self.invalid.is_none()
            && self.scene_to_render().is_some()
            && !self.is_settling()
            && self.is_prepared()
    }

    /// Finds out how long a render will take, unless that is known.
    pub(super) fn estimate_time(&mut self) {
        let Some(prepared) = self.scene_to_render().cloned() else {
            return;
        };
        if self.is_estimating_time() || self.estimated_time().is_some() {
            return;
        }
        self.time = TimeState::Measuring;
        let subject = Subject {
            scene: self.document.scene.clone(),
            part: self.wanted_part(),
            threads: self.threads,
        };
        self.jobs.start(Lane::Time, move |job| {
            worker::estimate_time(job, subject, &prepared);
        });
    }

    /// Gives up finding out, where that goes on.
    pub(super) fn stop_estimating_time(&mut self) {
        if self.is_estimating_time() {
            self.jobs.cancel(Lane::Time);
            self.time = TimeState::Unknown;
        }
    }

    pub(super) fn time_estimated(
        &mut self,
        subject: Box<Subject>,
        result: Result<TimeEstimate, String>,
    ) {
        self.time = match result {
            Ok(estimate) => TimeState::Known { subject, estimate },
            Err(problem) => {
                self.messages
                    .error("The time of a render cannot be told", problem);
                TimeState::Unknown
            }
        };
    }
}
