//! How often each brightness is on the screen, per channel, and how much of the picture is cut off at white.

use egui::epaint::PathShape;
use egui::{Color32, CornerRadius, RichText, Sense, Shape, Stroke, Ui, Vec2};

use super::theme;
use super::widgets::{counted, percent};

const HEIGHT: f32 = 64.0;
const CHANNELS: [Color32; 3] = [
    Color32::from_rgb(0xe8, 0x5c, 0x5c),
    Color32::from_rgb(0x5c, 0xc8, 0x6c),
    Color32::from_rgb(0x5c, 0x8c, 0xf0),
];

/// How often each value of a channel is on the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    bins: Box<[[u32; 256]; 3]>,
    pixels: u64,
    not_finite: u64,
    white: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            bins: Box::new([[0; 256]; 3]),
            pixels: 0,
            not_finite: 0,
            white: 0,
        }
    }
}

impl Histogram {
    /// Counts a pixel: its linear value and its colour on the screen.
    pub fn count(&mut self, linear: [f32; 3], color: Color32) {
        self.pixels += 1;
        if linear.iter().any(|channel| !channel.is_finite()) {
            self.not_finite += 1;
            return;
        }
        let channels = [color.r(), color.g(), color.b()];
        for (bins, value) in self.bins.iter_mut().zip(channels) {
            bins[usize::from(value)] += 1;
        }
        self.white += u64::from(channels.contains(&255));
    }

    /// Pixels that are not finite in some channel, among those that were counted.
    #[must_use]
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The share of pixels with a channel as bright as can be shown.
    #[must_use]
    pub fn white_share(&self) -> f64 {
        self.white as f64 / self.pixels.max(1) as f64
    }

    /// Draws it.
    pub fn histogram_ui(&self, ui: &mut Ui) {
        let size = Vec2::new(ui.available_width(), HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Image, ui.is_enabled(), "Histogram")
        });
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, CornerRadius::same(3), theme::backdrop(ui.visuals()));
        let inside = rect.shrink2(Vec2::new(1.0, 3.0));
        let highest = self.usual_height();
        for (bins, color) in self.bins.iter().zip(CHANNELS) {
            let point = |(value, &count): (usize, &u32)| {
                let x = inside.left() + inside.width() * value as f32 / 255.0;
                // Roots show rare values beside frequent ones.
                let share = (count as f32 / highest).min(1.0).sqrt();
                egui::pos2(x, inside.bottom() - inside.height() * share)
            };
            let points: Vec<_> = bins.iter().enumerate().map(point).collect();
            let line = PathShape::line(points, Stroke::new(1.2, color.gamma_multiply(0.9)));
            painter.add(Shape::Path(line));
        }
        response.on_hover_text(
            "How often each brightness is on the screen, black at the left and white at the right, per channel; heights are roots",
        );
        ui.label(RichText::new(self.in_words()).weak().small());
    }

    /// The count that reaches the top: what few values exceed. An even background and much black or white would dwarf all others.
    fn usual_height(&self) -> f32 {
        const EXCEEDED_BY: usize = 50;
        let mut counts: Vec<u32> = self
            .bins
            .iter()
            .flat_map(|bins| &bins[1..255])
            .copied()
            .collect();
        counts.sort_unstable();
        counts[counts.len() - 1 - counts.len() / EXCEEDED_BY].max(1) as f32
    }

    fn in_words(&self) -> String {
        let white = percent(self.white_share());
        let words = format!("{white} of the picture is cut off at white");
        if self.not_finite == 0 {
            return words;
        }
        let count = usize::try_from(self.not_finite).unwrap_or(usize::MAX);
        let pixels = counted(count, "pixel is", "pixels are");
        format!("{words}; {pixels} not finite, in magenta")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_counted_by_what_the_screen_shows() {
        let mut histogram = Histogram::default();
        histogram.count([0.5; 3], Color32::from_gray(188));
        histogram.count([2.0, 0.0, 0.0], Color32::from_rgb(255, 0, 0));
        histogram.count([f32::INFINITY, 0.0, 0.0], Color32::from_rgb(255, 0, 255));
        histogram.count([0.0; 3], Color32::BLACK);
        assert_eq!(histogram.not_finite(), 1);
        assert!((histogram.white_share() - 0.25).abs() < 1e-12);
        assert_eq!(histogram.bins[0][188], 1);
        assert_eq!(histogram.bins[1][0], 2);
        assert_eq!(
            histogram.in_words(),
            "25 % of the picture is cut off at white; 1 pixel is not finite, in magenta"
        );
    }
}
