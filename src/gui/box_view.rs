//! The boxes of the structure in use, one level at a time, as lines in the preview.

use std::sync::Arc;

use egui::{Color32, Rect, RichText, Stroke, Ui, Vec2};

use super::orbit;
use super::pick::to_world;
use super::viewport::picture_size;
use super::widgets::{counted, integer_row_ui, switch_row_ui};
use crate::math::{DBounds, DVec3};
use crate::render::PreparedGeometry;
use crate::scene::Camera;

/// Most boxes that are drawn.
const MOST: usize = 1500;
/// Deepest level on offer: no structure is deeper.
const DEEPEST: u32 = 48;

/// What is shown of the structure. Where it is switched off, nothing is looked for.
#[derive(Debug)]
pub struct BoxView {
    is_on: bool,
    depth: u32,
    shown: Option<Shown>,
}

#[derive(Debug)]
struct Shown {
    geometry: Arc<PreparedGeometry>,
    depth: u32,
    boxes: Vec<DBounds>,
    is_cut: bool,
}

impl Default for BoxView {
    fn default() -> Self {
        Self {
            is_on: false,
            depth: 2,
            shown: None,
        }
    }
}

impl BoxView {
    /// Whether boxes are shown, and of which level.
    pub fn choice_ui(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            switch_row_ui(
                ui,
                "Show boxes",
                "Draw the boxes of the structure in the preview: those of one level",
                &mut self.is_on,
            );
            if let Some(shown) = &self.shown {
                let count = counted(shown.boxes.len(), "box", "boxes");
                let text = if shown.is_cut {
                    format!("the first {count} of more")
                } else {
                    count
                };
                ui.add(egui::Label::new(RichText::new(text).weak().small()).truncate());
            }
        });
        // There all the time, so that what is below keeps its place.
        ui.add_enabled_ui(self.is_on, |ui| {
            integer_row_ui(
                ui,
                "Level",
                "How many times the box around everything was divided: by one plane of the kd-tree, into up to eight boxes of the wide tree. Parts \
                 that were not divided so often are shown as they are",
                &mut self.depth,
                0..=DEEPEST,
                0.05,
            )
            .on_disabled_hover_text("Show boxes is off");
        });
    }

    /// Keeps the boxes those of `geometry`.
    pub fn update(&mut self, geometry: Option<&Arc<PreparedGeometry>>) {
        let Some(geometry) = geometry.filter(|_| self.is_on) else {
            self.shown = None;
            return;
        };
        let is_known =
            |shown: &Shown| shown.depth == self.depth && Arc::ptr_eq(&shown.geometry, geometry);
        if self.shown.as_ref().is_some_and(is_known) {
            return;
        }
        let found = geometry.accelerator().boxes_at(self.depth, MOST);
        let frame = geometry.frame();
        self.shown = Some(Shown {
            geometry: Arc::clone(geometry),
            depth: self.depth,
            boxes: found.boxes.iter().map(|b| to_world(frame, b)).collect(),
            is_cut: found.is_cut,
        });
    }

    /// How many boxes are drawn.
    #[must_use]
    pub fn count(&self) -> usize {
        self.shown.as_ref().map_or(0, |shown| shown.boxes.len())
    }

    /// Draws them into `frame`, which `camera` sees.
    pub fn boxes_ui(&self, ui: &Ui, frame: Rect, camera: &Camera) {
        let Some(shown) = &self.shown else { return };
        let painter = ui.painter().with_clip_rect(frame);
        let size = picture_size(frame);
        // Many boxes are drawn thinner than few.
        let alpha = if shown.boxes.len() > 200 { 0.45 } else { 0.8 };
        let color = Color32::from_rgb(0x4c, 0xe0, 0xc0).gamma_multiply(alpha);
        for bounds in &shown.boxes {
            for [from, to] in edges(bounds) {
                if let Some(ends) = orbit::project_line(camera, size, from, to) {
                    #[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
                    let ends = ends.map(|end| {
                        frame.min
                            + Vec2::new(
                                end.x.clamp(-1e5, 1e5) as f32,
                                end.y.clamp(-1e5, 1e5) as f32,
                            )
                    });
                    painter.line_segment(ends, Stroke::new(1.0, color));
                }
            }
        }
    }
}

/// The twelve edges of a box.
fn edges(bounds: &DBounds) -> impl Iterator<Item = [DVec3; 2]> + use<> {
    let ends = [bounds.min, bounds.max];
    let corner = move |bits: usize| {
        DVec3::new(
            ends[bits & 1].x,
            ends[bits >> 1 & 1].y,
            ends[bits >> 2 & 1].z,
        )
    };
    (0..8_usize).flat_map(move |from| {
        let others = (0..3).map(move |axis| from | 1 << axis);
        others
            .filter(move |&to| to != from)
            .map(move |to| [corner(from), corner(to)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_along_the_axes() {
        let bounds = DBounds {
            min: DVec3::new(1.0, 2.0, 3.0),
            max: DVec3::new(2.0, 4.0, 6.0),
        };
        let edges: Vec<[DVec3; 2]> = edges(&bounds).collect();
        assert_eq!(edges.len(), 12);
        let total: f64 = edges.iter().map(|[a, b]| a.distance(*b)).sum();
        assert_eq!(total, 4.0 * (1.0 + 2.0 + 3.0));
    }
}
