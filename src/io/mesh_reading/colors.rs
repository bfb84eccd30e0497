//! Colours of vertices, as text formats write them in sRGB, with channels up to 1 or up to 255: the largest channel of a file
//! tells which.

use crate::math::color::linear_from_srgb;
use crate::math::{DVec3, Vec3};

/// The colours of vertices or triangles, as far as there are any.
#[derive(Debug, Default)]
pub struct Colors {
    /// As written; [`NONE`] for what has none. Empty until the first has one.
    written: Vec<Vec3>,
    /// The largest channel.
    largest: f32,
}

/// Stands for no colour: more than white.
const NONE: Vec3 = Vec3::INFINITY;
/// Colours with a channel beyond this go to 255: white of a file that goes to 1 may be a little more.
const MOST_OF_UNITS: f32 = 1.5;

impl Colors {
    /// Gives `color` to the items with numbers in `range`, and none to those before that have none yet.
    pub fn fill(&mut self, range: std::ops::Range<usize>, color: DVec3) {
        let color = color.as_vec3();
        self.written.resize(range.start, NONE);
        self.written.resize(range.end, color);
        self.largest = self.largest.max(color.max_element());
    }

    /// Gives `color` to the last of `count` items.
    pub fn push(&mut self, count: usize, color: DVec3) {
        self.fill(count - 1..count, color);
    }

    /// An alpha, which means nothing but tells how far the channels go.
    pub fn measure(&mut self, alpha: f64) {
        #[expect(clippy::cast_possible_truncation, reason = "large stays large")]
        let alpha = alpha as f32;
        self.largest = self.largest.max(alpha);
    }

    /// The colours of all `count` items, linear and clamped to `0..=1`, white where there is none; `None` where no item has one.
    pub fn into_linear(mut self, count: usize) -> Option<Vec<Vec3>> {
        if self.written.is_empty() {
            return None;
        }
        self.written.resize(count, NONE);
        let white = if self.largest > MOST_OF_UNITS {
            255.0
        } else {
            1.0
        };
        for color in &mut self.written {
            *color = (*color / white).map(linear_from_srgb);
        }
        Some(self.written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_go_to_one_or_to_255_by_the_largest_of_all() {
        let half = linear_from_srgb(0.5);
        let mut units = Colors::default();
        units.push(2, DVec3::new(0.5, 1.0, -1.0));
        units.measure(1.0);
        let expected = vec![Vec3::ONE, Vec3::new(half, 1.0, 0.0), Vec3::ONE];
        assert_eq!(units.into_linear(3), Some(expected));

        let mut bytes = Colors::default();
        bytes.fill(0..2, DVec3::ZERO);
        bytes.push(3, DVec3::new(127.5, 255.0, 300.0));
        let expected = vec![Vec3::ZERO, Vec3::ZERO, Vec3::new(half, 1.0, 1.0)];
        assert_eq!(bytes.into_linear(3), Some(expected));

        // Nearly black in whole numbers, as the alpha tells.
        let mut dark = Colors::default();
        dark.push(1, DVec3::X);
        dark.measure(255.0);
        let dark = dark.into_linear(1).expect("there is one");
        assert_eq!(dark, [Vec3::X * linear_from_srgb(1.0 / 255.0)]);
        assert_eq!(Colors::default().into_linear(3), None);
    }
}
