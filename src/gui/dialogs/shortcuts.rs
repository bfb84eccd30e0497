use egui::{RichText, Ui};

use super::{buttons_ui, modal_ui};
use crate::gui::commands::Command;

/// Width of the sheet, what the window leaves around it, that of the keys, and the gap beside those, in points.
const LEAST_WIDTH: f32 = 480.0;
const MOST_WIDTH: f32 = 900.0;
const AROUND: f32 = 90.0;
const KEYS_WIDTH: f32 = 210.0;
const GAP: f32 = 18.0;

/// What the mouse does in the preview.
const MOUSE: [(&str, &str); 8] = [
    ("Drag", "Orbit about the target"),
    (
        "Shift + drag, middle or right drag",
        "Pan: the point under the mouse follows",
    ),
    ("Scroll, pinch", "Zoom about the point under the mouse"),
    ("Click", "Select the object or light"),
    ("Double click", "Orbit about this point from now on"),
    ("Drag a light's marker", "Move the light, at its distance"),
    (
        "Drag a handle",
        "Move, turn or scale what is selected; Ctrl snaps, X Y Z keep to an axis",
    ),
    (
        "Drop files",
        "Open scenes and meshes; make an image the background",
    ),
];

/// What it does over a picture.
const MOUSE_OVER_PICTURE: [(&str, &str); 4] = [
    (
        "Scroll, pinch",
        "Enlarge the picture about the point under the mouse",
    ),
    (
        "Drag",
        "Move the enlarged picture; orbit, in the preview, while all of it is seen",
    ),
    ("Point", "See the values of the pixel, in the line below"),
    (
        "Drag the divider",
        "See more of one of two compared pictures",
    ),
];

/// The sheet of shortcuts; returns whether it stays.
#[must_use]
pub fn shortcuts_ui(ctx: &egui::Context) -> bool {
    let width = (ctx.content_rect().width() - AROUND).clamp(LEAST_WIDTH, MOST_WIDTH);
    let response = modal_ui(ctx, "shortcuts", width, |ui| {
        ui.heading("Keyboard and mouse");
        ui.add_space(6.0);
        let height = (ctx.content_rect().height() - 190.0).max(120.0);
        egui::ScrollArea::vertical()
            .max_height(height)
            .min_scrolled_height(height)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                ui.spacing_mut().interact_size.y = 18.0;
                group_ui(
                    ui,
                    "Mouse, in the preview, and in the whole picture with Live on",
                    |ui| {
                        for (keys, what) in MOUSE {
                            line_ui(ui, keys, what);
                        }
                    },
                );
                group_ui(ui, "Mouse, over other pictures", |ui| {
                    for (keys, what) in MOUSE_OVER_PICTURE {
                        line_ui(ui, keys, what);
                    }
                });
                group_ui(ui, "Keyboard", |ui| {
                    for command in Command::ALL {
                        let keys: Vec<_> = command.shortcut_texts(ctx).collect();
                        line_ui(ui, &keys.join(",  "), command.description());
                    }
                });
            });
        buttons_ui(ui, |ui| ui.button("Close").clicked())
    });
    !(response.inner || response.should_close())
}

fn group_ui(ui: &mut Ui, title: &str, lines: impl FnOnce(&mut Ui)) {
    ui.add_space(6.0);
    ui.label(RichText::new(title).weak());
    egui::Grid::new(title)
        .num_columns(2)
        .min_col_width(KEYS_WIDTH)
        .max_col_width(ui.available_width() - KEYS_WIDTH - GAP)
        .spacing([GAP, 4.0])
        .show(ui, lines);
}

fn line_ui(ui: &mut Ui, keys: &str, what: &str) {
    ui.label(RichText::new(keys).strong());
    ui.add(egui::Label::new(what).wrap());
    ui.end_row();
}
