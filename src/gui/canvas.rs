//! A picture on the screen that is filled in piece by piece, over a coarse one where that came first.
//!
//! What goes to the graphics driver costs the window's thread some of the time it has for a frame: each call a little, and each new
//! texture, and each large block of memory on the way there, much. So a picture is cut into cells, each a texture of its own, which is made when
//! the first piece lies in it: bands as wide as the picture, or as a texture may be. Pieces side by side in a cell go there together; and what does
//! not fit into a frame waits for the next.

use std::time::{Duration, Instant};

use egui::{
    Color32, ColorImage, Painter, Rect, TextureFilter, TextureHandle, TextureId, TextureOptions,
    pos2, vec2,
};

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
        self.pending.clear();
        self.new_coarse = Some(texels);
    }

    /// Shows what was taken in of a picture of `size` texels, as much as a frame has time for.
    pub fn flush(&mut self, ctx: &egui::Context, size: [usize; 2]) {
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
            texels += run.piece.pixels.pixels.len();
            self.show(ctx, run.piece);
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

    /// Puts a piece on the cell that it lies in.
    fn show(&mut self, ctx: &egui::Context, EncodedTile { position, pixels }: EncodedTile) {
        let [width, height] = self.grid.size();
        self.covered = (self.covered + pixels.pixels.len()).min(width * height);
        let number = self.grid.cell_at(position);
        let [columns, rows] = self.grid.texels(number);
        let size = [columns.len(), rows.len()];
        let at = [position[0] - columns.start, position[1] - rows.start];
        let is_all = pixels.size == size;
        let cell = &mut self.cells[number];
        match &mut cell.texture {
            Some(texture) if is_all => texture.set(pixels, OPTIONS),
            Some(texture) => {
                if !cell.is_current {
                    texture.set(clear(size), OPTIONS);
                }
                texture.set_partial(at, pixels, OPTIONS);
            }
            place @ None => {
                let load = |image| ctx.load_texture("picture", image, OPTIONS);
                let texture = if is_all {
                    load(pixels)
                } else {
                    let mut texture = load(clear(size));
                    texture.set_partial(at, pixels, OPTIONS);
                    texture
                };
                *place = Some(texture);
            }
        }
        cell.is_current = true;
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

fn clear(size: [usize; 2]) -> ColorImage {
    ColorImage::filled(size, Color32::TRANSPARENT)
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
        pixels: ColorImage::new([width, height], texels),
    };
    Waiting::new(piece, run[0].turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece([x, y]: [usize; 2], size: [usize; 2], gray: u8) -> EncodedTile {
        EncodedTile {
            position: [x, y],
            pixels: ColorImage::filled(size, Color32::from_gray(gray)),
        }
    }

    /// What the textures of `canvas` show, by a look at all that was sent there.
    #[derive(Default)]
    struct Screen(std::collections::HashMap<TextureId, ColorImage>);

    impl Screen {
        /// Takes in what was sent; returns the number of texels.
        fn take(&mut self, ctx: &egui::Context) -> usize {
            let mut delta = ctx.tex_manager().write().take_delta();
            let mut sent = 0;
            for (id, deltas) in std::mem::take(&mut delta.set) {
                for delta in deltas {
                    let egui::ImageData::Color(image) = delta.image;
                    sent += image.pixels.len();
                    let Some([x, y]) = delta.pos else {
                        self.0.insert(id, (*image).clone());
                        continue;
                    };
                    let Some(whole) = self.0.get_mut(&id) else {
                        continue;
                    };
                    for row in 0..image.size[1] {
                        for column in 0..image.size[0] {
                            whole[(x + column, y + row)] = image[(column, row)];
                        }
                    }
                }
            }
            for id in std::mem::take(&mut delta.free) {
                self.0.remove(&id);
            }
            sent
        }

        /// The texel at the middle of a pixel of a picture of `size`.
        fn texel(&self, canvas: &Canvas, [x, y]: [usize; 2], size: [usize; 2]) -> Option<Color32> {
            let at = pos2(
                (x as f32 + 0.5) / size[0] as f32,
                (y as f32 + 0.5) / size[1] as f32,
            );
            let seen = canvas.layers().filter(|layer| layer.place.contains(at));
            let colors = seen.filter_map(|layer| {
                let image = self.0.get(&layer.texture)?;
                let share = (at - layer.place.min) / layer.place.size();
                let within = layer.part.min + share * layer.part.size();
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "within the image"
                )]
                let index = |share: f32, count: usize| (share * count as f32) as usize;
                let [columns, rows] = image.size;
                Some(image[(index(within.x, columns), index(within.y, rows))])
                    .filter(|color| *color != Color32::TRANSPARENT)
            });
            colors.last()
        }
    }

    fn flush_all(canvas: &mut Canvas, ctx: &egui::Context, size: [usize; 2]) {
        loop {
            canvas.flush(ctx, size);
            if canvas.pending.is_empty() {
                return;
            }
        }
    }

    #[test]
    fn pieces_side_by_side_are_joined_and_the_last_at_a_place_counts() {
        let mut canvas = Canvas::default();
        for piece in [
            piece([4, 2], [2, 2], 1),
            piece([0, 0], [2, 2], 2),
            piece([2, 2], [2, 2], 3),
            piece([2, 0], [2, 1], 4),
            piece([2, 2], [2, 2], 5),
            piece([8, 2], [2, 2], 6),
        ] {
            canvas.put(piece);
        }
        let runs = joined(canvas.pending, Grid::of([10, 4], 2048));
        let runs = runs.into_iter().map(|run| run.piece);
        let runs: Vec<_> = runs.collect();
        let places: Vec<_> = runs.iter().map(|r| (r.position, r.pixels.size)).collect();
        let expected = [
            ([2, 0], [2, 1]),
            ([0, 0], [2, 2]),
            ([2, 2], [4, 2]),
            ([8, 2], [2, 2]),
        ];
        assert_eq!(places, expected);
        assert_eq!(runs[2].pixels[(0, 1)], Color32::from_gray(5));
        assert_eq!(runs[2].pixels[(2, 0)], Color32::from_gray(1));
    }

    #[test]
    fn of_pieces_that_overlap_the_last_shows_whatever_their_heights() {
        let size = [96, 128];
        // Bands, and tiles of half their height: over a band, below one, and across the edge of one.
        let pieces = [
            piece([0, 0], [96, 64], 1),
            piece([32, 0], [32, 32], 2),
            piece([64, 32], [32, 32], 3),
            piece([0, 64], [32, 32], 4),
            piece([0, 48], [32, 32], 5),
            piece([0, 64], [96, 64], 6),
            piece([64, 48], [32, 32], 7),
            piece([80, 40], [16, 16], 8),
        ];
        for last in 1..=pieces.len() {
            let ctx = egui::Context::default();
            let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
            let pieces = &pieces[..last];
            for piece in pieces {
                canvas.put(piece.clone());
            }
            flush_all(&mut canvas, &ctx, size);
            screen.take(&ctx);
            for [x, y] in (0..96).flat_map(|x| (0..128).map(move |y| [x, y])) {
                let place = pos2(x as f32 + 0.5, y as f32 + 0.5);
                let mut over = pieces.iter().rev();
                let expected = over.find(|piece| place_of(piece).contains(place));
                assert_eq!(
                    screen.texel(&canvas, [x, y], size),
                    expected.map(|piece| piece.pixels.pixels[0]),
                    "at {x}, {y} after {last} pieces"
                );
            }
        }
    }

    #[test]
    fn tiles_that_come_in_any_order_go_to_the_driver_in_rows() {
        let mut canvas = Canvas::default();
        for x in [2, 0, 3, 1] {
            for y in [1, 0] {
                canvas.put(piece([32 * x, 32 * y], [32, 32], 1));
            }
        }
        // Those of the next pass take the place of those that do not show yet.
        canvas.put(piece([32, 32], [32, 32], 2));
        let runs = joined(canvas.pending, Grid::of([128, 64], 2048));
        let sizes: Vec<_> = runs.iter().map(|run| run.piece.pixels.size).collect();
        assert_eq!(sizes, [[128, 32]; 2]);
        let row = &runs[1].piece.pixels;
        assert_eq!([31, 32].map(|x| row[(x, 0)].r()), [1, 2]);
    }

    #[test]
    fn pieces_show_where_they_belong_across_the_edges_of_bands() {
        let (ctx, size) = (egui::Context::default(), [50, 150]);
        let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
        canvas.flush(&ctx, size);
        assert!(!canvas.is_shown() && !canvas.is_covered());
        canvas.put(piece([3, 60], [20, 80], 7));
        canvas.put(piece([23, 60], [20, 80], 8));
        flush_all(&mut canvas, &ctx, size);
        screen.take(&ctx);
        let at = |place| screen.texel(&canvas, place, size);
        for row in [60, 63, 64, 127, 128, 139] {
            assert_eq!(at([3, row]), Some(Color32::from_gray(7)), "row {row}");
            assert_eq!(at([42, row]), Some(Color32::from_gray(8)), "row {row}");
            assert_eq!((at([2, row]), at([43, row])), (None, None));
        }
        assert_eq!((at([10, 59]), at([10, 140])), (None, None));
        assert!(!canvas.is_covered());
        canvas.put(piece([0, 0], size, 9));
        flush_all(&mut canvas, &ctx, size);
        assert!(canvas.is_covered());
        screen.take(&ctx);
        assert_eq!(
            screen.texel(&canvas, [49, 149], size),
            Some(Color32::from_gray(9))
        );
    }

    #[test]
    fn pieces_show_where_they_belong_across_the_edges_of_columns() {
        let (ctx, size) = (egui::Context::default(), [4100, 130]);
        let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
        // Three columns, the last a texel narrower, of three bands; the piece lies in six of these.
        let edges = [1367, 2734];
        canvas.put(piece([1300, 60], [1500, 10], 7));
        flush_all(&mut canvas, &ctx, size);
        screen.take(&ctx);
        assert_eq!((canvas.covered, canvas.layers().count()), (15_000, 6));
        let at = |place| screen.texel(&canvas, place, size);
        for column in [1300, edges[0] - 1, edges[0], edges[1] - 1, edges[1], 2799] {
            for row in [60, 63, 64, 69] {
                let color = at([column, row]);
                assert_eq!(color, Some(Color32::from_gray(7)), "{column}, {row}");
            }
            assert_eq!((at([column, 59]), at([column, 70])), (None, None));
        }
        assert_eq!((at([1299, 65]), at([2800, 65])), (None, None));

        // A coarse picture takes its place, and another piece lies over that.
        canvas.put_coarse(CoarseTexels {
            pixels: ColorImage::filled([513, 17], Color32::from_gray(9)),
            share: vec2(4100.0 / 4104.0, 130.0 / 136.0),
        });
        canvas.put(piece([2730, 100], [8, 30], 8));
        flush_all(&mut canvas, &ctx, size);
        screen.take(&ctx);
        assert!(canvas.is_covered());
        let at = |place| screen.texel(&canvas, place, size);
        for place in [[0, 0], [1400, 65], [2729, 110], [2738, 110], [4099, 129]] {
            assert_eq!(at(place), Some(Color32::from_gray(9)), "{place:?}");
        }
        for place in [[2730, 100], [2733, 129], [2734, 127], [2737, 128]] {
            assert_eq!(at(place), Some(Color32::from_gray(8)), "{place:?}");
        }

        // A piece as large as the picture covers all of it at once.
        canvas.put(piece([0, 0], size, 10));
        flush_all(&mut canvas, &ctx, size);
        screen.take(&ctx);
        assert!(canvas.coarse.is_none() && canvas.is_covered());
        assert_eq!(canvas.layers().count(), 9);
        let at = |place| screen.texel(&canvas, place, size);
        for place in [[0, 0], [1366, 63], [1367, 64], [4099, 129]] {
            assert_eq!(at(place), Some(Color32::from_gray(10)), "{place:?}");
        }
    }

    #[test]
    fn tiles_are_joined_up_to_the_edge_of_a_column() {
        let mut canvas = Canvas::default();
        for x in [64, 0, 96, 32] {
            canvas.put(piece([x, 0], [32, 32], 1));
        }
        // Two columns of 70 and 69 texels.
        let runs = joined(canvas.pending, Grid::of([139, 40], 100));
        let runs = runs.into_iter().map(|run| run.piece);
        let places: Vec<_> = runs.map(|run| (run.position, run.pixels.size)).collect();
        assert_eq!(places, [([0, 0], [70, 32]), ([70, 0], [58, 32])]);
    }

    #[test]
    fn a_piece_wider_than_a_frame_has_time_for_is_shown_over_several() {
        let (ctx, size) = (egui::Context::default(), [8192, 64]);
        let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
        canvas.put(piece([0, 0], size, 1));
        for waiting in (0..4).rev() {
            canvas.flush(&ctx, size);
            assert_eq!(screen.take(&ctx), 2048 * 64);
            assert_eq!(canvas.pending.len(), waiting);
        }
        assert!(canvas.is_covered());
        // All of a cell takes the place of its texture.
        canvas.put(piece([2048, 0], [2048, 64], 2));
        canvas.flush(&ctx, size);
        assert_eq!(screen.take(&ctx), 2048 * 64);
        assert_eq!(canvas.layers().count(), 4);
        let at = |x| screen.texel(&canvas, [x, 3], size).map(|color| color.r());
        assert_eq!([2047, 2048, 4095, 4096].map(at), [1, 2, 2, 1].map(Some));
    }

    #[test]
    fn a_coarse_picture_larger_than_a_texture_is_shown_as_one_that_fits() {
        let (ctx, size) = (egui::Context::default(), [12_000, 8]);
        let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
        let shades = (0..6000).map(|index| Color32::from_gray(if index < 3000 { 1 } else { 2 }));
        canvas.put_coarse(CoarseTexels {
            pixels: ColorImage::new([3000, 2], shades.collect()),
            share: vec2(1.0, 1.0),
        });
        canvas.flush(&ctx, size);
        assert_eq!(screen.take(&ctx), 1500);
        assert!(canvas.is_covered());
        let color = screen.texel(&canvas, [11_999, 7], size);
        assert_eq!(color, Some(Color32::from_gray(1)));
    }

    #[test]
    fn what_a_frame_has_no_time_for_waits_for_the_next() {
        let (ctx, size) = (egui::Context::default(), [2048, 8192]);
        let mut canvas = Canvas::default();
        for y in (0..size[1]).step_by(64) {
            canvas.put(piece([0, y], [size[0], 64], 1));
        }
        let mut frames = 0;
        while !canvas.is_covered() {
            let before = canvas.covered;
            canvas.flush(&ctx, size);
            assert!(canvas.covered > before, "each frame shows something");
            frames += 1;
        }
        assert!(frames > 1 && canvas.pending.is_empty());
    }

    #[test]
    fn a_coarse_picture_takes_the_place_of_what_was_there_until_pieces_cover_it() {
        let (ctx, size) = (egui::Context::default(), [8, 70]);
        let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
        canvas.put(piece([0, 0], size, 200));
        flush_all(&mut canvas, &ctx, size);
        canvas.put(piece([0, 0], size, 201));
        canvas.put_coarse(CoarseTexels {
            pixels: ColorImage::filled([2, 18], Color32::from_gray(9)),
            share: vec2(1.0, 70.0 / 72.0),
        });
        canvas.flush(&ctx, size);
        screen.take(&ctx);
        assert!(canvas.is_covered());
        for place in [[0, 0], [7, 69]] {
            assert_eq!(
                screen.texel(&canvas, place, size),
                Some(Color32::from_gray(9))
            );
        }
        canvas.put(piece([2, 2], [1, 1], 50));
        flush_all(&mut canvas, &ctx, size);
        screen.take(&ctx);
        let at = |place| screen.texel(&canvas, place, size);
        assert_eq!(at([2, 2]), Some(Color32::from_gray(50)));
        assert_eq!(at([3, 2]), Some(Color32::from_gray(9)), "nothing of before");
        canvas.put(piece([0, 0], size, 51));
        flush_all(&mut canvas, &ctx, size);
        assert!(canvas.coarse.is_none() && canvas.is_covered());
    }
}
