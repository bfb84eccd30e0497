//! A render as the window watches it: its scene, its pixels, how far it is, and what of it is on the screen.

mod timing;

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::canvas::{Canvas, StandIn};
use super::first_look::FirstLook;
use super::inspector::Samples;
use super::jobs::drop_elsewhere;
use super::keeping::KeptRender;
use super::opened_picture::OpenedPicture;
use super::part::Part;
use super::picture_buffer::{CoarseTexels, Encoded, EncodedTile, PictureBuffer};
use super::reached::Reached;
use crate::control::{Progress, Throttle};
use crate::io::WrittenError;
use crate::render::{ErrorPoint, LiveRules, RenderProgress, RenderStats, StopRules};
use crate::scene::{RenderSettings, Scene};
pub use timing::time_left;

/// From this time on a render is work that nobody wants to lose: edits start it anew only where the picture follows them, it is remembered, it
/// stays on disk until it is saved or the next begins, and closing the window asks.
pub const LONG: Duration = Duration::from_secs(30);

/// How a render ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Still running.
    Running,
    /// All samples are in.
    Finished {
        /// SHA-256 of the linear picture, see [`crate::render::Image::hash`].
        hash: String,
        /// What it took.
        stats: Box<RenderStats>,
    },
    /// Stopped by the user; the tiles so far stay.
    Cancelled,
    /// Ended by a fault of the program.
    Failed,
    /// Ended before this session: the picture was in the file that was opened.
    Opened {
        /// Of the linear picture, as of one that is finished; `None` where the file has rounded it.
        hash: Option<String>,
        /// That of the picture before it was rounded, where the file tells.
        hash_before: Option<String>,
        /// How wrong it is, where the file tells.
        error: Option<WrittenError>,
    },
}

/// What holds a render back. Whoever lets go of it lets the render go on, so that a cancelled one ends.
#[derive(Debug, Default)]
struct Hold(Throttle);

impl Drop for Hold {
    fn drop(&mut self) {
        self.0.allow(usize::MAX);
    }
}

/// A render and what the window shows of it.
pub struct Picture {
    /// Its number among the renders of this session, from 1.
    pub number: usize,
    /// What it is called among other renders.
    pub name: String,
    /// What its scene is called.
    pub scene_name: String,
    /// Which of what was opened its scene belongs to, see [`Document::file_number`](super::document::Document::file_number).
    pub file: usize,
    /// The scene as it was when the render started.
    pub scene: Scene,
    /// Its pixels.
    pub buffer: Arc<PictureBuffer>,
    /// How far it is.
    pub progress: RenderProgress,
    /// How far what is there of it on disk is read, before it goes on: in bytes.
    pub reading: Progress,
    /// How it ended.
    pub outcome: Outcome,
    standing: Standing,
    /// Whether something else was on the screen when that was last noted.
    is_unseen: bool,
    /// Whether it is in a file.
    is_saved: bool,
    /// Whether its own job prepares its scene first.
    pub is_preparing: bool,
    /// From the click to the first tile, or the coarse picture, on its way to the screen.
    pub first_tile: Option<Duration>,
    /// Why every pixel is black, where that is certain.
    pub why_black: Option<String>,
    /// Where its render waits until the first look is drawn.
    pub first_look: FirstLook,
    /// Where it is on disk, in case the program is killed.
    kept: Option<Arc<KeptRender>>,
    /// What it has reached, once it has ended, for one that goes on from there.
    reached: Reached,
    /// By which rules it ends.
    rules: LiveRules,
    hold: Hold,
    /// What was edited since it began, and that it is not to be made anew for.
    passed_over: Option<(Scene, Part)>,
    /// What is known of its error, oldest first.
    errors: Vec<ErrorPoint>,
    before_rules: BeforeRules,
    /// How long it had taken when the last of it came.
    newest_error: Duration,
    started: Instant,
    /// Of a render that was interrupted: what it took before, and which part was done then, `0..=1`.
    before: Option<(Duration, f64)>,
    /// How long it will take in all, as was known before it began.
    expected_time: Option<Duration>,
    elapsed: Option<Duration>,
    canvas: Canvas,
    next_look: NextLook,
}

/// What a render is to whoever looks at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// Somebody asked for it.
    AskedFor,
    /// It only follows what is edited, and is soon another.
    Follows,
    /// Another took its place because the scene was edited while this one was looked at, and it is nothing to remember.
    Replaced,
}

