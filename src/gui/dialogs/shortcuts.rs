//! The sheet of keys and mouse gestures. Keys come from the commands; gestures are listed here by hand.

use egui::{RichText, Ui};

use super::{buttons_ui, modal_ui};
use crate::gui::commands::Command;

/// Width of the sheet and what the window leaves around it, in points.
const LEAST_WIDTH: f32 = 480.0;
const MOST_WIDTH: f32 = 1180.0;
const AROUND: f32 = 60.0;
/// Where there is so much room, the sheet has two columns, with this gap between them.
const TWO_COLUMNS: f32 = 1000.0;
const BETWEEN: f32 = 24.0;
/// Width of the keys in one column and in each of two, and the gap beside them.
const KEYS_WIDTH: [f32; 2] = [210.0, 128.0];
const GAP: f32 = 14.0;

/// What the mouse does in the preview.
const MOUSE: [(&str, &str); 9] = [
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
        "Click, then , and .",
        "With the tool Rays: see the rays of a pixel, and of its sample before and after",
    ),
    (
        "Drop files",
        "Open scenes, meshes and saved renders; make another image the background",
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
        "Move the enlarged picture; the camera moves in the preview alone, or with Live on",
    ),
    ("Point", "See the values of the pixel, in the line below"),
    (
        "Drag the divider",
        "See more of one of two compared pictures; the arrow keys move it too",
    ),
];

/// The sheet of shortcuts; returns whether it stays.
#[must_use]
pub fn shortcuts_ui(ctx: &egui::Context) -> bool {
    let mut keys = Command::ShowShortcuts.shortcuts().iter();
    let is_asked_again =
        ctx.input(|input| keys.any(|shortcut| input.key_pressed(shortcut.logical_key)));
    let width = (ctx.content_rect().width() - AROUND).clamp(LEAST_WIDTH, MOST_WIDTH);
    let response = modal_ui(ctx, "shortcuts", width, |ui| {
        ui.heading("Keyboard and mouse");
        ui.add_space(6.0);
        let height = (ctx.content_rect().height() - 150.0).max(120.0);
        egui::ScrollArea::vertical()
            .max_height(height)
            .min_scrolled_height(height)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                ui.spacing_mut().interact_size.y = 14.0;
                ui.spacing_mut().item_spacing.y = 2.0;
                let room = ui.available_width();
                if room < TWO_COLUMNS {
                    mouse_ui(ui, KEYS_WIDTH[0]);
                    commands_ui(ui, "Keyboard", KEYS_WIDTH[0], &Command::ALL);
                    return;
                }
                // All of it is to be seen at once.
                ui.style_mut().override_font_id = Some(egui::FontId::proportional(12.5));
                // About as many lines in each.
                let mouse = MOUSE.len() + MOUSE_OVER_PICTURE.len();
                let (left, right) = Command::ALL.split_at((Command::ALL.len() - mouse) / 2);
                ui.horizontal_top(|ui| {
                    let width = (room - BETWEEN) / 2.0;
                    let column = egui::vec2(width, 0.0);
                    let layout = egui::Layout::top_down(egui::Align::Min);
                    ui.allocate_ui_with_layout(column, layout, |ui| {
                        ui.set_width(width);
                        mouse_ui(ui, KEYS_WIDTH[1]);
                        commands_ui(ui, "Keyboard", KEYS_WIDTH[1], left);
                    });
                    ui.add_space(BETWEEN - ui.spacing().item_spacing.x);
                    ui.allocate_ui_with_layout(column, layout, |ui| {
                        ui.set_width(width);
                        commands_ui(ui, "Keyboard, continued", KEYS_WIDTH[1], right);
                    });
                });
            });
        buttons_ui(ui, |ui| ui.button("Close").clicked())
    });
    !(response.inner || response.should_close() || is_asked_again)
}

fn mouse_ui(ui: &mut Ui, keys_width: f32) {
    title_ui(
        ui,
        "Mouse, in the preview, and in the whole picture with Live on",
    );
    for (keys, what) in MOUSE {
        line_ui(ui, keys_width, keys, what);
    }
    title_ui(ui, "Mouse, over other pictures");
    for (keys, what) in MOUSE_OVER_PICTURE {
        line_ui(ui, keys_width, keys, what);
    }
}

fn commands_ui(ui: &mut Ui, title: &str, keys_width: f32, commands: &[Command]) {
    title_ui(ui, title);
    for command in commands {
        let keys: Vec<_> = command.shortcut_texts(ui.ctx()).collect();
        line_ui(ui, keys_width, &keys.join(",  "), command.description());
    }
}

fn title_ui(ui: &mut Ui, title: &str) {
    ui.add_space(4.0);
    ui.label(RichText::new(title).weak());
}

fn line_ui(ui: &mut Ui, keys_width: f32, keys: &str, what: &str) {
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        ui.allocate_ui_with_layout(
            egui::vec2(keys_width, 0.0),
            egui::Layout::top_down(egui::Align::Min),
            |ui| {
                ui.set_width(keys_width);
                ui.add(egui::Label::new(RichText::new(keys).strong()).wrap());
            },
        );
        ui.add(egui::Label::new(what).wrap());
    });
}
