//! The part of the picture that is rendered: drawn with the mouse over picture or preview, or given in pixels.
//!
//! It is no part of the scene: it is in no scene file and no step to undo. When the picture's size changes, it keeps what it shows.

use std::ops::RangeInclusive;

use egui::emath::Numeric as _;
use egui::{Color32, CursorIcon, Rect, Sense, Stroke, StrokeKind, Ui};

use super::part::Part;
use super::theme;
use super::tool;
use super::widgets::{Number, row_ui};

/// What the region is, and whether it is being drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct RegionTool {
    chosen: Option<Part>,
    /// Whether the mouse draws one.
    pub is_drawing: bool,
    /// The drag that is going on.
    drag: Option<Drag>,
}

/// A region that is being drawn.
#[derive(Clone, Copy, Debug)]
struct Drag {
    /// Where it began, as edges of pixels.
    from: [u32; 2],
    /// What was chosen before.
    before: Option<Part>,
}

impl RegionTool {
    /// What is rendered of a picture of the size `of`.
    #[must_use]
    pub fn part(&self, of: [u32; 2]) -> Part {
        let chosen = self.chosen.map(|part| part.scaled_to(of));
        chosen.unwrap_or(Part::whole(of))
    }

    /// Whether it is less than the whole picture.
    #[must_use]
    pub fn is_chosen(&self) -> bool {
        self.chosen.is_some()
    }

    /// Has `part` rendered from now on.
    pub fn choose(&mut self, part: Part) {
        self.chosen = Some(part).filter(|part| !part.is_whole());
    }

    /// Has all of the picture rendered again.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes the tool that draws, or puts it away.
    pub fn toggle_drawing(&mut self) {
        if self.is_drawing {
            self.stop();
        } else {
            self.is_drawing = true;
        }
    }

    /// Puts the tool away that draws. What a drag has drawn that goes on is as it was before.
    pub fn stop(&mut self) {
        self.is_drawing = false;
        if let Some(drag) = self.drag.take() {
            self.chosen = drag.before;
        }
    }

    /// Lets the mouse draw the region of a picture of the size `of` that is in `frame`, of which `area` is seen: from anywhere in that, as
    /// what lies beside the picture stands for its edge. A click clears it.
    pub fn draw_ui(&mut self, ui: &Ui, frame: Rect, area: Rect, of: [u32; 2]) {
        let response = ui
            .interact(area, ui.scope_id().with("region"), Sense::click_and_drag())
            .accessible_name("Region to render")
            .on_hover_cursor(CursorIcon::Crosshair);
        if response.clicked() {
            self.clear();
            return;
        }
        if response.drag_started() {
            let origin = ui.input(|input| input.pointer.press_origin());
            self.drag = origin.map(|origin| Drag {
                from: Part::edge_at(origin, frame, of),
                before: self.chosen,
            });
        }
        if let (Some(drag), Some(position)) = (self.drag, response.interact_pointer_pos()) {
            let to = Part::edge_at(position, frame, of);
            self.chosen = Part::between(drag.from, to, of).filter(|part| !part.is_whole());
        }
        if response.drag_stopped() {
            let is_released = ui.input(|input| input.pointer.any_released());
            // One drag is one region; the mouse is free again. Where Esc ends it, the command that goes with the key puts the tool away.
            match self.drag.take() {
                Some(drag) if !is_released => self.chosen = drag.before,
                _ => self.is_drawing = false,
            }
        }
    }

