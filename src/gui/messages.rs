//! What the window has to tell: failures and warnings as banners that stay until they are dismissed, good news as one line
//! in the status bar.

use std::time::{Duration, Instant};

use egui::{Align, Frame, Layout, Margin, RichText, Ui};

use super::widgets::counted;

/// How serious a banner is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something the user asked for did not happen.
    Error,
    /// Something the user asked for happened in part.
    Warning,
}

/// A banner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How serious it is.
    pub severity: Severity,
    /// What happened, in a few words.
    pub title: String,
    /// Why, and what to do.
    pub text: String,
}

/// The banners that have not been dismissed, and the last good news.
#[derive(Clone, Debug, Default)]
pub struct Messages {
    banners: Vec<Message>,
    news: String,
    /// When they were told.
    told: Option<Instant>,
    /// Whether the next edit makes the news old.
    are_until_edit: bool,
}

/// How long good news are shown.
const NEWS_TIME: Duration = Duration::from_secs(8);

/// Banners shown at once, the newest: more would leave the picture little room. Older ones are counted.
const MOST_SHOWN: usize = 2;

/// Banners that are kept; older ones go first.
const MOST_BANNERS: usize = 20;

impl Messages {
    /// Says that something failed.
    pub fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.push(Severity::Error, title.into(), text.into());
    }

    /// Says that something is not wholly as asked for.
    pub fn warning(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.push(Severity::Warning, title.into(), text.into());
    }

    /// Good news for the status bar.
    pub fn news(&mut self, text: impl Into<String>) {
        self.news = text.into();
        self.told = Some(Instant::now());
        self.are_until_edit = false;
    }

    /// [`Self::news`] that the next edit or selection makes old.
    pub fn news_until_edit(&mut self, text: impl Into<String>) {
        self.news(text);
        self.are_until_edit = true;
    }

    /// The scene was edited, or something else was selected.
    pub fn note_edit(&mut self) {
        if self.are_until_edit {
            self.news("");
        }
    }

    /// The last good news; empty when there is none.
    #[must_use]
    pub fn last_news(&self) -> &str {
        &self.news
    }

    /// The last good news while they are new, and for how long they still are; what is going on is told until something else is.
    #[must_use]
    pub fn fresh_news(&self) -> (&str, Option<Duration>) {
        let age = self.told.map_or(Duration::MAX, |told| told.elapsed());
        let left = NEWS_TIME.saturating_sub(age);
        if self.news.is_empty() || self.news.ends_with('…') {
            (&self.news, None)
        } else if left.is_zero() {
            ("", None)
        } else {
            (&self.news, Some(left))
        }
    }

    /// The banners, oldest first.
    #[must_use]
    pub fn banners(&self) -> &[Message] {
        &self.banners
    }

    /// Removes the banners called `title`: what they say is no longer so.
    pub fn withdraw(&mut self, title: &str) {
        self.banners.retain(|banner| banner.title != title);
    }

    /// Removes all banners: what they were about is gone.
    pub fn clear(&mut self) {
        self.banners.clear();
    }

    fn push(&mut self, severity: Severity, title: String, text: String) {
        let message = Message {
            severity,
            title,
            text,
        };
        self.banners.retain(|banner| *banner != message);
        self.banners.push(message);
        let surplus = self.banners.len().saturating_sub(MOST_BANNERS);
        self.banners.drain(..surplus);
    }

    /// Removes the newest banner.
    pub fn dismiss_newest(&mut self) {
        self.banners.pop();
    }

    /// Draws the newest banners over the full width, and says how many others there are.
    pub fn banners_ui(&mut self, ui: &mut Ui) {
        let mut dismissed = None;
        let hidden = self.banners.len().saturating_sub(MOST_SHOWN);
        for (index, message) in self.banners.iter().enumerate().skip(hidden) {
            if banner_ui(ui, message) {
                dismissed = Some(index);
            }
        }
        if let Some(index) = dismissed {
            self.banners.remove(index);
        } else if self.banners.len() > 1 && all_ui(ui, hidden) {
            self.clear();
        }
    }
}

