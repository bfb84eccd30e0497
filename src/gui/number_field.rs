//! A field for a number: dragged, or typed as a number or a sum. It is as wide as it is told, whatever the number is.
//!
//! What is shown is rounded and short; what is edited is the whole number, and what is left as it was stays to the last bit. Text that is no
//! number is refused: the number is again what it was before, and a note at the field says so.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::{DragValue, Id, Layout, Response, RichText, TextStyle, Ui, UiBuilder, Vec2, WidgetText};

use super::sum::worked_out;
use super::widgets::format_number;

/// How long it is said that a text was refused, in seconds.
const NOTE_SECS: f64 = 4.0;
/// Room around the field in which its edge is drawn, in points.
const EDGE: f32 = 2.0;

/// How a number is shown and moved.
#[derive(Clone, Debug)]
pub struct Number {
    /// Change per point of dragging.
    pub speed: f64,
    /// What it may be.
    pub range: RangeInclusive<f64>,
    /// Its unit, with a leading blank where one belongs.
    pub suffix: &'static str,
    /// Most digits after the point; 0 for whole numbers.
    pub decimals: usize,
}

impl Number {
    /// Any number, moved by `speed`.
    #[must_use]
    pub fn any(speed: f64) -> Self {
        Self {
            speed,
            range: f64::MIN..=f64::MAX,
            suffix: "",
            decimals: 3,
        }
    }

    /// A number in `range`, moved by `speed`.
    #[must_use]
    pub fn within(range: RangeInclusive<f64>, speed: f64) -> Self {
        Self {
            range,
            ..Self::any(speed)
        }
    }

    /// The same with a unit.
    #[must_use]
    pub fn with_suffix(self, suffix: &'static str) -> Self {
        Self { suffix, ..self }
    }

    /// Draws a field of `width` points for `value`, with `prefix` before it.
    pub fn field_ui(
        &self,
        ui: &mut Ui,
        width: f32,
        value: &mut f64,
        prefix: Option<RichText>,
    ) -> Response {
        let size = Vec2::new(width.max(0.0), ui.spacing().interact_size.y);
        let (_, place) = ui.allocate_space(size);
        let layout = Layout::centered_and_justified(ui.layout().main_dir());
        let mut inside = ui.new_child(UiBuilder::new().max_rect(place).layout(layout));
        inside.shrink_clip_rect(place.expand(EDGE));
        // What is wider than its place does not make the row wider: the row never hears of it.
        self.drag_ui(&mut inside, value, prefix)
    }

    fn drag_ui(&self, ui: &mut Ui, value: &mut f64, prefix: Option<RichText>) -> Response {
        let id = ui.next_auto_id();
        let before = *value;
        let is_edited = ui.memory(|memory| memory.has_focus(id));
        let shown = if is_edited {
            Self::whole(before)
        } else {
            self.fitted(before, |text| self.fits(ui, prefix.as_ref(), text))
        };
        let refused = RefCell::new(None);
        let parser = |text: &str| {
            // What nobody changed is not rounded to what was shown.
            if text == shown {
                return Some(before);
            }
            let read = self.read(text);
            if read.is_none() {
                refused.replace(Some(text.trim().to_owned()));
            }
            read
        };
        let mut drag = DragValue::new(value)
            .speed(self.speed)
            .range(self.range.clone())
            .clamp_existing_to_range(false)
            .max_decimals(self.decimals)
            .suffix(self.suffix)
            .clip_text(true)
            .custom_parser(parser)
            .custom_formatter(|number, _| {
                if number == before {
                    shown.clone()
                } else {
                    self.usual(number)
                }
            });
        if let Some(prefix) = prefix {
            drag = drag.prefix(prefix);
        }
        let mut response = ui.add(drag);
        if value.is_nan() {
            *value = before;
        }
        if let Some(text) = settle(ui, id, value, before, refused.into_inner()) {
            note_ui(ui, &response, &text);
        }
        if value.to_bits() != before.to_bits() {
            response.mark_changed();
        }
        let whole = Self::whole(before);
        if is_edited || shown == self.usual(before) && !shown.contains('e') {
            response
        } else {
            response.on_hover_text(format!("{whole}{}", self.suffix))
        }
    }

