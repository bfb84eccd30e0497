//! A picture on the screen that is filled in piece by piece, over a coarse one where that came first.
//!
//! What goes to the graphics driver costs the window's thread some of the time it has for a frame: each call a little, and each new
//! texture, and each large block of memory on the way there, much. So a picture is cut into cells, each a texture of its own, which is made when
//! the first piece lies in it: bands as wide as the picture, or as a texture may be. Pieces side by side in a cell go there together; and what does
//! not fit into a frame waits for the next.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{
    Color32, ColorImage, ImageData, Painter, Rect, TextureFilter, TextureHandle, TextureId,
    TextureOptions, pos2, vec2,
};

use super::jobs::drop_elsewhere;
use super::picture_buffer::{CoarseTexels, EncodedTile, Grid};

/// Sharp pixels when enlarged, smooth when reduced.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};
/// What a frame may spend on pieces, and how many texels it may hand on: the driver takes its time for each.
const BUDGET: Duration = Duration::from_micros(700);
const MOST_TEXELS: usize = 1 << 17;

/// The textures that show a picture, and what is to go there.
#[derive(Default)]
pub struct Canvas {
    coarse: Option<(TextureHandle, Rect)>,
    new_coarse: Option<CoarseTexels>,
    grid: Grid,
    cells: Vec<Cell>,
    pending: Vec<Waiting>,
    /// What a cell begins with: fresh memory is dear, and most cells are as large as each other.
    blank: Option<Arc<ColorImage>>,
    /// All that was taken in and that somebody may still have: see [`Self::give_back`].
    lent: Vec<Arc<ColorImage>>,
    /// Texels that were put on it, until they are all there are.
    covered: usize,
}

/// A piece that does not show yet.
struct Waiting {
    piece: EncodedTile,
    /// Where it lies, in texels.
    place: Rect,
    /// It goes after those of earlier turns. Pieces of one turn do not overlap: they may go in any order.
    turn: usize,
}

impl Waiting {
    fn new(piece: EncodedTile, turn: usize) -> Self {
        Self {
            place: place_of(&piece),
            piece,
            turn,
        }
    }
}

/// Some columns and rows of a picture.
#[derive(Default)]
struct Cell {
    texture: Option<TextureHandle>,
    /// Whether what the texture shows is of the present picture.
    is_current: bool,
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
    /// Takes in a piece; it shows from [`Self::flush`] on, over all that came before.
    pub fn put(&mut self, piece: EncodedTile) {
        self.lent.push(Arc::clone(&piece.pixels));
        let place = place_of(&piece);
        let mut turn = 0;
        let mut index = 0;
        // Hundreds may come in a frame and find hundreds here: nothing is moved along.
        while let Some(earlier) = self.pending.get(index) {
            if !overlap(place, earlier.place) {
                index += 1;
            } else if place.contains_rect(earlier.place) {
                self.pending.swap_remove(index);
            } else {
                turn = turn.max(earlier.turn + 1);
                index += 1;
            }
        }
        self.pending.push(Waiting { piece, place, turn });
    }

    /// Takes in a coarse picture, which shows from [`Self::flush`] on in place of all that there was.
    pub fn put_coarse(&mut self, texels: CoarseTexels) {
        self.lent.push(Arc::clone(&texels.pixels));
        self.pending.clear();
        self.new_coarse = Some(texels);
    }

