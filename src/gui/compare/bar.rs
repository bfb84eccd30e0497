//! The bar over two compared pictures: how they are shown, and how far they are apart.

use egui::{Align, Button, Frame, Layout, Margin, RichText, Ui, Vec2};

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
        Frame::new()
            .fill(ui.visuals().panel_fill)
            .inner_margin(Margin::symmetric(12, 5))
            .show(ui, |ui| {
                // Its height is its own: where there is more room, it takes none of it.
                let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
                let layout = Layout::right_to_left(Align::Center);
                ui.allocate_ui_with_layout(size, layout, |ui| {
                    let close = ui
                        .button("Close")
                        .on_hover_text("Stop comparing")
                        .clicked()
                        .then_some(Asked::Close);
                    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                        self.modes_ui(ui);
                        ui.spacing_mut().item_spacing.x = 8.0;
                        ui.add_space(4.0);
                        let names = format!("{a} against {}", self.name);
                        ui.add(egui::Label::new(RichText::new(names).strong()).truncate());
                        self.distance_ui(ui);
                    });
                    close
                })
                .inner
            })
            .inner
    }

    fn modes_ui(&mut self, ui: &mut Ui) {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (mode, _) in Mode::ALL {
            let (name, meaning) = match mode {
                Mode::Wipe => ("Wipe", "Drag the divider between the two"),
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

    fn distance_ui(&self, ui: &mut Ui) {
        ui.label(RichText::new("·").weak());
        match &self.distance {
            None => {
                ui.label(RichText::new("measuring…").weak());
            }
            Some(Err(why)) => {
                let text = RichText::new(why).color(ui.visuals().warn_fg_color);
                ui.add(egui::Label::new(text).truncate());
            }
            Some(Ok(distance)) => {
                let words = in_words(distance);
                ui.add(egui::Label::new(words).truncate()).on_hover_text(
                    "Over all pixels and channels, on linear values. RMSE: root of the mean squared difference. Relative MSE: each \
                     squared difference by the squared value of the second picture plus 0.01; its root is what noise means elsewhere. FLIP: how different they look when a \
                     screen shows them in turn, from 0 to 1",
                );
            }
        }
    }
}

fn in_words(distance: &Distance) -> String {
    if distance.differing_pixels == 0 {
        return "the same, bit for bit".to_owned();
    }
    let mut parts = vec![
        format!("RMSE {}", format_number(distance.rmse, 5)),
        format!(
            "relative MSE {} (root {})",
            format_number(distance.relmse, 5),
            percent(distance.relmse.sqrt())
        ),
    ];
    if let Some(flip) = distance.flip {
        parts.push(format!("FLIP {}", format_number(flip, 4)));
    }
    if distance.non_finite_pixels > 0 {
        let count = usize::try_from(distance.non_finite_pixels).unwrap_or(usize::MAX);
        let pixels = counted(count, "pixel", "pixels");
        parts.push(format!("{pixels} without finite value left out"));
    }
    parts.join("  ·  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_read_well() {
        let mut distance = Distance {
            rmse: 0.0123,
            relmse: 0.0004,
            flip: Some(0.0321),
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
        distance.differing_pixels = 0;
        assert_eq!(in_words(&distance), "the same, bit for bit");
    }
}