    /// Draws its outline, and darkens what is not rendered while it is being drawn.
    pub fn outline_ui(&self, ui: &Ui, frame: Rect, visible: Rect, of: [u32; 2]) {
        let painter = ui.painter().with_clip_rect(visible);
        let Some(part) = self.chosen.map(|part| part.scaled_to(of)) else {
            if self.is_drawing {
                tool::hint_ui(
                    ui,
                    frame.intersect(visible),
                    "Drag over the part to render; click for all of it",
                );
            }
            return;
        };
        let inside = part.rect_in(frame);
        if self.is_drawing {
            let shade = Color32::from_black_alpha(110);
            let columns =
                |left: f32, right: f32| Rect::from_x_y_ranges(left..=right, inside.y_range());
            let rows = |top: f32, bottom: f32| Rect::from_x_y_ranges(frame.x_range(), top..=bottom);
            for outside in [
                rows(frame.top(), inside.top()),
                rows(inside.bottom(), frame.bottom()),
                columns(frame.left(), inside.left()),
                columns(inside.right(), frame.right()),
            ] {
                painter.rect_filled(outside, 0.0, shade);
            }
        }
        for (width, color) in [(3.0, Color32::from_black_alpha(150)), (1.4, theme::ACCENT)] {
            painter.rect_stroke(inside, 0.0, Stroke::new(width, color), StrokeKind::Outside);
        }
    }

    /// Buttons and numbers, for a picture of the size `of`.
    pub fn panel_ui(&mut self, ui: &mut Ui, of: [u32; 2]) {
        row_ui(
            ui,
            "Region",
            "Render only a part of the picture; its pixels are those of the whole. Saving writes the part alone",
            |ui| {
                let text = if self.is_drawing {
                    "Drag over it…"
                } else {
                    "Draw"
                };
                let draw = ui
                    .add(egui::Button::new(text).selected(self.is_drawing))
                    .on_hover_text("Draw it with the mouse, over the preview or the picture; a click clears it  (B)");
                let draw = draw.accessible_name("Draw region");
                if draw.clicked() {
                    self.toggle_drawing();
                }
                let clear = ui
                    .add_enabled(self.is_chosen(), egui::Button::new("Clear"))
                    .accessible_name("Clear region")
                    .on_hover_text("Render all of the picture again  (Shift+B)")
                    .on_disabled_hover_text("All of the picture is rendered");
                if clear.clicked() {
                    self.clear();
                }
                ui.response()
            },
        );
        // Those of the whole picture where none is chosen: the place of all that is below is the same.
        let shown = self.part(of);
        let typed = numbers_ui(ui, shown);
        // At another size it is rounded; what was chosen stays until another is, or sizes that are gone through would wear it down.
        if typed != shown {
            self.choose(typed);
        }
    }
}

/// Lets the pixels of `part` be typed; what would lie outside of the picture is cut off.
fn numbers_ui(ui: &mut Ui, part: Part) -> Part {
    let [width, height] = part.of;
    let mut region = part.region;
    let [last_column, last_row] = part.of.map(|side| side.saturating_sub(1));
    let corner = [
        (
            "Region left",
            "First column, from 0",
            &mut region.x,
            0..=last_column,
        ),
        (
            "Region top",
            "First row, from 0",
            &mut region.y,
            0..=last_row,
        ),
    ];
    pair_ui(ui, ["Left, top", "The first pixel of the region"], corner);
    let (columns, rows) = (1..=width.max(1), 1..=height.max(1));
    let size = [
        ("Region width", "Columns", &mut region.width, columns),
        ("Region height", "Rows", &mut region.height, rows),
    ];
    pair_ui(
        ui,
        [
            "Width, height",
            "How many pixels of the picture are rendered",
        ],
        size,
    );
    region.width = region.width.min(width - region.x);
    region.height = region.height.min(height - region.y);
    Part { region, ..part }
}

/// A row with two whole numbers: each has a name, a tooltip, a value and its range.
fn pair_ui(
    ui: &mut Ui,
    [label, tooltip]: [&str; 2],
    pair: [(&str, &str, &mut u32, RangeInclusive<u32>); 2],
) {
    row_ui(ui, label, tooltip, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
        for (name, tooltip, value, range) in pair {
            let number = Number {
                decimals: 0,
                ..Number::within(range.start().to_f64()..=range.end().to_f64(), 1.0)
            };
            let mut whole = value.to_f64();
            let response = number.field_ui(ui, width, &mut whole, None);
            if response.changed() {
                *value = u32::from_f64(whole);
            }
            response.accessible_name(name).on_hover_text(tooltip);
        }
        ui.response()
    });
}