    /// Shows what was taken in of a picture of `size` texels, as much as a frame has time for.
    pub fn flush(&mut self, ctx: &egui::Context, size: [usize; 2]) {
        self.give_back();
        let largest_texture = ctx.input(|input| input.max_texture_side);
        if let Some(coarse) = self.new_coarse.take() {
            self.show_coarse(ctx, coarse.within(largest_texture));
        }
        if self.pending.is_empty() {
            return;
        }
        let grid = Grid::of(size, largest_texture);
        if self.grid != grid {
            self.grid = grid;
            self.covered = 0;
            self.cells.clear();
            self.cells.resize_with(grid.count(), Cell::default);
        }
        let started = Instant::now();
        let mut runs = joined(std::mem::take(&mut self.pending), grid).into_iter();
        let mut texels = 0;
        for run in runs.by_ref() {
            texels += self.show(ctx, run.piece);
            if texels >= MOST_TEXELS || started.elapsed() > BUDGET {
                break;
            }
        }
        self.pending = runs.collect();
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

    fn show_coarse(&mut self, ctx: &egui::Context, CoarseTexels { pixels, share }: CoarseTexels) {
        self.covered = 0;
        for cell in &mut self.cells {
            cell.is_current = false;
        }
        let part = Rect::from_min_max(pos2(0.0, 0.0), share.to_pos2());
        if let Some((texture, shown)) = &mut self.coarse {
            texture.set(pixels, OPTIONS);
            *shown = part;
        } else {
            let texture = ctx.load_texture("coarse picture", pixels, OPTIONS);
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
        let [width, height] = self.grid.size();
        self.covered = (self.covered + pixels.pixels.len()).min(width * height);
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
        let coarse = self.coarse.as_ref().map(|(texture, part)| CanvasLayer {
            texture: texture.id(),
            place: WHOLE,
            part: *part,
        });
        let [width, height] = self.grid.size().map(|side| side.max(1) as f32);
        let cells = self.cells.iter().enumerate();
        let cells = cells.filter_map(move |(number, cell)| {
            let texture = cell.texture.as_ref().filter(|_| cell.is_current)?;
            let [columns, rows] = self.grid.texels(number);
            let corner = |x: usize, y: usize| pos2(x as f32 / width, y as f32 / height);
            Some(CanvasLayer {
                texture: texture.id(),
                place: Rect::from_min_max(
                    corner(columns.start, rows.start),
                    corner(columns.end, rows.end),
                ),
                part: WHOLE,
            })
        });
        coarse.into_iter().chain(cells)
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
        self.coarse.is_some() || self.is_filled()
    }

    fn is_filled(&self) -> bool {
        let [width, height] = self.grid.size();
        !self.cells.is_empty() && self.covered >= width * height
    }
}

/// Whether two places have more than an edge in common.
fn overlap(a: Rect, b: Rect) -> bool {
    a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y
}

/// Where a piece lies, in texels.
fn place_of(piece: &EncodedTile) -> Rect {
    let [x, y] = piece.position.map(|side| side as f32);
    let [width, height] = piece.pixels.size.map(|side| side as f32);
    Rect::from_min_size(pos2(x, y), vec2(width, height))
}

/// The pieces in the order in which they go, each in one cell: cut where they are not, and those of one turn that lie side by side joined.
fn joined(pieces: Vec<Waiting>, grid: Grid) -> Vec<Waiting> {
    let cut = |Waiting { piece, turn, .. }| {
        let parts = grid.cut(piece).into_iter();
        parts.map(move |part| Waiting::new(part, turn))
    };
    let mut pieces: Vec<Waiting> = pieces.into_iter().flat_map(cut).collect();
    pieces.sort_by_key(|Waiting { piece, turn, .. }| {
        let [x, y] = piece.position;
        (*turn, y, piece.pixels.size[1], x)
    });
    let mut runs: Vec<Vec<Waiting>> = Vec::new();
    for piece in pieces {
        match runs.last_mut() {
            Some(run) if run.last().is_some_and(|last| continues(last, &piece, grid)) => {
                run.push(piece);
            }
            _ => runs.push(vec![piece]),
        }
    }
    runs.into_iter().map(side_by_side).collect()
}

/// Whether `next` lies beside `last` in its cell, as high as that, and goes with it.
fn continues(last: &Waiting, next: &Waiting, grid: Grid) -> bool {
    let [x, y] = last.piece.position;
    let [width, height] = last.piece.pixels.size;
    let is_beside = next.piece.position == [x + width, y]
        && grid.cell_at(next.piece.position) == grid.cell_at([x, y]);
    next.turn == last.turn && is_beside && next.piece.pixels.size[1] == height
}

/// The pieces of a run as one.
fn side_by_side(mut run: Vec<Waiting>) -> Waiting {
    if run.len() == 1 {
        return run.swap_remove(0);
    }
    let height = run[0].piece.pixels.size[1];
    let width = run.iter().map(|next| next.piece.pixels.size[0]).sum();
    let mut texels = Vec::with_capacity(width * height);
    for row in 0..height {
        for pixels in run.iter().map(|next| &next.piece.pixels) {
            let columns = pixels.size[0];
            texels.extend_from_slice(&pixels.pixels[row * columns..][..columns]);
        }
    }
    let piece = EncodedTile {
        position: run[0].piece.position,
        pixels: Arc::new(ColorImage::new([width, height], texels)),
    };
    Waiting::new(piece, run[0].turn)
}

#[cfg(test)]
mod tests;
