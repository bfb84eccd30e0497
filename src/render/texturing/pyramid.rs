//! An image at every size, each half of the one before, so that what a ray stands for is a few texels of one of them.

use std::sync::Arc;

use rayon::prelude::*;

use crate::control::CancelToken;
use crate::math::color::linear_from_srgb;
use crate::math::{DVec2, Vec3};
use crate::scene::{Texels, TextureImage};

/// What the values of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Light that is reflected: bytes and words are sRGB, floats linear.
    Color,
    /// Coordinates of a unit vector, each from −1 to 1. Of bytes, 128 is 0, so that there is a code for it; of words, 32768.
    Normal,
}

/// An image at every size. It repeats in both directions.
#[derive(Debug)]
pub struct Pyramid {
    image: Arc<TextureImage>,
    meaning: Meaning,
    /// What each code of a byte or word means; empty for floats.
    values: Vec<f32>,
    /// The sizes after the first, down to one texel.
    smaller: Vec<Level>,
}

/// An image at one size.
#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

/// What is taken together of an image: a box, by its two sides in units of the image's width and height.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    /// Where its middle is: right and up, from 0 to 1 over the image.
    pub middle: DVec2,
    /// The sides.
    pub sides: [DVec2; 2],
}

/// The most places along the longer side of an area that are looked at.
const MOST_TAPS: f64 = 16.0;

impl Pyramid {
    /// The most memory that the smaller sizes of `image` take, in bytes: a third of its texels, and for those of a single row or column as
    /// many again as it has in a row and a column. Tables of the same size for all images do not count.
    #[must_use]
    pub fn foreseen_bytes(image: &TextureImage) -> u64 {
        let sides = u64::from(image.width()) + u64::from(image.height());
        (image.texels().len() as u64 / 3 + sides) * size_of::<Vec3>() as u64
    }

    /// All sizes of `image`; `None` when cancelled.
    #[must_use]
    pub fn new(image: &Arc<TextureImage>, meaning: Meaning, cancel: &CancelToken) -> Option<Self> {
        let most = match image.texels() {
            Texels::Bytes(_) => u16::from(u8::MAX),
            Texels::Words(_) => u16::MAX,
            Texels::Floats(_) => 0,
        };
        let value_of = |code: u16| match meaning {
            Meaning::Color => linear_from_srgb(f32::from(code) / f32::from(most)),
            Meaning::Normal => {
                let zero = f32::from(most / 2 + 1);
                ((f32::from(code) - zero) / (f32::from(most) - zero)).max(-1.0)
            }
        };
        let values = if most > 0 {
            (0..=most).map(value_of).collect()
        } else {
            Vec::new()
        };
        let mut pyramid = Self {
            image: Arc::clone(image),
            meaning,
            values,
            smaller: Vec::new(),
        };
        loop {
            let last = pyramid.smaller.len();
            let (width, height) = pyramid.size(last);
            if (width, height) == (1, 1) {
                return Some(pyramid);
            }
            let level = pyramid.halved(last, cancel)?;
            pyramid.smaller.push(level);
        }
    }

    /// The image it is of.
    #[must_use]
    pub fn image(&self) -> &TextureImage {
        &self.image
    }

    /// What its values mean.
    #[must_use]
    pub fn meaning(&self) -> Meaning {
        self.meaning
    }

