//! The renders of this session: a strip of small pictures, each with its settings, time, noise and hash.
//!
//! The present render is not in here, but in the window; it joins the others when the next one takes its place. All pixels are kept
//! while they fit into [`BUDGET_BYTES`]. Beyond that the oldest renders lose first their layers, then their pixels; their small
//! pictures, their figures and their settings stay.

mod strip;

use std::sync::Arc;
use std::time::Duration;

use egui::{ColorImage, ImageData, TextureHandle, TextureOptions};

use super::error_plot::seconds_in_words;
use super::part::Part;
use super::picture::{Outcome, Picture};
use super::picture_buffer::{PictureBuffer, PictureId};
use super::status_bar::duration;
use super::undo::bytes_beside;
use super::widgets::{chosen_percent, counted, percent};
use crate::render::Image;
use crate::scene::{Choice, Mode, RenderSettings, Scene};

pub use strip::{Asked, HEIGHT, LEAST_HEIGHT, StripState};

/// Memory for the pixels and scenes of renders before the present one, in bytes.
pub const BUDGET_BYTES: u64 = 1 << 30;
/// Renders that are remembered.
const MOST_RENDERS: usize = 500;

/// What there is to say about a render.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Its number among the renders of this session.
    pub number: usize,
    /// Its picture, kept or not.
    pub picture: PictureId,
    /// What sets it apart from the one before.
    pub name: String,
    /// What its scene is called.
    pub scene_name: String,
    /// Which of what was opened its scene belongs to, see [`Picture::file`].
    pub file: usize,
    /// What was computed.
    pub render: RenderSettings,
    /// Of which part of the picture.
    pub part: Part,
    /// How it ended.
    pub outcome: Outcome,
    /// How long it took.
    pub elapsed: Duration,
    /// Its noise, where that is known: 0.03 is 3 %.
    pub noise: Option<f64>,
}

impl Facts {
    /// The facts about `picture`.
    #[must_use]
    pub fn of(picture: &Picture) -> Self {
        let last = picture.errors().last();
        let noise = match &picture.outcome {
            Outcome::Finished { stats, .. } => stats.error.map(|error| error.noise().value),
            Outcome::Opened { error, .. } => error.map(|error| error.noise()),
            _ => last.map(|point| point.error.noise().value),
        };
        Self {
            number: picture.number,
            picture: picture.buffer.id(),
            name: picture.name.clone(),
            scene_name: picture.scene_name.clone(),
            file: picture.file,
            render: picture.settings_to_repeat(),
            part: picture.buffer.part(),
            outcome: picture.outcome.clone(),
            elapsed: picture.elapsed(),
            noise,
        }
    }

    /// The settings that matter most, in a line.
    #[must_use]
    pub fn settings(&self) -> String {
        let render = &self.render;
        let mut parts = vec![
            render.mode.name().to_owned(),
            self.part.size_in_words(),
            counted(render.samples_per_pixel as usize, "sample", "samples"),
        ];
        if render.mode == Mode::Path {
            parts.push(counted(render.max_bounces as usize, "bounce", "bounces"));
        }
        if let Some(noise) = render.stop.noise {
            parts.push(format!("down to {}", chosen_percent(noise)));
        }
        if let Some(seconds) = render.stop.seconds {
            parts.push(format!("stop after {}", seconds_in_words(seconds)));
        }
        parts.join(", ")
    }

    /// Time and noise, in a line.
    #[must_use]
    pub fn result(&self) -> String {
        let time = duration(self.elapsed);
        let ending = match self.outcome {
            Outcome::Running => format!("{time} so far"),
            Outcome::Finished { .. } => time,
            Outcome::Cancelled => format!("{time}, cancelled"),
            Outcome::Failed => format!("{time}, failed"),
            Outcome::Opened { .. } => "from its file".to_owned(),
        };
        match self.noise {
            Some(noise) => format!("{ending} · noise {}", percent(noise)),
            None => ending,
        }
    }

    /// The hash of a finished picture.
    #[must_use]
    pub fn hash(&self) -> Option<&str> {
        match &self.outcome {
            Outcome::Finished { hash, .. } => Some(hash),
            Outcome::Opened { hash, .. } => hash.as_deref(),
            _ => None,
        }
    }
}

