//! Curves on logarithmic axes. The plot knows linear axes only, so it is given logarithms to base 10, and its grid and labels
//! take them back.

use egui::{Align2, Color32, FontId, RichText, Stroke, Ui, Vec2};
use egui_plot::{
    AxisHints, FilledArea, GridInput, GridMark, HLine, HoverPosition, Line, LineStyle, MarkerShape,
    Plot, PlotBounds, PlotPoint, PlotPoints, PlotUi, Points, Polygon, Text,
};

use super::curve::{Crossing, Curve, next_crossing, seconds_in_words};
use crate::gui::theme;
use crate::gui::widgets::{chosen_percent, format_number, noise_in_words};
use crate::render::{ErrorPoint, NOISE_TARGETS};

/// What the plot shows.
pub(super) struct Curves<'a> {
    pub present: Option<&'a Curve>,
    /// The noise at which the present render is to stop.
    pub target: Option<f64>,
    pub past: Vec<Past<'a>>,
}

/// A render before the present one.
pub(super) struct Past<'a> {
    pub curve: &'a Curve,
    pub color: Color32,
    /// Whether it is to stand out.
    pub is_pointed_at: bool,
}

impl Curves<'_> {
    pub fn are_empty(&self) -> bool {
        self.all().all(|curve| curve.points.is_empty())
    }

    /// The past ones, then the present one.
    fn all(&self) -> impl Iterator<Item = &Curve> {
        self.past.iter().map(|past| past.curve).chain(self.present)
    }

    fn crossing(&self) -> Option<Crossing> {
        next_crossing(&self.present?.points, self.target)
    }

    /// The levels that are marked: the target, or else the usual ones.
    fn levels(&self) -> Vec<f64> {
        self.target
            .map_or(NOISE_TARGETS.to_vec(), |noise| vec![noise])
    }

    /// What all of it needs, in logarithms. Ends are round numbers, so that the plot stands still while a render goes on.
    fn bounds(&self) -> PlotBounds {
        let points = || self.all().flat_map(|curve| &curve.points);
        let mut seconds: Vec<f64> = points().map(|point| point.seconds).collect();
        let mut noises: Vec<f64> = points().map(|point| point.error.noise().value).collect();
        if let Some(crossing) = self
            .crossing()
            .filter(|crossing| is_near(crossing, &seconds))
        {
            seconds.extend([crossing.seconds.value, crossing.seconds.high]);
            // Room for the words under it.
            noises.push(crossing.noise / 1.5);
        }
        noises.extend(self.target);
        let [x_min, x_max] = round_range(&seconds);
        let [y_min, y_max] = round_range(&noises);
        PlotBounds::from_min_max([x_min, y_min], [x_max, y_max])
    }
}

/// Whether a crossing is near enough to be drawn: one that is years away would press all curves to the edge.
fn is_near(crossing: &Crossing, seconds: &[f64]) -> bool {
    const MOST_FACTOR: f64 = 300.0;
    let last = seconds.iter().copied().fold(0.0, f64::max);
    crossing.seconds.high < last * MOST_FACTOR
}

/// The logarithms of the round numbers below and above all of `numbers`.
fn round_range(numbers: &[f64]) -> [f64; 2] {
    const STEPS: [f64; 5] = [1.0, 2.0, 3.0, 5.0, 10.0];
    let (least, most) = numbers
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(a, b), &n| (a.min(n), b.max(n)));
    // A little room, so that no curve runs along an edge.
    let (least, most) = ((least / 1.1).log10(), (most * 1.1).log10());
    let below = STEPS.iter().rev().map(|step| least.floor() + step.log10());
    let above = STEPS.iter().map(|step| most.floor() + step.log10());
    [
        below
            .into_iter()
            .find(|&edge| edge <= least)
            .unwrap_or(least),
        above.into_iter().find(|&edge| edge >= most).unwrap_or(most),
    ]
}

