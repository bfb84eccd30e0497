//! Two pictures side by side: the one that is looked at, A, and another one, B, a render of this session or a file.
//!
//! They are shown with a divider between them, in turn, or as their difference; and it is measured how far they are apart, as
//! `raymini compare` does, on the linear values. Where B is of a file that holds what a screen showed, with an exposure or a tone curve, A is
//! given the same before it is measured: they cannot be taken back.

mod bar;
mod file;
mod seen;
mod wipe;

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::canvas::Canvas;
use super::part::Part;
use super::picture_buffer::{Encoded, PictureBuffer, PictureId};
use crate::analysis::{Metrics, mean_flip_unless, scaled_difference};
use crate::control::CancelToken;
use crate::render::{Image, Region};
use crate::scene::{Choice, Display};

pub use bar::Asked;
pub use file::FilePicture;
pub use seen::Seen;

/// Time between two measures of a picture that still changes.
const INTERVAL: Duration = Duration::from_secs(2);

/// How two pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// A at the left of a divider, B at the right.
    #[default]
    Wipe,
    /// One after the other.
    Flip,
    /// How far they are apart.
    Difference,
}

impl Choice for Mode {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Wipe, "wipe"),
        (Self::Flip, "flip"),
        (Self::Difference, "difference"),
    ];
}

/// Which of the pictures beside A a tile belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// B.
    Other,
    /// The difference of both.
    Difference,
}

/// How far two pictures are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Root of the mean squared difference, in the unit of the pictures.
    pub rmse: f64,
    /// Mean squared difference relative to B.
    pub relmse: f64,
    /// How different they look in turn on a screen, 0 to 1; `None` while one of them changes.
    pub flip: Option<f64>,
    /// The pixels that were measured, where the pictures show different parts of one: those that both show.
    pub shared: Option<Part>,
    /// Pixels that differ in any bit.
    pub differing_pixels: u64,
    /// Pixels that are left out, as one of the pictures has no finite value there.
    pub non_finite_pixels: u64,
    /// The difference that is drawn white.
    pub white: f64,
}

/// What a comparison found: the distance, and the picture of the difference.
pub type Compared = Result<(Distance, Arc<PictureBuffer>), String>;

/// [`compare`], of what the renders in two buffers have so far; where they show parts of pictures of one size, of what both show. `a` is given
/// `saved_look`, where `b` has it already.
///
/// # Errors
/// When the sizes differ, or nothing is in both, in words.
pub fn compare_buffers(
    a: &PictureBuffer,
    b: &PictureBuffer,
    saved_look: Option<&Display>,
    is_changing: bool,
    cancel: &CancelToken,
) -> Compared {
    let given_look = |mut image: Image| {
        if let Some(look) = saved_look {
            file::give_look(&mut image, look);
        }
        image
    };
    let (a_part, b_part) = (a.part(), b.part());
    if a_part.of != b_part.of || a_part == b_part {
        return compare(&given_look(a.image()), &b.image(), is_changing, cancel);
    }
    let shared = a_part
        .shared_with(&b_part)
        .ok_or("they show parts of the picture that have no pixel in common")?;
    let [a, b] = [a, b].map(|buffer| part_of(&buffer.image(), buffer.part().region, shared.region));
    let (distance, difference) = compare(&given_look(a), &b, is_changing, cancel)?;
    let distance = Distance {
        shared: Some(shared),
        ..distance
    };
    Ok((distance, difference))
}

/// The pixels of `region`, of an image that has those of `kept`, which contains it.
fn part_of(image: &Image, kept: Region, region: Region) -> Image {
    let (left, top) = (region.x - kept.x, region.y - kept.y);
    let mut pixels = Vec::with_capacity(region.pixel_count());
    for y in top..top + region.height {
        let start = y as usize * image.width as usize + left as usize;
        pixels.extend_from_slice(&image.pixels[start..start + region.width as usize]);
    }
    Image {
        width: region.width,
        height: region.height,
        pixels,
    }
}

/// Measures how far `a` is from `b`, and draws where. What they look like takes time, and is left out where one of them `is_changing`, or
/// when cancelled.
///
/// # Errors
/// When the sizes differ, in words.
pub fn compare(a: &Image, b: &Image, is_changing: bool, cancel: &CancelToken) -> Compared {
    let metrics = Metrics::measure(a, b).map_err(|error| error.to_string())?;
    let white = metrics.white();
    let difference = scaled_difference(a, b, white).map_err(|error| error.to_string())?;
    let flip = if is_changing {
        None
    } else {
        mean_flip_unless(a, b, cancel).ok().flatten()
    };
    let distance = Distance {
        rmse: metrics.errors.rmse(),
        relmse: metrics.errors.relmse,
        flip,
        shared: None,
        differing_pixels: metrics.differing_pixels,
        non_finite_pixels: metrics.non_finite_a.max(metrics.non_finite_b),
        white,
    };
    let buffer = PictureBuffer::of_image(difference, Display::default());
    Ok((distance, Arc::new(buffer)))
}

