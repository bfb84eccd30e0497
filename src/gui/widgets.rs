//! Building blocks of the panels: rows of label and control that line up, numbers with units, colours.
//!
//! Every control gets an accessible name and a tooltip through [`row_ui`], so a panel cannot forget them.

use std::ops::RangeInclusive;

use egui::{Align, Color32, Layout, Response, RichText, Ui, Vec2};

pub use super::number_field::Number;

use crate::math::DVec3;
use crate::render::Interval;
use crate::scene::{Choice, Rgb};

/// Width of the labels at the left, in points.
const LABEL_WIDTH: f32 = 104.0;

/// Most height of a list to choose from: what the longest takes, all layers, in points.
const COMBO_HEIGHT: f32 = 360.0;

/// A part of the side panel with a heading to fold it by.
pub fn section_ui(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    ui.add_space(2.0);
    egui::CollapsingHeader::new(RichText::new(title).strong().size(13.5))
        .id_salt(("section", title))
        .default_open(open)
        .show_unindented(ui, |ui| {
            ui.add_space(2.0);
            contents(ui);
            ui.add_space(6.0);
        });
    ui.separator();
}

/// A row with `label` at the left and `control` in what is left of the width, named and explained by `tooltip`.
pub fn row_ui(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    control: impl FnOnce(&mut Ui) -> Response,
) -> Response {
    ui.horizontal(|ui| {
        let label = label_ui(ui, label, tooltip);
        let response = ui
            .with_layout(Layout::left_to_right(Align::Center), control)
            .inner;
        response.labelled_by(label.id).on_hover_text(tooltip)
    })
    .inner
}

/// The label of a row; the control follows.
fn label_ui(ui: &mut Ui, label: &str, tooltip: &str) -> Response {
    let height = ui.spacing().interact_size.y;
    ui.allocate_ui_with_layout(
        Vec2::new(LABEL_WIDTH, height),
        Layout::left_to_right(Align::Center),
        |ui| {
            ui.set_min_width(LABEL_WIDTH);
            ui.add(egui::Label::new(label).truncate())
                .on_hover_text(tooltip)
        },
    )
    .inner
}

/// A number as people read it: no more than `decimals` digits after the point where it has a usual size, scientific where
/// it has not.
#[must_use]
pub fn format_number(number: f64, decimals: usize) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        return format!("{number:.3e}");
    }
    let text = format!("{number:.decimals$}");
    if text.contains('.') {
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0" } else { text }.to_owned()
    } else {
        text
    }
}

/// A whole number with groups of three digits: 1,234,567.
#[must_use]
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `count` things, in words.
#[must_use]
pub fn counted(count: usize, one: &str, many: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        _ => format!("{} {many}", grouped(count as u64)),
    }
}

/// A share in percent with two digits, or three where they stand before the point.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{} %", percent_number(share))
}

/// A share that somebody chose, in percent, as it is.
#[must_use]
pub fn chosen_percent(share: f64) -> String {
    format!("{} %", format_number(share * 100.0, 2))
}

/// A level of noise and the interval it lies in.
#[must_use]
pub fn noise_in_words(noise: Interval) -> String {
    let [low, high] = [noise.low, noise.high].map(percent_number);
    format!("{} ({low} – {high})", percent(noise.value))
}

fn percent_number(share: f64) -> String {
    let percent = share * 100.0;
    let decimals = match percent.abs() {
        size if size >= 9.95 || size == 0.0 => 0,
        size if size >= 0.995 => 1,
        size if size >= 0.0995 => 2,
        _ => 3,
    };
    format!("{percent:.decimals$}")
}

/// A row with a number.
pub fn number_row_ui(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut f64,
    number: &Number,
) -> Response {
    row_ui(ui, label, tooltip, |ui| {
        number.field_ui(ui, ui.available_width(), value, None)
    })
}

/// A row with a whole number.
pub fn integer_row_ui<N: egui::emath::Numeric>(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut N,
    range: RangeInclusive<N>,
    speed: f64,
) -> Response {
    let number = Number {
        decimals: 0,
        ..Number::within(range.start().to_f64()..=range.end().to_f64(), speed)
    };
    row_ui(ui, label, tooltip, |ui| {
        let mut whole = value.to_f64();
        let response = number.field_ui(ui, ui.available_width(), &mut whole, None);
        // Only an edit may touch the stored value: the largest whole numbers are rounded.
        if response.changed() {
            *value = N::from_f64(whole);
        }
        response
    })
}

