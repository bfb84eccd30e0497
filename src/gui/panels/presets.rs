//! The ball that shows what a material looks like, and a menu of common materials to take in its place.

use egui::{Rect, Sense, Ui, Vec2, vec2};

use crate::gui::balls::Balls;
use crate::gui::icons;
use crate::scene::Material;
use crate::scene::presets::materials::{self, MaterialPreset};

/// Diameter of the ball of the material that is edited, and of those on offer, in points.
const LARGE: f32 = 64.0;
const SMALL: f32 = 40.0;
/// Size of an entry of the menu, and entries beside each other.
const ENTRY: Vec2 = vec2(104.0, 66.0);
const COLUMNS: usize = 4;
/// What a new material is called.
pub const NEW_MATERIAL: &str = "material";

/// What the material called `name` looks like, and others to take in its place; returns what the one is called that was taken.
pub fn presets_ui(
    ui: &mut Ui,
    balls: &mut Balls,
    name: &str,
    material: &mut Material,
) -> Option<&'static str> {
    let mut taken = None;
    ui.horizontal(|ui| {
        let (place, response) = ui.allocate_exact_size(Vec2::splat(LARGE), Sense::hover());
        ball_ui(ui, balls, place, Some(name), material);
        response.widget_info(|| {
            let label = format!("Ball of {name}");
            egui::WidgetInfo::labeled(egui::Role::Image, true, label)
        });
        response.on_hover_text(
            "What the material looks like on a ball two units across, with all light (mode path)",
        );
        ui.add_space(4.0);
        let menu = ui.menu_button("Presets", |ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(2.0);
            egui::Grid::new("presets").spacing([2.0; 2]).show(ui, |ui| {
                for row in materials::all().chunks(COLUMNS) {
                    for preset in row {
                        if preset_ui(ui, balls, preset) {
                            *material = Material::clone(&preset.material);
                            taken = Some(preset.name);
                            ui.close();
                        }
                    }
                    ui.end_row();
                }
            });
        });
        let tooltip = "Make this material a common one; its objects stay, and so does a name that you gave it";
        menu.response
            .accessible_name("Presets of materials")
            .on_hover_text(tooltip);
    });
    ui.add_space(3.0);
    taken
}

/// Whether a material is called what nobody chose for it: as a new one or as one of the presets is, with a number or without.
pub fn has_usual_name(name: &str) -> bool {
    let base = match name.rsplit_once(' ') {
        Some((base, number)) if number.parse::<u32>().is_ok() => base,
        _ => name,
    };
    let presets = materials::all();
    let mut usual = presets.iter().map(|preset| preset.name);
    base == NEW_MATERIAL || usual.any(|usual| usual.eq_ignore_ascii_case(base))
}

/// An entry of the menu; returns whether it is chosen.
fn preset_ui(ui: &mut Ui, balls: &mut Balls, preset: &MaterialPreset) -> bool {
    let (place, response) = ui.allocate_exact_size(ENTRY, Sense::click());
    response.widget_info(|| {
        let label = format!("Preset {}", preset.name);
        egui::WidgetInfo::labeled(egui::Role::Button, ui.is_enabled(), label)
    });
    let visuals = ui.style().interact(&response);
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(place, 6.0, visuals.weak_bg_fill);
    }
    let ink = visuals.text_color();
    let middle = place.center_top() + vec2(0.0, 4.0 + SMALL / 2.0);
    let square = Rect::from_center_size(middle, Vec2::splat(SMALL));
    ball_ui(ui, balls, square, None, &preset.material);
    ui.painter().text(
        place.center_bottom() - vec2(0.0, 4.0),
        egui::Align2::CENTER_BOTTOM,
        preset.name,
        egui::FontId::proportional(11.0),
        ink,
    );
    response.on_hover_text(preset.description).clicked()
}

/// Draws the ball of a material, with an edge that is seen where it is as bright as the ground, or a disk of its colour while it is not there.
fn ball_ui(ui: &Ui, balls: &mut Balls, square: Rect, name: Option<&str>, material: &Material) {
    if let Some(texture) = balls.texture(name, material) {
        icons::ball(ui.painter(), square, texture);
    } else {
        let color = icons::color_of(material.color());
        let radius = square.width() / 2.0;
        ui.painter().circle_filled(square.center(), radius, color);
    }
    let edge = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter()
        .circle_stroke(square.center(), square.width() / 2.0, edge);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_somebody_gave_is_told_from_a_usual_one() {
        for name in ["material", "material 2", "gold", "Brushed gold", "Water 12"] {
            assert!(has_usual_name(name), "{name}");
        }
        for name in ["clear", "my gold", "material x", "12", "gold ring 2"] {
            assert!(!has_usual_name(name), "{name}");
        }
    }
}
