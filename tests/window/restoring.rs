//! How windows end, and what the next one brings back beside what is edited in it.

use std::path::{Path, PathBuf};

use crate::driver::{Files, SCENE, Window, set_samples};
use crate::keeping::{asks, copy_folder, edit_and_die, open, render_until_kept};
use eframe::App as _;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::jobs::Lane;
use raymini::gui::keeping::begin;
use raymini::gui::picture::Picture;

/// Who closes the window and gives up a render is not asked about it again.
#[test]
fn closing_the_window_in_a_render_leaves_nothing_behind() {
    let files = Files::new();
    let text = SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 100_000");
    let data = files.path("data");
    let mut window = open(&files.write("room.toml", &text), &data);
    render_until_kept(&mut window, &data);
    window.ask_to_close();
    window.click("Give up and close");
    window.harness.state_mut().on_exit();
    let sessions = std::fs::read_dir(data.join("sessions")).unwrap();
    assert_eq!(sessions.count(), 0);
}

/// A desktop whose session ends may end the program without a question: all is there again, whatever came last.
#[test]
fn an_end_that_nobody_was_asked_about_loses_nothing() {
    let files = Files::new();
    let data = files.path("data");
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 100_000);
    render_until_kept(&mut window, &data);
    window.click("Add light");
    window.harness.state_mut().on_exit();
    drop(window);
    // Threads of this process hold locks for a moment.
    let left = files.path("left");
    copy_folder(&data, &left);

    let mut window = open(&files.path("pyramid.off"), &left);
    asks(&mut window);
    assert!(window.says("A render was not saved, and goes on where it was."));
    window.click("Restore");
    window.until("the render goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    assert_eq!(window.scene().lights.len(), 2);
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
}

/// The scene of the work that is kept in `data`.
pub fn kept_scene(data: &Path) -> PathBuf {
    let sessions = std::fs::read_dir(data.join("sessions")).unwrap();
    let scenes = sessions.map(|session| session.unwrap().path().join("scene.toml"));
    let mut scenes = scenes.filter(|scene| scene.is_file());
    scenes.next().expect("work is kept")
}

/// What cannot be restored stays on disk, and the message says where.
#[test]
fn work_that_cannot_be_read_stays() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    std::fs::write(kept_scene(&data), "no scene").unwrap();
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

/// Restored work stays where it was found, and its render goes on in the folder of the window. Killed once more, both are asked about together.
#[test]
fn edits_and_their_render_are_restored_together_after_every_kill() {
    let files = Files::new();
    let [data, killed, again] = ["data", "killed", "again"].map(|name| files.path(name));
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 100_000);
    render_until_kept(&mut window, &data);
    for (from, to, lights) in [(&data, &killed, 2), (&killed, &again, 3)] {
        window.click("Add light");
        window.until("the edit is kept", App::is_work_kept);
        copy_folder(from, to);
        window.click("Cancel");
        window.until("threads have stopped", |app| app.render_threads() == 0);
        drop(window);

        window = open(&files.path("pyramid.off"), to);
        asks(&mut window);
        assert!(window.says("changes to room"));
        assert!(window.says("A render was not saved, and goes on where it was."));
        window.click("Restore");
        window.until("the render goes on", |app| {
            app.picture().and_then(Picture::goes_on_from).is_some()
        });
        assert_eq!(window.scene().lights.len(), lights);
        assert!(window.app().dialog().is_none());
    }
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
}

fn sessions(data: &Path) -> Vec<PathBuf> {
    let sessions = std::fs::read_dir(data.join("sessions")).unwrap();
    sessions.map(|session| session.unwrap().path()).collect()
}

