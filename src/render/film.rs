use super::Image;
use super::layers::{Gathered, Layer};
use super::tiles::Region;

/// Sums of samples per pixel, normalised only when read.
///
/// Sums are `f64`: a hundred thousand samples drift by less than an `f32` can show. Samples arrive in fixed blocks, each
/// summed from zero, and blocks are added in index order, so an interrupted render continues to the same bits.
#[derive(Clone, Debug)]
pub struct Film {
    region: Region,
    /// The picture's sums first, then those of each layer.
    planes: Vec<Vec<[f64; 3]>>,
    layers: Vec<Layer>,
    samples: Vec<u32>,
}

/// The sums of one block of samples over one tile: the picture's first, then those of each layer, each row by row.
#[derive(Clone, Debug)]
pub struct TileSums {
    planes: Vec<Vec<[f64; 3]>>,
}

impl TileSums {
    /// Nothing yet of `pixels` pixels.
    pub fn new(layers: &[Layer], pixels: usize) -> Self {
        Self {
            planes: vec![vec![[0.0; 3]; pixels]; 1 + layers.len()],
        }
    }

    /// Adds a sample of the pixel number `index`.
    pub fn add(&mut self, index: usize, layers: &[Layer], sample: &Gathered) {
        let (picture, rest) = self.planes.split_first_mut().expect("the picture is there");
        add_to(&mut picture[index], sample.radiance.as_dvec3().to_array());
        for (plane, &layer) in rest.iter_mut().zip(layers) {
            add_to(&mut plane[index], sample.of(layer).as_dvec3().to_array());
        }
    }
}

fn add_to(sum: &mut [f64; 3], value: [f64; 3]) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += value;
    }
}

impl Film {
    /// An empty film over `region` of the picture, with these layers beside it.
    #[must_use]
    pub fn new(region: Region, layers: &[Layer]) -> Self {
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
        }
    }

    /// Adds one block of `samples` per pixel over `tile`.
    ///
    /// # Panics
    /// When the tile does not lie in the film's region or `sums` is of another size or has other layers.
    pub fn add(&mut self, tile: Region, sums: &TileSums, samples: u32) {
        assert_eq!(self.planes.len(), sums.planes.len(), "the same layers");
        for row in 0..tile.height as usize {
            let start = self.row_start(tile, row);
            let width = tile.width as usize;
            for (plane, sums) in self.planes.iter_mut().zip(&sums.planes) {
                assert_eq!(
                    sums.len(),
                    tile.pixel_count(),
                    "one sum per pixel of the tile"
                );
                let row = &sums[row * width..][..width];
                for (sum, value) in plane[start..start + width].iter_mut().zip(row) {
                    add_to(sum, *value);
                }
            }
            for count in &mut self.samples[start..start + width] {
                *count += samples;
            }
        }
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
        self.image_of(&self.planes[0])
    }

    /// The layers so far.
    #[must_use]
    pub fn layer_images(&self) -> Vec<(Layer, Image)> {
        let images = self.planes[1..].iter().map(|plane| self.image_of(plane));
        self.layers.iter().copied().zip(images).collect()
    }

    fn image_of(&self, plane: &[[f64; 3]]) -> Image {
        let Region { width, height, .. } = self.region;
        Image {
            width,
            height,
            pixels: (0..plane.len())
                .map(|index| self.mean(plane, index))
                .collect(),
        }
    }

    fn mean(&self, plane: &[[f64; 3]], index: usize) -> [f32; 3] {
        let samples = f64::from(self.samples[index].max(1));
        #[expect(clippy::cast_possible_truncation, reason = "the picture is f32")]
        plane[index].map(|sum| (sum / samples) as f32)
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

    fn sums(pixels: usize, samples: &[[f32; 3]]) -> TileSums {
        let mut sums = TileSums::new(&[Layer::Ambient], pixels);
        for index in 0..pixels {
            for &sample in samples {
                sums.add(index, &[Layer::Ambient], &Gathered::seen(sample.into()));
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
        let mut film = Film::new(region, &[Layer::Ambient]);
        film.add(region, &sums(6, &[[1.0, 2.0, 4.0]]), 1);
        let corner = Region {
            x: 12,
            y: 21,
            width: 1,
            height: 1,
        };
        film.add(
            corner,
            &sums(1, &[[1.0, 0.0, 0.0], [0.0; 3], [2.0, 0.0, 0.0]]),
            3,
        );
        assert_eq!(film.image().pixel(2, 1), [1.0, 0.5, 1.0]);
        assert_eq!(film.image().pixel(0, 0), [1.0, 2.0, 4.0]);
        assert_eq!(film.means(corner), [[[1.0, 0.5, 1.0]], [[0.0; 3]]]);
    }
}
