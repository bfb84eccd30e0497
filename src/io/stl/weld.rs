//! One vertex for all corners of the very same position.

use crate::math::DVec3;
use foldhash::fast::RandomState;
use std::collections::HashMap;

/// Vertices by their positions.
#[derive(Default)]
pub struct Weld {
    pub positions: Vec<DVec3>,
    vertices: HashMap<[u64; 3], u32, RandomState>,
}

impl Weld {
    /// The vertex at `position`, a new one if there is none; `None` where there are 2³² already.
    pub fn vertex(&mut self, position: DVec3) -> Option<u32> {
        // −0 + 0 is 0.
        let position = position + DVec3::ZERO;
        let key = position.to_array().map(f64::to_bits);
        let next = u32::try_from(self.positions.len()).ok()?;
        let vertex = *self.vertices.entry(key).or_insert(next);
        if vertex == next {
            self.positions.push(position);
        }
        Some(vertex)
    }
}
