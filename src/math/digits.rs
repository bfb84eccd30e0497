//! Numbers for people.

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

/// A number of two places, with a minus sign where that is not all zeros.
#[must_use]
pub fn signed(number: f64) -> String {
    let text = format!("{number:.2}");
    if text == "-0.00" {
        "0.00".to_owned()
    } else {
        text.replace('-', "−")
    }
}

/// A time with three digits: in milliseconds below a tenth of a second.
#[must_use]
pub fn time_in_words(seconds: f64) -> String {
    if (1e-7..0.1).contains(&seconds) {
        format!("{} ms", three_digits(1000.0 * seconds))
    } else {
        format!("{} s", three_digits(seconds))
    }
}

/// A number and what it is the number of: "1 face", "12 faces".
#[must_use]
pub fn counted(count: u64, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_plural() {
        let found = [0, 1, 2].map(|count| counted(count, "face", "faces"));
        assert_eq!(found, ["0 faces", "1 face", "2 faces"]);
    }

    #[test]
    fn numbers_that_are_shown_as_0_have_no_sign() {
        for (number, expected) in [
            (-0.004, "0.00"),
            (-0.5, "−0.50"),
            (0.25, "0.25"),
            (0.0, "0.00"),
        ] {
            assert_eq!(signed(number), expected);
        }
    }

    #[test]
    fn short_times_are_milliseconds() {
        for (seconds, expected) in [
            (0.0, "0 s"),
            (0.0184, "18.4 ms"),
            (0.000_5, "0.500 ms"),
            (0.25, "0.250 s"),
            (16.0, "16.0 s"),
        ] {
            assert_eq!(time_in_words(seconds), expected);
        }
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
