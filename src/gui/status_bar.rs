//! The bar at the bottom: what runs and how far it is, what the last render gave, and what the scene holds.

use std::time::Duration;

use egui::{Align, Button, CornerRadius, Layout, ProgressBar, RichText, Ui};

use super::commands::{Command, Stoppable};
use super::picture::{Outcome, Picture};
use super::report::Run;
use super::theme;
use super::time_estimate::rounded;
use super::widgets::{chosen_percent, counted, format_number, grouped, noise_in_words, percent};
use crate::render::{Ending, RenderStats, Sight};
use crate::scene::{RenderSettings, Scene, Stop};

/// What runs or was last done.
#[derive(Clone, Debug)]
pub enum Activity<'a> {
    /// Nothing yet; a hint instead.
    Idle,
    /// Files are being read; the share is 0 while the whole is not known.
    Loading {
        /// Which files.
        what: &'a str,
        /// `0..=1`.
        share: f64,
    },
    /// Triangles are placed and their acceleration structure is built.
    Preparing {
        /// How far the structure is, `0..=1`.
        share: f64,
    },
    /// A report is being made.
    Reporting(&'a Run),
    /// A render runs or has ended.
    Picture {
        /// The picture of the render.
        picture: &'a Picture,
        /// Whether another scene is open than the one that it is of.
        is_of_other: bool,
        /// Whether the scene is no longer the one it shows.
        outdated: bool,
    },
}

/// What the bar shows.
#[derive(Clone, Debug)]
pub struct Status<'a> {
    /// What runs or was last done.
    pub activity: Activity<'a>,
    /// Which pictures are being written, in words; `None` where none are.
    pub saving: Option<String>,
    /// How far measuring what effects cost is, `0..=1`, where that goes on.
    pub measuring: Option<f64>,
    /// The render that runs while another picture is looked at.
    pub running: Option<&'a Picture>,
    /// Whether the render that ended can go on with its samples.
    pub can_continue: bool,
    /// What Esc would stop.
    pub esc_stops: Option<Stoppable>,
    /// The last thing that was done, such as saving.
    pub news: &'a str,
    /// The scene, where there is one.
    pub scene: Option<&'a Scene>,
}

/// Height of the bar, in points.
pub const HEIGHT: f32 = 26.0;

/// What was asked for in the bar.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked {
    /// What is to be stopped.
    pub stop: Option<Stoppable>,
    /// What else is to be done.
    pub command: Option<Command>,
}

/// Draws the bar; returns what was asked for.
pub fn status_bar_ui(ui: &mut Ui, status: &Status<'_>) -> Asked {
    let mut asked = Asked::default();
    ui.horizontal(|ui| {
        ui.set_min_height(HEIGHT);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some(scene) = status.scene {
                ui.label(RichText::new(facts(scene)).weak());
                ui.separator();
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                if let Some(saving) = &status.saving {
                    stop_ui(ui, Stoppable::Saving, status, &mut asked);
                    ui.label(format!("Saving {saving}…"));
                    ui.separator();
                }
                if let Some(share) = status.measuring {
                    stop_ui(ui, Stoppable::Measuring, status, &mut asked);
                    progress_ui(ui, share);
                    ui.label("Measuring costs");
                    ui.separator();
                }
                if let Some(picture) = status.running {
                    progress_ui(ui, picture.progress.share());
                    let what = if picture.is_paused() {
                        "Paused"
                    } else {
                        "Rendering"
                    };
                    let left = time_left_in_words(picture);
                    let parts: Vec<String> = std::iter::once(what.to_owned()).chain(left).collect();
                    ui.label(parts.join("  ·  "));
                    ui.separator();
                }
                activity_ui(ui, status, &mut asked);
            });
        });
    });
    asked
}

