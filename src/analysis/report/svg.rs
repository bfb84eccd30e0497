//! The report as a picture.

use super::chart::{Axis, Chart, Curve, Level, Line, Point, Unit};
use super::study::{Study, Variant};
use super::summary::{Slope, Summary, SummaryPoint};
use crate::analysis::bench::Spread;
use crate::math::{counted, signed};
use crate::render::NOISE_TARGETS;

/// About so many letters fit into a line of the caption.
const CAPTION_WIDTH: usize = 118;
/// So many letters of a scene's name fit above the plot.
const TITLE_WIDTH: usize = 60;
/// Levels so many times as large as all that is shown, or as small, only make the curves small.
const NEAR_LEVELS: f64 = 30.0;

/// Noise against run time: for each variant what is true and what the renders estimate; for the scene as it is also with the
/// time of preparing.
#[must_use]
pub fn to_chart(study: &Study) -> Chart {
    let summaries: Vec<(&Variant, Summary)> = study
        .measured()
        .filter_map(|variant| Some((variant, Summary::of(variant, &study.reference)?)))
        .collect();
    let curves = summaries.iter().enumerate();
    let curves: Vec<Curve> = curves
        .flat_map(|(color, (variant, summary))| curves_of(variant, summary, color))
        .collect();
    Chart {
        title: format!(
            "Error against run time: {}",
            end_of(&study.scene_name, TITLE_WIDTH)
        ),
        x: Axis {
            label: "render time".to_owned(),
            unit: Unit::Seconds,
        },
        y: Axis {
            label: "noise (root of the relative mean square error)".to_owned(),
            unit: Unit::Percent,
        },
        levels: levels_near(&curves),
        curves,
        caption: caption(study, &summaries),
    }
}

/// The levels that are worth their place beside `curves`; none where nothing is shown.
fn levels_near(curves: &[Curve]) -> Vec<Level> {
    let shown = curves.iter().flat_map(Curve::shown);
    let ends = shown.map(|point| point.y.median).fold(None, |ends, y| {
        let (least, most) = ends.unwrap_or((y, y));
        Some((y.min(least), y.max(most)))
    });
    let is_near = |&y: &f64| {
        ends.is_some_and(|(least, most)| (least / NEAR_LEVELS..=most * NEAR_LEVELS).contains(&y))
    };
    let near = NOISE_TARGETS.into_iter().filter(is_near);
    near.map(|y| Level {
        y,
        label: format!("{:.0} %", 100.0 * y),
    })
    .collect()
}

