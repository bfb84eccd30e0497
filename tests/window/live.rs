//! The picture that follows every change.

use crate::driver::{Files, Window, library_hash, set_samples};
use egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2,
};
use raymini::gui::App;
use raymini::gui::document::same_picture;
use raymini::gui::jobs::Lane;
use raymini::gui::top_bar::View;
use raymini::math::DVec3;

fn move_camera(window: &mut Window, step: f64) {
    window.harness.state_mut().document_mut().scene.camera.eye.x += step;
    window.harness.run_steps(2);
}

#[test]
fn a_live_picture_follows_every_change_until_it_is_told_not_to() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    // Enough for an error, which would show in the plot.
    set_samples(&mut window, 16);
    window.click("Live");
    window.until("a finished render", |app| {
        app.picture()
            .is_some_and(|p| !p.is_running() && p.is_shown())
    });
    let has_small_picture: fn(&App) -> bool = |app| app.renders().thumbnail_count() > 0;
    window.until("its small picture", has_small_picture);
    assert_eq!(window.app().view(), View::Picture);
    assert_eq!(window.hash(), library_hash(window.scene()));
    for step in [0.1, -0.3] {
        let before = window.hash();
        move_camera(&mut window, step);
        window.until("a render of what the camera sees now", |app| {
            let scene = &app.document().scene;
            app.picture()
                .is_some_and(|p| !p.is_running() && p.scene.camera == scene.camera)
        });
        assert_ne!(window.hash(), before);
        assert_eq!(window.hash(), library_hash(window.scene()));
        window.until("its small picture", has_small_picture);
    }
    // What was only followed crowds nothing.
    assert!(!window.app().picture().unwrap().errors().is_empty());
    let renders = window.app().renders();
    assert_eq!((renders.entries().len(), renders.thumbnail_count()), (0, 1));
    assert_eq!(window.app().error_plot().past().count(), 0);
    assert_eq!(window.app().picture().unwrap().number, 1);

    window.press(Modifiers::NONE, Key::L);
    let before = window.hash();
    move_camera(&mut window, 0.2);
    window.harness.run_steps(10);
    assert_eq!(window.hash(), before);
    assert!(window.says("settings changed since"));
}

/// What Live makes on the way is nothing to remember; a render that was asked for is, however short it was.
#[test]
fn a_render_that_was_asked_for_is_not_lost_to_live_pictures() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let asked_for = window.hash();
    window.click("Live");
    for step in [0.1, 0.2] {
        move_camera(&mut window, step);
        wait_for_picture(&mut window);
        let entries = window.app().renders().entries();
        let hashes: Vec<_> = entries.iter().map(|entry| entry.facts.hash()).collect();
        assert_eq!(hashes, [Some(asked_for.as_str())]);
        assert_eq!(window.app().picture().unwrap().number, 2);
    }
    // One that is asked for while Live is on is no other.
    window.render();
    let asked_for = window.hash();
    move_camera(&mut window, 0.3);
    wait_for_picture(&mut window);
    let newest = window.app().renders().entries().last().unwrap();
    assert_eq!(newest.facts.hash(), Some(asked_for.as_str()));
}

/// Opens the room with a live picture that is done.
fn open_live(files: &Files) -> Window {
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Live");
    wait_for_picture(&mut window);
    window
}

/// Waits for the finished picture of the scene as it is.
fn wait_for_picture(window: &mut Window) {
    window.until("the picture of the scene as it is", |app| {
        let scene = &app.document().scene;
        app.picture()
            .is_some_and(|p| !p.is_running() && same_picture(&p.scene, scene))
    });
    window.settle();
    assert_eq!(window.app().view(), View::Picture);
    assert_eq!(window.hash(), library_hash(window.scene()));
}

#[test]
fn the_mouse_looks_around_in_a_live_picture_as_in_the_preview() {
    let files = Files::new();
    let mut window = open_live(&files);
    let before = window.scene().camera;
    let from = Pos2::new(400.0, 400.0);
    window.drag(PointerButton::Primary, from, from + Vec2::new(60.0, 20.0));
    let orbited = window.scene().camera;
    assert_ne!(orbited.eye, before.eye);
    wait_for_picture(&mut window);

    window.harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 3.0),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(30);
    let eye = window.scene().camera.eye;
    assert!(eye.distance(orbited.target) < orbited.eye.distance(orbited.target));
    assert!(!window.app().zoom().is_enlarged());
    wait_for_picture(&mut window);

    // Enlarged, it is looked at as any picture is.
    let still = window.scene().camera;
    window.press(Modifiers::NONE, Key::Num4);
    window.drag(PointerButton::Primary, from, from + Vec2::new(60.0, 20.0));
    assert_eq!(window.scene().camera, still);
}

#[test]
fn an_object_that_is_moved_by_its_handle_is_seen_at_once_in_a_live_picture() {
    let files = Files::new();
    let mut window = open_live(&files);
    window.click("Move tool");
    window.click("Select pyramid");
    assert_eq!(window.app().view(), View::Picture);
    let middle = DVec3::new(1.0, 0.0, 0.75);
    let right = window.scene().camera.axes().unwrap().right;
    let unit = (window.on_screen(middle + right) - window.on_screen(middle)).length();
    let from = window.on_screen(middle + DVec3::X * 70.0 / f64::from(unit));
    let press = |window: &mut Window, at: Pos2, pressed: bool| {
        window.harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        window.harness.run_steps(1);
    };
    let prepared = window.app().jobs_started(Lane::Prepare);
    window.harness.hover_at(from);
    window.harness.run_steps(1);
    press(&mut window, from, true);
    let to = from + (window.on_screen(middle + DVec3::X) - window.on_screen(middle));
    for share in [0.3, 0.7, 1.0] {
        window.harness.hover_at(from + (to - from) * share);
        window.harness.run_steps(1);
    }
    assert!(window.scene().objects[0].translate.x > 0.6);
    // Still in the hand, it is there.
    window.until("a first look", |app| {
        let scene = &app.document().scene;
        app.picture()
            .is_some_and(|p| p.first_tile.is_some() && same_picture(&p.scene, scene))
    });
    press(&mut window, to, false);
    wait_for_picture(&mut window);
    let now = window.app().jobs_started(Lane::Prepare);
    assert_eq!(now, prepared, "the render has prepared it itself");
    // What is prepared is what is drawn and picked.
    window.press(Modifiers::NONE, Key::Num1);
    window.settle();
    assert_eq!(window.app().jobs_started(Lane::Prepare), prepared);
}

#[test]
fn a_live_picture_that_is_cancelled_while_things_move_leaves_the_scene_prepared() {
    let files = Files::new();
    let mut window = open_live(&files);
    for step in 1..=3 {
        let scene = &mut window.harness.state_mut().document_mut().scene;
        scene.objects[0].translate.x = f64::from(step) * 0.2;
        window.harness.run_steps(1);
    }
    window.press(Modifiers::NONE, Key::Escape);
    window.settle();
    window.press(Modifiers::NONE, Key::L);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
}
