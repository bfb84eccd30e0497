//! Which picture is looked at: that of the present render, or one of those before it.

use std::path::Path;

use super::App;
use crate::gui::commands::Command;
use crate::gui::dialogs::{Dialog, question};
use crate::gui::jobs::{Lane, drop_elsewhere};
use crate::gui::opened_picture::OpenedPicture;
use crate::gui::picture::Picture;
use crate::gui::renders::{Asked, Facts, Freed, Renders};
use crate::gui::top_bar::View;
use crate::gui::worker;

impl App {
    /// The picture that is looked at, where there is one.
    pub(super) fn shown_picture(&self) -> Option<&Picture> {
        match self.shown_render {
            Some(number) => self.renders.picture(number),
            None => self.picture.as_ref(),
        }
    }

    pub(super) fn shown_picture_mut(&mut self) -> Option<&mut Picture> {
        match self.shown_render {
            Some(number) => self.renders.picture_mut(number),
            None => self.picture.as_mut(),
        }
    }

    /// The picture of render `number`.
    pub(super) fn picture_of_mut(&mut self, number: usize) -> Option<&mut Picture> {
        match &mut self.picture {
            Some(picture) if picture.number == number => Some(picture),
            _ => self.renders.picture_mut(number),
        }
    }

    /// The number of the render that is looked at.
    pub(super) fn shown_number(&self) -> Option<usize> {
        let present = self.picture.as_ref().map(|picture| picture.number);
        self.shown_render.or(present)
    }

    /// Does what was asked for in the strip.
    pub(super) fn carry_out_asked(&mut self, ctx: &egui::Context, asked: Asked) {
        match asked {
            Asked::Show(number) => self.show_render(number),
            Asked::Restore(number) => self.restore_render(number),
            Asked::Compare(number) => self.compare_with(number),
            Asked::Forget(number) => self.ask_to_forget(ctx, number),
            Asked::Command(command) => self.carry_out(ctx, command),
        }
    }

    /// Takes render `number` out of the list, once nobody minds what is lost by that.
    fn ask_to_forget(&mut self, ctx: &egui::Context, number: usize) {
        if self
            .renders
            .is_just_forgotten(ctx.input(|input| input.time))
        {
            return;
        }
        let picture = self.picture_of_mut(number);
        if picture.is_some_and(|picture| picture.is_unsaved_work()) {
            self.ask(Dialog::Forget(number));
        } else {
            self.forget_render(ctx, number);
        }
    }

    /// Asks about the picture of render `number`, which is in no file, before it is forgotten.
    pub(super) fn forget_ui(&mut self, ctx: &egui::Context, number: usize) {
        let name = self.name_in_comparison(number);
        match question::forget_ui(ctx, &name) {
            Some(true) => self.forget_render(ctx, number),
            Some(false) => {}
            None => self.dialog = Some(Dialog::Forget(number)),
        }
    }

    /// Takes render `number`, which does not run, out of the list. Where it is looked at, another one is then.
    fn forget_render(&mut self, ctx: &egui::Context, number: usize) {
        self.renders.forgotten_at = Some(ctx.input(|input| input.time));
        let is_shown = self.shown_number() == Some(number);
        let is_present = |picture: &mut Picture| picture.number == number && !picture.is_running();
        if let Some(present) = self.picture.take_if(is_present) {
            if is_shown {
                self.jobs.cancel(Lane::Encode);
            }
            self.keep_render(present);
        } else if is_shown {
            self.show_present_render();
        }
        drop_elsewhere(self.renders.forget(number));
        if self.picture.is_none() && is_shown {
            match self.renders.entries().last() {
                Some(newest) => self.show_render(newest.facts.number),
                None => self.view = View::Preview,
            }
        }
    }

    /// Shows the picture of render `number`.
    pub(super) fn show_render(&mut self, number: usize) {
        self.view = View::Picture;
        if let Some(comparison) = &mut self.comparison {
            // Whoever asks for it wants to see it, whichever was seen in turn.
            comparison.shows_other = false;
        }
        let before = self.shown_number();
        if before == Some(number) {
            return;
        }
        let stand_in = self.shown_picture().map(Picture::as_stand_in);
        self.hide_past_render();
        let is_present = self.picture.as_ref().is_some_and(|p| p.number == number);
        self.shown_render = (!is_present).then_some(number);
        if let (Some(picture), Some(stand_in)) = (self.renders.picture_mut(number), stand_in) {
            picture.show_meanwhile(stand_in);
        }
        let display = self.document.scene.display;
        if let Some(picture) = self.shown_picture_mut() {
            picture.scene.display = display;
            picture.buffer.set_display(display);
            self.show_picture_as_asked();
        } else {
            self.messages.news(format!(
                "Of render {number} only the small picture is left; its settings can be restored"
            ));
        }
        self.compare_anew(number, before);
    }

