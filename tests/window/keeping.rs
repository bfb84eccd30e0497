//! Unsaved work that outlives the window, and the list of files opened last.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::closing::is_told_to_close;
use crate::driver::{DEADLINE, Files, Window, library_hash, load, set_samples};
use eframe::App as _;
use egui::{Key, Modifiers};
use raymini::control::CancelToken;
use raymini::gui::dialogs::Dialog;
use raymini::gui::inspector::Samples;
use raymini::gui::keeping::begin;
use raymini::gui::picture::{LONG, Picture};
use raymini::io::{BlockLog, LoggedBlocks, block_record, describe_render};
use raymini::render::{Layer, Region, StopRules};
use raymini::scene::RenderSettings;

/// A window that keeps its work in `data`.
pub fn open(path: &Path, data: &Path) -> Window {
    Window::start_keeping(vec![path.to_owned()], true, Some(data.to_owned()))
}

/// Edits, and ends as a process does that is killed: it says goodbye to nobody, and its locks are free.
pub fn edit_and_die(files: &Files, data: &Path) {
    let mut window = open(&files.path("room.toml"), data);
    window.click("Add light");
    window.until("the work is kept", raymini::gui::App::is_work_kept);
    window.click("Add light");
    window.until("the newest work is kept", raymini::gui::App::is_work_kept);
}

pub fn asks(window: &mut Window) {
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

/// What another program wrote after the work was lost is not written over without a question.
#[test]
fn a_file_that_was_written_since_the_work_was_lost_is_asked_about() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    let text = crate::driver::SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 7");
    let room = files.write("room.toml", &text);
    let mut window = open(&room, &data);
    asks(&mut window);
    window.click("Restore");
    window.until("it is restored", |app| app.document().is_modified());
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is asked", |app| {
        matches!(app.dialog(), Some(Dialog::Overwrite(_)))
    });
    assert_eq!(load(&room).render.samples_per_pixel, 7);
    window.click("Overwrite");
    window.until("it is saved", |app| !app.document().is_modified());
    assert_eq!(load(&room).lights.len(), 3);
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
    window.ask_to_close();
    window.click("Discard");
    window.harness.state_mut().on_exit();
    let sessions = std::fs::read_dir(data.join("sessions")).unwrap();
    assert_eq!(sessions.count(), 0);
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
pub fn render_until_kept(window: &mut Window, data: &Path) {
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
pub fn copy_folder(from: &Path, to: &Path) {
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

/// Live follows edits by renders that nobody asked for; one that somebody asks for meanwhile is kept as any other.
#[test]
fn a_render_that_is_asked_for_in_live_is_kept() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 100_000);
    let renders = |data: &Path| {
        let found = begin(data).expect("a folder of sessions");
        let renders = found.lost.iter().filter(|lost| lost.render().is_some());
        let count = renders.count();
        found.session.end();
        count
    };
    window.click("Live");
    window.until("the picture that follows is there", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    let followed = files.path("followed");
    copy_folder(&data, &followed);
    assert_eq!(renders(&followed), 0);
    window.click("Cancel");
    assert!(window.app().is_live());
    render_until_kept(&mut window, &data);
    let asked_for = files.path("asked for");
    copy_folder(&data, &asked_for);
    assert_eq!(renders(&asked_for), 1);
    window.click("Cancel");
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
    assert!(window.says("before the render of room was saved"));
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
    let other = text.replace("seed = 0", "seed = 9");
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
    assert!(window.says("A render was not saved, and goes on where it was."));
    window.click("Restore");
    window.until("it is finished", |app| {
        app.picture().is_some_and(|picture| !picture.is_running())
    });
    assert_eq!(window.hash(), library_hash(&rendered));
    assert_eq!(window.scene().lights.len(), 2);
    assert!(window.app().document().is_modified());
}

/// The folders of renders in the sessions of `data`.
pub fn renders(data: &Path) -> Vec<PathBuf> {
    let entries = |folder: &Path| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect::<Vec<_>>()
    };
    let sessions = entries(&data.join("sessions"));
    let folders = sessions.iter().flat_map(|session| entries(session));
    folders.filter(|folder| folder.is_dir()).collect()
}