/// Draws the curves into all the room there is.
pub(super) fn curves_ui(ui: &mut Ui, curves: &Curves<'_>) {
    let font = FontId::proportional(11.0);
    let ink = ui.visuals().weak_text_color();
    let axis = |hints: AxisHints<'static>, label: &str| {
        hints
            .label(RichText::new(label).size(11.0).color(ink))
            .tick_label_font(font.clone())
            .tick_label_color(ink)
    };
    let x_axis = axis(AxisHints::new_x(), "Seconds of rendering")
        .label_spacing(34.0..=40.0)
        .formatter(|mark, _| tick(mark.value, "s"));
    let y_axis = axis(AxisHints::new_y(), "Noise")
        .label_spacing(13.0..=16.0)
        .formatter(|mark, range| {
            // One at the lower end would meet that of the other axis.
            let is_clear = mark.value > range.start() + 0.04 * (range.end() - range.start());
            if is_clear {
                tick(mark.value + 2.0, "%")
            } else {
                String::new()
            }
        });
    let all: Vec<&Curve> = curves.all().collect();
    let bounds = curves.bounds();
    let colors = Colors::of(ui);
    Plot::new("error plot")
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(Vec2::ZERO)
        .grid_spacing(4.0..=260.0)
        .grid_color(colors.ink.gamma_multiply(0.45))
        .x_grid_spacer(|input| decades(&input))
        .y_grid_spacer(|input| decades(&input))
        .custom_x_axes(vec![x_axis])
        .custom_y_axes(vec![y_axis])
        .label_formatter(|position| hover_text(&all, position))
        .show(ui, |plot| {
            plot.set_plot_bounds(bounds);
            levels_ui(plot, curves, bounds, &colors);
            for (index, past) in curves.past.iter().enumerate() {
                let (color, width) = if past.is_pointed_at {
                    (past.color, 2.6)
                } else {
                    (past.color.gamma_multiply(0.75), 1.5)
                };
                plot.line(line(index, &past.curve.points).stroke(Stroke::new(width, color)));
            }
            if let Some(curve) = curves.present {
                band_ui(plot, &curve.points);
                if let Some((last, crossing)) = curve.points.last().zip(curves.crossing()) {
                    prediction_ui(plot, last, &crossing, bounds, &colors);
                }
                let index = curves.past.len();
                plot.line(line(index, &curve.points).stroke(Stroke::new(2.2, theme::ACCENT)));
                if let Some(last) = curve.points.last() {
                    plot.points(
                        Points::new("", vec![place(last.seconds, last.error.noise().value)])
                            .radius(3.5)
                            .color(theme::ACCENT)
                            .allow_hover(false),
                    );
                }
            }
        });
}

/// Colours that differ between the dark and the light theme.
struct Colors {
    ink: Color32,
    weak: Color32,
    target: Color32,
}

impl Colors {
    fn of(ui: &Ui) -> Self {
        let visuals = ui.visuals();
        Self {
            ink: visuals.text_color(),
            weak: visuals.weak_text_color(),
            target: visuals.warn_fg_color,
        }
    }
}

/// A point of the plot: logarithms of seconds and noise.
fn place(seconds: f64, noise: f64) -> [f64; 2] {
    [seconds.log10(), noise.log10()]
}

/// The curve with number `index`, which is what [`hover_text`] knows it by.
fn line(index: usize, points: &[ErrorPoint]) -> Line<'static> {
    let places = points
        .iter()
        .map(|point| place(point.seconds, point.error.noise().value));
    Line::new(index.to_string(), places.collect::<PlotPoints<'_>>())
}

/// The 95 % interval around the present curve.
fn band_ui(plot: &mut PlotUi<'_>, points: &[ErrorPoint]) {
    let over = |value: fn(&ErrorPoint) -> f64| -> Vec<f64> {
        points.iter().map(|point| value(point).log10()).collect()
    };
    let seconds = over(|point| point.seconds);
    let low = over(|point| point.error.noise().low);
    let high = over(|point| point.error.noise().high);
    plot.add(
        FilledArea::new("", &seconds, &low, &high)
            .fill_color(theme::ACCENT.gamma_multiply(0.22))
            .allow_hover(false),
    );
}

/// The line at the target, or fainter ones at the usual levels, each with its value.
fn levels_ui(plot: &mut PlotUi<'_>, curves: &Curves<'_>, bounds: PlotBounds, colors: &Colors) {
    for noise in curves.levels() {
        let y = noise.log10();
        if !bounds.range_y().contains(&y) {
            continue;
        }
        let (color, width) = match curves.target {
            Some(_) => (colors.target, 1.2),
            None => (colors.weak.gamma_multiply(0.6), 1.0),
        };
        plot.hline(
            HLine::new("", y)
                .stroke(Stroke::new(width, color))
                .style(LineStyle::dashed_loose())
                .allow_hover(false),
        );
        let level = chosen_percent(noise);
        let (text, x, anchor) = match curves.target {
            Some(_) => (
                format!(" Stop at {level}"),
                bounds.min()[0],
                Align2::LEFT_BOTTOM,
            ),
            None => (format!("{level} "), bounds.max()[0], Align2::RIGHT_BOTTOM),
        };
        plot.text(
            Text::new("", PlotPoint::new(x, y), RichText::new(text).size(11.0))
                .color(color)
                .anchor(anchor)
                .allow_hover(false),
        );
    }
}