/// What is in the way of a render is no reason to lose it: neither at once, nor when the work beside it is saved.
#[test]
fn a_render_that_cannot_be_taken_over_waits_also_where_the_work_beside_it_is_saved() {
    let files = Files::new();
    let [data, killed] = ["data", "killed"].map(|name| files.path(name));
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 100_000);
    render_until_kept(&mut window, &data);
    window.click("Add light");
    window.until("the edit is kept", App::is_work_kept);
    copy_folder(&data, &killed);
    window.click("Cancel");
    drop(window);

    let found = sessions(&killed);
    let mut window = open(&files.path("pyramid.off"), &killed);
    asks(&mut window);
    let mut own = sessions(&killed).into_iter();
    let own = own.find(|session| !found.contains(session));
    // Where its first render goes there is something that cannot be replaced.
    let in_the_way = own.expect("it has one").join("render-0/in the way");
    std::fs::create_dir_all(in_the_way).unwrap();
    window.click("Restore");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    assert!(window.says("The interrupted render waits"));
    assert!(window.app().picture().is_none());
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |app| !app.document().is_modified());
    window.until("nothing is kept", App::is_work_kept);
    drop(window);

    let mut window = open(&files.path("room.toml"), &killed);
    asks(&mut window);
    assert!(window.says("before the render of room was saved"));
    window.click("Go on");
    window.until("the render goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
}

/// Of several things that were lost one is restored, and the others are told of.
#[test]
fn what_else_was_lost_is_told_when_one_thing_is_restored() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    let other = files.write("other.toml", SCENE);
    let mut window = open(&other, &data);
    asks(&mut window);
    window.click("Later");
    window.click("Add light");
    window.until("the edit is kept", App::is_work_kept);
    drop(window);

    let mut window = open(&files.path("pyramid.off"), &data);
    asks(&mut window);
    assert!(window.says("changes to other"), "the newest");
    window.click("Restore");
    window.until("it is restored", |app| app.document().name() == "other");
    assert!(window.says("What was not saved of room is offered again at the next start."));
}

/// Opens a window on a mesh, has what is lost in `data` restored, and edits before it is read: by then it is asked about that.
fn edit_while_lost_work_is_read(files: &Files, data: &Path) -> Window {
    let mut window = open(&files.path("pyramid.off"), data);
    asks(&mut window);
    window.harness.get_by_label("Restore").click();
    window.just_until("it is being read", |app| app.works_in(Lane::Load));
    window.harness.state_mut().document_mut().scene.lights.pop();
    window.until("the edit is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    assert!(window.has("Save the changes to pyramid?"));
    assert!(window.says("What is restored takes its place. Undo brings this one back."));
    window.until("the edit is kept", App::is_work_kept);
    window
}

/// The names of the work that a window finds which begins when one that keeps its work in `data` is killed.
fn found_after_kill(files: &Files, data: &Path, copy: &str) -> Vec<String> {
    let copy = files.path(copy);
    copy_folder(data, &copy);
    let lost = begin(&copy).unwrap().lost.into_iter();
    let mut names: Vec<_> = lost.map(|lost| lost.about.name).collect();
    names.sort();
    names
}

/// What is edited while lost work is read is work too.
#[test]
fn edits_made_while_lost_work_is_read_are_not_lost() {
    let files = Files::new();
    let [data, again] = ["data", "again"].map(|name| files.path(name));
    edit_and_die(&files, &data);
    copy_folder(&data, &again);
    let both = ["pyramid", "room"];

    let mut window = edit_while_lost_work_is_read(&files, &data);
    let edited = window.scene().clone();
    assert_eq!(found_after_kill(&files, &data, "asked"), both);
    window.click("Cancel");
    assert!(window.says("What was restored of room is offered again at the next start"));
    assert_eq!(window.scene(), &edited);
    assert_eq!(found_after_kill(&files, &data, "cancelled"), both);
    drop(window);

    let mut window = edit_while_lost_work_is_read(&files, &again);
    window.click("Replace");
    assert_eq!(window.app().document().name(), "room");
    assert_eq!(window.scene().lights.len(), 3);
    window.settle();
    assert!(window.says("Restored what was not saved. Undo brings pyramid back"));
    window.until("it is kept", App::is_work_kept);
    assert_eq!(found_after_kill(&files, &again, "replaced"), both);
    // One step back is all that was there, and what was restored stays.
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.app().document().name(), "pyramid");
    assert_eq!(window.scene(), &edited);
    window.until("it is kept", App::is_work_kept);
    assert_eq!(found_after_kill(&files, &again, "undone"), both);
    window.ask_to_close();
    window.click("Discard");
    window.harness.state_mut().on_exit();
    drop(window);
    assert_eq!(found_after_kill(&files, &again, "closed"), ["room"]);
}