/// A render before the present one.
#[derive(Debug)]
pub struct Entry {
    /// What there is to say about it.
    pub facts: Facts,
    /// The scene as it was, see [`Picture::scene_to_repeat`].
    pub scene: Scene,
    /// Its picture, as long as that is kept.
    pub picture: Option<Picture>,
}

/// The renders before the present one, and whether the strip shows.
#[derive(Default)]
pub struct Renders {
    /// Whether the strip shows.
    pub open: bool,
    /// When one was forgotten last, in seconds of the window's time.
    pub forgotten_at: Option<f64>,
    entries: Vec<Entry>,
    /// Small pictures, of the present render too.
    thumbnails: Vec<Thumbnail>,
}

/// A small picture of a render.
struct Thumbnail {
    picture: PictureId,
    /// As it is on the screen.
    texture: TextureHandle,
    /// Of a render whose pixels are gone it is all there is, should the window need another texture.
    image: Arc<ColorImage>,
}

impl Thumbnail {
    fn new(ctx: &egui::Context, picture: PictureId, image: Arc<ColorImage>) -> Self {
        let shown = ImageData::Color(Arc::clone(&image));
        Self {
            picture,
            texture: ctx.load_texture("thumbnail", shown, TextureOptions::LINEAR),
            image,
        }
    }
}

impl std::fmt::Debug for Renders {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renders")
            .field("entries", &self.entries)
            .finish_non_exhaustive()
    }
}

impl Renders {
    /// The renders, oldest first.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Names of those that took long and are in no file.
    pub fn unsaved(&self) -> impl Iterator<Item = &str> {
        let pictures = self.entries.iter().filter_map(|e| e.picture.as_ref());
        let unsaved = pictures.filter(|picture| picture.is_unsaved_work());
        unsaved.map(|picture| picture.name.as_str())
    }

    /// The picture of render `number`, if it is still kept.
    #[must_use]
    pub fn picture(&self, number: usize) -> Option<&Picture> {
        self.entry(number)?.picture.as_ref()
    }

    /// [`Renders::picture`], to change what of it is shown.
    pub fn picture_mut(&mut self, number: usize) -> Option<&mut Picture> {
        let mut entries = self.entries.iter_mut();
        let entry = entries.find(|entry| entry.facts.number == number)?;
        entry.picture.as_mut()
    }

    /// The picture with this identity, if it is still kept, to change what is known of it.
    pub fn with_id_mut(&mut self, id: PictureId) -> Option<&mut Picture> {
        let mut pictures = self.entries.iter_mut().filter_map(|e| e.picture.as_mut());
        pictures.find(|picture| picture.buffer.id() == id)
    }

    /// Render `number`.
    #[must_use]
    pub fn entry(&self, number: usize) -> Option<&Entry> {
        let mut entries = self.entries.iter();
        entries.find(|entry| entry.facts.number == number)
    }

    /// Whether `picture` is one to remember: it is finished, or the user ended it with something to see.
    #[must_use]
    pub fn wants(picture: &Picture) -> bool {
        let is_seen = picture.first_tile.is_some();
        is_seen && !picture.is_replaced() && !picture.is_running()
    }

    /// Takes in a render that makes room for another. `present`: the scene being edited, whose meshes and images are in memory anyway.
    /// Returns what is to be given back of memory, which may take longer than a frame.
    pub fn keep(&mut self, mut picture: Picture, present: &Scene) -> Vec<Freed> {
        picture.hide();
        // One that ran beside others may be older than what came meanwhile.
        let place = self
            .entries
            .partition_point(|entry| entry.facts.number < picture.number);
        let entry = Entry {
            facts: Facts::of(&picture),
            scene: picture.scene_to_repeat(),
            picture: Some(picture),
        };
        self.entries.insert(place, entry);
        self.trim(present, BUDGET_BYTES)
    }

    /// Has nothing more written to disk of them; what is there stays.
    pub fn stop_keeping(&self) {
        let pictures = self.entries.iter().filter_map(|it| it.picture.as_ref());
        pictures.for_each(Picture::stop_keeping);
    }

    /// Removes what is on disk of them: another render takes its place.
    pub fn forget_kept(&mut self) {
        let pictures = self.entries.iter_mut();
        let pictures = pictures.filter_map(|entry| entry.picture.as_mut());
        pictures.for_each(Picture::forget_kept);
    }

