//! From the edited scene to a prepared one and to a picture.
//!
//! One prepare job runs at a time. While it does, further edits pile up in the scene; when it ends, the newest state is
//! prepared, if it differs. So an object that is dragged moves in the preview as often as the machine manages.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{App, PreparedState};
use crate::control::Progress;
use crate::gui::document::{same_geometry, same_image, same_picture};
use crate::gui::error_plot::name_of_render;
use crate::gui::jobs::Lane;
use crate::gui::part::Part;
use crate::gui::pick::world_bounds;
use crate::gui::picture::{Outcome, Picture};
use crate::gui::picture_buffer::PictureBuffer;
use crate::gui::preview_image::PreviewImage;
use crate::gui::threads::cores;
use crate::gui::top_bar::View;
use crate::gui::worker::{self, Placed, RenderRequest};
use crate::render::{Layer, PreparedScene, RenderProgress, RenderStats};
use crate::scene::Display;

impl App {
    /// Whether the scene's triangles and image, as they are now, have been prepared (or found impossible to prepare).
    pub(super) fn is_prepared(&self) -> bool {
        if self.document.scene.objects.is_empty() {
            return true;
        }
        self.preparing.as_ref().is_some_and(|scene| {
            same_geometry(scene, &self.document.scene) && same_image(scene, &self.document.scene)
        }) && !self.jobs.is_busy(Lane::Prepare)
    }

    /// Whether a render runs or waits for its geometry.
    pub(super) fn is_rendering(&self) -> bool {
        self.waiting_render.is_some() || self.picture.as_ref().is_some_and(Picture::is_running)
    }

    /// Starts what the scene's newest state needs.
    pub(super) fn update_background_work(&mut self) {
        if self.document.scene.objects.is_empty() {
            self.prepared = None;
            self.preparing = None;
            self.problem = None;
            self.waiting_render = None;
            return;
        }
        if self.jobs.is_busy(Lane::Prepare) || self.is_in_hand() {
            return;
        }
        if !self.is_prepared() {
            let scene = self.document.scene.clone();
            self.preparing = Some(scene.clone());
            let known = self.prepared.as_ref();
            let placed = known.map(|state| state.placed.clone());
            let prepared = known.and_then(|state| state.prepared.clone());
            let gpu = self.preview.as_ref().map(PreviewImage::gpu);
            let progress = Progress::new();
            self.build_progress = progress.clone();
            self.jobs.start(Lane::Prepare, move |job| {
                let (prepared, gpu) = (prepared.as_ref(), gpu.as_ref());
                worker::prepare(job, &scene, placed, prepared, gpu, &progress);
            });
        } else if let Some(asked) = self.waiting_render.take() {
            self.start_render(asked);
        }
    }

    /// From now on the preview shows the scene that is being prepared.
    pub(super) fn placed(&mut self, placed: Placed) {
        let bounds = world_bounds(&placed.geometry);
        let mut before = self.prepared.take();
        self.prepared = Some(PreparedState {
            placed,
            prepared: before.as_mut().and_then(|before| before.prepared.take()),
            scene: self.preparing.clone().unwrap_or_default(),
            bounds,
        });
        free(before);
    }

    pub(super) fn prepared(&mut self, result: Result<PreparedScene, String>) {
        match result {
            Ok(prepared) => {
                self.problem = None;
                if let Some(state) = &mut self.prepared {
                    let geometry = Arc::clone(prepared.geometry());
                    let geometry = std::mem::replace(&mut state.placed.geometry, geometry);
                    free((geometry, state.prepared.replace(prepared)));
                }
            }
            Err(problem) => {
                self.problem = Some(problem);
                self.waiting_render = None;
            }
        }
    }

    /// Starts a render as soon as its geometry is there; one that runs is given up.
    pub(super) fn ask_for_render(&mut self) {
        if let Some(picture) = self.picture.as_mut().filter(|p| p.is_running()) {
            picture.is_replaced = true;
            self.cancel_render();
        }
        self.cancel_measuring_costs();
        self.stop_estimating_time();
        self.messages.news("");
        self.waiting_render = Some(Instant::now());
        self.update_background_work();
    }

