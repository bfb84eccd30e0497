//! The picture in the file of a render that is opened: what was rendered is there to be looked at and compared with at once.

use std::path::Path;
use std::sync::Arc;

use super::part::Part;
use super::picture_buffer::PictureBuffer;
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadedScene, RenderFile, WrittenError};
use crate::render::{Image, Layer, Region};
use crate::scene::{Display, Scene};

/// What a file shows of its render.
#[derive(Debug)]
pub struct OpenedPicture {
    /// Its pixels, with the layers that the file holds.
    pub buffer: Arc<PictureBuffer>,
    /// SHA-256 of the linear picture; `None` where the file has rounded it.
    pub hash: Option<String>,
    /// That of the picture before it was rounded, where the file tells.
    pub hash_before: Option<String>,
    /// How wrong it is, where the file tells.
    pub error: Option<WrittenError>,
    /// Why its layers could not be read, in words, where that is so.
    pub without_layers: Option<String>,
}

/// Has `progress` count the file at `path` too, of which [`OpenedPicture::of`] reads the picture: told at the start, it never goes back.
pub fn announce(path: &Path, progress: &Progress) {
    let length = std::fs::metadata(path).map_or(0, |file| file.len());
    // Each byte is read and understood.
    progress.add_to_total(2 * length);
}

impl OpenedPicture {
    /// The picture in `path`, a file of a render of the scene that was `loaded` from it; why there is none, or no layers, is
    /// added to what is said of that.
    pub fn of(
        path: &Path,
        loaded: &mut LoadedScene,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let warnings = &mut loaded.warnings;
        match Self::read(path, &loaded.scene, cancel, progress) {
            Ok(found) => {
                let without = found
                    .as_ref()
                    .and_then(|found| found.without_layers.as_ref());
                let said =
                    without.map(|why| format!("the layers of the picture are not shown: {why}"));
                warnings.extend(said);
                found
            }
            Err(error) => {
                warnings.push(format!("the picture itself is not shown: {error}"));
                None
            }
        }
    }

    /// The picture in `path`, a file of a render of `scene`. `None` where it has been given a look that cannot be taken back, as a PNG holds
    /// what the screen showed, and when cancelled. `progress` advances by the bytes of the file twice, as they are read and understood.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    fn read(
        path: &Path,
        scene: &Scene,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Self>, io::PictureError> {
        let Some(file) = io::read_render(path, cancel, progress)? else {
            return Ok(None);
        };
        let RenderFile {
            picture,
            layers,
            origin,
        } = file;
        if !picture.is_linear && scene.display != Display::default() {
            return Ok(None);
        }
        let image = picture.image;
        let (layers, without_layers) = match layers {
            Ok(layers) => (layers, None),
            Err(reason) => (Vec::new(), Some(reason)),
        };
        let is_as_large = |(_, layer): &(Layer, Image)| {
            (layer.width, layer.height) == (image.width, image.height)
        };
        let layers = layers.into_iter().filter(is_as_large).collect();
        let hash = origin.rendered_hash.is_none().then(|| image.hash());
        let part = part_of(&image, origin.region, scene);
        let buffer = PictureBuffer::of_render(image, layers, part, scene.display);
        Ok(Some(Self {
            buffer: Arc::new(buffer),
            hash,
            hash_before: origin.rendered_hash.filter(|hash| !hash.is_empty()),
            error: origin.error,
            without_layers,
        }))
    }
}

/// Which part of the picture of `scene` an image is whose file says that it is `region`; all of another one where that cannot be.
pub(super) fn part_of(image: &Image, region: Option<Region>, scene: &Scene) -> Part {
    let size = [image.width, image.height];
    let of = [scene.render.width, scene.render.height];
    let is_it =
        |region: &Region| region.fits(of[0], of[1]) && [region.width, region.height] == size;
    match region.filter(is_it) {
        Some(region) => Part { region, of },
        None => Part::whole(size),
    }
}
