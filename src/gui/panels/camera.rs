use egui::Ui;

use crate::gui::widgets::{Number, number_row_ui, vector_row_ui};
use crate::scene::Camera;

/// The camera's properties. `length_speed`: change of a length per point of dragging.
pub fn camera_ui(ui: &mut Ui, camera: &mut Camera, length_speed: f64) {
    let length = Number::any(length_speed);
    let before = *camera;
    vector_row_ui(
        ui,
        "Eye",
        "Where the camera stands, in scene units",
        &mut camera.eye,
        &length,
    );
    vector_row_ui(
        ui,
        "Target",
        "The point in the middle of the picture, in scene units; orbiting turns about it",
        &mut camera.target,
        &length,
    );
    vector_row_ui(
        ui,
        "Up",
        "The direction that is up in the picture, and the axis of orbiting; any length",
        &mut camera.up,
        &Number::any(0.01),
    );
    number_row_ui(
        ui,
        "Field of view",
        "Angle over the full height of the picture, in degrees",
        &mut camera.vertical_fov.0,
        &Number {
            decimals: 2,
            ..Number::within(0.1..=175.0, 0.2).with_suffix("°")
        },
    );
    // A number typed in may leave no direction to look in; keep the last one that works.
    if camera.axes().is_none() {
        *camera = before;
    }
}
