//! The picture of a file, to compare with.

use std::path::Path;
use std::sync::Arc;

use crate::control::{CancelToken, Progress};
use crate::gui::opened_picture::part_of;
use crate::gui::part::Part;
use crate::gui::picture_buffer::PictureBuffer;
use crate::gui::widgets::format_number;
use crate::io::{self, RenderFile, scene_file::SceneFile};
use crate::math::color::linear_from_srgb;
use crate::render::{Image, display};
use crate::scene::{Display, Scene, ToneCurve};

/// What a file shows.
#[derive(Debug)]
pub struct FilePicture {
    /// Its pixels, as the part of a picture that the file tells.
    pub buffer: Arc<PictureBuffer>,
    /// The exposure, tone curve and gamma that it was saved with, where they cannot be taken back: then the pixels are what a screen showed, in
    /// linear values.
    pub saved_look: Option<Display>,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

impl FilePicture {
    /// The picture in the file at `path`; `None` when cancelled.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    pub fn read(path: &Path, cancel: &CancelToken) -> Result<Option<Self>, String> {
        let read = io::read_render(path, cancel, &Progress::new());
        let read = read.map_err(|error| error.to_string())?;
        Ok(read.map(Self::of))
    }

    fn of(file: RenderFile) -> Self {
        let RenderFile {
            picture, origin, ..
        } = file;
        let image = picture.image;
        let scene = origin.scene.and_then(|text| scene_in(&text));
        let part = scene.as_ref().map_or_else(
            || Part::whole([image.width, image.height]),
            |scene| part_of(&image, origin.region, scene),
        );
        let look = scene.map(|scene| scene.display);
        let is_given = |look: &Display| !picture.is_linear && *look != Display::default();
        let display = Display::default();
        Self {
            buffer: Arc::new(PictureBuffer::of_render(image, Vec::new(), part, display)),
            saved_look: look.filter(is_given),
            warnings: picture.warnings,
        }
    }
}

/// The scene that a picture's file tells in `text`, without meshes; `None` where it cannot be understood: the picture is one all the same.
fn scene_in(text: &str) -> Option<Scene> {
    let file = SceneFile::parse(text, "the scene of the picture").ok()?;
    Some(file.scene)
}

/// Turns pixels into what a screen shows of them with `look`, in linear values.
pub(super) fn give_look(image: &mut Image, look: &Display) {
    for pixel in &mut image.pixels {
        *pixel = display::encode(*pixel, look).map(linear_from_srgb);
    }
}

/// What `look` changes, in words.
pub(super) fn look_in_words(look: &Display) -> String {
    let exposure = (look.exposure != 0.0).then(|| {
        let stops = format_number(look.exposure, 2);
        let unit = if stops == "1" { "stop" } else { "stops" };
        format!("exposure {stops} {unit}")
    });
    let curve = (look.tone_curve == ToneCurve::Aces).then(|| "tone curve ACES".to_owned());
    let gamma = (look.gamma != 1.0).then(|| format!("gamma {}", format_number(look.gamma, 2)));
    let parts: Vec<String> = [exposure, curve, gamma].into_iter().flatten().collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_is_told_by_what_it_changes() {
        let mut look = Display {
            exposure: 1.5,
            tone_curve: ToneCurve::Aces,
            gamma: 1.0,
        };
        assert_eq!(look_in_words(&look), "exposure 1.5 stops, tone curve ACES");
        look = Display {
            gamma: 0.8,
            ..Display::default()
        };
        assert_eq!(look_in_words(&look), "gamma 0.8");
    }

    #[test]
    fn a_plain_look_cuts_off_what_is_brighter_than_the_screen() {
        let mut image = Image {
            width: 1,
            height: 1,
            pixels: vec![[0.25, 3.0, 0.0]],
        };
        give_look(&mut image, &Display::default());
        let [red, green, blue] = image.pixels[0];
        assert!((red - 0.25).abs() < 1e-6);
        assert_eq!([green, blue], [1.0, 0.0]);
    }
}
