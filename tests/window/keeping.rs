//! Unsaved work that outlives the window, and the list of files opened last.

use std::path::Path;

use crate::driver::{Files, Window, load};
use eframe::App as _;
use egui::{Key, Modifiers};
use raymini::gui::dialogs::Dialog;

/// A window that keeps its work in `data`.
fn open(path: &Path, data: &Path) -> Window {
    Window::start_keeping(vec![path.to_owned()], true, Some(data.to_owned()))
}

/// Edits, and ends as a process does that is killed: it says goodbye to nobody, and its locks are free.
fn edit_and_die(files: &Files, data: &Path) {
    let mut window = open(&files.path("room.toml"), data);
    window.click("Add light");
    window.until("the work is kept", raymini::gui::App::is_work_kept);
    window.click("Add light");
    window.until("the newest work is kept", raymini::gui::App::is_work_kept);
}

fn asks(window: &mut Window) {
    window.until("lost work is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Recovery(_)))
    });
}

#[test]
fn lost_work_is_restored_and_still_is_not_saved() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);

    // The demo was asked for this time; the work of before is offered all the same.
    let mut window = Window::start_keeping(Vec::new(), true, Some(data.clone()));
    asks(&mut window);
    assert!(window.says("changes to room"));
    window.click("Restore");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    assert_eq!(window.scene().lights.len(), 3);
    assert!(window.app().document().is_modified());
    let room = files.path("room.toml");
    assert_eq!(window.app().document().path(), Some(room.as_path()));
    assert_eq!(load(&room).lights.len(), 1, "the file is as it was saved");

    // It is kept by this window from now on, and not lost by another end.
    window.until("it is kept here", raymini::gui::App::is_work_kept);
    drop(window);
    let mut window = open(&files.path("pyramid.off"), &data);
    asks(&mut window);
    window.click("Restore");
    window.until("it is restored again", |app| {
        app.document().name() == "room"
    });
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |app| !app.document().is_modified());
    assert_eq!(load(&room).lights.len(), 3);
    window.until("nothing is kept", raymini::gui::App::is_work_kept);
    drop(window);
    let window = open(&room, &data);
    assert!(window.app().dialog().is_none(), "saved work is not lost");
}

#[test]
fn lost_work_can_wait_and_be_discarded() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    let room = files.path("room.toml");
    let mut window = open(&room, &data);
    asks(&mut window);

    // Another window meanwhile is not asked.
    let mut beside = open(&room, &data);
    beside.harness.run_steps(20);
    assert!(beside.app().dialog().is_none());
    beside.harness.state_mut().on_exit();
    window.click("Later");
    assert!(window.app().dialog().is_none());
    assert_eq!(window.scene().lights.len(), 1);
    window.harness.state_mut().on_exit();
    drop(window);

    let mut window = open(&room, &data);
    asks(&mut window);
    window.click("Discard");
    window.harness.run_steps(5);
    window.harness.state_mut().on_exit();
    drop(window);
    let mut window = open(&room, &data);
    window.harness.run_steps(20);
    assert!(window.app().dialog().is_none());
}

/// Who closes the window and gives up the changes is not asked about them again.
#[test]
fn closing_the_window_leaves_nothing_behind() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    window.click("Add light");
    window.until("the work is kept", raymini::gui::App::is_work_kept);
    window.harness.state_mut().on_exit();
    let sessions = std::fs::read_dir(data.join("sessions")).unwrap();
    assert_eq!(sessions.count(), 0);
}

/// What cannot be restored stays on disk, and the message says where.
#[test]
fn work_whose_mesh_is_gone_stays() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    std::fs::remove_file(files.path("pyramid.off")).unwrap();
    let mut window = Window::start_keeping(Vec::new(), true, Some(data.clone()));
    asks(&mut window);
    window.click("Restore");
    window.until("a banner says why not", |app| {
        !app.messages().banners().is_empty()
    });
    let banner = &window.app().messages().banners()[0];
    assert_eq!(banner.title, "Cannot restore the unsaved work");
    assert!(banner.text.contains("sessions"), "{}", banner.text);
    window.harness.state_mut().on_exit();
    drop(window);
    let mut window = Window::start_keeping(Vec::new(), true, Some(data));
    asks(&mut window);
}

#[test]
fn a_window_looks_like_the_last_one() {
    let files = Files::new();
    let data = files.path("data");
    let room = files.path("room.toml");
    let mut window = open(&room, &data);
    assert!(!window.has("Render, and see the error fall"));
    window.press(Modifiers::NONE, Key::F8);
    window.press(Modifiers::NONE, Key::O);
    let panel = |window: &Window| 1280.0 - window.rect("Select Camera").left();
    let edge = egui::Pos2::new(1280.0 - raymini::gui::theme::PANEL_WIDTH, 400.0);
    let before = panel(&window);
    window.drag(
        egui::PointerButton::Primary,
        edge,
        edge - egui::Vec2::new(90.0, 0.0),
    );
    let wide = panel(&window);
    assert!((wide - before - 90.0).abs() < 12.0, "{before}, then {wide}");
    window.click("View");
    window.click("Light");
    window.harness.state_mut().on_exit();
    drop(window);
    // The harness has colours of its own for the next.
    let theme = raymini::gui::keeping::load_layout(&data).theme;
    assert_eq!(theme, raymini::gui::keeping::Theme::Light);

    let mut window = open(&room, &data);
    window.harness.run_steps(3);
    assert!(window.has("Render, and see the error fall"));
    assert!((panel(&window) - wide).abs() < 2.0, "{wide}");
    window.press(Modifiers::NONE, Key::O);
    window.press(Modifiers::NONE, Key::F9);
    assert!(!window.has("Select Camera"));
    window.harness.state_mut().on_exit();
    drop(window);
    let window = open(&room, &data);
    assert!(!window.has("Select Camera"), "the panel stays folded");
}

#[test]
fn a_folder_that_cannot_be_written_gets_a_banner() {
    let files = Files::new();
    let no_folder = files.write("data", "a file");
    let window = open(&files.path("room.toml"), &no_folder);
    let mut window = window;
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    let banner = &window.app().messages().banners()[0];
    assert_eq!(banner.title, "Unsaved work is not kept");
}

#[test]
fn files_opened_last_are_in_the_menu_at_the_next_start() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    window.settle();
    window.harness.state_mut().on_exit();
    drop(window);

    let mut window = Window::start_keeping(Vec::new(), true, Some(data.clone()));
    window.harness.run_steps(10);
    window.click("File");
    window.click("Open recent");
    assert!(window.has("Open pyramid.off"));
    window.click("Open room.toml");
    window.until("the scene is open", |app| app.document().name() == "room");
    window.settle();
    window.click("File");
    window.click("Open recent");
    window.click("Clear the list");
    window.harness.run_steps(10);
    window.harness.state_mut().on_exit();
    drop(window);
    assert!(raymini::gui::keeping::load_recent(&data).is_empty());
}
