//! How often a hazard was found, and its first few places.

use super::Place;
use crate::math::counted;

/// A count, and the first few of what is counted.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub count: u64,
    pub places: Vec<Place>,
}

impl Tally {
    /// The most places that are kept.
    pub const MOST_PLACES: usize = 5;

    /// Counts one more; `place` is asked for where it is, if that is kept.
    pub fn add(&mut self, place: impl FnOnce() -> Place) {
        self.count += 1;
        if self.places.len() < Self::MOST_PLACES {
            self.places.push(place());
        }
    }

    /// The count and what is counted: "1 face", "12 faces".
    pub fn of(&self, one: &str, many: &str) -> String {
        counted(self.count, one, many)
    }
}
