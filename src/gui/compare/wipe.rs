//! Two pictures in one frame.

use egui::{Align2, Color32, CursorIcon, FontId, Id, Key, Rect, Sense, Stroke, Ui, Vec2};

use super::{Comparison, Mode};
use crate::gui::canvas::Canvas;
use crate::gui::widgets::format_number;

/// How far beside the divider the mouse takes hold of it, in points.
const REACH: f32 = 7.0;
/// What one press of an arrow key moves the divider by, as a share of the width.
const KEY_STEP: f32 = 0.02;

impl Comparison {
    /// Draws B, the difference or the divider over A, which is there already, in `frame`, whatever part of it `visible` is. `a`: what
    /// A is called.
    pub fn show_ui(&mut self, ui: &Ui, frame: Rect, visible: Rect, a: &str) {
        match self.mode {
            Mode::Wipe => self.wipe_ui(ui, frame, visible, a),
            Mode::Flip => {
                if self.shows_other {
                    self.picture_ui(ui, frame, visible, self.other());
                }
                let name = if self.shows_other { &self.name } else { a };
                tag_ui(ui, visible, Align2::LEFT_TOP, name);
            }
            Mode::Difference => {
                self.picture_ui(ui, frame, visible, self.difference());
                let white = match &self.distance {
                    Some(Ok(distance)) => {
                        format!(", white is {}", format_number(distance.white, 4))
                    }
                    _ => String::new(),
                };
                tag_ui(ui, visible, Align2::LEFT_TOP, &format!("Difference{white}"));
            }
        }
    }

    /// Draws B, or the difference, which are of one part of the picture.
    fn picture_ui(&self, ui: &Ui, frame: Rect, clip: Rect, canvas: Option<&Canvas>) {
        let painter = ui.painter().with_clip_rect(clip.intersect(ui.clip_rect()));
        if let Some(canvas) = canvas {
            canvas.paint(&painter, self.buffer.part().rect_in(frame));
            return;
        }
        let words = match &self.distance {
            Some(Err(_)) => {
                "There is no difference to show: it takes the same part of pictures of one size"
            }
            _ => "…",
        };
        painter.rect_filled(frame, 0.0, Color32::from_black_alpha(190));
        let (center, font) = (frame.intersect(clip).center(), FontId::proportional(15.0));
        painter.text(center, Align2::CENTER_CENTER, words, font, Color32::WHITE);
    }

    fn wipe_ui(&mut self, ui: &Ui, frame: Rect, visible: Rect, a: &str) {
        let x = visible.left() + visible.width() * self.divider;
        let handle = Rect::from_center_size(
            egui::pos2(x, visible.center().y),
            Vec2::new(2.0 * REACH, visible.height()),
        );
        let response = ui.interact(handle, Id::unique("divider"), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::slider(ui.is_enabled(), f64::from(self.divider), "Divider")
        });
        if response.dragged()
            && let Some(position) = response.interact_pointer_pos()
        {
            self.divider = (position.x - visible.left()) / visible.width().max(1.0);
        }
        if response.has_focus() {
            let steps = ui.input(|input| {
                f32::from(u8::from(input.key_pressed(Key::ArrowRight)))
                    - f32::from(u8::from(input.key_pressed(Key::ArrowLeft)))
            });
            self.divider += steps * KEY_STEP;
        }
        self.divider = self.divider.clamp(0.0, 1.0);
        let is_held = response.dragged() || response.has_focus();
        let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);

        let right = Rect::from_min_max(egui::pos2(x, visible.top()), visible.max);
        self.picture_ui(ui, frame, right, self.other());
        let painter = ui.painter().with_clip_rect(visible.expand(1.0));
        let dark = Stroke::new(3.0, Color32::from_black_alpha(150));
        let width = if response.hovered() || is_held {
            2.0
        } else {
            1.2
        };
        for stroke in [dark, Stroke::new(width, Color32::WHITE)] {
            painter.vline(x, visible.y_range(), stroke);
        }
        let grip = egui::pos2(x, visible.center().y);
        painter.circle(
            grip,
            8.0,
            Color32::WHITE,
            Stroke::new(1.0, Color32::from_black_alpha(150)),
        );
        for side in [-1.0, 1.0] {
            let tip = grip + Vec2::new(side * 5.0, 0.0);
            let corner = |y: f32| grip + Vec2::new(side * 2.0, y);
            let points = vec![tip, corner(-3.0), corner(3.0)];
            painter.add(egui::Shape::convex_polygon(
                points,
                Color32::DARK_GRAY,
                Stroke::NONE,
            ));
        }
        tag_ui(ui, visible, Align2::LEFT_TOP, a);
        tag_ui(ui, visible, Align2::RIGHT_TOP, &self.name);
    }
}

/// A name in a corner of `frame`.
fn tag_ui(ui: &Ui, frame: Rect, corner: Align2, name: &str) {
    const MOST_LETTERS: usize = 42;
    let mut name: String = name.to_owned();
    if name.chars().count() > MOST_LETTERS {
        name = name.chars().take(MOST_LETTERS - 1).chain(['…']).collect();
    }
    let painter = ui.painter().with_clip_rect(frame);
    let font = FontId::proportional(12.5);
    let galley = painter.layout_no_wrap(name.clone(), font, Color32::WHITE);
    let padding = Vec2::new(7.0, 3.0);
    let size = galley.size() + 2.0 * padding;
    let rect = corner.align_size_within_rect(size, frame.shrink(8.0));
    painter.rect_filled(rect, 4.0, Color32::from_black_alpha(170));
    painter.galley(rect.min + padding, galley, Color32::WHITE);
    let id = ui.scope_id().with(("tag", corner.x(), corner.y()));
    ui.interact(rect, id, Sense::hover())
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &name));
}
