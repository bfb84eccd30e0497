//! A plot on two logarithmic axes: noise against seconds. The plot knows linear axes only, so it is given logarithms to base 10, and
//! its grid and labels take them back.

use egui::{Align2, Color32, FontId, RichText, Stroke, Ui, Vec2};
use egui_plot::{
    AxisHints, GridInput, GridMark, HLine, HoverPosition, LineStyle, Plot, PlotBounds, PlotPoint,
    PlotUi, Text,
};

use super::widgets::format_number;

/// Colours of curves, one after the other: of one brightness, and none like the accent.
const COLORS: [Color32; 6] = [
    Color32::from_rgb(0xd0, 0x8a, 0x3c),
    Color32::from_rgb(0x5c, 0xa8, 0x6a),
    Color32::from_rgb(0xb0, 0x7a, 0xc8),
    Color32::from_rgb(0xc8, 0x6a, 0x78),
    Color32::from_rgb(0x4c, 0xa6, 0xb0),
    Color32::from_rgb(0x9c, 0x98, 0x50),
];

/// The colour of curve number `number` beside one in the accent's.
#[must_use]
pub fn color_of_curve(number: usize) -> Color32 {
    COLORS[number % COLORS.len()]
}

/// What is to be seen for all of `seconds` and `noises`, in logarithms. Ends are round numbers, so that the plot stands still while
/// curves grow.
#[must_use]
pub fn bounds_of(seconds: &[f64], noises: &[f64]) -> PlotBounds {
    let [x_min, x_max] = round_range(seconds);
    let [y_min, y_max] = round_range(noises);
    PlotBounds::from_min_max([x_min, y_min], [x_max, y_max])
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

/// A plot into all the room there is. `hover_text` tells what is known where the mouse is, and `draw` adds curves.
pub fn log_plot_ui(
    ui: &mut Ui,
    id: &str,
    bounds: PlotBounds,
    hover_text: impl Fn(&HoverPosition<'_>) -> Option<String>,
    draw: impl FnOnce(&mut PlotUi<'_>),
) {
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
    Plot::new(id)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(Vec2::ZERO)
        .grid_spacing(4.0..=260.0)
        .grid_color(ui.visuals().text_color().gamma_multiply(0.45))
        .x_grid_spacer(|input| decades(&input))
        .y_grid_spacer(|input| decades(&input))
        .custom_x_axes(vec![x_axis])
        .custom_y_axes(vec![y_axis])
        .label_formatter(hover_text)
        .show(ui, |plot| {
            plot.set_plot_bounds(bounds);
            draw(plot);
        });
}

/// A point of the plot: logarithms of seconds and noise.
#[must_use]
pub fn place(seconds: f64, noise: f64) -> [f64; 2] {
    [seconds.log10(), noise.log10()]
}

/// A dashed line at a level of noise with `text` at its `end`, where that is in sight.
pub fn level_ui(
    plot: &mut PlotUi<'_>,
    bounds: PlotBounds,
    noise: f64,
    stroke: Stroke,
    (text, end): (&str, End),
) {
    let y = noise.log10();
    if !bounds.range_y().contains(&y) {
        return;
    }
    plot.hline(
        HLine::new("", y)
            .stroke(stroke)
            .style(LineStyle::dashed_loose())
            .allow_hover(false),
    );
    let (text, x, anchor) = match end {
        End::Left => (format!(" {text}"), bounds.min()[0], Align2::LEFT_BOTTOM),
        End::Right => (format!("{text} "), bounds.max()[0], Align2::RIGHT_BOTTOM),
    };
    plot.text(
        Text::new("", PlotPoint::new(x, y), RichText::new(text).size(11.0))
            .color(stroke.color)
            .anchor(anchor)
            .allow_hover(false),
    );
}

/// The ends of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Where time begins.
    Left,
    /// Where it ends.
    Right,
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
