//! The bar at the top: menus, what the central area shows, and the one button that matters.

mod menus;

use std::path::PathBuf;
use std::time::Duration;

use egui::{Align, Button, Layout, RichText, Ui, Vec2};

use super::commands::Command;
use super::theme;
use super::time_estimate::{in_short, in_words};
use super::tool::Tool;
use super::widgets::primary_button;
use crate::analysis::pilot::TimeEstimate;

/// Width of the menus, in points.
const MENUS_WIDTH: f32 = 282.0;

/// What the central area shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum View {
    /// The live preview.
    #[default]
    Preview,
    /// The rendered picture.
    Picture,
}

/// Where the work stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// There is no scene to render.
    Empty,
    /// There is one.
    Ready,
    /// It is being rendered, or about to.
    Rendering,
    /// A report is being made: nothing can be rendered beside it.
    Reporting,
}

/// What the bar needs to know.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is true or false whatever the others are"
)]
pub struct TopBarState<'a> {
    /// What the central area shows.
    pub view: View,
    /// What Render would do.
    pub phase: Phase,
    /// What the mouse does in the preview.
    pub tool: Tool,
    /// Whether handles go along the axes of the part itself.
    pub has_own_axes: bool,
    /// Whether cameras were remembered.
    pub has_bookmarks: bool,
    /// Whether the picture follows every change.
    pub is_live: bool,
    /// Whether something goes on that can be stopped.
    pub can_cancel: bool,
    /// Whether a render is under way that can rest.
    pub can_pause: bool,
    /// Whether it rests.
    pub is_paused: bool,
    /// Whether the render that ended can go on with its samples.
    pub can_continue: bool,
    /// What a render of the scene as it is takes, where that is known.
    pub time: Option<TimeEstimate>,
    /// Whether that is being found out.
    pub is_estimating_time: bool,
    /// Whether it can be found out now.
    pub can_estimate_time: bool,
    /// Whether every value of the scene is one that can be rendered.
    pub is_valid: bool,
    /// Whether the mouse draws the region to render.
    pub is_drawing_region: bool,
    /// Whether only a part of the picture is rendered.
    pub has_region: bool,
    /// Whether costs are being measured.
    pub is_measuring: bool,
    /// Whether there is a picture to look at and save.
    pub has_picture: bool,
    /// Whether the side panel shows.
    pub panel_open: bool,
    /// Whether the error plot shows.
    pub error_plot_open: bool,
    /// Whether the renders of this session show.
    pub renders_open: bool,
    /// Whether the tiles that are being rendered are outlined.
    pub are_tiles_outlined: bool,
    /// Whether there is something to compare the shown picture with, or that is done.
    pub can_compare: bool,
    /// Whether a picture is on the screen.
    pub is_picture_shown: bool,
    /// Whether two pictures are compared.
    pub is_comparing: bool,
    /// Whether there are renders to look at.
    pub has_renders: bool,
    /// Whether the scene has unsaved changes.
    pub modified: bool,
    /// What the menu Edit offers.
    pub edit: EditState<'a>,
    /// The files opened last, newest first.
    pub recent: &'a [PathBuf],
}

/// What was asked for in the bar.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// By name.
    pub commands: Vec<Command>,
    /// About the files opened last.
    pub recent: Option<Recent>,
}

/// What can be asked for about the files opened last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Recent {
    /// Open this one.
    Open(PathBuf),
    /// Empty the list.
    Forget,
}

/// What can be edited now.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is true or false whatever the others are"
)]
pub struct EditState<'a> {
    /// What undoing takes back, such as "moving the camera".
    pub undo: Option<&'a str>,
    /// What redoing does again.
    pub redo: Option<&'a str>,
    /// Whether a part that there may be several of is selected.
    pub can_copy: bool,
    /// Whether the selected part has a name to change.
    pub can_rename: bool,
    /// Whether the selected part may go.
    pub can_remove: bool,
    /// Whether something was copied.
    pub can_paste: bool,
}

