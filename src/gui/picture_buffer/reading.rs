//! What is read from a picture beside its tiles: a pixel, a small picture, how bright it is.

use egui::ColorImage;

use super::PictureBuffer;
use crate::gui::histogram::Histogram;
use crate::gui::inspector::PixelValues;
use crate::render::{Image, Layer};

/// Most width and height of a thumbnail, in pixels.
const THUMBNAIL: [u32; 2] = [192, 120];

impl PictureBuffer {
    /// What is at column and row `[x, y]` of the picture; `None` outside of what is kept of it.
    #[must_use]
    pub fn values_at(&self, pixel: [u32; 2]) -> Option<PixelValues> {
        let [x, y] = self.kept(pixel)?;
        let state = self.lock();
        let layer = self.layer(state.shown);
        // Before the first tile there is nothing.
        let linear = state.planes.get(state.shown)?.pixel(x, y);
        let error = self.layers().iter().position(|&kept| kept == Layer::Error);
        let error = error.filter(|_| state.error_scale.is_some() && layer.is_none());
        Some(PixelValues {
            linear,
            color: state.look_on_screen(layer).color(linear),
            error: error.map(|index| state.planes[index + 1].pixel(x, y)),
        })
    }

    /// The light at column and row `[x, y]` of the picture, whatever layer is on the screen; `None` outside of what is kept of it.
    #[must_use]
    pub fn light_at(&self, pixel: [u32; 2]) -> Option<[f32; 3]> {
        let [x, y] = self.kept(pixel)?;
        Some(self.lock().planes.first()?.pixel(x, y))
    }

    /// Column and row of a pixel of the picture in what is kept of it; `None` outside of that.
    fn kept(&self, [x, y]: [u32; 2]) -> Option<[u32; 2]> {
        let x = x.checked_sub(self.part.region.x)?;
        let y = y.checked_sub(self.part.region.y)?;
        (x < self.width && y < self.height).then_some([x, y])
    }

    /// How often each brightness is on the screen. Of a large picture some pixels of every row count for all; what is not finite is
    /// looked for in each.
    #[must_use]
    pub fn histogram(&self) -> Histogram {
        /// Pixels counted about: more make no visible difference.
        const ENOUGH: u64 = 1 << 20;
        let pixels = u64::from(self.width) * u64::from(self.height);
        let step = usize::try_from(pixels / ENOUGH)
            .unwrap_or(usize::MAX)
            .max(1);
        let scale = {
            let state = self.lock();
            state.look_on_screen(self.layer(state.shown)).scale()
        };
        let mut histogram = Histogram::new(scale);
        for y in 0..self.height {
            // The window may want the picture in between.
            let mut state = self.lock();
            let shown = state.shown;
            let look = state.look_on_screen(self.layer(shown));
            if look.scale() != scale {
                // Another look was asked for, and soon its histogram.
                break;
            }
            let width = self.width as usize;
            let row = &state.planes()[shown].pixels[y as usize * width..][..width];
            let is_finite = |pixel: &[f32; 3]| pixel.iter().all(|channel| channel.is_finite());
            // Another column first in each row, so that no column is left out.
            let first = y as usize % step;
            for pixel in row.iter().skip(first).step_by(step) {
                if is_finite(pixel) {
                    let (levels, is_white) = look.levels(*pixel);
                    histogram.count(levels, is_white);
                }
            }
            let corner = [self.part.region.x, self.part.region.y];
            for (x, pixel) in (0..).zip(row) {
                if !is_finite(pixel) {
                    histogram.count_not_finite([corner[0] + x, corner[1] + y]);
                }
            }
        }
        histogram
    }

    /// A small picture of the whole, whatever layer is on the screen.
    #[must_use]
    pub fn thumbnail(&self) -> ColorImage {
        let block = self
            .width
            .div_ceil(THUMBNAIL[0])
            .max(self.height.div_ceil(THUMBNAIL[1]));
        let block = block.max(1);
        let size = [self.width, self.height].map(|side| side.div_ceil(block));
        let mut pixels = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for y in 0..size[1] {
            // The window may want the picture in between.
            let mut state = self.lock();
            let look = state.look(None);
            for x in 0..size[0] {
                let rgb = self.mean_of_block(&state.planes()[0], [x * block, y * block], block);
                pixels.push(look.color(rgb));
            }
        }
        ColorImage::new(size.map(|side| side as usize), pixels)
    }

