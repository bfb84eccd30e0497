use egui::Ui;

use crate::gui::widgets::{Number, combo_row_ui, light_row_ui, vector_row_ui};
use crate::scene::{Background, Rgb, Scene};

const UNIT: &str = " W/m²/sr";

/// The background's properties.
pub fn background_ui(ui: &mut Ui, scene: &mut Scene) {
    let mut is_gradient = matches!(scene.background, Background::Gradient { .. });
    let was_gradient = is_gradient;
    combo_row_ui(
        ui,
        "Kind",
        "What rays see that hit nothing; it also lights the scene",
        &mut is_gradient,
        &[
            (false, "One radiance".to_owned()),
            (true, "Sky and ground".to_owned()),
        ],
    );
    if is_gradient != was_gradient {
        scene.background = converted(&scene.background, scene.camera.up);
    }
    if let Background::Image { image, .. } = &scene.background {
        ui.label(image);
    }
    match &mut scene.background {
        Background::Image { .. } => {}
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
            let before = *up;
            vector_row_ui(
                ui,
                "Up",
                "The direction of the zenith; any length",
                up,
                &Number::any(0.01),
            );
            if up.try_normalize().is_none() {
                *up = before;
            }
        }
    }
}

/// The background of the other kind that looks most alike.
fn converted(background: &Background, up: crate::math::DVec3) -> Background {
    match *background {
        Background::Constant { radiance } => Background::Gradient {
            zenith: radiance,
            horizon: radiance,
            ground: radiance * Rgb::splat(0.5),
            up,
        },
        Background::Gradient { horizon, .. } => Background::Constant { radiance: horizon },
        Background::Image { .. } => Background::default(),
    }
}
