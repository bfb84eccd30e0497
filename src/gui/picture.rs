//! A render as the window watches it: its scene, its pixels, how far it is, and what of it is on the screen.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Color32, ColorImage, TextureFilter, TextureHandle, TextureOptions};

use super::picture_buffer::{EncodedTile, PictureBuffer};
use crate::render::{ErrorPoint, RenderProgress, RenderStats};
use crate::scene::Scene;

/// Sharp pixels when enlarged, smooth when reduced.
const TEXTURE_OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};

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
}

/// A render and what the window shows of it.
pub struct Picture {
    /// Its number among the renders of this session, from 1.
    pub number: usize,
    /// What it is called among other renders.
    pub name: String,
    /// What its scene is called.
    pub scene_name: String,
    /// The scene as it was when the render started.
    pub scene: Scene,
    /// Its pixels.
    pub buffer: Arc<PictureBuffer>,
    /// How far it is.
    pub progress: RenderProgress,
    /// How it ended.
    pub outcome: Outcome,
    /// Whether another took its place because the scene was edited while this one was looked at.
    pub is_replaced: bool,
    /// From the click to the first tile on its way to the screen.
    pub first_tile: Option<Duration>,
    /// What is known of its error, oldest first.
    errors: Vec<ErrorPoint>,
    /// When the last of it came.
    newest_error: Instant,
    started: Instant,
    elapsed: Option<Duration>,
    texture: Option<TextureHandle>,
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
            scene,
            buffer,
            progress,
            outcome: Outcome::Running,
            is_replaced: false,
            first_tile: None,
            errors: Vec::new(),
            newest_error: started,
            started,
            elapsed: None,
            texture: None,
        }
    }

    /// Puts a tile on the screen.
    pub fn show_tile(&mut self, ctx: &egui::Context, tile: EncodedTile) {
        if self.first_tile.is_none() {
            self.first_tile = Some(self.started.elapsed());
        }
        let size = self.buffer.texture_size();
        put_tile(ctx, &mut self.texture, size, tile);
    }

    /// Goes on showing what `previous` showed until the first tiles are there, where both are of one size.
    pub fn continue_from(&mut self, previous: &mut Self) {
        if previous.buffer.texture_size() == self.buffer.texture_size() {
            self.texture = previous.texture.take();
        }
    }

    /// Takes it off the screen; it is shown again by encoding it anew.
    pub fn hide(&mut self) {
        self.texture = None;
    }

    /// What there is to show; `None` before the first tile.
    #[must_use]
    pub fn texture(&self) -> Option<egui::TextureId> {
        self.texture.as_ref().map(TextureHandle::id)
    }

    /// Takes in what the render has learnt of its error since the last call.
    pub fn take_errors(&mut self) {
        let new = self.progress.errors_from(self.errors.len());
        if !new.is_empty() {
            self.errors.extend(new);
            self.newest_error = Instant::now();
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
        self.outcome = outcome;
        self.elapsed = Some(self.started.elapsed());
    }

    /// Whether the render runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.outcome == Outcome::Running
    }

    /// Time since the render was asked for, up to its end.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.elapsed.unwrap_or_else(|| self.started.elapsed())
    }

    /// Time the rest takes: until the noise is low enough where that is foreseen, else at the pace so far; `None` while that is
    /// a guess.
    #[must_use]
    pub fn remaining(&self) -> Option<Duration> {
        if let Some((point, stop)) = self.errors.last().and_then(|p| Some((p, p.time_to_stop?))) {
            let end = stop
                .value
                .min(self.scene.render.stop.seconds.unwrap_or(f64::INFINITY));
            let since = self.newest_error.elapsed().as_secs_f64();
            return Duration::try_from_secs_f64((end - point.seconds - since).max(0.0)).ok();
        }
        time_left(self.progress.samples.fraction(), self.elapsed())
    }

    /// Million rays per second so far.
    #[must_use]
    pub fn mrays_per_second(&self) -> f64 {
        self.progress.rays() as f64 / self.elapsed().as_secs_f64().max(1e-9) / 1e6
    }
}

/// Puts a tile into `texture`, which is made of `size` texels where it is not there.
pub(super) fn put_tile(
    ctx: &egui::Context,
    texture: &mut Option<TextureHandle>,
    size: [usize; 2],
    tile: EncodedTile,
) {
    let texture = texture.get_or_insert_with(|| {
        let empty = ColorImage::filled(size, Color32::TRANSPARENT);
        ctx.load_texture("picture", empty, TEXTURE_OPTIONS)
    });
    texture.set_partial(tile.position, tile.pixels, TEXTURE_OPTIONS);
}

/// Time that the rest of some work takes at the pace so far; `None` while that is a guess. `done`: the done part, `0..=1`.
#[must_use]
pub fn time_left(done: f64, elapsed: Duration) -> Option<Duration> {
    let elapsed = elapsed.as_secs_f64();
    let known = done > 0.01 && elapsed > 0.2;
    known
        .then(|| Duration::try_from_secs_f64(elapsed * (1.0 - done) / done).ok())
        .flatten()
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Picture")
            .field("outcome", &self.outcome)
            .field("elapsed", &self.elapsed())
            .finish_non_exhaustive()
    }
}
