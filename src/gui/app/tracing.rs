//! The rays of a pixel, and the boxes of the structure that they pass.

use std::sync::Arc;

use super::App;
use crate::gui::document::{same_geometry, same_picture_but_camera};
use crate::gui::jobs::Lane;
use crate::gui::ray_view::{RayView, WantedRays};
use crate::gui::tool::Tool;
use crate::render::SampleTrace;

impl App {
    /// Has the rays traced of the pixel that was clicked, where one was. Those of a picture are of the scene it was rendered of.
    pub(super) fn trace_asked_ray(&mut self) {
        let Some(place) = self.viewport.take_asked_ray() else {
            return;
        };
        let Some(state) = &self.prepared else { return };
        let picture = self.picture_on_screen().map(|picture| &picture.scene);
        let scene = picture.unwrap_or(&self.document.scene);
        if !same_geometry(&state.scene, scene) {
            self.messages
                .news("No rays: the objects have changed since this picture");
            return;
        }
        let wanted = WantedRays::at(place, scene.clone(), self.document.scene.clone());
        self.trace(wanted);
    }

    /// Has another sample of the same pixel traced, `step` after the present one.
    pub(super) fn trace_other_sample(&mut self, step: i64) {
        if let Some(rays) = &self.rays
            && let Some(wanted) = rays.wanted.of_other_sample(step)
        {
            self.trace(wanted);
        }
    }

    fn trace(&mut self, wanted: WantedRays) {
        let known = self.prepared.as_ref();
        let known = known.and_then(|state| state.prepared.clone());
        self.jobs.start(Lane::Trace, move |job| {
            wanted.trace(known.as_ref(), job);
        });
    }

    /// Shows rays that were traced, in the preview.
    pub(super) fn traced(&mut self, wanted: WantedRays, result: Result<SampleTrace, String>) {
        match result {
            Ok(trace) => {
                self.rays = Some(RayView::new(wanted, trace));
                self.show_camera_view();
            }
            Err(error) => self.messages.error("No rays can be shown", error),
        }
    }

    /// Whether the rays are still those of the scene, and asked for.
    pub(super) fn shows_rays(&self) -> bool {
        let is_of =
            |rays: &RayView| same_picture_but_camera(&rays.wanted.edited, &self.document.scene);
        self.viewport.tool == Tool::Rays && self.rays.as_ref().is_some_and(is_of)
    }

    /// What to say of them.
    pub(super) fn ray_words(&self) -> Vec<String> {
        match self.rays.as_ref().filter(|_| self.shows_rays()) {
            Some(rays) => rays.in_words(),
            None => vec!["Click a pixel to see its rays".to_owned()],
        }
    }

    /// Keeps the boxes those of the structure in use.
    pub(super) fn update_boxes(&mut self) {
        let state = self.prepared.as_ref().filter(|_| self.is_prepared());
        let geometry = state.map(|state| Arc::clone(&state.placed.geometry));
        self.boxes.update(geometry.as_ref());
    }
}
