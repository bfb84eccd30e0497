//! The question what becomes of a scene some of whose meshes and images are not there.

use std::path::PathBuf;

use egui::{Align, Layout, RichText, ScrollArea, Ui};

use super::question::is_confirmed;
use super::{buttons_ui, modal_ui};
use crate::gui::keeping::Lost;
use crate::gui::widgets::{counted, primary_button};
use crate::io::{MissingFile, MissingKind, Moves};

/// Files that are listed; the others are found with one of them, or stay missing.
const MOST: usize = 50;

/// Most height of the list, in points.
const LIST_HEIGHT: f32 = 260.0;

/// What lacks files.
#[derive(Clone, Debug)]
pub enum Lacking {
    /// The scene in a file that is to be opened.
    File(PathBuf),
    /// Work that a window before did not save.
    Work(Lost),
}

/// A scene, and the files that it lacks.
#[derive(Clone, Debug)]
pub struct Missing {
    /// The scene.
    pub of: Lacking,
    /// At least one.
    pub files: Vec<MissingFile>,
    /// Where some of them were found.
    pub found: Moves,
    /// The one that is being located.
    pub located: Option<PathBuf>,
    /// Why what was chosen last is not it.
    pub problem: Option<String>,
}

/// What the user decided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Open the scene with what was found, and without the rest.
    Open,
    /// Say where this file is.
    Locate(PathBuf),
    /// Leave everything as it is.
    Cancel,
}

impl Missing {
    /// Of what lacks `files` none is found.
    #[must_use]
    pub fn new(of: Lacking, files: Vec<MissingFile>) -> Self {
        Self {
            of,
            files,
            found: Moves::new(),
            located: None,
            problem: None,
        }
    }

    /// The same question once more: what was found is not what was missing, for the reason `problem`. Where that names a file, the others stay
    /// found.
    #[must_use]
    pub fn again(mut self, problem: String) -> Self {
        let is_named = |path: &PathBuf| problem.contains(&*path.to_string_lossy());
        if self.found.values().any(is_named) {
            self.found.retain(|_, to| !is_named(to));
        } else {
            self.found.clear();
        }
        Self {
            problem: Some(problem),
            located: None,
            ..self
        }
    }

    /// Whether nobody has said or been told anything about the files.
    #[must_use]
    pub fn is_untouched(&self) -> bool {
        self.found.is_empty() && self.located.is_none() && self.problem.is_none()
    }

    /// Whether every file is found.
    #[must_use]
    pub fn lacks_nothing(&self) -> bool {
        self.count_lacking() == 0
    }

    fn count_lacking(&self) -> usize {
        let is_found = |file: &&MissingFile| self.found.contains_key(&file.path);
        self.files.len() - self.files.iter().filter(is_found).count()
    }

    /// Takes in where files are; who said so of one is right about it.
    pub fn take_found(&mut self, found: Moves) {
        for (from, to) in found {
            if self.located.as_ref() == Some(&from) {
                self.found.insert(from, to);
            } else {
                self.found.entry(from).or_insert(to);
            }
        }
        (self.located, self.problem) = (None, None);
    }

    /// What lacks the files, in words.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.of {
            Lacking::File(path) => {
                let name = path.file_name().unwrap_or(path.as_os_str());
                name.to_string_lossy().into_owned()
            }
            Lacking::Work(lost) => format!("The unsaved work on {}", lost.about.name),
        }
    }

    /// What is taken from the missing file at `path`.
    #[must_use]
    pub fn kind_of(&self, path: &PathBuf) -> MissingKind {
        let file = self.files.iter().find(|file| file.path == *path);
        file.map_or(MissingKind::Mesh, |file| file.kind)
    }

    /// Asks; `None` while nothing is decided.
    #[must_use]
    pub fn show_ui(&self, ctx: &egui::Context) -> Option<Choice> {
        let response = modal_ui(ctx, "missing", 600.0, |ui| self.contents_ui(ui));
        match response.inner {
            None if response.should_close() => Some(Choice::Cancel),
            None if is_confirmed(ctx) => Some(Choice::Open),
            choice => choice,
        }
    }

    fn contents_ui(&self, ui: &mut Ui) -> Option<Choice> {
        let (lacking, name) = (self.count_lacking(), self.name());
        ui.heading(match lacking {
            0 => format!("{name} lacks nothing any more"),
            lacking => format!("{name} lacks {}", counted(lacking, "file", "files")),
        });
        ui.add_space(4.0);
        let located = self.files_ui(ui);
        if let Some(problem) = &self.problem {
            ui.label(RichText::new(problem).color(ui.visuals().warn_fg_color));
        }
        ui.add_space(4.0);
        let text = if lacking == 0 {
            "What was found takes the place of what is missing. The file of the scene stays as it is until you save."
        } else {
            "The scene can be opened without. What lacks its mesh stays in the scene and shows nothing, materials show their plain colours and a \
             background is black. All of it is saved as it is, and shows as soon as the file is there."
        };
        ui.label(RichText::new(text).weak());
        let decided = buttons_ui(ui, |ui| {
            let (open, tooltip) = if lacking == 0 {
                ("Open", "Open the scene with what was found")
            } else {
                (
                    "Open without",
                    "Open the scene, with nothing in place of what is missing",
                )
            };
            let opens = ui.add(primary_button(open)).on_hover_text(tooltip);
            let cancels = ui.button("Cancel");
            let cancels = cancels.on_hover_text("Leave everything as it is");
            let opens = opens.clicked().then_some(Choice::Open);
            opens.or(cancels.clicked().then_some(Choice::Cancel))
        });
        located.map(Choice::Locate).or(decided)
    }

    /// The files, each with a button to say where it is; returns that whose button was clicked.
    fn files_ui(&self, ui: &mut Ui) -> Option<PathBuf> {
        let mut located = None;
        let list = ScrollArea::vertical()
            .max_height(LIST_HEIGHT)
            .auto_shrink([false, true]);
        list.show(ui, |ui| {
            for file in self.files.iter().take(MOST) {
                let layout = Layout::right_to_left(Align::Min);
                ui.with_layout(layout, |ui| {
                    let name = file.path.file_name().unwrap_or(file.path.as_os_str());
                    let button = ui.button("Locate…").on_hover_text(
                        "Say where this file is now; what moved with it is found, too",
                    );
                    let name = format!("Locate {}", name.to_string_lossy());
                    if button.accessible_name(name).clicked() {
                        located = Some(file.path.clone());
                    }
                    ui.with_layout(Layout::top_down(Align::Min), |ui| {
                        ui.label(self.line_about(file));
                    });
                });
            }
        });
        if let Some(more) = self.files.len().checked_sub(MOST).filter(|&more| more > 0) {
            ui.label(format!("and {more} more"));
        }
        located
    }

    fn line_about(&self, file: &MissingFile) -> String {
        let users = file.users();
        match self.found.get(&file.path) {
            Some(found) => format!("{users}: found at {}", found.display()),
            None => format!("{users}: there is no file {}", file.path.display()),
        }
    }
}
