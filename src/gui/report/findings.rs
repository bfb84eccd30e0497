//! What a report has found so far: the chart, and figures beside it.

use egui::{Align, Grid, Layout, RichText, Ui, Vec2};

use super::chart::{chart_ui, color_of, legend_ui};
use crate::analysis::report::{Chart, Study, Summary, TimeTo, to_chart};
use crate::math::{counted, percent, signed, three_digits, time_in_words};
use crate::render::NOISE_TARGETS;

/// Height of the chart, in points.
const CHART_HEIGHT: f32 = 300.0;
/// Width of the names in the table, in points.
const NAME_WIDTH: f32 = 270.0;
/// Width of the legend beside the chart, in points.
const LEGEND_WIDTH: f32 = 240.0;

/// Figures that a report shows, without the pictures and scenes it was made with.
#[derive(Clone, Debug)]
pub struct Findings {
    /// As in `report.svg`.
    pub chart: Chart,
    /// Name and figures of each variant, the scene as it is in front.
    pub variants: Vec<(String, Summary)>,
    /// What was rendered, in a line.
    subject: String,
    reference: String,
    warnings: Vec<String>,
}

impl Findings {
    /// What `study` has found, and what looked wrong before it began.
    #[must_use]
    pub fn of(study: &Study, warnings: &[String]) -> Self {
        let summaries = study.measured().filter_map(|variant| {
            let summary = Summary::of(variant, &study.reference)?;
            Some((variant.name.clone(), summary))
        });
        let seeds = study.variants.first().map_or(0, |base| base.trials.len());
        let image = &study.reference.image;
        Self {
            subject: format!(
                "{}, {} × {} pixels, median of {}",
                study.scene_name,
                image.width,
                image.height,
                counted(seeds as u64, "seed", "seeds")
            ),
            chart: to_chart(study),
            variants: summaries.collect(),
            reference: study.reference.describe(),
            warnings: warnings.to_vec(),
        }
    }

    /// Draws the chart and the figures.
    pub(super) fn findings_ui(&self, ui: &mut Ui) {
        // The label at the upper end of the axis reaches above the chart.
        ui.add_space(8.0);
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 12.0;
            let width = (ui.available_width() - LEGEND_WIDTH - 12.0).max(200.0);
            let size = Vec2::new(width, CHART_HEIGHT);
            ui.allocate_ui(size, |ui| {
                ui.set_min_size(size);
                chart_ui(ui, &self.chart);
            });
            ui.vertical(|ui| {
                ui.set_width(LEGEND_WIDTH);
                self.result_ui(ui);
                legend_ui(ui, &self.chart);
            });
        });
        ui.add_space(8.0);
        self.table_ui(ui);
        ui.add_space(4.0);
        ui.label(RichText::new(format!("Reference: {}.", self.reference)).weak());
        let warn = ui.visuals().warn_fg_color;
        for warning in self.warnings.iter().cloned().chain(self.faults()) {
            ui.label(RichText::new(warning).color(warn));
        }
    }

    /// What came out for the scene as it is.
    fn result_ui(&self, ui: &mut Ui) {
        let last = self.variants.first().and_then(|(_, s)| s.points.last());
        let Some(last) = last else { return };
        let noise = last.noise_in_words();
        let time = time_in_words(last.seconds.median);
        let text = format!("{noise} after {time}");
        ui.label(RichText::new(text).strong().size(15.0))
            .on_hover_text("True error relative to the picture's brightness (root of relmse), median over the seeds");
        let subject = RichText::new(&self.subject).size(12.5);
        ui.add(egui::Label::new(subject).wrap());
        if let Some(estimated) = last.estimated_noise() {
            let estimated = percent(estimated.median);
            ui.label(RichText::new(format!("The renders themselves say {estimated}")).size(12.5));
        }
        ui.separator();
    }

    /// The figures of all variants.
    fn table_ui(&self, ui: &mut Ui) {
        Grid::new("report figures")
            .num_columns(5 + NOISE_TARGETS.len())
            .spacing([18.0, 4.0])
            .striped(true)
            .show(ui, |ui| {
                for (head, tooltip) in [
                    ("", ""),
                    ("Noise", "True noise at the last point, median over the seeds"),
                    ("Seconds", "Time of rendering up to the last point, median over the seeds"),
                    (
                        "Slope",
                        "Noise falls as time to the power of this: at −0.5 four times the time halves it",
                    ),
                    (
                        "Efficiency",
                        "1 / (noise² · seconds): four times as much halves the noise of the same time",
                    ),
                ] {
                    ui.label(RichText::new(head).weak()).on_hover_text(tooltip);
                }
                for noise in NOISE_TARGETS {
                    let head = format!("To {:.0} %", 100.0 * noise);
                    ui.label(RichText::new(head).weak()).on_hover_text(
                        "Seconds until the noise is that low; after ≈ the curve ends before and its slope is followed",
                    );
                }
                ui.end_row();
                for (number, (name, summary)) in self.variants.iter().enumerate() {
                    let color = color_of(number);
                    let name = egui::Label::new(RichText::new(name).color(color));
                    let size = Vec2::new(NAME_WIDTH, ui.spacing().interact_size.y);
                    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                        ui.set_min_width(NAME_WIDTH);
                        ui.add(name.truncate());
                    });
                    for cell in cells(summary) {
                        ui.label(cell);
                    }
                    ui.end_row();
                }
            });
    }

    /// Samples that no picture should have, and errors that are not those of the renders.
    fn faults(&self) -> impl Iterator<Item = String> {
        self.variants.iter().flat_map(|(name, summary)| {
            let clamped = &summary.clamped;
            let taken = percent(clamped.energy_share);
            let faults = [
                (
                    summary.non_finite_samples,
                    ["sample was", "samples were"],
                    "infinite or not a number".to_owned(),
                ),
                (
                    summary.negative_samples,
                    ["sample had", "samples had"],
                    "less than no light".to_owned(),
                ),
                (
                    clamped.samples,
                    ["sample was", "samples were"],
                    format!("limited by clamping, which took {taken} of the light"),
                ),
            ];
            let faults = faults.into_iter().filter(|(count, ..)| *count > 0);
            faults
                .map(|(count, [one, many], fault)| format!("{} {fault}", counted(count, one, many)))
                .chain(summary.doubt())
                .chain(summary.load())
                .map(move |fault| format!("{name}: {fault}"))
        })
    }
}

const NONE: &str = "–";

/// The figures of a variant under the heads of the table.
fn cells(summary: &Summary) -> Vec<String> {
    let last = summary.points.last();
    let number = |number: Option<f64>, shown: fn(f64) -> String| {
        let number = number.filter(|number| number.is_finite());
        number.map_or_else(|| NONE.to_owned(), shown)
    };
    let mut cells = vec![
        number(last.map(|point| point.true_noise().median), percent),
        number(last.map(|point| point.seconds.median), three_digits),
        number(summary.noise_slope.map(|slope| slope.value), signed),
        number(Some(summary.efficiency.wall), three_digits),
    ];
    let time = |time: Option<TimeTo>| {
        time.map_or_else(
            || NONE.to_owned(),
            |time| {
                let mark = match (time.predicted, time.at_most) {
                    (true, _) => "≈ ",
                    (_, true) => "≤ ",
                    _ => "",
                };
                format!("{mark}{}", time_in_words(time.seconds))
            },
        )
    };
    cells.extend(summary.time_to.map(time));
    cells
}
