//! The question what becomes of a scene some of whose meshes are not there.

use std::path::PathBuf;

use egui::RichText;

use super::question::is_confirmed;
use super::{buttons_ui, modal_ui};
use crate::gui::widgets::{counted, primary_button};
use crate::io::MissingMesh;

/// Meshes that are listed.
const MOST: usize = 4;

/// A scene file, and the meshes that it lacks.
#[derive(Clone, Debug)]
pub struct Missing {
    /// The scene file.
    pub path: PathBuf,
    /// At least one.
    pub meshes: Vec<MissingMesh>,
}

impl Missing {
    /// Asks. `Some(true)` to open the scene without them, `Some(false)` to leave everything as it is; `None` while nothing is decided.
    #[must_use]
    pub fn show_ui(&self, ctx: &egui::Context) -> Option<bool> {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        let response = modal_ui(ctx, "missing", 540.0, |ui| {
            let count = counted(self.meshes.len(), "mesh", "meshes");
            ui.heading(format!("{} lacks {count}", name.to_string_lossy()));
            ui.add_space(4.0);
            for MissingMesh { object, path, .. } in self.meshes.iter().take(MOST) {
                let path = path.display();
                ui.label(format!("{object}: there is no file {path}"));
            }
            if let Some(more) = self.meshes.len().checked_sub(MOST).filter(|&more| more > 0) {
                ui.label(format!("and {more} more"));
            }
            let text = "The scene can be opened without. What lacks its mesh stays in the scene, also where that is saved, and shows as soon as \
                        the file is there.";
            ui.label(RichText::new(text).weak());
            buttons_ui(ui, |ui| {
                let opens = ui
                    .add(primary_button("Open without"))
                    .on_hover_text("Open the scene, with nothing in place of these meshes");
                let cancels = ui
                    .button("Cancel")
                    .on_hover_text("Leave everything as it is");
                let opens = opens.clicked().then_some(true);
                opens.or(cancels.clicked().then_some(false))
            })
        });
        match response.inner {
            None if response.should_close() => Some(false),
            None if is_confirmed(ctx) => Some(true),
            decision => decision,
        }
    }
}