    /// How many sizes there are, that of the image and that of one texel included.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.smaller.len() + 1
    }

    /// Whether it was made from this image with this meaning.
    pub(super) fn is_of(&self, image: &Arc<TextureImage>, meaning: Meaning) -> bool {
        Arc::ptr_eq(&self.image, image) && self.meaning == meaning
    }

    /// Memory beside that of the image, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let smaller = self.smaller.iter().map(|level| size_of_val(&*level.texels));
        size_of_val(&*self.values) + smaller.sum::<usize>()
    }

    /// The mean of the image over `area`, about: over as many squares in a row as it is longer than wide, up to [`MOST_TAPS`], each
    /// a mixture of the two sizes whose texels are nearest to it.
    pub(super) fn mean(&self, area: &Area) -> Vec3 {
        let (width, height) = self.size(0);
        let size = DVec2::new(width as f64, height as f64);
        let Axes { long, short } = Axes::of(area.sides.map(|side| side * size));
        let length = long.length();
        // Never wider than long, never so thin that there are too many, and none smaller than a texel.
        let side = short.max(length / MOST_TAPS).max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most MOST_TAPS"
        )]
        let taps = (length / side).round().clamp(1.0, MOST_TAPS) as u32;
        #[expect(clippy::cast_possible_truncation, reason = "a level needs few digits")]
        let level = libm::log2(side) as f32;
        if taps == 1 {
            return self.at(area.middle, level);
        }
        let step = long / size / f64::from(taps);
        let first = area.middle - step * (f64::from(taps - 1) / 2.0);
        let tap = |number: u32| self.at(first + step * f64::from(number), level);
        (0..taps).map(tap).sum::<Vec3>() / taps as f32
    }

    /// The image at a place, whose texels are 2^`level` of those of the first size.
    fn at(&self, place: DVec2, level: f32) -> Vec3 {
        let last = self.smaller.len();
        if level <= 0.0 {
            return self.bilinear(0, place);
        }
        if level >= last as f32 {
            return self.bilinear(last, place);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the last level"
        )]
        let finer = level as usize;
        let share = level - finer as f32;
        let fine = self.bilinear(finer, place);
        if share == 0.0 {
            return fine;
        }
        fine.lerp(self.bilinear(finer + 1, place), share)
    }

    /// Between the middles of the four texels around a place of one size.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the image"
    )]
    fn bilinear(&self, level: usize, place: DVec2) -> Vec3 {
        let (width, height) = self.size(level);
        // In texels from the middle of the lower left one, 0 or more.
        let within = |value: f64, size: usize| {
            let size = size as f64;
            let at = (value - value.floor()) * size - 0.5;
            if at < 0.0 { at + size } else { at }
        };
        let (x, y) = (within(place.x, width), within(1.0 - place.y, height));
        let (left, top) = (x as usize % width, y as usize % height);
        let (right, bottom) = ((left + 1) % width, (top + 1) % height);
        let (over_x, over_y) = (x.fract() as f32, y.fract() as f32);
        let texel = |x, y| self.texel(level, x, y);
        let upper = texel(left, top).lerp(texel(right, top), over_x);
        let lower = texel(left, bottom).lerp(texel(right, bottom), over_x);
        upper.lerp(lower, over_y)
    }

    /// Texels per row, and rows, of a level; level 0 is the image, each other has half the sides of the one before, rounded down.
    #[must_use]
    pub fn size(&self, level: usize) -> (usize, usize) {
        match level.checked_sub(1) {
            None => (self.image.width() as usize, self.image.height() as usize),
            Some(smaller) => (self.smaller[smaller].width, self.smaller[smaller].height),
        }
    }

    /// The texel in column `x` and row `y` from the top of a level: a linear colour, or a normal.
    ///
    /// # Panics
    /// Where there is none.
    #[must_use]
    #[inline]
    pub fn texel(&self, level: usize, x: usize, y: usize) -> Vec3 {
        if let Some(smaller) = level.checked_sub(1) {
            let level = &self.smaller[smaller];
            return level.texels[y * level.width + x];
        }
        let index = y * self.image.width() as usize + x;
        let value = |code: usize| self.values[code];
        match (self.image.texels(), self.meaning) {
            (Texels::Bytes(texels), _) => texels[index].map(|code| value(code.into())).into(),
            (Texels::Words(texels), _) => texels[index].map(|code| value(code.into())).into(),
            (Texels::Floats(texels), Meaning::Color) => texels[index].into(),
            (Texels::Floats(texels), Meaning::Normal) => Vec3::from(texels[index]) * 2.0 - 1.0,
        }
    }

    /// Half the size of a level; `None` when cancelled. Each texel is the mean over the part of the image that it covers, so that the
    /// mean of the whole is the same at every size.
    fn halved(&self, level: usize, cancel: &CancelToken) -> Option<Level> {
        let (from_width, from_height) = self.size(level);
        let (width, height) = ((from_width / 2).max(1), (from_height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|x| covered(x, width, from_width)).collect();
        let mut texels = vec![Vec3::ZERO; width * height];
        texels
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                if cancel.is_cancelled() {
                    return;
                }
                let rows = covered(y, height, from_height);
                for (texel, columns) in row.iter_mut().zip(&columns) {
                    for &(y, of_row) in &rows {
                        for &(x, of_column) in columns {
                            *texel += self.texel(level, x, y) * (of_row * of_column);
                        }
                    }
                }
            });
        (!cancel.is_cancelled()).then_some(Level {
            width,
            height,
            texels,
        })
    }
}

/// Which of `from` texels in a row are covered by texel number `index` of `count` in the row of the smaller size, and the share of it that
/// each fills.
fn covered(index: usize, count: usize, from: usize) -> Vec<(usize, f32)> {
    // In units in which the wide texel is `from` long and a narrow one `count`.
    let (start, end) = (index * from, (index + 1) * from);
    let share = |narrow: usize| {
        let (from_here, to_here) = (start.max(narrow * count), end.min((narrow + 1) * count));
        (narrow, (to_here - from_here) as f32 / from as f32)
    };
    (start / count..end.div_ceil(count)).map(share).collect()
}

