//! The accumulator of a render: sums of samples in `f64`, and earlier means of each pixel, from which its error is estimated.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Image;
use super::layers::{Gathered, Layer, Parts};
use super::tiles::Region;
use crate::control::CancelToken;
use crate::scene::RenderSettings;

/// Pixels between two looks at the cancel token.
pub const CHUNK: usize = 1 << 16;

/// Sums of samples per pixel, normalised only when read.
///
/// Sums are `f64`: a hundred thousand samples drift by less than an `f32` can show. Samples arrive in blocks, each summed from
/// zero, and blocks are added in index order, so an interrupted render continues to the same bits. A block never reaches beyond
/// the next power of two, nor across the middle between two of them: there the film notes the mean, see [`Halves`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Film {
    region: Region,
    /// The picture's sums first, then those of each layer.
    planes: Vec<Vec<[f64; 3]>>,
    layers: Vec<Layer>,
    samples: Vec<u32>,
    /// What error estimates need; nothing where they are not asked for.
    marks: Option<Marks>,
}

/// What error estimates need of each pixel: the mean radiance of the first quarter, half and three quarters of the samples it has at the next
/// power of two, or now if that is one; and the `rays` that all its samples took. Each by itself: a pass changes few of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Marks {
    rays: Vec<u32>,
    quarter: Vec<[f32; 3]>,
    half: Vec<[f32; 3]>,
    three_quarters: Vec<[f32; 3]>,
}

/// How a pixel's mean differs between halves of its samples, at the last power of two it has reached.
#[derive(Clone, Copy, Debug, Default)]
pub struct Halves {
    /// The number of samples is 2 to this power.
    pub level: u32,
    /// Mean of all minus mean of the first half.
    pub whole: [f64; 3],
    /// The same for each half of the samples by itself. Between powers of two, and below four samples, where that is not known:
    /// what it is on average for independent samples.
    pub parts: [[f64; 3]; 2],
    /// Whether `parts` is known.
    pub is_complete: bool,
}

impl Halves {
    fn without_parts(level: u32, whole: [f64; 3]) -> Self {
        let part = whole.map(|value| value * std::f64::consts::SQRT_2);
        Self {
            level,
            whole,
            parts: [part, part],
            is_complete: false,
        }
    }
}

/// The sums of blocks of samples of the pixels of one tile: the picture's first, then those of each layer, each row by row.
#[derive(Clone, Debug, Default)]
pub struct TileSums {
    pub planes: Vec<Vec<[f64; 3]>>,
    pub samples: Vec<u32>,
    pub rays: Vec<u32>,
}

impl TileSums {
    /// Starts again, without samples, for `pixels` pixels; memory is kept.
    pub fn reset(&mut self, layers: &[Layer], pixels: usize) {
        self.planes.resize_with(1 + layers.len(), Vec::new);
        for plane in &mut self.planes {
            refill(plane, pixels);
        }
        refill(&mut self.samples, pixels);
        refill(&mut self.rays, pixels);
    }

    /// Adds a sample of the pixel number `index` that took `rays`.
    pub fn add<P: Parts>(
        &mut self,
        index: usize,
        layers: &[Layer],
        sample: &Gathered<P>,
        rays: u32,
    ) {
        let (picture, rest) = self.planes.split_first_mut().expect("the picture is there");
        add_to(&mut picture[index], sample.radiance.as_dvec3().to_array());
        for (plane, &layer) in rest.iter_mut().zip(layers) {
            add_to(
                &mut plane[index],
                sample.parts.of(layer).as_dvec3().to_array(),
            );
        }
        self.samples[index] += 1;
        self.rays[index] = self.rays[index].saturating_add(rays);
    }
}

/// Makes `values` as many zeros as `count`, in the memory it has.
fn refill<T: Clone + Default>(values: &mut Vec<T>, count: usize) {
    values.clear();
    values.resize(count, T::default());
}

fn add_to(sum: &mut [f64; 3], value: [f64; 3]) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += value;
    }
}