    /// Whether one was forgotten so short a time before `now`, in seconds, that a click to forget the next, which has come under the pointer, is
    /// the second of a double click.
    #[must_use]
    pub fn is_just_forgotten(&self, now: f64) -> bool {
        const DOUBLE_CLICK_SECONDS: f64 = 0.5;
        let since = self.forgotten_at.map(|at| now - at);
        since.is_some_and(|since| since < DOUBLE_CLICK_SECONDS)
    }

    /// Forgets render `number`.
    pub fn forget(&mut self, number: usize) -> Vec<Freed> {
        let index = self.entries.iter().position(|e| e.facts.number == number);
        let Some(entry) = index.map(|index| self.entries.remove(index)) else {
            return Vec::new();
        };
        self.forget_thumbnail(entry.facts.picture);
        entry.picture.map(Freed::of).into_iter().collect()
    }

    /// Gives up what does not fit into `budget` bytes, the oldest first: of pictures that nobody would miss, then of others; that of the
    /// newest stays.
    fn trim(&mut self, present: &Scene, budget: u64) -> Vec<Freed> {
        let mut freed = Vec::new();
        while self.entries.len() > MOST_RENDERS || self.scene_bytes(present) > budget {
            let oldest = self.entries[0].facts.number;
            freed.extend(self.forget(oldest));
        }
        let budget = budget - self.scene_bytes(present);
        let mut bytes: u64 = self.entries.iter().map(Entry::pixel_bytes).sum();
        let Some((_, older)) = self.entries.split_last_mut() else {
            return freed;
        };
        for is_missed in [false, true] {
            let is_it = |picture: &&mut Picture| picture.is_unsaved_work() == is_missed;
            for entry in older.iter_mut() {
                if bytes <= budget {
                    return freed;
                }
                let before = entry.pixel_bytes();
                if let Some(picture) = entry.picture.as_mut().filter(is_it) {
                    freed.push(Freed(None, picture.buffer.take_layers()));
                }
                bytes -= before - entry.pixel_bytes();
            }
            for entry in older.iter_mut() {
                if bytes <= budget {
                    return freed;
                }
                let before = entry.pixel_bytes();
                let given_up = entry.picture.take_if(|picture| is_it(&picture));
                freed.extend(given_up.map(Freed::of));
                bytes -= before - entry.pixel_bytes();
            }
        }
        freed
    }

    /// Gives up all pixels.
    pub fn free_pixels(&mut self) -> Vec<Freed> {
        let pictures = self
            .entries
            .iter_mut()
            .filter_map(|entry| entry.picture.take());
        pictures.map(Freed::of).collect()
    }

    /// Bytes that only the scenes of these renders hold: none of what the scene `present` has.
    fn scene_bytes(&self, present: &Scene) -> u64 {
        let scenes = self.entries.iter().map(|entry| &entry.scene);
        bytes_beside(scenes, present) as u64
    }

    /// The pictures of renders whose small ones are missing, `present` among them.
    #[must_use]
    pub fn without_thumbnail(&self, present: Option<&Picture>) -> Vec<Arc<PictureBuffer>> {
        let kept = self
            .entries
            .iter()
            .filter_map(|entry| entry.picture.as_ref());
        let present = present.filter(|picture| Self::wants(picture));
        let missing = |picture: &&Picture| self.thumbnail(picture.buffer.id()).is_none();
        kept.chain(present)
            .filter(missing)
            .map(|picture| Arc::clone(&picture.buffer))
            .collect()
    }

    /// Takes in the small picture of `picture`, unless that is neither `present` nor remembered any more.
    pub fn set_thumbnail(
        &mut self,
        ctx: &egui::Context,
        present: Option<&Picture>,
        picture: PictureId,
        image: ColorImage,
    ) {
        self.forget_thumbnail(picture);
        let past = self.entries.iter().map(|entry| entry.facts.picture);
        let mut wanted = past.chain(present.map(|present| present.buffer.id()));
        if wanted.any(|wanted| wanted == picture) {
            self.thumbnails
                .push(Thumbnail::new(ctx, picture, Arc::new(image)));
        }
    }

    /// Forgets the small picture of `picture`.
    pub fn forget_thumbnail(&mut self, picture: PictureId) {
        self.thumbnails.retain(|known| known.picture != picture);
    }

