//! What writers of mesh formats share: numbers in text.

use crate::math::DVec3;
use std::fmt::{self, Display, Formatter};

/// A vector as three numbers in text, each the shortest that reads back as the same `f64`.
pub struct Decimals(pub DVec3);

impl Display for Decimals {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.0;
        write_number(x, out)?;
        out.write_str(" ")?;
        write_number(y, out)?;
        out.write_str(" ")?;
        write_number(z, out)
    }
}

/// Writes a number; plain digits would be hundreds long for the extreme ones.
fn write_number(value: f64, out: &mut Formatter<'_>) -> fmt::Result {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) {
        write!(out, "{value}")
    } else {
        write!(out, "{value:e}")
    }
}

/// Whether `f32` holds all these numbers as they are.
pub fn fit_f32<'a>(vectors: impl IntoIterator<Item = &'a DVec3>) -> bool {
    let mut vectors = vectors.into_iter();
    vectors.all(|vector| vector.as_vec3().as_dvec3() == *vector)
}