/// Says how many banners do not show, and offers to remove all; returns whether they are to go.
fn all_ui(ui: &mut Ui, hidden: usize) -> bool {
    Frame::new()
        .fill(ui.visuals().panel_fill)
        .inner_margin(Margin::symmetric(12, 4))
        .show(ui, |ui| {
            // In a row: without one, what is centred takes all the height there is.
            ui.horizontal(|ui| {
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let dismiss = ui
                        .button("Dismiss all")
                        .on_hover_text("Remove all messages");
                    if hidden > 0 {
                        let older = counted(hidden, "older message", "older messages");
                        ui.label(RichText::new(format!("and {older}")).weak());
                    }
                    dismiss.clicked()
                })
                .inner
            })
            .inner
        })
        .inner
}

/// Draws a banner; returns whether it is to go.
fn banner_ui(ui: &mut Ui, message: &Message) -> bool {
    let visuals = ui.visuals();
    let color = match message.severity {
        Severity::Error => visuals.error_fg_color,
        Severity::Warning => visuals.warn_fg_color,
    };
    Frame::new()
        .fill(visuals.panel_fill.lerp_to_gamma(color, 0.16))
        .inner_margin(Margin::symmetric(12, 8))
        .show(ui, |ui| {
            ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                let dismiss = ui
                    .button("Dismiss")
                    .on_hover_text("Remove this message; Esc removes the newest")
                    .clicked();
                ui.with_layout(Layout::top_down(Align::Min), |ui| {
                    ui.label(RichText::new(&message.title).strong().color(color));
                    egui::ScrollArea::vertical()
                        .max_height(96.0)
                        .id_salt(&message.text)
                        .show(ui, |ui| {
                            ui.set_width(ui.available_width());
                            ui.add(egui::Label::new(&message.text).wrap().selectable(true));
                        });
                });
                dismiss
            })
            .inner
        })
        .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_longer_so_is_withdrawn() {
        let mut messages = Messages::default();
        messages.error("cannot read a", "line 1");
        messages.error("cannot read b", "line 2");
        messages.withdraw("cannot read a");
        let titles: Vec<_> = messages
            .banners()
            .iter()
            .map(|m| m.title.as_str())
            .collect();
        assert_eq!(titles, ["cannot read b"]);
    }

    #[test]
    fn good_news_fade_and_what_goes_on_stays() {
        let mut messages = Messages::default();
        assert_eq!(messages.fresh_news(), ("", None));
        messages.news("Copied ram");
        let (news, left) = messages.fresh_news();
        assert_eq!(news, "Copied ram");
        assert!(left.is_some_and(|left| left <= NEWS_TIME));
        messages.told = Instant::now().checked_sub(NEWS_TIME);
        assert_eq!(messages.fresh_news(), ("", None));
        assert_eq!(messages.last_news(), "Copied ram");
        messages.news("Saving the scene…");
        messages.told = Instant::now().checked_sub(NEWS_TIME);
        assert_eq!(messages.fresh_news(), ("Saving the scene…", None));
    }

    #[test]
    fn the_newest_messages_stay_and_none_is_doubled() {
        let mut messages = Messages::default();
        for name in ["a", "b", "a", "c", "d"] {
            messages.error("cannot open", name);
        }
        let texts = |messages: &Messages| -> Vec<String> {
            let banners = messages.banners().iter();
            banners.map(|banner| banner.text.clone()).collect()
        };
        assert_eq!(texts(&messages), ["b", "a", "c", "d"]);
        messages.dismiss_newest();
        assert_eq!(texts(&messages), ["b", "a", "c"]);
        for number in 0..MOST_BANNERS {
            messages.error("cannot open", number.to_string());
        }
        assert_eq!(texts(&messages).len(), MOST_BANNERS);
        assert_eq!(texts(&messages)[0], "0");
    }
}
