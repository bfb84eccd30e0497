//! The strip of renders: small pictures from left to right, newest first, and what there is to say about the one that shows.

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Button, Color32, CornerRadius, FontId, Rect, RichText, Sense, Stroke, StrokeKind, Ui, Vec2,
};

use super::{Facts, Renders};
use crate::gui::commands::Command;
use crate::gui::picture::Picture;
use crate::gui::theme;

/// Height of the strip, in points: as it opens, and the least.
pub const HEIGHT: f32 = 158.0;
/// See [`HEIGHT`].
pub const LEAST_HEIGHT: f32 = 128.0;
/// Width of the words beside the small pictures, in points.
const WORDS_WIDTH: f32 = 268.0;
/// Room around a small picture for its outline, in points.
const OUTLINE: Vec2 = Vec2::new(0.0, 2.0);
/// Room below a small picture for its line, and the most that this takes, in points.
const LINE_HEIGHT: f32 = 18.0;
const MOST_LINE_WIDTH: f32 = 180.0;
/// Height of the strip from which on there is room for a second line of settings, in points.
const TWO_LINES_HEIGHT: f32 = 140.0;

/// What the strip draws.
#[derive(Clone, Copy, Debug)]
pub struct StripState<'a> {
    /// The present render.
    pub present: Option<&'a Picture>,
    /// The number of the render that is looked at.
    pub shown: Option<usize>,
    /// Whether a picture is on the screen that can be saved.
    pub can_save: bool,
}

/// What was asked for in the strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Show the picture of this render.
    Show(usize),
    /// Make the scene what it was for this render.
    Restore(usize),
    /// Compare the shown picture with that of this render.
    Compare(usize),
    /// Forget this render.
    Forget(usize),
    /// A command of the window.
    Command(Command),
}