    fn start_render(&mut self, asked: Instant) {
        let scene = self.document.scene.clone();
        let largest = self.largest_texture();
        let part = self.wanted_part();
        let mut layers = if scene.output.layers {
            Layer::all_of(&scene)
        } else {
            Vec::new()
        };
        if !layers.is_empty() && scene.render.measures_error() {
            layers.push(Layer::Error);
        }
        let buffer = PictureBuffer::new(part, layers, scene.display, largest);
        let Some(buffer) = buffer.map(Arc::new) else {
            let text = format!(
                "A picture of {} pixels does not fit into memory. Make it smaller.",
                part.size_in_words()
            );
            self.messages.error("Cannot render", text);
            self.is_live = false;
            return;
        };
        buffer.set_shown(self.shown_layer);
        let progress = RenderProgress::default();
        let name = self.name_of_next_picture();
        let was_shown = self.view == View::Picture && self.shown_render.is_none();
        self.hide_past_render();
        let mut picture = Picture::new(
            0,
            [name, self.document.name().to_owned()],
            scene.clone(),
            Arc::clone(&buffer),
            progress.clone(),
            asked,
        );
        if let Some(mut previous) = self.picture.take() {
            if was_shown {
                picture.continue_from(&mut previous);
            }
            self.keep_render(previous);
        }
        picture.number = self.render_count + 1;
        let number = picture.number;
        let throttle = picture.throttle().clone();
        self.picture = Some(picture);
        self.view = View::Picture;

        let request = RenderRequest {
            number,
            scene,
            previous: self.prepared.as_ref().and_then(|p| p.prepared.clone()),
            primary_hits: self.primary_hits.clone(),
            threads: self.threads.count(),
            throttle,
            buffer,
            progress,
            tile_delay: self.refresh_interval(),
        };
        self.jobs.cancel(Lane::Encode);
        let freed = std::mem::take(&mut self.freed);
        self.jobs.start(Lane::Render, move |job| {
            // Before it is looked how much there is.
            drop(freed);
            worker::render(job, &request);
        });
    }

    /// What the render that starts now is called among those of this session. One that it takes the place of was none.
    fn name_of_next_picture(&self) -> String {
        let present = self.picture.as_ref().filter(|picture| !picture.is_replaced);
        let present = present.map(|picture| (picture.scene_name.as_str(), &picture.scene));
        let past = self.renders.entries().last();
        let past = past.map(|entry| (entry.facts.scene_name.as_str(), &entry.scene));
        let name = name_of_render(self.document.name(), &self.document.scene, present.or(past));
        if self.wanted_part().is_whole() {
            name
        } else {
            format!("{name}, region")
        }
    }

    /// What of the picture is rendered.
    pub(super) fn wanted_part(&self) -> Part {
        let render = &self.document.scene.render;
        self.region.part([render.width, render.height])
    }

    /// Whether a render is paused.
    pub(super) fn is_paused(&self) -> bool {
        self.picture.as_ref().is_some_and(Picture::is_paused)
    }

    /// Has the running render rest, or go on as it was: with the scene it was started with. Where it is to follow every change, it
    /// does so now.
    pub(super) fn toggle_pause(&mut self) {
        let part = self.wanted_part();
        let Some(picture) = &mut self.picture else {
            return;
        };
        if !picture.is_paused() {
            picture.pause();
        } else if self.is_live && !same_picture(&picture.scene, &self.document.scene) {
            self.ask_for_render();
        } else {
            picture.resume(&self.document.scene, part);
        }
    }

    /// Leaves a core to the user who works in the window, where that is wanted.
    pub(super) fn share_processor(&mut self, ctx: &egui::Context) {
        self.attention.note(ctx);
        let Some(picture) = self.picture.as_ref().filter(|p| p.is_running()) else {
            return;
        };
        let time_left = self.attention.time_left();
        picture.allow_threads(self.threads.allowed(cores(), time_left.is_some()));
        if let Some(time_left) = time_left.filter(|_| !picture.is_paused()) {
            ctx.request_repaint_after(time_left);
        }
    }

    /// Has a render follow every change from now on, beginning with the scene as it is, or no longer.
    pub(super) fn toggle_live(&mut self) {
        self.is_live = !self.is_live;
        if self.is_live {
            self.hide_past_render();
            let is_there = self.picture.as_ref().is_some_and(|p| !self.is_outdated(p));
            if is_there {
                self.view = View::Picture;
            } else {
                self.ask_for_render();
            }
        }
    }