/// Leaves in `killed` what a process leaves that is killed in a render of the scene at `room`, with some blocks of samples that seem to have
/// taken very long.
fn leave_long_render(room: &Path, data: &Path, killed: &Path) {
    let mut window = open(room, data);
    window.click("Render");
    let logged = |data: &Path| {
        let logs = renders(data).into_iter().map(|it| it.join("blocks-1"));
        let logged = logs.filter_map(|log| std::fs::metadata(log).ok());
        logged.map(|log| log.len()).sum::<u64>()
    };
    window.just_until("blocks are logged", |_| logged(data) > 1 << 16);
    window.click("Pause");
    copy_folder(data, killed);
    window.click("Cancel");
    wait_until_no_render_is_kept(&mut window, data);
    drop(window);

    let [folder] = &renders(killed)[..] else {
        panic!("one render is kept");
    };
    let scene = load(&folder.join("scene.toml"));
    let region = Region::full(scene.render.width, scene.render.height);
    let layers = Layer::all_of(&scene);
    // By which rules it ends may change on the way.
    let mut endless = scene.clone();
    let any = RenderSettings {
        samples_per_pixel: RenderSettings::MAX_SAMPLES,
        ..RenderSettings::default()
    };
    StopRules::of(&any).put_into(&mut endless.render);
    let description = describe_render(&endless, region, &layers, &CancelToken::new());
    let description = description.expect("nobody cancels");
    let path = folder.join("blocks-1");
    let known = LoggedBlocks::read(std::slice::from_ref(&path), &description);
    let mut blocks: Vec<_> = known.headers().iter().collect();
    blocks.truncate(3);
    let blocks: Vec<_> = blocks
        .into_iter()
        .map(|header| known.find(header.pass, header.tile).expect("it is whole"))
        .collect();
    assert!(!blocks.is_empty());
    let mut log = BlockLog::create(&path, &description).unwrap();
    for mut block in blocks {
        block.header.seconds = 2.0 * LONG.as_secs_f64();
        block.header.cpu_seconds = block.header.seconds;
        log.append(&block_record(&block)).unwrap();
    }
    let _ = std::fs::remove_file(folder.join("checkpoint"));
}

/// A picture that took long is there again when the program is killed after it is done, and nothing loses it without a question.
#[test]
fn a_long_render_is_kept_until_its_picture_is_saved() {
    let files = Files::new();
    let text = crate::driver::SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 300");
    let room = files.write("room.toml", &text);
    let [data, killed, again] = ["data", "killed", "again"].map(|name| files.path(name));
    leave_long_render(&room, &data, &killed);

    let finish = |data: &Path| {
        let mut window = open(&room, data);
        asks(&mut window);
        window.click("Go on");
        window.until("it is finished", |app| {
            app.picture().is_some_and(|picture| !picture.is_running())
        });
        assert!(window.app().picture().unwrap().elapsed() >= 2 * LONG);
        assert_eq!(window.hash(), library_hash(&load(&room)));
        window.until("it is on disk", |app| !app.is_keeping_render());
        window
    };
    let mut window = finish(&killed);
    assert_eq!(renders(&killed).len(), 1);
    copy_folder(&killed, &again);

    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Pictures)));
    assert!(!is_told_to_close(&window));
    window.click("Leave open");
    window.save_picture(&files.path("room.exr"));
    let deadline = Instant::now() + DEADLINE;
    while !renders(&killed).is_empty() {
        assert!(Instant::now() < deadline, "what is saved is still kept");
        window.harness.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    window.ask_to_close();
    assert!(window.app().dialog().is_none());
    drop(window);

    let mut window = finish(&again);
    // Opening another scene takes it from nobody.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.write("other.toml", crate::driver::SCENE));
    window.until("the other is open", |app| app.document().name() == "other");
    window.settle();
    assert_eq!(window.app().renders().entries().len(), 1);
    assert_eq!(renders(&again).len(), 1);
    // Another render takes its place on disk; the picture stays under Renders, and is asked about.
    window.render();
    assert_eq!(window.app().renders().entries().len(), 1);
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Pictures)));
}

/// An edit starts a render anew that has just begun, and not one that has run for long.
#[test]
fn an_edit_does_not_give_up_a_long_render() {
    let files = Files::new();
    let text = crate::driver::SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 100_000");
    let room = files.write("room.toml", &text);
    let [data, killed] = ["data", "killed"].map(|name| files.path(name));
    leave_long_render(&room, &data, &killed);
    let mut window = open(&room, &killed);
    asks(&mut window);
    window.click("Go on");
    window.until("it goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    window.operate("Shadows: Off");
    window.harness.run_steps(5);
    let number = |window: &Window| window.app().picture().map(|picture| picture.number);
    assert_eq!(number(&window), Some(1));
    assert!(window.says("settings changed: F5 restarts"));
    assert!(window.app().renders().entries().is_empty());

    // What it has reached is there when another is asked for, which the next edit starts anew.
    window.press(Modifiers::NONE, Key::F5);
    window.click("Render anew");
    let runs_as = |number| {
        move |app: &raymini::gui::App| {
            let picture = app.picture();
            picture.is_some_and(|p| p.is_running() && p.number == number && p.first_tile.is_some())
        }
    };
    window.until("another runs", runs_as(2));
    assert_eq!(window.app().renders().entries().len(), 1);
    window.operate("Shadows: Soft");
    window.until("it starts anew", |app| {
        app.picture().is_some_and(|picture| {
            let shadows = picture.scene.render.shadows;
            picture.is_running() && shadows == raymini::scene::Shadows::Soft
        })
    });
    assert_eq!(window.app().renders().entries().len(), 1);
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
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