/// What there was before the rules by which a render ends were those of now.
#[derive(Clone, Copy, Debug, Default)]
struct BeforeRules {
    /// Whether that was another render, which had ended, and whose samples this one took up.
    is_another_render: bool,
    /// How much of what is known of the error is by rules that do not hold any more.
    errors: usize,
}

/// All of a picture on its way in another look, see [`Picture::await_look`].
#[derive(Clone, Copy, Debug, Default)]
struct NextLook {
    is_awaited: bool,
    /// Whether one came while tiles of the render did.
    may_have_hidden_tiles: bool,
}

impl Picture {
    /// A picture whose render was asked for at `started`.
    #[must_use]
    pub fn new(
        number: usize,
        [name, scene_name]: [String; 2],
        scene: Scene,
        buffer: Arc<PictureBuffer>,
        progress: RenderProgress,
        started: Instant,
    ) -> Self {
        Self {
            number,
            name,
            scene_name,
            file: 0,
            buffer,
            progress,
            reading: Progress::new(),
            outcome: Outcome::Running,
            standing: Standing::AskedFor,
            is_unseen: false,
            is_saved: false,
            is_preparing: false,
            first_tile: None,
            why_black: None,
            first_look: FirstLook::default(),
            kept: None,
            reached: Reached::default(),
            rules: LiveRules::new(StopRules::of(&scene.render)),
            scene,
            hold: Hold::default(),
            passed_over: None,
            errors: Vec::new(),
            before_rules: BeforeRules::default(),
            newest_error: Duration::ZERO,
            started,
            before: None,
            expected_time: None,
            elapsed: None,
            canvas: Canvas::default(),
            next_look: NextLook::default(),
        }
    }

    /// The picture of a file.
    #[must_use]
    pub fn opened(number: usize, names: [String; 2], scene: Scene, opened: OpenedPicture) -> Self {
        let progress = RenderProgress::default();
        let started = Instant::now();
        let mut picture = Self::new(number, names, scene, opened.buffer, progress, started);
        picture.first_tile = Some(Duration::ZERO);
        picture.elapsed = Some(Duration::ZERO);
        picture.is_saved = true;
        picture.outcome = Outcome::Opened {
            hash: opened.hash,
            hash_before: opened.hash_before,
            error: opened.error,
        };
        picture
    }

    /// Takes in a tile of the render; it is on the screen from [`Self::show_tiles`] on.
    pub fn take_tile(&mut self, tile: EncodedTile) {
        // It looks as the picture soon will, and is encoded again with that.
        if !self.next_look.is_awaited {
            self.take_encoded(Encoded::Tile(tile));
        }
    }

    /// Takes in a coarse picture.
    pub fn take_coarse(&mut self, texels: CoarseTexels) {
        self.take_encoded(Encoded::Coarse(texels));
    }

    /// Takes in what is encoded of it; it is on the screen from [`Self::show_tiles`] on.
    pub fn take_encoded(&mut self, encoded: Encoded) {
        if self.first_tile.is_none() {
            self.first_tile = Some(self.elapsed_here());
        }
        if matches!(encoded, Encoded::Coarse(_)) {
            self.next_look.is_awaited = false;
        }
        self.canvas.take(encoded);
    }

    /// Takes note whether all of it is on its way in another look. Tiles of the render wait for that; and one that comes while its place is
    /// encoded may be covered by what was there before.
    pub fn await_look(&mut self, awaits: bool) {
        self.next_look.is_awaited = awaits;
        self.next_look.may_have_hidden_tiles |= awaits && self.is_running();
    }

    /// Whether some of what ended may not be on the screen as it is.
    #[must_use]
    pub fn may_lack_tiles(&self) -> bool {
        self.next_look.may_have_hidden_tiles && !self.is_running()
    }

    /// What it shows, for a picture of the same part that is not there yet.
    #[must_use]
    pub fn as_stand_in(&self) -> (Part, StandIn) {
        (self.buffer.part(), self.canvas.as_stand_in())
    }

    /// Shows what another picture showed until something of this is there, where both are of one part.
    pub fn show_meanwhile(&mut self, (part, stand_in): (Part, StandIn)) {
        if part == self.buffer.part() {
            self.canvas.show_meanwhile(stand_in);
        }
    }

    /// Puts the tiles that were taken in on the screen.
    pub fn show_tiles(&mut self, ctx: &egui::Context) {
        self.canvas.flush(ctx, self.buffer.size_in_texels());
    }

    /// Goes on showing what `previous` showed until the first tiles are there, where both are of one part of a picture.
    pub fn continue_from(&mut self, previous: &mut Self) {
        if previous.buffer.part() == self.buffer.part() {
            self.canvas = std::mem::take(&mut previous.canvas);
        }
    }

