//! The curves of renders, and what is foreseen of the present one.

use egui::{Align2, Color32, RichText, Stroke, Ui};
use egui_plot::{
    FilledArea, HoverPosition, Line, LineStyle, MarkerShape, PlotBounds, PlotPoint, PlotPoints,
    PlotUi, Points, Polygon, Text,
};

use super::curve::{Crossing, Curve, next_crossing, seconds_in_words};
use crate::gui::log_plot::{End, bounds_of, level_ui, log_plot_ui, place};
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
        bounds_of(&seconds, &noises)
    }
}

/// Whether a crossing is near enough to be drawn: one that is years away would press all curves to the edge.
fn is_near(crossing: &Crossing, seconds: &[f64]) -> bool {
    const MOST_FACTOR: f64 = 300.0;
    let last = seconds.iter().copied().fold(0.0, f64::max);
    crossing.seconds.high < last * MOST_FACTOR
}

/// Draws the curves into all the room there is.
pub(super) fn curves_ui(ui: &mut Ui, curves: &Curves<'_>) {
    let all: Vec<&Curve> = curves.all().collect();
    let bounds = curves.bounds();
    let colors = Colors::of(ui);
    let hover_text = |position: &HoverPosition<'_>| hover_text(&all, position);
    log_plot_ui(ui, "error plot", bounds, hover_text, |plot| {
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
        let level = chosen_percent(noise);
        if curves.target.is_some() {
            let stroke = Stroke::new(1.2, colors.target);
            let text = format!("Stop at {level}");
            level_ui(plot, bounds, noise, stroke, (&text, End::Left));
        } else {
            let stroke = Stroke::new(1.0, colors.weak.gamma_multiply(0.6));
            level_ui(plot, bounds, noise, stroke, (&level, End::Right));
        }
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