impl Renders {
    /// Draws the strip; returns what was asked for.
    pub fn strip_ui(&self, ui: &mut Ui, state: &StripState<'_>) -> Option<Asked> {
        let present = state.present.map(Facts::of);
        let past = self.entries.iter().map(|entry| &entry.facts);
        let facts: Vec<&Facts> = past.chain(&present).collect();
        if facts.is_empty() {
            ui.centered_and_justified(|ui| ui.weak("Render, and the picture is kept here"));
            return None;
        }
        let mut asked = None;
        let available = ui.available_size();
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 10.0;
            let width = (available.x - WORDS_WIDTH - 10.0).max(120.0);
            ui.allocate_ui(Vec2::new(width, available.y), |ui| {
                ui.set_min_size(Vec2::new(width, available.y));
                egui::ScrollArea::horizontal()
                    .auto_shrink(false)
                    .show(ui, |ui| {
                        ui.horizontal_top(|ui| {
                            ui.spacing_mut().item_spacing.x = 6.0;
                            // The outline of the first.
                            ui.add_space(2.0);
                            for facts in facts.iter().rev() {
                                asked = self.card_ui(ui, state, facts).or(asked);
                            }
                        });
                    });
            });
            ui.vertical(|ui| {
                ui.set_width(WORDS_WIDTH);
                let shown = facts.iter().find(|f| Some(f.number) == state.shown);
                if let Some(shown) = shown {
                    asked = self.words_ui(ui, state, shown).or(asked);
                    asked = self.compare_ui(ui, state, &facts).or(asked);
                }
            });
        });
        asked
    }

    /// A small picture with a line below it: a click shows its render.
    fn card_ui(&self, ui: &mut Ui, state: &StripState<'_>, facts: &Facts) -> Option<Asked> {
        let height = (ui.available_height() - LINE_HEIGHT - 18.0).max(40.0);
        let color = ui.visuals().text_color();
        let line = format!("{}  {}", facts.number, facts.result());
        let mut line = LayoutJob::simple_singleline(line, FontId::proportional(11.0), color);
        line.wrap = TextWrapping::truncate_at_width(MOST_LINE_WIDTH);
        let line = ui.painter().layout_job(line);
        // What is under a narrow picture is to be read too.
        let width = (height * ratio_of(facts)).clamp(64.0, 260.0);
        let width = width.max(line.size().x + 2.0);
        let size = Vec2::new(width, height + LINE_HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size + OUTLINE * 2.0, Sense::click());
        let rect = rect.shrink2(OUTLINE);
        let is_shown = state.shown == Some(facts.number);
        let name = format!("Show render {}", facts.number);
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, ui.is_enabled(), is_shown, &name)
        });
        if ui.is_rect_visible(rect) {
            let frame = Rect::from_min_size(rect.min, Vec2::new(width, height));
            self.small_picture_ui(ui, state, facts, frame);
            let visuals = ui.visuals();
            let edge = if is_shown {
                Stroke::new(2.0, theme::ACCENT)
            } else if response.hovered() || response.has_focus() {
                Stroke::new(1.5, visuals.widgets.hovered.fg_stroke.color)
            } else {
                Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color)
            };
            ui.painter()
                .rect_stroke(frame, CornerRadius::same(2), edge, StrokeKind::Outside);
            let place = frame.left_bottom() + Vec2::new(1.0, 4.0);
            let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
            painter.galley(place, line, color);
        }
        let tooltip = format!("{}\n{}\n{}", facts.name, facts.settings(), facts.result());
        let response = response.on_hover_text(tooltip);
        let mut asked = response.clicked().then_some(Asked::Show(facts.number));
        response.context_menu(|ui| {
            asked = self.menu_ui(ui, state, facts).or(asked);
        });
        asked
    }

    /// The picture, scaled to fit into `frame`.
    fn small_picture_ui(&self, ui: &Ui, state: &StripState<'_>, facts: &Facts, frame: Rect) {
        let painter = ui.painter();
        painter.rect_filled(frame, CornerRadius::ZERO, theme::backdrop(ui.visuals()));
        let present = state.present.filter(|p| p.number == facts.number);
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        let ratio = ratio_of(facts);
        let width = frame.width().min(frame.height() * ratio);
        let inside = Rect::from_center_size(frame.center(), Vec2::new(width, width / ratio));
        if let Some(small) = self.thumbnail(facts.picture) {
            painter.image(small.id(), inside, whole, Color32::WHITE);
        } else if let Some(picture) = present {
            // A running render has no small picture yet: what is on the screen serves.
            picture.paint(painter, inside);
        }
    }

    /// What can be done with a render.
    fn menu_ui(&self, ui: &mut Ui, state: &StripState<'_>, facts: &Facts) -> Option<Asked> {
        let number = facts.number;
        let mut asked = None;
        let can_forget = self.can_forget(state, number);
        for (name, tooltip, is_possible, meaning) in [
            (
                "Restore settings",
                RESTORE_TOOLTIP,
                true,
                Asked::Restore(number),
            ),
            (
                "Compare shown picture with this",
                "Show both with a divider, in turn, or their difference",
                self.can_compare(state, number),
                Asked::Compare(number),
            ),
            ("Forget", FORGET_TOOLTIP, can_forget, Asked::Forget(number)),
        ] {
            let response = ui.add_enabled(is_possible, Button::new(name));
            if response.on_hover_text(tooltip).clicked() {
                asked = Some(meaning);
                ui.close();
            }
        }
        asked
    }

    /// Whether render `number` can be forgotten: whether it has ended.
    fn can_forget(&self, state: &StripState<'_>, number: usize) -> bool {
        let present = state.present.filter(|picture| !picture.is_running());
        present.is_some_and(|picture| picture.number == number) || self.entry(number).is_some()
    }

    /// Whether the shown picture can be compared with that of render `number`.
    fn can_compare(&self, state: &StripState<'_>, number: usize) -> bool {
        let present = state.present.filter(|picture| !picture.is_running());
        let is_there = present.is_some_and(|picture| picture.number == number)
            || self.picture(number).is_some();
        is_there && state.can_save && state.shown != Some(number)
    }

    /// What the shown picture can be compared with, as a menu.
    fn compare_ui(&self, ui: &mut Ui, state: &StripState<'_>, all: &[&Facts]) -> Option<Asked> {
        /// Renders on offer, the newest first: the others have the menus of their small pictures.
        const MOST: usize = 12;
        let mut asked = None;
        ui.add_enabled_ui(state.can_save, |ui| {
            let menu = ui.menu_button("Compare with…", |ui| {
                let others = all.iter().rev();
                let others = others.filter(|facts| self.can_compare(state, facts.number));
                for facts in others.take(MOST) {
                    let name = format!("{}  {}  ·  {}", facts.number, facts.name, facts.result());
                    if ui.button(name).on_hover_text(facts.settings()).clicked() {
                        asked = Some(Asked::Compare(facts.number));
                        ui.close();
                    }
                }
                ui.separator();
                let command = Command::CompareFile;
                let file = ui
                    .button("Image file…")
                    .on_hover_text(command.description());
                if file.clicked() {
                    asked = Some(Asked::Command(command));
                    ui.close();
                }
            });
            menu.response
                .on_hover_text("Show another picture against this one, and how far they are apart")
                .on_disabled_hover_text("There is no picture to compare");
        });
        asked
    }

    /// What there is to say about the render that shows, and what can be done with it.
    fn words_ui(&self, ui: &mut Ui, state: &StripState<'_>, facts: &Facts) -> Option<Asked> {
        ui.spacing_mut().item_spacing.y = 3.0;
        let line = |ui: &mut Ui, text: RichText| {
            ui.add(egui::Label::new(text).truncate());
        };
        let has_room = ui.available_height() >= TWO_LINES_HEIGHT;
        let title = format!("{}  {}", facts.number, facts.name);
        line(ui, RichText::new(title).strong());
        let settings = RichText::new(facts.settings()).size(12.0);
        if has_room {
            ui.add(egui::Label::new(settings).wrap());
        } else {
            line(ui, settings);
        }
        line(ui, RichText::new(facts.result()).size(12.0));
        let entry = self.entry(facts.number);
        let note = match (facts.hash(), entry) {
            (_, Some(entry)) if entry.picture.is_none() => {
                "Only the small picture is left: memory for renders is full".to_owned()
            }
            (Some(hash), _) => format!("hash {}", &hash[..hash.len().min(16)]),
            (None, _) => String::new(),
        };
        line(ui, RichText::new(note).size(12.0).weak());
        ui.add_space(3.0);
        let mut asked = None;
        ui.horizontal(|ui| {
            let restore = ui.button("Restore settings").on_hover_text(RESTORE_TOOLTIP);
            if restore.clicked() {
                asked = Some(Asked::Restore(facts.number));
            }
            let save = ui
                .add_enabled(state.can_save, Button::new("Save…"))
                .accessible_name("Save shown picture")
                .on_hover_text(Command::SavePicture.tooltip(ui.ctx()))
                .on_disabled_hover_text("There is no picture to save");
            if save.clicked() {
                asked = Some(Asked::Command(Command::SavePicture));
            }
            let forget = ui
                .add_enabled(self.can_forget(state, facts.number), Button::new("Forget"))
                .on_hover_text(FORGET_TOOLTIP)
                .on_disabled_hover_text("It still runs");
            if forget.clicked() {
                asked = Some(Asked::Forget(facts.number));
            }
        });
        asked
    }
}

/// Width over height of what was rendered.
fn ratio_of(facts: &Facts) -> f32 {
    let region = facts.part.region;
    region.width.max(1) as f32 / region.height.max(1) as f32
}

const RESTORE_TOOLTIP: &str =
    "Make the scene and all settings what they were for this render; Undo takes it back";
const FORGET_TOOLTIP: &str = "Take this render out of the list and free its memory";
