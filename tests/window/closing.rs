//! Questions before something is lost: of unsaved work, of running renders, and of what comes from outside while one shows.

use std::process::Command;

use crate::driver::{Files, SCENE, Window, load, set_samples};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::jobs::Lane;
use raymini::gui::picture::Picture;

#[test]
fn unsaved_work_is_asked_about_before_it_is_replaced() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Cancel");
    assert!(window.app().dialog().is_none());
    assert_eq!(window.scene().lights.len(), 2);

    // Adding keeps what is there.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Add to scene");
    assert_eq!(window.scene().objects.len(), 2);
    assert_eq!(window.scene().objects[1].name, "pyramid 2");
    assert_eq!(window.scene().lights.len(), 2);
    window.settle();

    // Saving first writes the scene, then opens the other.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.click("Save first");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);
    assert_eq!(load(&files.path("room.toml")).objects.len(), 2);
}

#[test]
fn closing_asks_about_unsaved_work() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Save first");
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);
}

/// Questions wait for one another, and none is answered by what was meant for another one.
#[test]
fn what_comes_from_outside_waits_for_the_question_that_shows() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.click("Add light");
    window.ask_to_close();
    window.click("Save first");
    let is_path = |app: &App| matches!(app.dialog(), Some(Dialog::Path(_)));
    assert!(is_path(window.app()), "there is no file yet");
    window.drop_file(files.path("pyramid.off"));
    window.harness.step();
    window.until("the mesh is read", |app| !app.works_in(Lane::Load));
    assert!(is_path(window.app()), "the path is still being typed");
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Cancel");
    assert!(is_path(window.app()), "it comes back");
    window.press(Modifiers::NONE, Key::Escape);
    assert!(matches!(window.app().dialog(), Some(Dialog::Import(_))));
    window.click("Add to scene");
    assert_eq!(window.scene().objects.len(), 2);
    // Closing was given up with the path: saving now closes nothing.
    window.press(Modifiers::COMMAND, Key::S);
    window.enter_path(&files.path("saved.toml"));
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert!(!is_told_to_close(&window));
}

/// Whether the window told the desktop in the last frame to close it.
pub fn is_told_to_close(window: &Window) -> bool {
    let output = window.harness.output().viewport_output.values();
    let mut commands = output.flat_map(|viewport| &viewport.commands);
    commands.any(|command| *command == egui::ViewportCommand::Close)
}

/// Starts a render that does not end by itself, with nothing unsaved.
fn start_long_render(window: &mut Window) {
    set_samples(window, 100_000);
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the scene is saved", |app| !app.document().is_modified());
    window.press(Modifiers::NONE, Key::F5);
    window.until("it runs", |app| {
        app.picture()
            .is_some_and(|picture| picture.first_tile.is_some())
    });
}

#[test]
fn closing_asks_before_a_render_is_given_up() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    for answer in ["Go on", "Give up and close"] {
        window.ask_to_close();
        assert!(matches!(window.app().dialog(), Some(Dialog::Running)));
        assert!(window.app().picture().is_some_and(Picture::is_running));
        window.harness.get_by_label(answer).click();
        let mut is_closed = false;
        for _ in 0..4 {
            window.harness.step();
            is_closed |= is_told_to_close(&window);
        }
        assert_eq!(is_closed, answer != "Go on");
    }
}

#[test]
fn what_is_done_beside_a_render_is_told() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    window.press(Modifiers::COMMAND, Key::E);
    window.enter_path(&files.path("part.png"));
    let news = "Saved what there is to";
    window.until("it is saved", |app| {
        app.messages().last_news().starts_with(news)
    });
    assert!(window.app().picture().is_some_and(Picture::is_running));
    assert!(window.says(news));
}

/// A picture that is being written shows, holds up closing and is cancelled by its button.
#[cfg(unix)]
#[test]
fn saving_a_picture_can_be_cancelled() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    // Writing to a pipe waits until somebody reads from it.
    let pipe = files.path("pipe.png");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    window.press(Modifiers::COMMAND, Key::E);
    window.enter_path(&pipe);
    assert!(window.says("Saving pipe.png"));
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Running)));
    assert!(window.has("Give up saving the picture?"));
    window.click("Go on");
    assert!(window.app().dialog().is_none());
    window.click("Cancel saving the picture");
    // Open both ways, it waits for nobody.
    let mut ends = std::fs::File::options();
    let reader = ends.read(true).write(true).open(&pipe).unwrap();
    window.until("it is told", |app| {
        app.messages().last_news() == "Saving cancelled"
    });
    assert!(!window.has("Cancel saving the picture"));
    assert!(!window.says("Saving pipe.png"));
    drop(reader);
}

/// The extension that is added counts.
#[test]
fn a_file_that_will_be_replaced_is_told_of() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.fill("Path", files.path("room").to_str().unwrap());
    window.until_says("A file of this name is there");
    let scene_file = || std::fs::read_to_string(files.path("room.toml")).unwrap();
    // Enter goes no further than to ask, and then nowhere.
    window.press(Modifiers::NONE, Key::Enter);
    assert!(window.has("Replace room.toml?"));
    window.press(Modifiers::NONE, Key::Enter);
    assert!(matches!(window.app().dialog(), Some(Dialog::Path(_))));
    window.enter_path(&files.path("room.toml"));
    window.click("Cancel");
    assert!(window.app().dialog().is_none());
    assert_eq!(scene_file(), SCENE);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&files.path("room"));
    window.click("Replace");
    window.until_saved(&files.path("room.toml"));
    assert_ne!(scene_file(), SCENE);
}
