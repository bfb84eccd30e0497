//! Images of a document: files beside it, or bytes within it.

use std::borrow::Cow;

use super::accessor::{Data, beyond};
use super::container;
use super::document::{Document, Image, Index, TextureInfo};
use super::uri::{self, Uri};
use super::{Load, buffers};
use crate::io::mesh_reading::{List, Malformed, Place};
use crate::io::remarks::Remarks;

/// What the name of an image within a file begins with; its number follows.
const PREFIX: &str = "image ";

/// The number in the name of an image within a file.
#[must_use]
pub fn image_number(part: &str) -> Option<u32> {
    part.strip_prefix(PREFIX)?.parse().ok()
}

/// The code of OpenGL for images that repeat.
const REPEAT: u32 = 10_497;

/// Where an image is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImageName {
    /// A file, by its name relative to the document's.
    File(String),
    /// Within the document, by its name there.
    Within(String),
}

/// The image that a texture shows, if it can be shown; of one that cannot, `remarks` say so of the material called `material`.
pub fn image_of(
    document: &Document,
    texture: &TextureInfo,
    material: &str,
    remarks: &mut Remarks,
) -> Option<ImageName> {
    if texture.coordinates() != 0 {
        remarks.add(
            material,
            "has an image by other coordinates than the first, which is not shown",
        );
        return None;
    }
    if texture.scale.is_some_and(|scale| scale != 1.0) {
        remarks.add(
            material,
            "has normals that are to be made steeper or flatter, which is not heeded",
        );
    }
    let record = document.textures.get(texture.index as usize);
    let sampler = record.and_then(|texture| texture.sampler);
    let sampler = sampler.and_then(|sampler| document.samplers.get(sampler as usize));
    let ends = |wrap: Option<u32>| wrap.is_some_and(|wrap| wrap != REPEAT);
    if sampler.is_some_and(|sampler| ends(sampler.wrap_s) || ends(sampler.wrap_t)) {
        remarks.add(
            material,
            "has an image that ends or is mirrored at its edges; it repeats here",
        );
    }
    let number = record.and_then(|texture| texture.source);
    let image = number.and_then(|number| Some((number, document.images.get(number as usize)?)));
    let Some((number, image)) = image else {
        remarks.add(
            material,
            "has an image that is not in the file, or of another format",
        );
        return None;
    };
    if let Some(Some(name)) = image.uri.as_deref().map(uri::without_data) {
        return Some(ImageName::File(name.into_owned()));
    }
    // However often a file says that it is an image, it is one.
    let is_same = |other: &Image| other.uri == image.uri && other.buffer_view == image.buffer_view;
    let first = document.images.iter().position(is_same);
    let first = first.and_then(|first| u32::try_from(first).ok());
    let number = first.unwrap_or(number);
    Some(ImageName::Within(format!("{PREFIX}{number}")))
}

/// A file of which images are taken: however many there are, it is understood once.
pub struct ImageFile {
    bytes: Vec<u8>,
    document: Document,
    /// The bytes of all buffers, once an image was in one; `None` for what is in the file.
    buffers: Option<Vec<Option<Vec<u8>>>>,
}

impl ImageFile {
    /// The file whose bytes these are.
    ///
    /// # Errors
    /// What breaks the rules of the format.
    pub fn new(bytes: Vec<u8>) -> Result<Self, Malformed> {
        let document = Document::parse(container::take_apart(&bytes)?.json)?;
        Ok(Self {
            bytes,
            document,
            buffers: None,
        })
    }

    /// The bytes of the image of number `index`. `load` gives the bytes of other files; `None` when cancelled.
    ///
    /// # Errors
    /// What breaks the rules of the format, or that there is no such image.
    pub fn image(
        &mut self,
        index: Index,
        load: &mut Load<'_>,
    ) -> Result<Option<Vec<u8>>, Malformed> {
        let images = &self.document.images;
        let image = images
            .get(index as usize)
            .ok_or_else(|| beyond(List::Images, index, images.len()))?;
        let place = Place::Item(List::Images, index);
        if let Some(uri) = &image.uri {
            return match uri::read(uri) {
                Ok(Uri::Data(bytes)) => Ok(Some(bytes)),
                Ok(Uri::File(_)) => Err(Malformed::at(
                    place,
                    "an image within the file",
                    "another file",
                )),
                Err(found) => Err(Malformed::at(place, "data in base64", found)),
            };
        }
        let view = image.buffer_view.ok_or_else(|| {
            Malformed::at(place, "an image with a uri or a bufferView", "neither")
        })?;
        let binary = container::take_apart(&self.bytes)?.binary;
        let known = match self.buffers.take() {
            Some(known) => known,
            None => match buffers(&self.document, binary, load)? {
                Some(buffers) => buffers
                    .into_iter()
                    .map(|buffer| match buffer {
                        Cow::Borrowed(_) => None,
                        Cow::Owned(bytes) => Some(bytes),
                    })
                    .collect(),
                None => return Ok(None),
            },
        };
        let buffers = known.iter().map(|bytes| match bytes {
            Some(bytes) => Cow::Borrowed(&bytes[..]),
            None => Cow::Borrowed(binary.unwrap_or_default()),
        });
        let data = Data::new(&self.document, buffers.collect(), 0);
        let bytes = data.view(view).map(<[u8]>::to_vec);
        drop(data);
        self.buffers = Some(known);
        bytes.map(Some)
    }
}
