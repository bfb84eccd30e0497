//! A window for tests of what is inside it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui_kittest::Harness;

use super::{App, AppOptions, FileDialogs};
use crate::gui::picture::Picture;
use crate::gui::picture_buffer::PictureBuffer;
use crate::render::RenderProgress;

/// A window on the demo, prepared, that draws without a GPU and keeps its work in `data_folder`.
pub(super) fn window(data_folder: Option<PathBuf>) -> Harness<'static, App> {
    let options = AppOptions {
        file_dialogs: FileDialogs::PathField,
        data_folder,
        ..AppOptions::default()
    };
    let mut window = Harness::builder()
        .with_size([1280.0, 800.0])
        .build_eframe(|creation| App::new(creation, options));
    until(&mut window, |app| !app.is_settling());
    window
}

/// Draws frames until `holds`.
pub(super) fn until(window: &mut Harness<'static, App>, holds: impl Fn(&App) -> bool) {
    let deadline = Instant::now() + Duration::from_mins(1);
    while !holds(window.state()) {
        assert!(Instant::now() < deadline, "waited in vain");
        window.step();
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The first render of the scene that `app` edits, which begins now, and which nobody renders.
pub(super) fn picture(app: &App) -> Picture {
    let scene = app.document.scene.clone();
    let buffer = PictureBuffer::new(app.wanted_part(), Vec::new(), scene.display);
    Picture::new(
        1,
        ["demo", "Demo"].map(str::to_owned),
        scene,
        Arc::new(buffer.expect("it fits")),
        RenderProgress::default(),
        Instant::now(),
    )
}
