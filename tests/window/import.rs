//! Meshes that come into a scene: dropped or chosen, added or in its place, in another unit, with another axis up.

use crate::driver::{Files, MESH, Window};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use raymini::gui::dialogs::Dialog;
use raymini::math::DVec3;

/// Until it is asked what becomes of what was dropped.
fn until_asked(window: &mut Window) {
    window.harness.step();
    window.until("it is asked what becomes of the mesh", |app| {
        matches!(app.dialog(), Some(Dialog::Import(_)))
    });
}

/// Chooses from the list called `name`.
fn choose(window: &mut Window, name: &str, choice: &str) {
    let list = window.harness.get_by_role_and_label(Role::ComboBox, name);
    list.click();
    window.harness.run_steps(3);
    let choices = window.harness.query_all_by_label_contains(choice);
    choices.last().expect("the choice is in the list").click();
    window.harness.run_steps(3);
}

#[test]
fn enter_opens_a_dropped_mesh_in_place_of_a_scene_without_changes() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    assert!(window.says("1 object, 10 triangles") && window.says("4 × 2 × 1.5"));
    window.press(Modifiers::NONE, Key::Enter);
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    window.settle();
    assert_eq!(window.scene().objects.len(), 1);
}

#[test]
fn enter_adds_a_dropped_mesh_to_a_scene_with_changes() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    window.press(Modifiers::NONE, Key::Enter);
    window.settle();
    assert_eq!(window.scene().objects[1].name, "pyramid 2");
    assert_eq!(window.scene().lights.len(), 2);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().objects.len(), 1);
    assert_eq!(window.scene().lights.len(), 2);
}

#[test]
fn a_mesh_in_inches_with_y_up_is_added_as_large_and_upright_as_it_is() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    choose(&mut window, "Unit", "Inches");
    window.click("Up axis: Y");
    // 4 × 2 × 1.5 inches, upright where Z is up.
    assert!(window.says("0.102 × 0.038 × 0.051"));
    window.click("Add to scene");
    window.settle();
    let object = &window.scene().objects[1];
    assert_eq!((object.scale, object.rotate), (0.0254, DVec3::X * 90.0));
    assert_eq!(window.scene().objects[0].scale, 1.0);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().objects.len(), 1);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(window.scene().objects.len(), 2);
}

#[test]
fn a_fitted_mesh_is_as_large_as_what_is_there_and_stands_in_it() {
    let files = Files::new();
    let huge = MESH.replace("0 0 1.5", "0 0 15000");
    let huge = files.write("huge.off", &huge);
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().bounds();
    window.drop_file(huge);
    until_asked(&mut window);
    choose(&mut window, "Unit", "Fitted");
    window.click("Add to scene");
    window.settle();
    let scene = window.scene();
    let object = &scene.objects[1];
    let bounds = object.bounds_of(&scene.meshes[&object.mesh]);
    let share = bounds.diagonal() / before.diagonal();
    assert!((share - 1.0).abs() < 1e-9, "{share}");
    assert!((bounds.min.z - before.min.z).abs() < 1e-9, "it stands");
    let off = (bounds.center() - before.center()).truncate().length();
    assert!(off < 1e-9, "in the middle");
}

#[test]
fn meshes_dropped_together_are_one_question_and_one_step() {
    let files = Files::new();
    let other = files.write("other.off", MESH);
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(files.path("pyramid.off"));
    window.drop_file(other);
    until_asked(&mut window);
    assert!(window.says("Import 2 meshes"));
    window.click("Add to scene");
    window.settle();
    assert_eq!(window.scene().objects.len(), 3);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().objects.len(), 1);

    // In their place, in millimetres: smaller, and framed as before.
    window.drop_file(files.path("pyramid.off"));
    window.drop_file(files.path("other.off"));
    until_asked(&mut window);
    choose(&mut window, "Unit", "Millimetres");
    window.click("Replace");
    window.settle();
    let scene = window.scene();
    assert_eq!(scene.objects.len(), 2);
    assert!((scene.bounds().diagonal() - 22.25_f64.sqrt() * 1e-3).abs() < 1e-9);

    // What was there is a step away, with its file.
    let history = window.app().document().undo_history();
    assert_eq!(history.next_undo(), Some("opening pyramid"));
    window.press(Modifiers::COMMAND, Key::Z);
    window.settle();
    assert_eq!(window.scene().objects.len(), 1);
    let document = window.app().document();
    assert!(document.name() == "room" && document.path().is_some() && !document.is_modified());
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    window.settle();
    assert_eq!(window.scene().objects.len(), 2);
    assert_eq!(window.app().document().name(), "pyramid");
}

