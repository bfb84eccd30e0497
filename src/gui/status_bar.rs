//! The bar at the bottom: what runs and how far it is, what the last render gave, and what the scene holds.

use std::time::Duration;

use egui::{Align, CornerRadius, Layout, ProgressBar, RichText, Ui};

use super::picture::{Outcome, Picture};
use super::theme;
use super::widgets::{counted, grouped};
use crate::scene::Scene;

/// What runs or was last done.
#[derive(Clone, Debug)]
pub enum Activity<'a> {
    /// Nothing yet; a hint instead.
    Idle,
    /// Files are being read; the share is 0 while the whole is not known.
    Loading {
        /// Which.
        what: &'a str,
        /// `0..=1`.
        share: f64,
    },
    /// Triangles are placed and their acceleration structure is built.
    Preparing {
        /// How far the structure is, `0..=1`.
        share: f64,
    },
    /// A render runs or has ended.
    Picture {
        /// It.
        picture: &'a Picture,
        /// Whether the scene is no longer the one it shows.
        outdated: bool,
    },
}

/// Height of the bar, in points.
pub const HEIGHT: f32 = 26.0;

/// Draws the bar. `news`: the last thing that was done, such as saving.
pub fn status_bar_ui(ui: &mut Ui, activity: &Activity<'_>, news: &str, scene: Option<&Scene>) {
    ui.horizontal(|ui| {
        ui.set_min_height(HEIGHT);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some(scene) = scene {
                ui.label(RichText::new(facts(scene)).weak());
                ui.separator();
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                activity_ui(ui, activity, news);
            });
        });
    });
}

fn activity_ui(ui: &mut Ui, activity: &Activity<'_>, news: &str) {
    match activity {
        Activity::Idle if news.is_empty() => {
            line_ui(
                ui,
                "Drag to orbit · Shift+drag or middle drag to pan · scroll to zoom · ? for more",
            );
        }
        Activity::Idle => line_ui(ui, news),
        Activity::Loading { what, share } => {
            progress_ui(ui, *share);
            line_ui(ui, &format!("Loading {what}"));
        }
        Activity::Preparing { share } => {
            if *share > 0.0 {
                progress_ui(ui, *share);
            }
            line_ui(ui, "Preparing the scene…");
        }
        Activity::Picture { picture, outdated } => picture_ui(ui, picture, *outdated, news),
    }
}

fn picture_ui(ui: &mut Ui, picture: &Picture, outdated: bool, news: &str) {
    let render = &picture.scene.render;
    let what = format!(
        "{} × {}, {}",
        render.width,
        render.height,
        counted(render.samples_per_pixel as usize, "sample", "samples")
    );
    let mut parts = Vec::new();
    match &picture.outcome {
        Outcome::Running => {
            progress_ui(ui, picture.progress.samples.fraction());
            parts.push(format!("Rendering {what}"));
            parts.push(duration(picture.elapsed()));
            if let Some(remaining) = picture.remaining() {
                parts.push(format!("{} left", duration(remaining)));
            }
            parts.push(format!("{:.2} Mrays/s", picture.mrays_per_second()));
        }
        Outcome::Finished { hash, stats } => {
            if !news.is_empty() {
                parts.push(news.to_owned());
            }
            parts.push(format!("{what} in {}", duration(picture.elapsed())));
            let mrays = stats.rays.total() as f64 / stats.render_seconds.max(1e-9) / 1e6;
            parts.push(format!("{mrays:.2} Mrays/s"));
            parts.push(format!("hash {}", &hash[..hash.len().min(8)]));
            if stats.non_finite_samples > 0 {
                let count = grouped(stats.non_finite_samples);
                parts.push(format!("{count} samples are not numbers"));
            }
            if render.clamp.is_some() {
                let share = stats.clamped.energy_share * 100.0;
                parts.push(format!("clamping took {share:.2} % of the light"));
            }
        }
        Outcome::Cancelled => {
            let share = picture.progress.samples.fraction() * 100.0;
            parts.push(format!(
                "Cancelled at {share:.0} % after {}",
                duration(picture.elapsed())
            ));
            if !news.is_empty() {
                parts.push(news.to_owned());
            }
        }
        Outcome::Failed => parts.push("The render failed".to_owned()),
    }
    if picture.buffer.step() > 1 {
        parts.push(format!("shown at 1/{} of its size", picture.buffer.step()));
    }
    if outdated {
        let hint = if picture.is_running() {
            "settings changed: Render restarts"
        } else {
            "settings changed since"
        };
        ui.label(RichText::new(hint).color(ui.visuals().warn_fg_color));
        ui.label(RichText::new("·").weak());
    }
    line_ui(ui, &parts.join("  ·  "));
}

fn progress_ui(ui: &mut Ui, share: f64) {
    #[expect(clippy::cast_possible_truncation, reason = "a share for display")]
    let share = share as f32;
    let bar = ProgressBar::new(share)
        .desired_width(170.0)
        .desired_height(14.0)
        .corner_radius(CornerRadius::same(7))
        .fill(theme::ACCENT)
        .text(RichText::new(format!("{:.0} %", (share * 100.0).floor())).small());
    ui.add(bar).accessible_name("Progress");
}

fn line_ui(ui: &mut Ui, text: &str) {
    ui.add(egui::Label::new(text).truncate());
}

/// What the scene holds.
fn facts(scene: &Scene) -> String {
    format!(
        "{}, {} triangles, {}",
        counted(scene.objects.len(), "object", "objects"),
        grouped(scene.triangle_count()),
        counted(scene.lights.len(), "light", "lights"),
    )
}

/// A time as people read it.
#[must_use]
pub fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    if seconds < 0.9995 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 59.95 {
        format!("{seconds:.1} s")
    } else {
        let whole = duration.as_secs();
        let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
        if hours == 0 {
            format!("{minutes} min {seconds:02} s")
        } else {
            format!("{hours} h {minutes:02} min")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_well() {
        let shown = |seconds| duration(Duration::from_secs_f64(seconds));
        assert_eq!(shown(0.034), "34 ms");
        assert_eq!(shown(0.9999), "1.0 s");
        assert_eq!(shown(59.99), "0 min 59 s");
        assert_eq!(shown(75.0), "1 min 15 s");
        assert_eq!(shown(7500.0), "2 h 05 min");
    }
}
