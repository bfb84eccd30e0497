//! A picture on the screen that is filled in piece by piece, over a coarse one where that came first.
//!
//! What goes to the graphics driver costs the window's thread some of the time it has for a frame: each call a little, and each new
//! texture, and each large block of memory on the way there, much. So a picture is cut into cells, each a texture of its own, which is made when
//! the first piece lies in it: bands as wide as the picture, or as a texture may be. Pieces side by side in a cell go there together; and what does
//! not fit into a frame waits for the next.
//!
//! What is on the screen is of one picture in one look: another look, and another picture, begin with a coarse picture of the whole, which
//! takes the place of all there was in one frame. Only tiles of a render that goes on come one by one.
//!
//! - `pieces`: those that wait, and in which order they go

mod pieces;
#[cfg(test)]
mod tests;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{
    Color32, ColorImage, ImageData, Painter, Rect, TextureFilter, TextureHandle, TextureId,
    TextureOptions, pos2,
};

use super::jobs::drop_elsewhere;
use super::picture_buffer::{CoarseTexels, Encoded, EncodedTile, Grid};
use pieces::Queue;

/// Sharp pixels when enlarged, smooth when reduced.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};
/// Those of what becomes sharp in a moment.
const SMOOTH: TextureOptions = TextureOptions::LINEAR;
/// What a frame may spend on pieces, and how many texels it may hand on: the driver takes its time for each.
const BUDGET: Duration = Duration::from_micros(700);
const MOST_TEXELS: usize = 1 << 17;

/// The textures that show a picture, and what is to go there.
#[derive(Default)]
pub struct Canvas {
    /// What another picture shows, until there is something of this one.
    stand_in: StandIn,
    coarse: Option<(TextureHandle, Rect)>,
    new_coarse: Option<CoarseTexels>,
    grid: Grid,
    cells: Vec<Cell>,
    pending: Queue,
    /// What a cell begins with: fresh memory is dear, and most cells are as large as each other.
    blank: Option<Arc<ColorImage>>,
    /// All that was taken in and that somebody may still have: see [`Self::give_back`].
    lent: Vec<Arc<ColorImage>>,
}

/// What a canvas shows, to be shown in place of a picture that is not there yet. Nothing where that is not all of a picture.
#[derive(Clone, Default)]
pub struct StandIn(Vec<(TextureHandle, CanvasLayer)>);

/// Some columns and rows of a picture.
#[derive(Default)]
struct Cell {
    texture: Option<TextureHandle>,
    /// Whether what the texture shows is of the present picture.
    is_current: bool,
    /// Texels that were put on it, until they are all there are.
    covered: usize,
}

impl Cell {
    /// Shows `image`, which is as large as the cell, in place of all that it showed.
    fn fill(&mut self, ctx: &egui::Context, image: ImageData) {
        match &mut self.texture {
            Some(texture) => texture.set(image, OPTIONS),
            None => self.texture = Some(ctx.load_texture("picture", image, OPTIONS)),
        }
        self.is_current = true;
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        let lent = std::mem::take(&mut self.lent);
        if !lent.is_empty() {
            drop_elsewhere((pending, self.new_coarse.take(), lent));
        }
    }
}

/// A texture, where it lies in the picture (shares of width and height), and what of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CanvasLayer {
    /// The texture.
    pub texture: TextureId,
    /// Where it lies, `0..=1` along each axis.
    pub place: Rect,
    /// The part of it that is shown, `0..=1` along each axis.
    pub part: Rect,
}

/// All of something.
const WHOLE: Rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));

impl Canvas {
    /// Takes in what was encoded: a piece, or a coarse picture that begins another look.
    pub fn take(&mut self, encoded: Encoded) {
        match encoded {
            Encoded::Tile(piece) => self.put(piece),
            Encoded::Coarse(texels) => self.put_coarse(texels),
        }
    }

    /// Takes in a piece; it shows from [`Self::flush`] on, over all that came before.
    pub fn put(&mut self, piece: EncodedTile) {
        self.lent.push(Arc::clone(&piece.pixels));
        self.pending.put(piece);
    }

    /// Takes in a coarse picture, which shows from [`Self::flush`] on in place of all that there was.
    pub fn put_coarse(&mut self, texels: CoarseTexels) {
        self.lent.push(Arc::clone(&texels.pixels));
        self.pending.clear();
        self.new_coarse = Some(texels);
    }

    /// What it shows, for another canvas.
    #[must_use]
    pub fn as_stand_in(&self) -> StandIn {
        if self.is_covered() {
            StandIn(self.textures().collect())
        } else {
            StandIn::default()
        }
    }

    /// Shows what another canvas showed until there is something else to show.
    pub fn show_meanwhile(&mut self, stand_in: StandIn) {
        self.stand_in = stand_in;
    }