    /// Takes it off the screen; it is shown again by encoding it anew.
    pub fn hide(&mut self) {
        self.canvas = Canvas::default();
    }

    /// Whether something is on the screen everywhere in it.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.canvas.is_covered()
    }

    /// Whether there is anything to show.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.canvas.is_shown()
    }

    /// Draws what there is to show in `place`.
    pub fn paint(&self, painter: &egui::Painter, place: egui::Rect) {
        self.canvas.paint(painter, place);
    }

    /// Takes in what the render has learnt of its error since the last call.
    pub fn take_errors(&mut self) {
        let new = self.progress.errors_from(self.errors.len());
        if !new.is_empty() {
            self.errors.extend(new);
            self.newest_error = self.elapsed();
        }
    }

    /// What is known of its error, oldest first.
    #[must_use]
    pub fn errors(&self) -> &[ErrorPoint] {
        &self.errors
    }

    /// Ends the picture.
    pub fn end(&mut self, outcome: Outcome) {
        self.take_errors();
        self.is_preparing = false;
        self.elapsed = Some(self.elapsed_here());
        self.outcome = outcome;
        self.hold.0.allow(usize::MAX);
        if !self.is_long() {
            self.forget_kept();
        }
    }

    /// Takes note of where its render is on disk.
    pub fn keep_in(&mut self, place: Option<Arc<KeptRender>>) {
        self.kept = place;
    }

    /// Removes what is on disk of it, as soon as nobody writes there any more.
    pub fn forget_kept(&mut self) {
        if let Some(kept) = self.kept.take() {
            kept.give_up();
            drop_elsewhere(kept);
        }
    }

    /// Has nothing more written to disk of it; what is there stays.
    pub fn stop_keeping(&self) {
        if let Some(kept) = &self.kept {
            kept.give_up();
        }
    }

    /// Takes note that a file has what there will be of it; `is_all`: with its light and its layers, not only as a screen shows it.
    pub fn set_saved(&mut self, is_all: bool) {
        self.is_saved = true;
        if is_all {
            self.forget_kept();
        }
    }

    /// Leaves on disk what it was to go on from, if it does not yet.
    pub fn leave_kept(&self) {
        if let Some(kept) = &self.kept {
            kept.leave();
        }
    }

    /// Takes note that another takes its place because the scene was edited. It is remembered then if it took long, or was asked for and is
    /// done.
    pub fn replace(&mut self) {
        let is_made_on_the_way = self.is_running() || self.standing == Standing::Follows;
        if is_made_on_the_way && !self.is_long() {
            self.standing = Standing::Replaced;
        }
    }

    /// Takes note that it only follows what is edited.
    pub fn follow(&mut self) {
        self.standing = Standing::Follows;
    }

    /// Whether another took its place, and it is nothing to remember.
    #[must_use]
    pub fn is_replaced(&self) -> bool {
        self.standing == Standing::Replaced
    }

    /// Whether it took so long that it is not given up without being asked for.
    #[must_use]
    pub fn is_long(&self) -> bool {
        self.elapsed() >= LONG
    }

    /// Whether it ended, took long, and is in no file.
    #[must_use]
    pub fn is_unsaved_work(&self) -> bool {
        !self.is_running() && self.is_long() && !self.is_saved && self.first_tile.is_some()
    }

    /// Whether it runs, has taken long, and shows something by now: were another to take its place, it could not go on.
    #[must_use]
    pub fn is_work_in_hand(&self) -> bool {
        self.is_running() && self.is_long() && self.first_tile.is_some()
    }

    /// By which rules it ends, for the threads that render.
    #[must_use]
    pub fn rules(&self) -> &LiveRules {
        &self.rules
    }

    /// Has it end by `rules` from now on: it goes on with the samples that it has. `name`: what it is called then.
    pub fn end_by(&mut self, rules: StopRules, name: String) {
        rules.put_into(&mut self.scene.render);
        self.name = name;
        self.before_rules.errors = self.errors.len();
        self.expected_time = None;
        let pixels = self.buffer.part().region.pixel_count() as u64;
        self.progress
            .begin_anew(pixels * u64::from(rules.samples_per_pixel));
        // From then on the render itself may know more.
        self.rules.set(rules);
    }

    /// Its settings as they have to be for a render to end with this picture: a pixel may have had more samples than it may by the rules that
    /// were set last, and then those are the most.
    #[must_use]
    pub fn settings_to_repeat(&self) -> RenderSettings {
        let mut settings = self.scene.render.clone();
        if let Outcome::Finished { stats, .. } = &self.outcome {
            let most = &mut settings.samples_per_pixel;
            *most = stats.sample_range[1].max(*most);
        }
        settings
    }

    /// Its scene with its [settings to repeat](Self::settings_to_repeat).
    #[must_use]
    pub fn scene_to_repeat(&self) -> Scene {
        Scene {
            render: self.settings_to_repeat(),
            ..self.scene.clone()
        }
    }

    /// Where what it has reached is left at its end.
    #[must_use]
    pub fn reached(&self) -> &Reached {
        &self.reached
    }

    /// Takes note that it took up the samples of another, which had ended by other rules. `leads_elsewhere`: whether its picture is not that of
    /// a render by its own rules from the start.
    pub fn continue_another(&mut self, leads_elsewhere: bool) {
        self.before_rules.is_another_render = true;
        if leads_elsewhere {
            self.rules.set_lead_elsewhere();
        }
    }

    /// Whether it took up the samples of another that had ended.
    #[must_use]
    pub fn is_continued(&self) -> bool {
        self.before_rules.is_another_render
    }

    /// Whether it ended, and would go on by `rules` if it could.
    #[must_use]
    pub fn would_go_on_by(&self, rules: &StopRules) -> bool {
        let stop = &rules.stop;
        match &self.outcome {
            Outcome::Cancelled => {
                let seconds = self.elapsed().as_secs_f64();
                let has_tiles = self.first_tile.is_some() || self.is_continued();
                has_tiles && stop.seconds.is_none_or(|limit| limit > seconds)
            }
            Outcome::Finished { stats, .. } => {
                let noise = stats.error.map(|error| error.noise().value);
                let is_quiet = stop.noise.zip(noise).is_some_and(|(to, noise)| noise <= to);
                stats.sample_range[0] < rules.samples_per_pixel
                    && stop
                        .seconds
                        .is_none_or(|limit| limit > stats.render_seconds)
                    && stop.passes.is_none_or(|passes| passes > stats.passes)
                    && !is_quiet
            }
            _ => false,
        }
    }

    /// What holds the render back, for the threads that render.
    #[must_use]
    pub fn throttle(&self) -> &Throttle {
        &self.hold.0
    }

    /// Lets so many of its threads work, unless it is paused.
    pub fn allow_threads(&self, threads: usize) {
        let throttle = self.throttle();
        if self.is_running() && !self.is_paused() && throttle.allowed() != threads {
            throttle.allow(threads);
        }
    }

    /// Has a running render rest, with its time standing still.
    pub fn pause(&self) {
        if self.is_running() {
            self.throttle().allow(0);
        }
    }

    /// Goes on with a paused render. Whatever was edited meanwhile, up to `scene` and `part`, does not start it anew.
    pub fn resume(&mut self, scene: &Scene, part: Part) {
        self.pass_over(scene, part);
        self.throttle().allow(usize::MAX);
    }

    /// Takes note that nobody wants it anew for what was edited since it began, up to `scene` and `part`.
    pub fn pass_over(&mut self, scene: &Scene, part: Part) {
        self.passed_over = Some((scene.clone(), part));
    }

    /// Takes note whether it is on the screen; returns whether it is again, after it was not.
    pub fn note_seen(&mut self, is_seen: bool) -> bool {
        std::mem::replace(&mut self.is_unseen, !is_seen) && is_seen
    }

    /// Whether it is paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.is_running() && self.throttle().is_paused()
    }

    /// What was edited since it began, and that it is not to be made anew for.
    #[must_use]
    pub fn passed_over(&self) -> Option<(&Scene, Part)> {
        let (scene, part) = self.passed_over.as_ref()?;
        Some((scene, *part))
    }

    /// Whether the render runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.outcome == Outcome::Running
    }

    /// How many samples a pixel has so far.
    #[must_use]
    pub fn samples(&self) -> Samples {
        if let Outcome::Opened { error, .. } = &self.outcome {
            return error.map_or(Samples::Unknown, |error| {
                Samples::OnAverage(error.samples_per_pixel)
            });
        }
        if let Outcome::Finished { stats, .. } = &self.outcome {
            let [fewest, most] = stats.sample_range;
            return if fewest == most {
                Samples::OfEach(most)
            } else {
                Samples::OnAverage(stats.samples_per_pixel)
            };
        }
        let pixels = self.buffer.part().region.pixel_count() as f64;
        Samples::OnAverage(self.progress.samples.done() as f64 / pixels)
    }
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Picture")
            .field("outcome", &self.outcome)
            .field("elapsed", &self.elapsed())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