/// The button that stops `what`.
fn stop_ui(ui: &mut Ui, what: Stoppable, status: &Status<'_>, asked: &mut Asked) {
    let name = format!("Cancel {}", what.in_words());
    let tooltip = if status.esc_stops == Some(what) {
        format!("{name}  ({})", Command::Cancel.shortcut_text(ui.ctx()))
    } else {
        name.clone()
    };
    let response = ui
        .add(Button::new(Command::Cancel.label()).small())
        .accessible_name(name)
        .on_hover_text(tooltip);
    if response.clicked() {
        asked.stop = Some(what);
    }
}

/// The button that goes on with the render that ended.
fn continue_ui(ui: &mut Ui, asked: &mut Asked) {
    let command = Command::Continue;
    let response = ui
        .add(Button::new(command.label()).small())
        .on_hover_text(command.tooltip(ui.ctx()));
    if response.clicked() {
        asked.command = Some(command);
    }
}

fn activity_ui(ui: &mut Ui, status: &Status<'_>, asked: &mut Asked) {
    let news = status.news;
    match &status.activity {
        Activity::Idle if news.is_empty() => {
            line_ui(
                ui,
                "Drag to orbit · Shift+drag or middle drag to pan · scroll to zoom · ? for more",
            );
        }
        Activity::Idle => line_ui(ui, news),
        Activity::Loading { what, share } => {
            stop_ui(ui, Stoppable::Loading, status, asked);
            progress_ui(ui, *share);
            line_ui(ui, &format!("Loading {what}"));
        }
        Activity::Preparing { share } => {
            stop_ui(ui, Stoppable::Preparing, status, asked);
            if *share > 0.0 {
                progress_ui(ui, *share);
                line_ui(ui, "Preparing the scene: building its tree");
            } else {
                line_ui(ui, "Preparing the scene: placing its triangles");
            }
        }
        Activity::Reporting(run) => {
            progress_ui(ui, run.progress.how_far().0);
            let mut parts = vec![format!("Report: {}", run.describe())];
            if !news.is_empty() {
                parts.push(news.to_owned());
            }
            line_ui(ui, &parts.join("  ·  "));
        }
        Activity::Picture {
            picture,
            is_of_other,
            outdated,
        } => {
            if status.can_continue {
                continue_ui(ui, asked);
            }
            let hint = match (is_of_other, outdated) {
                (true, _) => Some(other_scene(picture)),
                (false, true) => Some(other_settings(picture, status.can_continue).to_owned()),
                (false, false) => None,
            };
            picture_ui(ui, picture, hint, news);
        }
    }
}

/// What is said where another scene is open than the one that `picture` is of.
fn other_scene(picture: &Picture) -> String {
    let hint = if picture.is_running() {
        ": F5 renders this scene instead"
    } else {
        ""
    };
    format!("a picture of {}{hint}", picture.scene_name)
}

/// What is said where the scene is no longer the one that `picture` shows.
fn other_settings(picture: &Picture, can_continue: bool) -> &'static str {
    if picture.is_paused() {
        "settings changed: Resume goes on without, F5 restarts"
    } else if picture.is_running() {
        "settings changed: F5 restarts"
    } else if can_continue {
        "may go on by now: Continue takes its samples along, F5 begins anew"
    } else {
        "settings changed since"
    }
}

