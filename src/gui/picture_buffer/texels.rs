//! Which pixel of a picture each texel on the screen shows.
//!
//! Each shows a pixel of its own, whatever the picture's sides. A picture of more pixels than there is memory for textures is shown at a whole
//! fraction of its size, one pixel of every block; nothing but the showing is reduced.

use std::ops::Range;
use std::sync::Arc;

use egui::{Color32, ColorImage, Vec2};

use super::Grid;

/// Most texels that a picture is shown with, as many as 8192 × 8192: at four bytes each, they take 256 MB of the GPU's memory.
const MOST_SHOWN: u64 = 1 << 26;

/// A piece of the picture as the screen shows it, in texels.
#[derive(Clone, Debug)]
pub struct EncodedTile {
    /// Left and top edge.
    pub position: [usize; 2],
    /// Size and colours. Shared, for whoever is last to have them to decide where their memory goes.
    pub pixels: Arc<ColorImage>,
}

/// A coarse picture as the screen shows it.
#[derive(Clone, Debug)]
pub struct CoarseTexels {
    /// A texel for each block of pixels.
    pub pixels: Arc<ColorImage>,
    /// What of their width and height the picture takes: blocks at its edges are cut off.
    pub share: Vec2,
    /// Whether they blend into each other where they are enlarged, as the picture is sharp in a moment.
    pub is_smooth: bool,
}

/// What is encoded of a picture for the screen.
#[derive(Clone, Debug)]
pub enum Encoded {
    /// All of it, coarse: what shows of it from now on may look different.
    Coarse(CoarseTexels),
    /// A piece of it, which looks as what is there.
    Tile(EncodedTile),
}

impl CoarseTexels {
    /// The same on a texture of at most `largest_texture` texels a side: where it has more, one of every few in a row and in a column.
    #[must_use]
    pub fn within(self, largest_texture: usize) -> Self {
        let [width, height] = self.pixels.size;
        let step = width.max(height).div_ceil(largest_texture.max(1));
        if step <= 1 {
            return self;
        }
        let size = [width, height].map(|side| side.div_ceil(step));
        let rows = self.pixels.pixels.chunks(width).step_by(step);
        let texels = rows.flat_map(|row| row.iter().copied().step_by(step));
        let taken = |before: usize, after: usize| before as f32 / (after * step) as f32;
        Self {
            pixels: Arc::new(ColorImage::new(size, texels.collect())),
            share: self.share * Vec2::new(taken(width, size[0]), taken(height, size[1])),
            is_smooth: self.is_smooth,
        }
    }
}

/// The texels of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texels {
    /// Of the picture, in pixels.
    size: [u32; 2],
    /// Pixels per texel along each axis.
    step: u32,
}

impl Texels {
    /// The texels of a picture of `size` pixels.
    pub fn of(size: [u32; 2]) -> Self {
        let texels = |step: u32| -> u64 {
            let sides = size.map(|side| u64::from(side.div_ceil(step)));
            sides.iter().product()
        };
        let step = (1..=u32::MAX).find(|&step| texels(step) <= MOST_SHOWN);
        Self {
            size,
            step: step.expect("one texel is not too many"),
        }
    }

    /// Picture pixels per texel along each axis: 1 unless the picture has too many.
    pub fn step(self) -> u32 {
        self.step
    }

    /// Width and height in texels.
    pub fn size(self) -> [usize; 2] {
        self.size.map(|side| side.div_ceil(self.step) as usize)
    }

    /// The columns and rows of pixels that are encoded at once where all are: those of the cells of a [`Grid`].
    pub fn pieces(self) -> impl Iterator<Item = [Range<u32>; 2]> {
        let grid = Grid::of(self.size(), usize::MAX);
        (0..grid.count()).map(move |number| {
            let texels = grid.texels(number);
            [0, 1].map(|axis| {
                let side = self.size[axis];
                let edge = |texel: usize| {
                    let texel = u32::try_from(texel).unwrap_or(side);
                    texel.saturating_mul(self.step).min(side)
                };
                edge(texels[axis].start)..edge(texels[axis].end)
            })
        })
    }

