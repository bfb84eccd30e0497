use raymini::io::{WrittenOrigin, parse_image, parse_render};
use raymini::scene::RadianceMap;

use super::{assert_message, measured};

/// Bytes of memory per pixel that is read: three numbers, and as many in the decoder.
const MEMORY_PER_PIXEL: usize = 40;

/// Bytes of memory per byte of a file that is read, beside its pixels.
const MEMORY: usize = 64;

/// The same for a file that turns out wrong, whose pixels may have been decoded up to there: one byte in deflate can stand for a
/// thousand, and a bit of these for a pixel.
const MEMORY_OF_WRONG_FILES: usize = 100_000;

/// What readers may take however small the file: profiles and tables.
const FREE_BYTES: usize = 2 << 20;

/// The program's limits on the size of an image.
const FREE_PIXELS: usize = 1 << 24;
pub const MOST_PIXELS_PER_BYTE: usize = 512;

/// Reads `bytes` as a PNG, OpenEXR or Radiance HDR picture. It has as many pixels as it says, and no more than the file can mean.
pub fn check(bytes: &[u8]) {
    let repaired = with_checksums(bytes);
    let bytes = repaired.as_deref().unwrap_or(bytes);
    let (read, peak) = measured(|| parse_image("picture", bytes));
    match read {
        Ok(file) => {
            let image = &file.image;
            let pixels = image.pixels.len();
            assert_size(image.width, image.height, pixels, bytes);
            assert_memory(peak, pixels, bytes);
            for warning in &file.warnings {
                assert_message(warning);
            }
        }
        Err(error) => {
            assert_memory(peak, 0, bytes);
            assert_message(&error.to_string());
        }
    }
    let (origin, peak_of_origin) = measured(|| WrittenOrigin::of_bytes(bytes));
    assert_memory(peak_of_origin, 0, bytes);
    if let Err(error) = origin {
        assert_message(&error);
    }
    let (render, peak) = measured(|| parse_render("picture", bytes));
    // What it tells of itself is read beside its pixels.
    let peak = peak.saturating_sub(peak_of_origin);
    match render {
        Ok(render) => {
            let layers = render.layers.iter().flatten().map(|(_, image)| image);
            let pixels = layers.chain([&render.picture.image]).map(|image| {
                assert_size(image.width, image.height, image.pixels.len(), bytes);
                image.pixels.len()
            });
            assert_memory(peak, pixels.sum(), bytes);
        }
        Err(error) => {
            assert_memory(peak, 0, bytes);
            assert_message(&error.to_string());
        }
    }
}

/// Panics where an image is none, or larger than the file can mean.
pub fn assert_size(width: u32, height: u32, pixels: usize, bytes: &[u8]) {
    assert!(RadianceMap::can_hold(width.into(), height.into()));
    assert_eq!(pixels, width as usize * height as usize);
    assert!(pixels <= FREE_PIXELS.max(MOST_PIXELS_PER_BYTE * bytes.len()));
}

/// Panics where reading `bytes` took more than it may; `pixels` is 0 where none came out.
pub fn assert_memory(peak: usize, pixels: usize, bytes: &[u8]) {
    let per_byte = match pixels {
        0 => MEMORY_OF_WRONG_FILES,
        _ => MEMORY,
    };
    // Header values may claim that many pixels where the compression, DWA, is one for which little says how much a byte can hold.
    let claimed = if pixels == 0 && is_dwa(bytes) {
        FREE_PIXELS
    } else {
        0
    };
    let most = MEMORY_PER_PIXEL * (pixels + claimed) + per_byte * bytes.len() + FREE_BYTES;
    let length = bytes.len();
    assert!(
        peak <= most,
        "{peak} bytes were allocated to read {length} bytes and {pixels} pixels"
    );
}

fn is_dwa(bytes: &[u8]) -> bool {
    const ATTRIBUTE: &[u8] = b"compression\0compression\0\x01\0\0\0";
    let mut places = bytes.windows(ATTRIBUTE.len() + 1);
    places.any(|window| window.starts_with(ATTRIBUTE) && window[ATTRIBUTE.len()] >= 8)
}

/// A PNG whose chunks have the checksums they should have: without, a changed file is hardly looked at. `None` for other files.
pub fn with_checksums(bytes: &[u8]) -> Option<Vec<u8>> {
    const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
    bytes.starts_with(SIGNATURE).then_some(())?;
    let mut repaired = bytes.to_vec();
    let mut at = SIGNATURE.len();
    // A chunk: the length of its data, its name, the data, the checksum of the latter two.
    while let Some(length) = repaired.get(at..).and_then(<[u8]>::first_chunk) {
        let Some(end) = (at + 8).checked_add(u32::from_be_bytes(*length) as usize) else {
            break;
        };
        let Some(named) = repaired.get(at + 4..end) else {
            break;
        };
        let sum = crc32(named).to_be_bytes();
        let Some(place) = repaired.get_mut(end..end + 4) else {
            break;
        };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
    Some(repaired)
}

/// The checksum of PNG and zip, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xEDB8_8320 * (sum & 1))
        })
    })
}
