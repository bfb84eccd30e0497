//! Radiance HDR (`.hdr`, `.pic`): red, green and blue of 8 bits with a common exponent.

use std::io::{self, Read};

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};

use super::{MOST_PIXELS_PER_BYTE, RawImage, Reading, refuse_size, too_short};
use crate::control::{CancelToken, Progress};

/// Bytes that a row takes at least, by the older of the two run-length codings.
const LEAST_ROW_BYTES: u64 = 4;

/// Reads `bytes`; `progress` advances by as many, at the end. `EXPOSURE` and `COLORCORR` lines of the header, which say by what the values
/// were multiplied, are undone.
pub fn read(bytes: &[u8], cancel: &CancelToken, progress: &Progress) -> Reading<RawImage> {
    let source = Watched { bytes, cancel };
    let in_words = |error: image::ImageError| format!("not a whole Radiance HDR file: {error}");
    // Not strict about the first line: "#?RGBE" is common too.
    let decoder = HdrDecoder::new_nonstrict(source).map_err(in_words)?;
    let (width, height) = decoder.dimensions();
    let length = bytes.len() as u64;
    let (width, height) = refuse_size(width.into(), height.into(), length)?;
    let pixels = u64::from(width) * u64::from(height);
    if u64::from(height) * LEAST_ROW_BYTES > length || pixels > MOST_PIXELS_PER_BYTE * length {
        return Err(too_short(length, width, height));
    }
    let metadata = decoder.metadata();
    let decoded = DynamicImage::from_decoder(decoder);
    if cancel.is_cancelled() {
        return Ok(None);
    }
    let values = decoded.map_err(in_words)?.into_rgb32f().into_raw();

    let exposure = metadata.exposure.unwrap_or(1.0);
    let (red, green, blue) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let divisors = [exposure * red, exposure * green, exposure * blue];
    progress.advance(bytes.len() as u64);
    let pixel = |values: &[f32]| std::array::from_fn(|i| values[i] / divisors[i]);
    Ok(Some(RawImage {
        width,
        height,
        pixels: values.chunks_exact(3).map(pixel).collect(),
        warnings: Vec::new(),
    }))
}

/// Bytes that end where reading is cancelled.
struct Watched<'a> {
    bytes: &'a [u8],
    cancel: &'a CancelToken,
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.cancel.is_cancelled() {
            return Ok(0);
        }
        self.bytes.read(buffer)
    }
}
