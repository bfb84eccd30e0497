//! Where the parts of a chart are, in pixels from the upper left corner.

use super::scale::{Scale, Tick};
use super::{Chart, Curve, Level, Point};

/// Sizes of letters: of the title, of most texts, and of what is less important.
pub(super) const TITLE_SIZE: f64 = 16.0;
pub(super) const TEXT_SIZE: f64 = 12.0;
pub(super) const SMALL_SIZE: f64 = 11.0;

/// From one line of the caption to the next, and between labels of levels at least.
pub(super) const LINE_HEIGHT: f64 = 15.0;

/// Length of the piece of line in the legend.
pub(super) const SAMPLE_LENGTH: f64 = 36.0;

/// The most letters of a line in the legend, and the most lines of a name.
const LEGEND_LETTERS: usize = 38;
const LEGEND_LINES: usize = 6;

/// Between labels and what they belong to.
pub(super) const GAP: f64 = 8.0;

/// From one line of a note to the next.
pub(super) const NOTE_HEIGHT: f64 = 14.0;

const LEAST_WIDTH: f64 = 900.0;
const LEAST_PLOT_WIDTH: f64 = 480.0;
const LEAST_PLOT_HEIGHT: f64 = 410.0;
const EDGE: f64 = 16.0;
const TITLE_HEIGHT: f64 = 46.0;
/// Labels of ticks and the name of the axis, below the plot.
const X_AXIS_HEIGHT: f64 = 58.0;
/// Room for a label of a tick, along its axis.
const X_LABEL_ROOM: f64 = 66.0;
const Y_LABEL_ROOM: f64 = 22.0;

/// Places and scales.
pub(super) struct Layout {
    pub width: f64,
    pub height: f64,
    /// The frame around the data.
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub x: Scale,
    pub y: Scale,
    pub x_ticks: Vec<Tick>,
    pub y_ticks: Vec<Tick>,
    /// The middle of the y axis's name.
    pub y_name: f64,
    /// Left end of the legend.
    pub legend: f64,
    /// Base lines of the caption.
    pub caption: Vec<(f64, String)>,
}

impl Layout {
    /// The places for this chart's parts: plot and legend are as large as the texts around them leave room for.
    pub fn of(chart: &Chart) -> Self {
        let (x, y) = scales(chart);
        let caption = caption_lines(chart);

        // From top to bottom.
        let legend_height: f64 = chart.shown_curves().map(legend_height).sum();
        let (top, plot_height) = (TITLE_HEIGHT, LEAST_PLOT_HEIGHT.max(legend_height));
        let bottom = top + plot_height;
        let caption_top = bottom + X_AXIS_HEIGHT;
        let base_line = |line| caption_top + (line as f64 + 0.5) * LINE_HEIGHT;
        let height = base_line(caption.len()) + GAP;

        // From left to right.
        let y_ticks = y.ticks(chart.y.unit, plot_height, Y_LABEL_ROOM);
        let tick_labels = y_ticks.iter().filter_map(|tick| tick.label.as_deref());
        let y_name = EDGE + TEXT_SIZE / 2.0;
        let left = y_name + TEXT_SIZE / 2.0 + 2.0 * GAP + widest(tick_labels, TEXT_SIZE);
        let of_curves = || chart.shown_curves();
        let names: Vec<String> = of_curves().flat_map(|c| legend_lines(&c.name)).collect();
        let notes = of_curves().filter_map(|c| c.note.as_deref());
        let notes: Vec<String> = notes.flat_map(legend_lines).collect();
        let width = |lines: &[String], size| widest(lines.iter().map(String::as_str), size);
        let legend_texts = width(&names, TEXT_SIZE).max(width(&notes, SMALL_SIZE));
        let legend_width = SAMPLE_LENGTH + GAP + legend_texts;
        let level_labels = chart.shown_levels().map(|level| &*level.label);
        let after_plot = GAP + widest(level_labels, TEXT_SIZE) + EDGE;
        let after_left = after_plot + legend_width + EDGE;
        // Bold letters are wider by a sixth.
        let title = left + text_width(&chart.title, TITLE_SIZE * 7.0 / 6.0) + EDGE;
        let lines = left + widest(caption.iter().map(String::as_str), SMALL_SIZE) + EDGE;
        let width = (left + LEAST_PLOT_WIDTH + after_left)
            .max(title)
            .max(lines)
            .max(LEAST_WIDTH);
        let right = width - after_left;

        Self {
            width,
            height,
            left,
            right,
            top,
            bottom,
            x,
            y,
            x_ticks: x.ticks(chart.x.unit, right - left, X_LABEL_ROOM),
            y_ticks,
            y_name,
            legend: right + after_plot,
            caption: (0..).map(base_line).zip(caption).collect(),
        }
    }