impl TopBarState<'_> {
    /// Whether `command` can be asked for now.
    #[must_use]
    pub fn allows(self, command: Command) -> bool {
        match command {
            Command::SavePicture | Command::ShowPicture | Command::CompareFile => self.has_picture,
            Command::Compare => self.can_compare,
            Command::NextBookmark | Command::PreviousBookmark => self.has_bookmarks,
            Command::Flip => self.is_comparing,
            Command::ShowWhole | Command::ShowFullSize | Command::Enlarge | Command::Reduce => {
                self.is_picture_shown
            }
            Command::ShowOlderRender | Command::ShowNewerRender => self.has_renders,
            Command::Cancel => self.can_cancel,
            Command::TogglePause => self.can_pause,
            Command::Continue => self.can_continue,
            Command::ClearRegion => self.has_region,
            Command::EstimateTime => self.can_estimate_time,
            Command::Render => {
                self.is_valid && matches!(self.phase, Phase::Ready | Phase::Rendering)
            }
            Command::ToggleLive => matches!(self.phase, Phase::Ready | Phase::Rendering),
            Command::DrawRegion => self.phase != Phase::Empty,
            Command::Report => self.is_valid && self.phase != Phase::Empty,
            Command::MeasureCosts => self.is_valid && self.phase == Phase::Ready,
            Command::Undo => self.edit.undo.is_some(),
            Command::Redo => self.edit.redo.is_some(),
            Command::Copy | Command::Duplicate => self.edit.can_copy,
            Command::Paste => self.edit.can_paste,
            Command::Rename => self.edit.can_rename,
            Command::Remove => self.edit.can_remove,
            _ => true,
        }
    }

    /// What pausing is called now.
    fn pause_label(self) -> &'static str {
        if self.is_paused { "Resume" } else { "Pause" }
    }

    /// Whether a render or a report goes on.
    fn is_busy(self) -> bool {
        matches!(self.phase, Phase::Rendering | Phase::Reporting)
    }

    /// Why `command` cannot be asked for now, where it cannot.
    #[must_use]
    pub fn why_not(self, command: Command) -> &'static str {
        match command {
            Command::SavePicture | Command::ShowPicture | Command::CompareFile => {
                "There is no picture yet: press Render"
            }
            Command::NextBookmark | Command::PreviousBookmark => "No camera was remembered yet",
            Command::Compare => "It takes two renders to compare",
            Command::Flip => "No pictures are compared",
            Command::ShowWhole | Command::ShowFullSize | Command::Enlarge | Command::Reduce => {
                "No picture is on the screen"
            }
            Command::ShowOlderRender | Command::ShowNewerRender => "Nothing was rendered yet",
            Command::TogglePause if self.phase == Phase::Rendering => {
                "The scene is still being prepared"
            }
            Command::TogglePause => "Nothing is rendered now",
            Command::Continue => {
                "There is no render that was cancelled, or may take more samples or time than it took"
            }
            Command::Cancel => "Nothing goes on that could be stopped",
            Command::EstimateTime if self.phase == Phase::Rendering || self.is_measuring => {
                "Something is rendered or measured now, which would spoil it"
            }
            Command::EstimateTime if self.phase == Phase::Ready && self.is_valid => {
                "The scene is not prepared yet"
            }
            Command::ClearRegion => "All of the picture is rendered",
            Command::Undo => "Nothing was edited yet",
            Command::Redo => "Nothing was undone",
            Command::Paste => "Nothing was copied yet",
            Command::Remove if self.edit.can_copy => {
                "An object uses this material; give the object another one first"
            }
            Command::Copy | Command::Duplicate | Command::Rename | Command::Remove => {
                "Select an object, a light or a material first"
            }
            Command::MeasureCosts if self.phase == Phase::Rendering => {
                "A render is going on, and the times would spoil each other"
            }
            _ if self.phase == Phase::Reporting => {
                "A report is being made, and a render would spoil its times"
            }
            _ if self.phase == Phase::Empty => {
                "There is nothing to render yet: open a scene or add a mesh"
            }
            _ if !self.is_valid => "The scene cannot be rendered as it is, for the reason given",
            _ => "The scene is still loading",
        }
    }
}