    /// Shows what was taken in of a picture of `size` texels, as much as a frame has time for.
    pub fn flush(&mut self, ctx: &egui::Context, size: [usize; 2]) {
        self.give_back();
        let largest_texture = ctx.input(|input| input.max_texture_side);
        let mut texels = 0;
        if let Some(coarse) = self.new_coarse.take() {
            let coarse = coarse.within(largest_texture);
            texels = coarse.pixels.pixels.len();
            self.show_coarse(ctx, coarse);
        }
        if self.pending.is_empty() {
            return;
        }
        if texels >= MOST_TEXELS {
            ctx.request_repaint();
            return;
        }
        let grid = Grid::of(size, largest_texture);
        if self.grid != grid {
            self.grid = grid;
            self.cells.clear();
            self.cells.resize_with(grid.count(), Cell::default);
        }
        let started = Instant::now();
        let mut pending = std::mem::take(&mut self.pending);
        pending.drain(grid, |piece| {
            texels += self.show(ctx, piece);
            if texels >= MOST_TEXELS || started.elapsed() > BUDGET {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        self.pending = pending;
        if !self.pending.is_empty() {
            ctx.request_repaint();
        } else if self.is_filled() {
            self.coarse = None;
        }
    }

    /// Gives back, on another thread, what nobody has any more, the driver included. A thread that renders has made it: who frees the last of what
    /// such a thread had gives back all of its memory at once, which is many megabytes and takes more than a frame has.
    fn give_back(&mut self) {
        let idle = |image: &mut Arc<ColorImage>| Arc::strong_count(image) == 1;
        let idle: Vec<_> = self.lent.extract_if(.., idle).collect();
        if !idle.is_empty() {
            drop_elsewhere(idle);
        }
    }

    fn show_coarse(&mut self, ctx: &egui::Context, texels: CoarseTexels) {
        self.stand_in.0.clear();
        for cell in &mut self.cells {
            cell.is_current = false;
            cell.covered = 0;
        }
        let part = Rect::from_min_max(pos2(0.0, 0.0), texels.share.to_pos2());
        let options = if texels.is_smooth { SMOOTH } else { OPTIONS };
        if let Some((texture, shown)) = &mut self.coarse {
            texture.set(texels.pixels, options);
            *shown = part;
        } else {
            let texture = ctx.load_texture("coarse picture", texels.pixels, options);
            self.coarse = Some((texture, part));
        }
    }

    /// Puts a piece on the cell that it lies in. Returns how many texels that handed on: all of the cell too, where it is the first of the picture
    /// there.
    fn show(
        &mut self,
        ctx: &egui::Context,
        EncodedTile { position, pixels }: EncodedTile,
    ) -> usize {
        self.stand_in.0.clear();
        let number = self.grid.cell_at(position);
        let [columns, rows] = self.grid.texels(number);
        let size = [columns.len(), rows.len()];
        let at = [position[0] - columns.start, position[1] - rows.start];
        let is_all = pixels.size == size;
        let mut handed_on = pixels.pixels.len();
        if !is_all && !self.cells[number].is_current {
            let blank = self.blank(size);
            handed_on += blank.pixels.len();
            self.cells[number].fill(ctx, blank.into());
        }
        let cell = &mut self.cells[number];
        cell.covered = (cell.covered + pixels.pixels.len()).min(size[0] * size[1]);
        match &mut cell.texture {
            Some(texture) if !is_all => texture.set_partial(at, pixels, OPTIONS),
            _ => cell.fill(ctx, pixels.into()),
        }
        handed_on
    }

    /// Nothing, as large as a cell.
    fn blank(&mut self, size: [usize; 2]) -> Arc<ColorImage> {
        let known = self.blank.take().filter(|blank| blank.size == size);
        let blank =
            known.unwrap_or_else(|| Arc::new(ColorImage::filled(size, Color32::TRANSPARENT)));
        self.blank = Some(Arc::clone(&blank));
        blank
    }

    /// All there is to show, each over the one before.
    pub fn layers(&self) -> impl Iterator<Item = CanvasLayer> {
        self.textures().map(|(_, layer)| layer)
    }

    fn textures(&self) -> impl Iterator<Item = (TextureHandle, CanvasLayer)> {
        let stand_in = self.stand_in.0.iter().cloned();
        let coarse = self.coarse.as_ref().map(|(texture, part)| {
            let layer = CanvasLayer {
                texture: texture.id(),
                place: WHOLE,
                part: *part,
            };
            (texture.clone(), layer)
        });
        let [width, height] = self.grid.size().map(|side| side.max(1) as f32);
        let cells = self.cells.iter().enumerate();
        let cells = cells.filter_map(move |(number, cell)| {
            let texture = cell.texture.as_ref().filter(|_| cell.is_current)?;
            let [columns, rows] = self.grid.texels(number);
            let corner = |x: usize, y: usize| pos2(x as f32 / width, y as f32 / height);
            let layer = CanvasLayer {
                texture: texture.id(),
                place: Rect::from_min_max(
                    corner(columns.start, rows.start),
                    corner(columns.end, rows.end),
                ),
                part: WHOLE,
            };
            Some((texture.clone(), layer))
        });
        stand_in.chain(coarse).chain(cells)
    }

    /// Whether there is anything to show.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.layers().next().is_some()
    }

    /// Draws it in `frame`.
    pub fn paint(&self, painter: &Painter, frame: Rect) {
        for CanvasLayer {
            texture,
            place,
            part,
        } in self.layers()
        {
            let corner = |at: egui::Pos2| frame.lerp_inside(at.to_vec2());
            let place = Rect::from_min_max(corner(place.min), corner(place.max));
            painter.image(texture, place, part, Color32::WHITE);
        }
    }

    /// Whether something is on it everywhere: each pass over a picture brings every texel once.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        !self.stand_in.0.is_empty() || self.coarse.is_some() || self.is_filled()
    }

    fn is_filled(&self) -> bool {
        let is_full = |(number, cell): (usize, &Cell)| {
            let [columns, rows] = self.grid.texels(number);
            cell.covered >= columns.len() * rows.len()
        };
        !self.cells.is_empty() && self.cells.iter().enumerate().all(is_full)
    }
}
