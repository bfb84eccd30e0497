//! What the mouse does in the preview beside looking around, and the small bar to choose it from.

use egui::{Color32, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2, vec2};

use super::commands::Command;
use super::gizmo::Orientation;
use super::theme;

/// Side of a button, in points.
const SIDE: f32 = 28.0;
/// From the corner of the preview's room, in points.
const DISTANCE: f32 = 8.0;
/// What the bar and the room beside it take of the left of the area, in points.
pub const BAR_WIDTH: f32 = SIDE + 2.0 * DISTANCE;

/// What the mouse does in the preview. Dragging beside handles and markers looks around with every tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Tool {
    /// A click selects.
    #[default]
    Select,
    /// Handles move the selected object or light.
    Move,
    /// Handles turn it.
    Rotate,
    /// A handle makes it larger or smaller.
    Scale,
    /// A click makes what is under it sharp.
    Focus,
    /// A click shows the rays of what is under it.
    Rays,
}

impl Tool {
    /// All of them, in the order of the bar.
    pub const ALL: [Self; 6] = [
        Self::Select,
        Self::Move,
        Self::Rotate,
        Self::Scale,
        Self::Focus,
        Self::Rays,
    ];

    /// The command that chooses it.
    #[must_use]
    pub fn command(self) -> Command {
        match self {
            Self::Select => Command::SelectTool,
            Self::Move => Command::MoveTool,
            Self::Rotate => Command::RotateTool,
            Self::Scale => Command::ScaleTool,
            Self::Focus => Command::FocusTool,
            Self::Rays => Command::RayTool,
        }
    }

    /// The tool that `command` chooses.
    #[must_use]
    pub fn chosen_by(command: Command) -> Option<Self> {
        Self::ALL.into_iter().find(|tool| tool.command() == command)
    }

    /// Whether it has handles.
    #[must_use]
    pub fn has_handles(self) -> bool {
        matches!(self, Self::Move | Self::Rotate | Self::Scale)
    }

    /// Draws what it does around `center`.
    fn paint(self, painter: &Painter, center: Pos2, ink: Color32) {
        let stroke = Stroke::new(1.5, ink);
        let at = |x: f32, y: f32| center + vec2(x, y);
        let arrow_head = |tip: Pos2, along: Vec2| {
            let across = along.rot90();
            for side in [across, -across] {
                painter.line_segment([tip, tip - along * 3.2 + side * 3.2], stroke);
            }
        };
        match self {
            Self::Select => {
                let corners = [(-4.0, -7.0), (-4.0, 6.0), (-0.8, 3.2), (5.4, 3.2)];
                let corners = corners.map(|(x, y)| at(x, y)).to_vec();
                painter.add(egui::Shape::convex_polygon(corners, ink, Stroke::NONE));
                painter.line_segment([at(-0.4, 2.0), at(2.2, 7.4)], Stroke::new(2.2, ink));
            }
            Self::Move => {
                for along in [
                    vec2(1.0, 0.0),
                    vec2(0.0, 1.0),
                    vec2(-1.0, 0.0),
                    vec2(0.0, -1.0),
                ] {
                    painter.line_segment([center, center + along * 8.0], stroke);
                    arrow_head(center + along * 8.0, along);
                }
            }
            Self::Rotate => {
                let arc = (0..=20_u8).map(|step| {
                    let angle = 0.6 + f32::from(step) / 20.0 * 4.9;
                    center + Vec2::angled(angle) * 6.5
                });
                let arc: Vec<Pos2> = arc.collect();
                let (tip, before) = (arc[20], arc[17]);
                painter.line(arc, stroke);
                arrow_head(tip, (tip - before).normalized());
            }
            Self::Scale => {
                let small = Rect::from_min_max(at(-7.0, 1.0), at(-1.0, 7.0));
                painter.rect_stroke(small, 0.0, stroke, egui::StrokeKind::Middle);
                painter.line_segment([at(0.5, -0.5), at(6.5, -6.5)], stroke);
                arrow_head(at(6.5, -6.5), vec2(1.0, -1.0).normalized());
            }
            Self::Rays => {
                let path = vec![at(-8.0, -5.0), at(-1.0, 5.0), at(7.0, -1.0)];
                painter.line(path, stroke);
                painter.circle_filled(at(-1.0, 5.0), 2.0, ink);
                painter.line_segment([at(-1.0, 5.0), at(1.0, -7.0)], Stroke::new(1.0, ink));
            }
            Self::Focus => {
                painter.circle_stroke(center, 5.5, stroke);
                painter.circle_filled(center, 1.6, ink);
                for along in [
                    vec2(1.0, 0.0),
                    vec2(0.0, 1.0),
                    vec2(-1.0, 0.0),
                    vec2(0.0, -1.0),
                ] {
                    painter.line_segment([center + along * 5.5, center + along * 9.0], stroke);
                }
            }
        }
    }
}

