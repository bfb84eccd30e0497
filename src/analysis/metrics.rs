//! How far a picture is from a reference.
//!
//! Everything is measured on linear values; the one measure of what an eye may see says so. A pixel with a value that is not
//! finite, in either picture, has no distance: it is left out of sums, means and ranks, and counted.

use crate::math::CompensatedSum;
use crate::render::display::encode;
use crate::render::{Image, RELATIVE_FLOOR};
use crate::scene::Display;

/// More than one step of 8 bits between encoded values. The thousandth is for what rounding does to a step on its way through
/// the sRGB curve and back.
const VISIBLE: f32 = 1.001 / 255.0;

/// The two pictures are not of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the sizes differ: {}×{} and {}×{} pixels", a.0, a.1, b.0, b.1)]
pub struct SizesDiffer {
    /// Width and height of the picture, in pixels.
    pub a: (u32, u32),
    /// Width and height of the reference.
    pub b: (u32, u32),
}

/// Mean squared differences of a picture from a reference, over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquaredErrors {
    /// Mean of (x − ref)²; NaN where no pixel is compared.
    pub mse: f64,
    /// Mean of (x − ref)² / (ref² + 0.01); NaN where no pixel is compared.
    pub relmse: f64,
    /// How many pixels are compared; the others are not finite in one of the pictures.
    pub compared_pixels: u64,
}

impl SquaredErrors {
    /// Measures `a` against the reference `b`. Allocates nothing.
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn measure(a: &Image, b: &Image) -> Result<Self, SizesDiffer> {
        check_sizes(a, b)?;
        let (mut squares, mut ratios) = (CompensatedSum::default(), CompensatedSum::default());
        let mut compared_pixels = 0;
        for (&a, &b) in a.pixels.iter().zip(&b.pixels) {
            if !(is_finite(a) && is_finite(b)) {
                continue;
            }
            let (mut square, mut ratio) = (0.0, 0.0);
            for (a, b) in a.into_iter().zip(b) {
                let (a, b) = (f64::from(a), f64::from(b));
                let squared = (a - b) * (a - b);
                square += squared;
                ratio += squared / (b * b + RELATIVE_FLOOR);
            }
            squares.add(square);
            ratios.add(ratio);
            compared_pixels += 1;
        }
        let values = 3.0 * compared_pixels as f64;
        Ok(Self {
            mse: squares.total() / values,
            relmse: ratios.total() / values,
            compared_pixels,
        })
    }

    /// The root of [`mse`](Self::mse), in the unit of the pictures.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        self.mse.sqrt()
    }

    /// The root of [`relmse`](Self::relmse).
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.relmse.sqrt()
    }
}

/// A difference and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocatedDifference {
    /// |x − ref| of one channel.
    pub value: f64,
    /// Column from the left.
    pub x: u32,
    /// Row from the top.
    pub y: u32,
}

/// All that is measured between a picture A and a reference B.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// Mean squared errors, and over how many pixels they and all below but the counts are taken.
    pub errors: SquaredErrors,
    /// The largest difference of a channel, the first of equal ones; `None` where no pixel is compared.
    pub largest: Option<LocatedDifference>,
    /// What the largest difference of a pixel's channels does not pass in 99.9 % of the pixels: of n values in order, number
    /// ⌈0.999 n⌉. NaN where no pixel is compared.
    pub percentile_999: f64,
    /// Mean of A per channel; NaN where no pixel is compared.
    pub mean_a: [f64; 3],
    /// Mean of B.
    pub mean_b: [f64; 3],
    /// Pixels with a channel that is not the same, bit for bit.
    pub differing_pixels: u64,
    /// Pixels with a channel that differs by more than 1/255 when a screen shows both (no exposure, no tone curve, sRGB).
    pub visibly_differing_pixels: u64,
    /// Pixels of A with a channel that is infinite or not a number.
    pub non_finite_a: u64,
    /// Those of B.
    pub non_finite_b: u64,
}