    /// Starts a render anew whose scene was edited while it is looked at, where it runs or is to follow every change. In the preview,
    /// editing goes on beside it.
    pub(super) fn restart_edited_render(&mut self) {
        let is_shown = self.view == View::Picture && self.shown_render.is_none();
        let picture = self.picture.as_ref().filter(|_| is_shown);
        let can_start = self.problem.is_none() && !self.report.is_running();
        // What is edited in a pause shows in the preview, and in the picture when Render is pressed.
        let picture =
            picture.filter(|picture| !picture.is_paused() && !self.goes_on_as_it_was(picture));
        let is_followed = self.is_live && can_start && self.waiting_render.is_none();
        let is_wanted = |p: &Picture| (p.is_running() || is_followed) && self.is_outdated(p);
        if picture.is_some_and(is_wanted) {
            if let Some(picture) = &mut self.picture {
                picture.is_replaced = true;
            }
            self.ask_for_render();
        }
    }

    /// Time between two frames while a render runs and the user does nothing. Where the processor draws the window, each
    /// frame takes time from the render.
    pub(super) fn refresh_interval(&self) -> Duration {
        Duration::from_millis(if self.is_drawn_by_processor() {
            400
        } else {
            33
        })
    }

    pub(super) fn rendered(&mut self, hash: String, stats: Box<RenderStats>) {
        self.end_picture(Outcome::Finished { hash, stats });
    }

    pub(super) fn render_failed(&mut self, text: &str, is_short_of_memory: bool) {
        self.end_picture(Outcome::Failed);
        if is_short_of_memory && self.free_past_pixels() {
            return self.ask_for_render();
        }
        self.messages.error("Cannot render", text);
        if self.picture.as_ref().is_some_and(|p| p.texture().is_none()) {
            self.view = View::Preview;
        }
    }

    pub(super) fn cancel_render(&mut self) {
        self.waiting_render = None;
        self.jobs.cancel(Lane::Render);
        self.end_picture(Outcome::Cancelled);
    }

    /// Has the picture stay as it is until something else is edited, also where a render follows every change.
    pub(super) fn pass_over_edits(&mut self) {
        let part = self.wanted_part();
        if let Some(picture) = &mut self.picture {
            picture.pass_over(&self.document.scene, part);
        }
    }

    pub(super) fn end_picture(&mut self, outcome: Outcome) {
        if let Some(picture) = self.picture.as_mut().filter(|p| p.is_running()) {
            picture.end(outcome);
        }
    }

    /// Shows the picture with other display settings: they change no radiance.
    pub(super) fn show_picture_with(&mut self, display: Display) {
        let Some(picture) = self.shown_picture_mut() else {
            return;
        };
        picture.scene.display = display;
        picture.buffer.set_display(display);
        self.encode_picture();
        self.encode_other();
    }

    /// Shows a layer of the picture, or all of it.
    pub(super) fn show_layer(&mut self, layer: Option<Layer>) {
        self.shown_layer = layer;
        if let Some(picture) = self.shown_picture() {
            picture.buffer.set_shown(layer);
            self.encode_picture();
            self.encode_other();
        }
    }

    /// Has the picture that is looked at encoded anew. One that runs shows nothing before its first tile.
    pub(super) fn encode_picture(&mut self) {
        let shown = self.shown_picture();
        let shown = shown.filter(|picture| !picture.is_running() || picture.texture().is_some());
        let shown = shown.map(|picture| (picture.number, Arc::clone(&picture.buffer)));
        if let Some((number, buffer)) = shown {
            self.jobs.start(Lane::Encode, move |job| {
                worker::encode(job, number, &buffer);
            });
        }
    }

    /// Whether `picture` is of another scene than the one being edited, or of another part of it.
    pub(super) fn is_outdated(&self, picture: &Picture) -> bool {
        picture.buffer.part() != self.wanted_part()
            || !same_picture(&picture.scene, &self.document.scene)
    }

    /// Whether all that was edited since `picture` began was edited while it was paused, or the render of it was cancelled.
    fn goes_on_as_it_was(&self, picture: &Picture) -> bool {
        let passed_over = picture.passed_over();
        passed_over.is_some_and(|(scene, part)| {
            part == self.wanted_part() && same_picture(scene, &self.document.scene)
        })
    }
}

/// Gives back memory on another thread: for triangles and trees that takes longer than the window has for a frame.
fn free(what: impl Send + 'static) {
    rayon::spawn(move || drop(what));
}