/// The axes of the ellipse that fills a parallelogram as a circle fills a square, as wide and long as it.
struct Axes {
    long: DVec2,
    /// The length of the short axis.
    short: f64,
}

impl Axes {
    /// By the singular values of the matrix of the `sides`. Sides that are not finite count as none.
    fn of([a, b]: [DVec2; 2]) -> Self {
        let (xx, yy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y);
        let xy = a.x * a.y + b.x * b.y;
        if !(xx.is_finite() && yy.is_finite() && xy.is_finite()) {
            let (long, short) = (DVec2::ZERO, 0.0);
            return Self { long, short };
        }
        let (mean, difference) = (f64::midpoint(xx, yy), (xx - yy) / 2.0);
        let spread = (difference * difference + xy * xy).sqrt();
        let long = (mean + spread).sqrt();
        let short = (mean - spread).max(0.0).sqrt();
        // Of two forms of the direction, the one that does not vanish.
        let direction = if difference >= 0.0 {
            DVec2::new(difference + spread, xy)
        } else {
            DVec2::new(xy, spread - difference)
        };
        Self {
            long: direction.normalize_or(DVec2::X) * long,
            short,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    fn pyramid(width: u32, texels: Texels, meaning: Meaning) -> Pyramid {
        let height = u32::try_from(texels.len()).expect("is small") / width;
        let image = Arc::new(TextureImage::new(width, height, texels));
        Pyramid::new(&image, meaning, &CancelToken::new()).expect("nobody cancels")
    }

    fn noise(width: u32, height: u32) -> Pyramid {
        let mut random = Random::new(5);
        #[expect(clippy::cast_possible_truncation, reason = "texels are f32")]
        let mut value = || random.unit() as f32;
        let texels = (0..width * height).map(|_| [value(), value(), value()]);
        pyramid(width, Texels::Floats(texels.collect()), Meaning::Color)
    }

    fn all(pyramid: &Pyramid, level: usize) -> Vec<Vec3> {
        let (width, height) = pyramid.size(level);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        places.map(|(x, y)| pyramid.texel(level, x, y)).collect()
    }

    fn mean(values: &[Vec3]) -> Vec3 {
        values.iter().sum::<Vec3>() / values.len() as f32
    }

    #[test]
    fn every_size_has_the_mean_of_the_first() {
        for (width, height) in [(1, 1), (64, 64), (13, 7), (5, 1), (1, 6), (33, 100)] {
            let pyramid = noise(width, height);
            let expected = mean(&all(&pyramid, 0));
            for level in 0..=pyramid.smaller.len() {
                let found = mean(&all(&pyramid, level));
                assert!(
                    found.abs_diff_eq(expected, 2e-6),
                    "{width}×{height} {level}"
                );
            }
            assert_eq!(pyramid.size(pyramid.smaller.len()), (1, 1));
        }
    }

    #[test]
    fn memory_is_foreseen() {
        for (width, height) in [(1, 1), (64, 64), (128, 32), (100, 1), (33, 65)] {
            let pyramid = noise(width, height);
            let foreseen = Pyramid::foreseen_bytes(&pyramid.image);
            let taken = pyramid.bytes() as u64;
            let of_sides = u64::from(2 * (width + height)) * 12;
            assert!(taken <= foreseen, "{taken} {foreseen}");
            assert!(foreseen <= taken + of_sides, "{taken} {foreseen}");
        }
    }

    /// By the formula of IEC 61966-2-1, in double precision.
    #[test]
    fn codes_of_srgb_are_decoded_exactly() {
        let decoded = |code: f64| {
            if code <= 0.04045 {
                code / 12.92
            } else {
                ((code + 0.055) / 1.055).powf(2.4)
            }
        };
        let bytes: Vec<_> = (0..=255).map(|code| [code; 3]).collect();
        let bytes = pyramid(256, Texels::Bytes(bytes), Meaning::Color);
        let words: Vec<_> = (0..=u16::MAX).map(|code| [code; 3]).collect();
        let words = pyramid(65_536, Texels::Words(words), Meaning::Color);
        for (pyramid, most) in [(bytes, 255.0), (words, 65_535.0)] {
            for (code, value) in all(&pyramid, 0).into_iter().enumerate() {
                let expected = decoded(code as f64 / most);
                let error = (f64::from(value.x) - expected).abs();
                assert!(error <= 6e-7 * expected, "{code}: {value} {expected}");
            }
        }
    }

    #[test]
    fn codes_of_normals_have_a_zero_and_both_ends() {
        let bytes = pyramid(
            4,
            Texels::Bytes(vec![[0; 3], [1; 3], [128; 3], [255; 3]]),
            Meaning::Normal,
        );
        assert_eq!(all(&bytes, 0), [-1.0, -1.0, 0.0, 1.0].map(Vec3::splat));
        let words = pyramid(
            3,
            Texels::Words(vec![[1; 3], [32_768; 3], [65_535; 3]]),
            Meaning::Normal,
        );
        assert_eq!(all(&words, 0), [-1.0, 0.0, 1.0].map(Vec3::splat));
        let floats = pyramid(2, Texels::Floats(vec![[0.5; 3], [1.0; 3]]), Meaning::Normal);
        assert_eq!(all(&floats, 0), [0.0, 1.0].map(Vec3::splat));
    }

    /// The middle of a texel has its value, rows go down, and the image repeats.
    #[test]
    fn texels_lie_where_they_should() {
        let pyramid = noise(5, 3);
        for (index, expected) in all(&pyramid, 0).into_iter().enumerate() {
            let (x, y) = ((index % 5) as f64, (index / 5) as f64);
            for turn in [0.0, 1.0, -7.0] {
                let place = DVec2::new((x + 0.5) / 5.0 + turn, 1.0 - (y + 0.5) / 3.0 - turn);
                let area = Area {
                    middle: place,
                    sides: [DVec2::ZERO; 2],
                };
                let found = pyramid.mean(&area);
                assert!(
                    found.abs_diff_eq(expected, 1e-5),
                    "{index}: {found} {expected}"
                );
            }
        }
        let between = pyramid.mean(&Area {
            middle: DVec2::new(0.0, 1.0 - 0.5 / 3.0),
            sides: [DVec2::ZERO; 2],
        });
        let expected = (pyramid.texel(0, 4, 0) + pyramid.texel(0, 0, 0)) / 2.0;
        assert!(between.abs_diff_eq(expected, 1e-6), "{between} {expected}");
    }

    /// Long thin areas, lying as they like: near the mean over them that many places give. The bar is a fifth of the spread of the
    /// texels; looking at one place only would miss it by several fifths.
    #[test]
    fn a_mean_is_near_that_of_many_places() {
        let pyramid = noise(64, 64);
        let mut random = Random::new(9);
        let (mut error, mut alone) = (0.0, 0.0);
        let trials = 200;
        for _ in 0..trials {
            let mut place = || DVec2::new(random.unit(), random.unit());
            let (middle, long, short) = (place(), place() - 0.5, place() - 0.5);
            let area = Area {
                middle,
                sides: [long * 0.5, short * 0.1],
            };
            let count = 64;
            let mut sum = Vec3::ZERO;
            for x in 0..count {
                for y in 0..count {
                    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(count) - 0.5;
                    sum +=
                        pyramid.bilinear(0, middle + area.sides[0] * at(x) + area.sides[1] * at(y));
                }
            }
            let expected = sum / (count * count) as f32;
            error += f64::from((pyramid.mean(&area) - expected).length_squared());
            alone += f64::from((pyramid.bilinear(0, middle) - expected).length_squared());
        }
        // Uniform noise in three channels: variance 3/12.
        let spread = (f64::from(trials) * 0.25).sqrt();
        assert!(error.sqrt() < 0.2 * spread, "{} {spread}", error.sqrt());
        assert!(alone.sqrt() > 0.5 * spread, "{} {spread}", alone.sqrt());
    }

    #[test]
    fn axes_are_those_of_the_ellipse() {
        let axes = Axes::of([DVec2::new(3.0, 0.0), DVec2::new(0.0, 1.0)]);
        assert!(axes.long.abs_diff_eq(DVec2::X * 3.0, 1e-12) && (axes.short - 1.0).abs() < 1e-12);
        let axes = Axes::of([DVec2::new(0.0, 0.5), DVec2::new(0.0, 4.0)]);
        assert!((axes.long.length() - 16.25_f64.sqrt()).abs() < 1e-12 && axes.short < 1e-6);
        assert!(axes.long.x.abs() < 1e-12);
        let turned = Axes::of([DVec2::new(2.0, 2.0), DVec2::new(-0.5, 0.5)]);
        assert!(turned.long.abs_diff_eq(DVec2::new(2.0, 2.0), 1e-12));
        assert!((turned.short - 0.5_f64.sqrt()).abs() < 1e-12);
        let nothing = Axes::of([DVec2::NAN, DVec2::INFINITY]);
        assert_eq!((nothing.long, nothing.short), (DVec2::ZERO, 0.0));
    }

    #[test]
    fn cancelling_makes_none() {
        let image = Arc::new(TextureImage::new(2, 1, Texels::Bytes(vec![[1; 3]; 2])));
        let cancel = CancelToken::new();
        cancel.cancel();
        assert!(Pyramid::new(&image, Meaning::Color, &cancel).is_none());
    }
}
