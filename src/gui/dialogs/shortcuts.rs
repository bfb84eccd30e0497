use egui::{Id, Modal, RichText, Ui};

use crate::gui::commands::Command;

/// What the mouse does in the preview.
const MOUSE: [(&str, &str); 7] = [
    ("Drag", "Orbit about the target"),
    (
        "Shift + drag, middle or right drag",
        "Pan: the point under the mouse follows",
    ),
    ("Scroll, pinch", "Zoom about the point under the mouse"),
    ("Click", "Select the object or light"),
    ("Double click", "Orbit about this point from now on"),
    ("Drag a light's marker", "Move the light, at its distance"),
    ("Drop files", "Open scenes and meshes"),
];

/// The sheet of shortcuts; returns whether it stays.
#[must_use]
pub fn shortcuts_ui(ctx: &egui::Context) -> bool {
    let response = Modal::new(Id::unique("shortcuts")).show(ctx, |ui| {
        ui.set_width(560.0);
        ui.heading("Keyboard and mouse");
        ui.add_space(8.0);
        egui::ScrollArea::vertical()
            .max_height(ctx.content_rect().height() - 170.0)
            .show(ui, |ui| {
                egui::Grid::new("shortcuts")
                    .num_columns(2)
                    .spacing([24.0, 5.0])
                    .show(ui, |ui| {
                        for (keys, what) in MOUSE {
                            line_ui(ui, keys, what);
                        }
                        ui.end_row();
                        for command in Command::ALL {
                            let keys: Vec<_> = command
                                .shortcuts()
                                .iter()
                                .map(|keys| ctx.format_shortcut(keys))
                                .collect();
                            line_ui(ui, &keys.join(",  "), command.description());
                        }
                    });
            });
        ui.add_space(8.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Button::new("Close").min_size(egui::vec2(88.0, 28.0)))
                .clicked()
        })
        .inner
    });
    !(response.inner || response.should_close())
}

fn line_ui(ui: &mut Ui, keys: &str, what: &str) {
    ui.label(RichText::new(keys).strong());
    ui.label(what);
    ui.end_row();
}
