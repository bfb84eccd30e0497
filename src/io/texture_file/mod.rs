//! Images to be laid on surfaces: PNG, JPEG, OpenEXR and Radiance HDR.
//!
//! Values come as they stand in the file, so that an image takes no more memory than it needs, and the material may say whether they
//! are colours or normals. Of alpha nothing is applied.

mod jpeg;

use std::path::Path;

use super::picture_file::read_png;
use super::radiance_file::{RadianceError, RawImage, Reading, parse_values};
use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};
use crate::scene::{RadianceMap, Texels, TextureImage};

/// The formats that have a reader, for messages and file dialogs.
pub const TEXTURE_FORMATS: &str = "PNG (.png), JPEG (.jpg), OpenEXR (.exr) and Radiance HDR (.hdr)";

/// File name extensions, in lower case, of the formats that have a reader.
pub const TEXTURE_EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "exr", "hdr"];

/// What the file of a texture held.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureFile {
    /// Its texels.
    pub image: TextureImage,
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

/// Loads the texture at `path`. The content says which format it is; the name may say what it likes.
///
/// `progress` advances by bytes, each once when it is read and once when it is understood; setting its total is the
/// caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, is malformed, or holds a size that cannot be held.
pub fn load_texture(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<TextureFile>, RadianceError> {
    let read = read_file(path, "an image file", cancel, progress);
    let read = read.and_then(|bytes| match bytes {
        Some(bytes) => parse(&bytes, cancel, progress),
        None => Ok(None),
    });
    read.map_err(|reason| RadianceError {
        name: path.display().to_string(),
        reason,
    })
}

/// The texture in `bytes`, which are those of a whole file; `name` stands for the path in messages.
///
/// `progress` advances by the bytes understood; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the bytes are of a format without reader, malformed, or hold a size that cannot be held.
pub fn parse_texture(
    name: &str,
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<TextureFile>, RadianceError> {
    parse(bytes, cancel, progress).map_err(|reason| RadianceError {
        name: name.to_owned(),
        reason,
    })
}

fn parse(bytes: &[u8], cancel: &CancelToken, progress: &Progress) -> Reading<TextureFile> {
    if bytes.starts_with(b"\x89PNG") {
        let file = png(bytes)?;
        progress.advance(bytes.len() as u64);
        return Ok(Some(file));
    }
    if bytes.starts_with(b"\xff\xd8\xff") {
        let raw = jpeg::read(bytes)?;
        progress.advance(bytes.len() as u64);
        return Ok(Some(texture("JPEG", raw, Texels::Bytes)));
    }
    let Some(file) = parse_values(bytes, TEXTURE_FORMATS, cancel, progress)? else {
        return Ok(None);
    };
    let (width, height) = (file.map.width(), file.map.height());
    let texels = Texels::Floats(RadianceMap::into_pixels(file.map));
    Ok(Some(TextureFile {
        image: TextureImage::new(width, height, texels),
        format: file.format,
        warnings: file.warnings,
    }))
}

/// Reads a PNG with as many bits as it has, at least 8.
fn png(bytes: &[u8]) -> Result<TextureFile, String> {
    /// Where its header says how many bits a sample has.
    const DEPTH_AT: usize = 24;
    const FITS: &str = "codes have so many bits";
    Ok(if bytes.get(DEPTH_AT) == Some(&16) {
        let word = |code, _| u16::try_from(code).expect(FITS);
        texture("PNG", read_png(bytes, word)?, Texels::Words)
    } else {
        let byte = |code, _| u8::try_from(code).expect(FITS);
        texture("PNG", read_png(bytes, byte)?, Texels::Bytes)
    })
}

fn texture<T>(
    format: &'static str,
    raw: RawImage<T>,
    texels: impl FnOnce(Vec<[T; 3]>) -> Texels,
) -> TextureFile {
    TextureFile {
        image: TextureImage::new(raw.width, raw.height, texels(raw.pixels)),
        format,
        warnings: raw.warnings,
    }
}

#[cfg(test)]
mod tests;
