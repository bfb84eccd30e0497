//! Materials in the window: what they look like, and common ones to take.

use crate::driver::{Files, Window};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable;
use raymini::gui::jobs::Lane;
use raymini::scene::Material;
use raymini::scene::presets::materials;

#[test]
fn a_material_becomes_a_preset_and_its_ball_follows() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let clay = Material::clone(&window.scene().materials["clay"]);
    window.click("Select pyramid");
    let known = Material::clone(&clay);
    window.until("the ball of clay is there", move |app| {
        app.balls().has(&known)
    });

    window.click("Presets of materials");
    let presets = materials::all();
    for preset in &presets {
        assert!(window.has(&format!("Preset {}", preset.name)));
    }
    window.click("Preset Gold");
    let gold = presets.iter().find(|preset| preset.name == "Gold").unwrap();
    // Clay is the name of a preset, which nobody chose for this one.
    assert_eq!(window.scene().materials["Gold"], gold.material);
    let object = &window.scene().objects[0];
    assert_eq!(object.material.as_deref(), Some("Gold"));
    assert!(!window.has("Preset Gold"), "the menu is closed");
    let known = Material::clone(&gold.material);
    window.until("the ball of gold is there", move |app| {
        app.balls().has(&known)
    });
    let history = window.app().document().undo_history();
    assert_eq!(
        history.next_undo(),
        Some("changing the kind of material clay")
    );
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().materials["clay"], clay);

    // In the list, and in the material's own panel.
    window.click("Select Camera");
    // The group folds by what stands before its name.
    let title = window.harness.get_by_label("Materials  1").rect();
    window.click_at(title.left_center() - Vec2::new(10.0, 0.0));
    window.click("Select clay");
    assert!(window.has("Ball of clay"));
    window.harness.render().unwrap();

    // When everything is there, nothing is done any more.
    window.until("no ball is missing", |app| !app.works_in(Lane::Balls));
    let frames = window.harness.try_run_realtime();
    assert!(frames.is_ok(), "the window comes to rest");
}