/// Draws the bar over the scene called `name`; returns what was asked for.
pub fn top_bar_ui(ui: &mut Ui, state: TopBarState<'_>, name: &str) -> Asked {
    let mut asked = Asked::default();
    ui.horizontal(|ui| {
        ui.set_min_height(theme::BAR_BUTTON_HEIGHT);
        ui.spacing_mut().interact_size.y = theme::BAR_BUTTON_HEIGHT;
        // A menu bar takes all the width it is given.
        let size = Vec2::new(MENUS_WIDTH, theme::BAR_BUTTON_HEIGHT);
        ui.allocate_ui(size, |ui| menus::menus_ui(ui, state, &mut asked));
        ui.add_space(10.0);
        view_switch_ui(ui, state, &mut asked.commands);
        ui.add_space(8.0);
        // Where there is no room for them, the menu View has them too.
        if ui.available_width() >= SWITCHES_WIDTH + RIGHT_WIDTH {
            switches_ui(ui, state, &mut asked.commands);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            render_button_ui(ui, state, &mut asked.commands);
            live_switch_ui(ui, state, &mut asked.commands);
            time_ui(ui, state, &mut asked.commands);
            ui.add_space(8.0);
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add_space(14.0);
                name_ui(ui, name, state.modified);
            });
        });
    });
    asked
}

/// What the scene is called, and whether it has unsaved changes.
fn name_ui(ui: &mut Ui, name: &str, modified: bool) {
    const GAP: f32 = 6.0;
    const LEAST_WIDTH: f32 = 48.0;
    let room = ui.available_width();
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = |text: &str| {
        let painter = ui.painter();
        let galley = painter.layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::WHITE);
        galley.size().x + GAP
    };
    // The words give way before the name does.
    let marks = ["• not saved", "•"].map(|mark| (mark, width(mark)));
    let fitting = marks.iter().find(|(_, width)| room - width >= LEAST_WIDTH);
    let (mark, mark_width) = *fitting.unwrap_or(&marks[1]);
    ui.spacing_mut().item_spacing.x = GAP;
    let reserved = if modified { mark_width } else { 0.0 };
    ui.scope(|ui| {
        ui.set_max_width((room - reserved).max(0.0));
        ui.add(egui::Label::new(RichText::new(name).strong()).truncate());
    });
    if modified {
        let label = ui.label(RichText::new(mark).weak());
        // Of a label, the text is the name.
        label.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, "• not saved"));
        label.on_hover_text("Not saved: the scene has changed since it was opened or saved");
    }
}

/// Preview or picture.
fn view_switch_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    ui.spacing_mut().item_spacing.x = 2.0;
    for (view, command) in [
        (View::Preview, Command::ShowPreview),
        (View::Picture, Command::ShowPicture),
    ] {
        let button = Button::new(command.label())
            .selected(state.view == view)
            .min_size(Vec2::new(76.0, theme::BAR_BUTTON_HEIGHT));
        let response = ui
            .add_enabled(state.allows(command), button)
            .on_hover_text(command.tooltip(ui.ctx()))
            .on_disabled_hover_text(state.why_not(command));
        if response.clicked() {
            asked.push(command);
        }
    }
}

/// Room for the switches of the panels at the bottom, and for what is to the right of them, in points.
const SWITCHES_WIDTH: f32 = 170.0;
const RIGHT_WIDTH: f32 = 260.0;

/// The switches of the panels at the bottom.
fn switches_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    for (command, is_open) in [
        (Command::ToggleErrorPlot, state.error_plot_open),
        (Command::ToggleRenders, state.renders_open),
    ] {
        let button = Button::new(command.label())
            .selected(is_open)
            .min_size(Vec2::new(76.0, theme::BAR_BUTTON_HEIGHT));
        let response = ui.add(button).on_hover_text(command.tooltip(ui.ctx()));
        if response.clicked() {
            asked.push(command);
        }
    }
}

/// Whether the picture follows every change.
fn live_switch_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    let command = Command::ToggleLive;
    let button = Button::new(command.label())
        .selected(state.is_live)
        .min_size(Vec2::new(52.0, theme::BAR_BUTTON_HEIGHT));
    let response = ui
        .add_enabled(state.allows(command), button)
        .on_hover_text(command.tooltip(ui.ctx()))
        .on_disabled_hover_text(state.why_not(command));
    if response.clicked() {
        asked.push(command);
    }
}

/// Room between the time and Live, in points.
const TIME_GAP: f32 = 8.0;
/// Least room that the name of the scene is left beside the time, in points.
const LEAST_NAME_WIDTH: f32 = 120.0;
/// How long the mouse rests on Render until the time is found out, in seconds.
const REST_SECONDS: f32 = 0.3;

