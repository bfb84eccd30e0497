//! Unsaved work that outlives the window, and the list of files opened last.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::driver::{DEADLINE, Files, Window, library_hash, load, set_samples};
use eframe::App as _;
use egui::{Key, Modifiers};
use raymini::gui::dialogs::Dialog;
use raymini::gui::inspector::Samples;
use raymini::gui::picture::Picture;

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

/// The checkpoints of renders in the sessions of `data`.
fn checkpoints(data: &Path) -> Vec<PathBuf> {
    let entries = |folder: &Path| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect::<Vec<_>>()
    };
    let sessions = entries(&data.join("sessions"));
    let renders = sessions.iter().flat_map(|session| entries(session));
    let files = renders.map(|render| render.join("checkpoint"));
    files.filter(|file| file.is_file()).collect()
}

/// Starts a render, and pauses it when it is on disk.
fn render_until_kept(window: &mut Window, data: &Path) {
    window.click("Render");
    window.just_until("it runs", |app| {
        app.picture().is_some_and(Picture::is_running)
    });
    window.click("Pause");
    // So that one is due after the next tile, however quick the machine is.
    std::thread::sleep(Duration::from_millis(2500));
    window.click("Resume");
    window.just_until("it is kept", |_| !checkpoints(data).is_empty());
    window.click("Pause");
}

/// What a process leaves that is killed now: `to` is beside `from`.
fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let copy = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &copy);
        } else {
            std::fs::copy(entry.path(), copy).unwrap();
        }
    }
}

fn wait_until_no_render_is_kept(window: &mut Window, data: &Path) {
    let deadline = Instant::now() + DEADLINE;
    while !checkpoints(data).is_empty() {
        assert!(Instant::now() < deadline, "a checkpoint stays");
        window.harness.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_render_that_was_killed_goes_on_to_the_same_bits() {
    let files = Files::new();
    let text = crate::driver::SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 300");
    let room = files.write("room.toml", &text);
    let data = files.path("data");
    let mut window = open(&room, &data);
    render_until_kept(&mut window, &data);
    let [killed, damaged, foreign] = ["killed", "damaged", "foreign"].map(|name| files.path(name));
    for copy in [&killed, &damaged, &foreign] {
        copy_folder(&data, copy);
    }
    window.click("Cancel");
    wait_until_no_render_is_kept(&mut window, &data);
    drop(window);

    let mut window = open(&room, &killed);
    asks(&mut window);
    assert!(window.says("before the render of room was done"));
    window.click("Go on");
    window.until("the render goes on", |app| {
        let share = app.picture().and_then(Picture::goes_on_from);
        share.is_some_and(|share| share > 0.0 && share < 1.0)
    });
    window.until("it is finished", |app| {
        app.picture().is_some_and(|picture| !picture.is_running())
    });
    assert_eq!(window.hash(), library_hash(&load(&room)));
    assert!(!window.app().document().is_modified());
    wait_until_no_render_is_kept(&mut window, &killed);
    window.harness.state_mut().on_exit();
    drop(window);
    let window = open(&room, &killed);
    assert!(window.app().dialog().is_none(), "nothing is left");
    drop(window);

    // What cannot be gone on with is told, and nothing runs.
    let [file] = &checkpoints(&damaged)[..] else {
        panic!("one render is kept");
    };
    let mut bytes = std::fs::read(file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(file, bytes).unwrap();
    let [file] = &checkpoints(&foreign)[..] else {
        panic!("one render is kept");
    };
    let scene = file.with_file_name("scene.toml");
    let text = std::fs::read_to_string(&scene).unwrap();
    let other = text.replace("samples_per_pixel = 300", "samples_per_pixel = 301");
    assert_ne!(text, other);
    std::fs::write(&scene, other).unwrap();
    for (data, reason) in [(&damaged, "damaged"), (&foreign, "another render")] {
        let mut window = open(&room, data);
        asks(&mut window);
        window.click("Go on");
        window.until("it is told", |app| !app.messages().banners().is_empty());
        let banner = &window.app().messages().banners()[0];
        assert_eq!(banner.title, "The interrupted render cannot go on");
        assert!(banner.text.contains(reason), "{}", banner.text);
        assert!(!window.app().picture().is_some_and(Picture::is_running));
        assert_eq!(window.app().document().name(), "room");
        wait_until_no_render_is_kept(&mut window, data);
    }
}

/// The share of the samples of a render that are taken.
fn share_done(window: &Window) -> f64 {
    let picture = window.app().picture().expect("one is there");
    let Samples::OnAverage(samples) = picture.samples() else {
        panic!("it is not finished");
    };
    samples / f64::from(picture.scene.render.samples_per_pixel)
}

/// Between checkpoints too, but for the tiles in hand.
#[test]
fn nearly_all_samples_of_a_killed_render_are_there_again() {
    let files = Files::new();
    let text = crate::driver::SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 10_000");
    let room = files.write("room.toml", &text);
    let data = files.path("data");
    let mut window = open(&room, &data);
    render_until_kept(&mut window, &data);
    let kept = share_done(&window);
    window.click("Resume");
    window.just_until("it is further", |app| {
        let picture = app.picture().expect("it runs");
        let Samples::OnAverage(samples) = picture.samples() else {
            return true;
        };
        samples / 10_000.0 > kept + 0.02
    });
    window.click("Pause");
    let done = share_done(&window);
    let killed = files.path("killed");
    copy_folder(&data, &killed);
    drop(window);

    let mut window = open(&room, &killed);
    asks(&mut window);
    window.click("Go on");
    window.until("the render goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    let share = window.app().picture().and_then(Picture::goes_on_from);
    let lost = done - share.expect("was waited for");
    assert!(lost < 0.01, "{lost} of {done} are lost");
}

/// Unsaved work comes back as it was edited last, and the render goes on with the scene it was started with.
#[test]
fn a_render_goes_on_beside_what_was_edited_since() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 300);
    let rendered = window.scene().clone();
    render_until_kept(&mut window, &data);
    window.click("Add light");
    window.until("the work is kept", raymini::gui::App::is_work_kept);
    let killed = files.path("killed");
    copy_folder(&data, &killed);
    drop(window);

    let mut window = open(&files.path("pyramid.off"), &killed);
    asks(&mut window);
    assert!(window.says("A render was interrupted, and goes on."));
    window.click("Restore");
    window.until("it is finished", |app| {
        app.picture().is_some_and(|picture| !picture.is_running())
    });
    assert_eq!(window.hash(), library_hash(&rendered));
    assert_eq!(window.scene().lights.len(), 2);
    assert!(window.app().document().is_modified());
}

/// A picture that follows every change is soon another.
#[test]
fn live_pictures_are_not_kept() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 100_000);
    window.click("Live");
    window.just_until("it runs", |app| {
        app.picture().is_some_and(Picture::is_running)
    });
    let started = Instant::now();
    while started.elapsed() < Duration::from_millis(2500) {
        window.harness.step();
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(checkpoints(&data), Vec::<PathBuf>::new());
}
