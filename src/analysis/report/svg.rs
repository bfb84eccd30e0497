//! The report as a picture.

use super::chart::{Axis, Chart, Curve, Level, Line, Point, Unit};
use super::study::{Study, Variant};
use super::summary::{Summary, SummaryPoint};
use crate::analysis::bench::Spread;
use crate::render::NOISE_TARGETS;

/// About so many letters fit into a line of the caption.
const CAPTION_WIDTH: usize = 118;

/// Noise against run time: for each variant what is true and what the renders estimate; for the scene as it is also with the
/// time of preparing.
#[must_use]
pub fn to_chart(study: &Study) -> Chart {
    let mut curves = Vec::new();
    for (color, variant) in study.measured().enumerate() {
        if let Some(summary) = Summary::of(variant, &study.reference) {
            curves.extend(curves_of(variant, &summary, color));
        }
    }
    Chart {
        title: format!("Error against run time: {}", study.scene_name),
        x: Axis {
            label: "render time".to_owned(),
            unit: Unit::Seconds,
        },
        y: Axis {
            label: "noise (root of the relative mean square error)".to_owned(),
            unit: Unit::Percent,
        },
        curves,
        levels: NOISE_TARGETS
            .iter()
            .map(|&y| Level {
                y,
                label: format!("{:.0} %", 100.0 * y),
            })
            .collect(),
        caption: caption(study),
    }
}

fn curves_of(variant: &Variant, summary: &Summary, color: usize) -> Vec<Curve> {
    let curve = |name: String, note, line, points| Curve {
        name,
        note,
        color,
        line,
        band: line == Line::Solid,
        points,
    };
    let noise = |x: fn(&SummaryPoint) -> Spread| {
        let points = summary.points.iter();
        points
            .map(|point| Point {
                x: x(point).median,
                y: point.true_noise(),
            })
            .collect()
    };
    let slope = summary
        .noise_slope
        .map(|slope| format!("slope {}", signed(slope)));
    let estimated = summary.points.iter().filter_map(|point| {
        Some(Point {
            x: point.seconds.median,
            y: point.estimated_noise()?,
        })
    });
    let mut curves = vec![
        curve(
            variant.name.clone(),
            slope,
            Line::Solid,
            noise(|point| point.seconds),
        ),
        curve(
            "… estimated".to_owned(),
            None,
            Line::Dashed,
            estimated.collect(),
        ),
    ];
    if color == 0 {
        let points = noise(|point| point.seconds_with_build);
        let name = "… with build time".to_owned();
        curves.push(curve(name, None, Line::Dotted, points));
    }
    curves
}

/// A number of two places with a minus sign.
pub(super) fn signed(number: f64) -> String {
    format!("{number:.2}").replace('-', "−")
}

fn caption(study: &Study) -> Vec<String> {
    let mut lines = vec![format!(
        "RayMini {} on {}",
        env!("CARGO_PKG_VERSION"),
        study.machine.describe()
    )];
    if let Some(base) = study.measured().next() {
        lines.extend(wrapped(&telling_settings(study, base).join(", ")));
        let seeds: Vec<String> = base.trials.iter().map(|t| t.seed.to_string()).collect();
        lines.extend(wrapped(&format!(
            "Median and range of {}: {}",
            seeds_in_words(base.trials.len(), study.seeds),
            seeds.join(", ")
        )));
    }
    lines.extend(wrapped(&format!(
        "Reference: {}",
        study.reference.describe()
    )));
    lines.extend(wrapped(correction(study)));
    lines
}