/// What A was when it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measured {
    picture: PictureId,
    /// Whether it was to change.
    was_running: bool,
    at: Instant,
}

/// A comparison that is looked at.
pub struct Comparison {
    /// How it is shown.
    pub mode: Mode,
    /// Whether B shows where one shows at a time.
    pub shows_other: bool,
    /// What B is called.
    pub name: String,
    /// The number of B's render, where it is one.
    pub number: Option<usize>,
    /// B's pixels.
    pub buffer: Arc<PictureBuffer>,
    /// The look that B was saved with and has for good, see [`FilePicture::saved_look`].
    pub saved_look: Option<Display>,
    /// Where the divider is, `0..=1` of the width.
    divider: f32,
    measured: Option<Measured>,
    distance: Option<Result<Distance, String>>,
    /// Texels of the difference.
    difference_size: [usize; 2],
    other: Canvas,
    difference: Canvas,
}

impl std::fmt::Debug for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Comparison")
            .field("name", &self.name)
            .field("mode", &self.mode)
            .field("distance", &self.distance)
            .finish_non_exhaustive()
    }
}

impl Comparison {
    /// A comparison with the picture in `buffer`, called `name`, that of render `number` where it is one.
    #[must_use]
    pub fn new(name: String, number: Option<usize>, buffer: Arc<PictureBuffer>) -> Self {
        Self {
            mode: Mode::default(),
            shows_other: false,
            name,
            number,
            buffer,
            saved_look: None,
            divider: 0.5,
            measured: None,
            distance: None,
            difference_size: [0; 2],
            other: Canvas::default(),
            difference: Canvas::default(),
        }
    }

    /// A comparison with the picture of a file that is called `name`.
    #[must_use]
    pub fn with_file(name: String, file: FilePicture) -> Self {
        Self {
            saved_look: file.saved_look,
            ..Self::new(name, None, file.buffer)
        }
    }

    /// How far the pictures are apart, or why that cannot be said; `None` until it is known.
    #[must_use]
    pub fn distance(&self) -> Option<&Result<Distance, String>> {
        self.distance.as_ref()
    }

    /// Whether A, which is `picture`, is to be measured: it is another one, or has changed and the last time is long enough ago.
    /// Takes note that it is.
    pub fn must_measure(&mut self, picture: PictureId, is_running: bool) -> bool {
        let is_due = self.measured.is_none_or(|measured| {
            measured.picture != picture
                || measured.was_running && (!is_running || measured.at.elapsed() > INTERVAL)
        });
        if is_due {
            if self.measures_another(picture) {
                self.distance = None;
                self.difference = Canvas::default();
            }
            self.measured = Some(Measured {
                picture,
                was_running: is_running,
                at: Instant::now(),
            });
        }
        is_due
    }

    /// Takes in how far the pictures are apart, and the size of the picture of the difference.
    pub fn set_distance(&mut self, result: Result<(Distance, [usize; 2]), String>) {
        self.distance = Some(result.map(|(distance, size)| {
            if self.difference_size != size {
                self.difference = Canvas::default();
            }
            self.difference_size = size;
            distance
        }));
    }

    /// Takes in what is encoded of a picture; it is on the screen from [`Self::show_tiles`] on.
    pub fn take(&mut self, side: Side, encoded: Encoded) {
        match side {
            Side::Other => self.other.take(encoded),
            Side::Difference => self.difference.take(encoded),
        }
    }

    /// Puts the pieces that were taken in on the screen.
    pub fn show_tiles(&mut self, ctx: &egui::Context) {
        self.other.flush(ctx, self.buffer.size_in_texels());
        self.difference.flush(ctx, self.difference_size);
    }

    /// Takes the place of `before`: as that is shown, and showing its picture until this one is there.
    pub fn continue_from(&mut self, before: &mut Self) {
        self.mode = before.mode;
        self.shows_other = before.shows_other;
        self.divider = before.divider;
        if before.buffer.part() == self.buffer.part() {
            self.other = std::mem::take(&mut before.other);
        }
    }

    /// Whether A is another picture than the one that was measured last, or is being.
    #[must_use]
    pub fn measures_another(&self, picture: PictureId) -> bool {
        self.measured
            .is_some_and(|measured| measured.picture != picture)
    }