    /// The number of a text; `None` where it is none that the field can hold.
    fn read(&self, text: &str) -> Option<f64> {
        let text = text.trim();
        let text = text.strip_suffix(self.suffix.trim()).unwrap_or(text);
        let number = worked_out(text).filter(|number| {
            number.is_finite() || *number > 0.0 && self.range.end().is_infinite()
        })?;
        Some(if self.decimals == 0 {
            number.round()
        } else {
            number
        })
    }

    /// All its digits, as they are typed.
    fn whole(number: f64) -> String {
        let size = number.abs();
        let is_usual = size == 0.0 || (1e-6..1e15).contains(&size);
        // The last bit of what was multiplied by a hundred is nobody's wish.
        let short = format!("{number:.14e}").parse().unwrap_or(number);
        let number = if (short - number).abs() <= number.abs() * f64::EPSILON {
            short
        } else {
            number
        };
        if is_usual || !number.is_finite() {
            number.to_string()
        } else {
            format!("{number:e}")
        }
    }

    /// The number as it is shown where there is room.
    fn usual(&self, number: f64) -> String {
        if self.decimals == 0 && number.abs() < 1e15 {
            format!("{number:.0}")
        } else {
            format_number(number, self.decimals)
        }
    }

    /// The number with so many digits that it `fits`, or as few as there can be.
    fn fitted(&self, number: f64, fits: impl Fn(&str) -> bool) -> String {
        let usual = self.usual(number);
        if fits(&usual) || !number.is_finite() {
            return usual;
        }
        // Digits after the point go first, as long as there are others.
        let fewer = (0..self.decimals)
            .rev()
            .map(|decimals| format_number(number, decimals));
        let fewer =
            fewer.filter(|text| !text.contains('e') && !matches!(text.as_str(), "0" | "-0"));
        let powers = (0..=2_usize)
            .rev()
            .map(|decimals| format!("{number:.decimals$e}"));
        let mut shorter = fewer.chain(powers);
        let last = format!("{number:.0e}");
        shorter.find(|text| fits(text)).unwrap_or(last)
    }

    /// Whether `text` fits into the field that `ui` has room for.
    fn fits(&self, ui: &Ui, prefix: Option<&RichText>, text: &str) -> bool {
        let width = |text: WidgetText, style: TextStyle| {
            let galley =
                text.into_galley(ui, Some(egui::TextWrapMode::Extend), f32::INFINITY, style);
            galley.size().x
        };
        let style = ui.style().drag_value_text_style.clone();
        let number = width(RichText::new(text).into(), style);
        let suffix = width(self.suffix.into(), TextStyle::Button);
        let prefix = prefix.map_or(0.0, |prefix| {
            width(prefix.clone().into(), TextStyle::Button)
        });
        number + prefix + suffix + 2.0 * ui.spacing().button_padding.x <= ui.max_rect().width()
    }
}

/// What is known of a field that is edited, or was until a moment ago.
#[derive(Clone, Copy, Debug)]
struct Edited {
    /// The number when the edit began.
    from: f64,
    /// Frames since it ended: the text is read once more in the first of them.
    frames_since: u8,
}

/// A text that was refused.
#[derive(Clone, Debug)]
struct Refused {
    text: String,
    /// Until when that is said, in seconds.
    until: f64,
}

