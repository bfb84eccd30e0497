use super::pieces::place_of;
use super::*;
use egui::vec2;

pub(super) fn piece([x, y]: [usize; 2], size: [usize; 2], gray: u8) -> EncodedTile {
    EncodedTile {
        position: [x, y],
        pixels: Arc::new(ColorImage::filled(size, Color32::from_gray(gray))),
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
                let ImageData::Color(image) = delta.image;
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

/// Texels that were put on cells.
fn covered(canvas: &Canvas) -> usize {
    canvas.cells.iter().map(|cell| cell.covered).sum()
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
    assert_eq!((covered(&canvas), canvas.layers().count()), (15_000, 6));
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
        pixels: Arc::new(ColorImage::filled([513, 17], Color32::from_gray(9))),
        share: vec2(4100.0 / 4104.0, 130.0 / 136.0),
        is_smooth: false,
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
        pixels: Arc::new(ColorImage::new([3000, 2], shades.collect())),
        share: vec2(1.0, 1.0),
        is_smooth: false,
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
        let before = covered(&canvas);
        canvas.flush(&ctx, size);
        assert!(covered(&canvas) > before, "each frame shows something");
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
        pixels: Arc::new(ColorImage::filled([2, 18], Color32::from_gray(9))),
        share: vec2(1.0, 70.0 / 72.0),
        is_smooth: false,
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

/// However many frames the pieces of another look take, what is seen is one look: first coarse, then sharper and sharper.
#[test]
fn another_look_takes_the_place_of_all_there_was_in_one_frame() {
    let (ctx, size) = (egui::Context::default(), [2048, 512]);
    let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
    canvas.put(piece([0, 0], size, 1));
    flush_all(&mut canvas, &ctx, size);
    screen.take(&ctx);
    let looks = |canvas: &Canvas, screen: &Screen| {
        let rows = (0..size[1]).step_by(16);
        let seen = rows.map(|y| screen.texel(canvas, [700, y], size));
        seen.map(|color| color.map(|c| c.r()))
            .collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(looks(&canvas, &screen), [Some(1)].into());
    // Of the look before there are pieces that wait.
    canvas.put(piece([0, 128], [2048, 64], 1));
    canvas.take(Encoded::Coarse(CoarseTexels {
        pixels: Arc::new(ColorImage::filled([1024, 256], Color32::from_gray(2))),
        share: vec2(1.0, 1.0),
        is_smooth: true,
    }));
    for y in (0..size[1]).step_by(64) {
        canvas.take(Encoded::Tile(piece([0, y], [2048, 64], 2)));
    }
    let mut frames = 0;
    while canvas.coarse.is_none() || !canvas.pending.is_empty() {
        canvas.flush(&ctx, size);
        let sent = screen.take(&ctx);
        assert!(sent <= 1 << 18, "{sent} texels in a frame");
        assert_eq!(looks(&canvas, &screen), [Some(2)].into());
        frames += 1;
        if canvas.coarse.is_none() {
            break;
        }
    }
    assert!(frames > 2 && canvas.coarse.is_none() && canvas.is_covered());
}

#[test]
fn another_picture_shows_in_place_of_one_that_is_not_there_yet() {
    let (ctx, size) = (egui::Context::default(), [16, 16]);
    let (mut before, mut screen) = (Canvas::default(), Screen::default());
    let mut canvas = Canvas::default();
    canvas.show_meanwhile(before.as_stand_in());
    assert!(!canvas.is_shown(), "there is nothing to stand in");
    before.put(piece([0, 0], size, 1));
    flush_all(&mut before, &ctx, size);
    canvas.show_meanwhile(before.as_stand_in());
    drop(before);
    canvas.flush(&ctx, size);
    screen.take(&ctx);
    let seen = |canvas: &Canvas, screen: &Screen| screen.texel(canvas, [7, 9], size);
    assert_eq!(seen(&canvas, &screen), Some(Color32::from_gray(1)));
    assert!(canvas.is_covered());
    canvas.put(piece([0, 0], [8, 16], 2));
    canvas.flush(&ctx, size);
    screen.take(&ctx);
    assert_eq!(seen(&canvas, &screen), Some(Color32::from_gray(2)));
    assert!(!canvas.is_covered() && canvas.layers().count() == 1);
}

/// What was there before must go from a cell with the first small piece of the next picture, which is much more than that piece.
#[test]
fn a_frame_has_time_for_few_cells_that_begin() {
    let (ctx, size) = (egui::Context::default(), [1024, 640]);
    let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
    canvas.put(piece([0, 0], size, 1));
    flush_all(&mut canvas, &ctx, size);
    canvas.put_coarse(CoarseTexels {
        pixels: Arc::new(ColorImage::filled([256, 160], Color32::from_gray(9))),
        share: vec2(1.0, 1.0),
        is_smooth: false,
    });
    canvas.flush(&ctx, size);
    screen.take(&ctx);
    for y in (0..size[1]).step_by(64) {
        canvas.put(piece([32, y], [32, 32], 2));
    }
    let mut frames = 0;
    while !canvas.pending.is_empty() {
        canvas.flush(&ctx, size);
        let sent = screen.take(&ctx);
        assert!(sent <= MOST_TEXELS + 1024 * 64 + 32 * 32, "{sent} texels");
        frames += 1;
    }
    assert!(frames >= 5, "in {frames} frames");
    for y in (0..size[1]).step_by(64) {
        let at = |x| screen.texel(&canvas, [x, y], size).map(|color| color.r());
        assert_eq!([31, 32, 63, 64].map(at), [9, 2, 2, 9].map(Some), "row {y}");
    }
}

#[test]
fn whoever_uploads_pixels_is_not_the_last_to_have_them() {
    let (ctx, size) = (egui::Context::default(), [64, 64]);
    let (mut canvas, mut screen) = (Canvas::default(), Screen::default());
    let pieces = [piece([0, 0], [32, 32], 1), piece([40, 40], [8, 8], 2)];
    let mut made: Vec<_> = pieces.iter().map(|p| Arc::downgrade(&p.pixels)).collect();
    let coarse = CoarseTexels {
        pixels: Arc::new(ColorImage::filled([16, 16], Color32::from_gray(9))),
        share: vec2(1.0, 1.0),
        is_smooth: false,
    };
    made.push(Arc::downgrade(&coarse.pixels));
    canvas.put_coarse(coarse);
    for piece in pieces {
        canvas.put(piece);
    }
    // One that is not shown before it is covered.
    let covered = piece([40, 40], [4, 4], 3);
    let unshown = Arc::downgrade(&covered.pixels);
    canvas.put(covered);
    canvas.put(piece([40, 40], [4, 4], 4));
    assert_eq!(unshown.strong_count(), 1);
    made.push(unshown);
    // The driver has dropped what it was handed.
    canvas.flush(&ctx, size);
    screen.take(&ctx);
    assert!(made[..3].iter().all(|image| image.strong_count() > 0));
    flush_all(&mut canvas, &ctx, size);
    screen.take(&ctx);
    canvas.flush(&ctx, size);
    let deadline = Instant::now() + Duration::from_mins(1);
    while made.iter().any(|image| image.strong_count() > 0) {
        assert!(Instant::now() < deadline, "they stay");
        std::thread::sleep(Duration::from_millis(1));
    }
}
