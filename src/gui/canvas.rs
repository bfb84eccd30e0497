//! A picture on the screen that is filled in piece by piece, over a coarse one where that came first.
//!
//! What goes to the graphics driver costs the window's thread some of the time it has for a frame: each call a little, and each new
//! texture, and each large block of memory on the way there, much. So a picture is cut into bands, each a texture of its own, which is made when
//! the first piece lies in it; pieces side by side go there together; and what does not fit into a frame waits for the next.

use std::time::{Duration, Instant};

use egui::{
    Color32, ColorImage, Painter, Rect, TextureFilter, TextureHandle, TextureId, TextureOptions,
    pos2, vec2,
};

use super::picture_buffer::{CoarseTexels, EncodedTile};

/// Sharp pixels when enlarged, smooth when reduced.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};
/// Rows of a band, in texels.
const BAND: usize = 64;
/// What a frame may spend on pieces, and how many texels it may hand on: the driver takes its time for each.
const BUDGET: Duration = Duration::from_micros(700);
const MOST_TEXELS: usize = 1 << 17;

/// The textures that show a picture, and what is to go there.
#[derive(Default)]
pub struct Canvas {
    coarse: Option<(TextureHandle, Rect)>,
    new_coarse: Option<CoarseTexels>,
    /// Width and height in texels.
    size: [usize; 2],
    bands: Vec<Band>,
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

/// Some rows of a picture.
#[derive(Default)]
struct Band {
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

    /// Shows what was taken in, on textures of `size` texels, as much as a frame has time for.
    pub fn flush(&mut self, ctx: &egui::Context, size: [usize; 2]) {
        if let Some(coarse) = self.new_coarse.take() {
            self.show_coarse(ctx, coarse);
        }
        if self.pending.is_empty() {
            return;
        }
        if self.size != size {
            self.size = size;
            self.covered = 0;
            self.bands.clear();
            self.bands
                .resize_with(size[1].div_ceil(BAND), Band::default);
        }
        let started = Instant::now();
        let mut runs = joined(std::mem::take(&mut self.pending)).into_iter();
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
        for band in &mut self.bands {
            band.is_current = false;
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

    /// Puts a piece on the bands that it lies in.
    fn show(&mut self, ctx: &egui::Context, EncodedTile { position, pixels }: EncodedTile) {
        let [x, top] = position;
        let [columns, rows] = pixels.size;
        let whole = self.size[0] * self.size[1];
        self.covered = (self.covered + columns * rows).min(whole);
        let mut texels = Some(pixels);
        for number in top / BAND..(top + rows).div_ceil(BAND) {
            let first = number * BAND;
            let height = BAND.min(self.size[1] - first);
            let inside = top.max(first)..(top + rows).min(first + height);
            let part = if inside.len() == rows {
                texels.take().expect("it lies in one band")
            } else {
                let whole = texels.as_ref().expect("it lies in several bands");
                rows_of(whole, inside.start - top..inside.end - top)
            };
            let band = &mut self.bands[number];
            let is_all = part.size == [self.size[0], height];
            match &mut band.texture {
                Some(texture) if is_all => texture.set(part, OPTIONS),
                Some(texture) => {
                    if !band.is_current {
                        texture.set(clear([self.size[0], height]), OPTIONS);
                    }
                    texture.set_partial([x, inside.start - first], part, OPTIONS);
                }
                place @ None => {
                    let load = |image| ctx.load_texture("picture", image, OPTIONS);
                    let texture = if is_all {
                        load(part)
                    } else {
                        let mut texture = load(clear([self.size[0], height]));
                        texture.set_partial([x, inside.start - first], part, OPTIONS);
                        texture
                    };
                    *place = Some(texture);
                }
            }
            band.is_current = true;
        }
    }

    /// All there is to show, each over the one before.
    pub fn layers(&self) -> impl Iterator<Item = CanvasLayer> {
        let coarse = self.coarse.as_ref().map(|(texture, part)| CanvasLayer {
            texture: texture.id(),
            place: WHOLE,
            part: *part,
        });
        let rows = self.size[1].max(1) as f32;
        let bands = self
            .bands
            .iter()
            .enumerate()
            .filter_map(move |(number, band)| {
                let texture = band.texture.as_ref().filter(|_| band.is_current)?;
                let edge = |number: usize| (number * BAND) as f32 / rows;
                Some(CanvasLayer {
                    texture: texture.id(),
                    place: Rect::from_min_max(
                        pos2(0.0, edge(number)),
                        pos2(1.0, edge(number + 1).min(1.0)),
                    ),
                    part: WHOLE,
                })
            });
        coarse.into_iter().chain(bands)
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
        let [width, height] = self.size;
        !self.bands.is_empty() && self.covered >= width * height
    }
}

fn clear(size: [usize; 2]) -> ColorImage {
    ColorImage::filled(size, Color32::TRANSPARENT)
}

/// Some rows of an image.
fn rows_of(image: &ColorImage, rows: std::ops::Range<usize>) -> ColorImage {
    let width = image.size[0];
    let texels = image.pixels[rows.start * width..rows.end * width].to_vec();
    ColorImage::new([width, rows.len()], texels)
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

/// The pieces in the order in which they go, those of one turn that lie side by side joined.
fn joined(mut pieces: Vec<Waiting>) -> Vec<Waiting> {
    pieces.sort_by_key(|Waiting { piece, turn, .. }| {
        let [x, y] = piece.position;
        (*turn, y, piece.pixels.size[1], x)
    });
    let mut runs: Vec<Vec<Waiting>> = Vec::new();
    for piece in pieces {
        match runs.last_mut() {
            Some(run) if run.last().is_some_and(|last| continues(last, &piece)) => run.push(piece),
            _ => runs.push(vec![piece]),
        }
    }
    runs.into_iter().map(side_by_side).collect()
}

/// Whether `next` lies beside `last`, as high as that, and goes with it.
fn continues(last: &Waiting, next: &Waiting) -> bool {
    let [x, y] = last.piece.position;
    let [width, height] = last.piece.pixels.size;
    let is_beside = next.piece.position == [x + width, y];
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
    Waiting {
        place: place_of(&piece),
        turn: run[0].turn,
        piece,
    }
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
        let runs = joined(canvas.pending).into_iter().map(|run| run.piece);
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
        let runs = joined(canvas.pending);
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