/// Where the edit has ended with a text that was `refused`, takes it back to where it began. `before`: the number before this frame.
/// Returns what there is to say of a text that was refused a short time ago.
fn settle(
    ui: &Ui,
    id: Id,
    value: &mut f64,
    before: f64,
    refused: Option<String>,
) -> Option<String> {
    let now = ui.input(|input| input.time);
    let edited = ui.data(|data| data.get_temp::<Edited>(id));
    if ui.memory(|memory| memory.has_focus(id)) {
        let edited = edited.filter(|edited| edited.frames_since == 0);
        let from = edited.map_or(before, |edited| edited.from);
        ui.data_mut(|data| {
            data.remove::<Refused>(id);
            let frames_since = 0;
            data.insert_temp(id, Edited { from, frames_since });
        });
        return None;
    }
    if let Some(Edited { from, frames_since }) = edited {
        if let Some(text) = refused {
            *value = from;
            let until = now + NOTE_SECS;
            ui.data_mut(|data| data.insert_temp(id, Refused { text, until }));
        }
        let frames_since = frames_since + 1;
        ui.data_mut(|data| {
            if frames_since > 2 {
                data.remove::<Edited>(id);
            } else {
                data.insert_temp(id, Edited { from, frames_since });
            }
        });
    }
    let refused = ui.data(|data| data.get_temp::<Refused>(id))?;
    let left = refused.until - now;
    if left <= 0.0 {
        ui.data_mut(|data| data.remove::<Refused>(id));
        return None;
    }
    let left = std::time::Duration::try_from_secs_f64(left).unwrap_or_default();
    ui.request_repaint_after(left);
    Some(refused.text)
}

/// Says below a field that `text` was refused.
fn note_ui(ui: &Ui, field: &Response, text: &str) {
    let words = if text.is_empty() {
        "Nothing was typed; the number stays as it was".to_owned()
    } else {
        // A long one is known by its beginning.
        let start: String = text.chars().take(24).collect();
        let dots = if start == text { "" } else { "…" };
        format!("“{start}{dots}” is not a number or a sum; it stays as it was")
    };
    let tip = egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), field.id, field.rect);
    tip.show(|ui| {
        let color = ui.visuals().warn_fg_color;
        ui.label(RichText::new(words).color(color));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_as_short_as_its_field() {
        let number = Number::any(1.0);
        let shown = |value: f64, room: usize| number.fitted(value, |text| text.len() <= room);
        assert_eq!(shown(12.3456, 10), "12.346");
        assert_eq!(shown(12.3456, 5), "12.35");
        assert_eq!(shown(12.3456, 3), "12");
        assert_eq!(shown(12_345_678.123_456_789, 7), "1.235e7");
        assert_eq!(shown(12_345_678.123_456_789, 4), "1e7");
        assert_eq!(shown(-123_456.0, 6), "-1.2e5");
        assert_eq!(shown(1e300, 9), "1.000e300");
        assert_eq!(shown(1e300, 6), "1e300");
        assert_eq!(shown(0.001_234, 3), "1e-3");
        assert_eq!(shown(f64::INFINITY, 1), "inf");
        let whole = Number {
            decimals: 0,
            ..Number::any(1.0)
        };
        assert_eq!(whole.usual(4_294_967_295.0), "4294967295");
    }

    #[test]
    fn the_whole_number_is_edited() {
        let number = Number::any(1.0);
        for value in [
            0.1,
            -1.0 / 3.0,
            12_345_678.123_456_789,
            1e300,
            -4e-12,
            0.0,
            7.0,
        ] {
            let text = Number::whole(value);
            assert!(text.len() < 26, "{text}");
            let read = number.read(&text).unwrap();
            assert!((read - value).abs() <= value.abs() * f64::EPSILON, "{text}");
        }
        assert_eq!(Number::whole(0.07 * 100.0), "7");
    }

    #[test]
    fn only_numbers_are_read() {
        let number = Number::within(0.0..=f64::MAX, 1.0).with_suffix(" W/sr");
        assert_eq!(number.read(" 2*3 W/sr"), Some(6.0));
        for text in ["nan", "inf", "1e400", "-inf", "W/sr", "twenty"] {
            assert_eq!(number.read(text), None, "{text}");
        }
        let far = Number::within(0.0..=f64::INFINITY, 1.0);
        assert_eq!(far.read("inf"), Some(f64::INFINITY));
        assert_eq!(far.read("nan"), None);
    }
}
