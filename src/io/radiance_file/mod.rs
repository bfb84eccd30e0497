//! Images of radiance from files: OpenEXR and Radiance HDR, for backgrounds and to be compared.
//!
//! A reader takes bytes and gives the values as they stand in the file; this module finds the reader, refuses sizes that no
//! image has before anything is allocated, and cleans what is no radiance.

mod exr;
mod hdr;

use std::fmt::Display;
use std::path::Path;

use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};
use crate::memory::require;
use crate::scene::RadianceMap;

/// The formats that have a reader, for messages and file dialogs.
pub const RADIANCE_FORMATS: &str = "OpenEXR (.exr) and Radiance HDR (.hdr)";

/// File name extensions, in lower case, of the formats that have a reader.
pub const RADIANCE_EXTENSIONS: &[&str] = &["exr", "hdr"];

/// What an image file held.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceFile {
    /// Its pixels.
    pub map: RadianceMap,
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// In how many pixels a value was no radiance and became 0.
    pub cleaned: u64,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

/// Why an image could not be loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct RadianceError {
    /// The file, as it was asked for.
    pub name: String,
    /// What is wrong and what was expected, in a plain sentence.
    pub reason: String,
}

/// Values as they stand in a file, row by row from the top left.
#[derive(Debug)]
pub struct RawImage<T = f32> {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGB, linear where `T` is a float, whatever the file holds: negative, infinite and not a number too.
    pub pixels: Vec<[T; 3]>,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

/// What a reader of one format returns: `None` when cancelled, errors as sentences.
pub type Reading<T> = Result<Option<T>, String>;

/// Images beside the main one that were asked for by name, each with the place of its name; or why there is no room for them, in a sentence.
pub type Named = Result<Vec<(usize, RawImage)>, String>;

/// What is in a file, as it stands there.
#[derive(Debug)]
pub struct RawFile {
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// The main image.
    pub image: RawImage,
    /// Those beside it.
    pub named: Named,
}

/// Loads the image at `path`.
///
/// `progress` advances by bytes, each once when it is read and once when it is understood; setting its total is the
/// caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, is malformed, or holds a size that cannot be held.
pub fn load_radiance(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<RadianceFile>, RadianceError> {
    let name = path.display().to_string();
    let expected = "an image file";
    let read = read_file(path, expected, cancel, progress).and_then(|bytes| match bytes {
        Some(bytes) => parse(&bytes, cancel, progress),
        None => Ok(None),
    });
    read.map_err(|reason| RadianceError { name, reason })
}

/// The image in `bytes`, which are those of a whole file; `name` stands for the path in messages.
///
/// `progress` advances by the bytes understood; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the bytes are of a format without reader, malformed, or hold a size that cannot be held.
pub fn parse_radiance(
    name: &str,
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<RadianceFile>, RadianceError> {
    parse(bytes, cancel, progress).map_err(|reason| RadianceError {
        name: name.to_owned(),
        reason,
    })
}

/// The image in `bytes`, which are those of a whole file.
fn parse(bytes: &[u8], cancel: &CancelToken, progress: &Progress) -> Reading<RadianceFile> {
    parse_values(bytes, RADIANCE_FORMATS, cancel, progress)
}

/// The image in `bytes`, which are those of a whole file, cleaned.
///
/// `expected`: the formats that would do, for the message about another one.
pub fn parse_values(
    bytes: &[u8],
    expected: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Reading<RadianceFile> {
    let values = read_values(bytes, &[], expected, cancel, progress)?;
    let Some(RawFile { format, image, .. }) = values else {
        return Ok(None);
    };
    let RawImage {
        width,
        height,
        pixels,
        mut warnings,
    } = image;
    let (map, cleaned) = RadianceMap::cleaned(width, height, pixels);
    if cleaned > 0 {
        warnings.push(format!(
            "in {cleaned} of {} pixels a value is negative, infinite or not a number; it is taken as 0",
            map.pixels().len()
        ));
    }
    Ok(Some(RadianceFile {
        map,
        format,
        cleaned,
        warnings,
    }))
}

/// What is in the file whose bytes these are, as it stands there: the main image, and those called by one of `names`, as
/// [`write_image`](super::write_image) calls layers. Formats but OpenEXR have none of these.
///
/// `expected`: the formats that would do, for the message about another one.
pub fn read_values(
    bytes: &[u8],
    names: &[&str],
    expected: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Reading<RawFile> {
    let (format, read) = match recognise(bytes, expected)? {
        Format::Exr => ("OpenEXR", exr::read(bytes, names, cancel, progress)?),
        Format::Hdr => {
            let image = hdr::read(bytes, cancel, progress)?;
            ("Radiance HDR", image.map(|image| (image, Ok(Vec::new()))))
        }
    };
    Ok(read.map(|(image, named)| RawFile {
        format,
        image,
        named,
    }))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Exr,
    Hdr,
}

/// The format of a file by its content; its name may say what it likes.
fn recognise(bytes: &[u8], expected: &str) -> Result<Format, String> {
    if bytes.is_empty() {
        return Err("the file is empty".to_owned());
    }
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return Ok(Format::Exr);
    }
    if bytes.starts_with(b"#?") {
        return Ok(Format::Hdr);
    }
    let known: [(&[u8], &str); 6] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"II*\0", "a TIFF picture"),
        (b"MM\0*", "a TIFF picture"),
        (b"PF\n", "a PFM picture"),
        (b"BM", "a BMP picture"),
    ];
    let what = known
        .iter()
        .find(|(magic, _)| bytes.starts_with(magic))
        .map_or("not a known kind of image", |(_, what)| what);
    Err(format!("this is {what}; expected {expected}"))
}

/// Pixels that any file may hold, as many as two pictures of 4K have.
const FREE_PIXELS: u64 = 1 << 24;

/// Beyond [`FREE_PIXELS`], most pixels per byte of the file. No picture of RGB in deflate reaches it, whatever it shows.
pub const MOST_PIXELS_PER_BYTE: u64 = 512;

/// An error about a size that no image has, that cannot be held, or that a file of `length` bytes can hardly mean.
pub fn refuse_size(width: u64, height: u64, length: u64) -> Result<(u32, u32), String> {
    if !RadianceMap::can_hold(width, height) {
        return Err(format!(
            "the image is said to be {width}×{height}; expected sides of 1 to {} and at most {} pixels",
            RadianceMap::MAX_SIDE,
            RadianceMap::MAX_PIXELS
        ));
    }
    if width * height > FREE_PIXELS.max(MOST_PIXELS_PER_BYTE * length) {
        return Err(too_short(length, width, height));
    }
    let side = |side| u32::try_from(side).expect("the limit is far below");
    let (width, height) = (side(width), side(height));
    // Asked before it is taken: the system promises more than it has. Smaller ones are anybody's.
    let pixels = u64::from(width) * u64::from(height);
    if pixels > FREE_PIXELS {
        require(pixels * BYTES_PER_PIXEL)
            .map_err(|short| format!("an image of {width}×{height} takes about {short}"))?;
    }
    Ok((width, height))
}

/// Memory of a pixel: three floats, or as many bytes and what a texture is made of.
const BYTES_PER_PIXEL: u64 = 12;

/// Room for an image of a size that a header claims: memory that is not there is an error, not an end.
pub fn black(width: u32, height: u32) -> Result<Vec<[f32; 3]>, String> {
    let count = width as usize * height as usize;
    let mut pixels = Vec::new();
    pixels
        .try_reserve_exact(count)
        .map_err(|_| no_memory(width, height))?;
    pixels.resize(count, [0.0; 3]);
    Ok(pixels)
}

/// What is said of a file whose `length` bytes cannot mean an image of this size.
pub fn too_short(length: u64, width: impl Display, height: impl Display) -> String {
    format!("the file is too short: {length} bytes hardly hold {width}×{height} pixels")
}

/// What is said where there is no room for an image of this size.
pub fn no_memory(width: u32, height: u32) -> String {
    format!("there is no memory for an image of {width}×{height}")
}

#[cfg(test)]
mod tests;
