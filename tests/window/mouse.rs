//! The mouse in the preview: looking around, selecting, and moving lights.

use crate::driver::{Files, Window, load};
use egui::{Event, Key, Modifiers, PointerButton, Vec2};
use raymini::math::DVec3;

#[test]
fn framing_and_resetting_the_camera() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let home = window.scene().camera;
    window.press(Modifiers::NONE, Key::F);
    let framed = window.scene().camera;
    assert_ne!(framed, home);
    window.press(Modifiers::NONE, Key::Home);
    assert_eq!(window.scene().camera, home);
    window.click("Select pyramid");
    window.press(Modifiers::SHIFT, Key::F);
    assert_eq!(window.scene().camera, framed, "the only object is all");
}

/// A click selects what is under it, scrolling comes nearer to it, a double click turns the camera to it.
#[test]
fn the_mouse_selects_zooms_and_aims() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let on_the_pyramid = window.on_screen(DVec3::new(0.0, -0.6, 0.6));
    window.click_at(on_the_pyramid);
    assert!(window.has("Scale"), "the object's properties show");
    assert_eq!(window.scene().camera, load(&files.path("room.toml")).camera);

    let before = window.scene().camera;
    window.harness.hover_at(on_the_pyramid);
    window.harness.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(30);
    let nearer = window.scene().camera;
    assert!(nearer.eye.length() < before.eye.length() * 0.95);
    let still_there = window.on_screen(DVec3::new(0.0, -0.6, 0.6));
    assert!(still_there.distance(on_the_pyramid) < 8.0);

    window.clicks_at(still_there, 2);
    let aimed = window.scene().camera;
    assert_eq!(aimed.eye, nearer.eye);
    let target = aimed.target;
    assert!(
        target.distance(DVec3::new(0.0, -0.6, 0.6)) < 0.3,
        "{target}, before {}",
        nearer.target
    );
}

#[test]
fn a_lights_marker_moves_the_light() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F);
    let scene = window.scene();
    let camera = scene.camera;
    let position = scene.lights[0].position();
    // Where the marker is not in view, the camera steps back first.
    let eye = camera.target + (camera.eye - camera.target) * 3.0;
    window.harness.state_mut().document_mut().scene.camera.eye = eye;
    window.harness.run_steps(2);
    let marker = window.on_screen(position);
    window.drag(
        PointerButton::Primary,
        marker,
        marker + Vec2::new(40.0, 0.0),
    );
    let moved = window.scene().lights[0].position();
    assert_ne!(moved, position);
    assert_eq!(window.scene().camera.eye, eye, "the camera stays");
    assert!(
        window
            .on_screen(moved)
            .distance(marker + Vec2::new(40.0, 0.0))
            < 3.0
    );
}

/// A light that is dragged by its marker is where it was once Esc is pressed, and nothing is left to undo.
#[test]
fn esc_puts_a_dragged_light_back() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let camera = &mut window.harness.state_mut().document_mut().scene.camera;
    camera.eye = camera.target + (camera.eye - camera.target) * 3.0;
    window.settle();
    window.harness.run_steps(2);
    let before = window.scene().clone();
    let undo = window.app().document().undo_history().next_undo();
    let undo = undo.map(str::to_owned);
    let marker = window.on_screen(before.lights[0].position());
    let press = |pressed| Event::PointerButton {
        pos: marker,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.harness.hover_at(marker);
    window.harness.run_steps(1);
    window.harness.event(press(true));
    for step in 1..=3_u8 {
        let by = Vec2::new(25.0, 10.0) * f32::from(step);
        window.harness.hover_at(marker + by);
        window.harness.run_steps(1);
    }
    assert_ne!(window.scene().lights[0], before.lights[0]);
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.scene(), &before);
    // The button is still held, and nothing follows it any more.
    window.harness.hover_at(marker + Vec2::new(-40.0, 30.0));
    window.harness.run_steps(2);
    window.harness.event(press(false));
    window.harness.run_steps(2);
    assert_eq!(window.scene(), &before);
    let history = window.app().document().undo_history();
    assert_eq!(history.next_undo().map(str::to_owned), undo);
}
