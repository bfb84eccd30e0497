//! The report as a page to read.

use super::digits::samples;
use super::fit::TimeTo;
use super::reference::{Origin, ROUNDED};
use super::study::{Study, Variant};
use super::summary::{Honesty, Summary, SummaryPoint, Target};
use super::svg::{correction, seeds_in_words, settings, signed};
use crate::analysis::bench::Spread;
use crate::math::{percent, three_digits};
use crate::render::NOISE_TARGETS;

/// From this share of a measured mean square on, true errors depend much on how well the reference's own error is known.
const LARGE_SHARE: f64 = 0.25;

const NONE: &str = "—";

/// The report as Markdown; the picture is `report.svg` beside it.
#[must_use]
pub fn to_markdown(study: &Study) -> String {
    let variants: Vec<(&Variant, Summary)> = study
        .measured()
        .filter_map(|variant| Some((variant, Summary::of(variant, &study.reference)?)))
        .collect();
    let mut parts = vec![format!("# Error against run time: {}", study.scene_name)];
    parts.push("![Noise against render time](report.svg)".to_owned());
    if let Some((variant, summary)) = variants.first() {
        parts.push(in_short(study, variant, summary));
    }
    for (variant, summary) in &variants {
        if let Some(doubt) = summary.doubt() {
            parts.push(format!("**{}**: {doubt}.", code(variant, &variants)));
        }
    }
    parts.push(how_to_read(study));
    parts.push("## Summary".to_owned());
    parts.push(summaries(&variants));
    parts.extend(targets(&variants));
    parts.push("## Points".to_owned());
    for (variant, summary) in &variants {
        if variants.len() > 1 {
            parts.push(format!("### {}", code(variant, &variants)));
        }
        parts.push(points(summary));
    }
    parts.push("## Numerical failures".to_owned());
    parts.push(failures(&variants));
    parts.push("## Reference".to_owned());
    parts.push(reference(study, &variants));
    parts.push("## Settings".to_owned());
    parts.push(machine_and_settings(study, &variants));
    parts.join("\n\n") + "\n"
}

/// What came out, in a paragraph.
fn in_short(study: &Study, variant: &Variant, summary: &Summary) -> String {
    let seeds = seeds_in_words(variant.trials.len(), study.seeds);
    let Some(last) = summary.points.last() else {
        return format!("Rendered with {seeds}; nothing could be measured.");
    };
    let estimated = last.estimated_noise().map_or_else(String::new, |noise| {
        format!(
            "; the renders themselves say {}, without a reference",
            percent(noise.median)
        )
    });
    let slope = summary.noise_slope.map_or_else(String::new, |slope| {
        format!(
            " Noise falls as render time to the power of {}.",
            signed(slope)
        )
    });
    let unfinished = if study.next().is_some() {
        " **Not all renders are done yet.**"
    } else {
        ""
    };
    format!(
        "With {} samples per pixel and after {} s of rendering the picture has **{}** (median of {seeds}){estimated}.{slope}{unfinished}",
        samples(last.samples_per_pixel),
        three_digits(last.seconds.median),
        last.noise_in_words(),
    )
}

fn how_to_read(study: &Study) -> String {
    format!(
        "## How to read it\n\n\
        Both axes are logarithmic, so a law such as “four times the time, half the noise” is a straight line, here of slope −0.5. \
        *Noise* is the root of the relative mean square error: errors squared, divided by the true value squared plus 0.01, \
        averaged over pixels and channels. The solid line is the true noise: its markers are medians over the seeds, its band \
        reaches from the least to the largest. The dashed line is what the renders estimate by themselves while they run; where \
        it lies on the solid one, the estimate is honest. The dotted line adds the time of preparing the scene. Of two lines, the \
        lower one has less noise after the same time, the one farther left takes less time for the same noise. The slope is \
        fitted to the points from 4 samples on.\n\n{}",
        correction(study)
    )
}

/// A Markdown table.
fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |", cells.join(" | "));
    let head: Vec<String> = head.iter().map(|&cell| cell.to_owned()).collect();
    // The first column holds names, or what the others depend on.
    let rule: Vec<String> = (0..head.len())
        .map(|column| if column == 0 { ":--" } else { "--:" }.to_owned())
        .collect();
    let mut lines = vec![line(&head), line(&rule)];
    lines.extend(rows.iter().map(|row| line(row)));
    lines.join("\n")
}

