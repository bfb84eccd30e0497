//! How the texels of a picture are cut into cells, each of which is a texture on the screen, and a piece where the picture is encoded anew.

use std::ops::Range;
use std::sync::Arc;

use egui::ColorImage;

use super::texels::EncodedTile;

/// Most columns of a cell, whatever the GPU can hold: with [`ROWS`], as much as is made and copied within a frame.
const MOST_COLUMNS: usize = 4096;
/// Fewest rows of a cell.
const ROWS: usize = 64;
/// Most cells one below the other, as each is drawn by a call of its own. Those of higher pictures have more rows, and fewer columns, as
/// the texels of a picture are bounded.
const MOST_BANDS: usize = 256;

/// A picture that is cut into cells, numbered row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Grid {
    /// Width and height of the picture, in texels.
    size: [usize; 2],
    /// Width and height of a cell; those at the right and lower edge may have less.
    cell: [usize; 2],
}

impl Grid {
    /// Cuts a picture of `size` texels into cells of at most `largest_texture` columns. Those side by side are about as wide as each other, so
    /// that none takes more of a frame than it must.
    #[must_use]
    pub fn of(size: [usize; 2], largest_texture: usize) -> Self {
        let [width, height] = size;
        let columns = width.div_ceil(largest_texture.clamp(1, MOST_COLUMNS));
        let cell = [
            width.div_ceil(columns.max(1)),
            ROWS.max(height.div_ceil(MOST_BANDS)),
        ];
        Self { size, cell }
    }

    /// Width and height of the picture, in texels.
    #[must_use]
    pub fn size(self) -> [usize; 2] {
        self.size
    }

    /// How many cells there are.
    #[must_use]
    pub fn count(self) -> usize {
        self.columns() * self.size[1].div_ceil(self.cell[1])
    }

    /// Cells side by side.
    fn columns(self) -> usize {
        self.size[0].div_ceil(self.cell[0])
    }

    /// The columns and rows of texels of a cell.
    #[must_use]
    pub fn texels(self, number: usize) -> [Range<usize>; 2] {
        let columns = self.columns();
        let place = [number % columns, number / columns];
        [0, 1].map(|axis| {
            let start = place[axis] * self.cell[axis];
            start..(start + self.cell[axis]).min(self.size[axis])
        })
    }

    /// The cell that a texel lies in.
    #[must_use]
    pub fn cell_at(self, [x, y]: [usize; 2]) -> usize {
        y / self.cell[1] * self.columns() + x / self.cell[0]
    }

    /// Cuts a piece of the picture where it crosses edges of cells.
    #[must_use]
    pub fn cut(self, piece: EncodedTile) -> Vec<EncodedTile> {
        let cells = [0, 1].map(|axis| {
            let start = piece.position[axis];
            let end = start + piece.pixels.size[axis];
            start / self.cell[axis]..end.div_ceil(self.cell[axis])
        });
        if cells.iter().all(|cells| cells.len() == 1) {
            return vec![piece];
        }
        let [columns, rows] = cells;
        let numbers = rows.flat_map(|row| columns.clone().map(move |x| row * self.columns() + x));
        numbers
            .map(|number| part_in(&piece, &self.texels(number)))
            .collect()
    }
}

/// What of a piece lies in some columns and rows of the picture.
fn part_in(piece: &EncodedTile, texels: &[Range<usize>; 2]) -> EncodedTile {
    let [columns, rows] = [0, 1].map(|axis| {
        let start = piece.position[axis];
        let end = start + piece.pixels.size[axis];
        texels[axis].start.max(start)..texels[axis].end.min(end)
    });
    let position = [columns.start, rows.start];
    let size = [columns.len(), rows.len()];
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for row in rows {
        let start = (row - piece.position[1]) * piece.pixels.size[0];
        let first = start + columns.start - piece.position[0];
        pixels.extend_from_slice(&piece.pixels.pixels[first..first + size[0]]);
    }
    EncodedTile {
        position,
        pixels: Arc::new(ColorImage::new(size, pixels)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Color32;

    #[test]
    fn each_texel_lies_in_one_cell_that_a_texture_holds() {
        for size in [
            [1, 1],
            [4096, 64],
            [4097, 65],
            [5120, 2880],
            [16_384, 4000],
            [8192, 8192],
            [65_536, 1],
            [3, 65_536],
        ] {
            for largest in [2048, 8192] {
                let grid = Grid::of(size, largest);
                assert!(grid.count() <= 512, "{grid:?}");
                let mut texels = 0;
                for number in 0..grid.count() {
                    let [columns, rows] = grid.texels(number);
                    assert!(columns.len() <= largest.min(MOST_COLUMNS), "{grid:?}");
                    assert_eq!(grid.cell_at([columns.start, rows.start]), number);
                    assert_eq!(grid.cell_at([columns.end - 1, rows.end - 1]), number);
                    texels += columns.len() * rows.len();
                }
                assert_eq!(texels, size[0] * size[1], "{grid:?}");
            }
        }
    }

    #[test]
    fn cells_are_bands_as_long_as_a_texture_holds_them_and_else_equally_wide() {
        let cell = |size| Grid::of(size, 8192).cell;
        assert_eq!(cell([3840, 2160]), [3840, 64]);
        assert_eq!(cell([4096, 4096]), [4096, 64]);
        assert_eq!(cell([5120, 2880]), [2560, 64]);
        assert_eq!(cell([16_384, 4000]), [4096, 64]);
        assert_eq!(cell([1024, 65_536]), [1024, 256]);
        assert_eq!(Grid::of([3840, 2160], 2048).cell, [1920, 64]);
    }

    #[test]
    fn a_piece_is_cut_at_the_edges_of_cells_and_nowhere_else() {
        let grid = Grid {
            size: [25, 30],
            cell: [10, 8],
        };
        let piece = |position: [usize; 2], size: [usize; 2]| {
            let count = u8::try_from(size[0] * size[1]).unwrap();
            EncodedTile {
                position,
                pixels: Arc::new(ColorImage::new(
                    size,
                    (0..count).map(Color32::from_gray).collect(),
                )),
            }
        };
        // Edge to edge of a cell.
        let whole = grid.cut(piece([10, 8], [10, 8]));
        assert_eq!(whole.len(), 1);
        assert_eq!(whole[0].pixels, piece([10, 8], [10, 8]).pixels);

        let across = piece([7, 6], [14, 11]);
        let parts = grid.cut(across.clone());
        let places: Vec<_> = parts.iter().map(|p| (p.position, p.pixels.size)).collect();
        let expected = [
            ([7, 6], [3, 2]),
            ([10, 6], [10, 2]),
            ([20, 6], [1, 2]),
            ([7, 8], [3, 8]),
            ([10, 8], [10, 8]),
            ([20, 8], [1, 8]),
            ([7, 16], [3, 1]),
            ([10, 16], [10, 1]),
            ([20, 16], [1, 1]),
        ];
        assert_eq!(places, expected);
        for part in parts {
            let [x, y] = [0, 1].map(|axis| part.position[axis] - across.position[axis]);
            for (column, row) in (0..part.pixels.size[0])
                .flat_map(|column| (0..part.pixels.size[1]).map(move |row| (column, row)))
            {
                let expected = across.pixels[(x + column, y + row)];
                assert_eq!(part.pixels[(column, row)], expected);
            }
        }
    }
}
