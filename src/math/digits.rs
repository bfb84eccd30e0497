//! Numbers for people.

use std::fmt::Display;

/// A number with three digits, and with an exponent where there would be many zeros.
#[must_use]
pub fn three_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !(1e-4..1e5).contains(&size) {
        format!("{value:.2e}")
    } else {
        // 100 has no places behind the point, 0.0001 has 6. What is rounded up to another digit loses a place.
        let places = (0..7).take_while(|&places| size * 10_f64.powi(places) < 99.95);
        format!("{value:.*}", places.count())
    }
}

/// A part of one as a percentage with three digits.
#[must_use]
pub fn percent(part: f64) -> String {
    format!("{} %", three_digits(100.0 * part))
}

/// So many of a thing, whose plural is its name and an s.
#[must_use]
pub fn counted(count: impl Display + PartialEq + From<u8> + Copy, thing: &str) -> String {
    let plural = if count == 1.into() { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!(counted(1_usize, "triangle"), "1 triangle");
        assert_eq!(counted(0_u64, "triangle"), "0 triangles");
        assert_eq!(counted(1.0, "sample"), "1 sample");
        assert_eq!(counted(1.5, "sample"), "1.5 samples");
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1.00"),
            (9.994, "9.99"),
            (99.96, "100"),
            (123.4, "123"),
            (12_345.6, "12346"),
            (0.000_123_4, "0.000123"),
            (0.000_012_34, "1.23e-5"),
            (-0.5, "-0.500"),
            (1e6, "1.00e6"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(three_digits(value), expected);
        }
        assert_eq!(percent(0.0312), "3.12 %");
    }
}
