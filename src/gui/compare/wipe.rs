//! Two pictures in one frame.

use egui::{
    Align2, Color32, CursorIcon, EventFilter, FontId, Id, Key, Rect, Sense, Stroke, Ui, Vec2,
};

use super::{Comparison, Mode, Side};
use crate::gui::theme;
use crate::gui::widgets::format_number;

/// How far beside the divider the mouse takes hold of it, in points.
const REACH: f32 = 7.0;
/// What one press of an arrow key moves the divider by, as a share of the width.
const KEY_STEP: f32 = 0.02;
/// The keys that move it.
const ARROWS: EventFilter = EventFilter {
    tab: false,
    horizontal_arrows: true,
    vertical_arrows: false,
    escape: false,
};

impl Comparison {
    /// Draws B, the difference or the divider over A, which is there already, in `frame`, whatever part of it `visible` is. `a`: what
    /// A is called.
    pub fn show_ui(&mut self, ui: &Ui, frame: Rect, visible: Rect, a: &str) {
        match self.mode {
            Mode::Wipe => self.wipe_ui(ui, frame, visible, a),
            Mode::Flip => {
                if self.shows_other {
                    self.picture_ui(ui, frame, visible, Side::Other);
                }
                let name = if self.shows_other { &self.name } else { a };
                tag_ui(ui, visible, Align2::LEFT_TOP, name);
            }
            Mode::Difference => {
                self.picture_ui(ui, frame, visible, Side::Difference);
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

    /// Draws B, or the difference, over A. Where there is none of it, there is nothing: A would be taken for it.
    fn picture_ui(&self, ui: &Ui, frame: Rect, clip: Rect, side: Side) {
        let painter = ui.painter().with_clip_rect(clip.intersect(ui.clip_rect()));
        let (canvas, shared) = match (side, &self.distance) {
            (Side::Difference, Some(Ok(distance))) => (self.difference(), distance.shared),
            (Side::Difference, _) => (None, None),
            (Side::Other, _) => (self.other(), None),
        };
        if let Some(canvas) = canvas {
            let part = shared.unwrap_or(self.buffer.part());
            if !part.is_whole() {
                painter.rect_filled(frame, 0.0, theme::backdrop(ui.visuals()));
            }
            canvas.paint(&painter, part.rect_in(frame));
            return;
        }
        let words = match (side, &self.distance) {
            (Side::Difference, Some(Err(_))) => {
                "There is no difference to show: it takes pictures of one size that both show some of the same pixels"
            }
            _ => "…",
        };
        painter.rect_filled(frame, 0.0, Color32::from_black_alpha(190));
        let (center, font) = (frame.intersect(clip).center(), FontId::proportional(15.0));
        painter.text(center, Align2::CENTER_CENTER, words, font, Color32::WHITE);
    }

    fn wipe_ui(&mut self, ui: &Ui, frame: Rect, visible: Rect, a: &str) {
        let x = self.divider_x(visible);
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
        let is_focused = response.has_focus();
        if is_focused {
            // They would go on to another control.
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, ARROWS));
        }
        // Where nothing else takes keys, it need not be gone to.
        let is_steered = is_focused || ui.memory(|memory| memory.focused().is_none());
        if is_steered && ui.is_enabled() {
            let steps = ui.input(|input| {
                f32::from(u8::from(input.key_pressed(Key::ArrowRight)))
                    - f32::from(u8::from(input.key_pressed(Key::ArrowLeft)))
            });
            self.divider += steps * KEY_STEP;
        }
        self.divider = self.divider.clamp(0.0, 1.0);
        let is_held = response.dragged() || is_focused;
        let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);

        let right = Rect::from_min_max(egui::pos2(x, visible.top()), visible.max);
        self.picture_ui(ui, frame, right, Side::Other);
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
