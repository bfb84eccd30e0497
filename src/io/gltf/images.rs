//! Images of a document: files beside it, or bytes within it.

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
    if texture.tex_coord != 0 {
        remarks.add(
            material,
            "has an image by other coordinates than the first, which is not shown",
        );
        return None;
    }
    if texture
        .extensions
        .as_ref()
        .is_some_and(|extensions| extensions.transform.is_some())
    {
        remarks.add(
            material,
            "has an image that is moved or scaled, which is not heeded",
        );
    }
    let record = document.textures.get(texture.index as usize);
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

/// The bytes of the image of number `index` in the file whose bytes these are. `load` gives the bytes of other files; `None` when
/// cancelled.
///
/// # Errors
/// What breaks the rules of the format, or that there is no such image.
pub fn image(
    bytes: &[u8],
    index: Index,
    load: &mut Load<'_>,
) -> Result<Option<Vec<u8>>, Malformed> {
    let container = container::take_apart(bytes)?;
    let document = Document::parse(container.json)?;
    let images = &document.images;
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
    let view = image
        .buffer_view
        .ok_or_else(|| Malformed::at(place, "an image with a uri or a bufferView", "neither"))?;
    let Some(buffers) = buffers(&document, container.binary, load)? else {
        return Ok(None);
    };
    let data = Data::new(&document, buffers, 0);
    Ok(Some(data.view(view)?.to_vec()))
}
