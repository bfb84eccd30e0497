//! How often each brightness is on the screen, per channel, or each colour of a scale, and how much of the picture lies at its end.

use egui::epaint::PathShape;
use egui::{Color32, CornerRadius, RichText, Sense, Shape, Stroke, Ui, Vec2};

use super::look::{Levels, Scale};
use super::theme;
use super::widgets::{counted, percent};

const HEIGHT: f32 = 64.0;
const CHANNELS: [Color32; 3] = [
    Color32::from_rgb(0xe8, 0x5c, 0x5c),
    Color32::from_rgb(0x5c, 0xc8, 0x6c),
    Color32::from_rgb(0x5c, 0x8c, 0xf0),
];

/// How often each level is on the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    scale: Scale,
    /// Of each channel; of the first where there is one.
    bins: Box<[[u32; 256]; 3]>,
    pixels: u64,
    white: u64,
    not_finite: u64,
    first_not_finite: Option<[u32; 2]>,
}

impl Histogram {
    /// One that counts levels on `scale`.
    #[must_use]
    pub fn new(scale: Scale) -> Self {
        Self {
            scale,
            bins: Box::new([[0; 256]; 3]),
            pixels: 0,
            white: 0,
            not_finite: 0,
            first_not_finite: None,
        }
    }

    /// Counts a pixel that is finite: its levels, and whether it is as bright as can be shown.
    pub fn count(&mut self, levels: Levels, is_white: bool) {
        self.pixels += 1;
        self.white += u64::from(is_white);
        match levels {
            Levels::Colors(channels) => {
                for (bins, value) in self.bins.iter_mut().zip(channels) {
                    bins[usize::from(value)] += 1;
                }
            }
            Levels::One(value) => self.bins[0][usize::from(value)] += 1,
        }
    }

    /// Counts the pixel in column and row `pixel`, which is not finite in some channel.
    pub fn count_not_finite(&mut self, pixel: [u32; 2]) {
        self.not_finite += 1;
        self.first_not_finite.get_or_insert(pixel);
    }

    /// Pixels that are not finite in some channel.
    #[must_use]
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The first of them in reading order, as column and row of the picture.
    #[must_use]
    pub fn first_not_finite(&self) -> Option<[u32; 2]> {
        self.first_not_finite
    }

    /// The share of the finite pixels that are as bright as can be shown.
    #[must_use]
    pub fn white_share(&self) -> f64 {
        self.white as f64 / self.pixels.max(1) as f64
    }

    /// The channels that there are, with the colours of their lines.
    fn channels(&self, ui: &Ui) -> Vec<(&[u32; 256], Color32)> {
        match self.scale {
            Scale::Colors => self.bins.iter().zip(CHANNELS).collect(),
            _ => vec![(&self.bins[0], ui.visuals().text_color())],
        }
    }

    /// Draws it; returns the pixel that is asked for to be looked at.
    pub fn histogram_ui(&self, ui: &mut Ui) -> Option<[u32; 2]> {
        let size = Vec2::new(ui.available_width(), HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Image, ui.is_enabled(), "Histogram")
        });
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, CornerRadius::same(3), theme::backdrop(ui.visuals()));
        let inside = rect.shrink2(Vec2::new(1.0, 3.0));
        let highest = self.usual_height();
        for (bins, color) in self.channels(ui) {
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
        response.on_hover_text(format!("{}; heights are roots", self.meaning()));
        ui.label(RichText::new(self.in_words()).weak().small());
        let first = self.first_not_finite?;
        let show = ui
            .small_button("Show the first")
            .accessible_name("Show the first pixel that is not finite")
            .on_hover_text("Enlarge the picture there");
        show.clicked().then_some(first)
    }

    /// What it shows.
    fn meaning(&self) -> &'static str {
        match self.scale {
            Scale::Colors => {
                "How often each brightness of the picture is on the screen, black at the left and white at the right, per channel"
            }
            Scale::Grey => {
                "How often each grey of the channel is on the screen, black at the left and white at the right"
            }
            Scale::Stops => {
                "How often each false colour is on the screen, in the order of the legend over the picture"
            }
            Scale::Errors => {
                "How often each error is on the screen, none at the left and the end of the legend over the picture at the right"
            }
        }
    }

    /// The count that reaches the top: what few values exceed. An even background and much black or white would dwarf all others.
    fn usual_height(&self) -> f32 {
        const EXCEEDED_BY: usize = 50;
        let channels = match self.scale {
            Scale::Colors => &self.bins[..],
            _ => &self.bins[..1],
        };
        let counts = channels.iter().flat_map(|bins| &bins[1..255]);
        let mut counts: Vec<u32> = counts.copied().collect();
        counts.sort_unstable();
        counts[counts.len() - 1 - counts.len() / EXCEEDED_BY].max(1) as f32
    }

    fn in_words(&self) -> String {
        let white = percent(self.white_share());
        let words = match self.scale {
            Scale::Colors => format!("{white} of the picture is cut off at white"),
            Scale::Grey => format!("{white} of the channel is cut off at white"),
            Scale::Stops => format!("{white} of the picture is brighter than white"),
            Scale::Errors => format!("{white} of the picture is beyond the scale"),
        };
        if self.not_finite == 0 {
            return words;
        }
        let count = usize::try_from(self.not_finite).unwrap_or(usize::MAX);
        let pixels = counted(count, "pixel is", "pixels are");
        let magenta = match self.scale {
            Scale::Errors => "",
            _ => ", in magenta",
        };
        format!("{words}; {pixels} not finite{magenta}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_counted_by_what_the_screen_shows() {
        let mut histogram = Histogram::new(Scale::Colors);
        histogram.count(Levels::Colors([188; 3]), false);
        histogram.count(Levels::Colors([255, 0, 0]), true);
        histogram.count_not_finite([7, 3]);
        histogram.count_not_finite([8, 3]);
        histogram.count(Levels::Colors([0; 3]), false);
        histogram.count(Levels::Colors([0; 3]), false);
        assert_eq!(histogram.not_finite(), 2);
        assert_eq!(histogram.first_not_finite(), Some([7, 3]));
        assert!((histogram.white_share() - 0.25).abs() < 1e-12);
        assert_eq!(histogram.bins[0][188], 1);
        assert_eq!(histogram.bins[1][0], 3);
        assert_eq!(
            histogram.in_words(),
            "25 % of the picture is cut off at white; 2 pixels are not finite, in magenta"
        );
    }

    #[test]
    fn one_level_is_one_line() {
        let mut histogram = Histogram::new(Scale::Errors);
        histogram.count(Levels::One(255), true);
        histogram.count(Levels::One(3), false);
        assert_eq!((histogram.bins[0][255], histogram.bins[0][3]), (1, 1));
        assert!(histogram.bins[1].iter().all(|&count| count == 0));
        assert_eq!(
            histogram.in_words(),
            "50 % of the picture is beyond the scale"
        );
    }
}
