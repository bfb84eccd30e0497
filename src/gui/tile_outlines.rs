//! Outlines of the tiles that are being rendered, over the picture.

use egui::{Color32, CornerRadius, Rect, Stroke, StrokeKind, Ui};

use super::part::Part;
use super::picture::Picture;
use super::theme;

/// Whether tiles at work are outlined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOutlines {
    /// Whether they are.
    pub are_shown: bool,
}

impl Default for TileOutlines {
    fn default() -> Self {
        Self { are_shown: true }
    }
}

impl TileOutlines {
    /// Draws where in the picture, which is in `frame` and of which `visible` is seen, its threads are at work. A paused render is at work
    /// nowhere.
    pub fn outlines_ui(self, ui: &Ui, frame: Rect, visible: Rect, picture: &Picture) {
        if !self.are_shown || !picture.is_running() || picture.is_paused() {
            return;
        }
        let painter = ui.painter().with_clip_rect(visible);
        let of = picture.buffer.part().of;
        for region in picture.progress.in_hand.tiles() {
            let tile = Part { region, of }.rect_in(frame);
            // Seen on any picture: a bright line within a dark one.
            let around = Stroke::new(3.0, Color32::from_black_alpha(110));
            let edge = Stroke::new(1.5, theme::ACCENT);
            for stroke in [around, edge] {
                painter.rect_stroke(tile, CornerRadius::ZERO, stroke, StrokeKind::Middle);
            }
        }
    }
}
