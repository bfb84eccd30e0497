//! The error plot: noise against time on logarithmic axes, for the present render and those before it.
//!
//! Noise is √relmse of the whole picture as the renderer estimates it, and time is that of rendering alone. A straight line is a
//! power law; where the line of the present render meets a level of noise is when that level will be reached.

mod curve;
mod drawing;

use std::collections::VecDeque;

use egui::{Color32, RichText, Sense, Ui, Vec2};

pub use curve::{Crossing, Curve, name_of_render, next_crossing, seconds_in_words, slope};

use super::log_plot::color_of_curve;
use super::picture::{Outcome, Picture};
use super::theme;
use super::widgets::{chosen_percent, noise_in_words};
use crate::render::ErrorPoint;

/// Height of the panel, in points: as it opens, and the least.
pub const HEIGHT: f32 = 236.0;
/// See [`HEIGHT`].
pub const LEAST_HEIGHT: f32 = 150.0;

/// Width of the words beside the plot, in points.
const WORDS_WIDTH: f32 = 252.0;

/// Renders that are remembered, the present one apart.
const MOST_PAST: usize = 12;

/// The renders of this session, and whether they are plotted.
#[derive(Debug, Default)]
pub struct ErrorPlot {
    /// Whether the plot shows.
    pub open: bool,
    /// Oldest first, with their numbers.
    past: VecDeque<(usize, Curve)>,
    /// The number of the render that the mouse is on in the list.
    pointed_at: Option<usize>,
}

impl ErrorPlot {
    /// Keeps a render that makes room for another. One that was given up before it said anything is forgotten, so that renders
    /// that edits start anew do not crowd the plot. Returns whether it is kept.
    pub fn keep(&mut self, picture: &Picture) -> bool {
        let curve = Curve::of(picture);
        let is_given_up = !matches!(picture.outcome, Outcome::Finished { .. });
        if curve.points.is_empty() || is_given_up && slope(&curve.points).is_none() {
            return false;
        }
        if self.past.len() == MOST_PAST {
            self.past.pop_front();
        }
        self.past.push_back((picture.number, curve));
        true
    }

    /// The renders before the present one, oldest first.
    pub fn past(&self) -> impl Iterator<Item = &Curve> {
        self.past.iter().map(|(_, curve)| curve)
    }

    /// Draws the plot of `picture`, the present render, and of those before it.
    pub fn plot_ui(&mut self, ui: &mut Ui, picture: Option<&Picture>) {
        let present = picture.map(Curve::of);
        let target = picture.and_then(|picture| picture.scene.render.stop.noise);
        let available = ui.available_size();
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 10.0;
            let size = Vec2::new((available.x - WORDS_WIDTH - 10.0).max(120.0), available.y);
            ui.allocate_ui(size, |ui| {
                ui.set_min_size(size);
                let curves = drawing::Curves {
                    present: present.as_ref(),
                    target,
                    past: self
                        .past
                        .iter()
                        .map(|(number, curve)| drawing::Past {
                            curve,
                            color: color_of_curve(*number),
                            is_pointed_at: self.pointed_at == Some(*number),
                        })
                        .collect(),
                };
                if curves.are_empty() {
                    ui.centered_and_justified(|ui| ui.weak(why_empty(picture)));
                } else {
                    drawing::curves_ui(ui, &curves);
                }
            });
            ui.vertical(|ui| {
                ui.set_width(WORDS_WIDTH);
                self.words_ui(ui, picture.zip(present.as_ref()), target);
            });
        });
    }

    /// The figures of the present render, and the names of all.
    fn words_ui(&mut self, ui: &mut Ui, present: Option<(&Picture, &Curve)>, target: Option<f64>) {
        ui.spacing_mut().item_spacing.y = 3.0;
        if let Some((picture, curve)) = present
            && let Some(last) = curve.points.last()
        {
            let noise = format!("Noise {}", noise_in_words(last.error.noise()));
            ui.label(RichText::new(noise).strong().size(15.0)).on_hover_text(
                "Estimated error of the whole picture relative to its brightness (root of relmse), and the interval that holds \
                 the truth in 95 of 100 cases",
            );
            line_ui(ui, &slope_in_words(&curve.points));
            let is_over = !picture.is_running();
            line_ui(ui, &crossing_in_words(&curve.points, target, is_over));
            ui.separator();
        }
        self.pointed_at = None;
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                if let Some((picture, curve)) = present {
                    entry_ui(ui, theme::ACCENT, picture.number, curve);
                }
                for (number, curve) in self.past.iter().rev() {
                    if entry_ui(ui, color_of_curve(*number), *number, curve) {
                        self.pointed_at = Some(*number);
                    }
                }
            });
    }
}

/// Why there is no curve.
fn why_empty(picture: Option<&Picture>) -> &'static str {
    match picture {
        None => "Render, and see the error fall",
        Some(picture) if !picture.scene.render.error_estimate => {
            "The error of this render is not estimated: switch on Estimate error, and render"
        }
        Some(picture) if picture.is_running() => {
            "The error shows after a few samples of every pixel"
        }
        Some(picture) if picture.errors().is_empty() => {
            "There are too few samples to tell the error: it takes at least 4 of every pixel"
        }
        Some(_) => "This picture has no noise",
    }
}

fn slope_in_words(points: &[ErrorPoint]) -> String {
    slope(points).map_or_else(String::new, |slope| {
        let left = (2.0_f64.powf(slope) * 100.0).round();
        format!("Slope {slope:.2}: twice the time leaves {left} %")
    })
}

/// When the next level of noise is reached.
fn crossing_in_words(points: &[ErrorPoint], target: Option<f64>, is_over: bool) -> String {
    if is_over && slope(points).is_some_and(|slope| slope >= 0.0) {
        // A curve that does not fall reaches nothing.
        return String::new();
    }
    match (next_crossing(points, target), target) {
        (Some(Crossing { noise, seconds }), _) => {
            let [value, low, high] =
                [seconds.value, seconds.low, seconds.high].map(seconds_in_words);
            let at = if is_over { "would take" } else { "after" };
            format!("{} {at} {value} ({low} – {high})", chosen_percent(noise))
        }
        (None, Some(target)) => {
            let is_there = points
                .last()
                .is_some_and(|p| p.error.noise().value <= target);
            let text = if is_there {
                "is reached"
            } else {
                "is out of reach"
            };
            format!("{} {text}", chosen_percent(target))
        }
        (None, None) => String::new(),
    }
}

fn line_ui(ui: &mut Ui, text: &str) {
    if !text.is_empty() {
        ui.add(egui::Label::new(RichText::new(text).size(12.5)).truncate());
    }
}

/// A render in the list; returns whether the mouse is on it.
fn entry_ui(ui: &mut Ui, color: Color32, number: usize, curve: &Curve) -> bool {
    ui.spacing_mut().interact_size.y = 14.0;
    let response = ui.horizontal(|ui| {
        let (swatch, _) = ui.allocate_exact_size(Vec2::new(14.0, 14.0), Sense::hover());
        let line = swatch.shrink2(Vec2::new(0.0, 5.5));
        ui.painter().rect_filled(line, 1.5, color);
        let text = format!("{number}  {}", curve.name);
        ui.add(egui::Label::new(RichText::new(text).size(12.0)).truncate());
    });
    ui.horizontal(|ui| {
        ui.add_space(20.0);
        ui.add(egui::Label::new(RichText::new(&curve.result).size(11.0).weak()).truncate());
    });
    response.response.contains_pointer()
}
