//! A path to type, with the folder's files below it to click. It works on every desktop and in every test.

use std::path::{MAIN_SEPARATOR, Path, PathBuf, is_separator};

use egui::{Key, RichText, Ui};

use super::files::FilePurpose;
use super::{buttons_ui, modal_ui};
use crate::gui::widgets::primary_button;

/// Entries of the folder shown at most.
const MOST_ENTRIES: usize = 300;

/// The dialog's state.
#[derive(Clone, Debug)]
pub struct PathField {
    /// What the path is for.
    pub purpose: FilePurpose,
    /// Why the user has to type, if there is a reason.
    pub note: Option<String>,
    text: String,
    listing: Option<Listing>,
    focused: bool,
}

/// What is on disk where the text points to. Read by a worker: a folder on a network may take its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listing {
    /// The text it was made for.
    pub text: String,
    /// Whether the text names a file that is there.
    pub is_file: bool,
    /// The folder above, as a path to put in the field.
    pub parent: Option<String>,
    /// Folders (with a separator at the end) and fitting files, as paths to put in the field.
    pub entries: Vec<String>,
}

/// How the dialog goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It stays.
    Open,
    /// It stays, and wants a [`Listing`] of this text.
    List(String),
    /// It was cancelled.
    Cancelled,
    /// This is the path.
    Chosen(PathBuf),
}

impl PathField {
    /// A field that starts with `suggestion`.
    #[must_use]
    pub fn new(purpose: FilePurpose, suggestion: &Path, note: Option<String>) -> Self {
        Self {
            purpose,
            note,
            text: suggestion.to_string_lossy().into_owned(),
            listing: None,
            focused: false,
        }
    }

    /// Shows what a worker found.
    pub fn set_listing(&mut self, listing: Listing) {
        self.listing = Some(listing);
    }

    /// Draws the dialog.
    pub fn show_ui(&mut self, ctx: &egui::Context) -> Outcome {
        let response = modal_ui(ctx, "path field", 540.0, |ui| {
            ui.heading(self.purpose.title());
            if let Some(note) = &self.note {
                ui.label(RichText::new(note).weak());
            }
            ui.add_space(6.0);
            self.contents_ui(ui)
        });
        let should_close = response.should_close();
        match response.inner {
            Outcome::Open | Outcome::List(_) if should_close => Outcome::Cancelled,
            outcome => outcome,
        }
    }

    fn contents_ui(&mut self, ui: &mut Ui) -> Outcome {
        let field = ui
            .add(
                egui::TextEdit::singleline(&mut self.text)
                    .hint_text("Path")
                    .desired_width(f32::INFINITY)
                    .margin(egui::Margin::symmetric(8, 6)),
            )
            .accessible_name("Path");
        if !self.focused {
            self.focused = true;
            field.request_focus();
        }
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        ui.add_space(4.0);
        if self.entries_ui(ui) {
            field.request_focus();
        }
        self.overwrite_ui(ui);
        let confirmed = self.buttons_ui(ui);
        match confirmed {
            Some(false) => Outcome::Cancelled,
            _ if (entered || confirmed == Some(true)) && !self.text.trim().is_empty() => {
                let wants_file = !self.purpose.is_folder() && !self.text.ends_with(is_separator);
                if wants_file && with_home(self.text.trim()).is_dir() {
                    self.text = format!("{}{MAIN_SEPARATOR}", self.text.trim());
                }
                if self.is_place_to_go() {
                    field.request_focus();
                    return Outcome::Open;
                }
                let path = self.purpose.with_extension(with_home(self.text.trim()));
                Outcome::Chosen(path)
            }
            _ if self.listing.as_ref().is_none_or(|l| l.text != self.text) => {
                Outcome::List(self.text.clone())
            }
            _ => Outcome::Open,
        }
    }

    /// Whether the text names a folder where a file is wanted.
    fn is_place_to_go(&self) -> bool {
        self.text.ends_with(is_separator) && !self.purpose.is_folder()
    }