impl Metrics {
    /// Measures `a` against the reference `b`. Allocates a number per pixel; where only the mean errors are wanted,
    /// [`SquaredErrors::measure`] is cheaper.
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn measure(a: &Image, b: &Image) -> Result<Self, SizesDiffer> {
        let errors = SquaredErrors::measure(a, b)?;
        let (mut sum_a, mut sum_b) = (
            [CompensatedSum::default(); 3],
            [CompensatedSum::default(); 3],
        );
        let (mut differing_pixels, mut visibly_differing_pixels) = (0, 0);
        let (mut non_finite_a, mut non_finite_b) = (0, 0);
        let mut largest: Option<(f64, usize)> = None;
        let mut differences = Vec::with_capacity(a.pixels.len());
        for (index, (&a, &b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
            if a.map(f32::to_bits) != b.map(f32::to_bits) {
                differing_pixels += 1;
                visibly_differing_pixels += u64::from(differ_visibly(a, b));
            }
            let finite = (is_finite(a), is_finite(b));
            non_finite_a += u64::from(!finite.0);
            non_finite_b += u64::from(!finite.1);
            if finite != (true, true) {
                continue;
            }
            for channel in 0..3 {
                sum_a[channel].add(f64::from(a[channel]));
                sum_b[channel].add(f64::from(b[channel]));
            }
            let difference = largest_difference(a, b);
            if largest.is_none_or(|(value, _)| difference > value) {
                largest = Some((difference, index));
            }
            differences.push(difference);
        }

        let mean = |sum: CompensatedSum| sum.total() / errors.compared_pixels as f64;
        Ok(Self {
            errors,
            largest: largest.map(|(value, index)| locate(value, index, a.width)),
            percentile_999: percentile_999(&mut differences),
            mean_a: sum_a.map(mean),
            mean_b: sum_b.map(mean),
            differing_pixels,
            visibly_differing_pixels,
            non_finite_a,
            non_finite_b,
        })
    }

    /// The difference to draw white. A few wild pixels do not darken the others, unless only those differ; where nothing differs
    /// any scale is right.
    #[must_use]
    pub fn white(&self) -> f64 {
        let largest = self.largest.map_or(0.0, |largest| largest.value);
        [self.percentile_999, largest]
            .into_iter()
            .find(|&value| value > 0.0)
            .unwrap_or(1.0)
    }

    /// Whether the pictures are the same, bit for bit: they have one [hash](Image::hash).
    #[must_use]
    pub fn identical(&self) -> bool {
        self.differing_pixels == 0
    }

    /// By what part of B's mean A's mean is above it, per channel. 0 where they are equal, infinite where B's alone is 0.
    #[must_use]
    pub fn relative_means(&self) -> [f64; 3] {
        std::array::from_fn(|channel| {
            let difference = self.mean_a[channel] - self.mean_b[channel];
            if difference == 0.0 {
                0.0
            } else {
                difference / self.mean_b[channel].abs()
            }
        })
    }
}

fn locate(value: f64, index: usize, width: u32) -> LocatedDifference {
    let coordinate = |n: usize| u32::try_from(n).expect("a picture's sides are u32");
    let width = width as usize;
    LocatedDifference {
        value,
        x: coordinate(index % width),
        y: coordinate(index / width),
    }
}

pub(super) fn check_sizes(a: &Image, b: &Image) -> Result<(), SizesDiffer> {
    let (a, b) = ((a.width, a.height), (b.width, b.height));
    if a == b {
        Ok(())
    } else {
        Err(SizesDiffer { a, b })
    }
}

pub(super) fn is_finite(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

fn differ_visibly(a: [f32; 3], b: [f32; 3]) -> bool {
    let [a, b] = [a, b].map(|pixel| encode(pixel, &Display::default()));
    a.iter().zip(b).any(|(a, b)| (a - b).abs() > VISIBLE)
}

/// The largest difference of a channel.
fn largest_difference(a: [f32; 3], b: [f32; 3]) -> f64 {
    let differences = a
        .into_iter()
        .zip(b)
        .map(|(a, b)| f64::from(a) - f64::from(b));
    differences.map(f64::abs).fold(0.0, f64::max)
}

/// [`Metrics::percentile_999`] of `a` against the reference `b`, alone.
///
/// # Errors
/// When the sizes differ.
pub fn percentile_999_between(a: &Image, b: &Image) -> Result<f64, SizesDiffer> {
    check_sizes(a, b)?;
    let pairs = a.pixels.iter().zip(&b.pixels);
    let finite = pairs.filter(|(a, b)| is_finite(**a) && is_finite(**b));
    let mut differences: Vec<f64> = finite.map(|(a, b)| largest_difference(*a, *b)).collect();
    Ok(percentile_999(&mut differences))
}

/// Puts `values` in another order.
fn percentile_999(values: &mut [f64]) -> f64 {
    let rank = (values.len() * 999).div_ceil(1000);
    match rank.checked_sub(1) {
        None => f64::NAN,
        Some(index) => *values.select_nth_unstable_by(index, f64::total_cmp).1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, pixels: &[[f32; 3]]) -> Image {
        Image {
            width,
            height: u32::try_from(pixels.len()).expect("few") / width,
            pixels: pixels.to_vec(),
        }
    }

    fn near(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 1e-12 * expected.abs()
    }

    /// By hand: the differences are 0.5, −0.25, 0 and 0, 1, 0. Their squares sum to 0.25 + 0.0625 + 1 = 1.3125 = 21/16 over six
    /// values. Relative: 0.25 / (0.25 + 0.01) + 0.0625 / (0.0625 + 0.01) + 1 / (4 + 0.01) over six.
    #[test]
    fn errors_are_those_worked_out_by_hand() {
        let a = image(2, &[[1.0, 0.0, 3.0], [0.0, 3.0, -1.0]]);
        let b = image(2, &[[0.5, 0.25, 3.0], [0.0, 2.0, -1.0]]);
        let found = Metrics::measure(&a, &b).expect("are of one size");
        assert!(near(found.errors.mse, 21.0 / 96.0));
        assert!(near(found.errors.rmse(), (21.0_f64 / 96.0).sqrt()));
        let relative = (25.0 / 26.0 + 625.0 / 725.0 + 100.0 / 401.0) / 6.0;
        assert!(near(found.errors.relmse, relative));
        assert!(near(found.errors.noise(), relative.sqrt()));
        assert_eq!(found.errors.compared_pixels, 2);
        assert_eq!(
            found.largest,
            Some(LocatedDifference {
                value: 1.0,
                x: 1,
                y: 0
            })
        );
        assert_eq!(found.percentile_999, 1.0);
        assert_eq!(found.mean_a, [0.5, 1.5, 1.0]);
        assert_eq!(found.mean_b, [0.25, 1.125, 1.0]);
        assert_eq!(found.relative_means(), [1.0, 1.0 / 3.0, 0.0]);
        assert_eq!(found.differing_pixels, 2);
        assert!(!found.identical());
        // The error is relative to the second picture.
        let swapped = SquaredErrors::measure(&b, &a).expect("are of one size");
        let relative = (25.0 / 101.0 + 6.25 + 100.0 / 901.0) / 6.0;
        assert!(near(swapped.relmse, relative) && swapped.mse == found.errors.mse);
    }

    #[test]
    fn the_same_picture_is_identical_and_a_sign_of_zero_is_a_difference() {
        let a = image(1, &[[0.25, 0.5, 1e-40], [f32::NAN, 0.0, 1.0]]);
        let same = Metrics::measure(&a, &a).expect("are of one size");
        assert!(same.identical() && same.visibly_differing_pixels == 0);
        assert_eq!((same.errors.mse, same.errors.relmse), (0.0, 0.0));
        assert_eq!(same.relative_means(), [0.0; 3]);
        assert_eq!((same.non_finite_a, same.non_finite_b), (1, 1));

        let mut other = a.clone();
        other.pixels[1][1] = -0.0;
        let signed = Metrics::measure(&other, &a).expect("are of one size");
        assert_ne!(other.hash(), a.hash());
        assert_eq!(signed.differing_pixels, 1);
    }

    /// The largest values of `f32` differ by twice themselves; the square is 4.6e77.
    #[test]
    fn huge_values_do_not_overflow() {
        let a = image(1, &[[1e30, f32::MAX, 0.0], [0.0; 3]]);
        let b = image(1, &[[-1e30, -f32::MAX, 0.0], [0.0; 3]]);
        let found = Metrics::measure(&a, &b).expect("are of one size");
        let (big, most) = (f64::from(1e30_f32), f64::from(f32::MAX));
        let expected = 4.0 * (most * most + big * big) / 6.0;
        assert!((found.errors.mse - expected).abs() <= 1e-15 * expected);
        assert!(near(found.errors.relmse, 8.0 / 6.0));
        assert_eq!(found.mean_a[1], most / 2.0);
        assert_eq!(found.largest.expect("is there").value, 2.0 * most);
    }

    /// A million small errors beside a huge one: each is below half a unit in the last place of the sum.
    #[test]
    fn small_errors_are_not_lost_beside_a_huge_one() {
        let mut pixels = vec![[1.0, 0.0, 0.0]; 1_000_000];
        pixels[0] = [1e9, 0.0, 0.0];
        let (a, b) = (image(1000, &pixels), Image::black(1000, 1000));
        let found = SquaredErrors::measure(&a, &b).expect("are of one size");
        assert_eq!(found.mse, (1e18 + 999_999.0) / 3e6);
    }

    #[test]
    fn pixels_that_are_not_finite_are_left_out_and_counted() {
        let a = image(
            4,
            &[
                [0.5; 3],
                [f32::NAN, 0.0, 0.0],
                [0.0, f32::INFINITY, 0.0],
                [3.0; 3],
            ],
        );
        let b = image(
            4,
            &[
                [1.0; 3],
                [0.0; 3],
                [0.0, f32::INFINITY, 0.0],
                [f32::NEG_INFINITY, 3.0, 3.0],
            ],
        );
        let found = Metrics::measure(&a, &b).expect("are of one size");
        assert_eq!((found.non_finite_a, found.non_finite_b), (2, 2));
        assert_eq!(found.errors.compared_pixels, 1);
        assert_eq!(found.errors.mse, 0.25);
        assert_eq!((found.mean_a, found.mean_b), ([0.5; 3], [1.0; 3]));
        assert_eq!(found.largest.expect("is there").value, 0.5);
        // On a screen NaN is black, as the reference is there, and minus infinity is black beside white.
        assert_eq!(found.differing_pixels, 3);
        assert_eq!(found.visibly_differing_pixels, 2);
    }

    #[test]
    fn where_nothing_can_be_compared_there_is_no_number() {
        let nan = image(1, &[[f32::NAN; 3]]);
        for (a, b) in [
            (&nan, &Image::black(1, 1)),
            (&Image::black(0, 0), &Image::black(0, 0)),
        ] {
            let found = Metrics::measure(a, b).expect("are of one size");
            assert!(found.errors.mse.is_nan() && found.errors.relmse.is_nan());
            assert!(found.percentile_999.is_nan() && found.mean_a[0].is_nan());
            assert_eq!((found.largest, found.errors.compared_pixels), (None, 0));
        }
    }

    #[test]
    fn different_sizes_are_told() {
        let (a, b) = (Image::black(4, 3), Image::black(3, 4));
        let error = Metrics::measure(&a, &b).expect_err("are of two sizes");
        assert_eq!(error.to_string(), "the sizes differ: 4×3 and 3×4 pixels");
        assert_eq!(SquaredErrors::measure(&a, &b), Err(error));
    }

    /// Of 1..=n shuffled, the rank is the value: ⌈0.999 n⌉.
    #[test]
    fn the_percentile_is_the_value_of_its_rank() {
        for (count, expected) in [
            (1, 1.0),
            (999, 999.0),
            (1000, 999.0),
            (2001, 1999.0),
            (10_000, 9990.0),
        ] {
            // 7919 is prime and divides none of the counts.
            let mut values: Vec<f64> = (0..count)
                .map(|i| f64::from(i * 7919 % count + 1))
                .collect();
            assert_eq!(percentile_999(&mut values), expected, "{count}");
        }
    }

    /// One step of 8 bits may be rounding and is not counted, two steps are; values that no screen shows do not differ.
    #[test]
    fn visible_means_more_than_one_step_of_eight_bits() {
        use crate::math::color::linear_from_srgb;
        let code = |code: u8| linear_from_srgb(f32::from(code) / 255.0);
        for low in 0..254 {
            let visible = |step: u8| {
                let pixels = [low, low + step].map(|c| [0.5, code(c), 0.5]);
                let [a, b] = pixels.map(|pixel| image(1, &[pixel]));
                let found = Metrics::measure(&a, &b).expect("are of one size");
                assert_eq!(found.differing_pixels, 1);
                found.visibly_differing_pixels == 1
            };
            assert!(!visible(1) && visible(2), "{low}");
        }
        assert!(!differ_visibly([2.0, -1.0, 1.0], [1.0, 0.0, 9.0]));
    }
}