    /// Goes back to the present render.
    pub(super) fn show_present_render(&mut self) {
        if let Some(number) = self.picture.as_ref().map(|picture| picture.number) {
            self.show_render(number);
        } else {
            self.hide_past_render();
            self.view = View::Preview;
        }
    }

    /// Takes a picture of the past off the screen, where one is looked at.
    pub(super) fn hide_past_render(&mut self) {
        if let Some(number) = self.shown_render.take() {
            self.jobs.cancel(Lane::Encode);
            if let Some(picture) = self.renders.picture_mut(number) {
                picture.hide();
            }
        }
    }

    /// Shows the render before or after the one that is looked at.
    pub(super) fn show_neighbour(&mut self, command: Command) {
        let past = self.renders.entries().iter();
        let mut numbers: Vec<usize> = past.map(|entry| entry.facts.number).collect();
        numbers.extend(self.picture.as_ref().map(|picture| picture.number));
        let here = numbers.iter().position(|n| Some(*n) == self.shown_number());
        let there = match (here, command) {
            (Some(here), Command::ShowOlderRender) => here.checked_sub(1),
            (Some(here), _) => Some(here + 1),
            (None, _) => numbers.len().checked_sub(1),
        };
        if let Some(&number) = there.and_then(|there| numbers.get(there)) {
            self.show_render(number);
        }
    }

    /// Makes the scene what it was for render `number`, as one step to undo. Where that is another than the one that is open, it takes the
    /// place of that as a scene that is opened does.
    fn restore_render(&mut self, number: usize) {
        let present = self.picture.as_ref().filter(|p| p.number == number);
        let present = present.map(|picture| (picture.scene_to_repeat(), Facts::of(picture)));
        let past = self.renders.entry(number);
        let past = past.map(|entry| (entry.scene.clone(), entry.facts.clone()));
        let Some((scene, facts)) = present.or(past) else {
            return;
        };
        self.region.choose(facts.part);
        let before = self.document.name().to_owned();
        let is_of_other = facts.file != self.document.file_number();
        let of = (facts.file, facts.scene_name);
        let step = format!("restoring the settings of render {number}");
        self.document
            .restore_rendered(scene, of, &self.selection, step);
        let mut news = format!("The scene is that of render {number}");
        if is_of_other {
            let is_seen = self.view == View::Picture;
            self.show_other_scene();
            if is_seen {
                self.show_render(number);
            }
            news = format!("{news}. Undo brings {before} back");
        }
        self.messages.news(self.with_note_on_rules(news));
    }

    /// Remembers a render that makes room for another, if it is worth it.
    pub(super) fn keep_render(&mut self, picture: Picture) {
        // Those that edits start anew would push all others out of the plot.
        let is_in_plot = !picture.is_replaced() && self.error_plot.keep(&picture);
        let is_wanted = Renders::wants(&picture);
        if is_in_plot || is_wanted {
            self.render_count = self.render_count.max(picture.number);
        }
        drop_elsewhere(if is_wanted {
            self.renders.keep(picture, &self.document.scene)
        } else {
            self.renders.forget_thumbnail(picture.buffer.id());
            vec![Freed::of(picture)]
        });
    }

    /// Puts the picture of the file that was opened among the renders, and shows it.
    pub(super) fn show_opened(&mut self, path: &Path, opened: OpenedPicture) {
        let present = self.picture.as_ref().map_or(0, |picture| picture.number);
        let number = self.render_count.max(present) + 1;
        self.render_count = number;
        let file = path.file_name().unwrap_or(path.as_os_str());
        let names = [
            file.to_string_lossy().into_owned(),
            self.document.name().to_owned(),
        ];
        let scene = self.document.scene.clone();
        let mut picture = Picture::opened(number, names, scene, opened);
        picture.file = self.document.file_number();
        // What is rendered is what was.
        self.region.choose(picture.buffer.part());
        drop_elsewhere(self.renders.keep(picture, &self.document.scene));
        self.show_render(number);
    }

