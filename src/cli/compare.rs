//! `raymini compare`: how far a picture is from a reference.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use serde::Serialize;

use super::inputs::is_same_file;
use crate::analysis::{
    LocatedDifference, Metrics, mean_flip, scaled_difference, signed_difference,
};
use crate::io::{self, PictureFile, WrittenOrigin};
use crate::render::{Image, Region};
use crate::scene::{Display, Output};

/// What `raymini compare` takes.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The picture to be judged: .png, .exr or .hdr
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The reference
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Where to write the difference: .png for |A − B|, brightened; .exr for A − B itself
    #[arg(short, long, value_name = "DIFF", allow_hyphen_values = true, value_parser = super::values::output())]
    output: Option<PathBuf>,

    /// Print the numbers as JSON
    #[arg(long)]
    json: bool,
}

/// What is printed. Numbers that cannot be formed are null.
#[derive(Debug, Serialize)]
struct CompareFacts {
    width: u32,
    height: u32,
    identical: bool,
    rmse: f64,
    mse: f64,
    relmse: f64,
    noise: f64,
    flip: f64,
    largest: Option<LargestFacts>,
    percentile_999: f64,
    mean: MeanFacts,
    /// Where one picture is a part of the other, which is cut to it.
    part: Option<PartFacts>,
    differing_pixels: u64,
    visibly_differing_pixels: u64,
    non_finite: NonFiniteFacts,
    compared_pixels: u64,
    difference: Option<DifferenceFacts>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct LargestFacts {
    value: f64,
    x: u32,
    y: u32,
}

/// The part of one picture that the other, by its file, is of.
#[derive(Debug, Serialize)]
struct PartFacts {
    /// Which picture is the larger one, "a" or "b".
    of: &'static str,
    region: Region,
}

impl PartFacts {
    /// Cuts the larger picture to what the smaller one is of, where that one's file says that it is a part of a picture of this size.
    fn cut(paths: [&PathBuf; 2], images: [&mut Image; 2]) -> Option<Self> {
        let [a, b] = images;
        if (a.width, a.height) == (b.width, b.height) {
            return None;
        }
        // What does not tell of its origin is no part of anything.
        let [of_a, of_b] = paths.map(|path| WrittenOrigin::of_file(path).unwrap_or_default());
        let (of, whole, part, origin) = match (of_a.region, of_b.region) {
            (Some(_), None) => ("b", b, a, of_a),
            (None, Some(_)) => ("a", a, b, of_b),
            _ => return None,
        };
        let region = origin.region?;
        let size = (whole.width, whole.height);
        let is_whole = region.fits(size.0, size.1) && origin.picture_size()? == size;
        if !is_whole || (part.width, part.height) != (region.width, region.height) {
            return None;
        }
        *whole = cut(whole, region);
        Some(Self { of, region })
    }
}

/// The pixels of `region`, which lies in the image.
fn cut(image: &Image, region: Region) -> Image {
    let rows = image.pixels.chunks_exact(image.width as usize);
    let rows = rows.skip(region.y as usize).take(region.height as usize);
    let columns = region.x as usize..(region.x + region.width) as usize;
    Image {
        width: region.width,
        height: region.height,
        pixels: rows
            .flat_map(|row| &row[columns.clone()])
            .copied()
            .collect(),
    }
}

#[derive(Debug, Serialize)]
struct MeanFacts {
    a: [f64; 3],
    b: [f64; 3],
    relative: [f64; 3],
}

#[derive(Debug, Serialize)]
struct NonFiniteFacts {
    a: u64,
    b: u64,
}

/// The difference picture.
#[derive(Debug, Serialize)]
struct DifferenceFacts {
    file: String,
    /// Which difference is white, where it is drawn so.
    white: Option<f64>,
}

pub(super) fn run(arguments: &CompareArguments) -> Result<()> {
    if let Some(output) = &arguments.output {
        check_output(output, [&arguments.a, &arguments.b])?;
    }
    let (mut a, mut b) = (io::read_image(&arguments.a)?, io::read_image(&arguments.b)?);
    let part = PartFacts::cut([&arguments.a, &arguments.b], [&mut a.image, &mut b.image]);
    let names = [&arguments.a, &arguments.b].map(|path| path.display().to_string());
    let metrics = Metrics::measure(&a.image, &b.image)
        .with_context(|| format!("{} and {} cannot be compared", names[0], names[1]))?;
    let difference = match &arguments.output {
        Some(path) => Some(write_difference(&a, &b, &metrics, path)?),
        None => None,
    };
    let flip = mean_flip(&a.image, &b.image)?;
    let facts = CompareFacts {
        part,
        ..facts(&names, [&a, &b], &metrics, flip, difference)
    };
    if arguments.json {
        super::say_json(&facts)
    } else {
        super::say(&describe(&names, &facts))
    }
}

/// Looks for what keeps the difference from being written, and refuses to put it in the place of a picture that is compared.
fn check_output(output: &Path, compared: [&PathBuf; 2]) -> Result<()> {
    if compared.iter().any(|path| is_same_file(path, output)) {
        let name = output.display();
        bail!("{name}: it is compared; the difference would take its place");
    }
    Ok(io::check_image_path(output)?)
}

/// Writes the difference in the way that suits the format: a picture of how large it is, or the numbers.
fn write_difference(
    a: &PictureFile,
    b: &PictureFile,
    metrics: &Metrics,
    path: &Path,
) -> Result<DifferenceFacts> {
    // The format with layers is the one that holds any number.
    let (image, white) = if io::holds_layers(path) {
        (signed_difference(&a.image, &b.image)?, None)
    } else {
        let white = metrics.white();
        (scaled_difference(&a.image, &b.image, white)?, Some(white))
    };
    io::write_image(&image, &[], &Display::default(), &Output::default(), path)?;
    Ok(DifferenceFacts {
        file: path.display().to_string(),
        white,
    })
}

fn facts(
    names: &[String; 2],
    [a, b]: [&PictureFile; 2],
    metrics: &Metrics,
    flip: f64,
    difference: Option<DifferenceFacts>,
) -> CompareFacts {
    let mut warnings = Vec::new();
    let counts = [metrics.non_finite_a, metrics.non_finite_b];
    for ((name, file), count) in names.iter().zip([a, b]).zip(counts) {
        let of_file = file.warnings.iter();
        warnings.extend(of_file.map(|warning| format!("{name}: {warning}")));
        if count > 0 {
            warnings.push(format!(
                "{name}: {count} of {} pixels hold a value that is infinite or not a number; only the counts of differing pixels have them",
                file.image.pixels.len()
            ));
        }
    }
    if (a.format == "PNG") != (b.format == "PNG") {
        warnings.push(
            "a PNG holds what a screen shows: exposure, tone curve and the end at 1 are in it, and not in the other picture"
                .to_owned(),
        );
    }
    let errors = &metrics.errors;
    CompareFacts {
        width: a.image.width,
        height: a.image.height,
        identical: metrics.identical(),
        rmse: errors.rmse(),
        mse: errors.mse,
        relmse: errors.relmse,
        noise: errors.noise(),
        flip,
        largest: metrics
            .largest
            .map(|LocatedDifference { value, x, y }| LargestFacts { value, x, y }),
        percentile_999: metrics.percentile_999,
        mean: MeanFacts {
            a: metrics.mean_a,
            b: metrics.mean_b,
            relative: metrics.relative_means(),
        },
        part: None,
        differing_pixels: metrics.differing_pixels,
        visibly_differing_pixels: metrics.visibly_differing_pixels,
        non_finite: NonFiniteFacts {
            a: metrics.non_finite_a,
            b: metrics.non_finite_b,
        },
        compared_pixels: errors.compared_pixels,
        difference,
        warnings,
    }
}

/// The facts as lines for people: a name, a value and what it means each.
fn describe(names: &[String; 2], facts: &CompareFacts) -> String {
    let [a, b] = names;
    let mut lines = vec![
        format!("A: {a}"),
        format!("B: {b}, the reference"),
        String::new(),
    ];
    let mut line = |name: &str, value: &str, meaning: &str| {
        let text = format!("  {name:<18}{value:<30}  {meaning}");
        lines.push(text.trim_end().to_owned());
    };
    let pixels = u64::from(facts.width) * u64::from(facts.height);
    let size = format!("{}×{}", facts.width, facts.height);
    line("size", &size, "linear values, of red, green and blue");
    if let Some(PartFacts { of, region }) = &facts.part {
        let place = format!("from pixel ({}, {}) on", region.x, region.y);
        let meaning = match *of {
            "a" => "of A, which is larger, is compared with B",
            _ => "of B, which is larger, is compared with A",
        };
        line("part", &place, meaning);
    }
    line(
        "identical",
        if facts.identical { "yes" } else { "no" },
        "every value the same, bit for bit",
    );
    let share = |count: u64| format!("{count} ({})", percent(count as f64 / pixels as f64));
    line(
        "differing pixels",
        &share(facts.differing_pixels),
        "by however little",
    );
    line(
        "visibly differing",
        &share(facts.visibly_differing_pixels),
        "by more than 1/255 as a screen shows them",
    );
    line(
        "RMSE",
        &number(facts.rmse),
        "root of MSE, in the pictures' unit",
    );
    line("MSE", &number(facts.mse), "mean of (A − B)²");
    line(
        "relMSE",
        &number(facts.relmse),
        "mean of (A − B)² / (B² + 0.01)",
    );
    line("noise", &percent(facts.noise), "root of relMSE");
    line(
        "FLIP",
        &number(facts.flip),
        "how different they look in turn on a screen, 0 to 1",
    );
    let (largest, place) = match &facts.largest {
        Some(LargestFacts { value, x, y }) => (number(*value), format!("at pixel ({x}, {y})")),
        None => ("none".to_owned(), String::new()),
    };
    line("largest |A − B|", &largest, &place);
    line(
        "99.9th percentile",
        &number(facts.percentile_999),
        "of the pixels' largest |A − B|",
    );
    let triple = |values: [f64; 3], text: fn(f64) -> String| values.map(text).join("  ");
    let MeanFacts { a, b, relative } = facts.mean;
    line("mean of A", &triple(a, number), "red, green, blue");
    line("mean of B", &triple(b, number), "");
    line(
        "A brighter by",
        &triple(relative, signed_percent),
        "of B's mean",
    );
    let NonFiniteFacts { a, b } = facts.non_finite;
    line(
        "not finite",
        &format!("{a} in A, {b} in B"),
        "pixels left out of the measures from RMSE on",
    );
    if let Some(DifferenceFacts { file, white }) = &facts.difference {
        let meaning = match white {
            Some(white) => format!("|A − B|; white is {}", number(*white)),
            None => "A − B, with its sign".to_owned(),
        };
        line("difference", file, &meaning);
    }
    for warning in &facts.warnings {
        line("warning", warning, "");
    }
    lines.join("\n")
}

/// Five digits, with an exponent where there would be many zeros.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e5).contains(&size) {
        format!("{value:.4e}")
    } else {
        // 10000 has no places behind the point, 0.001 has 7.
        let places = (0..7).take_while(|&places| size * 10_f64.powi(places) < 1e4);
        format!("{value:.*}", places.count())
    }
}

fn percent(part: f64) -> String {
    format!("{} %", number(100.0 * part))
}

fn signed_percent(part: f64) -> String {
    format!("{:+.3} %", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_five_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (0.001, "0.0010000"),
            (0.000_999, "9.9900e-4"),
            (0.123_456_7, "0.12346"),
            (-1.5, "-1.5000"),
            (12_345.6, "12346"),
            (1e5, "1.0000e5"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), expected);
        }
    }
}
