//! The question that stands between unsaved work and its loss.

use egui::RichText;

use super::{Intent, buttons_ui, modal_ui};
use crate::gui::widgets::primary_button;

/// What the user decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Nothing yet.
    None,
    /// Save, then go on.
    Save,
    /// Go on; the work is lost.
    Discard,
    /// Leave everything as it is.
    Cancel,
}

/// Asks.
#[must_use]
pub fn unsaved_ui(ctx: &egui::Context, name: &str, intent: &Intent) -> Decision {
    let response = modal_ui(ctx, "unsaved", 440.0, |ui| {
        ui.heading(format!("Save the changes to {name}?"));
        ui.add_space(4.0);
        let (what, discard) = match intent {
            Intent::Open(_) | Intent::Import(_) => ("opening another scene", "Replace"),
            Intent::Close => ("closing the window", "Discard"),
        };
        ui.label(RichText::new(format!("They are lost by {what} without saving.")).weak());
        buttons_ui(ui, |ui| {
            let mut decision = Decision::None;
            let mut choice = |ui: &mut egui::Ui, button: egui::Button<'_>, tooltip, meaning| {
                let response = ui.add(button).on_hover_text(tooltip);
                if response.clicked() {
                    decision = meaning;
                }
            };
            choice(
                ui,
                primary_button("Save first"),
                "Write the scene to its file, then go on",
                Decision::Save,
            );
            choice(
                ui,
                egui::Button::new(discard),
                "Go on without saving",
                Decision::Discard,
            );
            choice(
                ui,
                egui::Button::new("Cancel"),
                "Leave everything as it is",
                Decision::Cancel,
            );
            decision
        })
    });
    match response.inner {
        Decision::None if response.should_close() => Decision::Cancel,
        decision => decision,
    }
}
