use egui::Ui;

use super::PanelState;
use crate::gui::selection::Selection;
use crate::gui::widgets::{Number, light_row_ui, vector_row_ui};
use crate::math::{DBounds, DVec3};
use crate::scene::{Light, Rgb, Scene};

/// A light's properties.
pub fn light_ui(ui: &mut Ui, state: &mut PanelState<'_>, index: usize) {
    let length = Number::any(state.length_speed());
    let Some(Light::Point {
        position,
        intensity,
    }) = state.scene.lights.get_mut(index)
    else {
        return;
    };
    vector_row_ui(
        ui,
        "Position",
        "Where the light is, in scene units; its marker in the preview can be dragged",
        position,
        &length,
    );
    light_row_ui(
        ui,
        "Intensity",
        "Colour, and radiant intensity in watts per steradian; what arrives falls with the squared distance",
        intensity,
        " W/sr",
    );
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        if ui
            .button("Duplicate light")
            .on_hover_text("Add a light like this one at the same place")
            .clicked()
        {
            let copy = state.scene.lights[index];
            state.scene.lights.insert(index + 1, copy);
            *state.selection = Selection::Light(index + 1);
        }
        if ui
            .button("Remove light")
            .on_hover_text("Take this light out of the scene")
            .clicked()
        {
            state.scene.lights.remove(index);
            *state.selection = match state.scene.lights.len() {
                0 => Selection::Camera,
                count => Selection::Light(index.min(count - 1)),
            };
        }
    });
}

/// A light that shows: above and beside the objects on the camera's side, about as bright as a lit room.
pub fn new_light(scene: &Scene, bounds: &DBounds) -> Light {
    let (center, size) = if bounds.is_empty() {
        (DVec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.diagonal().max(f64::MIN_POSITIVE))
    };
    let up = scene.camera.up.normalize_or(DVec3::Z);
    let towards = (scene.camera.eye - center).normalize_or(DVec3::NEG_Y);
    let offset = (towards + up).normalize_or(up) * size;
    Light::Point {
        position: center + offset,
        // Irradiance 1 at the middle of the scene.
        intensity: Rgb::splat(size * size),
    }
}
