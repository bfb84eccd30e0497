//! The small picture of what was rendered.

use crate::render::Image;

/// The most pixels of the small picture along its longer side.
const LONGER_SIDE: u32 = 320;

/// `image`, where it is larger than a page needs as the means over blocks of its pixels. Pixels that are not finite do not count.
pub(super) fn small(image: &Image) -> Image {
    let longer = image.width.max(image.height);
    if longer <= LONGER_SIDE {
        return image.clone();
    }
    let scaled = |side: u32| {
        let side = u64::from(side) * u64::from(LONGER_SIDE) / u64::from(longer);
        u32::try_from(side.max(1)).expect("no longer than before")
    };
    let mut small = Image::black(scaled(image.width), scaled(image.height));
    let (width, height) = (small.width as usize, small.height as usize);
    for (number, pixel) in small.pixels.iter_mut().enumerate() {
        let columns = block(number % width, width, image.width as usize);
        let rows = block(number / width, height, image.height as usize);
        *pixel = mean(image, columns, rows);
    }
    small
}

/// What number `index` of `count` blocks of a side of this `length` covers.
fn block(index: usize, count: usize, length: usize) -> std::ops::Range<usize> {
    index * length / count..(index + 1) * length / count
}

/// The mean of the finite pixels of a block; black where none is.
fn mean(image: &Image, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> [f32; 3] {
    let (mut sums, mut count) = ([0.0_f64; 3], 0.0);
    for row in rows {
        let start = row * image.width as usize;
        let pixels = &image.pixels[start + columns.start..start + columns.end];
        let finite = pixels
            .iter()
            .filter(|p| p.iter().all(|value| value.is_finite()));
        for pixel in finite {
            count += 1.0;
            for (sum, value) in sums.iter_mut().zip(pixel) {
                *sum += f64::from(*value);
            }
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "a mean of such values")]
    let mean = |sum: f64| {
        if count > 0.0 {
            (sum / count) as f32
        } else {
            0.0
        }
    };
    sums.map(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_stay_and_large_ones_keep_their_mean_and_shape() {
        let mut image = Image::black(320, 2);
        image.pixels[5] = [3.0; 3];
        assert_eq!(small(&image), image);

        // Each pixel of 640 × 480 becomes a quarter of one of 320 × 240.
        let mut image = Image::black(640, 480);
        image.pixels[640 * 479 + 639] = [4.0, 2.0, 0.0];
        image.pixels[0] = [f32::NAN; 3];
        image.pixels[1] = [3.0; 3];
        let small_one = small(&image);
        assert_eq!((small_one.width, small_one.height), (320, 240));
        assert_eq!(small_one.pixels[320 * 240 - 1], [1.0, 0.5, 0.0]);
        assert_eq!(small_one.pixels[0], [1.0; 3]);
        let thin = small(&Image::black(3200, 1));
        assert_eq!((thin.width, thin.height), (320, 1));
    }
}