/// The name of a variant; those that are assignments as code, so that nothing in them means anything to Markdown.
fn code(variant: &Variant, variants: &[(&Variant, Summary)]) -> String {
    let is_base = variants
        .first()
        .is_some_and(|(base, _)| std::ptr::eq(*base, variant));
    if is_base {
        variant.name.clone()
    } else {
        // In a table a bar ends the cell, in code too.
        format!("`{}`", variant.name.replace('|', "\\|"))
    }
}

fn summaries(variants: &[(&Variant, Summary)]) -> String {
    let rows = variants.iter().map(|(variant, summary)| {
        let slope = |slope: Option<f64>| slope.map_or(NONE.to_owned(), signed);
        let number = |value: f64| {
            if value.is_finite() {
                three_digits(value)
            } else {
                NONE.to_owned()
            }
        };
        let [ratios, held] = summary
            .honesty
            .map_or_else(|| [NONE; 2].map(str::to_owned), honesty);
        let mut row = vec![
            code(variant, variants),
            number(summary.build_seconds.median),
            slope(summary.noise_slope),
            slope(summary.slope),
            ratios,
            held,
            number(summary.efficiency.wall),
            number(summary.efficiency.cpu),
        ];
        row.extend(summary.time_to.map(time));
        row
    });
    let times = NOISE_TARGETS.map(|noise| format!("to {:.0} % (s)", 100.0 * noise));
    let mut head = vec![
        "variant",
        "build (s)",
        "slope of noise",
        "slope of RMSE",
        "estimated / true",
        "95 % intervals held",
        "efficiency, wall",
        "efficiency, CPU",
    ];
    head.extend(times.iter().map(String::as_str));
    table(&head, &rows.collect::<Vec<_>>())
        + "\n\nEstimates are compared with true errors, RMSE and noise, at all points from 16 samples on: the smallest and largest \
        ratio of their medians, and how often the intervals of the renders held the truth. Efficiency is 1 / (relMSE · seconds) at the last point. Times are seconds of rendering until the median noise is \
        that low: between points by interpolation, *predicted* beyond the last point by following the slope, ≤ where already \
        the first point is below."
}

/// What it took to the noise at which renders stop, where any stops at one.
fn targets(variants: &[(&Variant, Summary)]) -> Option<String> {
    let row = |variant: &Variant, target: Target| {
        let took = target.took.map_or_else(
            || [NONE; 3].map(str::to_owned),
            |took| {
                let with_range = |value: f64, [least, most]: [f64; 2]| {
                    let [value, least, most] = [value, least, most].map(three_digits);
                    format!("{value} ({least} – {most})")
                };
                [
                    samples(took.samples_per_pixel),
                    with_range(took.seconds, took.seconds_range),
                    with_range(took.cpu_seconds, took.cpu_seconds_range),
                ]
            },
        );
        let reached = format!("{} of {}", target.reached, target.renders);
        let start = [code(variant, variants), percent(target.noise), reached];
        start.into_iter().chain(took).collect()
    };
    let rows: Vec<Vec<String>> = variants
        .iter()
        .filter_map(|(variant, summary)| Some(row(variant, summary.target?)))
        .collect();
    let head = [
        "variant",
        "stops at noise",
        "renders there",
        "samples per pixel",
        "seconds (range)",
        "CPU seconds (range)",
    ];
    (!rows.is_empty()).then(|| {
        table(&head, &rows)
            + "\n\nWhat it took the renders to the noise at which they stop, by their own estimate: medians of those that are there."
    })
}

fn honesty(honesty: Honesty) -> [String; 2] {
    let [least, most] = honesty.estimated_over_true;
    let ratios = if least.is_finite() && most.is_finite() {
        format!("{least:.2} – {most:.2}")
    } else {
        NONE.to_owned()
    };
    [
        ratios,
        format!("{} of {}", honesty.intervals_held, honesty.intervals),
    ]
}

fn time(time: Option<TimeTo>) -> String {
    let Some(TimeTo {
        seconds,
        predicted,
        at_most,
    }) = time
    else {
        return NONE.to_owned();
    };
    let seconds = three_digits(seconds);
    match (predicted, at_most) {
        (true, _) => format!("{seconds} (predicted)"),
        (false, true) => format!("≤ {seconds}"),
        (false, false) => seconds,
    }
}

