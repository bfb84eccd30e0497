//! What the picture holds under the mouse, in two lines below it: the values, and the surface that is seen there. Below the preview it is the
//! surface alone; the lines are as high, so that a picture lies where the preview did.

use egui::{Color32, CornerRadius, RichText, Sense, Ui, Vec2};

use super::compare::Seen;
use super::look::NOT_FINITE;
use super::widgets::{counted, format_number, grouped, percent};
use crate::accel::Visits;
use crate::math::DVec3;

/// Height of both lines, in points.
const HEIGHT: f32 = 36.0;

/// The values of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelValues {
    /// Of the picture, or of the layer that is looked at.
    pub linear: [f32; 3],
    /// What the picture looks like there on the screen, as layer, channels, exposure and tone curve are.
    pub color: Color32,
    /// The estimated error of each channel of the picture, where it is kept; not a number where it is unknown.
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
    /// What shading takes for its normal, on the side that is seen; unit.
    pub normal: DVec3,
}

impl Surface {
    /// All of it, in a line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let normal = self.normal.to_array().map(|x| format_number(x, 2));
        let parts = [
            format!("{}, {}", self.object, self.material),
            format!("triangle {}", grouped(self.triangle.into())),
            format!("distance {}", format_number(self.distance, 3)),
            format!("normal {}", normal.join(" ")),
        ];
        parts.join(SEPARATOR)
    }
}

/// How many samples were taken of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Samples {
    /// So many of each.
    OfEach(u32),
    /// So many on average: pixels have as many as they need, or the render goes on.
    OnAverage(f64),
    /// The picture is from a file that does not tell.
    Unknown,
}

/// What is known of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// Column and row from the top left, from 0.
    pub pixel: [u32; 2],
    /// What it holds.
    pub values: PixelValues,
    /// Samples that were taken of it.
    pub samples: Samples,
    /// The light that the picture which is compared with holds there, at what is seen of it in the same place, where that is known.
    pub other: Option<[f32; 3]>,
    /// What is seen there.
    pub seen: Seen,
    /// What is seen there; `None` where that is the background, or where the scene has changed since.
    pub surface: Option<Surface>,
    /// What the ray through its middle visits of the structure in use; `None` where the scene has changed since.
    pub visits: Option<Visits>,
}

impl Inspected {
    /// Where it is and its values, in a line.
    #[must_use]
    pub fn values_in_words(&self) -> String {
        let [x, y] = self.pixel;
        let PixelValues { linear, error, .. } = self.values;
        let mut parts = vec![format!("{x}, {y}"), format!("linear {}", numbers(linear))];
        if let Some(other) = self.other {
            parts.push(format!("other {}", numbers(other)));
        }
        parts.push(self.seen_in_words());
        if let Some(error) = error
            && error.iter().any(|channel| channel.is_nan())
        {
            parts.push("error unknown".to_owned());
        } else if let Some(error) = error {
            let worst = error.into_iter().fold(0.0, f32::max);
            let value = linear.into_iter().fold(0.0, f32::max);
            let share = f64::from(worst) / f64::from(value);
            let relative = if share.is_finite() {
                format!(" ({})", percent(share))
            } else {
                String::new()
            };
            let worst = f64::from(worst);
            parts.push(format!("error {}{relative}", format_number(worst, 4)));
            parts.push(format!("variance {}", format_number(worst * worst, 4)));
        }
        match self.samples {
            Samples::OfEach(samples) => {
                parts.push(counted(samples as usize, "sample", "samples"));
            }
            Samples::OnAverage(samples) => {
                let number = format_number(samples, 1);
                let unit = if number == "1" { "sample" } else { "samples" };
                parts.push(format!("{number} {unit} on average"));
            }
            Samples::Unknown => {}
        }
        parts.join(SEPARATOR)
    }

    fn seen_in_words(&self) -> String {
        let what = match self.seen {
            Seen::Itself(_) => "",
            Seen::Other(_) => ", the other",
            Seen::Difference(_) => ", the difference",
            Seen::Nothing => return "nothing shown here".to_owned(),
        };
        match self.seen.color() {
            Some(NOT_FINITE) => format!("not finite: shown in magenta{what}"),
            // Of the layer of the error.
            Some(_) if what.is_empty() && self.values.linear.iter().any(|x| x.is_nan()) => {
                "unknown: shown in grey".to_owned()
            }
            color => {
                let [r, g, b, _] = color.unwrap_or_default().to_array();
                format!("shown {r} {g} {b}{what}")
            }
        }
    }

