//! Which pixel of a picture each texel of its texture shows.
//!
//! A picture wider or higher than a texture may be is shown at a whole fraction of its size, one pixel of every block; nothing but the
//! showing is reduced.

use std::ops::Range;

use egui::{Color32, ColorImage, Vec2};

/// Largest side of the texture a picture is shown with, whatever the GPU can hold: more than screens show, and made and
/// copied within a frame.
const LARGEST_TEXTURE: u32 = 4096;
/// Rows of texels of one piece of a picture that is encoded anew.
pub(super) const ROWS_PER_BAND: u32 = 64;

/// A piece of the picture as the screen shows it, in texels of the texture.
#[derive(Clone, Debug)]
pub struct EncodedTile {
    /// Left and top edge.
    pub position: [usize; 2],
    /// Size and colours.
    pub pixels: ColorImage,
}

/// A coarse picture as the screen shows it.
#[derive(Clone, Debug)]
pub struct CoarseTexels {
    /// A texel for each block of pixels.
    pub pixels: ColorImage,
    /// What of their width and height the picture takes: blocks at its edges are cut off.
    pub share: Vec2,
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
    /// The texels of a picture of `size` pixels, on textures of at most `largest_texture` texels a side.
    pub fn of(size: [u32; 2], largest_texture: u32) -> Self {
        let largest = largest_texture.clamp(1, LARGEST_TEXTURE);
        let step = size[0].max(size[1]).div_ceil(largest).max(1);
        Self { size, step }
    }

    /// Picture pixels per texel along each axis: 1 unless the picture is too large for a texture.
    pub fn step(self) -> u32 {
        self.step
    }

    /// Width and height of the texture.
    pub fn size(self) -> [usize; 2] {
        self.size.map(|side| side.div_ceil(self.step) as usize)
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
            pixels: ColorImage::new(size, pixels),
        })
    }
}