fn points(summary: &Summary) -> String {
    let with_range = |spread: Spread, text: fn(f64) -> String| {
        format!(
            "{} ({} – {})",
            text(spread.median),
            text(spread.min),
            text(spread.max)
        )
    };
    let row = |point: &SummaryPoint| {
        let true_noise = point.true_noise();
        let estimated = point.estimated.map(|estimated| {
            let [low, high] = estimated.relmse_interval.map(f64::sqrt);
            let noise = estimated.relmse.median.sqrt();
            let ratio = noise / true_noise.median;
            [
                format!("{} ({} – {})", percent(noise), percent(low), percent(high)),
                if ratio.is_finite() {
                    format!("{ratio:.2}")
                } else {
                    NONE.to_owned()
                },
                three_digits(estimated.rmse.median),
                {
                    let [low, high] = estimated.percentile_999_interval.map(three_digits);
                    let median = three_digits(estimated.percentile_999.median);
                    format!("{median} ({low} – {high})")
                },
            ]
        });
        let [estimated_noise, ratio, estimated_rmse, estimated_percentile] =
            estimated.unwrap_or_else(|| [NONE; 4].map(str::to_owned));
        vec![
            samples(point.samples_per_pixel),
            with_range(point.seconds, three_digits),
            three_digits(point.cpu_seconds.median),
            with_range(true_noise, percent),
            estimated_noise,
            ratio,
            three_digits(point.true_rmse.median),
            estimated_rmse,
            three_digits(point.true_percentile_999.median),
            estimated_percentile,
        ]
    };
    table(
        &[
            "samples per pixel",
            "seconds (range)",
            "CPU seconds",
            "true noise (range)",
            "estimated noise (95 % interval)",
            "estimated / true",
            "true RMSE",
            "estimated RMSE",
            "true 99.9 %",
            "estimated 99.9 % (95 % interval)",
        ],
        &summary.points.iter().map(row).collect::<Vec<_>>(),
    ) + "\n\nThe last two columns are what the error of a pixel's worst channel exceeds in one pixel of a thousand, in units of radiance."
}

fn failures(variants: &[(&Variant, Summary)]) -> String {
    let rows = variants.iter().map(|(variant, summary)| {
        vec![
            code(variant, variants),
            summary.non_finite_samples.to_string(),
            summary.negative_samples.to_string(),
            summary.clamped.samples.to_string(),
            percent(summary.clamped.energy_share),
            summary.unmeasured_pixels.to_string(),
        ]
    });
    table(
        &[
            "variant",
            "samples infinite or not a number",
            "negative samples",
            "clamped samples",
            "light taken by clamping",
            "pixels left out of errors",
        ],
        &rows.collect::<Vec<_>>(),
    ) + "\n\nSamples are counted over all renders. They stay in the pictures, and pixels that are not finite are left out of the \
        errors."
}

fn reference(study: &Study, variants: &[(&Variant, Summary)]) -> String {
    let mut sentences = vec![format!(
        "Renders are measured against {}.",
        study.reference.describe()
    )];
    if let Origin::Rendered {
        light_sampling,
        render_seconds,
        non_finite_samples,
        ..
    } = &study.reference.origin
    {
        let own_way = study.variants[0].scene.render.light_sampling;
        let independent = match light_sampling {
            Some(way) if *way == own_way => {
                "Its seed is none of those that are measured; its way of finding light is the scene's, as another was tried and was worse"
            }
            Some(_) => "Its seed and its way of finding light are not those of the scene",
            None => "Its seed is none of those that are measured",
        };
        sentences.push(format!(
            "{independent}; no sample of it is clamped. It took {} s to render.",
            three_digits(*render_seconds)
        ));
        if *non_finite_samples > 0 {
            sentences.push(format!(
                "**{non_finite_samples} of its samples are infinite or not a number.**"
            ));
        }
    }
    if study.reference.is_rounded() {
        sentences.push(format!("**Beware: {ROUNDED}.**"));
    }
    let own = study.reference.known_errors().map(|[_, relmse]| relmse);
    let shares = variants.iter().filter_map(|(_, summary)| {
        let last = summary.points.last()?;
        Some(own? / last.measured_relmse.median)
    });
    let share = shares.fold(0.0, f64::max);
    if share > LARGE_SHARE {
        sentences.push(format!(
            "**Up to {} of the measured mean square is the reference's own: true errors are as uncertain as its estimate. A \
            reference of more samples helps.**",
            percent(share.min(1.0))
        ));
    }
    if variants.len() > 1 {
        sentences.push(
            "A variant that shows something else than the scene as it is has the difference in its true error."
                .to_owned(),
        );
    }
    sentences.join(" ")
}

