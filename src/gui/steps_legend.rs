//! What the colours of mode `steps` mean, over a picture that shows them.

use egui::{Align2, Color32, FontId, Mesh, Pos2, Rect, Sense, Ui, Vec2};

use crate::render::{MOST_STEPS, display, steps_color};
use crate::scene::Display;

/// Size of the legend, and its distance from the picture's edges, in points.
const LEGEND: Vec2 = Vec2::new(250.0, 56.0);
const LEGEND_DISTANCE: f32 = 10.0;
/// Numbers of steps that are written under the bar.
const MARKS: [u64; 5] = [0, 3, 15, 63, MOST_STEPS];
/// Parts of the bar.
const PARTS: u16 = 64;

/// Draws the legend into the lower left corner of the picture in `frame`, in the colours that it has as it is shown.
pub fn legend_ui(ui: &Ui, frame: Rect, display: &Display) {
    let corner = frame.left_bottom() + Vec2::new(LEGEND_DISTANCE, -LEGEND_DISTANCE - LEGEND.y);
    let area = Rect::from_min_size(corner, LEGEND);
    let painter = ui.painter();
    painter.rect_filled(area, 6.0, Color32::from_black_alpha(200));
    let inside = area.shrink2(Vec2::new(14.0, 7.0));
    let bar = Rect::from_min_size(
        inside.left_top() + Vec2::new(0.0, 17.0),
        Vec2::new(inside.width(), 10.0),
    );
    let ink = Color32::from_gray(0xe8);
    let font = || FontId::proportional(11.0);
    let title = "Nodes and blocks that a ray visits";
    painter.text(inside.left_top(), Align2::LEFT_TOP, title, font(), ink);

    let mut mesh = Mesh::default();
    for (corner, part) in (0..).step_by(2).zip(0..=PARTS) {
        let share = f32::from(part) / f32::from(PARTS);
        let x = egui::lerp(bar.x_range(), share);
        let [r, g, b] = display::encode_8(steps_color(steps_at(share)).to_array(), display);
        for y in [bar.top(), bar.bottom()] {
            mesh.colored_vertex(Pos2::new(x, y), Color32::from_rgb(r, g, b));
        }
        if part > 0 {
            mesh.add_triangle(corner - 2, corner - 1, corner);
            mesh.add_triangle(corner - 1, corner, corner + 1);
        }
    }
    painter.add(mesh);
    for steps in MARKS {
        let place = Pos2::new(
            egui::lerp(bar.x_range(), share_of(steps)),
            bar.bottom() + 1.0,
        );
        let text = if steps == MOST_STEPS {
            format!("{steps}+")
        } else {
            steps.to_string()
        };
        painter.text(place, Align2::CENTER_TOP, text, font(), ink);
    }
    let response = ui.interact(area, ui.scope_id().with("steps legend"), Sense::hover());
    response.widget_info(|| {
        let label = format!("Colours of 0 to {MOST_STEPS} steps");
        egui::WidgetInfo::labeled(egui::Role::Label, true, label)
    });
}

/// Where that many steps are on the bar.
fn share_of(steps: u64) -> f32 {
    (steps as f32 + 1.0).log2() / (MOST_STEPS as f32 + 1.0).log2()
}

/// The steps at that place of the bar.
fn steps_at(share: f32) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 0 and at most the most steps"
    )]
    let steps = ((MOST_STEPS as f32 + 1.0).powf(share) - 1.0).round() as u64;
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_goes_from_none_to_the_most() {
        for steps in MARKS {
            assert_eq!(steps_at(share_of(steps)), steps);
        }
        assert_eq!([steps_at(0.0), steps_at(1.0)], [0, MOST_STEPS]);
    }
}
