//! What the user asks for by menu, button or key.

use super::App;
use crate::gui::commands::{Command, Stoppable};
use crate::gui::dialogs::Dialog;
use crate::gui::dialogs::files::FilePurpose;
use crate::gui::jobs::Lane;
use crate::gui::orbit;
use crate::gui::preview;
use crate::gui::report;
use crate::gui::selection::Selection;
use crate::gui::tool::Tool;
use crate::gui::top_bar::View;
use crate::math::DBounds;

impl App {
    /// Carries out what the user asked for.
    pub(super) fn carry_out(&mut self, ctx: &egui::Context, command: Command) {
        let state = self.top_bar_state();
        if !state.allows(command) && command != Command::Cancel {
            if command == Command::Render {
                let reason = state.why_not(command);
                self.messages.news_until_edit(reason);
            }
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
            Command::Render => self.ask_to_render(),
            Command::Continue => self.continue_render(),
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

    /// What goes on that can be stopped, the first where it is several things.
    pub(super) fn what_to_stop(&self) -> Option<Stoppable> {
        type GoesOn = fn(&App) -> bool;
        let all: [(GoesOn, Stoppable); 8] = [
            (|app| app.region.is_drawing, Stoppable::Region),
            (|app| app.waiting_render.is_some(), Stoppable::Preparing),
            (Self::is_rendering, Stoppable::Render),
            (|app| app.report.is_running(), Stoppable::Report),
            (Self::is_measuring_costs, Stoppable::Measuring),
            (|app| app.loading.is_some(), Stoppable::Loading),
            (Self::is_saving_picture, Stoppable::Saving),
            (Self::awaits_preparation, Stoppable::Preparing),
        ];
        let first = all.into_iter().find(|(goes_on, _)| goes_on(self));
        first.map(|(_, what)| what)
    }

    /// Stops `what`, where that goes on.
    pub(super) fn stop(&mut self, what: Stoppable) {
        match what {
            Stoppable::Region => self.region.stop(),
            Stoppable::Render => {
                let was_preparing = self.picture.as_ref().is_some_and(|p| p.is_preparing);
                self.cancel_render();
                self.pass_over_edits();
                // Else what it gave up would be begun again beside the picture.
                if was_preparing {
                    self.give_up_preparing();
                }
            }
            Stoppable::Report => self.cancel_report(),
            Stoppable::Measuring => self.cancel_measuring_costs(),
            Stoppable::Loading => {
                if self.loading.take().is_some() {
                    self.jobs.cancel(Lane::Load);
                    self.messages.news("Loading cancelled");
                }
            }
            Stoppable::Saving => self.cancel_saving(),
            Stoppable::Preparing => self.cancel_preparing(),
        }
    }

    /// Whether a window floats over the rest that Escape closes. What is measured in one it stops.
    pub(super) fn has_window_in_front(&self) -> bool {
        let has_report = self.report.open && !self.report.is_running();
        has_report || self.contributions.is_window_open()
    }

    /// Closes the front one of the windows that float over the rest.
    pub(super) fn close_window_in_front(&mut self, ctx: &egui::Context) {
        let has_report = self.report.open && !self.report.is_running();
        let is_report_in_front = ctx.top_layer_id() == Some(report::layer());
        if has_report && (is_report_in_front || !self.contributions.is_window_open()) {
            self.report.open = false;
        } else {
            self.contributions.close_window();
        }
    }

    /// Stops the first of what goes on. Where nothing does, nothing is selected any more but the camera.
    fn cancel(&mut self) {
        if let Some(what) = self.what_to_stop() {
            self.stop(what);
        } else {
            self.selection = Selection::Camera;
            self.viewport.look_away();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use egui::Key;
    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::gui::app::testing;

    #[test]
    fn loading_is_cancelled_beside_its_progress() {
        let mut window = testing::window(None);
        let app = window.state_mut();
        assert!(!app.top_bar_state().allows(Command::Cancel));
        let (release, wait) = channel::<()>();
        app.begin_loading("slow.off".to_owned());
        app.jobs.start(Lane::Load, move |_| {
            let _ = wait.recv();
        });
        assert!(app.top_bar_state().allows(Command::Cancel));
        window.run_steps(2);
        window.get_by_label("Cancel loading").click();
        window.run_steps(3);
        let app = window.state();
        assert!(app.loading.is_none() && !app.works_in(Lane::Load));
        assert_eq!(app.messages().last_news(), "Loading cancelled");
        assert!(!app.top_bar_state().allows(Command::Cancel));
        drop(release);
    }

    /// A render that prepares its scene itself, as those do that follow every change, takes that along when it is cancelled.
    #[test]
    fn preparing_ends_with_the_render_that_does_it() {
        let mut window = testing::window(None);
        let app = window.state_mut();
        let render = &mut app.document.scene.render;
        (render.width, render.height) = (96, 54);
        app.toggle_live();
        testing::until(&mut window, |app| !app.is_rendering() && !app.is_settling());
        let app = window.state_mut();
        let started = app.jobs_started(Lane::Prepare);
        app.document.scene.objects[0].translate.x += 0.5;
        app.ask_for_render();
        assert!(app.picture.as_ref().is_some_and(|p| p.is_preparing));
        assert_eq!(app.what_to_stop(), Some(Stoppable::Render));
        app.stop(Stoppable::Render);
        assert!(!app.works_in(Lane::Render));
        window.run_steps(5);
        let app = window.state_mut();
        assert_eq!(app.jobs_started(Lane::Prepare), started);
        assert!(app.is_live && app.what_to_stop().is_none());
        assert!(
            app.messages()
                .last_news()
                .starts_with("Preparing cancelled")
        );

        app.document.scene.objects[0].translate.x += 0.5;
        testing::until(&mut window, |app| !app.is_rendering() && !app.is_settling());
        let app = window.state();
        let picture = app.picture.as_ref().expect("there is one");
        assert_eq!(picture.scene.objects, app.document.scene.objects);
    }

    /// A cancelled preparation is not begun again on its own, but for a render and for an edit.
    #[test]
    fn preparing_is_cancelled_until_it_is_needed() {
        let mut window = testing::window(None);
        let (release, wait) = channel::<()>();
        let app = window.state_mut();
        app.prepared = None;
        app.jobs.start(Lane::Prepare, move |_| {
            let _ = wait.recv();
        });
        window.run_steps(2);
        assert!(window.query_by_label("Cancel preparing").is_some());
        let scene = window.state().document.scene.clone();
        let started = window.state().jobs_started(Lane::Prepare);
        window.key_press(Key::Escape);
        window.run_steps(5);
        let app = window.state_mut();
        assert!(!app.works_in(Lane::Prepare) && !app.is_settling());
        assert_eq!(app.jobs_started(Lane::Prepare), started);
        assert_eq!(app.document.scene, scene);
        assert!(
            app.messages()
                .last_news()
                .starts_with("Preparing cancelled")
        );

        // The render that waits goes with what it waits for.
        app.ask_for_render();
        assert_eq!(app.jobs_started(Lane::Prepare), started + 1);
        assert_eq!(app.what_to_stop(), Some(Stoppable::Preparing));
        app.stop(Stoppable::Preparing);
        assert!(app.waiting_render.is_none() && !app.works_in(Lane::Prepare));
        assert_eq!(app.what_to_stop(), None);

        app.document.scene.objects[0].translate.x += 0.5;
        testing::until(&mut window, |app| !app.is_settling());
        let app = window.state();
        assert_eq!(app.jobs_started(Lane::Prepare), started + 2);
        assert!(app.is_prepared());
        drop(release);
    }
}
