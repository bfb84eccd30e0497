use crate::math::color::linear_from_srgb;
use crate::math::{DVec3, Vec3};

/// The colours of vertices, as far as there are any.
#[derive(Debug, Default)]
pub struct Colors {
    /// As written; [`NONE`] for vertices without. Empty until the first vertex has one.
    written: Vec<Vec3>,
    /// The largest channel.
    largest: f32,
}

/// Stands for no colour: more than white.
const NONE: Vec3 = Vec3::INFINITY;
/// Colours with a channel beyond this go to 255: white of a file that goes to 1 may be a little more.
const MOST_OF_UNITS: f32 = 1.5;

impl Colors {
    /// The last of so many `vertices` has this colour.
    pub fn push(&mut self, color: DVec3, vertices: usize) {
        let color = color.as_vec3();
        self.written.resize(vertices - 1, NONE);
        self.written.push(color);
        self.largest = self.largest.max(color.max_element());
    }

    /// The last vertex has none.
    pub fn skip(&mut self) {
        if !self.written.is_empty() {
            self.written.push(NONE);
        }
    }

    /// All of them, linear and clamped to `0..=1`; `None` where no vertex has one.
    pub fn into_linear(mut self) -> Option<Vec<Vec3>> {
        let white = if self.largest > MOST_OF_UNITS {
            255.0
        } else {
            1.0
        };
        for color in &mut self.written {
            *color = (*color / white).map(linear_from_srgb);
        }
        (!self.written.is_empty()).then_some(self.written)
    }
}