/// Draws the bar into the upper left corner of `area`; returns the tool that was chosen there.
pub fn tools_ui(ui: &mut Ui, area: Rect, active: Tool) -> Option<Tool> {
    let corner = area.min + Vec2::splat(DISTANCE);
    let size = vec2(SIDE, SIDE * Tool::ALL.len() as f32);
    let bar = Rect::from_min_size(corner, size);
    let fill = ui.visuals().panel_fill;
    let edge = ui.visuals().widgets.noninteractive.bg_stroke;
    let painter = ui.painter();
    painter.rect(bar.expand(3.0), 7.0, fill, edge, egui::StrokeKind::Inside);
    let mut chosen = None;
    for (index, tool) in Tool::ALL.into_iter().enumerate() {
        let place = corner + vec2(0.0, SIDE * index as f32);
        let button = Rect::from_min_size(place, Vec2::splat(SIDE)).shrink(1.0);
        let command = tool.command();
        let response = ui.interact(button, ui.scope_id().with(command.label()), Sense::click());
        let is_active = tool == active;
        let label = command.label();
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, ui.is_enabled(), is_active, label)
        });
        let visuals = ui.style().interact_selectable(&response, is_active);
        if is_active {
            ui.painter().rect_filled(button, 5.0, theme::ACCENT);
        } else if response.hovered() || response.has_focus() {
            let fill = visuals.weak_bg_fill;
            ui.painter().rect_filled(button, 5.0, fill);
        }
        let ink = if is_active {
            theme::ON_ACCENT
        } else {
            visuals.text_color()
        };
        tool.paint(ui.painter(), button.center(), ink);
        if response.on_hover_text(command.tooltip(ui.ctx())).clicked() {
            chosen = Some(tool);
        }
    }
    chosen
}

/// Draws the switch between axes of the world and of the part below the bar in `area`, where a tool with handles is in use; returns
/// whether it was clicked.
pub fn axes_ui(ui: &mut Ui, area: Rect, orientation: Orientation) -> bool {
    let below = SIDE * Tool::ALL.len() as f32 + 2.0 * DISTANCE;
    let corner = area.min + vec2(DISTANCE, DISTANCE + below);
    let command = Command::ToggleOwnAxes;
    let is_own = orientation == Orientation::Own;
    let text = if is_own { "own" } else { "xyz" };
    let button = egui::Button::new(egui::RichText::new(text).size(11.0)).selected(is_own);
    let place = Rect::from_min_size(corner - Vec2::splat(3.0), vec2(SIDE + 6.0, SIDE));
    let response = ui.scope(|ui| {
        // The word just fits.
        ui.spacing_mut().button_padding.x = 2.0;
        ui.put(place, button)
    });
    let response = response.inner.accessible_name(command.label());
    response.on_hover_text(command.tooltip(ui.ctx())).clicked()
}

/// Writes what the tool in use has to say into the lower right corner of `area`; returns where.
#[must_use]
pub fn note_ui(ui: &Ui, area: Rect, lines: &[String]) -> Rect {
    const PADDING: Vec2 = vec2(10.0, 7.0);
    let ink = Color32::from_gray(0xe8);
    let text = lines.join("\n");
    let galley = ui.painter().layout(
        text.clone(),
        egui::FontId::proportional(12.0),
        ink,
        area.width(),
    );
    let size = galley.size() + 2.0 * PADDING;
    let place = Rect::from_min_size(area.max - size - Vec2::splat(DISTANCE), size);
    let painter = ui.painter().with_clip_rect(area);
    painter.rect_filled(place, 6.0, Color32::from_black_alpha(200));
    painter.galley(place.min + PADDING, galley, ink);
    let response = ui.interact(place, ui.scope_id().with("tool note"), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
    place
}

/// Writes what the mouse is for now into the upper edge of `area`.
pub fn hint_ui(ui: &Ui, area: Rect, text: &str) {
    let painter = ui.painter().with_clip_rect(area);
    let font = egui::FontId::proportional(14.0);
    let galley = painter.layout(text.to_owned(), font, Color32::WHITE, area.width() - 24.0);
    let place = area.center_top() + vec2(-galley.size().x / 2.0, 14.0);
    let ground = Rect::from_min_size(place, galley.size()).expand2(vec2(9.0, 5.0));
    painter.rect_filled(ground, 5.0, Color32::from_black_alpha(190));
    painter.galley(place, galley, Color32::WHITE);
    let response = ui.interact(ground, ui.scope_id().with("hint"), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, text));
}
