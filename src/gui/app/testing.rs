//! A window for tests of what is inside it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui_kittest::Harness;

use super::{App, AppOptions, FileDialogs};

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