    /// The texels whose pixel lies in the given columns and rows.
    pub fn encode(
        self,
        columns: Range<u32>,
        rows: Range<u32>,
        color: impl Fn(u32, u32) -> Color32,
    ) -> Option<EncodedTile> {
        let texels =
            |range: &Range<u32>| range.start.div_ceil(self.step)..range.end.div_ceil(self.step);
        let (columns, rows) = (texels(&columns), texels(&rows));
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        let size = [columns.len(), rows.len()];
        let position = [columns.start as usize, rows.start as usize];
        let pixels = rows
            .flat_map(|row| columns.clone().map(move |column| (column, row)))
            .map(|(column, row)| color(column * self.step, row * self.step))
            .collect();
        Some(EncodedTile {
            position,
            pixels: Arc::new(ColorImage::new(size, pixels)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_textures_have_room_for_is_shown_pixel_by_pixel_whatever_its_sides() {
        for (size, step) in [
            ([1, 1], 1),
            ([5120, 2880], 1),
            ([16_384, 4000], 1),
            ([8192, 8192], 1),
            ([65_536, 1024], 1),
            ([1024, 65_536], 1),
            ([8193, 8192], 2),
            ([65_536, 1025], 2),
            ([16_384, 16_384], 2),
            ([16_385, 16_384], 3),
        ] {
            let texels = Texels::of(size);
            assert_eq!(texels.step(), step, "{size:?}");
            let [width, height] = texels.size();
            assert!(width * height <= 1 << 26, "{size:?}");
        }
    }

    #[test]
    fn a_picture_that_is_reduced_has_no_gaps() {
        let (size, step) = ([100, 37], 4);
        let texels = Texels { size, step };
        let [width, height] = texels.size();
        assert_eq!([width, height], [25, 10]);
        let mut covered = vec![0; width * height];
        // Tiles whose edges are not multiples of the step.
        for y in (0..size[1]).step_by(7) {
            for x in (0..size[0]).step_by(9) {
                let columns = x..(x + 9).min(size[0]);
                let rows = y..(y + 7).min(size[1]);
                let color = |x: u32, y: u32| {
                    assert!(columns.contains(&x) && rows.contains(&y), "{x}, {y}");
                    Color32::WHITE
                };
                let Some(shown) = texels.encode(columns.clone(), rows.clone(), color) else {
                    continue;
                };
                let [left, top] = shown.position;
                for row in top..top + shown.pixels.height() {
                    for column in left..left + shown.pixels.width() {
                        covered[row * width + column] += 1;
                    }
                }
            }
        }
        assert!(covered.iter().all(|&count| count == 1));
    }

    #[test]
    fn the_pieces_of_a_picture_are_its_cells_and_have_every_pixel_once() {
        for (size, step) in [([5000, 70], 1), ([9001, 150], 2), ([3, 3], 4)] {
            let texels = Texels { size, step };
            let grid = Grid::of(texels.size(), usize::MAX);
            let mut pixels = 0;
            for (number, [columns, rows]) in texels.pieces().enumerate() {
                pixels += columns.len() * rows.len();
                let piece = texels.encode(columns, rows, |_, _| Color32::WHITE).unwrap();
                let [columns, rows] = grid.texels(number);
                assert_eq!(piece.position, [columns.start, rows.start], "{size:?}");
                assert_eq!(piece.pixels.size, [columns.len(), rows.len()], "{size:?}");
            }
            assert_eq!(pixels, size[0] as usize * size[1] as usize, "{size:?}");
        }
    }

    #[test]
    fn a_coarse_picture_fits_on_a_texture_and_stays_where_it_was() {
        let coarse = CoarseTexels {
            pixels: Arc::new(ColorImage::new(
                [10, 2],
                (0..20).map(Color32::from_gray).collect(),
            )),
            share: Vec2::new(0.95, 0.5),
            is_smooth: true,
        };
        let same = coarse.clone().within(10);
        assert_eq!(
            (same.pixels, same.share),
            (coarse.pixels.clone(), coarse.share)
        );
        let fewer = coarse.within(4);
        assert_eq!(fewer.pixels.size, [4, 1]);
        assert_eq!(
            fewer.pixels.pixels,
            [0, 3, 6, 9].map(Color32::from_gray).to_vec()
        );
        // Twelve columns and three rows of before, of which the picture takes 9.5 and one.
        let expected = Vec2::new(9.5 / 12.0, 1.0 / 3.0);
        assert!((fewer.share - expected).length() < 1e-6, "{}", fewer.share);
    }
}