/// `hint`: what sets the scene apart from that of the picture.
fn picture_ui(ui: &mut Ui, picture: &Picture, hint: Option<String>, news: &str) {
    let render = &picture.scene.render;
    let size = picture.buffer.part().size_in_words();
    let mut parts = Vec::new();
    if !news.is_empty() {
        parts.push(news.to_owned());
    }
    let mut warnings: Vec<String> = hint.into_iter().collect();
    if let Some(reason) = &picture.why_black {
        warnings.push(format!("the picture is black: {reason}"));
    }
    match &picture.outcome {
        Outcome::Running => {
            if let Some(share) = picture.reading() {
                progress_ui(ui, share);
                parts.push("Reading what was rendered before".to_owned());
            } else {
                progress_ui(ui, picture.progress.share());
                parts.extend(running_parts(picture, &size));
            }
        }
        Outcome::Finished { hash, stats } => {
            let ending = ending(stats, render);
            parts.push(format!(
                "{size} in {}, {ending}",
                duration(picture.elapsed())
            ));
            if let Some(error) = &stats.error {
                parts.push(format!("noise {}", noise_in_words(error.noise())));
            }
            parts.push(samples(stats));
            let mrays = stats.rays.total() as f64 / stats.render_seconds.max(1e-9) / 1e6;
            parts.push(format!("{mrays:.2} Mrays/s"));
            parts.push(short_hash(hash));
            if picture.rules().lead_elsewhere() {
                // Beside the line, which may have no room for its end.
                ui.label("stop rules changed on the way")
                    .on_hover_text(LED_ELSEWHERE);
                ui.label(RichText::new("·").weak());
            }
            warnings.extend(faults(stats));
            if render.clamp.is_some() {
                let share = stats.clamped.energy_share * 100.0;
                parts.push(format!("clamping took {share:.2} % of the light"));
            }
        }
        Outcome::Cancelled => {
            let share = (picture.progress.share() * 100.0).floor();
            parts.push(format!(
                "Cancelled at {share} % after {}",
                duration(picture.elapsed())
            ));
            if let Some(point) = picture.errors().last() {
                parts.push(format!("noise {}", noise_in_words(point.error.noise())));
            }
        }
        Outcome::Failed => parts.push("The render failed".to_owned()),
        Outcome::Opened { hash, error, .. } => {
            parts.push(format!("{size}, from {}", picture.name));
            if let Some(error) = error {
                parts.push(format!("noise {}", percent(error.noise())));
            }
            if let Some(hash) = hash {
                parts.push(short_hash(hash));
            }
        }
    }
    if picture.buffer.step() > 1 {
        parts.push(format!("shown at 1/{} of its size", picture.buffer.step()));
    }
    for warning in warnings {
        ui.label(RichText::new(warning).color(ui.visuals().warn_fg_color));
        ui.label(RichText::new("·").weak());
    }
    line_ui(ui, &parts.join("  ·  "));
}

/// Of a render that ended by other rules than it was begun with.
const LED_ELSEWHERE: &str = "Samples, noise or time at which it stops were changed on the way. A render that is begun anew with those of the end \
                             takes other samples, and has other noise";

/// How far a running render is.
fn running_parts(picture: &Picture, size: &str) -> Vec<String> {
    let render = &picture.scene.render;
    let mut parts = Vec::new();
    let samples = counted(render.samples_per_pixel as usize, "sample", "samples");
    let most = if render.stop == Stop::default() {
        ""
    } else {
        "up to "
    };
    let what = if picture.is_paused() {
        "Paused:"
    } else {
        "Rendering"
    };
    parts.push(format!("{what} {size}, {most}{samples}"));
    if let Some(share) = picture.goes_on_from() {
        let done = (share * 100.0).floor();
        parts.push(if picture.is_continued() {
            format!("goes on from {done} %")
        } else {
            format!("interrupted at {done} %, goes on")
        });
    }
    parts.push(duration(picture.elapsed()));
    if picture.progress.ends_with_pass() {
        parts.push("ends with this pass".to_owned());
    }
    parts.extend(time_left_in_words(picture));
    if let Some(point) = picture.errors().last() {
        parts.push(format!("noise {}", noise_in_words(point.error.noise())));
    }
    let rate = picture.mrays_per_second();
    parts.extend(rate.map(|rate| format!("{rate:.2} Mrays/s")));
    parts
}

/// How long a running render will take yet, as far as that is known.
fn time_left_in_words(picture: &Picture) -> Option<String> {
    Some(time_left(picture.remaining()?, picture.progress.sight()))
}

