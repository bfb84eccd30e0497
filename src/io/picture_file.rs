//! Pictures from files, to be measured: PNG, OpenEXR and Radiance HDR, by this program or any other.
//!
//! Values come as they stand in the file, negative and not finite ones too. A PNG is taken as sRGB and decoded to linear
//! values; of alpha nothing is applied.

use std::io::Cursor;
use std::path::Path;

use super::radiance_file::{RawImage, black, read_values, refuse_size};
use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};
use crate::math::color::linear_from_srgb;
use crate::render::Image;

/// The formats that have a reader, for messages.
pub const PICTURE_FORMATS: &str = "PNG (.png), OpenEXR (.exr) and Radiance HDR (.hdr)";

/// What a picture's file held.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureFile {
    /// Its pixels, in linear RGB.
    pub image: Image,
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

/// Why a picture could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct PictureError {
    /// The file, as it was asked for.
    pub name: String,
    /// What is wrong and what was expected, in a plain sentence.
    pub reason: String,
}

/// Reads the picture at `path`. The content says which format it is; the name may say what it likes.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, is malformed or ends early, or holds a size that cannot be
/// held.
pub fn read_image(path: &Path) -> Result<PictureFile, PictureError> {
    read(path).map_err(|reason| PictureError {
        name: path.display().to_string(),
        reason,
    })
}

fn read(path: &Path) -> Result<PictureFile, String> {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let bytes = read_file(path, "a picture", &cancel, &progress)?;
    parse(&bytes.expect("nobody cancels"))
}

/// The picture in `bytes`, which are those of a whole file.
fn parse(bytes: &[u8]) -> Result<PictureFile, String> {
    let (format, raw) = if bytes.starts_with(b"\x89PNG") {
        ("PNG", read_png(bytes)?)
    } else {
        let (cancel, progress) = (CancelToken::new(), Progress::new());
        read_values(bytes, PICTURE_FORMATS, &cancel, &progress)?.expect("nobody cancels")
    };
    Ok(PictureFile {
        image: Image {
            width: raw.width,
            height: raw.height,
            pixels: raw.pixels,
        },
        format,
        warnings: raw.warnings,
    })
}

/// Most bytes that one byte of a PNG's compressed data can stand for.
///
/// Source: zlib's technical details: the limit of deflate is 1032:1.
const MOST_DEFLATED: u64 = 1032;

/// Reads a PNG of any kind. Of an animation the first frame is taken.
fn read_png(bytes: &[u8]) -> Result<RawImage, String> {
    let in_words = |error: png::DecodingError| format!("not a whole PNG file: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // Palettes become colours, and fewer than 8 bits become 8.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(in_words)?;
    let info = reader.info();
    let (width, height) = refuse_size(info.width.into(), info.height.into())?;
    let stored = info.raw_row_length() as u64 * u64::from(height);
    if stored > MOST_DEFLATED * bytes.len() as u64 {
        return Err(format!(
            "the file ends early: {} bytes cannot hold {width}×{height} pixels",
            bytes.len()
        ));
    }
    let mut warnings = color_warnings(info);
    let length = reader
        .output_buffer_size()
        .ok_or_else(|| format!("there is no memory for an image of {width}×{height}"))?;
    let mut pixels = black(width, height)?;
    let mut encoded = vec![0; length];
    let frame = reader.next_frame(&mut encoded).map_err(in_words)?;
    // To the end, so that a file cut off there is noticed.
    reader.finish().map_err(in_words)?;
    if (frame.width, frame.height) != (width, height) {
        return Err("the first frame of its animation is not the whole picture".to_owned());
    }

    let alpha_is_opaque = if frame.bit_depth == png::BitDepth::Sixteen {
        let values = encoded.as_chunks().0.iter();
        let values = values.map(|&pair| usize::from(u16::from_be_bytes(pair)));
        fill(&mut pixels, frame.color_type, usize::from(u16::MAX), values)
    } else {
        let values = encoded.iter().map(|&value| usize::from(value));
        fill(&mut pixels, frame.color_type, usize::from(u8::MAX), values)
    };
    if !alpha_is_opaque {
        warnings.push("some pixels are not opaque; their colours are taken as written".to_owned());
    }
    Ok(RawImage {
        width,
        height,
        pixels,
        warnings,
    })
}

/// Decodes `values` of `0..=most`, as many per pixel as `color` has channels. Returns whether alpha, where there is one, is
/// opaque throughout.
fn fill(
    pixels: &mut [[f32; 3]],
    color: png::ColorType,
    most: usize,
    mut values: impl Iterator<Item = usize>,
) -> bool {
    let linear: Vec<f32> = (0..=most)
        .map(|value| linear_from_srgb(value as f32 / most as f32))
        .collect();
    let colors = match color {
        png::ColorType::Grayscale | png::ColorType::GrayscaleAlpha => 1,
        png::ColorType::Rgb | png::ColorType::Rgba | png::ColorType::Indexed => 3,
    };
    let has_alpha = color.samples() > colors;
    let mut is_opaque = true;
    for pixel in pixels {
        let mut next = || values.next().expect("the decoder gives every pixel");
        *pixel = match colors {
            1 => [linear[next()]; 3],
            _ => [linear[next()], linear[next()], linear[next()]],
        };
        if has_alpha {
            is_opaque &= next() == most;
        }
    }
    is_opaque
}

/// What is said where a PNG may mean other colours than sRGB.
fn color_warnings(info: &png::Info) -> Vec<String> {
    /// What encoders write for sRGB: 1/2.2, in hundred thousandths.
    const SRGB_GAMMA: u32 = 45_455;
    /// Code points of ITU-T H.273: primaries of Rec. 709, transfer curve of sRGB.
    const SRGB_CODE_POINTS: (u8, u8) = (1, 13);

    let code_points = info
        .coding_independent_code_points
        .map(|points| (points.color_primaries, points.transfer_function));
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_scaled);
    let claim = if code_points.is_some_and(|points| points != SRGB_CODE_POINTS) {
        "names another colour space"
    } else if info.icc_profile.is_some() {
        "has a colour profile"
    } else if info.srgb.is_none() && gamma.is_some_and(|gamma| gamma != SRGB_GAMMA) {
        "names another gamma"
    } else {
        return Vec::new();
    };
    vec![format!(
        "the file {claim}, which is not applied: its values are taken as sRGB"
    )]
}

#[cfg(test)]
mod tests;
