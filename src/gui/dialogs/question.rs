//! The question that stands between unsaved work and its loss.

use std::time::Duration;

use egui::{RichText, Ui};

use super::{Intent, buttons_ui, modal_ui};
use crate::gui::commands::Stoppable;
use crate::gui::picture::LONG;
use crate::gui::status_bar::duration;
use crate::gui::widgets::primary_button;

/// What the user decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Nothing yet.
    None,
    /// Save, then go on.
    Save,
    /// Go on; the work is lost.
    Discard,
    /// Leave everything as it is.
    Cancel,
}

/// Asks.
#[must_use]
pub fn unsaved_ui(ctx: &egui::Context, name: &str, intent: &Intent) -> Decision {
    let response = modal_ui(ctx, "unsaved", 440.0, |ui| {
        ui.heading(format!("Save the changes to {name}?"));
        ui.add_space(4.0);
        let (what, discard) = match intent {
            Intent::Open(_) | Intent::Import(_) => (
                "Another scene takes its place. Undo brings this one back.",
                "Replace",
            ),
            Intent::Restore(..) => (
                "What is restored takes its place. Undo brings this one back.",
                "Replace",
            ),
            Intent::Close => (
                "They are lost by closing the window without saving.",
                "Discard",
            ),
        };
        ui.label(RichText::new(what).weak());
        buttons_ui(ui, |ui| {
            let mut decision = Decision::None;
            let mut choice = |ui: &mut Ui, button: egui::Button<'_>, tooltip, meaning| {
                let response = ui.add(button).on_hover_text(tooltip);
                if response.clicked() {
                    decision = meaning;
                }
            };
            choice(
                ui,
                primary_button("Save first"),
                "Write the scene to its file, then go on",
                Decision::Save,
            );
            choice(
                ui,
                egui::Button::new(discard),
                "Go on without saving",
                Decision::Discard,
            );
            choice(
                ui,
                egui::Button::new("Cancel"),
                "Leave everything as it is",
                Decision::Cancel,
            );
            decision
        })
    });
    match response.inner {
        Decision::None if response.should_close() => Decision::Cancel,
        Decision::None if is_confirmed(ctx) => Decision::Save,
        decision => decision,
    }
}

/// Whether Enter was pressed and no button has the focus, which it would press.
pub(super) fn is_confirmed(ctx: &egui::Context) -> bool {
    ctx.input(|input| input.key_pressed(egui::Key::Enter))
        && ctx.memory(|memory| memory.focused().is_none())
}

/// Asks before `what`, of which the part `share` is done, is given up with the window. `Some(true)` to give it up, `Some(false)` to let
/// it go on; `None` while nothing is decided.
#[must_use]
pub fn running_ui(ctx: &egui::Context, what: Stoppable, share: Option<f64>) -> Option<bool> {
    let response = modal_ui(ctx, "running", 440.0, |ui| {
        ui.heading(format!("Give up {}?", what.in_words()));
        ui.add_space(4.0);
        let text = match share {
            Some(share) => {
                let done = (share * 100.0).floor();
                format!("It is at {done} %, and ends with the window.")
            }
            None => "The window closes as soon as it is done.".to_owned(),
        };
        ui.label(RichText::new(text).weak());
        keep_or_lose_ui(
            ui,
            ("Go on", "Leave the window open"),
            (
                "Give up and close",
                "What it has reached is lost, but for pictures that were saved",
            ),
        )
    });
    let is_over = response.should_close() || is_confirmed(ctx);
    response.inner.or(is_over.then_some(false))
}

/// Two buttons, each a name and a tooltip: to keep what there is, which is what is likely wanted, and to lose it. Returns whether it is to be
/// lost, once that is decided.
fn keep_or_lose_ui(ui: &mut Ui, keep: (&str, &str), lose: (&str, &str)) -> Option<bool> {
    buttons_ui(ui, |ui| {
        let keeps = ui.add(primary_button(keep.0)).on_hover_text(keep.1);
        let loses = ui.button(lose.0).on_hover_text(lose.1);
        let keeps = keeps.clicked().then_some(false);
        loses.clicked().then_some(true).or(keeps)
    })
}

/// Asks before pictures of these names, which are in no file, are lost with the window. `Some(true)` to lose them, `Some(false)` to leave the
/// window open; `None` while nothing is decided.
#[must_use]
pub fn pictures_ui(ctx: &egui::Context, names: &[&str]) -> Option<bool> {
    /// Names that are listed.
    const MOST: usize = 4;
    let response = modal_ui(ctx, "pictures", 440.0, |ui| {
        let (heading, they) = match names {
            [_] => ("Close without saving the picture?", "It is"),
            _ => ("Close without saving the pictures?", "They are"),
        };
        ui.heading(heading);
        ui.add_space(4.0);
        for name in names.iter().take(MOST) {
            ui.label(*name);
        }
        if names.len() > MOST {
            ui.label(format!("and {} more", names.len() - MOST));
        }
        let least = LONG.as_secs();
        let text =
            format!("{they} in no file, took {least} s or more to render, and would be lost.");
        ui.label(RichText::new(text).weak());
        keep_or_lose_ui(
            ui,
            (
                "Leave open",
                "Leave the window open, to save what is under Renders",
            ),
            (
                "Close without saving",
                "Close the window; the pictures are lost",
            ),
        )
    });
    let is_over = response.should_close() || is_confirmed(ctx);
    response.inner.or(is_over.then_some(false))
}

/// Asks before the picture called `name`, which is in no file, is forgotten. `Some(true)` to forget it, `Some(false)` to keep it; `None` while
/// nothing is decided.
#[must_use]
pub fn forget_ui(ctx: &egui::Context, name: &str) -> Option<bool> {
    let response = modal_ui(ctx, "forget", 440.0, |ui| {
        ui.heading("Forget the picture without saving it?");
        ui.add_space(4.0);
        ui.label(name);
        let least = LONG.as_secs();
        let text =
            format!("It is in no file, took {least} s or more to render, and would be lost.");
        ui.label(RichText::new(text).weak());
        keep_or_lose_ui(
            ui,
            ("Keep", "Leave it under Renders, to save it"),
            (
                "Forget without saving",
                "Take it out of the list; the picture is lost",
            ),
        )
    });
    let is_over = response.should_close() || is_confirmed(ctx);
    response.inner.or(is_over.then_some(false))
}

/// Asks before the running render called `name`, of which the part `share` is done after the time `elapsed`, is ended by another. `Some(true)` to
/// end it, `Some(false)` to let it go on; `None` while nothing is decided.
#[must_use]
pub fn anew_ui(ctx: &egui::Context, name: &str, share: f64, elapsed: Duration) -> Option<bool> {
    let response = modal_ui(ctx, "anew", 440.0, |ui| {
        ui.heading("End the running render for another?");
        ui.add_space(4.0);
        ui.label(name);
        let done = (share * 100.0).floor();
        let text = format!(
            "It is at {done} % after {}. Its picture so far stays under Renders, and cannot go on from there.",
            duration(elapsed)
        );
        ui.label(RichText::new(text).weak());
        keep_or_lose_ui(
            ui,
            ("Keep", "Leave the running render as it is"),
            ("Render anew", "End it, and render the scene as it is now"),
        )
    });
    let is_over = response.should_close() || is_confirmed(ctx);
    response.inner.or(is_over.then_some(false))
}
