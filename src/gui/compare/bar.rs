//! The bar over two compared pictures: how they are shown, and how far they are apart.

use egui::{Align, Button, Color32, Frame, Layout, Margin, RichText, TextStyle, Ui, Vec2};

use super::file::look_in_words;
use super::{Comparison, Distance, Mode};
use crate::gui::widgets::{counted, format_number, percent};
use crate::scene::Choice;

/// What was asked for in the bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Compare no more.
    Close,
}

impl Comparison {
    /// Draws the bar; `a`: what the picture that is looked at is called.
    pub fn bar_ui(&mut self, ui: &mut Ui, a: &str) -> Option<Asked> {
        let figures = self.figures(ui);
        Frame::new()
            .fill(ui.visuals().panel_fill)
            .inner_margin(Margin::symmetric(12, 5))
            .show(ui, |ui| {
                let width = ui.available_width();
                let fit = figures.fit(ui, width - CONTROLS_WIDTH);
                // Its height is its own: where there is more room, it takes none of it.
                let size = Vec2::new(width, ui.spacing().interact_size.y);
                let layout = Layout::right_to_left(Align::Center);
                let asked = ui.allocate_ui_with_layout(size, layout, |ui| {
                    let close = ui
                        .button("Close")
                        .on_hover_text("Stop comparing")
                        .clicked()
                        .then_some(Asked::Close);
                    if let Fit::Beside(text) = &fit {
                        figures.label_ui(ui, text);
                    }
                    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                        self.modes_ui(ui);
                        ui.spacing_mut().item_spacing.x = 8.0;
                        ui.add_space(4.0);
                        let names = format!("{a} against {}", self.name);
                        let label = egui::Label::new(RichText::new(&names).strong()).truncate();
                        ui.add(label.show_tooltip_when_elided(false))
                            .on_hover_text(names);
                    });
                    close
                });
                if let Fit::Below(text) = &fit {
                    figures.label_ui(ui, text);
                }
                asked.inner
            })
            .inner
    }

    fn modes_ui(&mut self, ui: &mut Ui) {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (mode, _) in Mode::ALL {
            let (name, meaning) = match mode {
                Mode::Wipe => (
                    "Wipe",
                    "Drag the divider between the two, or press the arrow keys left and right",
                ),
                Mode::Flip => ("Flip", "One after the other: X, or a click here again"),
                Mode::Difference => (
                    "Difference",
                    "How far each channel is apart, white where most; magenta where one has no finite value",
                ),
            };
            let button = Button::new(name).selected(self.mode == *mode);
            let response = ui
                .add(button)
                .accessible_name(format!("Compare: {name}"))
                .on_hover_text(meaning);
            if response.clicked() {
                if *mode == Mode::Flip && self.mode == Mode::Flip {
                    self.shows_other = !self.shows_other;
                }
                self.mode = *mode;
            }
        }
    }

    /// What there is to say of how far the pictures are apart.
    fn figures(&self, ui: &Ui) -> Figures {
        let visuals = ui.visuals();
        let saved_as = self.saved_look.as_ref().map(|look| {
            let look = look_in_words(look);
            (
                format!("  ·  both with what the file was saved with: {look}"),
                format!("  ·  both with {look}"),
            )
        });
        let (saved_as, saved_as_short) = saved_as.unwrap_or_default();
        let (long, short, color) = match &self.distance {
            None => {
                let words = "measuring…".to_owned();
                (words.clone(), words, visuals.weak_text_color())
            }
            Some(Err(why)) => (why.clone(), why.clone(), visuals.warn_fg_color),
            Some(Ok(distance)) => (
                in_words(distance) + &saved_as,
                in_short(distance) + &saved_as_short,
                visuals.text_color(),
            ),
        };
        Figures { long, short, color }
    }
}

/// How far two pictures are apart, in words: all of them, and fewer.
struct Figures {
    long: String,
    short: String,
    color: Color32,
}

