use egui::{Grid, RichText, Ui};

use crate::render::reasons;
use crate::scene::Scene;

/// What a render of the scene does, and what it leaves out and why.
pub fn plan_ui(ui: &mut Ui, scene: &Scene) {
    // A scene that cannot be rendered says so elsewhere.
    let Ok(reasons) = reasons(scene) else {
        return;
    };
    Grid::new("plan").num_columns(2).show(ui, |ui| {
        for (feature, reason) in reasons {
            let name = feature.name();
            match reason {
                None => {
                    ui.label(name);
                    ui.label("needed");
                }
                Some(reason) => {
                    ui.label(RichText::new(name).weak());
                    ui.label(RichText::new(format!("left out: {reason}")).weak());
                }
            }
            ui.end_row();
        }
    });
}
