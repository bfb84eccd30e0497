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
    let frame =
        Frame::find(bytes).map_err(|why| format!("not a JPEG file that can be read: {why}"))?;
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(in_words)?;
    let info = decoder.info().ok_or("not a whole JPEG file")?;
    let length = bytes.len() as u64;
    let (width, height) = refuse_size(info.width.into(), info.height.into(), length)?;
    // Every block of 64 values takes bits: even a small file cannot hold a large image of one colour, as a PNG can.
    if frame.pixels_in_blocks(width, height) > MOST_PIXELS_PER_BYTE * length {
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

/// Side of a block of values.
const BLOCK: u64 = 8;

/// How often the values of a component are taken, next to those of the others.
struct Frame {
    /// Of the component that is sampled most finely, horizontally and vertically, 1 to 4.
    finest: [u8; 2],
}

impl Frame {
    /// Looks for the header of the frame in front of the first scan. The decoder looks too, but panics at components that are sampled in
    /// ways that nobody writes.
    ///
    /// Source: ITU-T T.81, annex B.2.
    fn find(bytes: &[u8]) -> Result<Self, String> {
        const CUT_OFF: &str = "it ends before the header of its frame";
        let mut rest = bytes.get(2..).ok_or(CUT_OFF)?;
        loop {
            let (&[fill, marker], after) = rest.split_first_chunk().ok_or(CUT_OFF)?;
            if fill != 0xff || marker == 0xff || marker == 0 {
                rest = &rest[1..];
                continue;
            }
            let length = after.first_chunk().ok_or(CUT_OFF)?;
            let length = usize::from(u16::from_be_bytes(*length));
            let part = after.get(2..length).ok_or(CUT_OFF)?;
            match marker {
                // Tables and arithmetic coding have numbers among those of frames.
                0xc0..=0xcf if ![0xc4, 0xc8, 0xcc].contains(&marker) => return Self::of(part),
                0xda => return Err("its frame has no header".to_owned()),
                // Of an APP0 of this length the decoder takes one byte more, and then finds another header than this.
                0xe0 if length == 6 => return Err("its APP0 part has no identifier".to_owned()),
                _ => rest = &after[length..],
            }
        }
    }

    /// The frame whose header, from the precision on, is `header`.
    fn of(header: &[u8]) -> Result<Self, String> {
        // Precision, height and width, and the number of components take six bytes, and each component three.
        let components = header.get(6..).unwrap_or_default().chunks_exact(3);
        let mut factors = components.map(|component| [component[1] >> 4, component[1] & 15]);
        let finest = factors.next().ok_or("its frame has no components")?;
        let is_even = |finest: u8, factor: u8| factor > 0 && finest.is_multiple_of(factor);
        let are_even = |factors: [u8; 2]| (0..2).all(|axis| is_even(finest[axis], factors[axis]));
        if finest.iter().any(|factor| !(1..=4).contains(factor)) || !factors.all(are_even) {
            return Err("its components are sampled in a way that cannot be read".to_owned());
        }
        Ok(Self { finest })
    }

    /// How many pixels an image of this size has with those that fill up the blocks at its edges: what decoding takes memory for.
    fn pixels_in_blocks(&self, width: u32, height: u32) -> u64 {
        let filled =
            |side: u32, factor: u8| u64::from(side).next_multiple_of(BLOCK * u64::from(factor));
        filled(width, self.finest[0]) * filled(height, self.finest[1])
    }
}

/// The marker at the end of an image.
const END: [u8; 2] = [0xff, 0xd9];
