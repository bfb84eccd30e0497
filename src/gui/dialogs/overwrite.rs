//! The question before the scene or a picture takes the place of a file.

use std::path::PathBuf;

use egui::RichText;

use super::files::FilePurpose;
use super::question::is_confirmed;
use super::{buttons_ui, modal_ui};
use crate::gui::widgets::primary_button;

/// A file that is about to be written over.
#[derive(Clone, Debug)]
pub struct Overwrite {
    /// What it is for.
    pub purpose: FilePurpose,
    /// The file.
    pub path: PathBuf,
    /// Whether it is the scene's own, and somebody else has written to it; else it is any file that is there.
    pub has_changed: bool,
}

/// What the user decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Write over it.
    Overwrite,
    /// Write to another file.
    Elsewhere,
    /// Write nothing.
    Cancel,
}

impl Overwrite {
    /// Asks; `None` while nothing is decided. Enter loses nothing.
    #[must_use]
    pub fn show_ui(&self, ctx: &egui::Context) -> Option<Choice> {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        let name = name.to_string_lossy();
        let (heading, text, overwrite, elsewhere) = if self.has_changed {
            (
                format!("Overwrite {name}?"),
                "Another program has written to it: it is not what was read or saved here last, and what it holds now would be lost.",
                "Overwrite",
                "Save as…",
            )
        } else {
            (
                format!("Replace {name}?"),
                "A file of this name is there, and what it holds would be lost.",
                "Replace",
                "Other name…",
            )
        };
        let response = modal_ui(ctx, "overwrite", 440.0, |ui| {
            ui.heading(heading);
            ui.add_space(4.0);
            ui.label(RichText::new(text).weak());
            buttons_ui(ui, |ui| {
                let mut choice = |button: egui::Button<'_>, tooltip, meaning| {
                    let response = ui.add(button).on_hover_text(tooltip);
                    response.clicked().then_some(meaning)
                };
                let (elsewhere, overwrite) =
                    (primary_button(elsewhere), egui::Button::new(overwrite));
                let elsewhere = choice(elsewhere, "Write to another file", Choice::Elsewhere);
                let overwrite = choice(overwrite, "Write to this file", Choice::Overwrite);
                let cancel = choice(egui::Button::new("Cancel"), "Write nothing", Choice::Cancel);
                elsewhere.or(overwrite).or(cancel)
            })
        });
        match response.inner {
            None if response.should_close() => Some(Choice::Cancel),
            None if is_confirmed(ctx) => Some(Choice::Elsewhere),
            choice => choice,
        }
    }
}
