//! Everything that can be operated has a name, for those who do not see it.

use crate::driver::{Files, SCENE, Window};
use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::analysis::contributions::Contributor;
use raymini::analysis::cost::Effect;
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;

/// What can be operated.
const CONTROLS: [Role; 9] = [
    Role::Button,
    Role::CheckBox,
    Role::ColorWell,
    Role::ComboBox,
    Role::Link,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::TextInput,
];

/// The controls of the window, and those among them without a name.
fn controls(window: &Window) -> (usize, Vec<String>) {
    let root = window.harness.root();
    let nodes = root.children_recursive();
    let controls: Vec<_> = nodes
        .filter(|node| CONTROLS.contains(&node.accesskit_node().role()))
        .collect();
    let is_nameless = |node: &&egui_kittest::Node<'_>| {
        let name = node.accesskit_node().label().unwrap_or_default();
        name.trim().is_empty()
    };
    let nameless = controls.iter().filter(is_nameless);
    let nameless = nameless.map(|node| format!("{node:?}")).collect();
    (controls.len(), nameless)
}

fn assert_named(window: &Window, at_least: usize, what: &str) {
    let (count, nameless) = controls(window);
    assert!(count >= at_least, "{what}: {count} controls");
    assert!(nameless.is_empty(), "{what}: {nameless:#?}");
}

#[test]
fn every_control_has_a_name() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    assert_named(&window, 50, "camera");
    for part in ["Background", "pyramid", "Light 1"] {
        window.click(&format!("Select {part}"));
        assert_named(&window, 50, part);
    }
    for tool in ["Move tool", "Rotate tool", "Scale tool", "Focus tool"] {
        window.click(tool);
        assert_named(&window, 50, tool);
    }
    window.operate("Plan");
    window.operate("Stop at noise");
    window.operate("Occlusion");
    window.operate("Clamp");
    assert_named(&window, 60, "all settings");
    for menu in ["File", "Edit", "View", "Render menu", "Help"] {
        window.click(menu);
        assert_named(&window, 60, menu);
        window.press(Modifiers::NONE, Key::Escape);
    }
    window.press(Modifiers::NONE, Key::F1);
    assert_named(&window, 1, "the sheet of shortcuts");
    window.press(Modifiers::NONE, Key::Escape);

    // A picture, its renders, its comparison, its error, a report.
    window.render();
    window.render();
    window.press(Modifiers::NONE, Key::F6);
    window.press(Modifiers::NONE, Key::F8);
    window.press(Modifiers::NONE, Key::C);
    assert_named(&window, 60, "pictures");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    assert_named(&window, 60, "the report");
    window.press(Modifiers::NONE, Key::Escape);

    window.drop_file(files.path("pyramid.off"));
    window.import("Cancel");
    window.press(Modifiers::COMMAND, Key::O);
    assert_named(&window, 3, "the path field");
}

#[test]
fn every_control_of_materials_bookmarks_and_contributions_has_a_name() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    // The group folds by what stands before its name.
    let title = window.rect("Materials  1");
    window.click_at(title.left_center() - Vec2::new(10.0, 0.0));
    window.click("Select clay");
    assert!(window.has("Ball of clay"));
    assert_named(&window, 40, "the material");
    window.click("Presets of materials");
    assert!(window.has("Preset Gold"));
    assert_named(&window, 50, "the presets of materials");
    window.press(Modifiers::NONE, Key::Escape);

    window.click("Select Camera");
    window.press(Modifiers::NONE, Key::M);
    assert!(window.has("Go to bookmark 1") && window.has("Remove bookmark 1"));
    assert_named(&window, 50, "the bookmarks");
    window.click("View");
    assert_named(&window, 60, "the menu with the bookmarks");
    window.press(Modifiers::NONE, Key::Escape);

    let shadows = Contributor::Effect(Effect::Shadows);
    let picture = window.harness.get_by_label("Contribution of shadows");
    picture.scroll_to_me();
    window.until("it is known what shadows bring", move |app| {
        app.contributions().known(&shadows).is_some()
    });
    window.operate("Contribution of shadows");
    assert!(window.has("Show: Without"));
    assert_named(&window, 50, "the window of a contribution");
}

fn asks(window: &mut Window, is_it: impl Fn(&Dialog) -> bool) {
    window.until("it is asked", |app| app.dialog().is_some_and(&is_it));
}

#[test]
fn every_answer_to_a_question_has_a_name() {
    let files = Files::new();
    let data = files.path("data");
    let room = files.path("room.toml");
    let open = || Window::start_keeping(vec![room.clone()], true, Some(data.clone()));
    let mut window = open();
    window.operate("Add light");
    window.until("the work is kept", App::is_work_kept);
    window.drop_file(room.clone());
    asks(&mut window, |dialog| matches!(dialog, Dialog::Unsaved(_)));
    assert!(window.has("Replace"));
    assert_named(&window, 3, "unsaved work before another scene");
    window.press(Modifiers::NONE, Key::Escape);
    window.ask_to_close();
    asks(&mut window, |dialog| matches!(dialog, Dialog::Unsaved(_)));
    assert!(window.has("Discard"));
    assert_named(&window, 3, "unsaved work before closing");
    // It ends as a process does that is killed.
    drop(window);

    let mut window = open();
    asks(&mut window, |dialog| matches!(dialog, Dialog::Recovery(_)));
    assert!(window.has("Restore") && window.has("Later"));
    assert_named(&window, 3, "lost work");
    drop(window);

    let long = SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 100_000");
    let mut window = Window::open(&files.write("long.toml", &long));
    window.press(Modifiers::NONE, Key::F5);
    window.until("it renders", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.ask_to_close();
    asks(&mut window, |dialog| matches!(dialog, Dialog::Running));
    assert!(window.has("Give up and close"));
    assert_named(&window, 2, "a render before closing");
}
