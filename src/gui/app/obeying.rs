//! What the user asks for by menu, button or key.

use super::App;
use crate::gui::commands::Command;
use crate::gui::dialogs::Dialog;
use crate::gui::dialogs::files::FilePurpose;
use crate::gui::jobs::Lane;
use crate::gui::orbit;
use crate::gui::preview;
use crate::gui::selection::Selection;
use crate::gui::tool::Tool;
use crate::gui::top_bar::View;
use crate::math::DBounds;

impl App {
    /// Carries out what the user asked for.
    pub(super) fn carry_out(&mut self, ctx: &egui::Context, command: Command) {
        if !self.top_bar_state().allows(command) && command != Command::Cancel {
            return;
        }
        if self.viewport.is_part_held() && command != Command::Cancel {
            return;
        }
        self.document.record_edit(&self.selection);
        if self.carry_out_edit(ctx, command) {
            return;
        }
        if let Some(tool) = Tool::chosen_by(command) {
            return self.choose_tool(tool);
        }
        match command {
            Command::Open => self.ask_for_path(FilePurpose::Open),
            Command::AddMesh => self.ask_for_path(FilePurpose::AddMesh),
            Command::SetBackground => {
                self.ask_for_path(FilePurpose::SetBackground);
            }
            Command::SetTexture(texture) => {
                self.ask_for_path(FilePurpose::SetTexture(texture));
            }
            Command::ToggleOwnAxes => {
                let orientation = &mut self.viewport.orientation;
                *orientation = orientation.other();
            }
            Command::SaveScene => self.save_scene(),
            Command::SaveSceneAs => {
                self.ask_for_path(FilePurpose::SaveScene);
            }
            Command::SavePicture => {
                self.ask_for_path(FilePurpose::SavePicture);
            }
            Command::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Command::FrameAll => self.frame(&self.bounds()),
            Command::FrameSelected => self.frame(&self.selected_bounds()),
            Command::ResetCamera => {
                self.document.scene.camera = self.document.home();
                self.show_camera_view();
            }
            Command::AddBookmark => self.add_bookmark(),
            Command::NextBookmark => self.go_to_next_bookmark(1),
            Command::PreviousBookmark => self.go_to_next_bookmark(-1),
            Command::TurnUp => {
                if let Err(error) = self.document.scene.turn_surroundings() {
                    let title = "The other axis cannot be turned up";
                    self.messages.error(title, error.to_string());
                }
            }
            Command::ShowPreview => self.view = View::Preview,
            Command::ShowPicture => self.view = View::Picture,
            Command::TogglePanel => self.panel_open = !self.panel_open,
            Command::ToggleErrorPlot => self.error_plot.open = !self.error_plot.open,
            Command::ToggleRenders => self.renders.open = !self.renders.open,
            Command::ToggleTiles => {
                self.tile_outlines.are_shown = !self.tile_outlines.are_shown;
            }
            Command::ShowOlderRender | Command::ShowNewerRender => self.show_neighbour(command),
            Command::Compare => self.toggle_comparison(),
            Command::CompareFile => self.ask_for_path(FilePurpose::Compare),
            Command::Flip => self.flip(),
            Command::ShowWhole => self.zoom.fit(),
            Command::ShowFullSize => self.zoom.full(),
            Command::Enlarge => self.zoom.nearer(),
            Command::Reduce => self.zoom.farther(),
            Command::Render => self.ask_for_render(),
            Command::ToggleLive => self.toggle_live(),
            Command::TogglePause => self.toggle_pause(),
            Command::DrawRegion => self.region.toggle_drawing(),
            Command::ClearRegion => self.region.clear(),
            Command::Cancel => self.cancel(),
            Command::EstimateTime => self.estimate_time(),
            Command::Report => self.show_report(ctx),
            Command::MeasureCosts => self.measure_costs(),
            Command::ShowShortcuts => self.ask(Dialog::Shortcuts),
            _ => {}
        }
    }

    /// Moves the camera to where it sees all of `bounds`; an empty box moves nothing.
    fn frame(&mut self, bounds: &DBounds) {
        let scene = &mut self.document.scene;
        let size = preview::uniforms::picture_size(scene);
        scene.camera = orbit::frame_all(&scene.camera, size, bounds);
        self.show_camera_view();
    }

    /// Puts away the tool that draws the region, else stops what runs: a render first, else a report, else measuring, else loading. Where
    /// nothing runs, the window of the report closes, or nothing is selected any more but the camera.
    fn cancel(&mut self) {
        if self.region.is_drawing {
            self.region.stop();
        } else if self.is_rendering() {
            self.cancel_render();
            self.pass_over_edits();
        } else if self.report.is_running() {
            self.cancel_report();
        } else if self.is_measuring_costs() {
            self.cancel_measuring_costs();
        } else if self.loading.take().is_some() {
            self.jobs.cancel(Lane::Load);
            self.messages.news("Loading cancelled");
        } else if self.report.open {
            self.report.open = false;
        } else {
            self.selection = Selection::Camera;
            self.viewport.look_away();
        }
    }
}