    /// How many small pictures there are.
    #[must_use]
    pub fn thumbnail_count(&self) -> usize {
        self.thumbnails.len()
    }

    /// Shows all small pictures in another window.
    pub fn move_to(&mut self, ctx: &egui::Context) {
        for known in &mut self.thumbnails {
            *known = Thumbnail::new(ctx, known.picture, Arc::clone(&known.image));
        }
    }

    fn thumbnail(&self, picture: PictureId) -> Option<&TextureHandle> {
        let mut thumbnails = self.thumbnails.iter();
        let known = thumbnails.find(|known| known.picture == picture);
        known.map(|known| &known.texture)
    }
}

impl Entry {
    /// Bytes of the pixels that are kept.
    fn pixel_bytes(&self) -> u64 {
        self.picture
            .as_ref()
            .map_or(0, |picture| picture.buffer.bytes())
    }
}

/// Memory that is to be given back; dropping it does so.
#[derive(Debug)]
pub struct Freed(
    #[expect(dead_code, reason = "held to be dropped")] Option<Arc<PictureBuffer>>,
    #[expect(dead_code, reason = "held to be dropped")] Vec<Image>,
);

impl Freed {
    /// The pixels of `picture`; what of it is on the screen goes at once, and what is on disk soon.
    #[must_use]
    pub fn of(mut picture: Picture) -> Self {
        picture.forget_kept();
        Self(Some(picture.buffer), Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::gui::picture::LONG;
    use crate::math::DVec3;
    use crate::render::{Layer, RenderProgress, RenderStats};
    use crate::scene::{Display, RadianceMap, Texels, TextureImage};
    use std::time::Instant;

    const SIDE: u32 = 64;
    const PLANE: u64 = 12 * SIDE as u64 * SIDE as u64;

    fn picture(number: usize) -> Picture {
        let layers = vec![Layer::Emission, Layer::Shadow, Layer::Error];
        let buffer =
            PictureBuffer::new(Part::whole([SIDE; 2]), layers, Display::default()).unwrap();
        let mut picture = Picture::new(
            number,
            [format!("render {number}"), "room".to_owned()],
            Scene::default(),
            Arc::new(buffer),
            RenderProgress::default(),
            Instant::now(),
        );
        picture.first_tile = Some(Duration::from_millis(5));
        picture.end(Outcome::Finished {
            hash: "0123456789".to_owned(),
            stats: Box::new(RenderStats::default()),
        });
        picture
    }

    #[test]
    fn the_oldest_lose_their_layers_and_then_their_pixels_but_never_their_figures() {
        let present = Scene::default();
        let mut renders = Renders::default();
        for number in 1..=4 {
            assert!(Renders::wants(&picture(number)));
            assert!(renders.keep(picture(number), &present).is_empty());
        }
        let kept = |renders: &Renders| -> Vec<u64> {
            renders
                .entries
                .iter()
                .map(|e| e.pixel_bytes() / PLANE)
                .collect()
        };
        assert_eq!(kept(&renders), [4, 4, 4, 4]);
        renders.trim(&present, 11 * PLANE);
        assert_eq!(kept(&renders), [1, 1, 4, 4]);
        renders.trim(&present, 6 * PLANE);
        assert_eq!(kept(&renders), [0, 1, 1, 4]);
        assert!(renders.picture(1).is_none());
        assert_eq!(renders.entry(1).unwrap().facts.hash(), Some("0123456789"));
        assert_eq!(renders.forget(2).len(), 1);
        assert_eq!(renders.entries().len(), 3);
        assert_eq!(renders.free_pixels().len(), 2);
        assert_eq!(kept(&renders), [0, 0, 0]);
        assert!(renders.free_pixels().is_empty());
    }

    #[test]
    fn pictures_that_took_long_and_are_in_no_file_go_last() {
        let present = Scene::default();
        let mut renders = Renders::default();
        for number in 1..=3 {
            let mut picture = picture(number);
            if number == 1 {
                picture.go_on_after(LONG, 0.5);
            }
            renders.keep(picture, &present);
        }
        assert_eq!(renders.unsaved().count(), 1);
        let kept = |renders: &Renders| -> Vec<u64> {
            let entries = renders.entries.iter();
            entries.map(|entry| entry.pixel_bytes() / PLANE).collect()
        };
        renders.trim(&present, 8 * PLANE);
        assert_eq!(kept(&renders), [4, 0, 4]);
        // What came last stays, however little room there is.
        renders.trim(&present, 0);
        assert_eq!(kept(&renders), [0, 0, 4]);
    }

    #[test]
    fn meshes_and_images_that_only_old_renders_hold_are_given_up_with_them() {
        let mesh = Arc::new(TriangleMesh {
            positions: vec![DVec3::ZERO; 1000],
            ..TriangleMesh::default()
        });
        let (sky, _) = RadianceMap::cleaned(100, 5, vec![[1.0; 3]; 500]);
        let bark = TextureImage::new(10, 10, Texels::Bytes(vec![[0; 3]; 100]));
        let present = Scene {
            meshes: [("ram".to_owned(), Arc::clone(&mesh))].into(),
            images: [("sky".to_owned(), Arc::new(sky))].into(),
            textures: [("bark".to_owned(), Arc::new(bark))].into(),
            ..Scene::default()
        };
        let mut renders = Renders::default();
        for number in 1..=2 {
            let mut picture = picture(number);
            picture.scene = present.clone();
            renders.keep(picture, &present);
        }
        assert_eq!(renders.scene_bytes(&present), 0);
        let bytes = 24_000 + 6_000 + 300;
        assert_eq!(
            renders.scene_bytes(&Scene::default()),
            bytes,
            "counted once"
        );
        renders.trim(&present, 8 * PLANE);
        assert_eq!(renders.entries().len(), 2);
        renders.trim(&Scene::default(), bytes - 1);
        assert!(renders.entries().is_empty());
    }

    #[test]
    fn a_small_picture_that_comes_too_late_is_not_that_of_who_took_over_the_number() {
        let ctx = egui::Context::default();
        let small = || ColorImage::filled([2, 2], egui::Color32::WHITE);
        let mut renders = Renders::default();
        let (before, present) = (picture(1), picture(1));
        renders.set_thumbnail(&ctx, Some(&present), before.buffer.id(), small());
        assert_eq!(renders.thumbnail_count(), 0);
        let missing = renders.without_thumbnail(Some(&present));
        assert_eq!(missing.len(), 1);
        renders.set_thumbnail(&ctx, Some(&present), missing[0].id(), small());
        assert!(renders.without_thumbnail(Some(&present)).is_empty());
        // It stays when the picture becomes one of the past, and goes with that.
        renders.keep(present, &Scene::default());
        assert_eq!(renders.thumbnail_count(), 1);
        renders.forget(1);
        assert_eq!(renders.thumbnail_count(), 0);
    }

    #[test]
    fn a_render_that_an_edit_replaced_is_not_remembered() {
        let mut replaced = picture(1);
        replaced.follow();
        replaced.replace();
        assert!(!Renders::wants(&replaced));
        let mut asked_for = picture(1);
        asked_for.replace();
        assert!(Renders::wants(&asked_for));
        let mut long = picture(1);
        long.follow();
        long.go_on_after(LONG, 0.5);
        long.replace();
        assert!(Renders::wants(&long), "it is too much to lose");
        let mut unseen = picture(1);
        unseen.first_tile = None;
        assert!(!Renders::wants(&unseen));
    }

    #[test]
    fn a_render_is_described_in_two_lines() {
        let mut facts = Facts::of(&picture(3));
        facts.elapsed = Duration::from_millis(1500);
        facts.noise = Some(0.0123);
        assert_eq!(facts.settings(), "direct, 64 × 64, 16 samples");
        assert_eq!(facts.result(), "1.5 s · noise 1.2 %");
        facts.outcome = Outcome::Cancelled;
        facts.render.mode = Mode::Path;
        facts.render.stop.noise = Some(0.01);
        assert_eq!(
            facts.settings(),
            "path, 64 × 64, 16 samples, 8 bounces, down to 1 %"
        );
        facts.render.stop.seconds = Some(90.0);
        assert_eq!(
            facts.settings(),
            "path, 64 × 64, 16 samples, 8 bounces, down to 1 %, stop after 1 min 30 s"
        );
        assert_eq!(facts.result(), "1.5 s, cancelled · noise 1.2 %");
    }
}