    /// From left to right, the place of a share of the x axis.
    pub fn across(&self, share: f64) -> f64 {
        self.left + share * (self.right - self.left)
    }

    /// From top to bottom, the place of a share of the y axis.
    pub fn down(&self, share: f64) -> f64 {
        self.bottom - share * (self.bottom - self.top)
    }

    /// The levels from top to bottom, each with the heights of its line and of the middle of its label: labels are moved
    /// down where they would meet.
    pub fn levels<'a>(&self, chart: &'a Chart) -> Vec<(&'a Level, f64, f64)> {
        let mut levels: Vec<_> = chart.shown_levels().collect();
        levels.sort_by(|a, b| b.y.total_cmp(&a.y));
        let mut free = 0.0_f64;
        let places = levels.into_iter().map(|level| {
            let line = self.down(self.y.share(level.y));
            let label = line.max(free);
            free = label + LINE_HEIGHT;
            (level, line, label)
        });
        places.collect()
    }
}

/// The scales around all that is shown.
fn scales(chart: &Chart) -> (Scale, Scale) {
    let points = || {
        let curves = chart.curves.iter();
        curves.flat_map(|curve| curve.shown().map(move |point| (curve, point)))
    };
    // The median is there for ranges that have no end on the axis.
    let heights = |(curve, Point { y, .. }): (&Curve, &Point)| {
        let (min, max) = if curve.band {
            (y.min, y.max)
        } else {
            (y.median, y.median)
        };
        [min, y.median, max]
    };
    let levels = chart.shown_levels().map(|level| level.y);
    let heights = points().flat_map(heights).chain(levels);
    (
        Scale::around(points().map(|(_, point)| point.x)),
        Scale::around(heights.filter(|&y| super::has_place(y))),
    )
}

/// The caption, and what is missing in the picture.
fn caption_lines(chart: &Chart) -> Vec<String> {
    let mut lines = chart.caption.clone();
    let missing = match chart.left_out() {
        0 => return lines,
        1 => "1 value is not shown: a logarithmic axis has no place for it".to_owned(),
        n => format!("{n} values are not shown: a logarithmic axis has no place for them"),
    };
    lines.push(missing);
    lines
}

/// Height of a curve's place in the legend.
pub(super) fn legend_height(curve: &Curve) -> f64 {
    let more_lines = legend_lines(&curve.name).len().saturating_sub(1);
    let notes = curve
        .note
        .as_deref()
        .map_or(0, |note| legend_lines(note).len());
    22.0 + (more_lines as f64) * LINE_HEIGHT + notes as f64 * NOTE_HEIGHT
}

/// A text of the legend in lines that are not too long, broken behind what parts settings and words where there is such a place. Of very
/// many lines the first are shown.
pub(super) fn legend_lines(text: &str) -> Vec<String> {
    let letters: Vec<char> = text.chars().collect();
    let mut lines = Vec::new();
    let mut rest = letters.as_slice();
    while rest.len() > LEGEND_LETTERS {
        let place = |parts: &[char]| {
            let last = rest[..LEGEND_LETTERS]
                .iter()
                .rposition(|c| parts.contains(c))?;
            // A short line would only make the others many.
            (last + 1 > LEGEND_LETTERS / 3).then_some(last + 1)
        };
        let end = place(&[';']).or_else(|| place(&[' ']));
        let end = end.or_else(|| place(&['=', '.', '/', ',']));
        let (line, after) = rest.split_at(end.unwrap_or(LEGEND_LETTERS));
        lines.push(line.iter().collect::<String>().trim_end().to_owned());
        rest = after.strip_prefix(&[' ']).unwrap_or(after);
    }
    lines.push(rest.iter().collect());
    if lines.len() > LEGEND_LINES {
        lines.truncate(LEGEND_LINES);
        lines[LEGEND_LINES - 1].push('…');
    }
    lines
}

fn widest<'a>(texts: impl Iterator<Item = &'a str>, size: f64) -> f64 {
    texts.fold(0.0, |widest, text| text_width(text, size).max(widest))
}

/// About the width of a text in a wide font: fonts are the viewer's, so it cannot be known.
fn text_width(text: &str, size: f64) -> f64 {
    let em = |c: char| if c.is_ascii() { 0.6 } else { 1.0 };
    text.chars().map(em).sum::<f64>() * size
}