#[test]
fn a_winding_is_repaired_on_import_and_as_it_was_by_a_switch() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    window.operate("Repair winding");
    window.click("Add to scene");
    window.settle();
    assert!(window.scene().objects[1].repair_winding && !window.scene().objects[0].repair_winding);
    window.operate("Repair winding");
    window.settle();
    assert!(!window.scene().objects[1].repair_winding);
    let history = window.app().document().undo_history();
    assert_eq!(
        history.next_undo(),
        Some("changing the winding of pyramid 2")
    );
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(window.scene().objects[1].repair_winding);
}

#[test]
fn escape_leaves_everything_and_a_broken_mesh_says_why() {
    let files = Files::new();
    let broken = files.write("broken.off", "OFF\n1 1 0\n0 0\n");
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.app().dialog().is_none());
    assert_eq!(window.scene(), &before);

    window.drop_file(broken);
    window.harness.step();
    window.until("it is told why", |app| !app.messages().banners().is_empty());
    assert_eq!(
        window.app().messages().banners()[0].title,
        "Cannot open broken.off"
    );
    assert_eq!(window.scene(), &before);
}

/// Nothing would come of adding it.
#[test]
fn a_mesh_without_triangles_is_told_of_and_not_asked_about() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    window.drop_file(files.write("empty.off", "OFF\n1 0 0\n0 0 0\n"));
    window.harness.step();
    window.until("it is told why", |app| !app.messages().banners().is_empty());
    assert!(window.app().dialog().is_none());
    let banner = &window.app().messages().banners()[0];
    assert_eq!(banner.title, "Cannot open empty.off");
    assert!(banner.text.contains("no triangles"), "{}", banner.text);
    assert_eq!(window.scene(), &before);

    // Of many messages the newest show, and all go.
    for name in ["a.off", "b.off", "c.off"] {
        window.drop_file(files.write(name, "OFF\n1 0 0\n0 0 0\n"));
        window.harness.step();
        let title = format!("Cannot open {name}");
        window.until("it is told", |app| {
            app.messages().banners().last().unwrap().title == title
        });
    }
    assert!(window.has("Cannot open b.off") && window.has("Cannot open c.off"));
    assert!(!window.has("Cannot open a.off") && window.says("and 2 older messages"));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.has("Cannot open c.off") && window.has("Cannot open a.off"));
    window.click("Dismiss all");
    assert!(window.app().messages().banners().is_empty());
}

/// Unsaved work is asked about before a mesh takes its place.
#[test]
fn replacing_unsaved_work_asks_first() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    window.click("Replace");
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Cancel");
    assert_eq!(window.scene().lights.len(), 2);
    window.drop_file(files.path("pyramid.off"));
    until_asked(&mut window);
    window.click("Replace");
    window.click("Replace");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
}

/// Colours of vertices show also where the mesh joins a scene whose material has none.
#[test]
fn vertex_colors_show_when_a_mesh_is_added() {
    let files = Files::new();
    let colored = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n";
    let colored = files.write("colored.ply", colored);
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(colored);
    until_asked(&mut window);
    window.click("Add to scene");
    window.settle();
    let scene = window.scene();
    let material = scene.material_of(&scene.objects[1]).unwrap();
    assert!(material.textures().unwrap().vertex_colors);
    assert_eq!(scene.objects[0].material.as_deref(), Some("clay"));
    window.harness.render().unwrap();
}