/// The most samples of the next block of a pixel that has `samples`: up to the next power of two or the middle before it.
pub fn block_after(samples: u32) -> u32 {
    let next = (samples + 1).next_power_of_two();
    let middle = next / 4 * 3;
    if samples < middle {
        middle - samples
    } else {
        next - samples
    }
}

impl Film {
    /// An empty film over `region` of the picture, with these layers beside it; ready for error estimates, if `with_marks`.
    #[must_use]
    pub fn new(region: Region, layers: &[Layer], with_marks: bool) -> Self {
        let pixels = region.pixel_count();
        // Each plane by itself: copies of one would be written at once, where zeroed pages cost nothing until they are used.
        let black = || vec![[0.0; 3]; pixels];
        Self {
            region,
            planes: std::iter::repeat_with(black)
                .take(1 + layers.len())
                .collect(),
            layers: layers.to_vec(),
            samples: vec![0; pixels],
            marks: with_marks.then(|| Marks::new(pixels)),
        }
    }

    /// A copy; `None` when cancelled.
    #[must_use]
    pub fn copy_unless(&self, cancel: &CancelToken) -> Option<Self> {
        let planes = self.planes.iter().map(|plane| copied(plane, cancel));
        let marks = match &self.marks {
            Some(marks) => Some(marks.copy_unless(cancel)?),
            None => None,
        };
        Some(Self {
            region: self.region,
            planes: planes.collect::<Option<_>>()?,
            layers: self.layers.clone(),
            samples: copied(&self.samples, cancel)?,
            marks,
        })
    }

    /// The bytes that one pixel takes in a film with as many `layers`.
    #[must_use]
    pub fn bytes_per_pixel(layers: usize, with_marks: bool) -> usize {
        let marks = if with_marks {
            Marks::BYTES_PER_PIXEL
        } else {
            0
        };
        (1 + layers) * size_of::<[f64; 3]>() + size_of::<u32>() + marks
    }

    /// Whether it is as [`Self::new`] makes it, and no pixel has more samples than any render may take, which is not certain where it was
    /// read from a file.
    #[must_use]
    pub fn is_like(&self, region: Region, layers: &[Layer], with_marks: bool) -> bool {
        let most = RenderSettings::MAX_SAMPLES;
        let pixels = region.pixel_count();
        self.region == region
            && self.layers == layers
            && self.planes.len() == 1 + layers.len()
            && self.planes.iter().all(|plane| plane.len() == pixels)
            && self.samples.len() == pixels
            && self.samples.iter().all(|&samples| samples <= most)
            && self.marks.is_some() == with_marks
            && self.marks.iter().all(|marks| marks.is_like(pixels))
    }

    /// Adds one block of samples over `tile`.
    ///
    /// # Panics
    /// When the tile does not lie in the film's region or `sums` is of another size or has other layers.
    pub fn add(&mut self, tile: Region, sums: &TileSums) {
        assert_eq!(self.planes.len(), sums.planes.len(), "the same layers");
        assert_eq!(
            sums.samples.len(),
            tile.pixel_count(),
            "one sum per pixel of the tile"
        );
        let width = tile.width as usize;
        for row in 0..tile.height as usize {
            let start = self.row_start(tile, row);
            let in_tile = row * width..(row + 1) * width;
            let in_film = start..start + width;
            let added = &sums.samples[in_tile.clone()];
            if let Some(marks) = &mut self.marks {
                marks.count_rays(in_film.clone(), &sums.rays[in_tile.clone()]);
                let sums = &self.planes[0][in_film.clone()];
                marks.begin(start, sums, &self.samples[in_film.clone()], added);
            }
            for (plane, sums) in self.planes.iter_mut().zip(&sums.planes) {
                for (sum, value) in plane[in_film.clone()]
                    .iter_mut()
                    .zip(&sums[in_tile.clone()])
                {
                    add_to(sum, *value);
                }
            }
            for (count, added) in self.samples[in_film.clone()].iter_mut().zip(added) {
                *count += added;
            }
            if let Some(marks) = &mut self.marks {
                let sums = &self.planes[0][in_film.clone()];
                marks.note_three_quarters(start, sums, &self.samples[in_film]);
            }
        }
    }

