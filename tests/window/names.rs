//! Everything that can be operated has a name, for those who do not see it.

use crate::driver::{Files, Window};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::NodeT;

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
