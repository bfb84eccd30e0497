//! The properties of the camera, and the bookmarks.

use egui::Ui;

use super::{PanelState, command_button_ui};
use crate::gui::commands::Command;
use crate::gui::widgets::{Number, number_row_ui, switch_row_ui, vector_row_ui};
use crate::scene::Camera;

/// The camera's properties.
pub fn camera_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let length_speed = state.length_speed();
    lens_and_place_ui(ui, &mut state.scene.camera, length_speed);
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        for (name, command) in [
            ("Pick focus", Command::FocusTool),
            ("Add bookmark", Command::AddBookmark),
        ] {
            let tooltip = command.tooltip(ui.ctx());
            command_button_ui(ui, state, name, command, &tooltip);
        }
    });
    bookmarks_ui(ui, state);
}

/// Cameras to come back to.
fn bookmarks_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let scene = &mut *state.scene;
    let mut removed = None;
    for (index, bookmark) in scene.bookmarks.iter_mut().enumerate() {
        let number = index + 1;
        ui.horizontal(|ui| {
            let field = egui::TextEdit::singleline(&mut bookmark.name).desired_width(112.0);
            ui.add(field)
                .accessible_name(format!("Name of bookmark {number}"));
            let is_here = bookmark.camera == scene.camera;
            let go = ui
                .add(egui::Button::selectable(is_here, "Go"))
                .accessible_name(format!("Go to bookmark {number}"))
                .on_hover_text("Look from here  (N goes through all)");
            if go.clicked() {
                scene.camera = bookmark.camera;
            }
            let set = ui
                .add_enabled(!is_here, egui::Button::new("Set"))
                .accessible_name(format!("Set bookmark {number}"))
                .on_hover_text("Remember the camera as it is now in place of this one");
            if set.clicked() {
                bookmark.camera = scene.camera;
            }
            let remove = ui
                .button("Remove")
                .accessible_name(format!("Remove bookmark {number}"));
            if remove.clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        scene.bookmarks.remove(index);
    }
}

/// Where the camera stands and what its lens is. `length_speed`: change of a length per point of dragging.
fn lens_and_place_ui(ui: &mut Ui, camera: &mut Camera, length_speed: f64) {
    let length = Number::any(length_speed);
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
            ..Number::within(0.001..=179.9, 0.2).with_suffix("°")
        },
    );
    let aperture = Number {
        range: 0.0..=f64::MAX,
        ..length.clone()
    };
    number_row_ui(
        ui,
        "Lens radius",
        "Radius of the lens, in scene units: 0 is a pinhole, larger blurs more of what is out of focus",
        &mut camera.aperture_radius,
        &Number {
            decimals: 4,
            speed: 0.1 * length_speed,
            ..aperture.clone()
        },
    );
    if camera.aperture_radius > 0.0 {
        let mut at_target = camera.focus_distance.is_none();
        switch_row_ui(
            ui,
            "Focus on target",
            "Keep the target sharp wherever the camera goes",
            &mut at_target,
        );
        let mut distance = camera.focus();
        if at_target {
            camera.focus_distance = None;
        } else {
            let range = f64::MIN_POSITIVE..=f64::INFINITY;
            let number = Number {
                range,
                ..length.clone()
            };
            number_row_ui(
                ui,
                "Focus distance",
                "Distance along the view at which the picture is sharp, in scene units",
                &mut distance,
                &number,
            );
            camera.focus_distance = Some(distance);
        }
    }
}
