//! The picture in the file of a render that is opened: what was rendered is there to be looked at and compared with at once.

use std::path::Path;
use std::sync::Arc;

use super::picture_buffer::PictureBuffer;
use crate::control::{CancelToken, Progress};
use crate::io::{self, WrittenError, WrittenOrigin};
use crate::render::{Image, Layer};
use crate::scene::{Display, Scene};

/// What a file shows of its render.
#[derive(Debug)]
pub struct OpenedPicture {
    /// Its pixels, with the layers that the file holds.
    pub buffer: Arc<PictureBuffer>,
    /// SHA-256 of the linear picture; `None` where the file has rounded it.
    pub hash: Option<String>,
    /// How wrong it is, where the file tells.
    pub error: Option<WrittenError>,
    /// Why its layers could not be read, in words, where that is so.
    pub without_layers: Option<String>,
}

impl OpenedPicture {
    /// The picture in `path`, a file of a render of `scene`. `None` where it has been given a look that cannot be taken back, as a PNG holds
    /// what the screen showed, and when cancelled.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    pub fn read(
        path: &Path,
        scene: &Scene,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, io::PictureError> {
        // What is awaited is the scene; a picture comes along in no time, unless it is huge.
        let progress = Progress::new();
        let Some(file) = io::read_image_unless(path, cancel, &progress)? else {
            return Ok(None);
        };
        if !file.is_linear && scene.display != Display::default() {
            return Ok(None);
        }
        let (layers, without_layers) = match io::read_layers(path, cancel, &progress) {
            Ok(Some(layers)) => (layers, None),
            Ok(None) => return Ok(None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        let is_as_large = |(_, layer): &(Layer, Image)| {
            (layer.width, layer.height) == (file.image.width, file.image.height)
        };
        let layers = layers.into_iter().filter(is_as_large).collect();
        let origin = WrittenOrigin::of_file(path).unwrap_or_default();
        let hash = file.is_linear.then(|| file.image.hash());
        let buffer = PictureBuffer::of_render(file.image, layers, scene.display);
        Ok(Some(Self {
            buffer: Arc::new(buffer),
            hash,
            error: origin.error,
            without_layers,
        }))
    }
}
