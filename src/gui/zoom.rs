//! Where a picture lies in the window: all of it fits, or it is enlarged and moved.
//!
//! Scales are in pixels of the screen per pixel of the picture: 1 is 100 %.

use egui::{Pos2, Rect, Response, Ui, Vec2, pos2};

use super::part::Part;

/// Largest scale: single pixels fill a good part of the screen.
const LARGEST: f32 = 64.0;
/// Scale at which a single pixel is found at once.
const CLOSE: f32 = 16.0;
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

    /// The frame, on whole pixels of the screen.
    fn frame(&self) -> Rect {
        let frame = self.exact_frame();
        if self.enlarged.is_none() {
            return frame;
        }
        let scale = self.place.pixels_per_point;
        let snap = |points: f32| (points * scale).round() / scale;
        Rect::from_min_size(pos2(snap(frame.left()), snap(frame.top())), frame.size())
    }

    /// The frame as it follows from what was done: what a turn of the wheel rounds would add up over many.
    fn exact_frame(&self) -> Rect {
        let Some(Enlarged { scale, center }) = self.enlarged else {
            return self.place.fit;
        };
        let Place { area, fit, .. } = self.place;
        let size = self.place.points(scale);
        let wanted = area.center() - center * size;
        // It covers where all of it is seen, or lies within that where it is smaller. So it does not leave the room, and whatever is
        // pointed at in the whole picture can stay where it is as that is enlarged.
        let place = |wanted: f32, size: f32, low: f32, high: f32| {
            let ends = [low, high - size];
            wanted.clamp(ends[0].min(ends[1]), ends[0].max(ends[1]))
        };
        let x = place(wanted.x, size.x, fit.left(), fit.right());
        let y = place(wanted.y, size.y, fit.top(), fit.bottom());
        Rect::from_min_size(pos2(x, y), size)
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

    /// Shows a pixel of the picture in the middle, so large that it is found at once.
    pub fn show_pixel(&mut self, pixel: [u32; 2]) {
        let size = self.place.size.map(|side| side.max(1) as f32);
        let [x, y] = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / size[axis]);
        self.enlarged = Some(Enlarged {
            scale: self.scale().max(CLOSE),
            center: Vec2::new(x, y),
        });
        self.settle();
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
        let frame = self.exact_frame();
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
        let frame = self.exact_frame();
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

    /// The place of the picture under `position`, as shares of its width and height.
    #[must_use]
    pub fn share_at(&self, position: Pos2) -> Option<Vec2> {
        let frame = self.frame();
        let is_there = frame.contains(position) && self.place.area.contains(position);
        is_there.then(|| (position - frame.min) / frame.size())
    }

    /// The pixel of the picture under `position`.
    #[must_use]
    pub fn pixel_at(&self, position: Pos2) -> Option<[u32; 2]> {
        let share = self.share_at(position)?;
        Some(Part::whole(self.place.size).pixel_at(share))
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

    /// A wheel that turns comes nearer in many small steps, first of all from the whole picture, which has room around it.
    #[test]
    fn many_small_steps_from_the_whole_picture_lead_to_what_is_pointed_at() {
        let place = Place {
            area: Rect::from_min_size(pos2(0.0, 40.0), Vec2::new(940.0, 600.0)),
            fit: Rect::from_min_size(pos2(44.0, 71.0), Vec2::new(882.0, 538.0)),
            size: [882, 538],
            pixels_per_point: 1.0,
        };
        for share in [[0.01, 0.01], [0.5, 0.2], [0.97, 0.4], [0.3, 0.99]] {
            let mut zoom = Zoom::default();
            zoom.frame_in(place);
            let mouse = place.fit.lerp_inside(Vec2::from(share));
            let before = zoom.pixel_at(mouse).unwrap();
            for step in 0..150 {
                zoom.zoom_to(zoom.scale() * 1.02, mouse);
                let after = zoom.pixel_at(mouse).unwrap();
                let apart = [0, 1].map(|axis| before[axis].abs_diff(after[axis]));
                assert!(
                    apart[0].max(apart[1]) <= 1,
                    "{before:?} {after:?} after {step}"
                );
            }
            assert!(zoom.scale() > 15.0);
        }
    }

    #[test]
    fn a_pixel_is_shown_in_the_middle() {
        let mut zoom = zoom();
        for pixel in [[400, 200], [237, 311]] {
            zoom.show_pixel(pixel);
            assert!(zoom.scale() >= CLOSE);
            assert_eq!(zoom.pixel_at(zoom.place.area.center()), Some(pixel));
        }
        // At an edge it is as near to the middle as it can be.
        zoom.show_pixel([0, 399]);
        let frame = zoom.frame();
        let corner = pos2(frame.left() + 1.0, frame.bottom() - 1.0);
        assert!(zoom.place.area.contains(corner));
        assert_eq!(zoom.pixel_at(corner), Some([0, 399]));
        assert!((zoom.scale() - CLOSE).abs() < 1e-3);
    }

    #[test]
    fn the_picture_does_not_leave_the_room() {
        let mut zoom = zoom();
        zoom.full();
        for delta in [-5000.0, 5000.0] {
            zoom.pan(Vec2::splat(delta));
            let frame = zoom.frame();
            assert_eq!(frame.size(), Vec2::new(800.0, 400.0));
            assert!(frame.contains_rect(zoom.place.fit), "{frame:?}");
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
