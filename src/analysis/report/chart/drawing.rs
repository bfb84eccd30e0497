//! A chart as SVG elements, one a line. Numbers have two decimals: the same chart is the same text.

use std::fmt::Write;

use super::layout::{
    GAP, LINE_HEIGHT, Layout, NOTE_HEIGHT, SAMPLE_LENGTH, SMALL_SIZE, TEXT_SIZE, TITLE_SIZE,
    legend_height, legend_lines,
};
use super::scale::Tick;
use super::{Chart, Curve, Line};

/// Colours that people who see few colours tell apart, on white.
///
/// Source: M. Okabe, K. Ito, Color Universal Design (2008), without its yellow, which is too light for lines.
const COLORS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000",
];

/// Outlines of markers around their middle: circle, square, triangle, diamond. Their number and that of the colours have
/// no common factor, so all pairs appear before one repeats.
const MARKERS: [&str; 4] = [
    "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
    "m-3.5 -3.5h7v7h-7z",
    "m0 -4.8l4.6 8h-9.2z",
    "m0 -5l5 5l-5 5l-5 -5z",
];

/// From the middle of a line of text down to its base line, in sizes of its letters.
const BASE_LINE: f64 = 0.35;

/// The document.
pub(super) fn draw(chart: &Chart, layout: &Layout) -> String {
    let (width, height) = (layout.width.ceil(), layout.height.ceil());
    let mut lines = vec![
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" font-family=\"sans-serif\" fill=\"#222\">"
        ),
        format!("<title>{}</title>", escaped(&chart.title)),
        r##"<rect width="100%" height="100%" fill="#fff"/>"##.to_owned(),
    ];
    lines.extend(grid(layout));
    lines.extend(levels(chart, layout));
    lines.extend(chart.curves.iter().filter_map(|c| ranges(c, layout)));
    for curve in &chart.curves {
        lines.extend(line_and_markers(curve, layout));
    }
    lines.extend(labels(chart, layout));
    lines.extend(legend(chart, layout));
    lines.push("</svg>\n".to_owned());
    lines.join("\n")
}

