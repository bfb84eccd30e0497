//! The two measures of error, which are added up and judged side by side.

use serde::{Deserialize, Serialize};

/// One of the two.
#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Squares of errors, in units of radiance.
    Absolute,
    /// Squares of errors over those of the truth, which is [`RELATIVE_FLOOR`](super::RELATIVE_FLOOR) at least.
    Relative,
}

/// The same by both measures.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Measures<T> {
    pub absolute: T,
    pub relative: T,
}

impl<T> Measures<T> {
    /// That of one measure.
    pub fn of(&self, measure: Measure) -> &T {
        match measure {
            Measure::Absolute => &self.absolute,
            Measure::Relative => &self.relative,
        }
    }

    /// What `follow` makes of both.
    pub fn map<U>(&self, follow: impl Fn(&T) -> U) -> Measures<U> {
        Measures {
            absolute: follow(&self.absolute),
            relative: follow(&self.relative),
        }
    }

    /// Changes both by what `other` has of the same measure.
    pub fn change_by<U>(&mut self, other: &Measures<U>, change: impl Fn(&mut T, &U)) {
        change(&mut self.absolute, &other.absolute);
        change(&mut self.relative, &other.relative);
    }
}

impl std::ops::Add for Measures<f64> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            absolute: self.absolute + other.absolute,
            relative: self.relative + other.relative,
        }
    }
}
