//! A logarithmic axis: what it spans, its ticks and their labels.
//!
//! Places are exponents of ten, so that no number is too large or too small. Logarithms are libm's, which are the same on
//! every machine.

use libm::log10;

/// Least distance between data and the ends of the axis, in decades: a marker does not lie on the frame.
const MARGIN: f64 = 0.02;

/// Digits at which an axis may end, and that have a label where few powers of ten are in sight.
const ROUND_DIGITS: [u8; 3] = [1, 2, 5];

/// Decades from which powers of ten alone are labelled: at least two of them are in sight.
const LABELS_OF_POWERS_ONLY: f64 = 2.0;

/// Least length of a decade with ticks that have no label, in pixels: the nearest of them are 2 pixels apart.
const DECADE_OF_TICKS: f64 = 40.0;

/// Figures of an exponent.
const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// What the numbers of an axis are, which decides how they are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// As they are.
    Plain,
    /// Seconds, `0.1 s`.
    Seconds,
    /// Parts of one, as percentages: 0.1 is `10 %`.
    Percent,
}

impl Unit {
    /// `digit` · 10^`decade` as people write it.
    fn label(self, digit: u8, decade: i32) -> String {
        match self {
            Self::Plain => number(digit, decade),
            Self::Seconds => number(digit, decade) + " s",
            Self::Percent => number(digit, decade + 2) + " %",
        }
    }
}

/// `digit` · 10^`decade` in figures; as a power where those are many.
fn number(digit: u8, decade: i32) -> String {
    if (-4..=4).contains(&decade) {
        let places = decade.min(0).unsigned_abs() as usize;
        return format!("{:.places$}", f64::from(digit) * 10_f64.powi(decade));
    }
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    let exponent: String = decade.to_string().chars().map(raised).collect();
    if digit == 1 {
        format!("10{exponent}")
    } else {
        format!("{digit}·10{exponent}")
    }
}

/// The part of a logarithmic axis that is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Exponent at the low end.
    low: f64,
    /// Exponent at the high end, larger.
    high: f64,
}

/// A place on an axis where a grid line is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// How far along the axis, from 0 to 1.
    pub share: f64,
    /// Whether it is a power of ten.
    pub power: bool,
    /// What is written at it.
    pub label: Option<String>,
}

impl Scale {
    /// The least range with round ends around positive, finite numbers; a decade to each side of 1 where there are none.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let ends = values.map(log10).fold(None, |ends, exponent| {
            let (least, greatest) = ends.unwrap_or((exponent, exponent));
            Some((exponent.min(least), exponent.max(greatest)))
        });
        let Some((least, greatest)) = ends else {
            return Self {
                low: -1.0,
                high: 1.0,
            };
        };
        let (least, greatest) = (least - MARGIN, greatest + MARGIN);
        let round = |below: f64| ROUND_DIGITS.map(|digit| below.floor() + log10(f64::from(digit)));
        let low = round(least).into_iter().rfind(|&end| end <= least);
        let high = round(greatest).into_iter().find(|&end| end >= greatest);
        Self {
            low: low.unwrap_or(least.floor()),
            high: high.unwrap_or(greatest.floor() + 1.0),
        }
    }

    /// How far along the axis a number is, from 0 to 1; one beyond an end, or without a logarithm, is at that end.
    pub fn share(self, value: f64) -> f64 {
        self.share_of_exponent(log10(value.max(0.0)))
            .clamp(0.0, 1.0)
    }

    fn share_of_exponent(self, exponent: f64) -> f64 {
        (exponent - self.low) / (self.high - self.low)
    }

    /// The ticks of an axis of this length whose labels need so much room, both in pixels.
    pub fn ticks(self, unit: Unit, length: f64, room: f64) -> Vec<Tick> {
        let decades = self.high - self.low;
        let decade_length = length / decades;
        let all = decade_length >= DECADE_OF_TICKS;
        // Of many powers every second, third, … has a label, 1 among them.
        let stride = whole((room / decade_length).ceil());
        let mut ticks = Vec::new();
        for decade in whole(self.low.floor())..=whole(self.high.floor()) {
            let power_label = decade % stride == 0;
            for digit in 1..=9 {
                let exponent = f64::from(decade) + log10(f64::from(digit));
                let labelled = if digit == 1 {
                    power_label
                } else {
                    decades < LABELS_OF_POWERS_ONLY && ROUND_DIGITS.contains(&digit)
                };
                if (self.low..=self.high).contains(&exponent) && (all || labelled) {
                    ticks.push(Tick {
                        share: self.share_of_exponent(exponent),
                        power: digit == 1,
                        label: labelled.then(|| unit.label(digit, decade)),
                    });
                }
            }
        }
        ticks
    }
}

