use egui::{Label, RichText, Ui};

use crate::render::reasons;
use crate::scene::Scene;

/// What a render of the scene does, and what it leaves out and why.
pub fn plan_ui(ui: &mut Ui, scene: &Scene) {
    // A scene that cannot be rendered says so elsewhere.
    let Ok(reasons) = reasons(scene) else {
        return;
    };
    for (feature, reason) in reasons {
        let name = feature.name();
        let text = match reason {
            None => RichText::new(format!("{name}: needed")),
            Some(reason) => RichText::new(format!("{name}: left out: {reason}")).weak(),
        };
        // Wrapped, as the longest reason must not make the panel wider.
        ui.add(Label::new(text).wrap());
    }
}
