//! Questions and sheets over the window. One shows at a time.

mod desktop;
pub mod files;
pub mod import;
pub mod missing;
pub mod overwrite;
pub mod path_field;
pub mod question;
pub mod recovery;
mod shortcuts;

use std::path::PathBuf;

use files::FilePurpose;
use import::Import;
use missing::Missing;
use overwrite::Overwrite;
use path_field::PathField;

use super::keeping::Lost;
use super::opened_picture::OpenedPicture;
use super::recovering::Recovered;
use crate::io::LoadedScene;
use crate::scene::Scene;

pub use shortcuts::shortcuts_ui;

/// What shows over the window.
#[derive(Debug)]
pub enum Dialog {
    /// A path to type, where the desktop offers no file dialog or the user prefers typing.
    Path(PathField),
    /// The desktop's file dialog is open.
    Waiting(FilePurpose),
    /// A file is about to be written over.
    Overwrite(Overwrite),
    /// Unsaved work is about to be lost.
    Unsaved(Intent),
    /// Something that runs is about to be given up with the window.
    Running,
    /// Pictures that took long are about to be lost with the window.
    Pictures,
    /// The picture of the render with this number, which took long, is about to be lost.
    Forget(usize),
    /// Another render is about to end the one with this number, which has taken long.
    Anew(usize),
    /// A scene lacks files.
    Missing(Missing),
    /// Meshes were read, and it is to be said what becomes of them.
    Import(Box<Import>),
    /// Work that a window before did not save.
    Recovery(Lost),
    /// The sheet of shortcuts.
    Shortcuts,
}

/// Shows `contents` in a box of `width` points over the dimmed window. Escape and a click outside ask it to close.
pub(super) fn modal_ui<R>(
    ctx: &egui::Context,
    id: &str,
    width: f32,
    contents: impl FnOnce(&mut egui::Ui) -> R,
) -> egui::ModalResponse<R> {
    let style = ctx.global_style();
    let frame = egui::Frame::popup(&style)
        .inner_margin(egui::Margin::symmetric(20, 18))
        .corner_radius(style.visuals.window_corner_radius);
    egui::Modal::new(egui::Id::unique(id))
        .frame(frame)
        .show(ctx, |ui| {
            ui.set_width(width.min(ctx.content_rect().width() - 60.0));
            contents(ui)
        })
}

/// The buttons at the lower right of a dialog, the first at the right.
pub(in crate::gui) fn buttons_ui<R>(
    ui: &mut egui::Ui,
    buttons: impl FnOnce(&mut egui::Ui) -> R,
) -> R {
    const HEIGHT: f32 = 28.0;
    ui.add_space(14.0);
    // Its height is its own: where there is more room, it takes none of it.
    let size = egui::vec2(ui.available_width(), HEIGHT);
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.spacing_mut().interact_size = egui::vec2(84.0, HEIGHT);
        ui.spacing_mut().button_padding.x = 12.0;
        buttons(ui)
    })
    .inner
}

/// A scene that was read.
#[derive(Debug)]
pub struct Opened {
    /// The files it came from; none for the demo.
    pub paths: Vec<PathBuf>,
    /// The scene.
    pub loaded: LoadedScene,
    /// The picture of it in the file, where that is one of a render.
    pub picture: Option<OpenedPicture>,
    /// The scene with files that were found elsewhere, in whose place something stands in `loaded`; `None` where there are none.
    pub moved: Option<Scene>,
}

/// What the user was about to do when unsaved work stood in the way.
#[derive(Debug)]
pub enum Intent {
    /// Put this in place of the scene.
    Open(Box<Opened>),
    /// Open these meshes, which were read, in place of the scene.
    Import(Box<Import>),
    /// Bring back lost work, which was read, in place of the scene.
    Restore(Lost, Box<Recovered>),
    /// Close the window.
    Close,
}
