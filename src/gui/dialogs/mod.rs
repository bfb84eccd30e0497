//! Questions and sheets over the window. One shows at a time.

pub mod files;
pub mod path_field;
pub mod question;
mod shortcuts;

use std::path::PathBuf;

use files::FilePurpose;
use path_field::PathField;

pub use shortcuts::shortcuts_ui;

/// What shows over the window.
#[derive(Clone, Debug)]
pub enum Dialog {
    /// A path to type, where the desktop offers no file dialog or the user prefers typing.
    Path(PathField),
    /// The desktop's file dialog is open.
    Waiting(FilePurpose),
    /// Unsaved work is about to be lost.
    Unsaved(Intent),
    /// The sheet of shortcuts.
    Shortcuts,
}

/// What the user was about to do when unsaved work stood in the way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Intent {
    /// Open these files in place of the scene.
    Open(Vec<PathBuf>),
    /// Close the window.
    Close,
}