    /// Takes all off the screen; the difference is drawn anew.
    pub fn hide(&mut self) {
        self.other = Canvas::default();
        self.difference = Canvas::default();
        self.measured = None;
    }

    fn other(&self) -> Option<&Canvas> {
        Some(&self.other).filter(|canvas| canvas.is_shown())
    }

    fn difference(&self) -> Option<&Canvas> {
        let is_known = matches!(self.distance, Some(Ok(_)));
        Some(&self.difference).filter(|canvas| is_known && canvas.is_shown())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::mean_flip;

    fn comparison() -> Comparison {
        let buffer = PictureBuffer::of_image(Image::black(4, 4), Display::default());
        Comparison::new("other".to_owned(), Some(1), Arc::new(buffer))
    }

    #[test]
    fn pictures_are_compared_as_the_command_does() {
        let a = Image {
            width: 2,
            height: 1,
            pixels: vec![[1.0; 3], [0.5; 3]],
        };
        let b = Image {
            pixels: vec![[1.0; 3]; 2],
            ..a.clone()
        };
        let wanted = CancelToken::new();
        let (distance, difference) = compare(&a, &b, false, &wanted).unwrap();
        assert!((distance.rmse - 0.125_f64.sqrt()).abs() < 1e-12);
        assert!((distance.relmse - 0.125 / 1.01).abs() < 1e-6);
        assert_eq!((distance.differing_pixels, distance.white), (1, 0.5));
        assert_eq!(distance.flip, mean_flip(&a, &b).ok());
        assert_eq!(compare(&a, &b, true, &wanted).unwrap().0.flip, None);
        assert_eq!(difference.image().pixels, [[0.0; 3], [1.0; 3]]);
        let error = compare(&a, &Image::black(3, 1), true, &wanted).unwrap_err();
        assert!(error.contains("2×1 and 3×1"), "{error}");
    }

    /// A buffer of a part of a picture whose pixels are told apart by where they are.
    fn part_buffer(region: Region, of: [u32; 2], brighter: f32) -> PictureBuffer {
        let part = Part { region, of };
        let buffer = PictureBuffer::new(part, Vec::new(), Display::default()).unwrap();
        let rows = region.y..region.y + region.height;
        let pixels = rows.flat_map(|y| {
            let columns = region.x..region.x + region.width;
            columns.map(move |x| [x as f32 + 100.0 * y as f32 + brighter; 3])
        });
        let rgb: Vec<_> = pixels.collect();
        let tile = crate::render::TilePixels {
            region,
            rgb: &rgb,
            layers: &[],
        };
        assert!(buffer.accept(&tile).is_some());
        buffer
    }

    #[test]
    fn a_region_is_compared_with_the_same_pixels_of_the_whole() {
        let of = [8, 6];
        let region = |x, y, width, height| Region {
            x,
            y,
            width,
            height,
        };
        let whole = part_buffer(Region::full(8, 6), of, 0.0);
        let part = part_buffer(region(3, 2, 4, 3), of, 0.5);
        let wanted = CancelToken::new();
        for (a, b) in [(&whole, &part), (&part, &whole)] {
            let (distance, difference) = compare_buffers(a, b, None, false, &wanted).unwrap();
            assert!((distance.rmse - 0.5).abs() < 1e-6, "{distance:?}");
            assert_eq!(distance.differing_pixels, 12);
            assert_eq!(distance.shared, Some(part.part()));
            assert_eq!(difference.size_in_texels(), [4, 3]);
        }
        let other = part_buffer(region(5, 0, 3, 4), of, 0.5);
        let (distance, _) = compare_buffers(&part, &other, None, false, &wanted).unwrap();
        assert_eq!(distance.differing_pixels, 0);
        assert_eq!(distance.shared.unwrap().region, region(5, 2, 2, 2));
        let far = part_buffer(region(0, 0, 2, 2), of, 0.0);
        let error = compare_buffers(&part, &far, None, false, &wanted).unwrap_err();
        assert!(error.contains("no pixel in common"), "{error}");
    }

    #[test]
    fn a_picture_is_measured_when_it_is_new_and_when_it_is_done() {
        let mut comparison = comparison();
        let [first, second] =
            [(); 2].map(|()| PictureBuffer::of_image(Image::black(4, 4), Display::default()).id());
        assert!(comparison.must_measure(first, true));
        assert!(!comparison.must_measure(first, true));
        assert!(comparison.must_measure(first, false));
        assert!(!comparison.must_measure(first, false));
        comparison.set_distance(Err("their sizes differ".to_owned()));
        assert!(comparison.must_measure(second, false));
        assert_eq!(comparison.distance(), None, "that was of another");
    }
}
