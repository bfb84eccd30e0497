//! What colours of a picture mean, over the picture: a bar of them, with numbers.

use egui::{Align2, Color32, FontId, Mesh, Pos2, Rect, Sense, Ui, Vec2};

/// Width of the legend, its height without and with numbers under the bar, and its distance from the picture's edges, in points.
const WIDTH: f32 = 250.0;
const HEIGHT: f32 = 44.0;
const HEIGHT_WITH_MARKS: f32 = 58.0;
const DISTANCE: f32 = 10.0;
/// Parts of the bar.
const PARTS: u16 = 64;

/// A legend.
#[derive(Clone, Debug)]
pub struct Legend<'a> {
    /// Over the start of the bar.
    pub start: &'a str,
    /// Over its end.
    pub end: &'a str,
    /// Under it, with their places, `0..=1` from its start.
    pub marks: &'a [(f32, String)],
    /// All of it, for those who do not see it.
    pub name: String,
    /// What shows where the mouse rests on it.
    pub explanation: &'a str,
}

impl Legend<'_> {
    /// Draws it into the lower left corner of the picture in `frame`; `color`: that of a place on the bar.
    pub fn show_ui(&self, ui: &Ui, frame: Rect, color: impl Fn(f32) -> Color32) {
        let height = if self.marks.is_empty() {
            HEIGHT
        } else {
            HEIGHT_WITH_MARKS
        };
        let corner = frame.left_bottom() + Vec2::new(DISTANCE, -DISTANCE - height);
        let area = Rect::from_min_size(corner, Vec2::new(WIDTH, height));
        let painter = ui.painter();
        painter.rect_filled(area, 6.0, Color32::from_black_alpha(200));
        let inside = area.shrink2(Vec2::new(14.0, 7.0));
        let bar = Rect::from_min_size(
            inside.left_top() + Vec2::new(0.0, 19.0),
            Vec2::new(inside.width(), 10.0),
        );
        let mut mesh = Mesh::default();
        for (corner, part) in (0..).step_by(2).zip(0..=PARTS) {
            let share = f32::from(part) / f32::from(PARTS);
            let x = egui::lerp(bar.x_range(), share);
            for y in [bar.top(), bar.bottom()] {
                mesh.colored_vertex(Pos2::new(x, y), color(share));
            }
            if part > 0 {
                mesh.add_triangle(corner - 2, corner - 1, corner);
                mesh.add_triangle(corner - 1, corner, corner + 1);
            }
        }
        painter.add(mesh);
        let ink = Color32::from_gray(0xe8);
        let text = |place, align, text: &str| {
            painter.text(place, align, text, FontId::proportional(11.0), ink);
        };
        text(inside.left_top(), Align2::LEFT_TOP, self.start);
        text(inside.right_top(), Align2::RIGHT_TOP, self.end);
        for (share, mark) in self.marks {
            let x = egui::lerp(bar.x_range(), *share);
            text(Pos2::new(x, bar.bottom() + 1.0), Align2::CENTER_TOP, mark);
        }
        let response = ui.interact(area, ui.scope_id().with("legend"), Sense::hover());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, self.name.clone()));
        response.on_hover_text(self.explanation);
    }
}