    /// The rectangle of the picture it holds.
    #[must_use]
    pub fn region(&self) -> Region {
        self.region
    }

    /// How many samples the pixel number `index` has.
    #[must_use]
    pub fn samples(&self, index: usize) -> u32 {
        self.samples[index]
    }

    /// How many rays the samples of the pixel number `index` took, 2³² − 1 at most; 0 where the film is not made for error
    /// estimates.
    #[must_use]
    pub fn rays(&self, index: usize) -> u32 {
        self.marks.as_ref().map_or(0, |marks| marks.rays[index])
    }

    /// Rays of all pixels, as far as [`Self::rays`] tells.
    #[must_use]
    pub fn total_rays(&self) -> u64 {
        let rays = self.marks.iter().flat_map(|marks| &marks.rays);
        rays.copied().map(u64::from).sum()
    }

    /// Mean radiance of the pixel number `index`; black where nothing was sampled.
    #[must_use]
    pub fn mean_at(&self, index: usize) -> [f32; 3] {
        self.mean(&self.planes[0], index)
    }

    /// The fewest and the most samples of a pixel.
    #[must_use]
    pub fn sample_range(&self) -> [u32; 2] {
        let samples = self.samples.iter().copied();
        [samples.clone().min(), samples.max()].map(Option::unwrap_or_default)
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.samples.len()
    }

    /// Mean samples of a pixel.
    #[must_use]
    pub fn mean_samples(&self) -> f64 {
        self.total_samples() as f64 / self.pixels() as f64
    }

    /// Samples of all pixels.
    #[must_use]
    pub fn total_samples(&self) -> u64 {
        self.samples.iter().copied().map(u64::from).sum()
    }

    /// How many samples all pixels together lack of `most` each.
    #[must_use]
    pub fn room_up_to(&self, most: u32) -> u64 {
        let lacking = |&samples: &u32| u64::from(most.saturating_sub(samples));
        self.samples.iter().map(lacking).sum()
    }

    /// How the halves of the samples of the pixel number `index` differ; `None` before it has two samples, and where the film is
    /// not made for error estimates.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "a fifth of a survey is copying what is seen"
    )]
    #[inline(always)]
    pub fn halves(&self, index: usize) -> Option<Halves> {
        let marks = self.marks.as_ref()?;
        let samples = self.samples[index];
        let level = samples.checked_ilog2().filter(|&level| level > 0)?;
        let [quarter, half, three_quarters] = [&marks.quarter, &marks.half, &marks.three_quarters]
            .map(|means| means[index].map(f64::from));
        if !samples.is_power_of_two() {
            return Some(Halves::without_parts(level, each(|c| half[c] - quarter[c])));
        }
        let mean = self.planes[0][index].map(|sum| sum / f64::from(samples));
        let whole = each(|c| mean[c] - half[c]);
        if level < 2 {
            return Some(Halves::without_parts(level, whole));
        }
        let first = each(|c| half[c] - quarter[c]);
        let second = each(|c| {
            let third_quarter = 3.0 * three_quarters[c] - 2.0 * half[c];
            2.0 * mean[c] - half[c] - third_quarter
        });
        Some(Halves {
            level,
            whole,
            parts: [first, second],
            is_complete: true,
        })
    }

    /// The means of every pixel of `tile`, row by row, of the picture and then of each layer; black where nothing was
    /// sampled.
    #[must_use]
    pub fn means(&self, tile: Region) -> Vec<Vec<[f32; 3]>> {
        let means = |plane: &Vec<[f64; 3]>| {
            (0..tile.height as usize)
                .flat_map(|row| {
                    let start = self.row_start(tile, row);
                    (start..start + tile.width as usize).map(|index| self.mean(plane, index))
                })
                .collect()
        };
        self.planes.iter().map(means).collect()
    }

    /// The picture so far.
    #[must_use]
    pub fn image(&self) -> Image {
        let image = image_of(
            &self.planes[0],
            &self.samples,
            self.region,
            &CancelToken::new(),
        );
        image.expect("nobody cancels")
    }

    /// The picture and the layers. The sums of each go as soon as it is made. `None` when cancelled.
    #[must_use]
    pub fn into_images(self, cancel: &CancelToken) -> Option<(Image, Vec<(Layer, Image)>)> {
        let Self {
            region,
            planes,
            layers,
            samples,
            marks,
        } = self;
        drop(marks);
        let images = planes
            .into_iter()
            .map(|plane| image_of(&plane, &samples, region, cancel));
        let mut images = images.collect::<Option<Vec<_>>>()?.into_iter();
        let image = images.next().expect("the picture is there");
        Some((image, layers.into_iter().zip(images).collect()))
    }

    fn mean(&self, plane: &[[f64; 3]], index: usize) -> [f32; 3] {
        mean_of(&plane[index], self.samples[index].max(1))
    }

    /// Number of the first pixel of row `row` of `tile`.
    pub(super) fn row_start(&self, tile: Region, row: usize) -> usize {
        let (x, y) = (
            (tile.x - self.region.x) as usize,
            (tile.y - self.region.y) as usize,
        );
        (y + row) * self.region.width as usize + x
    }
}

