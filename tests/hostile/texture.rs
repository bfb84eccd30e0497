use raymini::control::{CancelToken, Progress};
use raymini::io::parse_texture;

use super::picture::{MOST_PIXELS_PER_BYTE, assert_memory, assert_size, with_checksums};
use super::{assert_message, measured};

/// Reads `bytes` as an image to be laid on surfaces. It has as many texels as it says, and no more than the file can mean.
pub fn check(bytes: &[u8]) {
    let repaired = with_checksums(bytes);
    let bytes = repaired.as_deref().unwrap_or(bytes);
    let progress = Progress::new();
    let (read, peak) = measured(|| parse_texture("image", bytes, &CancelToken::new(), &progress));
    let file = match read {
        Ok(file) => file.expect("nobody cancels"),
        Err(error) => {
            assert_memory(peak, 0, bytes);
            return assert_message(&error.to_string());
        }
    };
    let (image, texels) = (&file.image, file.image.texels().len());
    assert_size(image.width(), image.height(), texels, bytes);
    // A JPEG is decoded in squares of up to 32 pixels, however low it is: as many as its bytes can mean.
    let squares = |side: u32| (side as usize).next_multiple_of(32);
    let in_squares = squares(image.width()) * squares(image.height());
    let in_squares = in_squares.min(MOST_PIXELS_PER_BYTE * bytes.len());
    let is_jpeg = bytes.starts_with(&[0xff, 0xd8]);
    let decoded = if is_jpeg {
        in_squares.max(texels)
    } else {
        texels
    };
    assert_memory(peak, decoded, bytes);
    assert_eq!(progress.done(), bytes.len() as u64);
    assert!(image.mean_color().is_finite() && image.mean_color().min_element() >= 0.0);
    for warning in &file.warnings {
        assert_message(warning);
    }
}