/// The size of the picture, and those settings of the base that must be known because they are not the usual ones or differ in a variant.
fn telling_settings(study: &Study, base: &Variant) -> Vec<String> {
    let usual = settings(&study.default_settings);
    let of_variants: Vec<Vec<String>> = study.measured().map(|v| settings(&v.settings)).collect();
    let has_key = |setting: &str, keys: &[&str]| {
        let key = setting.split(" =").next();
        key.is_some_and(|key| keys.contains(&key))
    };
    let tells = |setting: &String| {
        has_key(setting, &["mode", "samples_per_pixel"])
            || !usual.contains(setting)
            || of_variants.iter().any(|of| !of.contains(setting))
    };
    let image = &study.reference.image;
    let size = format!("{}×{} pixels", image.width, image.height);
    let others = settings(&base.settings).into_iter();
    let others = others.filter(|setting| !has_key(setting, &["width", "height", "seed"]));
    std::iter::once(size).chain(others.filter(tells)).collect()
}

/// How many seeds there are, of how many there are to be.
pub(super) fn seeds_in_words(done: usize, planned: u32) -> String {
    match (done, planned as usize) {
        (1, 1) => "1 seed".to_owned(),
        (done, planned) if done == planned => format!("{done} seeds"),
        (done, planned) => format!("{done} of {planned} seeds"),
    }
}

/// How the true error comes from what is measured.
pub(super) fn correction(study: &Study) -> &'static str {
    match study.reference.relmse() {
        None => "True errors are distances from the reference, with its own error in them.",
        Some(own) if own.value > 0.0 => {
            "True errors: mean squares against the reference, less the reference's own (σ²/N + σ²/N_ref − σ²/N_ref)."
        }
        Some(_) => "True errors are distances from the reference.",
    }
}

/// Dotted keys with their values, tables within tables included.
pub(super) fn settings(table: &toml::Table) -> Vec<String> {
    let mut lines = Vec::new();
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => {
                let inner = settings(inner);
                lines.extend(inner.into_iter().map(|line| format!("{key}.{line}")));
            }
            toml::Value::String(text) => lines.push(format!("{key} = {text}")),
            value => lines.push(format!("{key} = {value}")),
        }
    }
    lines
}

/// Lines that are not much longer than a caption's.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ') {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > CAPTION_WIDTH {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;

    #[test]
    fn each_variant_has_a_true_and_an_estimated_curve() {
        let mut study = test_data::study();
        let mirror = study.variants[1].settings.get_mut("mirror");
        *mirror.expect("is there") = toml::Value::Boolean(false);
        let chart = to_chart(&study);
        let curves: Vec<_> = chart
            .curves
            .iter()
            .map(|curve| (&*curve.name, curve.line, curve.points.len(), curve.color))
            .collect();
        assert_eq!(
            curves,
            [
                ("as the scene says", Line::Solid, 4, 0),
                ("… estimated", Line::Dashed, 2, 0),
                ("… with build time", Line::Dotted, 4, 0),
                ("render.a=1, \"b\"", Line::Solid, 4, 1),
                ("… estimated", Line::Dashed, 2, 1),
            ]
        );
        assert_eq!(chart.curves[0].note.as_deref(), Some("slope −1.00"));
        assert_eq!(chart.curves[2].points[3].x, 8.5);
        let levels: Vec<_> = chart.levels.iter().map(|level| &*level.label).collect();
        assert_eq!(levels, ["10 %", "3 %", "1 %"]);
        let caption = chart.caption.join("\n");
        for part in [
            "on A CPU, 2 threads, linux",
            // Mirrors are as usual, but not in the variant.
            "2×1 pixels, mode = path, mirror = true, stop.noise = 0.03\n",
            "3 seeds: 7, 8, 9",
            "exact answer",
        ] {
            assert!(caption.contains(part), "{part}: {caption}");
        }
    }

    #[test]
    fn the_caption_tells_the_error_of_the_reference() {
        let mut study = test_data::study();
        study.reference = test_data::rendered_reference(0.1, 0.0004);
        let caption = caption(&study).join(" ");
        assert!(
            caption.contains("2.00 % noise, RMSE 0.100")
                && caption.contains("less the reference's own ("),
            "{caption}"
        );
    }

    #[test]
    fn long_captions_are_wrapped_between_words() {
        let text = "word ".repeat(100);
        let lines = wrapped(text.trim());
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= CAPTION_WIDTH));
        assert_eq!(lines.join(" "), text.trim());
    }
}