    /// The mean of some finite pixels of a square block at `[x, y]`.
    fn mean_of_block(&self, image: &Image, [x, y]: [u32; 2], block: u32) -> [f32; 3] {
        /// Pixels looked at along each axis: more make no visible difference.
        const MOST: u32 = 4;
        let step = block.div_ceil(MOST);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for row in (y..(y + block).min(self.height)).step_by(step as usize) {
            for column in (x..(x + block).min(self.width)).step_by(step as usize) {
                let pixel = image.pixel(column, row);
                if pixel.iter().all(|channel| channel.is_finite()) {
                    sum = std::array::from_fn(|i| sum[i] + pixel[i]);
                    count += 1.0;
                }
            }
        }
        sum.map(|channel| channel / f32::max(count, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::look::{Channels, Levels, Scale};
    use crate::gui::part::Part;
    use crate::render::{Region, TilePixels};
    use crate::scene::Display;
    use egui::Color32;

    #[test]
    fn a_thumbnail_is_the_mean_of_blocks_and_leaves_out_what_is_not_finite() {
        let size = Part::whole([400, 100]);
        let buffer = PictureBuffer::new(size, Vec::new(), Display::default()).unwrap();
        let region = Region::full(400, 100);
        let mut rgb = vec![[1.0; 3]; region.pixel_count()];
        rgb[0] = [f32::NAN, 0.0, 0.0];
        let whole = TilePixels {
            region,
            rgb: &rgb,
            layers: &[],
        };
        assert!(buffer.accept(&whole).is_some());
        let thumbnail = buffer.thumbnail();
        assert_eq!(thumbnail.size, [134, 34]);
        assert!(thumbnail.pixels.iter().all(|&p| p == Color32::WHITE));
    }

    #[test]
    fn the_histogram_is_of_what_is_on_the_screen() {
        let layers = vec![Layer::Error];
        let part = Part {
            region: Region {
                x: 10,
                y: 20,
                width: 4,
                height: 2,
            },
            of: [100, 80],
        };
        let buffer = PictureBuffer::new(part, layers, Display::default()).unwrap();
        // Red cut off, green black; what is not finite counts for nothing else.
        let mut rgb = vec![[2.0, 0.0, 0.5]; 8];
        rgb[5] = [0.0, f32::INFINITY, 0.0];
        let tile = TilePixels {
            region: part.region,
            rgb: &rgb,
            layers: &[],
        };
        assert!(buffer.accept(&tile).is_some());
        let seen = |channels| {
            buffer.set_channels(channels);
            buffer.histogram()
        };
        let expected = |scale, levels, is_white| {
            let mut histogram = Histogram::new(scale);
            for _ in 0..7 {
                histogram.count(levels, is_white);
            }
            histogram.count_not_finite([11, 21]);
            histogram
        };
        let all = expected(Scale::Colors, Levels::Colors([255, 0, 188]), true);
        assert_eq!(seen(Channels::All), all);
        let grey = |level, is_white| expected(Scale::Grey, Levels::One(level), is_white);
        assert_eq!(seen(Channels::Red), grey(255, true));
        assert_eq!(seen(Channels::Green), grey(0, false));
        assert_eq!(seen(Channels::Blue), grey(188, false));
        // 0.2126 · 2 + 0.0722 · 0.5 is 1.116 stops below white, of twelve stops from eight below.
        let stops = expected(Scale::Stops, Levels::One(146), false);
        assert_eq!(seen(Channels::FalseColors), stops);
        // The error is told whatever channels are chosen.
        buffer.set_error(Image {
            width: 4,
            height: 2,
            pixels: vec![[0.25, 0.0, 0.0]; 8],
        });
        buffer.set_shown(Some(Layer::Error));
        let errors = seen(Channels::Red);
        assert_eq!(errors.not_finite(), 0);
        let mut expected = Histogram::new(Scale::Errors);
        for _ in 0..8 {
            expected.count(Levels::One(255), true);
        }
        assert_eq!(errors, expected);
    }

    #[test]
    fn a_pixel_is_read_with_its_color_and_error() {
        let layers = vec![Layer::Shadow, Layer::Error];
        let buffer = PictureBuffer::new(Part::whole([4, 3]), layers, Display::default()).unwrap();
        let region = Region::full(4, 3);
        let (rgb, shadow) = (vec![[1.0; 3]; 12], vec![[0.0; 3]; 12]);
        let layers = [shadow];
        let whole = TilePixels {
            region,
            rgb: &rgb,
            layers: &layers,
        };
        assert!(buffer.accept(&whole).is_some());
        let values = buffer.values_at([3, 2]).unwrap();
        assert_eq!((values.linear, values.color), ([1.0; 3], Color32::WHITE));
        assert_eq!(values.error, None, "nothing is known of it yet");
        buffer.set_error(Image {
            width: 4,
            height: 3,
            pixels: vec![[0.25; 3]; 12],
        });
        assert_eq!(buffer.values_at([0, 0]).unwrap().error, Some([0.25; 3]));
        // What is told is what is seen, also where that is one channel, or no light.
        buffer.set_channels(Channels::FalseColors);
        let told = buffer.values_at([0, 0]).unwrap().color;
        let white = crate::gui::false_colors::color(1.0, &Display::default());
        assert_eq!(told, white);
        buffer.set_channels(Channels::All);
        buffer.set_shown(Some(Layer::Shadow));
        let values = buffer.values_at([0, 0]).unwrap();
        assert_eq!((values.linear, values.error), ([0.0; 3], None));
        assert_eq!(buffer.values_at([4, 0]), None);
        assert!(buffer.histogram().white_share() < 1e-12);
    }
}