/// Lines at the ticks, those of powers of ten over the others.
fn grid(layout: &Layout) -> [String; 2] {
    let (left, right, top, bottom) = (layout.left, layout.right, layout.top, layout.bottom);
    [(false, "#eee"), (true, "#d4d4d4")].map(|(power, color)| {
        let chosen = |tick: &&Tick| tick.power == power;
        let mut path = String::new();
        for tick in layout.x_ticks.iter().filter(chosen) {
            let x = layout.across(tick.share);
            let _ = write!(path, "M{x:.2} {top:.2}V{bottom:.2}");
        }
        for tick in layout.y_ticks.iter().filter(chosen) {
            let y = layout.down(tick.share);
            let _ = write!(path, "M{left:.2} {y:.2}H{right:.2}");
        }
        format!(r#"<path d="{path}" stroke="{color}"/>"#)
    })
}

/// Lines to compare with, and their labels at the right.
fn levels(chart: &Chart, layout: &Layout) -> Vec<String> {
    let mut lines = Vec::new();
    for (level, line, label) in layout.levels(chart) {
        lines.push(format!(
            r##"<path d="M{:.2} {line:.2}H{:.2}" stroke="#555" stroke-dasharray="9 5"/>"##,
            layout.left, layout.right
        ));
        let place = (layout.right + GAP, label);
        lines.push(text(place, "start", &level.label));
    }
    lines
}

/// What the points' ranges cover, or a bar where there is but one.
fn ranges(curve: &Curve, layout: &Layout) -> Option<String> {
    if !curve.band {
        return None;
    }
    let lower = curve.shown().map(|p| place(layout, p.x, p.y.min));
    let upper = curve.shown().map(|p| place(layout, p.x, p.y.max));
    let (lower, mut outline): (Vec<_>, Vec<_>) = (lower.collect(), upper.collect());
    outline.extend(lower.into_iter().rev());
    let color = color_of(curve);
    let manner = match outline.len() {
        0 => return None,
        2 => format!(r#"stroke="{color}" stroke-width="5" stroke-opacity="0.3""#),
        _ => format!(r#"fill="{color}" fill-opacity="0.16""#),
    };
    Some(format!(r#"<path d="M{}z" {manner}/>"#, outline.join("L")))
}

/// The medians.
fn line_and_markers(curve: &Curve, layout: &Layout) -> Vec<String> {
    let places = curve.shown().map(|p| place(layout, p.x, p.y.median));
    let places: Vec<_> = places.collect();
    stroke_and_markers(curve, &places, &places)
}

/// A line through places in the curve's manner, and its markers at others.
fn stroke_and_markers(curve: &Curve, line: &[String], markers: &[String]) -> Vec<String> {
    if line.is_empty() {
        return Vec::new();
    }
    let color = color_of(curve);
    let (dashes, fill) = match curve.line {
        Line::Solid => ("", color),
        Line::Dashed => (r#" stroke-dasharray="7 4""#, "#fff"),
        Line::Dotted => (r#" stroke-dasharray="2 3""#, "#fff"),
    };
    let marker = MARKERS[curve.color % MARKERS.len()];
    let markers = markers.iter().map(|place| format!("M{place}{marker}"));
    let markers: String = markers.collect();
    vec![
        format!(
            r#"<path d="M{}" fill="none" stroke="{color}" stroke-width="2" stroke-linejoin="round"{dashes}/>"#,
            line.join("L")
        ),
        format!(r#"<path d="{markers}" fill="{fill}" stroke="{color}" stroke-width="1.5"/>"#),
    ]
}

/// The frame, and all texts around it but the legend.
fn labels(chart: &Chart, layout: &Layout) -> Vec<String> {
    let (left, right, top, bottom) = (layout.left, layout.right, layout.top, layout.bottom);
    let mut lines = vec![
        format!(
            r##"<rect x="{left:.2}" y="{top:.2}" width="{:.2}" height="{:.2}" fill="none" stroke="#222"/>"##,
            right - left,
            bottom - top
        ),
        format!(
            r#"<g font-weight="bold">{}</g>"#,
            sized_text(TITLE_SIZE, (left, top / 2.0), "start", &chart.title)
        ),
    ];
    for (tick, label) in labelled(&layout.x_ticks) {
        let x = layout.across(tick.share);
        lines.push(format!(
            r##"<path d="M{x:.2} {bottom:.2}v5" stroke="#222"/>"##
        ));
        let place = (x, bottom + GAP + TEXT_SIZE / 2.0);
        lines.push(text(place, "middle", label));
    }
    for (tick, label) in labelled(&layout.y_ticks) {
        let y = layout.down(tick.share);
        lines.push(format!(
            r##"<path d="M{left:.2} {y:.2}h-5" stroke="#222"/>"##
        ));
        lines.push(text((left - GAP, y), "end", label));
    }
    let (across, down) = (layout.across(0.5), layout.down(0.5));
    let x_name = (across, bottom + 2.0 * GAP + 1.5 * TEXT_SIZE);
    lines.push(text(x_name, "middle", &chart.x.label));
    lines.push(format!(
        r#"<g transform="translate({:.2} {down:.2}) rotate(-90)">{}</g>"#,
        layout.y_name,
        text((0.0, 0.0), "middle", &chart.y.label)
    ));
    if chart.shown_curves().next().is_none() {
        // On a white ground, as there is a grid behind it.
        let message = text((across, down), "middle", "no values to show");
        lines.push(format!(
            r##"<g paint-order="stroke" stroke="#fff" stroke-width="8">{message}</g>"##
        ));
    }
    let caption = layout.caption.iter();
    lines.extend(caption.map(|(y, line)| sized_text(SMALL_SIZE, (left, *y), "start", line)));
    lines
}

fn labelled(ticks: &[Tick]) -> impl Iterator<Item = (&Tick, &str)> {
    ticks
        .iter()
        .filter_map(|tick| Some((tick, tick.label.as_deref()?)))
}

/// A piece of every curve with its name, and its note below.
fn legend(chart: &Chart, layout: &Layout) -> Vec<String> {
    let mut lines = Vec::new();
    let mut top = layout.top;
    for curve in chart.shown_curves() {
        let y = top + TEXT_SIZE / 2.0;
        let along = [0.0, 0.5, 1.0].map(|share| layout.legend + share * SAMPLE_LENGTH);
        let [start, middle, end] = along.map(|x| format!("{x:.2} {y:.2}"));
        lines.extend(stroke_and_markers(curve, &[start, end], &[middle]));
        let x = layout.legend + SAMPLE_LENGTH + GAP;
        let mut below = y;
        for (number, line) in legend_lines(&curve.name).iter().enumerate() {
            below = y + number as f64 * LINE_HEIGHT;
            lines.push(text((x, below), "start", line));
        }
        for line in curve.note.as_deref().map_or_else(Vec::new, legend_lines) {
            below += NOTE_HEIGHT;
            lines.push(sized_text(SMALL_SIZE, (x, below), "start", &line));
        }
        top += legend_height(curve);
    }
    lines
}

/// The place of a point, as paths have it.
fn place(layout: &Layout, x: f64, y: f64) -> String {
    let (across, down) = (layout.x.share(x), layout.y.share(y));
    format!("{:.2} {:.2}", layout.across(across), layout.down(down))
}

fn color_of(curve: &Curve) -> &'static str {
    COLORS[curve.color % COLORS.len()]
}

/// A text around or beside a place, its middle line at the place's height.
fn text(place: (f64, f64), anchor: &str, content: &str) -> String {
    sized_text(TEXT_SIZE, place, anchor, content)
}

fn sized_text(size: f64, (x, y): (f64, f64), anchor: &str, content: &str) -> String {
    format!(
        r#"<text x="{x:.2}" y="{:.2}" text-anchor="{anchor}" font-size="{size:.0}">{}</text>"#,
        y + BASE_LINE * size,
        escaped(content)
    )
}

/// A text as XML has it; what no XML document may hold is replaced.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => escaped.push(char::REPLACEMENT_CHARACTER),
            _ => escaped.push(c),
        }
    }
    escaped
}
