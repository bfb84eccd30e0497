//! The report's chart drawn in the window: the curves of `report.svg` in the window's colours.

use egui::{Color32, RichText, Sense, Stroke, Ui, Vec2};
use egui_plot::{
    FilledArea, HoverPosition, Line as PlotLine, LineStyle, PlotPoints, PlotUi, Points,
};

use crate::analysis::report::{Chart, Curve, Line, Point};
use crate::gui::log_plot::{End, bounds_of, color_of_curve, level_ui, log_plot_ui, place};
use crate::gui::theme;
use crate::math::{percent, three_digits};

/// The colour of variant number `number`; the scene as it is has the accent's.
pub(super) fn color_of(number: usize) -> Color32 {
    match number {
        0 => theme::ACCENT,
        number => color_of_curve(number - 1),
    }
}

/// Draws the curves into all the room there is.
pub(super) fn chart_ui(ui: &mut Ui, chart: &Chart) {
    let curves: Vec<Vec<&Point>> = chart.curves.iter().map(|c| c.shown().collect()).collect();
    let points = || curves.iter().flatten();
    let seconds: Vec<f64> = points().map(|point| point.x).collect();
    if seconds.is_empty() {
        ui.centered_and_justified(|ui| ui.weak("These pictures have no noise"));
        return;
    }
    let noises: Vec<f64> = points().map(|point| point.y.median).collect();
    let bounds = bounds_of(&seconds, &noises);
    let weak = ui.visuals().weak_text_color();
    let hover_text = |position: &HoverPosition<'_>| hover_text(chart, &curves, position);
    log_plot_ui(ui, "report", bounds, hover_text, |plot| {
        for level in &chart.levels {
            let stroke = Stroke::new(1.0, weak.gamma_multiply(0.6));
            level_ui(plot, bounds, level.y, stroke, (&level.label, End::Right));
        }
        for (index, (curve, points)) in chart.curves.iter().zip(&curves).enumerate() {
            curve_ui(plot, index, curve, points, bounds.min()[1]);
        }
    });
}

/// The curve with number `index`, which is what [`hover_text`] knows it by. Ranges that a logarithmic axis has no place for end at
/// `lowest`.
fn curve_ui(plot: &mut PlotUi<'_>, index: usize, curve: &Curve, points: &[&Point], lowest: f64) {
    let color = color_of(curve.color);
    let places = || -> PlotPoints<'static> {
        let places = points.iter().map(|point| place(point.x, point.y.median));
        places.collect()
    };
    if curve.band {
        let over = |value: fn(&Point) -> f64| -> Vec<f64> {
            let values = points.iter().map(|point| value(point).log10());
            values.map(|value| value.max(lowest)).collect()
        };
        let seconds: Vec<f64> = points.iter().map(|point| point.x.log10()).collect();
        let area = FilledArea::new(
            "",
            &seconds,
            &over(|point| point.y.min),
            &over(|point| point.y.max),
        );
        plot.add(
            area.fill_color(color.gamma_multiply(0.2))
                .allow_hover(false),
        );
    }
    let (style, width) = match curve.line {
        Line::Solid => (LineStyle::Solid, 2.2),
        Line::Dashed => (LineStyle::dashed_dense(), 1.6),
        Line::Dotted => (LineStyle::dotted_dense(), 1.6),
    };
    plot.line(
        PlotLine::new(index.to_string(), places())
            .stroke(Stroke::new(width, color))
            .style(style),
    );
    if curve.line == Line::Solid {
        let markers = Points::new("", places()).radius(3.0).color(color);
        plot.points(markers.allow_hover(false));
    }
}

/// What is known where the mouse is.
fn hover_text(
    chart: &Chart,
    curves: &[Vec<&Point>],
    position: &HoverPosition<'_>,
) -> Option<String> {
    let HoverPosition::NearDataPoint {
        plot_name, index, ..
    } = position
    else {
        return None;
    };
    let number = plot_name.parse::<usize>().ok()?;
    let point = curves.get(number)?.get(*index)?;
    let [median, min, max] = [point.y.median, point.y.min, point.y.max].map(percent);
    Some(format!(
        "{}\nnoise {median} ({min} – {max})\nafter {} s",
        chart.curves.get(number)?.name,
        three_digits(point.x),
    ))
}

/// The names of the curves, each with its line.
pub(super) fn legend_ui(ui: &mut Ui, chart: &Chart) {
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.spacing_mut().interact_size.y = 14.0;
    for curve in &chart.curves {
        ui.horizontal(|ui| {
            line_ui(ui, curve);
            let name = RichText::new(&curve.name).size(12.0);
            ui.add(egui::Label::new(name).truncate());
        });
        if let Some(note) = &curve.note {
            ui.horizontal(|ui| {
                ui.add_space(28.0 + ui.spacing().item_spacing.x);
                ui.label(RichText::new(note).size(11.0).weak());
            });
        }
    }
}

/// A piece of the curve's line.
fn line_ui(ui: &mut Ui, curve: &Curve) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(28.0, 14.0), Sense::hover());
    let color = color_of(curve.color);
    let path = [rect.left_center(), rect.right_center()];
    let painter = ui.painter();
    match curve.line {
        Line::Solid => {
            painter.line_segment(path, Stroke::new(2.2, color));
            painter.circle_filled(rect.center(), 3.0, color);
        }
        Line::Dashed => {
            let stroke = Stroke::new(1.6, color);
            painter.extend(egui::Shape::dashed_line(&path, stroke, 6.0, 4.0));
        }
        Line::Dotted => {
            painter.extend(egui::Shape::dotted_line(&path, color, 4.0, 0.9));
        }
    }
}
