use raymini::control::{CancelToken, Progress};
use raymini::io::{parse_image, parse_radiance};

use super::picture::{assert_memory, assert_size};
use super::{assert_message, measured};

/// Reads `bytes` as an image of radiance. It holds radiance only, and otherwise what the same file holds as a picture.
pub fn check(bytes: &[u8]) {
    let progress = Progress::new();
    let (read, peak) = measured(|| parse_radiance("sky", bytes, &CancelToken::new(), &progress));
    let file = match read {
        Ok(file) => file.expect("nobody cancels"),
        Err(error) => {
            assert_memory(peak, 0, bytes);
            return assert_message(&error.to_string());
        }
    };
    let (map, pixels) = (&file.map, file.map.pixels());
    assert_size(map.width(), map.height(), pixels.len(), bytes);
    assert_memory(peak, pixels.len(), bytes);
    assert_eq!(progress.done(), bytes.len() as u64);
    for warning in &file.warnings {
        assert_message(warning);
    }

    let picture = parse_image("sky", bytes).expect("is a picture too").image;
    assert_eq!((picture.width, picture.height), (map.width(), map.height()));
    let is_radiance = |value: f32| value.is_finite() && value >= 0.0;
    let mut cleaned = 0;
    for (radiance, written) in pixels.iter().zip(&picture.pixels) {
        assert!(radiance.iter().all(|&value| is_radiance(value)));
        let expected = written.map(|value| if is_radiance(value) { value } else { 0.0 });
        assert_eq!(*radiance, expected);
        cleaned += u64::from(!written.iter().all(|&value| is_radiance(value)));
    }
    assert_eq!(file.cleaned, cleaned);
}