impl Marks {
    const BYTES_PER_PIXEL: usize = size_of::<u32>() + 3 * size_of::<[f32; 3]>();

    fn new(pixels: usize) -> Self {
        let black = || vec![[0.0; 3]; pixels];
        Self {
            rays: vec![0; pixels],
            quarter: black(),
            half: black(),
            three_quarters: black(),
        }
    }

    fn copy_unless(&self, cancel: &CancelToken) -> Option<Self> {
        Some(Self {
            rays: copied(&self.rays, cancel)?,
            quarter: copied(&self.quarter, cancel)?,
            half: copied(&self.half, cancel)?,
            three_quarters: copied(&self.three_quarters, cancel)?,
        })
    }

    fn is_like(&self, pixels: usize) -> bool {
        let means = [&self.quarter, &self.half, &self.three_quarters];
        self.rays.len() == pixels && means.iter().all(|means| means.len() == pixels)
    }

    fn count_rays(&mut self, pixels: Range<usize>, added: &[u32]) {
        for (rays, added) in self.rays[pixels].iter_mut().zip(added) {
            *rays = rays.saturating_add(*added);
        }
    }

    /// Begins the way to the next power of two of samples for those of the pixels from number `first` on that are at one, and to which
    /// samples are `added`.
    fn begin(&mut self, first: usize, sums: &[[f64; 3]], samples: &[u32], added: &[u32]) {
        let means = self.quarter[first..]
            .iter_mut()
            .zip(&mut self.half[first..]);
        let pixels = sums.iter().zip(samples.iter().zip(added));
        for ((sum, (&samples, &added)), (quarter, half)) in pixels.zip(means) {
            if added > 0 && samples.is_power_of_two() {
                *quarter = *half;
                *half = mean_of(sum, samples);
            }
        }
    }

    /// Notes the means of those of the pixels from number `first` on that have got three quarters of the way.
    fn note_three_quarters(&mut self, first: usize, sums: &[[f64; 3]], samples: &[u32]) {
        let pixels = sums.iter().zip(samples);
        for ((sum, &samples), three_quarters) in pixels.zip(&mut self.three_quarters[first..]) {
            // Three times a power of two.
            if samples >= 3 && samples == 3 << (samples.ilog2() - 1) {
                *three_quarters = mean_of(sum, samples);
            }
        }
    }
}

/// The same values; `None` when cancelled.
fn copied<T: Copy>(values: &[T], cancel: &CancelToken) -> Option<Vec<T>> {
    let mut copy = Vec::with_capacity(values.len());
    for values in values.chunks(CHUNK) {
        if cancel.is_cancelled() {
            return None;
        }
        copy.extend_from_slice(values);
    }
    Some(copy)
}

/// The means of a plane of sums; `None` when cancelled.
fn image_of(
    plane: &[[f64; 3]],
    samples: &[u32],
    region: Region,
    cancel: &CancelToken,
) -> Option<Image> {
    let mut pixels = Vec::with_capacity(plane.len());
    for (sums, samples) in plane.chunks(CHUNK).zip(samples.chunks(CHUNK)) {
        if cancel.is_cancelled() {
            return None;
        }
        let means = sums.iter().zip(samples);
        pixels.extend(means.map(|(sum, &samples)| mean_of(sum, samples.max(1))));
    }
    Some(Image {
        width: region.width,
        height: region.height,
        pixels,
    })
}

