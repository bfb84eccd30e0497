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
    pub fn values_at(&self, [x, y]: [u32; 2]) -> Option<PixelValues> {
        let x = x.checked_sub(self.part.region.x)?;
        let y = y.checked_sub(self.part.region.y)?;
        if x >= self.width || y >= self.height {
            return None;
        }
        let state = self.lock();
        let layer = self.layer(state.shown);
        // Before the first tile there is nothing.
        let linear = state.planes.get(state.shown)?.pixel(x, y);
        let error = self.layers().iter().position(|&kept| kept == Layer::Error);
        let error = error.filter(|_| state.error_scale.is_some() && layer.is_none());
        Some(PixelValues {
            linear,
            color: state.look(layer).color(linear),
            error: error.map(|index| state.planes[index + 1].pixel(x, y)),
        })
    }

    /// How often each brightness is on the screen. Of a large picture some pixels of every row count for all.
    #[must_use]
    pub fn histogram(&self) -> Histogram {
        /// Pixels counted about: more make no visible difference.
        const ENOUGH: u64 = 1 << 20;
        let pixels = u64::from(self.width) * u64::from(self.height);
        let step = usize::try_from(pixels / ENOUGH)
            .unwrap_or(usize::MAX)
            .max(1);
        let mut histogram = Histogram::default();
        for y in 0..self.height {
            // The window may want the picture in between.
            let mut state = self.lock();
            let shown = state.shown;
            let look = state.look(self.layer(shown));
            let image = &state.planes()[shown];
            // Another column first in each row, so that no column is left out.
            let first = y % u32::try_from(step).unwrap_or(u32::MAX);
            for x in (first..self.width).step_by(step) {
                let linear = image.pixel(x, y);
                histogram.count(linear, look.color(linear));
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
        buffer.set_shown(Some(Layer::Shadow));
        let values = buffer.values_at([0, 0]).unwrap();
        assert_eq!((values.linear, values.error), ([0.0; 3], None));
        assert_eq!(buffer.values_at([4, 0]), None);
        assert!(buffer.histogram().white_share() < 1e-12);
    }
}
