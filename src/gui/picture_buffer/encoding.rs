//! All of a picture in another look: a coarse picture of the whole at once, then its pieces.

use std::sync::Arc;

use egui::{ColorImage, Vec2};

use super::{CoarseTexels, Encoded, PictureBuffer};
use crate::control::CancelToken;
use crate::gui::look::Look;

/// Most texels of the coarse picture: what is made and handed to the graphics driver within a frame. It is exact where the picture has no
/// more, and nearly as sharp as the screen where all of the picture is seen.
const MOST_COARSE: u64 = 1 << 18;

/// What is on the screen of a picture, and how.
#[derive(Clone, Copy, Debug)]
struct Shown {
    plane: usize,
    look: Look,
    /// It is that until the buffer's state has changed more often.
    changes: u64,
}

impl PictureBuffer {
    /// Encodes the whole picture anew: first all of it, coarse, then piece by piece. All of that is one look: it ends where another one is
    /// asked for meanwhile.
    pub fn encode_all(&self, cancel: &CancelToken, mut show: impl FnMut(Encoded)) {
        let shown = {
            let state = self.lock();
            Shown {
                plane: state.shown,
                look: state.look_on_screen(self.layer(state.shown)),
                changes: state.changes,
            }
        };
        let Some(coarse) = self.coarse(shown) else {
            return;
        };
        show(Encoded::Coarse(coarse));
        for [columns, rows] in self.texels.pieces() {
            if cancel.is_cancelled() {
                return;
            }
            let (width, step) = (columns.len(), self.step());
            let mut piece = Vec::with_capacity(width * rows.len().div_ceil(step as usize));
            let is_read = self.read_rows(shown, rows.clone().step_by(step as usize), |row| {
                piece.extend_from_slice(&row[columns.start as usize..columns.end as usize]);
            });
            if is_read.is_none() {
                return;
            }
            let encode = |x: u32, y: u32| {
                let row = ((y - rows.start) / step) as usize;
                let pixel = piece[row * width + (x - columns.start) as usize];
                shown.look.color(pixel)
            };
            let tile = self.texels.encode(columns.clone(), rows.clone(), encode);
            if let Some(tile) = tile {
                show(Encoded::Tile(tile));
            }
        }
    }

    /// Hands on some rows of pixels of what is shown; `None` where that is something else by now.
    fn read_rows(
        &self,
        shown: Shown,
        rows: impl Iterator<Item = u32>,
        mut take: impl FnMut(&[[f32; 3]]),
    ) -> Option<()> {
        let mut state = self.lock();
        if state.changes != shown.changes {
            return None;
        }
        let image = &state.planes()[shown.plane];
        let width = self.width as usize;
        for y in rows {
            take(&image.pixels[y as usize * width..][..width]);
        }
        Some(())
    }