#[expect(clippy::cast_possible_truncation, reason = "the picture is f32")]
fn mean_of(sum: &[f64; 3], samples: u32) -> [f32; 3] {
    sum.map(|sum| (sum / f64::from(samples)) as f32)
}

/// The value of each channel. Not by `map` of an array, which compilers do not always turn into straight code.
#[inline]
pub fn each(value: impl Fn(usize) -> f64) -> [f64; 3] {
    [value(0), value(1), value(2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::layers::AllParts;

    fn sums(pixels: usize, samples: &[[f32; 3]]) -> TileSums {
        let mut sums = TileSums::default();
        sums.reset(&[Layer::Ambient], pixels);
        for index in 0..pixels {
            for &sample in samples {
                sums.add(
                    index,
                    &[Layer::Ambient],
                    &Gathered::<AllParts>::seen(sample.into()),
                    2,
                );
            }
        }
        sums
    }

    #[test]
    fn means_are_taken_over_the_samples_of_each_pixel() {
        let region = Region {
            x: 10,
            y: 20,
            width: 3,
            height: 2,
        };
        let mut film = Film::new(region, &[Layer::Ambient], true);
        film.add(region, &sums(6, &[[1.0, 2.0, 4.0]]));
        let corner = Region {
            x: 12,
            y: 21,
            width: 1,
            height: 1,
        };
        film.add(
            corner,
            &sums(1, &[[1.0, 0.0, 0.0], [0.0; 3], [2.0, 0.0, 0.0]]),
        );
        assert_eq!(film.image().pixel(2, 1), [1.0, 0.5, 1.0]);
        assert_eq!(film.image().pixel(0, 0), [1.0, 2.0, 4.0]);
        assert_eq!(film.means(corner), [[[1.0, 0.5, 1.0]], [[0.0; 3]]]);
        assert_eq!((film.total_samples(), film.sample_range()), (9, [1, 4]));
        assert_eq!((film.total_rays(), film.rays(2), film.rays(3)), (18, 2, 2));
        assert_eq!(film.rays(5), 8);
    }

    #[test]
    fn halves_are_those_of_the_samples() {
        let region = Region::full(1, 1);
        let mut film = Film::new(region, &[Layer::Ambient], true);
        assert!(film.halves(0).is_none());
        // Squares, so that no difference is like another; exact in f32.
        let values: Vec<f64> = (0..32).map(|i: i32| f64::from(i * i)).collect();
        let mean =
            |range: Range<usize>| values[range.clone()].iter().sum::<f64>() / range.len() as f64;
        let mut count = 0;
        while count < 32 {
            let block = block_after(u32::try_from(count).expect("small")) as usize;
            #[expect(clippy::cast_possible_truncation, reason = "small whole numbers")]
            let samples: Vec<_> = values[count..count + block]
                .iter()
                .map(|&v| [v as f32, 0.0, 0.0])
                .collect();
            film.add(region, &sums(1, &samples));
            count += block;
            let Some(halves) = film.halves(0) else {
                assert_eq!(count, 1);
                continue;
            };
            let full = 1 << count.ilog2();
            assert_eq!(halves.level, count.ilog2());
            let whole = mean(0..full) - mean(0..full / 2);
            assert!((halves.whole[0] - whole).abs() < 1e-4, "{count}");
            assert_eq!(halves.is_complete, count == full && count >= 4);
            if halves.is_complete {
                let [first, second] = halves.parts;
                let (quarter, half) = (full / 4, full / 2);
                let expected = mean(0..half) - mean(0..quarter);
                assert!((first[0] - expected).abs() < 1e-4, "{count}");
                let expected = mean(half..full) - mean(half..half + quarter);
                assert!((second[0] - expected).abs() < 1e-4, "{count}");
            }
        }
        assert_eq!(count, 32);
    }
}
