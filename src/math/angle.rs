//! Angles with their unit in the type: people write degrees, formulas take radians as plain `f64`.

use std::fmt;

/// An angle as people write it. Files and the window hold degrees; formulas take [`Degrees::radians`].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
pub struct Degrees(pub f64);

impl Degrees {
    /// The same angle in radians.
    #[must_use]
    pub fn radians(self) -> f64 {
        self.0.to_radians()
    }
}

impl fmt::Display for Degrees {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}°", self.0)
    }
}
