//! What the picture holds under the mouse, in a line below it.

use egui::{Color32, CornerRadius, RichText, Sense, Ui, Vec2};

use super::widgets::{format_number, grouped, percent};
use crate::accel::Visits;

/// Height of the line, in points.
pub const HEIGHT: f32 = 22.0;

/// The values of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelValues {
    /// Of the picture, or of the layer that is looked at.
    pub linear: [f32; 3],
    /// As it is on the screen.
    pub color: Color32,
    /// The estimated error of each channel of the picture, where it is kept.
    pub error: Option<[f32; 3]>,
}

/// The surface in the middle of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The object's name.
    pub object: String,
    /// The material's name.
    pub material: String,
    /// Which triangle of the scene.
    pub triangle: u32,
    /// How far from the eye, in scene units.
    pub distance: f64,
}

/// What is known of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// Column and row from the top left, from 0.
    pub pixel: [u32; 2],
    /// What it holds.
    pub values: PixelValues,
    /// What the picture that is compared with holds there.
    pub other: Option<[f32; 3]>,
    /// What is seen there; `None` where that is the background, or where the scene has changed since.
    pub surface: Option<Surface>,
    /// What the ray through its middle visits of the structure in use; `None` where the scene has changed since.
    pub visits: Option<Visits>,
}

impl Inspected {
    /// All of it, in a line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let [x, y] = self.pixel;
        let PixelValues {
            linear,
            color,
            error,
        } = self.values;
        let [r, g, b, _] = color.to_array();
        let mut parts = vec![format!("{x}, {y}"), format!("linear {}", numbers(linear))];
        if linear.iter().all(|channel| channel.is_finite()) {
            parts.push(format!("shown {r} {g} {b}"));
        } else {
            parts.push("not finite: shown in magenta".to_owned());
        }
        if let Some(other) = self.other {
            parts.push(format!("other {}", numbers(other)));
        }
        if let Some(error) = error {
            let worst = error.into_iter().fold(0.0, f32::max);
            let value = linear.into_iter().fold(0.0, f32::max);
            let share = f64::from(worst) / f64::from(value);
            let relative = if share.is_finite() {
                format!(" ({})", percent(share))
            } else {
                String::new()
            };
            parts.push(format!(
                "error {}{relative}",
                format_number(worst.into(), 4)
            ));
        }
        if let Some(surface) = &self.surface {
            parts.push(format!("{}, {}", surface.object, surface.material));
            parts.push(format!("triangle {}", grouped(surface.triangle.into())));
            parts.push(format!("distance {}", format_number(surface.distance, 3)));
        }
        if let Some(Visits { nodes, blocks }) = self.visits {
            parts.push(format!("steps {nodes} + {blocks}"));
        }
        parts.join("  ·  ")
    }
}

fn numbers(rgb: [f32; 3]) -> String {
    rgb.map(|channel| format_number(channel.into(), 4))
        .join(" ")
}

/// Draws the line. `scale`: pixels of the screen per pixel of the picture; `is_live`: whether the wheel moves the camera there.
pub fn inspector_ui(ui: &mut Ui, inspected: Option<&Inspected>, scale: f32, is_live: bool) {
    ui.horizontal(|ui| {
        ui.set_min_height(HEIGHT);
        ui.spacing_mut().item_spacing.x = 8.0;
        let zoom = format!("{:.0} %", scale * 100.0);
        let enlarging = if is_live { "press +" } else { "turn the wheel" };
        ui.label(RichText::new(zoom).strong().size(12.0))
            .on_hover_text(format!(
                "Pixels of the screen per pixel of the picture; {enlarging} over the picture to enlarge it"
            ));
        let Some(inspected) = inspected else {
            let hint =
                format!("Point at the picture to see its values  ·  {enlarging} to enlarge it");
            ui.label(RichText::new(hint).weak().size(12.0));
            return;
        };
        let (swatch, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
        let radius = CornerRadius::same(2);
        ui.painter().rect_filled(swatch, radius, inspected.values.color);
        let words = RichText::new(inspected.in_words()).size(12.0);
        ui.add(egui::Label::new(words).truncate());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_told_in_a_line() {
        let mut inspected = Inspected {
            pixel: [12, 7],
            values: PixelValues {
                linear: [0.5, 0.25, 2.0],
                color: Color32::from_rgb(188, 137, 255),
                error: Some([0.01, 0.0, 0.02]),
            },
            other: None,
            surface: Some(Surface {
                object: "ram".to_owned(),
                material: "clay".to_owned(),
                triangle: 1234,
                distance: 4.25,
            }),
            visits: Some(Visits {
                nodes: 5,
                blocks: 2,
            }),
        };
        assert_eq!(
            inspected.in_words(),
            "12, 7  ·  linear 0.5 0.25 2  ·  shown 188 137 255  ·  error 0.02 (1.0 %)  ·  ram, clay  ·  triangle 1,234  ·  \
             distance 4.25  ·  steps 5 + 2"
        );
        inspected.values.linear[1] = f32::NAN;
        inspected.values.error = None;
        inspected.surface = None;
        inspected.visits = None;
        assert_eq!(
            inspected.in_words(),
            "12, 7  ·  linear 0.5 NaN 2  ·  not finite: shown in magenta"
        );
    }
}