    /// What is seen there and what it took to find it, in a line.
    #[must_use]
    pub fn surface_in_words(&self) -> String {
        let mut parts: Vec<String> = self.surface.iter().map(Surface::in_words).collect();
        if let Some(Visits { nodes, blocks }) = self.visits {
            parts.push(format!("steps {nodes} + {blocks}"));
        }
        if parts.is_empty() {
            return "Background, or a scene that has changed since".to_owned();
        }
        parts.join(SEPARATOR)
    }
}

const SEPARATOR: &str = "  ·  ";

fn numbers(rgb: [f32; 3]) -> String {
    rgb.map(|channel| format_number(channel.into(), 4))
        .join(" ")
}

/// Of the words.
const MEANING: &str = "Above: column and row, what the picture holds there (radiance in W/m²/sr, unless layer or mode are of another \
                       kind), what the one compared with does, red, green and blue on the screen from 0 to 255, the estimated error of \
                       the worst channel and its square, samples. Below: object and material, triangle, distance from the eye and shading \
                       normal in the middle of the pixel, nodes and blocks that its ray visits";

/// Draws the lines. `scale`: pixels of the screen per pixel of the picture; `is_live`: whether the wheel moves the camera there.
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
        if let Some(color) = inspected.seen.color() {
            ui.painter().rect_filled(swatch, radius, color);
        }
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for words in [inspected.values_in_words(), inspected.surface_in_words()] {
                line_ui(ui, &words, MEANING);
            }
        });
    });
}

/// Draws a line, cut off where it is too long; all of it, and its meaning, show where the mouse rests on it.
fn line_ui(ui: &mut Ui, words: &str, meaning: &str) {
    let line = egui::Label::new(RichText::new(words).size(12.0)).truncate();
    ui.add(line.show_tooltip_when_elided(false))
        .on_hover_text(format!("{words}\n{meaning}"));
}

/// Draws what there is to say of the preview: `surface` is what is seen of it under the mouse.
pub fn preview_inspector_ui(ui: &mut Ui, surface: Option<&Surface>) {
    ui.horizontal(|ui| {
        ui.set_min_height(HEIGHT);
        let words = surface.map_or_else(
            || RichText::new("Point at an object to see what it is").weak(),
            |surface| RichText::new(surface.in_words()),
        );
        ui.add(egui::Label::new(words.size(12.0)).truncate())
            .on_hover_text(
                "Object and material, triangle, distance from the eye and shading normal under the mouse",
            );
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
            seen: Seen::Itself(Color32::from_rgb(188, 137, 255)),
            surface: Some(Surface {
                object: "ram".to_owned(),
                material: "clay".to_owned(),
                triangle: 1234,
                distance: 4.25,
                normal: DVec3::new(0.6, -0.8, 0.0),
            }),
            samples: Samples::OfEach(16),
            visits: Some(Visits {
                nodes: 5,
                blocks: 2,
            }),
        };
        assert_eq!(
            inspected.values_in_words(),
            "12, 7  ·  linear 0.5 0.25 2  ·  shown 188 137 255  ·  error 0.02 (1.0 %)  ·  variance 4.000e-4  ·  16 samples"
        );
        assert_eq!(
            inspected.surface_in_words(),
            "ram, clay  ·  triangle 1,234  ·  distance 4.25  ·  normal 0.6 -0.8 0  ·  steps 5 + 2"
        );
        inspected.other = Some([0.5, 0.75, 0.0]);
        inspected.seen = Seen::Other(Color32::from_rgb(188, 224, 0));
        assert!(
            inspected
                .values_in_words()
                .contains("other 0.5 0.75 0  ·  shown 188 224 0, the other  ·  error")
        );
        inspected.seen = Seen::Nothing;
        assert!(inspected.values_in_words().contains("nothing shown here"));
        inspected.other = None;
        inspected.seen = Seen::Itself(Color32::GRAY);
        inspected.values.linear[1] = f32::NAN;
        assert!(
            inspected
                .values_in_words()
                .contains("  ·  unknown: shown in grey  ·  ")
        );
        inspected.seen = Seen::Itself(NOT_FINITE);
        inspected.values.error = Some([f32::NAN; 3]);
        assert!(
            inspected
                .values_in_words()
                .contains("  ·  error unknown  ·  ")
        );
        inspected.values.error = None;
        inspected.surface = None;
        inspected.visits = None;
        inspected.samples = Samples::OnAverage(20.25);
        assert_eq!(
            inspected.values_in_words(),
            "12, 7  ·  linear 0.5 NaN 2  ·  not finite: shown in magenta  ·  20.2 samples on average"
        );
        assert!(inspected.surface_in_words().starts_with("Background"));
        inspected.samples = Samples::OnAverage(1.0);
        assert!(
            inspected
                .values_in_words()
                .ends_with("  ·  1 sample on average")
        );
    }
}
