//! Regions of a picture and the tiles they are cut into, in pixels from the top left of the full picture.

use serde::{Deserialize, Serialize};

use super::Image;

/// A rectangle of pixels of the full picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Region {
    /// Leftmost column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl Region {
    /// The whole of a picture.
    #[must_use]
    pub fn full(width: u32, height: u32) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether it has pixels and lies inside a `width` × `height` picture.
    #[must_use]
    pub fn fits(&self, width: u32, height: u32) -> bool {
        let within = |start: u32, length: u32, side: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= side)
        };
        within(self.x, self.width, width) && within(self.y, self.height, height)
    }

    /// Copies the region's pixels, row by row, into `image`, a picture of the full size.
    ///
    /// # Panics
    /// When the region does not lie in the image.
    pub fn copy_into(&self, pixels: &[[f32; 3]], image: &mut Image) {
        for (row, pixels) in pixels.chunks_exact(self.width as usize).enumerate() {
            let start = (self.y as usize + row) * image.width as usize + self.x as usize;
            image.pixels[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }

    /// Its pixels, row by row.
    pub(super) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> {
        let Self {
            x,
            y,
            width,
            height,
        } = *self;
        (y..y + height).flat_map(move |row| (x..x + width).map(move |column| (column, row)))
    }

    /// Cuts the region into tiles of at most `side` × `side` pixels, row by row.
    pub(super) fn cut(&self, side: u32) -> impl Iterator<Item = Region> {
        let whole = *self;
        let starts = move |length: u32| (0..length).step_by(side as usize);
        let corners =
            starts(whole.height).flat_map(move |y| starts(whole.width).map(move |x| (x, y)));
        corners.map(move |(x, y)| Region {
            x: whole.x + x,
            y: whole.y + y,
            width: side.min(whole.width - x),
            height: side.min(whole.height - y),
        })
    }

    /// The tiles of [`Self::cut`], those nearest the middle first, where people look.
    pub(super) fn tiles(&self, side: u32) -> Vec<Region> {
        let count = self.width.div_ceil(side) as usize * self.height.div_ceil(side) as usize;
        let mut tiles = Vec::with_capacity(count);
        tiles.extend(self.cut(side));
        // Twice the middle, so that it is a whole number. The sort is stable: equal distances keep their order.
        let middle = |region: &Region| {
            let twice = |start: u32, length: u32| 2 * i64::from(start) + i64::from(length);
            (
                twice(region.x, region.width),
                twice(region.y, region.height),
            )
        };
        let (cx, cy) = middle(self);
        tiles.sort_by_key(|tile| {
            let (x, y) = middle(tile);
            (x - cx).pow(2) + (y - cy).pow(2)
        });
        tiles
    }
}

/// What a finished tile shows so far.
#[derive(Clone, Copy, Debug)]
pub struct TilePixels<'a> {
    /// Where it lies in the full picture.
    pub region: Region,
    /// Mean linear radiance, row by row.
    pub rgb: &'a [[f32; 3]],
    /// Means of the layers that are kept, in the order of [`super::PreparedScene::layers`].
    pub layers: &'a [Vec<[f32; 3]>],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once_from_the_middle_out() {
        let region = Region {
            x: 5,
            y: 7,
            width: 70,
            height: 33,
        };
        let tiles = region.tiles(16);
        let mut covered = vec![0; region.pixel_count()];
        for tile in &tiles {
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    covered[((y - region.y) * region.width + x - region.x) as usize] += 1;
                }
            }
        }
        assert!(covered.iter().all(|&count| count == 1));
        assert_eq!(
            tiles[0],
            Region {
                x: 5 + 32,
                y: 7 + 16,
                width: 16,
                height: 16
            }
        );
    }

    #[test]
    fn regions_outside_the_picture_do_not_fit() {
        assert!(
            Region {
                x: 3,
                y: 0,
                width: 1,
                height: 4
            }
            .fits(4, 4)
        );
        assert!(
            !Region {
                x: 3,
                y: 0,
                width: 2,
                height: 4
            }
            .fits(4, 4)
        );
        assert!(
            !Region {
                x: 0,
                y: 0,
                width: 0,
                height: 4
            }
            .fits(4, 4)
        );
        assert!(
            !Region {
                x: u32::MAX,
                y: 0,
                width: 2,
                height: 1
            }
            .fits(4, 4)
        );
    }
}
