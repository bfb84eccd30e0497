use egui::Ui;

use super::PanelState;
use crate::gui::orbit;
use crate::gui::preview::uniforms::picture_size;
use crate::gui::selection::Selection;
use crate::gui::widgets::{Number, light_row_ui, vector_row_ui};
use crate::math::{DVec2, DVec3};
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

/// A light that the camera sees, up and to the right before its target, and about as bright there as a lit room.
pub fn new_light(scene: &Scene) -> Light {
    const PLACE: DVec2 = DVec2::new(0.65, 0.18);
    const DEPTH: f64 = 0.8;
    let camera = &scene.camera;
    let distance = camera.eye.distance(camera.target);
    let size = picture_size(scene);
    let place = PLACE * DVec2::new(size.width, size.height);
    let direction = orbit::view_direction(camera, size, place).unwrap_or(DVec3::ZERO);
    let position = camera.eye + direction * (distance * DEPTH);
    // Irradiance 2 at the target, for a surface that faces the light.
    let intensity = Rgb::splat(2.0 * position.distance_squared(camera.target));
    Light::Point {
        position,
        intensity,
    }
}
