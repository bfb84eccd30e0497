//! A part of a picture, or all of it: which of its pixels, and where they are on the screen.

use egui::{Pos2, Rect, Vec2};

use crate::render::Region;

/// A rectangle of pixels of a picture of a known size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The pixels. They lie in the picture.
    pub region: Region,
    /// Width and height of the picture, in pixels.
    pub of: [u32; 2],
}

impl Part {
    /// All of a picture of this width and height.
    #[must_use]
    pub fn whole(of: [u32; 2]) -> Self {
        Self {
            region: Region::full(of[0], of[1]),
            of,
        }
    }

    /// Whether it is all of the picture.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        *self == Self::whole(self.of)
    }

    /// The region, where it is not all of the picture.
    #[must_use]
    pub fn region(&self) -> Option<Region> {
        (!self.is_whole()).then_some(self.region)
    }

    /// The same part of a picture of another size: what it shows stays as far as pixels allow, and it has at least one.
    #[must_use]
    pub fn scaled_to(&self, of: [u32; 2]) -> Self {
        if of == self.of {
            return *self;
        }
        let along = |start: u32, length: u32, from: u32, to: u32| {
            let edge = |edge: u32| {
                let scaled = u64::from(edge) * u64::from(to) * 2 + u64::from(from);
                u32::try_from(scaled / (2 * u64::from(from.max(1)))).unwrap_or(to)
            };
            let first = edge(start).min(to.saturating_sub(1));
            let end = edge(start + length).clamp(first + 1, to.max(1));
            (first, end - first)
        };
        let Region {
            x,
            y,
            width,
            height,
        } = self.region;
        let (x, width) = along(x, width, self.of[0], of[0]);
        let (y, height) = along(y, height, self.of[1], of[1]);
        Self {
            region: Region {
                x,
                y,
                width,
                height,
            },
            of,
        }
    }

    /// The pixels between two corners, given as edges of pixels from the picture's top left corner; `None` where there are none
    /// between.
    #[must_use]
    pub fn between(a: [u32; 2], b: [u32; 2], of: [u32; 2]) -> Option<Self> {
        let first = [0, 1].map(|axis| a[axis].min(b[axis]).min(of[axis]));
        let end = [0, 1].map(|axis| a[axis].max(b[axis]).min(of[axis]));
        let region = Region {
            x: first[0],
            y: first[1],
            width: end[0] - first[0],
            height: end[1] - first[1],
        };
        region.fits(of[0], of[1]).then_some(Self { region, of })
    }

    /// The pixels that two parts of a picture have in common; `None` where there are none, or the pictures differ in size.
    #[must_use]
    pub fn shared_with(&self, other: &Self) -> Option<Self> {
        let ends = |region: Region| [region.x + region.width, region.y + region.height];
        let [a, b] = [self.region, other.region];
        let first = [a.x.max(b.x), a.y.max(b.y)];
        let end = [0, 1].map(|axis| ends(a)[axis].min(ends(b)[axis]));
        let is_any = self.of == other.of && first[0] < end[0] && first[1] < end[1];
        is_any.then(|| Self::between(first, end, self.of)).flatten()
    }

    /// Where it is on the screen, where the picture is in `frame`.
    #[must_use]
    pub fn rect_in(&self, frame: Rect) -> Rect {
        if self.is_whole() {
            return frame;
        }
        let Region {
            x,
            y,
            width,
            height,
        } = self.region;
        let at = |x: u32, y: u32| {
            let share = Vec2::new(
                x as f32 / self.of[0].max(1) as f32,
                y as f32 / self.of[1].max(1) as f32,
            );
            frame.min + share * frame.size()
        };
        Rect::from_min_max(at(x, y), at(x + width, y + height))
    }

    /// The edge of a pixel nearest to `position`, where a picture of the size `of` is in `frame`.
    #[must_use]
    pub fn edge_at(position: Pos2, frame: Rect, of: [u32; 2]) -> [u32; 2] {
        let share = (position - frame.min) / frame.size().max(Vec2::splat(f32::MIN_POSITIVE));
        let edge = |share: f32, side: u32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the picture"
            )]
            let edge = (f64::from(share).clamp(0.0, 1.0) * f64::from(side)).round() as u32;
            edge
        };
        [edge(share.x, of[0]), edge(share.y, of[1])]
    }

    /// The pixel at a place of the picture, which is given as shares of its width and height, `0..=1`.
    #[must_use]
    pub fn pixel_at(&self, share: Vec2) -> [u32; 2] {
        let pixel = |share: f32, side: u32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "no less than 0, and cut to the picture"
            )]
            let pixel = (share.max(0.0) * side as f32) as u32;
            pixel.min(side.saturating_sub(1))
        };
        [pixel(share.x, self.of[0]), pixel(share.y, self.of[1])]
    }

    /// Its size in words, and that of the picture where it is not all of it.
    #[must_use]
    pub fn size_in_words(&self) -> String {
        let Region { width, height, .. } = self.region;
        let [all_width, all_height] = self.of;
        if self.is_whole() {
            format!("{width} × {height}")
        } else {
            format!("{width} × {height} of {all_width} × {all_height}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    fn part(region: [u32; 4], of: [u32; 2]) -> Part {
        let [x, y, width, height] = region;
        let region = Region {
            x,
            y,
            width,
            height,
        };
        Part { region, of }
    }

    #[test]
    fn a_part_keeps_what_it_shows_when_the_picture_grows_or_shrinks() {
        let drawn = part([100, 50, 200, 100], [400, 300]);
        assert_eq!(
            drawn.scaled_to([800, 600]),
            part([200, 100, 400, 200], [800, 600])
        );
        assert_eq!(drawn.scaled_to([4, 3]), part([1, 1, 2, 1], [4, 3]));
        assert_eq!(drawn.scaled_to([1, 1]), Part::whole([1, 1]));
        let corner = part([399, 299, 1, 1], [400, 300]);
        for of in [[1, 1], [3, 2], [7, 5], [65_536, 1], [400, 300]] {
            let scaled = corner.scaled_to(of);
            assert!(scaled.region.fits(of[0], of[1]), "{scaled:?}");
        }
        assert!(Part::whole([400, 300]).scaled_to([7, 5]).is_whole());
    }

    #[test]
    fn what_two_parts_share_lies_in_both() {
        let of = [100, 80];
        let whole = Part::whole(of);
        let a = part([10, 20, 30, 40], of);
        assert_eq!(a.shared_with(&whole), Some(a));
        assert_eq!(whole.shared_with(&a), Some(a));
        let b = part([35, 0, 50, 30], of);
        assert_eq!(a.shared_with(&b), Some(part([35, 20, 5, 10], of)));
        assert_eq!(
            a.shared_with(&part([40, 20, 5, 5], of)),
            None,
            "side by side"
        );
        assert_eq!(a.shared_with(&Part::whole([80, 100])), None);
    }

    #[test]
    fn it_is_drawn_from_corner_to_corner_and_lies_where_it_was_drawn() {
        let frame = Rect::from_min_size(pos2(10.0, 20.0), Vec2::new(80.0, 40.0));
        let of = [160, 80];
        let (a, b) = (pos2(50.0, 70.0), pos2(30.0, 30.0));
        let [a, b] = [a, b].map(|position| Part::edge_at(position, frame, of));
        assert_eq!((a, b), ([80, 80], [40, 20]));
        let drawn = Part::between(a, b, of).unwrap();
        assert_eq!(drawn, part([40, 20, 40, 60], of));
        let rect = drawn.rect_in(frame);
        assert_eq!(rect, Rect::from_min_max(pos2(30.0, 30.0), pos2(50.0, 60.0)));
        assert_eq!(Part::between(a, a, of), None);
        assert_eq!(Part::whole(of).rect_in(frame), frame);
    }
}