fn machine_and_settings(study: &Study, variants: &[(&Variant, Summary)]) -> String {
    let mut parts = vec![format!(
        "RayMini {} on {}. Variants took turns, seed by seed. Measuring is not in the times.",
        env!("CARGO_PKG_VERSION"),
        study.machine.describe()
    )];
    if let Some((base, _)) = variants.first() {
        parts.push(format!(
            "```text\n{}\n```",
            settings(&base.settings).join("\n")
        ));
    }
    parts.push(
        "All numbers are in [report.json](report.json), and those of every render in [report.csv](report.csv).".to_owned(),
    );
    parts.join("\n\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;
    use crate::render::Ending;

    #[test]
    fn the_page_has_the_numbers_in_tables() {
        let page = to_markdown(&test_data::study());
        for line in [
            "![Noise against render time](report.svg)",
            "With 8 samples per pixel and after 8.00 s of rendering the picture has **5.00 % noise** (median of 3 seeds); \
             the renders themselves say 5.00 %, without a reference. Noise falls as render time to the power of −1.00.",
            "| as the scene says | 0.500 | −1.00 | −1.00 | — | — | 50.0 | 25.0 | 4.00 | 13.3 (predicted) | 40.0 (predicted) |",
            "### `render.a=1, \"b\"`",
            "| 1 | 1.00 (1.00 – 1.00) | 2.00 | 40.0 % (32.0 % – 48.0 %) | — | — | 0.200 | — | 0.625 | — |",
            "| as the scene says | 6 | 0 | 0 | 0 % | 0 |",
            "stop.noise = 0.03",
        ] {
            assert!(page.lines().any(|l| l == line), "{line}: {page}");
        }
        for row in page.lines().filter(|line| line.starts_with('|')) {
            assert!(row.ends_with('|'), "{row}");
        }
        assert!(
            !page.contains("NaN") && !page.contains("done yet"),
            "{page}"
        );
    }

    #[test]
    fn the_page_has_the_time_to_the_noise_that_was_asked_for() {
        let mut study = test_data::study();
        assert!(!to_markdown(&study).contains("stops at noise"));
        study.variants[0].scene.render.stop.noise = Some(0.03);
        study.variants[0].trials[1].stats.ending = Ending::Noise;
        study.variants[0].trials[1].stats.render_seconds = 2.0;
        study.variants[0].trials[1].stats.samples_per_pixel = 24.0;
        let page = to_markdown(&study);
        let row = "| as the scene says | 3.00 % | 1 of 3 | 24 | 2.00 (2.00 – 2.00) | 0 (0 – 0) |";
        assert!(page.lines().any(|line| line == row), "{page}");
    }

    #[test]
    fn the_page_warns_of_a_noisy_reference_and_of_renders_to_come() {
        let mut study = test_data::study();
        study.variants[1].trials.pop();
        study.reference = test_data::rendered_reference(0.01, 0.001);
        let page = to_markdown(&study);
        assert!(page.contains("**Not all renders are done yet.**"), "{page}");
        assert!(page.contains("**Up to 40.0 % of the measured"), "{page}");
        study.reference = test_data::rendered_reference(0.01, 0.0001);
        let page = to_markdown(&study);
        assert!(
            !page.contains("**Up to") && !page.contains("half of"),
            "{page}"
        );
        study.reference = test_data::file_reference(Some(0.0025));
        let page = to_markdown(&study);
        let expected = "\n\n**as the scene says**: from 8 samples per pixel on, more than half of the mean square";
        assert!(page.contains(expected), "{page}");
        assert!(
            page.contains("before.exr; its own error, estimated: 5.00 % noise, RMSE 0.0250."),
            "{page}"
        );
    }
}
