//! The picture that is looked at against another one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::App;
use crate::gui::compare::{self, Comparison, FilePicture, Mode, Side};
use crate::gui::document::name_of;
use crate::gui::event::Event;
use crate::gui::jobs::{Lane, drop_elsewhere};
use crate::gui::top_bar::View;

/// What a banner says until something is compared.
const CANNOT_COMPARE: &str = "Cannot compare";

impl App {
    /// What the picture of render `number` is called in a comparison.
    pub(super) fn name_in_comparison(&self, number: usize) -> String {
        let present = self.picture.as_ref().filter(|p| p.number == number);
        let past = self.renders.entry(number).map(|entry| &entry.facts.name);
        let name = present.map(|picture| &picture.name).or(past);
        format!("{number}  {}", name.map_or("", String::as_str))
    }

    /// What the picture that is looked at is called.
    pub(super) fn shown_name(&self) -> String {
        self.shown_number()
            .map_or_else(String::new, |number| self.name_in_comparison(number))
    }

    /// Whether there is another render to compare the shown one with.
    pub(super) fn can_compare(&self) -> bool {
        self.comparison.is_some() || self.shown_picture().is_some() && self.neighbour().is_some()
    }

    /// The newest render with a picture that is not the shown one.
    fn neighbour(&self) -> Option<usize> {
        let past = self.renders.entries().iter().rev();
        let past = past.filter(|entry| entry.picture.is_some());
        let mut past = past.map(|entry| entry.facts.number);
        past.find(|number| Some(*number) != self.shown_number())
            .or_else(|| {
                let present = self.picture.as_ref().filter(|p| !p.is_running())?;
                (Some(present.number) != self.shown_number()).then_some(present.number)
            })
    }

    /// Compares the shown render with the newest other one, or stops comparing.
    pub(super) fn toggle_comparison(&mut self) {
        if self.comparison.is_some() {
            self.stop_comparing();
        } else if let Some(number) = self.neighbour() {
            self.compare_with(number);
        }
    }

    /// Compares the picture that is looked at with that of render `number`.
    pub(super) fn compare_with(&mut self, number: usize) {
        let name = self.name_in_comparison(number);
        let picture = match &self.picture {
            Some(picture) if picture.number == number => Some(picture),
            _ => self.renders.picture(number),
        };
        let Some(buffer) = picture.map(|picture| Arc::clone(&picture.buffer)) else {
            return;
        };
        self.begin_comparing(Comparison::new(name, Some(number), buffer));
    }

    /// Reads the picture in `path` to compare with.
    pub(super) fn compare_with_file(&mut self, path: PathBuf) {
        self.jobs.start(Lane::CompareFile, move |job| {
            if let Some(result) = FilePicture::read(&path, &job.cancel).transpose() {
                job.send(Event::ComparisonRead { path, result });
            }
        });
    }

    pub(super) fn comparison_read(&mut self, path: &Path, result: Result<FilePicture, String>) {
        match result {
            Ok(file) => {
                if !file.warnings.is_empty() {
                    let title = format!("Compared with {}, with remarks", name_of(path));
                    self.messages.warning(title, file.warnings.join("\n"));
                }
                let name = path.file_name().unwrap_or(path.as_os_str());
                let name = name.to_string_lossy().into_owned();
                self.begin_comparing(Comparison::with_file(name, file));
            }
            Err(error) => self.messages.error(CANNOT_COMPARE, error),
        }
    }

    /// Render `shown` is looked at by now, and was not `before`: where it is what was compared with, the sides change places. A picture that
    /// still changes can only be at the left.
    pub(super) fn compare_anew(&mut self, shown: usize, before: Option<usize>) {
        let comparison = self.comparison.as_ref();
        if comparison.is_none_or(|comparison| comparison.number != Some(shown)) {
            return;
        }
        let ended = before.filter(|&number| {
            let picture = self.picture_of_mut(number);
            picture.is_some_and(|picture| !picture.is_running())
        });
        match ended {
            Some(number) => self.compare_with(number),
            None => self.stop_comparing(),
        }
    }

    fn begin_comparing(&mut self, mut comparison: Comparison) {
        self.view = View::Picture;
        self.messages.withdraw(CANNOT_COMPARE);
        if let Some(before) = &mut self.comparison {
            comparison.continue_from(before);
        }
        self.comparison = Some(comparison);
        self.jobs.cancel(Lane::Compare);
        self.encode_other();
    }

    pub(super) fn stop_comparing(&mut self) {
        if let Some(comparison) = self.comparison.take() {
            self.jobs.cancel(Lane::Compare);
            self.jobs.cancel(Lane::EncodeOther);
            drop_elsewhere(comparison.buffer);
        }
    }

    /// Shows the other of two compared pictures.
    pub(super) fn flip(&mut self) {
        if let Some(comparison) = &mut self.comparison {
            comparison.mode = Mode::Flip;
            comparison.shows_other = !comparison.shows_other;
        }
    }

    /// Has the other picture encoded as the shown one is.
    pub(super) fn encode_other(&mut self) {
        let Some(comparison) = &self.comparison else {
            return;
        };
        let buffer = Arc::clone(&comparison.buffer);
        // What has its look for good is shown as it is.
        let is_light = comparison.saved_look.is_none();
        let display = is_light.then_some(self.document.scene.display);
        buffer.set_display(display.unwrap_or_default());
        self.look_at(&buffer);
        self.jobs.start(Lane::EncodeOther, move |job| {
            buffer.encode_all(&job.cancel, |encoded| {
                job.send(Event::CompareEncoded(Side::Other, encoded));
            });
        });
    }

    /// Has measured what is compared, where it is looked at and not known.
    pub(super) fn update_comparison(&mut self) {
        let shown = self.picture_on_screen();
        let shown = shown.map(|p| (p.is_running(), Arc::clone(&p.buffer)));
        let (Some((is_running, a)), Some(comparison)) = (shown, &mut self.comparison) else {
            return;
        };
        if comparison.measures_another(a.id()) {
            // What is found of that, nobody wants to see.
            self.jobs.cancel(Lane::Compare);
        } else if self.jobs.is_busy(Lane::Compare) {
            return;
        }
        if !comparison.must_measure(a.id(), is_running) {
            return;
        }
        let (b, look) = (Arc::clone(&comparison.buffer), comparison.saved_look);
        self.jobs.start(Lane::Compare, move |job| {
            let compared = compare::compare_buffers(&a, &b, look.as_ref(), is_running, &job.cancel);
            match compared {
                Ok((distance, difference)) => {
                    let size = difference.size_in_texels();
                    job.send(Event::Compared(Ok((distance, size))));
                    difference.encode_all(&job.cancel, |encoded| {
                        job.send(Event::CompareEncoded(Side::Difference, encoded));
                    });
                }
                Err(why) => job.send(Event::Compared(Err(why))),
            }
        });
    }
}
