//! The report as a page to read.

mod escape;
#[cfg(test)]
mod tests;

use super::digits::samples;
use super::files::PICTURE_FILE;
use super::fit::TimeTo;
use super::honesty::Honesty;
use super::reference::Origin;
use super::study::{Study, Variant};
use super::summary::{Slope, Summary, SummaryPoint};
use super::svg::{correction, seeds_in_words, settings};
use super::target::Target;
use crate::analysis::bench::Spread;
use crate::math::{counted, percent, signed, three_digits, time_in_words};
use crate::render::NOISE_TARGETS;
use escape::{block, plain};

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
    let mut parts = vec![format!(
        "# Error against run time: {}",
        plain(&study.scene_name)
    )];
    parts.push("![Noise against render time](report.svg)".to_owned());
    if let Some((variant, summary)) = variants.first() {
        parts.push(in_short(study, variant, summary));
    }
    parts.extend(cautions(study, &variants));
    parts.extend(what_was_rendered(study));
    parts.push("## Summary".to_owned());
    parts.push(summaries(&variants));
    parts.extend(targets(&variants));
    parts.push(how_to_read(study));
    parts.push("## Reference".to_owned());
    parts.push(reference(study, &variants));
    parts.push("## Settings".to_owned());
    parts.push(machine_and_settings(study, &variants));
    parts.push("## Points".to_owned());
    for (variant, summary) in &variants {
        if variants.len() > 1 {
            parts.push(format!("### {}", code(variant, &variants)));
        }
        parts.push(points(summary));
    }
    parts.push("## Numerical failures".to_owned());
    parts.push(failures(&variants));
    parts.join("\n\n") + "\n"
}

/// What must be known before any number is believed: what looked wrong before and after the renders, and how busy the machine was.
fn cautions(study: &Study, variants: &[(&Variant, Summary)]) -> Option<String> {
    let before = study
        .warnings
        .iter()
        .map(|warning| format!("{}.", plain(warning)));
    let doubts = variants.iter().filter_map(|(variant, summary)| {
        Some(format!(
            "{}: {}.",
            code(variant, variants),
            summary.doubt()?
        ))
    });
    let is_exact = matches!(study.reference.origin, Origin::Exact { .. });
    let too_few = variants.iter().filter_map(|(variant, summary)| {
        let honesty = summary.honesty.filter(Honesty::holds_too_few)?;
        // Where the reference or the picture is at fault, that has been said. Of an exact answer nobody knows.
        let is_doubted = summary.doubt().is_some() && !is_exact;
        let is_told = summary.shows_another_picture || is_doubted;
        (!is_told).then(|| {
            format!(
                "{}: {} of {} intervals held the truth, which is too few for 95 %: of independent ones so few would in less than one \
                report of a hundred. Those of one render are not independent, so that one unlucky seed counts several times.",
                code(variant, variants),
                honesty.intervals_held,
                honesty.intervals
            )
        })
    });
    let load = variants.iter().find_map(|(_, summary)| summary.load());
    let load = load.map(|load| {
        let (first, rest) = load.split_at(load.chars().next().map_or(0, char::len_utf8));
        format!("{}{rest}.", first.to_uppercase())
    });
    let all = before.chain(doubts).chain(too_few).chain(load);
    let lines: Vec<String> = all.map(|line| format!("- {line}")).collect();
    (!lines.is_empty()).then(|| format!("**Beware:**\n\n{}", lines.join("\n")))
}

/// The picture, where there is one, and when and how it was made.
fn what_was_rendered(study: &Study) -> Vec<String> {
    let image = &study.reference.image;
    let facts = format!(
        "{} × {} pixels, {}. Measured on {}, begun {}.",
        image.width,
        image.height,
        counted(study.triangles, "triangle", "triangles"),
        plain(&study.machine.describe()),
        study.date
    );
    let picture = study
        .picture
        .as_ref()
        .map(|_| format!("[![What was rendered]({PICTURE_FILE})]({PICTURE_FILE})"));
    let again = study
        .command
        .as_ref()
        .map(|command| format!("To make it again:\n\n{}", block("sh", command)));
    picture.into_iter().chain([facts]).chain(again).collect()
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
            signed(slope.value)
        )
    });
    let unfinished = if study.next().is_some() {
        " **Not all renders are done yet.**"
    } else {
        ""
    };
    format!(
        "With {} per pixel and after {} of rendering the picture has **{}** (median of {seeds}){estimated}.{slope}{unfinished}",
        in_samples(last.samples_per_pixel),
        time_in_words(last.seconds.median),
        last.noise_in_words(),
    )
}

fn in_samples(number: f64) -> String {
    let plural = if number == 1.0 { "" } else { "s" };
    format!("{} sample{plural}", samples(number))
}

fn how_to_read(study: &Study) -> String {
    format!(
        "## How to read it\n\n\
        Both axes are logarithmic, so a law such as “four times the time, half the noise” is a straight line, here of slope −0.5. \
        *Noise* is the root of the relative mean square error: errors squared, divided by the true value squared plus 0.01, \
        averaged over pixels and channels. The solid line is the true noise: its markers are medians over the seeds, its band \
        reaches from the least to the largest. The dashed line is what the renders estimate by themselves while they run; where \
        it lies on the solid one, the estimate is honest. The dotted line adds the time of preparing the scene. Of two lines, the \
        lower one has less noise after the same time, the one farther left takes less time for the same noise. The slope is the \
        median of those that are fitted to the points of each seed from 4 samples on.\n\n{}",
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
        plain(&variant.name)
    } else {
        escape::code(&variant.name)
    }
}