/// `left` in words; `sight`: what is known of the samples that it is for.
fn time_left(left: Duration, sight: Sight) -> String {
    if left < Duration::from_secs(1) {
        return "under 1 s left".to_owned();
    }
    match sight {
        Sight::Bound => format!("at most {} left", duration(left)),
        Sight::Guess => format!("about {} left", rounded(left.as_secs_f64())),
        Sight::Known => format!("{} left", duration(left)),
    }
}

fn short_hash(hash: &str) -> String {
    format!("hash {}", &hash[..hash.len().min(8)])
}

/// Why a render ended.
fn ending(stats: &RenderStats, render: &RenderSettings) -> String {
    match (stats.ending, render.stop.noise) {
        (Ending::Noise, Some(noise)) => format!("down to {}", chosen_percent(noise)),
        (Ending::Noise, None) => "noise reached".to_owned(),
        (Ending::Time, _) if stats.sample_range[0] == 0 => {
            "time is up before every pixel has a sample".to_owned()
        }
        (Ending::Time, _) => "time is up".to_owned(),
        (Ending::Interrupted, _) => "interrupted".to_owned(),
        (Ending::Samples, _) if render.stop.passes == Some(stats.passes) => {
            counted(stats.passes as usize, "pass done", "passes done")
        }
        (Ending::Samples, Some(noise)) => {
            format!("not down to {}: samples used up", chosen_percent(noise))
        }
        (Ending::Samples, None) => "all samples taken".to_owned(),
    }
}

/// Samples of a pixel, and the fewest and the most where not all have the same.
fn samples(stats: &RenderStats) -> String {
    let mean = format_number(stats.samples_per_pixel, 1);
    match stats.sample_range {
        [1, 1] => "1 sample per pixel".to_owned(),
        [least, most] if least == most => format!("{mean} samples per pixel"),
        [least, most] => format!("{mean} samples per pixel ({least} – {most})"),
    }
}

/// Samples that no picture should have.
fn faults(stats: &RenderStats) -> Vec<String> {
    let counts = [
        (
            stats.non_finite_samples,
            ["is infinite or not a number", "are infinite or not numbers"],
        ),
        (
            stats.negative_samples,
            ["has less than no light", "have less than no light"],
        ),
    ];
    let present = counts.into_iter().filter(|(count, _)| *count > 0);
    let counted = present.map(|(count, [one, many])| match count {
        1 => format!("1 sample {one}"),
        _ => format!("{} samples {many}", grouped(count)),
    });
    let depth_limited = stats.notable_depth_limited_share().map(|share| {
        let percent = share * 100.0;
        format!("{percent:.0} % of samples may lack light: max bounces ended their paths")
    });
    counted.chain(depth_limited).collect()
}