    /// The folder's entries; returns whether one was clicked.
    fn entries_ui(&mut self, ui: &mut Ui) -> bool {
        let mut clicked = None;
        egui::Frame::new()
            .fill(ui.visuals().extreme_bg_color)
            .corner_radius(5.0)
            .inner_margin(6.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical()
                    .max_height(220.0)
                    .min_scrolled_height(220.0)
                    .auto_shrink(false)
                    .show(ui, |ui| {
                        let Some(listing) = &self.listing else { return };
                        if let Some(parent) = &listing.parent
                            && entry_ui(ui, "📁", "..")
                        {
                            clicked = Some(parent.clone());
                        }
                        for entry in &listing.entries {
                            let is_folder = entry.ends_with(is_separator);
                            let name = entry.trim_end_matches(is_separator);
                            let name = name.rsplit(is_separator).next().unwrap_or(name);
                            if entry_ui(ui, if is_folder { "📁" } else { "📄" }, name) {
                                clicked = Some(entry.clone());
                            }
                        }
                        if listing.entries.is_empty() {
                            let kinds = self.purpose.extensions().join(", .");
                            let text = if self.purpose.is_folder() {
                                "No folder here: add a name, and it is made".to_owned()
                            } else {
                                format!("No folder or .{kinds} file here")
                            };
                            ui.label(RichText::new(text).weak());
                        }
                    });
            });
        let was_clicked = clicked.is_some();
        if let Some(entry) = clicked {
            self.text = entry;
        }
        was_clicked
    }

    /// Says that a file is there, which it is asked about.
    fn overwrite_ui(&self, ui: &mut Ui) {
        let replaces = self.purpose.is_save() && self.listing.as_ref().is_some_and(|l| l.is_file);
        let text = if replaces {
            "A file of this name is there."
        } else {
            ""
        };
        ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
    }

    /// The buttons; `Some(true)` to go on, `Some(false)` to cancel.
    fn buttons_ui(&self, ui: &mut Ui) -> Option<bool> {
        buttons_ui(ui, |ui| {
            let ready = !self.text.trim().is_empty() && !self.is_place_to_go();
            let verb = primary_button(self.purpose.verb());
            if ui.add_enabled(ready, verb).clicked() {
                return Some(true);
            }
            ui.button("Cancel").clicked().then_some(false)
        })
    }
}

fn entry_ui(ui: &mut Ui, icon: &str, name: &str) -> bool {
    let button = egui::Button::selectable(false, format!("{icon}  {name}"))
        .min_size(egui::vec2(ui.available_width(), 22.0))
        .truncate();
    ui.add(button).clicked()
}

/// Looks at the disk where `text` points to.
#[must_use]
pub fn list(text: String, purpose: FilePurpose) -> Listing {
    let path = with_home(&text);
    let folder = if text.is_empty() || text.ends_with(is_separator) {
        path.as_path()
    } else {
        path.parent().unwrap_or(Path::new(""))
    };
    let on_disk = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let extensions = purpose.extensions();
    let mut folders = Vec::new();
    let mut files = Vec::new();
    for entry in std::fs::read_dir(on_disk).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') {
            continue;
        }
        let shown = folder.join(&name).to_string_lossy().into_owned();
        let extension = Path::new(&name).extension().unwrap_or_default();
        let extension = extension.to_string_lossy().to_lowercase();
        if entry.path().is_dir() {
            folders.push(format!("{shown}{MAIN_SEPARATOR}"));
        } else if extensions.contains(&extension.as_str()) {
            files.push(shown);
        }
    }
    folders.sort();
    files.sort();
    let mut entries = folders;
    entries.append(&mut files);
    entries.truncate(MOST_ENTRIES);
    let parent = folder
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    Listing {
        is_file: purpose.with_extension(path.clone()).is_file(),
        parent: parent.map(as_folder),
        text,
        entries,
    }
}

/// A folder as the field shows it: with a separator at the end.
fn as_folder(path: &Path) -> String {
    let text = path.to_string_lossy();
    format!("{}{MAIN_SEPARATOR}", text.trim_end_matches(is_separator))
}

/// The path, with `~/` as the user's home. What is typed after `//` begins anew: the field is filled already.
pub(in crate::gui) fn with_home(text: &str) -> PathBuf {
    // Where that is no path of a network drive.
    let anew = text.rfind("//").filter(|&place| place > 0);
    let text = anew.map_or(text, |place| &text[place + 1..]);
    let below_home = text
        .strip_prefix('~')
        .and_then(|rest| rest.strip_prefix(is_separator));
    match (below_home, std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => PathBuf::from(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listing_shows_folders_and_fitting_files() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.off", "a.toml", "notes.txt", ".hidden.off"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        let text = as_folder(folder.path());
        let listing = list(text.clone(), FilePurpose::Open);
        let names: Vec<_> = listing
            .entries
            .iter()
            .map(|entry| entry.strip_prefix(&text).unwrap())
            .collect();
        let meshes = format!("meshes{MAIN_SEPARATOR}");
        assert_eq!(names, [meshes.as_str(), "a.toml", "b.off"]);
        assert!(!listing.is_file);
        assert!(list(format!("{text}b.off"), FilePurpose::Open).is_file);
        assert!(
            list("/no/such/folder/x".into(), FilePurpose::Open)
                .entries
                .is_empty()
        );
    }
}
