//! Where a picture lies in the window: all of it fits, or it is enlarged and moved.
//!
//! Scales are in pixels of the screen per pixel of the picture: 1 is 100 %.

use egui::{Pos2, Rect, Response, Ui, Vec2, pos2};

/// Largest scale: single pixels fill a good part of the screen.
const LARGEST: f32 = 64.0;
/// How much larger one point of scrolling makes the picture.
const ZOOM_PER_POINT: f32 = 0.0025;
/// What one press of a key enlarges by.
const KEY_FACTOR: f32 = 1.5;

/// How a picture is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zoom {
    /// `None` where all of the picture is seen.
    enlarged: Option<Enlarged>,
    /// Where the picture was drawn last.
    place: Place,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Enlarged {
    scale: f32,
    /// What is in the middle of the area, as a share of the picture's width and height.
    center: Vec2,
}

/// Where there is room for a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The room, in points.
    pub area: Rect,
    /// The frame in which all of the picture is seen, in points.
    pub fit: Rect,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Pixels of the screen per point.
    pub pixels_per_point: f32,
}

impl Default for Zoom {
    fn default() -> Self {
        Self {
            enlarged: None,
            place: Place {
                area: Rect::ZERO,
                fit: Rect::ZERO,
                size: [1; 2],
                pixels_per_point: 1.0,
            },
        }
    }
}

impl Place {
    /// The scale at which all of the picture is seen.
    fn fit_scale(&self) -> f32 {
        self.fit.width() * self.pixels_per_point / self.size[0].max(1) as f32
    }

    /// Width and height of the picture in points.
    fn points(&self, scale: f32) -> Vec2 {
        let [width, height] = self.size.map(|side| side.max(1) as f32);
        Vec2::new(width, height) * (scale / self.pixels_per_point)
    }
}

impl Zoom {
    /// The frame of the picture, which lies partly outside the room where it is enlarged. Remembers the room.
    pub fn frame_in(&mut self, place: Place) -> Rect {
        self.place = place;
        self.frame()
    }

    fn frame(&self) -> Rect {
        let Some(Enlarged { scale, center }) = self.enlarged else {
            return self.place.fit;
        };
        let Place {
            area,
            pixels_per_point,
            ..
        } = self.place;
        let size = self.place.points(scale);
        let wanted = area.center() - center * size;
        // No gap beside the picture where it is larger than the room, and even gaps where it is not.
        let place = |wanted: f32, size: f32, low: f32, high: f32| {
            if size <= high - low {
                f32::midpoint(low, high) - size / 2.0
            } else {
                wanted.clamp(high - size, low)
            }
        };
        let snap = |points: f32| (points * pixels_per_point).round() / pixels_per_point;
        let x = place(wanted.x, size.x, area.left(), area.right());
        let y = place(wanted.y, size.y, area.top(), area.bottom());
        Rect::from_min_size(pos2(snap(x), snap(y)), size)
    }

    /// Whether the picture is larger than it takes to see all of it.
    #[must_use]
    pub fn is_enlarged(&self) -> bool {
        self.enlarged.is_some()
    }

    /// Pixels of the screen per pixel of the picture.
    #[must_use]
    pub fn scale(&self) -> f32 {
        let fit = self.place.fit_scale();
        self.enlarged.map_or(fit, |enlarged| enlarged.scale)
    }

    /// Shows all of the picture.
    pub fn fit(&mut self) {
        self.enlarged = None;
    }

    /// Shows each pixel of the picture as one of the screen, with what is in the middle staying there.
    pub fn full(&mut self) {
        self.zoom_to(1.0, self.place.area.center());
    }

    /// One step nearer.
    pub fn nearer(&mut self) {
        self.zoom_to(self.scale() * KEY_FACTOR, self.place.area.center());
    }

    /// One step back.
    pub fn farther(&mut self) {
        self.zoom_to(self.scale() / KEY_FACTOR, self.place.area.center());
    }

    /// Shows the picture at `scale`, with what is under `fixed` staying there. A scale at which less than the room is filled shows
    /// all of it, except for the small picture that is smaller at 100 %.
    fn zoom_to(&mut self, scale: f32, fixed: Pos2) {
        let frame = self.frame();
        let share = (fixed - frame.min) / frame.size().max(Vec2::splat(f32::MIN_POSITIVE));
        let fit = self.place.fit_scale();
        let scale = scale.clamp(fit.min(1.0), fit.max(LARGEST));
        let size = self.place.points(scale);
        let min = fixed - share * size;
        let is_fit = (scale / self.place.fit_scale() - 1.0).abs() < 1e-3;
        self.enlarged = (!is_fit && scale.is_finite()).then(|| Enlarged {
            scale,
            center: (self.place.area.center() - min) / size,
        });
        self.settle();
    }

