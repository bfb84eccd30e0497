//! How much memory a picture takes, and whether it is there: told in words before any of it is asked for.

use super::film::Film;
use super::prepare::PreparedScene;
use super::run::RunConfig;
use super::tiles::Region;
use crate::memory::{ShortOfMemory, require};
use crate::scene::SceneError;

/// What is kept of a picture while it is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureMemory {
    /// Its pixels.
    pub pixels: u64,
    /// Sums of samples that are kept beside the picture's.
    pub layers: usize,
    /// Whether its error is estimated.
    pub has_error: bool,
    /// Pictures of this size that whoever asks for it keeps, or makes of it, meanwhile.
    pub copies: usize,
    /// Whether checkpoints are made of the render, or read.
    pub has_checkpoint: bool,
    /// What is kept from one render to the next, in bytes.
    pub kept_bytes: u64,
}

/// The bytes of a pixel of a picture, an [`Image`](super::Image).
const IMAGE: usize = size_of::<[f32; 3]>();
/// Bytes of a pixel that the estimate of the error keeps.
const FALLS: usize = size_of::<f32>();
/// Bytes of a pixel that it takes while it is made: moves and the picture of the error, or less, and what decides where samples go.
const ESTIMATE: usize = 2 * IMAGE + size_of::<f32>();
/// Bytes of a pixel in a checkpoint beside the film, where some pixels get more samples than others: what its samples are worth, and
/// whether it gets some.
const CHOICE: usize = size_of::<f32>() + size_of::<bool>();
/// Bytes of a pixel that writing takes for each picture in the file: the picture, its channels apart, and the file, which is no larger.
const WRITING: usize = 3 * IMAGE;

impl PictureMemory {
    /// Of a render of `region`, or of the whole picture, with nothing beside it.
    #[must_use]
    pub fn of_render(scene: &PreparedScene, region: Option<Region>, run: &RunConfig) -> Self {
        let settings = scene.settings();
        let pixels = region.map_or(settings.pixel_count(), |region| region.pixel_count() as u64);
        Self {
            pixels,
            layers: if run.layers { scene.layers().len() } else { 0 },
            has_error: settings.measures_error(),
            copies: 0,
            has_checkpoint: false,
            kept_bytes: 0,
        }
    }

    /// The same with the picture of `region` beside it, as it is in memory.
    #[must_use]
    pub fn beside(self, region: Region) -> Self {
        let copies = (region.pixel_count() as u64).div_ceil(self.pixels);
        Self {
            copies: self.copies + usize::try_from(copies).unwrap_or(usize::MAX),
            ..self
        }
    }

    /// The bytes of a checkpoint, there or not.
    #[must_use]
    pub fn checkpoint_bytes(self) -> u64 {
        self.pixels * self.checkpoint_bytes_per_pixel() as u64
    }

    fn checkpoint_bytes_per_pixel(self) -> usize {
        let beside = if self.has_error { FALLS + CHOICE } else { 0 };
        Film::bytes_per_pixel(self.layers, self.has_error) + beside
    }

    /// The most bytes at any time. Sums become pictures one after the other, so that only one is there twice.
    #[must_use]
    pub fn bytes(self) -> u64 {
        let Self {
            pixels,
            layers,
            has_error,
            copies,
            has_checkpoint,
            kept_bytes,
        } = self;
        let (kept, estimate) = if has_error { (FALLS, ESTIMATE) } else { (0, 0) };
        let film = Film::bytes_per_pixel(layers, has_error) + kept;
        let checkpoint = if has_checkpoint {
            self.checkpoint_bytes_per_pixel()
        } else {
            0
        };
        let rendering = film + estimate.max(IMAGE) + checkpoint;
        let pictures = 1 + layers + usize::from(has_error && layers > 0);
        let most = rendering.max(pictures * WRITING) + copies * IMAGE;
        pixels * most as u64 + kept_bytes
    }

    /// Says whether there is that much, and a sixteenth more for what else is needed.
    ///
    /// # Errors
    /// [`PictureTooLarge`].
    pub fn require(self) -> Result<(), PictureTooLarge> {
        require(self.bytes() + self.bytes() / 16).map_err(PictureTooLarge)
    }
}

/// What building a structure takes for each triangle, at its peak, beside the mesh it is of: measured with meshes of 0.4 and 2.2 million
/// triangles, which take 172 and 209 bytes for each with the mesh.
const BUILDING: u64 = 130;

/// Says whether there is memory for a structure over so many triangles.
pub(super) fn require_structure(triangles: u64) -> Result<(), SceneError> {
    require(triangles * BUILDING).map_err(|short| SceneError::TooLittleMemory {
        triangles,
        needed: short.needed_in_words(),
        why: short.why(),
    })
}

/// Why a picture cannot be rendered here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the picture needs {} of memory while it is rendered, {}; make it smaller, render it part by part (--region), or switch \
     render.error_estimate or output.layers off",
    self.0.needed_in_words(),
    self.0.why()
)]
pub struct PictureTooLarge(pub ShortOfMemory);

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: PictureMemory = PictureMemory {
        pixels: 1000,
        layers: 0,
        has_error: false,
        copies: 0,
        has_checkpoint: false,
        kept_bytes: 0,
    };

    #[test]
    fn what_is_left_out_is_not_counted() {
        assert_eq!(PICTURE.bytes(), 1000 * (24 + 4 + 12));
        let more = |picture: PictureMemory| picture.bytes() - PICTURE.bytes();
        let copies = 2;
        assert_eq!(more(PictureMemory { copies, ..PICTURE }), 1000 * 24);
        let has_error = true;
        let with_error = PictureMemory {
            has_error,
            ..PICTURE
        };
        assert_eq!(more(with_error), 1000 * (40 + 4 + 16));
        let layers = 2;
        assert_eq!(more(PictureMemory { layers, ..PICTURE }), 1000 * 68);
        let with_checkpoint = |picture| PictureMemory {
            has_checkpoint: true,
            ..picture
        };
        assert_eq!(more(with_checkpoint(PICTURE)), 1000 * 28);
        let copy = with_checkpoint(with_error).bytes() - with_error.bytes();
        assert_eq!(copy, 1000 * (28 + 40 + 4 + 5));
    }

    #[test]
    fn what_is_not_there_is_refused_in_words() {
        assert_eq!(PICTURE.require(), Ok(()));
        let pixels = 1 << 50;
        let short = PictureMemory { pixels, ..PICTURE }.require();
        let said = short.expect_err("is not there").to_string();
        let expected = "the picture needs 47850746.0 GB of memory while it is rendered, ";
        assert!(said.starts_with(expected), "{said}");
        assert_eq!(require_structure(1000), Ok(()));
        let short = require_structure(1 << 50).expect_err("is not there");
        let expected = "the structure over 1125899906842624 triangles takes about 146366987.9 GB of memory while it is \
                        built, ";
        assert!(short.to_string().starts_with(expected), "{short}");
    }
}