fn summaries(variants: &[(&Variant, Summary)]) -> String {
    let rows = variants.iter().map(|(variant, summary)| {
        let slope = |slope: Option<Slope>| slope.map_or(NONE.to_owned(), |slope| slope.in_words());
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
            time_in_words(summary.build_seconds.median),
            slope(summary.noise_slope),
            slope(summary.cpu_noise_slope),
            summary.slope.map_or(NONE.to_owned(), signed),
            summary
                .cpu_share
                .map_or(NONE.to_owned(), |share| format!("{:.0} %", 100.0 * share)),
            ratios,
            held,
            number(summary.efficiency.wall),
            number(summary.efficiency.cpu),
        ];
        row.extend(summary.time_to.map(|to| time(to, summary)));
        row
    });
    let times = NOISE_TARGETS.map(|noise| format!("to {:.0} %", 100.0 * noise));
    let mut head = vec![
        "variant",
        "build",
        "slope of noise (range)",
        "slope by CPU time (range)",
        "slope of RMSE",
        "CPU",
        "estimated / true",
        "95 % intervals held",
        "efficiency, wall",
        "efficiency, CPU",
    ];
    head.extend(times.iter().map(String::as_str));
    table(&head, &rows.collect::<Vec<_>>())
        + "\n\nSlopes are fitted to each seed: medians, and the least and the largest. Other programs on the machine disturb \
        those by CPU time least. *CPU* is the processor time of the renders over what their threads could have had. Estimates are compared with \
        true errors, RMSE and noise, at all points from 16 samples on: the smallest and largest ratio of their medians, and how often the \
        intervals of the renders held the truth; pairs that are both no more than rounding are *exact*, and are not compared. Efficiency \
        is 1 / (relMSE · seconds) at the end of each render, the median over the seeds. Times are those of rendering until the median \
        noise is that low: between points by interpolation, *predicted* beyond the last point by following the slope by CPU time, ≤ where already \
        the first point is below. Nothing is predicted from slopes above −0.25, for more than 100 times the time that was measured, \
        where more than noise is measured, or beyond where `render.stop` ends the renders."
}

/// What it took to the noise at which renders stop, where any stops at one.
fn targets(variants: &[(&Variant, Summary)]) -> Option<String> {
    let row = |variant: &Variant, target: Target| {
        let took = target.took.map_or_else(
            || [NONE; 3].map(str::to_owned),
            |took| {
                let with_range = |value: f64, [least, most]: [f64; 2]| {
                    let [value, least, most] = [value, least, most].map(time_in_words);
                    format!("{value} ({least} – {most})")
                };
                [
                    samples(took.samples_per_pixel),
                    with_range(took.seconds, took.seconds_range),
                    with_range(took.cpu_seconds, took.cpu_seconds_range),
                ]
            },
        );
        let others = [
            (target.out_of_samples, "ran out of samples"),
            (target.out_of_time, "ran out of time"),
        ];
        let others = others.into_iter().filter(|(count, _)| *count > 0);
        let reached = format!("{} of {}", target.reached, target.renders);
        let others = others.map(|(count, why)| format!("{count} {why}"));
        let reached = [reached].into_iter().chain(others).collect::<Vec<_>>();
        let reached = reached.join("; ");
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
        "render time (range)",
        "CPU time (range)",
    ];
    (!rows.is_empty()).then(|| {
        table(&head, &rows)
            + "\n\nWhat it took the renders to the noise at which they stop, by their own estimate: medians of those that are there."
    })
}

fn honesty(honesty: Honesty) -> [String; 2] {
    let ratios = honesty.ratios().map_or(NONE.to_owned(), |[least, most]| {
        format!("{least:.2} – {most:.2}")
    });
    let compared = (honesty.intervals > 0).then(|| {
        let few = if honesty.holds_too_few() {
            ", too few"
        } else {
            ""
        };
        format!("{} of {}{few}", honesty.intervals_held, honesty.intervals)
    });
    let exact = honesty.as_exact_as_numbers;
    let exact = (exact > 0).then(|| format!("{exact} exact"));
    let held: Vec<String> = compared.into_iter().chain(exact).collect();
    [ratios, held.join("; ")]
}

fn time(time: Option<TimeTo>, summary: &Summary) -> String {
    let Some(TimeTo {
        seconds,
        predicted,
        at_most,
    }) = time
    else {
        let why = if summary.shows_another_picture {
            "not by sampling"
        } else {
            NONE
        };
        return why.to_owned();
    };
    let seconds = time_in_words(seconds);
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
                if ratio.is_finite() && !point.is_exact() {
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
            with_range(point.seconds, time_in_words),
            time_in_words(point.cpu_seconds.median),
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
            "render time (range)",
            "CPU time",
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
        plain(&study.reference.describe())
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
            "{independent}; no sample of it is clamped. It took {} to render.",
            time_in_words(*render_seconds)
        ));
        if *non_finite_samples > 0 {
            sentences.push(format!(
                "**{} infinite or not a number.**",
                counted(*non_finite_samples, "sample of it is", "samples of it are")
            ));
        }
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
    let others = variants.iter().filter(|(_, s)| s.shows_another_picture);
    let others: Vec<String> = others.map(|(v, _)| code(v, variants)).collect();
    if !others.is_empty() {
        sentences.push(format!(
            "What shows another picture than the scene as it is has the difference in its true error: {}.",
            others.join(", ")
        ));
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
        parts.push(block("text", &settings(&base.settings).join("\n")));
    }
    parts.push(
        "All numbers are in [report.json](report.json), and those of every render in [report.csv](report.csv).".to_owned(),
    );
    parts.join("\n\n")
}