/// The last letters of a text that is longer than `most`.
fn end_of(text: &str, most: usize) -> String {
    match text.chars().count().checked_sub(most) {
        None | Some(0) => text.to_owned(),
        Some(more) => std::iter::once('…')
            .chain(text.chars().skip(more + 1))
            .collect(),
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
        // What is no more than rounding has no place among errors of sampling.
        let points = summary.points.iter().filter(|point| !point.is_exact());
        points
            .map(|point| Point {
                x: x(point).median,
                y: point.true_noise(),
            })
            .collect()
    };
    let slope = slopes_in_words(summary.noise_slope, summary.cpu_noise_slope);
    let note = if summary.shows_another_picture {
        Some("another picture, difference included".to_owned())
    } else {
        slope
    };
    let points = summary.points.iter().filter(|point| !point.is_exact());
    let estimated = points.filter_map(|point| {
        Some(Point {
            x: point.seconds.median,
            y: point.estimated_noise()?,
        })
    });
    let mut curves = vec![
        curve(
            variant.name.clone(),
            note,
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

/// The slopes against wall and processor time, the first with the range over the seeds.
fn slopes_in_words(wall: Option<Slope>, cpu: Option<Slope>) -> Option<String> {
    let cpu = cpu.map_or_else(String::new, |cpu| {
        format!("; by CPU time {}", signed(cpu.value))
    });
    Some(format!("slope {}{cpu}", wall?.in_words()))
}

fn caption(study: &Study, summaries: &[(&Variant, Summary)]) -> Vec<String> {
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
    lines.extend(load(study, summaries));
    let cautions = study.reference.cautions();
    lines.extend(
        cautions
            .iter()
            .flat_map(|caution| wrapped(&format!("Beware: {caution}."))),
    );
    for (variant, summary) in summaries {
        let doubt = summary.doubt().into_iter();
        lines.extend(
            doubt.flat_map(|doubt| wrapped(&format!("Beware: {}: {doubt}.", variant.name))),
        );
    }
    let points = summaries.iter().flat_map(|(_, summary)| &summary.points);
    match points.filter(|point| point.is_exact()).count() {
        0 => {}
        1 => lines.push("1 point is as exact as numbers are, and is not shown".to_owned()),
        n => lines.push(format!(
            "{n} points are as exact as numbers are, and are not shown"
        )),
    }
    lines
}

/// How much of the processor the renders had, of all variants that which had least. One line whatever it was, so that the picture keeps its
/// size.
fn load(study: &Study, summaries: &[(&Variant, Summary)]) -> Option<String> {
    let shares = summaries
        .iter()
        .filter_map(|(_, summary)| summary.cpu_share);
    let least = shares.reduce(f64::min)?;
    let is_told = summaries
        .iter()
        .any(|(_, summary)| summary.load().is_some());
    let why = if is_told {
        ": other programs were busy, or the picture is small"
    } else {
        ""
    };
    Some(format!(
        "CPU seconds: {:.0} % of {} × wall seconds{why}",
        100.0 * least,
        counted(study.machine.threads as u64, "thread", "threads")
    ))
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
            "True errors: what is measured against the reference is σ²/N of the render plus σ²/N_ref of the reference, as the two are \
            independent; the reference's own σ²/N_ref, as it estimates it, is taken away."
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

/// Lines that are no longer than a caption's.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ').flat_map(pieces) {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > CAPTION_WIDTH {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&word);
    }
    lines.push(line);
    lines
}

/// A word, cut where it is longer than a line.
fn pieces(word: &str) -> Vec<String> {
    let letters: Vec<char> = word.chars().collect();
    if letters.is_empty() {
        return vec![String::new()];
    }
    letters
        .chunks(CAPTION_WIDTH)
        .map(|piece| piece.iter().collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::{Origin, test_data};

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
        let note = "slope −1.00 (−1.00 – −1.00); by CPU time −1.00";
        assert_eq!(chart.curves[0].note.as_deref(), Some(note));
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
        let caption = to_chart(&study).caption.join(" ");
        assert!(
            caption.contains("2.00 % noise, RMSE 0.100")
                && caption
                    .contains("the reference's own σ²/N_ref, as it estimates it, is taken away"),
            "{caption}"
        );
    }

    #[test]
    fn long_captions_are_wrapped_between_words() {
        let text = "word ".repeat(100);
        let lines = wrapped(text.trim());
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= CAPTION_WIDTH));
        assert_eq!(lines.join(" "), text.trim());
        let path = "/folder".repeat(60);
        let lines = wrapped(&path);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= CAPTION_WIDTH));
        assert_eq!(lines.concat(), path);
    }

    /// What spoils the curves is said where they are, as the picture may be shown without the page.
    #[test]
    fn the_caption_bewares_of_what_spoils_the_curves() {
        let mut study = test_data::study();
        study.variants[1].shows_another_picture = true;
        study.reference = test_data::file_reference(None);
        if let Origin::File {
            is_rounded,
            shared_seed,
            ..
        } = &mut study.reference.origin
        {
            (*is_rounded, *shared_seed) = (true, Some(8));
        }
        for trial in &mut study.variants[1].trials {
            trial.stats.threads = 4;
        }
        for measurement in &mut study.variants[1].trials[0].measurements {
            measurement.measured.relmse += 1.0;
        }
        let chart = to_chart(&study);
        let caption = chart.caption.join(" ");
        for part in [
            "Beware: the reference is a PNG: it holds what a screen shows",
            "Beware: the reference was rendered with seed 8",
            "CPU seconds: 50 % of 2 threads × wall seconds: other programs were busy",
        ] {
            assert!(caption.contains(part), "{part}: {caption}");
        }
        let note = chart.curves[3].note.as_deref();
        assert!(
            note.is_some_and(|note| note.starts_with("another picture")),
            "{note:?}"
        );
    }

    /// Renders that are exact but for rounding have no curve, so the axis is not stretched over seven powers of ten that nobody looks at.
    #[test]
    fn what_is_exact_or_far_away_does_not_stretch_the_axis() {
        let mut study = test_data::study();
        let scaled = |study: &mut Study, factor: f64| {
            let trials = study.variants.iter_mut().flat_map(|v| &mut v.trials);
            for measurement in trials.flat_map(|trial| &mut trial.measurements) {
                measurement.measured.mse *= factor;
                measurement.measured.relmse *= factor;
                measurement.estimated = None;
            }
        };
        // Noise of 40 to 5 % becomes 0.04 to 0.005 %, and that becomes 4e-7 to 5e-8.
        scaled(&mut study, 1e-6);
        let chart = to_chart(&study);
        assert_eq!(
            chart.levels.iter().map(|level| level.y).collect::<Vec<_>>(),
            [0.01]
        );
        assert!(
            chart
                .curves
                .iter()
                .any(|curve| curve.shown().next().is_some())
        );
        scaled(&mut study, 1e-6);
        let chart = to_chart(&study);
        assert!(chart.curves.iter().all(|curve| curve.points.is_empty()));
        assert!(chart.levels.is_empty(), "there is nothing to compare with");
        let said = "8 points are as exact as numbers are, and are not shown";
        assert!(
            chart.caption.iter().any(|line| line == said),
            "{:?}",
            chart.caption
        );
    }

    #[test]
    fn long_names_of_scenes_keep_their_end() {
        let mut study = test_data::study();
        study.scene_name = format!("{}/room.toml", "/folder".repeat(60));
        let title = to_chart(&study).title;
        assert!(
            title.ends_with("/folder/room.toml") && title.contains(": …"),
            "{title}"
        );
        assert!(title.chars().count() < 90);
    }
}
