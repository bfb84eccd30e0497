//! From the edited scene to a prepared one and to a picture.
//!
//! One prepare job runs at a time. While it does, further edits pile up in the scene; when it ends, the newest state is
//! prepared, if it differs. So an object that is dragged moves in the preview as often as the machine manages.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::{App, PreparedState, WaitingRender};
use crate::analysis::hazards::why_black;
use crate::control::Progress;
use crate::gui::dialogs::{Dialog, question};
use crate::gui::document::{same_geometry, same_image, same_picture, same_picture_but_render};
use crate::gui::jobs::{Lane, drop_elsewhere, drop_unless_cancelled};
use crate::gui::keeping::{KeptRender, RenderAbout};
use crate::gui::part::Part;
use crate::gui::pick::world_bounds;
use crate::gui::picture::{Outcome, Picture};
use crate::gui::picture_buffer::PictureBuffer;
use crate::gui::preview::paint::same_paint;
use crate::gui::preview_image::PreviewImage;
use crate::gui::reached::TakenUp;
use crate::gui::recovering::Interrupted;
use crate::gui::threads::cores;
use crate::gui::top_bar::View;
use crate::gui::worker::{self, Placed, Preparation, RenderRequest};
use crate::render::{Layer, PreparedScene, RenderProgress, RenderStats, StopRules};
use crate::scene::{Display, Scene};

impl App {
    /// Why the scene as it is cannot be rendered.
    pub(super) fn problem(&self) -> Option<&str> {
        self.invalid.as_deref().or(self.problem.as_deref())
    }

    /// Whether the scene's triangles and images, as they are now, have been prepared (or found impossible to prepare).
    pub(super) fn is_prepared(&self) -> bool {
        if self.document.scene.objects.is_empty() || self.invalid.is_some() {
            return true;
        }
        let scene = &self.document.scene;
        let preparing = self.preparing.as_ref();
        preparing.is_some_and(|known| is_prepared_alike(known, scene))
            && !self.is_preparing()
            && !self.lacks_upload()
    }

    /// Whether preparing the scene as it is was cancelled, and nobody has asked for it since.
    pub(super) fn is_preparation_unwanted(&self) -> bool {
        let unwanted = self.unwanted_preparation.as_ref();
        unwanted.is_some_and(|scene| is_prepared_alike(scene, &self.document.scene))
    }

    /// Whether somebody waits for the scene to be prepared: a render, or who is to see the scene for the first time.
    pub(super) fn awaits_preparation(&self) -> bool {
        let known = self.prepared.as_ref();
        let is_first = known.is_none_or(|state| state.prepared.is_none());
        // Scenes are compared only where that decides.
        let is_to_come = || !self.is_prepared() && !self.is_preparation_unwanted();
        self.waiting_render.is_some() || is_first && is_to_come()
    }

    /// Gives up preparing the scene as it is, and the render that waits for it: the preview shows what was placed by now, and a render
    /// or an edit has the scene prepared again.
    pub(super) fn cancel_preparing(&mut self) {
        if self.waiting_render.is_some() {
            self.cancel_render();
            self.pass_over_edits();
        }
        self.give_up_preparing();
        if self.picture.is_none() {
            // There is none to follow every change.
            self.is_live = false;
        }
    }

    /// Has the scene as it is not prepared before that is needed, where it is not by now.
    pub(super) fn give_up_preparing(&mut self) {
        if !self.is_prepared() {
            self.jobs.cancel(Lane::Prepare);
            self.preparing = None;
            self.unwanted_preparation = Some(self.document.scene.clone());
            self.messages
                .news("Preparing cancelled: Render prepares the scene again");
        }
    }

    /// Whether the graphics device is a new one, which has nothing of the scene yet.
    fn lacks_upload(&self) -> bool {
        let has_nothing = |state: &PreparedState| state.placed.triangles.is_none();
        self.problem.is_none()
            && self.preview.is_some()
            && self.prepared.as_ref().is_some_and(has_nothing)
    }

    /// Whether a job prepares the scene: one of its own, or that of a render.
    fn is_preparing(&self) -> bool {
        let by_render = self.picture.as_ref().is_some_and(|p| p.is_preparing);
        by_render || self.jobs.is_busy(Lane::Prepare)
    }

    /// Whether a render runs or waits for its geometry.
    pub(super) fn is_rendering(&self) -> bool {
        self.waiting_render.is_some() || self.picture.as_ref().is_some_and(Picture::is_running)
    }

