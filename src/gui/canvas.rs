//! A picture on the screen that is filled in piece by piece.
//!
//! Each piece that goes to the graphics driver on its own costs the window's thread some of the time it has for a frame, and a coarse
//! picture comes as hundreds at once. So pieces are collected, and where there are many in a frame, what they cover goes as one, from a
//! copy that is kept of all texels.

use egui::{Color32, ColorImage, TextureFilter, TextureHandle, TextureOptions};

use super::picture_buffer::EncodedTile;

/// Sharp pixels when enlarged, smooth when reduced.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};
/// So many pieces of a frame go one by one.
const FEW: usize = 12;

/// The texels of a picture, and the texture that shows them.
#[derive(Default)]
pub struct Canvas {
    texture: Option<TextureHandle>,
    texels: ColorImage,
    pending: Vec<EncodedTile>,
    /// Texels that were put on it, until they are all there are.
    covered: usize,
}

impl Canvas {
    /// Takes in a piece; it shows from [`Self::flush`] on.
    pub fn put(&mut self, tile: EncodedTile) {
        self.pending.push(tile);
    }

    /// Shows what was taken in, on a texture of `size` texels.
    pub fn flush(&mut self, ctx: &egui::Context, size: [usize; 2]) {
        if self.pending.is_empty() {
            return;
        }
        let texels = &mut self.texels;
        let texture = self.texture.get_or_insert_with(|| {
            *texels = ColorImage::filled(size, Color32::TRANSPARENT);
            ctx.load_texture("picture", texels.clone(), OPTIONS)
        });
        let is_one = self.pending.len() > FEW;
        let (mut first, mut end) = ([usize::MAX; 2], [0; 2]);
        for EncodedTile { position, pixels } in self.pending.drain(..) {
            self.covered = (self.covered + pixels.pixels.len()).min(size[0] * size[1]);
            copy_into(texels, position, &pixels);
            for axis in [0, 1] {
                first[axis] = first[axis].min(position[axis]);
                end[axis] = end[axis].max(position[axis] + pixels.size[axis]);
            }
            if !is_one {
                texture.set_partial(position, pixels, OPTIONS);
            }
        }
        if is_one {
            texture.set_partial(first, part_of(texels, first, end), OPTIONS);
        }
    }

    /// What there is to show; `None` before the first piece.
    #[must_use]
    pub fn texture(&self) -> Option<egui::TextureId> {
        self.texture.as_ref().map(TextureHandle::id)
    }

    /// Whether something is on it everywhere: each pass over a picture brings every texel once.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        let [width, height] = self.texels.size;
        self.texture.is_some() && self.covered >= width * height
    }
}

/// Puts `piece` into `image`, with its corner at `position`.
fn copy_into(image: &mut ColorImage, [x, y]: [usize; 2], piece: &ColorImage) {
    let [width, _] = image.size;
    for (row, texels) in piece.pixels.chunks_exact(piece.size[0].max(1)).enumerate() {
        let start = (y + row) * width + x;
        image.pixels[start..start + texels.len()].copy_from_slice(texels);
    }
}

/// The texels from `first` up to and without `end`.
fn part_of(image: &ColorImage, first: [usize; 2], end: [usize; 2]) -> ColorImage {
    let [width, _] = image.size;
    let size = [end[0] - first[0], end[1] - first[1]];
    let mut texels = Vec::with_capacity(size[0] * size[1]);
    for row in (first[1]..end[1]).map(|row| row * width) {
        texels.extend_from_slice(&image.pixels[row + first[0]..row + end[0]]);
    }
    ColorImage::new(size, texels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_pieces_go_as_one_and_few_one_by_one() {
        let ctx = egui::Context::default();
        let piece = |x: usize, y: usize| EncodedTile {
            position: [x, y],
            pixels: ColorImage::filled(
                [2, 1],
                Color32::from_gray(u8::try_from(x + 10 * y).unwrap()),
            ),
        };
        let mut canvas = Canvas::default();
        canvas.flush(&ctx, [8, 6]);
        assert_eq!((canvas.texture(), canvas.is_covered()), (None, false));
        let deltas = || {
            let mut delta = ctx.tex_manager().write().take_delta();
            let of_picture = std::mem::take(&mut delta.set).into_values().flatten();
            let partial = of_picture.filter(|delta| delta.pos.is_some());
            partial
                .map(|delta| (delta.pos.unwrap(), delta.image.size()))
                .collect::<Vec<_>>()
        };
        canvas.put(piece(2, 1));
        canvas.put(piece(4, 5));
        canvas.flush(&ctx, [8, 6]);
        assert_eq!(deltas(), [([2, 1], [2, 1]), ([4, 5], [2, 1])]);
        for y in 1..6 {
            for x in [2, 4, 6] {
                canvas.put(piece(x, y));
            }
        }
        canvas.flush(&ctx, [8, 6]);
        assert_eq!(deltas(), [([2, 1], [6, 5])]);
        let texels = &canvas.texels;
        assert_eq!(texels.pixels[8 * 5 + 7], Color32::from_gray(56));
        assert_eq!(texels.pixels[8 * 5 + 1], Color32::TRANSPARENT);
        let part = part_of(texels, [4, 4], [8, 6]);
        assert_eq!(part.size, [4, 2]);
        assert_eq!(part.pixels[7], Color32::from_gray(56));
        assert!(!canvas.is_covered());
        for y in 0..6 {
            for x in [0, 2, 4, 6] {
                canvas.put(piece(x, y));
            }
        }
        canvas.flush(&ctx, [8, 6]);
        assert!(canvas.is_covered());
    }
}
