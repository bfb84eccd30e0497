//! Pieces of a picture on their way to the screen: in which order, and which of them together.

use std::ops::ControlFlow;
use std::sync::Arc;

use egui::{ColorImage, Rect, pos2, vec2};

use crate::gui::picture_buffer::{EncodedTile, Grid};

/// Pieces that do not show yet.
#[derive(Default)]
pub(super) struct Queue(Vec<Waiting>);

impl Queue {
    /// Takes in a piece, which goes after all that lie where it does.
    pub fn put(&mut self, piece: EncodedTile) {
        let place = place_of(&piece);
        let mut turn = 0;
        let mut index = 0;
        // Hundreds may come in a frame and find hundreds here: nothing is moved along.
        while let Some(earlier) = self.0.get(index) {
            if !overlap(place, earlier.place) {
                index += 1;
            } else if place.contains_rect(earlier.place) {
                self.0.swap_remove(index);
            } else {
                turn = turn.max(earlier.turn + 1);
                index += 1;
            }
        }
        self.0.push(Waiting { piece, place, turn });
    }

    /// How many there are.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether all that was taken in shows.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Hands the pieces to `show`, each in one cell of `grid`, until that says it is enough; the others wait on.
    pub fn drain(&mut self, grid: Grid, mut show: impl FnMut(EncodedTile) -> ControlFlow<()>) {
        let mut runs = joined(std::mem::take(&mut self.0), grid).into_iter();
        for run in runs.by_ref() {
            if show(run.piece).is_break() {
                break;
            }
        }
        self.0 = runs.collect();
    }
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

/// Whether two places have more than an edge in common.
fn overlap(a: Rect, b: Rect) -> bool {
    a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y
}

/// Where a piece lies, in texels.
pub(super) fn place_of(piece: &EncodedTile) -> Rect {
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
mod tests {
    use super::*;
    use crate::gui::canvas::tests::piece;
    use egui::Color32;

    #[test]
    fn pieces_side_by_side_are_joined_and_the_last_at_a_place_counts() {
        let mut queue = Queue::default();
        for piece in [
            piece([4, 2], [2, 2], 1),
            piece([0, 0], [2, 2], 2),
            piece([2, 2], [2, 2], 3),
            piece([2, 0], [2, 1], 4),
            piece([2, 2], [2, 2], 5),
            piece([8, 2], [2, 2], 6),
        ] {
            queue.put(piece);
        }
        let runs = joined(queue.0, Grid::of([10, 4], 2048));
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
    fn tiles_that_come_in_any_order_go_to_the_driver_in_rows() {
        let mut queue = Queue::default();
        for x in [2, 0, 3, 1] {
            for y in [1, 0] {
                queue.put(piece([32 * x, 32 * y], [32, 32], 1));
            }
        }
        // Those of the next pass take the place of those that do not show yet.
        queue.put(piece([32, 32], [32, 32], 2));
        let runs = joined(queue.0, Grid::of([128, 64], 2048));
        let sizes: Vec<_> = runs.iter().map(|run| run.piece.pixels.size).collect();
        assert_eq!(sizes, [[128, 32]; 2]);
        let row = &runs[1].piece.pixels;
        assert_eq!([31, 32].map(|x| row[(x, 0)].r()), [1, 2]);
    }

    #[test]
    fn tiles_are_joined_up_to_the_edge_of_a_column() {
        let mut queue = Queue::default();
        for x in [64, 0, 96, 32] {
            queue.put(piece([x, 0], [32, 32], 1));
        }
        // Two columns of 70 and 69 texels.
        let runs = joined(queue.0, Grid::of([139, 40], 100));
        let runs = runs.into_iter().map(|run| run.piece);
        let places: Vec<_> = runs.map(|run| (run.position, run.pixels.size)).collect();
        assert_eq!(places, [([0, 0], [70, 32]), ([70, 0], [58, 32])]);
    }
}
