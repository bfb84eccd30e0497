//! The properties of the background. A change of its kind keeps what the two kinds have in common.

use std::path::Path;

use egui::{Ui, Vec2};

use super::PanelState;
use crate::analysis::contributions::Contributor;
use crate::gui::commands::Command;
use crate::gui::widgets::{
    Number, combo_row_ui, light_row_ui, number_row_ui, row_ui, vector_row_ui,
};
use crate::math::{DVec3, Degrees};
use crate::scene::{Background, Rgb};

const UNIT: &str = " W/m²/sr";

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Even,
    Gradient,
    Image,
}

/// The background's properties.
pub fn background_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let is = kind_of(&state.scene.background);
    let mut wanted = is;
    combo_row_ui(
        ui,
        "Kind",
        "What rays see that hit nothing; it also lights the scene",
        &mut wanted,
        &[
            (Kind::Even, "One radiance".to_owned()),
            (Kind::Gradient, "Sky and ground".to_owned()),
            (Kind::Image, "Image".to_owned()),
        ],
    );
    if wanted != is {
        change_kind(state, wanted);
    }
    match &mut state.scene.background {
        Background::Constant { radiance } => {
            light_row_ui(
                ui,
                "Radiance",
                "The same from everywhere: colour, and amount in watts per square metre and steradian",
                radiance,
                UNIT,
            );
        }
        Background::Gradient {
            zenith,
            horizon,
            ground,
            up,
        } => {
            light_row_ui(ui, "Zenith", "Radiance straight up", zenith, UNIT);
            light_row_ui(ui, "Horizon", "Radiance at the horizon", horizon, UNIT);
            light_row_ui(ui, "Ground", "Radiance straight down", ground, UNIT);
            up_ui(ui, "The direction of the zenith; any length", up);
        }
        Background::Image {
            image,
            up,
            rotation,
            scale,
        } => {
            if file_ui(ui, image) {
                state.commands.push(Command::SetBackground);
            }
            let turn = Number {
                decimals: 1,
                ..Number::any(0.5).with_suffix("°")
            };
            let tooltip = "Turns the image about its up, counter-clockwise as seen from above";
            number_row_ui(ui, "Rotation", tooltip, &mut rotation.0, &turn);
            let factor = Number::within(0.0..=f64::MAX, (*scale * 0.01).max(0.002));
            number_row_ui(
                ui,
                "Scale",
                "Factor to the image's radiance",
                scale,
                &factor,
            );
            up_ui(ui, "The direction of the image's top; any length", up);
        }
    }
    let contributions = &mut *state.contributions;
    contributions.row_ui(
        ui,
        &Contributor::Background,
        None,
        "Of the light in the picture",
    );
}

/// The image's name as a button that asks for another; returns whether it was clicked.
fn file_ui(ui: &mut Ui, image: &str) -> bool {
    let name = Path::new(image).file_name();
    let name = name.map_or(image.into(), |name| name.to_string_lossy());
    let tooltip = format!("{image}\nClick to choose another image of all directions (.exr, .hdr)");
    let response = row_ui(ui, "Image", &tooltip, |ui| {
        let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
        ui.add(egui::Button::new(name).truncate().min_size(size))
    });
    response.clicked()
}

fn up_ui(ui: &mut Ui, tooltip: &str, up: &mut DVec3) {
    let before = *up;
    vector_row_ui(ui, "Up", tooltip, up, &Number::any(0.01));
    if up.try_normalize().is_none() {
        *up = before;
    }
}

fn kind_of(background: &Background) -> Kind {
    match background {
        Background::Constant { .. } => Kind::Even,
        Background::Gradient { .. } => Kind::Gradient,
        Background::Image { .. } => Kind::Image,
    }
}

/// Makes the background the one of the `wanted` kind that looks most alike. An image that was not loaded before is asked for;
/// until it is there, nothing changes.
fn change_kind(state: &mut PanelState<'_>, wanted: Kind) {
    let scene = &mut *state.scene;
    // What stands for the sky where there was an image: what it showed is not one colour.
    let even = Rgb::splat(0.5);
    scene.background = match (wanted, &scene.background) {
        (Kind::Image, _) => {
            let Some(image) = scene.images.keys().next().cloned() else {
                state.commands.push(Command::SetBackground);
                return;
            };
            with_image(&scene.background, image, scene.camera.up)
        }
        (Kind::Even, Background::Gradient { horizon, .. }) => {
            Background::Constant { radiance: *horizon }
        }
        (Kind::Even, _) => Background::Constant { radiance: even },
        (Kind::Gradient, background) => {
            let radiance = match background {
                Background::Constant { radiance } => *radiance,
                _ => even,
            };
            Background::Gradient {
                zenith: radiance,
                horizon: radiance,
                ground: radiance * Rgb::splat(0.5),
                up: up_of(background).unwrap_or(scene.camera.up),
            }
        }
    };
}

/// The background of this image that keeps of `background` what it can; `camera_up` where that has no up.
pub fn with_image(background: &Background, image: String, camera_up: DVec3) -> Background {
    let (rotation, scale) = match background {
        Background::Image {
            rotation, scale, ..
        } => (*rotation, *scale),
        _ => (Degrees(0.0), 1.0),
    };
    Background::Image {
        image,
        up: up_of(background).unwrap_or(camera_up),
        rotation,
        scale,
    }
}

fn up_of(background: &Background) -> Option<DVec3> {
    match *background {
        Background::Constant { .. } => None,
        Background::Gradient { up, .. } | Background::Image { up, .. } => Some(up),
    }
}
