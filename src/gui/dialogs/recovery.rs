//! The question about work that a window before did not save.

use std::time::Duration;

use egui::RichText;

use super::{buttons_ui, modal_ui};
use crate::gui::keeping::Lost;
use crate::gui::widgets::{counted, primary_button};

/// What the user decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Nothing yet.
    None,
    /// Go on with it.
    Restore,
    /// Remove it for good.
    Discard,
    /// Leave it where it is.
    Later,
}

/// Asks about `lost`.
#[must_use]
pub fn recovery_ui(ctx: &egui::Context, lost: &Lost) -> Answer {
    let response = modal_ui(ctx, "recovery", 460.0, |ui| {
        let is_unsaved = lost.scene_file().is_some();
        ui.heading(if is_unsaved {
            "Restore unsaved work?"
        } else {
            "Go on with the render?"
        });
        ui.add_space(4.0);
        let age = lost.edited.elapsed().unwrap_or_default();
        let name = &lost.about.name;
        let age = ago(age);
        ui.label(if is_unsaved {
            format!("RayMini ended before the changes to {name} were saved. They were made {age}.")
        } else {
            format!("RayMini ended before the render of {name} was saved. It was kept {age}.")
        });
        if is_unsaved && lost.render().is_some() {
            ui.label("A render was not saved, and goes on where it was.");
        }
        if is_unsaved && let Some(path) = &lost.about.path {
            let text = format!("{} is as it was saved last.", path.display());
            ui.label(RichText::new(text).weak());
        }
        buttons_ui(ui, |ui| {
            let mut answer = Answer::None;
            for (button, tooltip, meaning) in [
                (
                    primary_button(if is_unsaved { "Restore" } else { "Go on" }),
                    "Go on where it ended",
                    Answer::Restore,
                ),
                (
                    egui::Button::new("Discard"),
                    "Remove it for good",
                    Answer::Discard,
                ),
                (
                    egui::Button::new("Later"),
                    "Ask again when RayMini starts next",
                    Answer::Later,
                ),
            ] {
                let response = ui.add(button).on_hover_text(tooltip);
                if response.clicked() {
                    answer = meaning;
                }
                // Enter does what is likely wanted.
                if meaning == Answer::Restore && ui.memory(|memory| memory.focused().is_none()) {
                    response.request_focus();
                }
            }
            answer
        })
    });
    match response.inner {
        Answer::None if response.should_close() => Answer::Later,
        answer => answer,
    }
}

/// How long ago, in words.
fn ago(age: Duration) -> String {
    let minutes = usize::try_from(age.as_secs() / 60).unwrap_or(usize::MAX);
    match minutes {
        0 => "less than a minute ago".to_owned(),
        1..60 => format!("{} ago", counted(minutes, "minute", "minutes")),
        60..1440 => format!("{} ago", counted(minutes / 60, "hour", "hours")),
        _ => format!("{} ago", counted(minutes / 1440, "day", "days")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_read_well() {
        let words = |seconds| ago(Duration::from_secs(seconds));
        assert_eq!(words(59), "less than a minute ago");
        assert_eq!(words(60), "1 minute ago");
        assert_eq!(words(7300), "2 hours ago");
        assert_eq!(words(90_000), "1 day ago");
    }
}
