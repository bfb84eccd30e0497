//! The picture in the file of a render that is opened: what was rendered is there to be looked at and compared with at once.

use std::path::Path;
use std::sync::Arc;

use super::picture_buffer::PictureBuffer;
use crate::io::{self, WrittenError, WrittenOrigin};
use crate::scene::{Display, Scene};

/// What a file shows of its render.
#[derive(Debug)]
pub struct OpenedPicture {
    /// Its pixels, without layers.
    pub buffer: Arc<PictureBuffer>,
    /// SHA-256 of the linear picture; `None` where the file has rounded it.
    pub hash: Option<String>,
    /// How wrong it is, where the file tells.
    pub error: Option<WrittenError>,
}

impl OpenedPicture {
    /// The picture in `path`, a file of a render of `scene`, to be shown on textures of at most `largest_texture` texels a side. `None` where
    /// it has been given a look that cannot be taken back: a PNG holds what the screen showed.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    pub fn read(
        path: &Path,
        scene: &Scene,
        largest_texture: u32,
    ) -> Result<Option<Self>, io::PictureError> {
        let file = io::read_image(path)?;
        if !file.is_linear && scene.display != Display::default() {
            return Ok(None);
        }
        let origin = WrittenOrigin::of_file(path).unwrap_or_default();
        let hash = file.is_linear.then(|| file.image.hash());
        let buffer = PictureBuffer::of_image(file.image, scene.display, largest_texture);
        Ok(Some(Self {
            buffer: Arc::new(buffer),
            hash,
            error: origin.error,
        }))
    }
}
