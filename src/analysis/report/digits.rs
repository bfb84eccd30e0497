//! Numbers of samples for people.

/// Samples of a pixel: a whole number where it is one.
pub(super) fn samples(samples: f64) -> String {
    if samples.fract() == 0.0 {
        format!("{samples:.0}")
    } else {
        format!("{samples:.1}")
    }
}
