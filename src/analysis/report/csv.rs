//! The report as a table of raw numbers: a row per variant, seed and moment.

use std::fmt::Write;

use super::study::Study;
use crate::render::{ErrorEstimate, Interval};

const COLUMNS: [&str; 22] = [
    "variant",
    "seed",
    "samples_per_pixel",
    "seconds",
    "cpu_seconds",
    "build_seconds",
    "estimated_rmse",
    "estimated_rmse_low",
    "estimated_rmse_high",
    "estimated_relmse",
    "estimated_relmse_low",
    "estimated_relmse_high",
    "estimated_percentile_999",
    "estimated_percentile_999_low",
    "estimated_percentile_999_high",
    "measured_rmse",
    "measured_relmse",
    "true_rmse",
    "true_relmse",
    "measured_percentile_999",
    "true_percentile_999",
    "measured_pixels",
];

/// The report as CSV (RFC 4180, but with plain line feeds). Fields are empty where there is no number.
#[must_use]
pub fn to_csv(study: &Study) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for variant in study.measured() {
        for trial in &variant.trials {
            for measurement in &trial.measurements {
                let truth = measurement.true_errors(&study.reference);
                let mut numbers = vec![
                    measurement.samples_per_pixel,
                    measurement.seconds,
                    measurement.cpu_seconds,
                    trial.build_seconds,
                ];
                numbers.extend(estimates(measurement.estimated.as_ref()));
                numbers.extend([
                    measurement.measured.rmse(),
                    measurement.measured.relmse,
                    truth.mse.sqrt(),
                    truth.relmse,
                    measurement.measured_percentile_999,
                    truth.percentile_999,
                ]);
                let numbers: Vec<String> = numbers.into_iter().map(field).collect();
                let _ = writeln!(
                    text,
                    "{},{},{},{}",
                    quoted(&variant.name),
                    trial.seed,
                    numbers.join(","),
                    measurement.measured.compared_pixels
                );
            }
        }
    }
    text
}

fn estimates(estimate: Option<&ErrorEstimate>) -> [f64; 9] {
    estimate.map_or([f64::NAN; 9], |estimate| {
        let three = |Interval { value, low, high }| [value, low, high];
        let ([a, b, c], [d, e, f]) = (three(estimate.rmse), three(estimate.relmse));
        let [g, h, i] = three(estimate.percentile_999);
        [a, b, c, d, e, f, g, h, i]
    })
}

/// All digits.
fn field(number: f64) -> String {
    if number.is_nan() {
        String::new()
    } else {
        // With an exponent where there would be many zeros.
        format!("{number:?}")
    }
}

/// A text as a field.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;

    #[test]
    fn there_is_a_row_per_variant_seed_and_moment() {
        let text = to_csv(&test_data::study());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 2 * 3 * 4);
        assert_eq!(
            lines[1],
            "as the scene says,7,1.0,1.0,2.0,0.5,,,,,,,,,,0.2,0.16000000000000003,0.2,0.16000000000000003,0.625,0.625,2"
        );
        assert!(lines[4].starts_with("as the scene says,7,8.0,8.0,16.0,0.5,0.025,"));
        assert!(lines[13].starts_with("\"render.a=1, \"\"b\"\"\",7,1.0,"));
        for line in &lines[..13] {
            assert_eq!(line.split(',').count(), COLUMNS.len(), "{line}");
        }
    }
}