/// How long a render will take, beside the button that starts it; a click finds out. Left out where there is no room.
fn time_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    let text = match &state.time {
        _ if state.phase != Phase::Ready => return,
        Some(time) => in_short(time),
        None if state.is_estimating_time => "…".to_owned(),
        None => "How long?".to_owned(),
    };
    let font = egui::TextStyle::Button.resolve(ui.style());
    let galley = ui
        .painter()
        .layout_no_wrap(text.clone(), font, egui::Color32::WHITE);
    if ui.available_width() < galley.size().x + TIME_GAP + LEAST_NAME_WIDTH {
        return;
    }
    let command = Command::EstimateTime;
    let explained = match &state.time {
        Some(time) => in_words(time),
        None => command.tooltip(ui.ctx()),
    };
    let button = Button::new(RichText::new(text).weak()).frame(false);
    // Right to left: away from Live.
    ui.add_space(TIME_GAP);
    let response = ui
        .add_enabled(state.time.is_some() || state.allows(command), button)
        .on_hover_text(explained)
        .on_disabled_hover_text(state.why_not(command));
    if response.clicked() {
        asked.push(command);
    }
}

/// Width of the button that renders, in points; those that stop and pause share it.
const RENDER_WIDTH: f32 = 136.0;

/// Render, or Cancel while rendering or making a report, with Pause beside it.
fn render_button_ui(ui: &mut Ui, state: TopBarState<'_>, asked: &mut Vec<Command>) {
    let spacing = ui.spacing().item_spacing.x;
    let half = (RENDER_WIDTH - spacing) / 2.0;
    // Costs that are measured give way to a render.
    if !state.is_busy() {
        let button = (primary_button("▶  Render"), RENDER_WIDTH);
        let response = bar_button_ui(ui, state, Command::Render, "Render", button, asked);
        let is_asked = state.time.is_none() && state.allows(Command::EstimateTime);
        if is_asked && response.hovered() {
            let rest = ui.input(|input| input.pointer.time_since_last_movement());
            if rest >= REST_SECONDS {
                asked.push(Command::EstimateTime);
            } else {
                let wait = Duration::from_secs_f32(REST_SECONDS - rest);
                ui.ctx().request_repaint_after(wait);
            }
        }
        return;
    }
    let text = RichText::new("Cancel").strong().color(theme::ON_ACCENT);
    let button = Button::new(text).fill(theme::STOP);
    let width = if state.phase == Phase::Rendering {
        half
    } else {
        RENDER_WIDTH
    };
    bar_button_ui(ui, state, Command::Cancel, "Cancel", (button, width), asked);
    if state.phase == Phase::Rendering {
        let label = state.pause_label();
        let button = if state.is_paused {
            primary_button(label)
        } else {
            Button::new(label)
        };
        bar_button_ui(
            ui,
            state,
            Command::TogglePause,
            label,
            (button, half),
            asked,
        );
    }
}

/// A button of the bar with its width in points, called `label`.
fn bar_button_ui(
    ui: &mut Ui,
    state: TopBarState<'_>,
    command: Command,
    label: &str,
    (button, width): (Button<'_>, f32),
    asked: &mut Vec<Command>,
) -> egui::Response {
    let size = Vec2::new(width, theme::BAR_BUTTON_HEIGHT);
    let response = ui
        .add_enabled(state.allows(command), button.min_size(size))
        .accessible_name(label)
        .on_hover_text(match &state.time {
            Some(time) if command == Command::Render => {
                format!("{}\n{}", command.tooltip(ui.ctx()), in_words(time))
            }
            _ => command.tooltip(ui.ctx()),
        })
        .on_disabled_hover_text(state.why_not(command));
    if response.clicked() {
        let clicked = egui::Id::unique("command of the bar that was clicked last");
        let before = ui.data_mut(|data| {
            let before = data.get_temp(clicked);
            data.insert_temp(clicked, command);
            before
        });
        // The second click of two on Render does not mean what has taken its place.
        let is_one_of_many = response.double_clicked() || response.triple_clicked();
        if !is_one_of_many || before == Some(command) {
            asked.push(command);
        }
    }
    response
}