    /// Looks for a value that cannot be rendered.
    fn find_invalid(&mut self) {
        let scene = &self.document.scene;
        let (objects, found) = &mut self.checked_objects;
        if *objects != scene.objects {
            objects.clone_from(&scene.objects);
            *found = scene.validate_objects();
        }
        let found = scene.validate_but_objects().and(found.clone());
        self.invalid = found.err().map(|error| error.to_string());
    }

    /// Starts what the scene's newest state needs.
    pub(super) fn update_background_work(&mut self) {
        self.find_invalid();
        if self.document.scene.objects.is_empty() {
            self.jobs.cancel(Lane::Prepare);
            self.prepared = None;
            self.preparing = None;
            self.problem = None;
            self.waiting_render = None;
            return;
        }
        if self.invalid.is_some() {
            self.waiting_render = None;
            return;
        }
        if !self.is_prepared()
            && self.can_sketch()
            && let Some(asked) = self.waiting_render.take()
        {
            self.jobs.cancel(Lane::Prepare);
            let preparation = self.preparation();
            return self.start_render(asked, preparation);
        }
        if self.is_preparing() || self.is_in_hand() || self.is_preparation_unwanted() {
            return;
        }
        if !self.is_prepared() {
            self.unwanted_preparation = None;
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
            self.start_render(asked, None);
        }
    }

    /// From now on the preview shows the scene that is being prepared.
    pub(super) fn placed(&mut self, placed: Placed) {
        // The device that it was uploaded to may be lost by now.
        let placed = placed.on(self.preview.as_ref().map(PreviewImage::device_number));
        let bounds = world_bounds(&placed.geometry);
        let mut before = self.prepared.take();
        self.prepared = Some(PreparedState {
            placed,
            prepared: before.as_mut().and_then(|before| before.prepared.take()),
            scene: self.preparing.clone().unwrap_or_default(),
            bounds,
        });
        drop_elsewhere(before);
    }