    /// The whole, by a pixel from the middle of each of so many blocks; `None` where something else is shown by now.
    fn coarse(&self, shown: Shown) -> Option<CoarseTexels> {
        let size = [self.width, self.height];
        let blocks = |side: u32| size.map(|pixels| pixels.div_ceil(side));
        let count = |side: u32| blocks(side).map(u64::from).iter().product::<u64>();
        let side = (self.step()..=u32::MAX).find(|&side| count(side) <= MOST_COARSE)?;
        let [columns, rows] = blocks(side);
        let middle = |block: u32, pixels: u32| (block * side + side / 2).min(pixels - 1);
        let mut colors = Vec::with_capacity(columns as usize * rows as usize);
        let mut picked = Vec::with_capacity(columns as usize);
        for row in 0..rows {
            // The window may want the picture in between.
            self.read_rows(shown, std::iter::once(middle(row, self.height)), |pixels| {
                picked.clear();
                let middles = (0..columns).map(|column| middle(column, self.width));
                picked.extend(middles.map(|x| pixels[x as usize]));
            })?;
            colors.extend(picked.iter().map(|&rgb| shown.look.color(rgb)));
        }
        let share = |pixels: u32, blocks: u32| pixels as f32 / (blocks as f32 * side as f32);
        Some(CoarseTexels {
            pixels: Arc::new(ColorImage::new(
                [columns, rows].map(|side| side as usize),
                colors,
            )),
            share: Vec2::new(share(self.width, columns), share(self.height, rows)),
            is_smooth: side > 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::part::Part;
    use crate::gui::picture_buffer::EncodedTile;
    use crate::render::{Image, Layer, Region, TilePixels};
    use crate::scene::Display;
    use egui::Color32;

    /// A picture that is filled with the given pixels.
    fn filled(size: [u32; 2], pixel: impl Fn(usize) -> [f32; 3]) -> PictureBuffer {
        let part = Part::whole(size);
        let buffer = PictureBuffer::new(part, Vec::new(), Display::default()).unwrap();
        let region = Region::full(size[0], size[1]);
        let rgb: Vec<_> = (0..region.pixel_count()).map(pixel).collect();
        let whole = TilePixels {
            region,
            rgb: &rgb,
            layers: &[],
        };
        assert!(buffer.accept(&whole).is_some());
        buffer
    }

    /// The coarse picture, and the pieces.
    fn encoded(buffer: &PictureBuffer) -> (CoarseTexels, Vec<EncodedTile>) {
        let (mut coarse, mut pieces) = (None, Vec::new());
        buffer.encode_all(&CancelToken::new(), |encoded| match encoded {
            Encoded::Coarse(texels) => {
                assert!(pieces.is_empty() && coarse.is_none(), "it comes first");
                coarse = Some(texels);
            }
            Encoded::Tile(piece) => pieces.push(piece),
        });
        (coarse.unwrap(), pieces)
    }

    #[test]
    fn a_picture_wider_than_a_texture_is_encoded_pixel_by_pixel() {
        let pixel = |index: usize| [(index % 251) as f32 / 251.0; 3];
        let buffer = filled([5000, 70], pixel);
        assert_eq!(buffer.step(), 1);
        assert_eq!(buffer.size_in_texels(), [5000, 70]);
        let mut shown = ColorImage::filled([5000, 70], Color32::TRANSPARENT);
        let (_, pieces) = encoded(&buffer);
        assert_eq!(pieces.len(), 4);
        for EncodedTile { position, pixels } in pieces {
            let [left, top] = position;
            for (x, y) in
                (0..pixels.width()).flat_map(|x| (0..pixels.height()).map(move |y| (x, y)))
            {
                shown[(left + x, top + y)] = pixels[(x, y)];
            }
        }
        let look = Look::Light(Display::default(), crate::gui::look::Channels::All);
        let expected: Vec<_> = (0..350_000).map(|index| look.color(pixel(index))).collect();
        assert!(shown.pixels == expected);
        assert_ne!(shown[(0, 0)], shown[(1, 0)]);
    }

    #[test]
    fn encoding_anew_shows_the_new_exposure_everywhere() {
        let buffer = filled([33, 150], |_| [0.25; 3]);
        buffer.set_display(Display {
            exposure: 2.0,
            ..Display::default()
        });
        let (coarse, pieces) = encoded(&buffer);
        let is_white = |pixels: &ColorImage| pixels.pixels.iter().all(|&p| p == Color32::WHITE);
        assert!(is_white(&coarse.pixels) && pieces.iter().all(|piece| is_white(&piece.pixels)));
        let rows: usize = pieces.iter().map(|piece| piece.pixels.height()).sum();
        assert_eq!(rows, 150);
    }

    /// The coarse picture of a small one is that itself, and each block of that of a large one lies where its pixel does.
    #[test]
    fn the_coarse_picture_has_every_part_in_its_place() {
        let small = filled([320, 200], |index| [(index % 7) as f32 / 7.0; 3]);
        let (coarse, pieces) = encoded(&small);
        assert_eq!(
            (coarse.pixels.size, coarse.share),
            ([320, 200], Vec2::splat(1.0))
        );
        assert!(!coarse.is_smooth);
        assert_eq!(coarse.pixels[(5, 3)], pieces[0].pixels[(5, 3)]);

        // Brighter from left to right; 1 % is less than a step of eight bits anywhere.
        let size = [3841_u32, 2161];
        let shade = |index: usize| [(index % 3841) as f32 / 3841.0; 3];
        let large = filled(size, shade);
        let (coarse, _) = encoded(&large);
        let [columns, rows] = coarse.pixels.size;
        assert!(columns * rows <= 1 << 18 && columns * rows > 1 << 16);
        assert!(coarse.is_smooth);
        let look = Look::Light(Display::default(), crate::gui::look::Channels::All);
        for column in [0, columns / 3, columns - 1] {
            let x = (column as f32 + 0.5) / (columns as f32 * coarse.share.x);
            let expected = look.color([x.min(1.0); 3]);
            let found = coarse.pixels[(column, rows / 2)];
            let apart = found.r().abs_diff(expected.r());
            assert!(apart <= 4, "{column}: {found:?}, {expected:?}");
        }
    }

    /// An error that nobody looks at changes nothing of what is seen.
    #[test]
    fn encoding_goes_on_while_what_is_not_seen_changes() {
        let part = Part::whole([64, 640]);
        let layers = vec![Layer::Error];
        let buffer = PictureBuffer::new(part, layers, Display::default()).unwrap();
        let pieces_with = |shown: Option<Layer>| {
            buffer.set_shown(shown);
            let mut pieces = 0;
            buffer.encode_all(&CancelToken::new(), |encoded| {
                if let Encoded::Tile(_) = encoded {
                    pieces += 1;
                    buffer.set_error(Image::black(64, 640));
                }
            });
            pieces
        };
        assert_eq!(pieces_with(None), 10);
        assert_eq!(pieces_with(Some(Layer::Error)), 1);
    }

    /// Pieces of another look than the coarse picture would be two looks at once.
    #[test]
    fn encoding_ends_where_another_look_is_asked_for() {
        let buffer = filled([64, 640], |_| [0.25; 3]);
        let mut pieces = 0;
        buffer.encode_all(&CancelToken::new(), |encoded| {
            if let Encoded::Tile(_) = encoded {
                pieces += 1;
            }
            // The same again is no other look.
            buffer.set_shown(None);
            buffer.set_display(Display {
                exposure: if pieces < 3 { 0.0 } else { 1.0 },
                ..Display::default()
            });
        });
        assert_eq!(pieces, 3);
    }
}