/// A whole number as such.
#[expect(
    clippy::cast_possible_truncation,
    reason = "exponents of f64, and counts of them, are small"
)]
fn whole(value: f64) -> i32 {
    value as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(values: &[f64]) -> Scale {
        Scale::around(values.iter().copied())
    }

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().filter_map(|t| t.label.as_deref()).collect()
    }

    #[test]
    fn chart_labels_are_what_readers_expect() {
        for (unit, digit, decade, expected) in [
            (Unit::Seconds, 1, -1, "0.1 s"),
            (Unit::Seconds, 1, 0, "1 s"),
            (Unit::Seconds, 5, 1, "50 s"),
            (Unit::Percent, 1, -1, "10 %"),
            (Unit::Percent, 1, -2, "1 %"),
            (Unit::Percent, 2, -4, "0.02 %"),
            (Unit::Plain, 1, -4, "0.0001"),
            (Unit::Plain, 2, 4, "20000"),
            (Unit::Plain, 1, 5, "10⁵"),
            (Unit::Seconds, 5, -12, "5·10⁻¹² s"),
        ] {
            assert_eq!(unit.label(digit, decade), expected);
        }
    }

    #[test]
    fn chart_ranges_end_at_round_numbers_beyond_the_data() {
        // 0.12 to 87 lies within 0.1 to 100; 1 and 100 themselves need room beside their markers.
        for (values, low, high) in [
            (vec![87.0, 0.12, 3.0], 0.1, 100.0),
            (vec![1.0, 100.0], 0.5, 200.0),
            (vec![3.0], 2.0, 5.0),
            (vec![0.06, 0.19], 0.05, 0.2),
            (vec![1e-4, 1e4], 5e-5, 2e4),
            (vec![], 0.1, 10.0),
        ] {
            let scale = scale(&values);
            assert!((scale.low - log10(low)).abs() < 1e-12, "{values:?}");
            assert!((scale.high - log10(high)).abs() < 1e-12, "{values:?}");
        }
    }

    #[test]
    fn chart_shares_grow_with_the_logarithm_and_stay_on_the_axis() {
        let scale = scale(&[0.12, 87.0]);
        for (value, share) in [
            (0.1, 0.0),
            (1.0, 1.0 / 3.0),
            (10.0, 2.0 / 3.0),
            (100.0, 1.0),
        ] {
            assert!((scale.share(value) - share).abs() < 1e-12, "{value}");
        }
        for (value, share) in [(-1.0, 0.0), (0.0, 0.0), (1e-9, 0.0), (f64::INFINITY, 1.0)] {
            assert_eq!(scale.share(value), share);
        }
    }

    #[test]
    fn chart_ticks_are_powers_of_ten_and_their_multiples() {
        let ticks = scale(&[0.12, 87.0]).ticks(Unit::Seconds, 480.0, 66.0);
        assert_eq!(labels(&ticks), ["0.1 s", "1 s", "10 s", "100 s"]);
        assert_eq!(ticks.len(), 3 * 9 + 1);
        assert_eq!(ticks.iter().filter(|tick| tick.power).count(), 4);
        assert_eq!((ticks[0].share, ticks[27].share), (0.0, 1.0));
        // The tick at 2, the eleventh, is 1.301 decades above 0.1.
        assert!((ticks[10].share - 1.301_03 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn chart_short_axes_have_labels_at_2_and_5() {
        let ticks = scale(&[0.06, 0.19]).ticks(Unit::Percent, 400.0, 22.0);
        assert_eq!(labels(&ticks), ["5 %", "10 %", "20 %"]);
        let ticks = scale(&[3.0]).ticks(Unit::Plain, 400.0, 22.0);
        assert_eq!(labels(&ticks), ["2", "5"]);
        assert_eq!(ticks.len(), 4);
    }

    #[test]
    fn chart_long_axes_leave_labels_out_and_then_ticks() {
        let ticks = scale(&[1e-4, 1e4]).ticks(Unit::Plain, 480.0, 66.0);
        assert_eq!(labels(&ticks), ["0.0001", "0.01", "1", "100", "10000"]);
        assert!(ticks.iter().any(|tick| !tick.power));
        let ticks = scale(&[f64::from_bits(1), f64::MAX]).ticks(Unit::Plain, 480.0, 66.0);
        assert!((5..=8).contains(&ticks.len()), "{ticks:?}");
        assert!(labels(&ticks).contains(&"1"));
    }
}
