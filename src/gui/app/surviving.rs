//! Going on when the graphics device is lost: the driver crashed or was updated, the card was unplugged or slept too long.
//!
//! What was on the device is gone, and so is the window that it drew. Nothing else is: the scene, its steps to undo, all renders and the
//! one that runs are in memory, and go on in a new window. Drawing with a lost device panics inside eframe; [`start`](crate::gui::start)
//! catches that, and the app moves to a new window.

use std::time::{Duration, Instant};

use super::{App, PreparedState};
use crate::gui::balls::Balls;
use crate::gui::contributions::Contributions;
use crate::gui::jobs::Lane;
use crate::gui::preview_image::PreviewImage;
use crate::gui::start::Survivor;
use crate::gui::theme;

impl App {
    /// Has the graphics device shut down, as a driver that fails does: to measure how that is survived.
    pub fn lose_device(&self) {
        if let Some(preview) = &self.preview {
            preview.device().destroy();
        }
    }
}

impl Survivor for App {
    fn ask_driver(&self) {
        if let Some(preview) = &self.preview {
            preview.ask_driver();
        }
    }

    fn loss(&self) -> Option<String> {
        self.preview.as_ref()?.loss()
    }

    fn move_to(&mut self, creation: &eframe::CreationContext<'_>, loss: &str) {
        let ctx = &creation.egui_ctx;
        theme::install(ctx);
        self.jobs.set_window(ctx.clone());
        let render_state = creation.wgpu_render_state.as_ref();
        self.preview = render_state.map(|state| PreviewImage::new(state, ctx));
        // What was uploaded is brought to the new device: see `lacks_upload`.
        if let Some(state) = self.prepared.take() {
            let placed = state
                .placed
                .on(self.preview.as_ref().map(PreviewImage::device_number));
            self.prepared = Some(PreparedState { placed, ..state });
        }
        if self.works_in(Lane::Prepare) {
            self.jobs.cancel(Lane::Prepare);
            self.preparing = None;
        }
        self.unwanted_preparation = None;
        self.viewport.release();
        self.title.clear();
        self.balls = Balls::default();
        self.jobs.cancel(Lane::Balls);
        self.jobs.cancel(Lane::Contributions);
        self.contributions = Contributions::default();
        self.renders.move_to(ctx);
        if let Some(picture) = &mut self.picture {
            picture.hide();
        }
        if let Some(picture) = self.shown_picture_mut() {
            picture.hide();
        }
        if let Some(comparison) = &mut self.comparison {
            comparison.hide();
        }
        self.show_pixels_again();
        self.encode_other();
        let text = format!(
            "The driver says: {loss}.\nThe window was opened anew, and everything is still here: the scene, what can be undone, all renders. One \
             that ran went on."
        );
        self.messages.warning("The graphics device was lost", text);
    }

    fn give_up(&mut self) {
        // What is being written may be older than what is here.
        let ctx = egui::Context::default();
        let end = Instant::now() + Duration::from_secs(5);
        while self.jobs.is_busy(Lane::Keep) && Instant::now() < end {
            self.jobs
                .wait_for(Lane::Keep, end.saturating_duration_since(Instant::now()));
            self.take_news(&ctx);
        }
        self.keep_work_at_once(&ctx);
        if let Some(session) = self.keeping.session() {
            session.leave();
        }
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui_wgpu::RendererOptions;
    use egui_kittest::Harness;
    use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};

    use super::*;
    use crate::gui::app::{AppOptions, FileDialogs};

    /// Goes on until the scene is prepared and drawn as far as that takes no frame.
    fn settle(app: &mut App, ctx: &egui::Context) {
        let deadline = Instant::now() + Duration::from_mins(1);
        while app.is_settling() {
            assert!(Instant::now() < deadline, "it does not settle");
            app.take_news(ctx);
            app.update_background_work();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_lost_device_takes_nothing_with_it_but_what_was_on_it() {
        let mut harness = Harness::builder()
            .with_size([1280.0, 800.0])
            .wgpu()
            .build_eframe(|creation| {
                let options = AppOptions {
                    file_dialogs: FileDialogs::PathField,
                    ..AppOptions::default()
                };
                App::new(creation, options)
            });
        let ctx = harness.ctx.clone();
        settle(harness.state_mut(), &ctx);
        harness.state_mut().document_mut().scene.camera.eye.x += 1.0;
        harness.run_steps(3);
        let app = harness.state_mut();
        let scene = app.document().scene.clone();
        let undo = app.document().undo_history().next_undo().map(str::to_owned);
        assert!(undo.is_some() && app.loss().is_none());

        app.lose_device();
        let deadline = Instant::now() + Duration::from_mins(1);
        let loss = loop {
            app.ask_driver();
            if let Some(loss) = app.loss() {
                break loss;
            }
            assert!(Instant::now() < deadline, "the driver does not tell");
            std::thread::sleep(Duration::from_millis(2));
        };
        let mut creation = eframe::CreationContext::_new_kittest(egui::Context::default());
        let state = create_render_state(default_wgpu_setup(), RendererOptions::default());
        creation.wgpu_render_state = Some(state);
        app.move_to(&creation, &loss);
        assert!(app.loss().is_none() && app.is_settling());
        settle(app, &creation.egui_ctx);

        assert_eq!(app.document().scene, scene);
        let history = app.document().undo_history();
        assert_eq!(history.next_undo().map(str::to_owned), undo);
        let preview = app.preview.as_mut().expect("there is a device");
        let placed = &app.prepared.as_ref().expect("it is placed").placed;
        assert_eq!(placed.device, Some(preview.device_number()));
        let triangles = placed.triangles.as_ref().expect("they are brought there");
        assert!(preview.show(&scene, triangles, None, [64, 48]).is_some());
        assert_eq!(preview.take_faults(), Vec::<String>::new());
        let message = app.messages().banners().first().expect("it is told");
        assert!(message.text.contains(&loss), "{message:?}");
    }
}
