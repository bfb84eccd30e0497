use super::Image;
use super::tiles::Region;

/// Sums of samples per pixel, normalised only when read.
///
/// Sums are `f64`: a hundred thousand samples drift by less than an `f32` can show. Samples arrive in fixed blocks, each
/// summed from zero, and blocks are added in index order, so an interrupted render continues to the same bits.
#[derive(Clone, Debug)]
pub struct Film {
    region: Region,
    sums: Vec<[f64; 3]>,
    samples: Vec<u32>,
}

impl Film {
    /// An empty film over `region` of the picture.
    #[must_use]
    pub fn new(region: Region) -> Self {
        let pixels = region.pixel_count();
        Self {
            region,
            sums: vec![[0.0; 3]; pixels],
            samples: vec![0; pixels],
        }
    }

    /// Adds one block of `samples` per pixel over `tile`; `sums` row by row.
    ///
    /// # Panics
    /// When the tile does not lie in the film's region or `sums` has another size.
    pub fn add(&mut self, tile: Region, sums: &[[f64; 3]], samples: u32) {
        assert_eq!(
            sums.len(),
            tile.pixel_count(),
            "one sum per pixel of the tile"
        );
        for (row, block) in sums.chunks_exact(tile.width as usize).enumerate() {
            let start = self.row_start(tile, row);
            for (offset, block_sum) in block.iter().enumerate() {
                for (sum, value) in self.sums[start + offset].iter_mut().zip(block_sum) {
                    *sum += value;
                }
                self.samples[start + offset] += samples;
            }
        }
    }

    /// The mean radiance of every pixel of `tile`, row by row; black where nothing was sampled.
    #[must_use]
    pub fn means(&self, tile: Region) -> Vec<[f32; 3]> {
        (0..tile.height as usize)
            .flat_map(|row| {
                let start = self.row_start(tile, row);
                (start..start + tile.width as usize).map(|index| self.mean(index))
            })
            .collect()
    }

    /// The picture so far.
    #[must_use]
    pub fn image(&self) -> Image {
        let Region { width, height, .. } = self.region;
        Image {
            width,
            height,
            pixels: (0..self.sums.len()).map(|index| self.mean(index)).collect(),
        }
    }

    fn mean(&self, index: usize) -> [f32; 3] {
        let samples = f64::from(self.samples[index].max(1));
        #[expect(clippy::cast_possible_truncation, reason = "the picture is f32")]
        self.sums[index].map(|sum| (sum / samples) as f32)
    }

    fn row_start(&self, tile: Region, row: usize) -> usize {
        let (x, y) = (
            (tile.x - self.region.x) as usize,
            (tile.y - self.region.y) as usize,
        );
        (y + row) * self.region.width as usize + x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_taken_over_the_samples_of_each_pixel() {
        let region = Region {
            x: 10,
            y: 20,
            width: 3,
            height: 2,
        };
        let mut film = Film::new(region);
        film.add(region, &[[1.0, 2.0, 4.0]; 6], 1);
        let corner = Region {
            x: 12,
            y: 21,
            width: 1,
            height: 1,
        };
        film.add(corner, &[[3.0, 0.0, 0.0]], 3);
        assert_eq!(film.image().pixel(2, 1), [1.0, 0.5, 1.0]);
        assert_eq!(film.image().pixel(0, 0), [1.0, 2.0, 4.0]);
        assert_eq!(film.means(corner), [[1.0, 0.5, 1.0]]);
    }
}