/// A row with three numbers, X, Y and Z.
pub fn vector_row_ui(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut DVec3,
    number: &Number,
) -> Response {
    const AXES: [(&str, Color32, Color32); 3] = [
        (
            "X",
            Color32::from_rgb(0xe0, 0x6c, 0x6c),
            Color32::from_rgb(0xb0, 0x30, 0x30),
        ),
        (
            "Y",
            Color32::from_rgb(0x7c, 0xc0, 0x6a),
            Color32::from_rgb(0x2f, 0x78, 0x20),
        ),
        (
            "Z",
            Color32::from_rgb(0x6f, 0xa4, 0xf0),
            Color32::from_rgb(0x28, 0x58, 0xb0),
        ),
    ];
    ui.horizontal(|ui| {
        label_ui(ui, label, tooltip);
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
        let dark = ui.visuals().dark_mode;
        let mut components = [value.x, value.y, value.z];
        let mut whole: Option<Response> = None;
        for ((name, on_dark, on_light), component) in AXES.into_iter().zip(&mut components) {
            let tint = if dark { on_dark } else { on_light };
            let response = ui
                .scope(|ui| {
                    ui.spacing_mut().button_padding.x = 4.0;
                    let prefix = RichText::new(format!("{name} ")).color(tint).size(11.0);
                    number.field_ui(ui, width, component, Some(prefix))
                })
                .inner
                .accessible_name(format!("{label} {name}"))
                .on_hover_text(tooltip);
            whole = Some(match whole {
                Some(whole) => whole.union(response),
                None => response,
            });
        }
        *value = DVec3::from_array(components);
        whole.unwrap_or_else(|| ui.response())
    })
    .inner
}

/// A row with a colour whose channels lie in `0..=1`.
pub fn color_row_ui(ui: &mut Ui, label: &str, tooltip: &str, color: &mut Rgb) -> Response {
    row_ui(ui, label, tooltip, |ui| {
        let response = color_button_ui(ui, color);
        ui.label(RichText::new(in_words(*color)).weak().small());
        response
    })
}

/// A row with light: a colour and how much of it. `unit` belongs to the amount, the largest channel.
pub fn light_row_ui(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut Rgb,
    unit: &'static str,
) -> Response {
    row_ui(ui, label, tooltip, |ui| {
        let (mut color, mut amount) = color_and_amount(*value);
        let picked = color_button_ui(ui, &mut color);
        let width = ui.available_width();
        let number = Number {
            decimals: 3,
            ..Number::within(0.0..=f64::MAX, (amount * 0.01).max(0.002)).with_suffix(unit)
        };
        let moved = number
            .field_ui(ui, width, &mut amount, None)
            .accessible_name(format!("{label} amount"))
            .on_hover_text(tooltip);
        if picked.changed() || moved.changed() {
            *value = color * amount;
        }
        picked.union(moved)
    })
}

/// A linear colour as a button that opens a picker.
fn color_button_ui(ui: &mut Ui, color: &mut Rgb) -> Response {
    let mut rgb = color.as_vec3().to_array();
    let response = ui.color_edit_button_rgb(&mut rgb);
    // Only an edit may touch the stored value: showing it would round it.
    if response.changed() {
        *color = DVec3::from_array(rgb.map(f64::from));
    }
    response
}

/// Splits light into a colour whose largest channel is 1 and the amount that gives it back.
fn color_and_amount(value: Rgb) -> (Rgb, f64) {
    let amount = value.max_element();
    if amount > 0.0 && amount.is_finite() {
        (value / amount, amount)
    } else {
        (Rgb::ONE, 0.0)
    }
}

fn in_words(color: Rgb) -> String {
    let [r, g, b] = color.to_array().map(|channel| format_number(channel, 2));
    format!("{r}, {g}, {b}")
}

/// A row that offers every value of a choice as one strip of buttons. `name_of` says what to call them on screen.
pub fn choice_row_ui<T: Choice>(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut T,
    name_of: impl Fn(T) -> (&'static str, &'static str),
) {
    ui.horizontal(|ui| {
        label_ui(ui, label, tooltip);
        ui.spacing_mut().item_spacing.x = 2.0;
        let width =
            (ui.available_width() - 2.0 * (T::ALL.len() as f32 - 1.0)) / T::ALL.len() as f32;
        for (candidate, _) in T::ALL {
            let (name, meaning) = name_of(*candidate);
            let button = egui::Button::new(name)
                .selected(*value == *candidate)
                .min_size(Vec2::new(width, ui.spacing().interact_size.y));
            let response = ui
                .add(button)
                .accessible_name(format!("{label}: {name}"))
                .on_hover_text(meaning);
            if response.clicked() {
                *value = *candidate;
            }
        }
    });
}

