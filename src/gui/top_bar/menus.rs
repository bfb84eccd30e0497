//! The menus of the top bar.

use std::path::{Path, PathBuf};

use egui::{Button, RichText, Ui, Vec2};

use super::{Asked, EditState, Recent, TopBarState, View};
use crate::gui::commands::Command;
use crate::gui::tool::Tool;
use crate::gui::widgets::faint_text;

/// Height of the window that a menu leaves, in points.
const ROOM_AROUND: f32 = 60.0;
/// Room for the mark before what is on, in points.
const MARK_WIDTH: f32 = 14.0;

/// All of them.
pub(super) fn menus_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Asked) {
    let Asked {
        commands: asked,
        recent,
    } = asked;
    egui::MenuBar::new().ui(ui, |ui| {
        ui.spacing_mut().button_padding = Vec2::new(10.0, 4.0);
        ui.menu_button("File", |ui| {
            menu_item_ui(ui, state, Command::Open, asked);
            recent_ui(ui, state.recent, recent);
            for command in [Command::AddMesh, Command::SetBackground] {
                menu_item_ui(ui, state, command, asked);
            }
            ui.separator();
            for command in [Command::SaveScene, Command::SaveSceneAs] {
                menu_item_ui(ui, state, command, asked);
            }
            ui.separator();
            menu_item_ui(ui, state, Command::SavePicture, asked);
            ui.separator();
            menu_item_ui(ui, state, Command::Quit, asked);
        });
        ui.menu_button("Edit", |ui| {
            for command in [Command::Undo, Command::Redo] {
                menu_item_ui(ui, state, command, asked);
            }
            ui.separator();
            for command in [
                Command::Copy,
                Command::Paste,
                Command::Duplicate,
                Command::Rename,
                Command::Remove,
            ] {
                menu_item_ui(ui, state, command, asked);
            }
            ui.separator();
            for tool in Tool::ALL {
                menu_item_ui(ui, state, tool.command(), asked);
            }
            menu_item_ui(ui, state, Command::ToggleOwnAxes, asked);
        });
        ui.menu_button("View", |ui| {
            // It is longer than a small window is high.
            let room = ui.ctx().content_rect().height() - ROOM_AROUND;
            egui::ScrollArea::vertical()
                .max_height(room)
                .min_scrolled_height(room)
                .show(ui, |ui| view_menu_ui(ui, state, asked));
        });
        let menu = ui.menu_button("Render", |ui| render_menu_ui(ui, state, asked));
        // The button that renders is called Render too.
        menu.response.accessible_name("Render menu");
        ui.menu_button("Help", |ui| {
            menu_item_ui(ui, state, Command::ShowShortcuts, asked);
            ui.separator();
            ui.label(RichText::new(concat!("RayMini ", env!("CARGO_PKG_VERSION"))).weak());
        });
    });
}

fn render_menu_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    for command in [
        Command::Render,
        Command::ToggleLive,
        Command::TogglePause,
        Command::Cancel,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [Command::DrawRegion, Command::ClearRegion] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [
        Command::EstimateTime,
        Command::Report,
        Command::MeasureCosts,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
}

/// What the menu View holds.
fn view_menu_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    for command in [
        Command::FrameAll,
        Command::FrameSelected,
        Command::ResetCamera,
        Command::TurnUp,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [
        Command::AddBookmark,
        Command::NextBookmark,
        Command::PreviousBookmark,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [
        Command::ShowPreview,
        Command::ShowPicture,
        Command::TogglePanel,
        Command::ToggleErrorPlot,
        Command::ToggleRenders,
        Command::ToggleTiles,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [
        Command::ShowWhole,
        Command::ShowFullSize,
        Command::Enlarge,
        Command::Reduce,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    for command in [
        Command::ShowOlderRender,
        Command::ShowNewerRender,
        Command::Compare,
        Command::CompareFile,
        Command::Flip,
    ] {
        menu_item_ui(ui, state, command, asked);
    }
    ui.separator();
    theme_ui(ui);
}

fn menu_item_ui(ui: &mut Ui, state: TopBarState<'_>, command: Command, asked: &mut Vec<Command>) {
    let is_on = match command {
        Command::ShowPreview => Some(state.view == View::Preview),
        Command::ShowPicture => Some(state.view == View::Picture),
        Command::TogglePanel => Some(state.panel_open),
        Command::ToggleErrorPlot => Some(state.error_plot_open),
        Command::ToggleRenders => Some(state.renders_open),
        Command::ToggleTiles => Some(state.are_tiles_outlined),
        Command::ToggleLive => Some(state.is_live),
        Command::ToggleOwnAxes => Some(state.has_own_axes),
        Command::DrawRegion => Some(state.is_drawing_region),
        Command::Compare => Some(state.is_comparing),
        other => Tool::chosen_by(other).map(|tool| tool == state.tool),
    };
    let label = match (command, state.edit) {
        (
            Command::Undo,
            EditState {
                undo: Some(name), ..
            },
        )
        | (
            Command::Redo,
            EditState {
                redo: Some(name), ..
            },
        ) => {
            format!("{} {name}", command.label())
        }
        (Command::TogglePause, _) => state.pause_label().to_owned(),
        _ => command.label().to_owned(),
    };
    // What is on has a check mark; all names begin below each other.
    let mark = RichText::new(if is_on == Some(true) { "✔" } else { "" });
    let mark = egui::AtomExt::atom_size(mark, Vec2::new(MARK_WIDTH, 0.0));
    let button = Button::new((mark, &*label))
        .wrap_mode(egui::TextWrapMode::Extend)
        .right_text(faint_text(ui, command.shortcut_text(ui.ctx()), false));
    let response = ui
        .add_enabled(state.allows(command), button)
        .accessible_name(&*label)
        .on_hover_text(command.description())
        .on_disabled_hover_text(state.why_not(command));
    if let Some(is_on) = is_on {
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, response.enabled(), is_on, &label)
        });
    }
    if response.clicked() {
        asked.push(command);
        ui.close();
    }
}

/// The files opened last.
fn recent_ui(ui: &mut Ui, paths: &[PathBuf], asked: &mut Option<Recent>) {
    ui.add_enabled_ui(!paths.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for path in paths {
                let name = path.file_name().unwrap_or(path.as_os_str());
                let folder = path.parent().and_then(Path::file_name).unwrap_or_default();
                let response = ui
                    .add(
                        Button::new(name.to_string_lossy())
                            .right_text(RichText::new(folder.to_string_lossy()).weak()),
                    )
                    .accessible_name(format!("Open {}", name.display()))
                    .on_hover_text(path.display().to_string());
                if response.clicked() {
                    *asked = Some(Recent::Open(path.clone()));
                    ui.close();
                }
            }
            ui.separator();
            let forget = ui.button("Clear the list");
            let forget = forget.on_hover_text("Forget these names; the files stay");
            if forget.clicked() {
                *asked = Some(Recent::Forget);
                ui.close();
            }
        })
        .response
        .on_disabled_hover_text("Nothing was opened or saved yet");
    });
}

fn theme_ui(ui: &mut Ui) {
    let mut preference = ui.ctx().options(|options| options.theme_preference);
    let before = preference;
    for (value, name) in [
        (egui::ThemePreference::System, "Colours of the desktop"),
        (egui::ThemePreference::Dark, "Dark"),
        (egui::ThemePreference::Light, "Light"),
    ] {
        ui.radio_value(&mut preference, value, name);
    }
    if preference != before {
        ui.ctx().set_theme(preference);
    }
}