/// A bar that is filled up to `share`, `0..=1`.
pub(super) fn progress_ui(ui: &mut Ui, share: f64) {
    #[expect(clippy::cast_possible_truncation, reason = "a share for display")]
    let share = share as f32;
    let bar = ProgressBar::new(share)
        .desired_width(150.0)
        .desired_height(14.0)
        .corner_radius(CornerRadius::same(7))
        .fill(theme::ACCENT);
    ui.add(bar).accessible_name("Progress");
    // Beside the bar: on it, its end runs through the words.
    ui.label(format!("{:.0} %", (share * 100.0).floor()));
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
        // The nearest, as the tenths below a minute are: with those cut off, 59.96 s would be 0 min 59 s.
        let whole = duration
            .saturating_add(Duration::from_millis(500))
            .as_secs();
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
    use std::sync::Arc;
    use std::time::Instant;

    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::gui::part::Part;
    use crate::gui::picture_buffer::PictureBuffer;
    use crate::render::RenderProgress;
    use crate::scene::Display;

    #[test]
    fn times_read_well() {
        let shown = |seconds| duration(Duration::from_secs_f64(seconds));
        assert_eq!(shown(0.034), "34 ms");
        assert_eq!(shown(0.9999), "1.0 s");
        assert_eq!(shown(59.94), "59.9 s");
        assert_eq!(shown(59.96), "1 min 00 s");
        assert_eq!(shown(59.99), "1 min 00 s");
        assert_eq!(shown(75.0), "1 min 15 s");
        assert_eq!(shown(119.7), "2 min 00 s");
        assert_eq!(shown(3599.9), "1 h 00 min");
        assert_eq!(shown(7500.0), "2 h 05 min");
    }

    #[test]
    fn what_is_left_is_told_no_surer_than_it_is() {
        let shown = |seconds, sight| time_left(Duration::from_secs_f64(seconds), sight);
        assert_eq!(shown(0.769, Sight::Known), "under 1 s left");
        assert_eq!(shown(18.34, Sight::Known), "18.3 s left");
        assert_eq!(shown(18.34, Sight::Guess), "about 18 s left");
        assert_eq!(shown(1620.0, Sight::Bound), "at most 27 min 00 s left");
    }

    /// In a window of the usual width, and not where the line is cut off.
    #[test]
    fn changed_stop_rules_are_told_where_they_can_be_read() {
        let part = Part::whole([1920, 1080]);
        let buffer = PictureBuffer::new(part, Vec::new(), Display::default());
        let mut picture = Picture::new(
            1,
            ["first render", "room"].map(str::to_owned),
            Scene::default(),
            Arc::new(buffer.expect("it fits")),
            RenderProgress::default(),
            Instant::now(),
        );
        picture.continue_another(true);
        let stats = RenderStats {
            samples_per_pixel: 1234.5,
            sample_range: [16, 100_000],
            ..RenderStats::default()
        };
        picture.end(Outcome::Finished {
            hash: "0123456789abcdef".to_owned(),
            stats: Box::new(stats),
        });
        let scene = Scene::default();
        let size = egui::vec2(1280.0, HEIGHT);
        let bar = egui_kittest::Harness::builder().with_size(size);
        let bar = bar.build_ui(|ui| {
            status_bar_ui(
                ui,
                &Status {
                    activity: Activity::Picture {
                        picture: &picture,
                        is_of_other: false,
                        outdated: true,
                    },
                    saving: None,
                    measuring: None,
                    running: None,
                    can_continue: true,
                    esc_stops: None,
                    news: "Saved /home/somebody/pictures/room.exr",
                    scene: Some(&scene),
                },
            );
        });
        let told = bar.get_by_label("stop rules changed on the way");
        let rect = told.rect();
        let bar = egui::Rangef::new(0.0, size.x);
        assert!(
            bar.contains(rect.left()) && bar.contains(rect.right()),
            "{rect:?}"
        );
    }

    #[test]
    fn the_end_of_a_render_is_told_in_words() {
        let mut render = RenderSettings::default();
        let mut stats = RenderStats {
            samples_per_pixel: 40.24,
            sample_range: [16, 64],
            ..RenderStats::default()
        };
        assert_eq!(ending(&stats, &render), "all samples taken");
        render.stop.noise = Some(0.03);
        assert_eq!(ending(&stats, &render), "not down to 3 %: samples used up");
        stats.ending = Ending::Noise;
        assert_eq!(ending(&stats, &render), "down to 3 %");
        assert_eq!(samples(&stats), "40.2 samples per pixel (16 – 64)");
        assert!(faults(&stats).is_empty());
        stats.non_finite_samples = 1;
        stats.negative_samples = 1200;
        assert_eq!(
            faults(&stats),
            [
                "1 sample is infinite or not a number",
                "1,200 samples have less than no light"
            ]
        );
        stats = RenderStats::default();
        stats.samples = 1000;
        stats.depth_limited_samples = 100;
        assert!(faults(&stats).is_empty());
        stats.depth_limited_samples = 250;
        assert_eq!(
            faults(&stats),
            ["25 % of samples may lack light: max bounces ended their paths"]
        );
    }
}