/// A row with a list to choose from.
pub fn combo_row_ui<T: PartialEq + Clone>(
    ui: &mut Ui,
    label: &str,
    tooltip: &str,
    value: &mut T,
    choices: &[(T, String)],
) {
    row_ui(ui, label, tooltip, |ui| {
        let shown = choices
            .iter()
            .find(|(choice, _)| choice == value)
            .map_or("", |(_, name)| name);
        egui::ComboBox::from_id_salt(label)
            .selected_text(shown)
            .width(ui.available_width())
            .height(COMBO_HEIGHT)
            .truncate()
            .show_ui(ui, |ui| {
                for (choice, name) in choices {
                    if ui.selectable_value(value, choice.clone(), name).clicked() {
                        // A click of the mouse closes the list anyway, one of a screen reader does not.
                        ui.close();
                    }
                }
            })
            .response
    });
}

/// Text at the end of a line that may be selected: fainter than the name before it, and still read on the colour of selection.
#[must_use]
pub fn faint_text(ui: &Ui, text: impl Into<String>, is_selected: bool) -> RichText {
    let text = RichText::new(text);
    if is_selected {
        let visuals = &ui.visuals().selection;
        text.color(visuals.bg_fill.lerp_to_gamma(visuals.stroke.color, 0.8))
    } else {
        text.weak()
    }
}

/// A row with a switch.
pub fn switch_row_ui(ui: &mut Ui, label: &str, tooltip: &str, on: &mut bool) -> Response {
    row_ui(ui, label, tooltip, |ui| {
        let size = Vec2::new(32.0, 18.0);
        let (rect, mut response) = ui.allocate_exact_size(size, egui::Sense::click());
        if response.clicked() {
            *on = !*on;
            response.mark_changed();
        }
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::CheckBox, ui.is_enabled(), *on, label)
        });
        if ui.is_rect_visible(rect) {
            let shift = ui.ctx().animate_bool_responsive(response.id, *on);
            let visuals = ui.style().interact(&response);
            let off = visuals.bg_fill;
            let track = off.lerp_to_gamma(super::theme::ACCENT, shift);
            let radius = rect.height() / 2.0;
            ui.painter().rect(
                rect,
                radius,
                track,
                visuals.bg_stroke,
                egui::StrokeKind::Inside,
            );
            let x = egui::lerp(rect.left() + radius..=rect.right() - radius, shift);
            let knob = egui::pos2(x, rect.center().y);
            ui.painter()
                .circle_filled(knob, radius - 3.0, Color32::WHITE);
        }
        response
    })
}

/// A row with a number that may be left out: a switch, and where it is on, the number. `default` is what switching it on starts
/// with; a value is shown `scale` times as large as it is. The number is called `number_name` by assistive technology.
pub fn optional_number_row_ui(
    ui: &mut Ui,
    [label, number_name]: [&str; 2],
    tooltip: &str,
    value: &mut Option<f64>,
    [default, scale]: [f64; 2],
    number: &Number,
) {
    ui.horizontal(|ui| {
        let mut is_on = value.is_some();
        if switch_row_ui(ui, label, tooltip, &mut is_on).changed() {
            *value = is_on.then_some(default);
        }
        let Some(value) = value else { return };
        let mut shown = *value * scale;
        let response = number
            .field_ui(ui, ui.available_width(), &mut shown, None)
            .accessible_name(number_name)
            .on_hover_text(tooltip);
        // Only an edit may touch the stored value: showing it would round it.
        if response.changed() {
            *value = shown / scale;
        }
    });
}

/// The button for the one thing to do next.
pub fn primary_button(text: &str) -> egui::Button<'_> {
    egui::Button::new(RichText::new(text).strong().color(super::theme::ON_ACCENT))
        .fill(super::theme::ACCENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well_at_every_size() {
        let shown = |number| format_number(number, 3);
        assert_eq!(shown(1.0), "1");
        assert_eq!(shown(-0.25), "-0.25");
        assert_eq!(shown(1.0 / 3.0), "0.333");
        assert_eq!(shown(-0.0), "0");
        assert_eq!(shown(100.0), "100");
        assert_eq!(shown(1.5e-9), "1.500e-9");
        assert_eq!(shown(2.5e12), "2.500e12");
        assert_eq!(grouped(1_234_567), "1,234,567");
        assert_eq!(grouped(999), "999");
        assert_eq!(counted(1, "light", "lights"), "1 light");
        let shares = [0.0, 0.000_42, 0.0034, 0.021, 0.0996, 0.34, 1.25];
        let shown = shares.map(percent);
        assert_eq!(
            shown,
            ["0 %", "0.042 %", "0.34 %", "2.1 %", "10 %", "34 %", "125 %"]
        );
    }

    #[test]
    fn light_splits_into_color_and_amount_and_back() {
        let value = Rgb::new(20.0, 10.0, 5.0);
        let (color, amount) = color_and_amount(value);
        assert_eq!((color, amount), (Rgb::new(1.0, 0.5, 0.25), 20.0));
        assert_eq!(color_and_amount(Rgb::ZERO), (Rgb::ONE, 0.0));
    }
}