    /// Moves the picture by `delta` points.
    pub fn pan(&mut self, delta: Vec2) {
        if let Some(enlarged) = &mut self.enlarged {
            enlarged.center -= delta / self.place.points(enlarged.scale);
        }
        self.settle();
    }

    /// Keeps the middle where the picture is, so that the way back from beyond an edge is not long.
    fn settle(&mut self) {
        let frame = self.frame();
        if let Some(enlarged) = &mut self.enlarged {
            enlarged.center = (self.place.area.center() - frame.min) / frame.size();
        }
    }

    /// Turning the wheel and pinching come nearer to what is under the mouse.
    pub fn scroll_ui(&mut self, ui: &Ui, response: &Response) {
        let Some(position) = response.hover_pos() else {
            return;
        };
        let (scrolled, pinched) =
            ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (scrolled * ZOOM_PER_POINT).exp() * pinched;
        if (factor - 1.0).abs() > 1e-6 {
            self.zoom_to(self.scale() * factor, position);
        }
    }

    /// The pixel of the picture under `position`.
    #[must_use]
    pub fn pixel_at(&self, position: Pos2) -> Option<[u32; 2]> {
        let frame = self.frame();
        if !frame.contains(position) || !self.place.area.contains(position) {
            return None;
        }
        let share = (position - frame.min) / frame.size();
        let pixel = |share: f32, side: u32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the picture"
            )]
            let pixel = (share * side as f32) as u32;
            pixel.min(side.saturating_sub(1))
        };
        let [width, height] = self.place.size;
        Some([pixel(share.x, width), pixel(share.y, height)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zoom() -> Zoom {
        let mut zoom = Zoom::default();
        let frame = zoom.frame_in(Place {
            area: Rect::from_min_size(pos2(10.0, 20.0), Vec2::new(400.0, 300.0)),
            fit: Rect::from_min_size(pos2(10.0, 70.0), Vec2::new(400.0, 200.0)),
            size: [800, 400],
            pixels_per_point: 1.0,
        });
        assert_eq!(frame, zoom.place.fit);
        zoom
    }

    #[test]
    fn what_is_under_the_mouse_stays_there() {
        let mut zoom = zoom();
        assert!((zoom.scale() - 0.5).abs() < 1e-6);
        let mouse = pos2(110.0, 120.0);
        let before = zoom.pixel_at(mouse).unwrap();
        for scale in [1.0, 4.0, 30.0] {
            zoom.zoom_to(scale, mouse);
            let after = zoom.pixel_at(mouse).unwrap();
            for (a, b) in before.iter().zip(after) {
                assert!(a.abs_diff(b) <= 2, "{before:?} {after:?} at {scale}");
            }
        }
        zoom.zoom_to(1e9, mouse);
        assert!((zoom.scale() - LARGEST).abs() < 1e-3);
        zoom.zoom_to(0.001, mouse);
        assert!(!zoom.is_enlarged(), "smaller than all of it is all of it");
    }

    #[test]
    fn the_picture_does_not_leave_the_room() {
        let mut zoom = zoom();
        zoom.full();
        for delta in [-5000.0, 5000.0] {
            zoom.pan(Vec2::splat(delta));
            let frame = zoom.frame();
            assert_eq!(frame.size(), Vec2::new(800.0, 400.0));
            assert!(frame.contains_rect(zoom.place.area), "{frame:?}");
        }
        // It does not stick at the edge.
        zoom.pan(Vec2::new(-10.0, 0.0));
        assert!(
            (zoom.frame().left() - 0.0).abs() < 1e-3,
            "{:?}",
            zoom.frame()
        );
        zoom.fit();
        assert_eq!(zoom.frame(), zoom.place.fit);
    }

    #[test]
    fn a_small_picture_is_in_the_middle_at_its_own_size() {
        let mut zoom = zoom();
        zoom.place.size = [40, 20];
        zoom.full();
        assert_eq!(zoom.frame().size(), Vec2::new(40.0, 20.0));
        assert_eq!(zoom.frame().center(), zoom.place.area.center());
        assert_eq!(zoom.pixel_at(pos2(11.0, 21.0)), None);
        assert_eq!(zoom.pixel_at(zoom.frame().min), Some([0, 0]));
    }
}
