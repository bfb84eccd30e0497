//! The picture that follows every change: the preview, ray traced.
//!
//! It is coarse as long as something moves and gets finer when all rests. As long as it is looked at as a whole, the mouse does in it what it does
//! in the preview. Where only places of objects change, it does not wait for the scene to be prepared: see [`Sketch`](crate::render::Sketch).

use std::time::Duration;

use super::{App, PreparedState, WaitingRender};
use crate::control::Progress;
use crate::gui::document::{same_geometry_but_places, same_picture};
use crate::gui::jobs::Lane;
use crate::gui::picture::Picture;
use crate::gui::preview_image::PreviewImage;
use crate::gui::top_bar::View;
use crate::gui::worker::Preparation;

/// How long a frame may wait for a first look at what was edited.
const FIRST_LOOK: Duration = Duration::from_millis(80);

impl App {
    /// Has a render follow every change from now on, beginning with the scene as it is, or no longer.
    pub(super) fn toggle_live(&mut self) {
        self.is_live = !self.is_live;
        if self.is_live {
            self.hide_past_render();
            let is_there = self.picture.as_ref().is_some_and(|p| !self.is_outdated(p));
            if is_there {
                self.view = View::Picture;
                // What was passed over before is to be followed from now on.
                self.pass_over_edits();
            } else {
                self.follow_scene();
            }
        }
    }

    /// Starts a render of the scene as it is, which makes room for the next without being remembered: nobody asked for this one alone.
    pub(super) fn follow_scene(&mut self) {
        self.ask_for(WaitingRender {
            follows: true,
            ..WaitingRender::new()
        });
    }

    /// Starts a render anew whose scene was edited while it is looked at, where it runs and has not run for long, or is to follow every
    /// change. In the preview, or while another picture is looked at, editing goes on beside it, and to look at it again starts nothing. It goes
    /// on where only the rules by which it ends were edited.
    pub(super) fn restart_edited_render(&mut self) {
        let is_shown = self.view == View::Picture && self.shown_render.is_none();
        let present = self.picture.as_mut();
        if present.is_some_and(|picture| picture.note_seen(is_shown)) && !self.is_live {
            self.pass_over_edits();
        }
        let picture = self.picture.as_ref().filter(|_| is_shown);
        let can_start = self.problem().is_none() && !self.report.is_running();
        // What is edited in a pause shows in the preview, and in the picture when Render is pressed.
        let picture =
            picture.filter(|picture| !picture.is_paused() && !self.goes_on_as_it_was(picture));
        let is_followed = self.is_live && can_start && self.waiting_render.is_none();
        let file = self.document.file_number();
        let is_given_up = |p: &Picture| p.is_running() && !p.is_long() && p.file == file;
        let takes_over = |p: &Picture| p.is_running() && self.differs_in_rules_alone(p);
        let is_wanted =
            |p: &Picture| (is_given_up(p) || is_followed) && self.is_outdated(p) && !takes_over(p);
        if picture.is_some_and(is_wanted) {
            self.replace_picture();
            if self.is_live {
                self.follow_scene();
            } else {
                self.ask_for_render();
                self.messages
                    .news("Rendering anew, as the scene was edited");
            }
        }
    }

    /// Has the picture stay as it is until something else is edited, also where a render follows every change.
    pub(super) fn pass_over_edits(&mut self) {
        let part = self.wanted_part();
        if let Some(picture) = &mut self.picture {
            picture.pass_over(&self.document.scene, part);
        }
    }

    /// Whether all that was edited since `picture` began was edited beside it: while it was paused or not looked at, or before its render was
    /// cancelled.
    pub(super) fn goes_on_as_it_was(&self, picture: &Picture) -> bool {
        let passed_over = picture.passed_over();
        passed_over.is_some_and(|(scene, part)| {
            part == self.wanted_part() && same_picture(scene, &self.document.scene)
        })
    }

    /// Has the picture follow what was edited in this frame, before it is drawn. Where the processor draws the window, a frame takes longer than
    /// a first look at the scene: this waits for that rather than showing it a frame later.
    pub(super) fn follow_edits(&mut self, ctx: &egui::Context) {
        let started = self.picture.as_ref().map(Picture::started);
        self.restart_edited_render();
        self.update_background_work();
        let is_new = self.picture.as_ref().map(Picture::started) != started;
        if is_new && self.is_live && self.is_drawn_by_processor() {
            // While this waits, all cores are free for it.
            self.jobs.wait_for(Lane::Render, FIRST_LOOK);
            self.take_news(ctx);
            self.share_processor(ctx);
        }
    }

    /// Whether the picture on the screen follows every change and is seen as the camera sees the scene: as the preview is.
    pub(super) fn is_live_view(&self) -> bool {
        self.is_live
            && self.shown_render.is_none()
            && self.comparison.is_none()
            && !self.zoom.is_enlarged()
            && self.picture_on_screen().is_some()
    }

    /// Whether the scene is seen as its camera sees it: in the preview, or in the picture that follows it.
    pub(super) fn is_camera_view(&self) -> bool {
        self.picture_on_screen().is_none() || self.is_live_view()
    }

    /// Shows what the camera sees: the preview, or the picture that follows it, where that was looked at.
    pub(super) fn show_camera_view(&mut self) {
        if self.is_live && self.view == View::Picture {
            self.hide_past_render();
            self.zoom.fit();
        } else {
            self.view = View::Preview;
        }
    }

    /// Whether a picture that follows every change may start with the places of things, before the scene is prepared.
    pub(super) fn can_sketch(&self) -> bool {
        let scene = &self.document.scene;
        let known = self
            .prepared
            .as_ref()
            .and_then(|state| state.prepared.as_ref());
        let is_like = |state: &PreparedState| same_geometry_but_places(&state.scene, scene);
        self.is_live && known.is_some() && self.prepared.as_ref().is_some_and(is_like)
    }

    /// What a render needs to prepare the scene itself; from now on that counts as being prepared.
    pub(super) fn preparation(&mut self) -> Option<Preparation> {
        let placed = self.prepared.as_ref()?.placed.clone();
        self.preparing = Some(self.document.scene.clone());
        self.build_progress = Progress::new();
        Some(Preparation {
            placed,
            sketches: self.sketches.clone(),
            gpu: self.preview.as_ref().map(PreviewImage::gpu),
            progress: self.build_progress.clone(),
            is_held: self.viewport.is_part_held(),
        })
    }
}
