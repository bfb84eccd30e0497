//! The picture that follows every change.

use crate::driver::{Files, Window, library_hash};
use egui::{Key, Modifiers};
use raymini::gui::top_bar::View;

fn move_camera(window: &mut Window, step: f64) {
    window.harness.state_mut().document_mut().scene.camera.eye.x += step;
    window.harness.run_steps(2);
}

#[test]
fn a_live_picture_follows_every_change_until_it_is_told_not_to() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Live");
    window.until("a finished render", |app| {
        app.picture()
            .is_some_and(|p| !p.is_running() && p.texture().is_some())
    });
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
    }
    assert!(
        window.app().renders().entries().is_empty(),
        "what was only followed crowds nothing"
    );

    window.press(Modifiers::NONE, Key::L);
    let before = window.hash();
    move_camera(&mut window, 0.2);
    window.harness.run_steps(10);
    assert_eq!(window.hash(), before);
    assert!(window.says("settings changed since"));
}
