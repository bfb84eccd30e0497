//! What the colours of mode `steps` mean, over a picture that shows them.

use egui::{Color32, Rect, Ui};

use super::legend::Legend;
use crate::render::{MOST_STEPS, display, steps_color};
use crate::scene::Display;

/// Numbers of steps that are written under the bar.
const MARKS: [u64; 5] = [0, 3, 15, 63, MOST_STEPS];

/// Draws the legend into the lower left corner of the picture in `frame`, in the colours that it has as it is shown.
pub fn legend_ui(ui: &Ui, frame: Rect, display: &Display) {
    let marks = MARKS.map(|steps| {
        let more = if steps == MOST_STEPS { "+" } else { "" };
        (share_of(steps), format!("{steps}{more}"))
    });
    let legend = Legend {
        start: "Nodes and blocks that a ray visits",
        end: "",
        marks: &marks,
        name: format!("Colours of 0 to {MOST_STEPS} steps"),
        explanation: "Steps through the structure that a ray takes to find what it hits",
    };
    legend.show_ui(ui, frame, |share| {
        let [r, g, b] = display::encode_8(steps_color(steps_at(share)).to_array(), display);
        Color32::from_rgb(r, g, b)
    });
}

/// Where that many steps are on the bar.
fn share_of(steps: u64) -> f32 {
    (steps as f32 + 1.0).log2() / (MOST_STEPS as f32 + 1.0).log2()
}

/// The steps at that place of the bar.
fn steps_at(share: f32) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 0 and at most the most steps"
    )]
    let steps = ((MOST_STEPS as f32 + 1.0).powf(share) - 1.0).round() as u64;
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_goes_from_none_to_the_most() {
        for steps in MARKS {
            assert_eq!(steps_at(share_of(steps)), steps);
        }
        assert_eq!([steps_at(0.0), steps_at(1.0)], [0, MOST_STEPS]);
    }
}