/// Where they fit.
enum Fit<'a> {
    /// Beside the names of the pictures.
    Beside(&'a str),
    /// In lines of their own.
    Below(&'a str),
}

impl Figures {
    /// The most that can be read in `beside` points beside modes and close, else in a line as wide as the bar.
    fn fit(&self, ui: &Ui, beside: f32) -> Fit<'_> {
        let font = TextStyle::Body.resolve(ui.style());
        let width = |text: &str| {
            let painter = ui.painter();
            let galley = painter.layout_no_wrap(text.to_owned(), font.clone(), self.color);
            galley.size().x
        };
        if width(&self.long) <= beside {
            Fit::Beside(&self.long)
        } else if width(&self.long) <= ui.available_width() {
            Fit::Below(&self.long)
        } else {
            // What still does not fit is wrapped.
            Fit::Below(&self.short)
        }
    }

    fn label_ui(&self, ui: &mut Ui, text: &str) {
        let label = egui::Label::new(RichText::new(text).color(self.color)).wrap();
        ui.add(label)
            .on_hover_text(format!("{}\n{MEANING}", self.long));
    }
}

/// What modes, Close and the beginning of the pictures' names take of the bar, in points.
const CONTROLS_WIDTH: f32 = 420.0;

/// Of the figures.
const MEANING: &str = "Over all pixels and channels that both pictures show, on linear values. RMSE: root of the mean squared \
                       difference. Relative MSE: each squared difference by the squared value of the second picture plus 0.01; its root is \
                       what noise means elsewhere. FLIP: how different they look when a screen shows them in turn, from 0 to 1; it takes a \
                       while, so it is measured once both renders have ended. A PNG that was saved with an exposure, a tone curve or a \
                       gamma holds what a screen showed: the first picture is given the same, and both are measured as that screen's light";

fn in_words(distance: &Distance) -> String {
    let relmse = format!(
        "relative MSE {} (root {})",
        format_number(distance.relmse, 5),
        percent(distance.relmse.sqrt())
    );
    let flip = distance.flip.map_or_else(
        || "FLIP when the render has ended".to_owned(),
        |flip| format!("FLIP {}", format_number(flip, 4)),
    );
    in_parts(distance, [relmse, flip])
}

/// [`in_words`], in fewer of them.
fn in_short(distance: &Distance) -> String {
    let relmse = format!("rel. MSE {}", format_number(distance.relmse, 3));
    let flip = distance.flip.map_or_else(
        || "FLIP later".to_owned(),
        |flip| format!("FLIP {}", format_number(flip, 3)),
    );
    in_parts(distance, [relmse, flip])
}

fn in_parts(distance: &Distance, figures: [String; 2]) -> String {
    let mut parts = Vec::new();
    if distance.differing_pixels == 0 {
        parts.push("the same, bit for bit".to_owned());
    } else {
        parts.push(format!("RMSE {}", format_number(distance.rmse, 5)));
        parts.extend(figures);
    }
    if let Some(shared) = distance.shared {
        let [width, height] = [shared.region.width, shared.region.height];
        parts.push(format!("over {width} × {height} that both show"));
    }
    if distance.non_finite_pixels > 0 && distance.differing_pixels > 0 {
        let count = usize::try_from(distance.non_finite_pixels).unwrap_or(usize::MAX);
        let pixels = counted(count, "pixel", "pixels");
        parts.push(format!("{pixels} without finite value left out"));
    }
    parts.join("  ·  ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::part::Part;
    use crate::render::Region;

    #[test]
    fn distances_read_well() {
        let mut distance = Distance {
            rmse: 0.0123,
            relmse: 0.0004,
            flip: Some(0.0321),
            shared: None,
            differing_pixels: 7,
            non_finite_pixels: 0,
            white: 0.25,
        };
        assert_eq!(
            in_words(&distance),
            "RMSE 0.0123  ·  relative MSE 4.000e-4 (root 2.0 %)  ·  FLIP 0.0321"
        );
        distance.non_finite_pixels = 1;
        assert!(
            in_words(&distance).ends_with("FLIP 0.0321  ·  1 pixel without finite value left out")
        );
        distance.non_finite_pixels = 0;
        assert_eq!(
            in_short(&distance),
            "RMSE 0.0123  ·  rel. MSE 4.000e-4  ·  FLIP 0.032"
        );
        distance.flip = None;
        assert!(in_words(&distance).ends_with("FLIP when the render has ended"));
        distance.differing_pixels = 0;
        assert_eq!(in_words(&distance), "the same, bit for bit");
        let region = Region {
            x: 1,
            y: 2,
            width: 30,
            height: 20,
        };
        let of = [100, 80];
        distance.shared = Some(Part { region, of });
        assert_eq!(
            in_words(&distance),
            "the same, bit for bit  ·  over 30 × 20 that both show"
        );
    }
}