/// From the last point to where the next level is reached, and how sure that is.
fn prediction_ui(
    plot: &mut PlotUi<'_>,
    last: &ErrorPoint,
    crossing: &Crossing,
    bounds: PlotBounds,
    colors: &Colors,
) {
    let from = place(last.seconds, last.error.noise().value);
    let [to, low, high] = [
        crossing.seconds.value,
        crossing.seconds.low,
        crossing.seconds.high,
    ]
    .map(|seconds| place(seconds.max(last.seconds), crossing.noise));
    plot.polygon(
        Polygon::new("", vec![from, low, high])
            .fill_color(theme::ACCENT.gamma_multiply(0.12))
            .stroke(Stroke::NONE)
            .allow_hover(false),
    );
    plot.line(
        Line::new("", vec![from, to])
            .stroke(Stroke::new(1.6, theme::ACCENT))
            .style(LineStyle::dashed_dense())
            .allow_hover(false),
    );
    plot.line(
        Line::new("", vec![low, high])
            .stroke(Stroke::new(3.0, theme::ACCENT))
            .allow_hover(false),
    );
    plot.points(
        Points::new("", vec![to])
            .shape(MarkerShape::Diamond)
            .radius(5.5)
            .color(theme::ACCENT)
            .allow_hover(false),
    );
    // The words go under the line, to the side with more room.
    let is_right = to[0] > f64::midpoint(bounds.min()[0], bounds.max()[0]);
    let text = format!(
        "{} at {}",
        chosen_percent(crossing.noise),
        seconds_in_words(crossing.seconds.value)
    );
    let anchor = if is_right {
        Align2::RIGHT_TOP
    } else {
        Align2::LEFT_TOP
    };
    let gap = plot.transform().dvalue_dpos()[1].abs() * 7.0;
    plot.text(
        Text::new(
            "",
            PlotPoint::new(to[0], to[1] - gap),
            RichText::new(text).size(11.0),
        )
        .color(colors.ink)
        .anchor(anchor)
        .allow_hover(false),
    );
}

/// Grid lines at 1, 2, …, 9 times the powers of ten.
fn decades(input: &GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let mut marks = Vec::new();
    let mut decade = low.floor();
    while decade <= high {
        for digit in 1..=9_u8 {
            let value = decade + f64::from(digit).log10();
            if (low - 1e-9..=high + 1e-9).contains(&value) {
                let next = (f64::from(digit + 1) / f64::from(digit)).log10();
                marks.push(GridMark {
                    value,
                    // Lines are as strong and have labels as they have room.
                    step_size: match digit {
                        1 => 1.0,
                        2 | 5 => 0.3,
                        _ => next,
                    },
                });
            }
        }
        decade += 1.0;
    }
    marks
}

/// What a grid line says; only those at 1, 2 and 5 say something.
fn tick(logarithm: f64, unit: &str) -> String {
    let digit = 10.0_f64.powf(logarithm.rem_euclid(1.0));
    let is = |wanted: f64| (digit / wanted - 1.0).abs() < 1e-6;
    if is(1.0) || is(2.0) || is(5.0) || is(10.0) {
        format!("{} {unit}", format_number(10.0_f64.powf(logarithm), 3))
    } else {
        String::new()
    }
}

/// What is known where the mouse is.
fn hover_text(curves: &[&Curve], position: &HoverPosition<'_>) -> Option<String> {
    let HoverPosition::NearDataPoint {
        plot_name, index, ..
    } = position
    else {
        return None;
    };
    let curve = curves.get(plot_name.parse::<usize>().ok()?)?;
    let point = curve.points.get(*index)?;
    Some(format!(
        "{}\nnoise {}\nafter {}, {} samples per pixel",
        curve.name,
        noise_in_words(point.error.noise()),
        seconds_in_words(point.seconds),
        format_number(point.error.samples_per_pixel, 1),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::RangeInclusive;

    fn ticks(range: RangeInclusive<f64>) -> Vec<String> {
        let bounds = (range.start().log10(), range.end().log10());
        let marks = decades(&GridInput {
            bounds,
            base_step_size: 0.01,
        });
        let texts = marks.into_iter().map(|mark| tick(mark.value, "s"));
        texts.filter(|text| !text.is_empty()).collect()
    }

    #[test]
    fn axes_are_labelled_at_round_numbers() {
        assert_eq!(
            ticks(0.05..=1.0),
            ["0.05 s", "0.1 s", "0.2 s", "0.5 s", "1 s"]
        );
        assert_eq!(ticks(40.0..=300.0), ["50 s", "100 s", "200 s"]);
    }

    #[test]
    fn ranges_end_at_round_numbers() {
        let [low, high] = round_range(&[0.07, 0.3, 4.0]).map(|edge| 10.0_f64.powf(edge));
        assert!(
            (low - 0.05).abs() < 1e-9 && (high - 5.0).abs() < 1e-9,
            "{low} {high}"
        );
        let [low, high] = round_range(&[1.0]).map(|edge| 10.0_f64.powf(edge));
        assert!(low < 1.0 && high > 1.0);
    }
}