    pub(super) fn prepared(&mut self, result: Result<PreparedScene, String>) {
        let by_render = self.picture.as_mut().filter(|picture| picture.is_preparing);
        if let Some(picture) = by_render {
            picture.is_preparing = false;
            if result.is_err() {
                picture.end(Outcome::Failed);
            }
        }
        match result {
            Ok(prepared) => {
                self.problem = None;
                drop_elsewhere(std::mem::take(&mut self.sketches));
                if let Some(state) = &mut self.prepared {
                    let geometry = Arc::clone(prepared.geometry());
                    let geometry = std::mem::replace(&mut state.placed.geometry, geometry);
                    drop_elsewhere((geometry, state.prepared.replace(prepared)));
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
        self.ask_for(WaitingRender::new());
    }

    /// [`Self::ask_for_render`], once nobody minds that a render which has taken long ends for it.
    pub(super) fn ask_to_render(&mut self) {
        match &self.picture {
            Some(picture) if picture.is_work_in_hand() => self.ask(Dialog::Anew(picture.number)),
            _ => self.ask_for_render(),
        }
    }

    /// Asks before another render ends the one with this number. Once that has ended by itself, it is there to be looked at.
    pub(super) fn anew_ui(&mut self, ctx: &egui::Context, number: usize) {
        let is_asked_about = |p: &&Picture| p.number == number && p.is_running();
        let Some(picture) = self.picture.as_ref().filter(is_asked_about) else {
            return;
        };
        let (share, elapsed) = (picture.progress.share(), picture.elapsed());
        match question::anew_ui(ctx, &picture.name, share, elapsed) {
            Some(true) => self.ask_for_render(),
            Some(false) => {}
            None => self.dialog = Some(Dialog::Anew(number)),
        }
    }

    pub(super) fn ask_for(&mut self, render: WaitingRender) {
        if self.picture.as_ref().is_some_and(Picture::is_running) {
            self.replace_picture();
            self.cancel_render();
        }
        self.cancel_measuring_costs();
        self.stop_estimating_time();
        self.messages.news("");
        self.unwanted_preparation = None;
        self.waiting_render = Some(render);
        self.update_background_work();
    }

    /// Takes note that another render takes the place of the present one, which is remembered where it is of another scene.
    pub(super) fn replace_picture(&mut self) {
        let file = self.document.file_number();
        if let Some(picture) = self.picture.as_mut().filter(|p| p.file == file) {
            picture.replace();
        }
    }

    /// What the render of the picture that is there leaves to the next one.
    fn taken_up(&self) -> Option<TakenUp> {
        let picture = self.picture.as_ref()?;
        let [before, now] =
            [&picture.scene, &self.document.scene].map(|scene| StopRules::of(&scene.render));
        Some(TakenUp {
            reached: picture.reached().clone(),
            has_other_rules: before != now,
        })
    }

    fn start_render(&mut self, waiting: WaitingRender, preparation: Option<Preparation>) {
        let WaitingRender {
            asked,
            interrupted,
            continues,
            follows,
        } = waiting;
        let taken_up = self.taken_up();
        let expected = self.estimated_time().filter(|_| interrupted.is_none());
        let expected = expected.filter(|estimate| !continues && !estimate.is_bound);
        let expected_samples = expected.map(|estimate| estimate.samples);
        let goes_on = interrupted.is_some();
        let (scene, part, kept) = if let Some(Interrupted { scene, kept }) = interrupted {
            let region = kept.about().region;
            let of = [scene.render.width, scene.render.height];
            let part = Part { region, of };
            self.region.choose(part);
            (scene, part, Some(kept))
        } else {
            let scene = self.document.scene.clone();
            (scene, self.wanted_part(), self.place_for_render(follows))
        };
        let buffer = PictureBuffer::new(part, layers_of(&scene), scene.display);
        let Some(buffer) = buffer.map(Arc::new) else {
            if preparation.is_some() {
                self.preparing = None;
            }
            return self.cannot_hold(part);
        };
        self.look_at(&buffer);
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
        if let Some(previous) = self.picture.take() {
            self.follow(previous, &mut picture, continues, was_shown);
        }
        // On disk there is one at a time.
        self.renders.forget_kept();
        picture.number = self.render_count + 1;
        picture.file = self.document.file_number();
        picture.is_preparing = preparation.is_some();
        if follows {
            picture.follow();
        }
        picture.why_black = why_black(&scene).ok().flatten();
        picture.expect_time(expected.map(|estimate| estimate.seconds.value));
        if goes_on {
            // What was edited beside it before, it goes on beside.
            picture.pass_over(&self.document.scene, self.wanted_part());
        }
        let is_awaited = self.is_live && self.is_drawn_by_processor();
        let first_look = is_awaited.then(|| picture.first_look.clone());
        let number = picture.number;
        let throttle = picture.throttle().clone();
        let kept = kept.map(Arc::new);
        picture.keep_in(kept.clone());
        let reading = picture.reading.clone();
        let rules = picture.rules().clone();
        let leaves = (!follows).then(|| picture.reached().clone());
        self.picture = Some(picture);
        self.view = View::Picture;

        let request = RenderRequest {
            number,
            scene,
            previous: self.prepared.as_ref().and_then(|p| p.prepared.clone()),
            preparation,
            first_look,
            primary_hits: self.primary_hits.clone(),
            threads: self.threads.count(),
            throttle,
            buffer,
            progress,
            reading,
            tile_delay: self.refresh_interval(),
            kept,
            goes_on,
            rules,
            expected_samples,
            continues: taken_up.clone().filter(|_| continues),
            reached: leaves,
        };
        self.jobs.cancel(Lane::Encode);
        let unwanted = taken_up.filter(|_| !continues);
        let freed = (
            std::mem::take(&mut self.freed),
            unwanted.map(|unwanted| unwanted.reached.take()),
        );
        self.jobs.start(Lane::Render, move |job| {
            // Before it is looked how much there is.
            drop_unless_cancelled(freed, &job.cancel);
            worker::render(job, &request);
            // What only it held takes long to be given back, on disk as in memory.
            drop_elsewhere(request);
        });
    }

    /// Lets `picture` take the place of the `previous` one, which is remembered. `continues`: with its samples; `was_shown`: on the screen.
    fn follow(
        &mut self,
        mut previous: Picture,
        picture: &mut Picture,
        continues: bool,
        was_shown: bool,
    ) {
        if continues {
            let reached = previous.reached();
            let changes = reached.leads_elsewhere(&previous.scene, &picture.scene);
            picture.continue_another(changes || previous.rules().lead_elsewhere());
        }
        // Layers have no coarse picture to begin with: tiles of this one among those of another would be two pictures.
        if was_shown && (self.shown_layer.is_none() || self.is_live) {
            picture.continue_from(&mut previous);
        }
        self.keep_render(previous);
    }

    /// There is no memory for the pixels of `part`.
    fn cannot_hold(&mut self, part: Part) {
        let text = format!(
            "A picture of {} pixels does not fit into memory. Make it smaller.",
            part.size_in_words()
        );
        self.messages.error("Cannot render", text);
        self.is_live = false;
    }

    /// Where the render that starts now is kept while it runs. One that `follows` every change is soon another.
    fn place_for_render(&self, follows: bool) -> Option<KeptRender> {
        let session = self.keeping.session().filter(|_| !follows)?;
        Some(session.place_render(RenderAbout {
            name: self.document.name().to_owned(),
            path: self.document.path().map(Path::to_owned),
            region: self.wanted_part().region,
        }))
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
            self.follow_scene();
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
        self.name_by_samples();
    }

    pub(super) fn render_failed(&mut self, text: &str, is_short_of_memory: bool) {
        self.end_picture(Outcome::Failed);
        let file = self.document.file_number();
        let is_of_other = self.picture.as_ref().is_some_and(|p| p.file != file);
        if is_short_of_memory && !is_of_other && self.free_past_pixels() {
            let failed = self.picture.as_ref();
            let continues = failed.is_some_and(|p| p.is_continued() && p.reached().is_there());
            return self.ask_for(WaitingRender {
                continues,
                ..WaitingRender::new()
            });
        }
        self.messages.error("Cannot render", text);
        if self.picture.as_ref().is_some_and(|p| !p.is_shown()) {
            self.view = View::Preview;
        }
    }

    pub(super) fn cancel_render(&mut self) {
        self.waiting_render = None;
        self.jobs.cancel(Lane::Render);
        self.end_picture(Outcome::Cancelled);
    }

    pub(super) fn end_picture(&mut self, outcome: Outcome) {
        if self.picture.as_ref().is_some_and(|p| p.is_preparing) {
            self.preparing = None;
        }
        if let Some(picture) = self.picture.as_mut().filter(|p| p.is_running()) {
            picture.end(outcome);
            if picture.may_lack_tiles() && self.shown_render.is_none() {
                self.show_pixels_again();
            }
        }
    }

    /// Shows the picture with other display settings: they change no radiance.
    pub(super) fn show_picture_with(&mut self, display: Display) {
        let Some(picture) = self.shown_picture_mut() else {
            return;
        };
        picture.scene.display = display;
        picture.buffer.set_display(display);
        self.show_pixels_again();
        self.encode_other();
    }

    /// Has the layer and the channels of a picture shown that are asked for.
    pub(super) fn look_at(&self, buffer: &PictureBuffer) {
        buffer.set_shown(self.shown_layer);
        buffer.set_channels(self.channels);
    }

    /// Shows the picture in the layer and the channels that are asked for by now.
    pub(super) fn show_picture_as_asked(&mut self) {
        if let Some(picture) = self.shown_picture() {
            self.look_at(&picture.buffer);
            self.show_pixels_again();
            self.encode_other();
        }
    }

    /// Has what there is of the picture that is looked at encoded anew. One that runs has nothing before its first tile.
    pub(super) fn show_pixels_again(&mut self) {
        let shown = self.shown_picture();
        let shown = shown.filter(|picture| !picture.is_running() || picture.first_tile.is_some());
        let shown = shown.map(|picture| (picture.number, Arc::clone(&picture.buffer)));
        if let Some((number, buffer)) = shown {
            self.await_look_of(Some(number));
            self.jobs.start(Lane::Encode, move |job| {
                worker::encode(job, number, &buffer);
            });
        }
    }

    /// Takes note that all of the picture of render `number` is being encoded, and of no other.
    pub(super) fn await_look_of(&mut self, number: Option<usize>) {
        if let Some(present) = &mut self.picture {
            present.await_look(number == Some(present.number));
        }
    }

    /// Whether `picture` is of another scene than the one being edited, or of another part of it.
    pub(super) fn is_outdated(&self, picture: &Picture) -> bool {
        let (scene, now) = (&picture.scene, &self.document.scene);
        let settings = [&scene.render, &picture.settings_to_repeat()];
        let is_of_scene = settings.contains(&&now.render)
            && scene.camera == now.camera
            && same_picture_but_render(scene, now);
        picture.buffer.part() != self.wanted_part() || !is_of_scene
    }
}

/// Whether the same is prepared for both: triangles, images, what the preview paints.
fn is_prepared_alike(a: &Scene, b: &Scene) -> bool {
    same_geometry(a, b) && same_image(a, b) && same_paint(a, b)
}

/// The layers that a render of `scene` keeps.
fn layers_of(scene: &Scene) -> Vec<Layer> {
    if !scene.output.layers {
        return Vec::new();
    }
    let mut layers = Layer::all_of(scene);
    if !layers.is_empty() && scene.render.measures_error() {
        layers.push(Layer::Error);
    }
    layers
}
