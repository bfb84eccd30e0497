//! JPEG images as textures, decoded to RGB of 8 bits and taken as sRGB.

use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::io::radiance_file::{MOST_PIXELS_PER_BYTE, RawImage, no_memory, refuse_size, too_short};
use crate::scene::RadianceMap;

/// Reads a JPEG, grey or coloured, as RGB of 8 bits.
///
/// # Errors
/// What is wrong with the file, in a plain sentence.
pub fn read(bytes: &[u8]) -> Result<RawImage<u8>, String> {
    let in_words = |error: DecodeErrors| {
        // Some end with a line end.
        format!("not a whole JPEG file: {}", error.to_string().trim())
    };
    let side = RadianceMap::MAX_SIDE as usize;
    let options = DecoderOptions::default()
        .set_max_width(side)
        .set_max_height(side)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(in_words)?;
    let info = decoder.info().ok_or("not a whole JPEG file")?;
    let length = bytes.len() as u64;
    let (width, height) = refuse_size(info.width.into(), info.height.into(), length)?;
    // Every block of 64 values takes bits: even a small file cannot hold a large image of one colour, as a PNG can.
    if u64::from(width) * u64::from(height) > MOST_PIXELS_PER_BYTE * length {
        return Err(too_short(length, width, height));
    }
    let mut rgb: Vec<[u8; 3]> = Vec::new();
    let count = width as usize * height as usize;
    rgb.try_reserve_exact(count)
        .map_err(|_| no_memory(width, height))?;
    rgb.resize(count, [0; 3]);
    decoder
        .decode_into(rgb.as_flattened_mut())
        .map_err(in_words)?;

    let mut warnings = Vec::new();
    // The decoder fills with grey what is not there.
    if !bytes.array_windows().any(|pair| *pair == END) {
        warnings.push("the file has no end: it may be cut off, and grey from there on".to_owned());
    }
    if decoder.icc_profile().is_some() {
        warnings.push(
            "the file has a colour profile, which is not applied: its values are taken as sRGB"
                .to_owned(),
        );
    }
    Ok(RawImage {
        width,
        height,
        pixels: rgb,
        warnings,
    })
}

/// The marker at the end of an image.
const END: [u8; 2] = [0xff, 0xd9];