    /// Gives up the pixels of all past renders, as a render does not fit beside them; returns whether there were any.
    pub(super) fn free_past_pixels(&mut self) -> bool {
        self.hide_past_render();
        self.freed = self.renders.free_pixels();
        if self.freed.is_empty() {
            return false;
        }
        self.stop_comparing();
        self.messages.warning(
            "Of earlier renders only the small pictures are left",
            "Their pixels made room for the render that runs now. Their settings can still be restored.",
        );
        true
    }

    /// Has small pictures made of renders that have none.
    pub(super) fn update_thumbnails(&mut self) {
        if self.jobs.is_busy(Lane::Thumbnails) {
            return;
        }
        let missing = self.renders.without_thumbnail(self.picture.as_ref());
        if !missing.is_empty() {
            self.jobs.start(Lane::Thumbnails, move |job| {
                worker::make_thumbnails(job, &missing);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use egui_kittest::kittest::Queryable as _;
    use std::time::Duration;

    use super::*;
    use crate::gui::app::testing;
    use crate::gui::picture::{LONG, Outcome};

    type Window = egui_kittest::Harness<'static, App>;

    fn click(window: &mut Window, name: &str) {
        window.run_steps(3);
        window.get_by_label(name).click();
        window.run_steps(3);
    }

    /// A render could not go on once another has taken its place.
    #[test]
    fn a_long_render_is_not_ended_by_another_without_a_question() {
        let mut window = testing::window(None);
        let press_f5 = |window: &mut Window| {
            window.key_press(egui::Key::F5);
            window.run_steps(3);
        };
        let asks = |window: &Window| {
            let heading = "End the running render for another?";
            window.query_by_label(heading).is_some()
        };
        let runs = |app: &App, number| {
            let mut picture = app.picture.iter();
            picture.any(|p| p.number == number && p.is_running())
        };
        let app = window.state_mut();
        let mut picture = testing::picture(app);
        picture.first_tile = Some(Duration::ZERO);
        picture.go_on_after(LONG, 0.5);
        picture.progress.go_on_at(0.5);
        (app.picture, app.view) = (Some(picture), View::Picture);
        press_f5(&mut window);
        assert!(asks(&window));
        let told = "It is at 50 % after 30";
        assert!(window.query_by_label_contains(told).is_some());
        click(&mut window, "Keep");
        assert!(!asks(&window) && runs(window.state(), 1));

        // One that ends while it is asked about stays to be looked at.
        press_f5(&mut window);
        window.state_mut().end_picture(Outcome::Cancelled);
        window.run_steps(3);
        assert!(!asks(&window) && window.state().waiting_render.is_none());
        let app = window.state_mut();
        assert!(app.picture.as_ref().is_some_and(|p| p.number == 1));
        if let Some(picture) = &mut app.picture {
            picture.outcome = Outcome::Running;
        }

        press_f5(&mut window);
        click(&mut window, "Render anew");
        testing::until(&mut window, |app| runs(app, 2));
        let entries = window.state().renders.entries();
        let entries = entries
            .iter()
            .map(|it| (it.facts.number, &it.facts.outcome));
        assert_eq!(entries.collect::<Vec<_>>(), [(1, &Outcome::Cancelled)]);
        // A short one is soon made again.
        press_f5(&mut window);
        assert!(!asks(&window));
        window.state_mut().cancel_render();
    }

    /// What took long, is in no file and cannot be undone is asked about, as when the window closes.
    #[test]
    fn a_long_render_that_is_not_saved_is_not_forgotten_without_a_question() {
        let mut window = testing::window(None);
        let app = window.state_mut();
        let mut picture = testing::picture(app);
        picture.first_tile = Some(Duration::ZERO);
        picture.go_on_after(LONG, 0.5);
        picture.end(Outcome::Cancelled);
        (app.picture, app.view, app.renders.open) = (Some(picture), View::Picture, true);
        click(&mut window, "Forget");
        let asks = "Forget the picture without saving it?";
        assert!(window.query_by_label(asks).is_some());
        click(&mut window, "Keep");
        assert!(window.query_by_label(asks).is_none());
        assert!(window.state().picture.is_some());
        click(&mut window, "Forget");
        click(&mut window, "Forget without saving");
        assert!(window.state().picture.is_none());
        assert!(window.state().renders.entries().is_empty());
        // What is in a file is there again.
        let app = window.state_mut();
        let mut picture = testing::picture(app);
        picture.go_on_after(LONG, 0.5);
        picture.end(Outcome::Cancelled);
        picture.set_saved(true);
        (app.picture, app.view) = (Some(picture), View::Picture);
        window.run_steps(40);
        click(&mut window, "Forget");
        assert!(window.state().picture.is_none() && window.state().dialog.is_none());
    }
}
