//! What of two compared pictures is seen at a place.

use egui::{Color32, Pos2, Rect};

use super::file::give_look;
use super::{Comparison, Mode};
use crate::analysis::scaled_difference;
use crate::gui::inspector::PixelValues;
use crate::gui::look::{Channels, Look};
use crate::gui::picture_buffer::PictureBuffer;
use crate::render::Image;
use crate::scene::Display;

/// Which picture is seen at a place, and its colour there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// The one that is looked at.
    Itself(Color32),
    /// The one that it is compared with.
    Other(Color32),
    /// The difference of both.
    Difference(Color32),
    /// None of them: there is no difference to show, or the other one does not reach there.
    Nothing,
}

impl Seen {
    /// The colour, where a picture is seen.
    #[must_use]
    pub fn color(self) -> Option<Color32> {
        match self {
            Self::Itself(color) | Self::Other(color) | Self::Difference(color) => Some(color),
            Self::Nothing => None,
        }
    }
}

impl Comparison {
    /// The light that B holds at a place of the frame, given as shares of its width and height, where it is known.
    #[must_use]
    pub fn light_at(&self, share: egui::Vec2) -> Option<[f32; 3]> {
        let values = self.other_at(share).filter(|_| self.saved_look.is_none());
        values.map(|values| values.linear)
    }

    /// What B holds at a place of the frame.
    fn other_at(&self, share: egui::Vec2) -> Option<PixelValues> {
        self.buffer.values_at(self.buffer.part().pixel_at(share))
    }

    /// What is seen at `position`, where `visible` is seen of the frame, whose shares `share` are: A, which is `picture` and looks like
    /// `color` there, B, or the difference.
    #[must_use]
    pub fn seen_at(
        &self,
        position: Pos2,
        visible: Rect,
        share: egui::Vec2,
        (picture, color): (&PictureBuffer, Color32),
    ) -> Seen {
        let shows_other = match self.mode {
            Mode::Wipe => position.x > self.divider_x(visible),
            Mode::Flip => self.shows_other,
            Mode::Difference => {
                let difference = self.difference_at(share, picture);
                return difference.map_or(Seen::Nothing, Seen::Difference);
            }
        };
        if !shows_other {
            return Seen::Itself(color);
        }
        let other = self.other().and_then(|_| self.other_at(share));
        other.map_or(Seen::Nothing, |values| Seen::Other(values.color))
    }

    /// Where the divider is on the screen.
    pub(super) fn divider_x(&self, visible: Rect) -> f32 {
        visible.left() + visible.width() * self.divider
    }

    /// The colour of the difference at a place, where it is shown.
    fn difference_at(&self, share: egui::Vec2, picture: &PictureBuffer) -> Option<Color32> {
        let distance = self.distance.as_ref()?.as_ref().ok()?;
        self.difference()?;
        let light = |buffer: &PictureBuffer| {
            let pixel = buffer.part().pixel_at(share);
            let pixels = vec![buffer.light_at(pixel)?];
            Some(Image {
                width: 1,
                height: 1,
                pixels,
            })
        };
        let (mut a, b) = (light(picture)?, light(&self.buffer)?);
        if let Some(look) = &self.saved_look {
            give_look(&mut a, look);
        }
        let difference = scaled_difference(&a, &b, distance.white).ok()?;
        let look = Look::Light(Display::default(), Channels::All);
        Some(look.color(difference.pixels[0]))
    }
}
