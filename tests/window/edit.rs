//! Undoing, copying, renaming and removing in the window, by the names on its controls and by keys.

use crate::driver::{Files, SCENE, Window, library_hash, load, set_number};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, accesskit::Role};
use egui_kittest::kittest::Queryable;
use raymini::gui::top_bar::View;
use raymini::scene::{SamplerChoice, Scene};

const REDO: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// What undoing would take back.
fn next_undo(window: &Window) -> Option<String> {
    let history = window.app().document().undo_history();
    history.next_undo().map(str::to_owned)
}

fn undo(window: &mut Window) {
    window.press(Modifiers::COMMAND, Key::Z);
}

/// Every kind of edit is one step, however many frames it takes, and undoing them all leads back to what was opened.
#[test]
fn everything_is_undone_step_by_step_and_done_again() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let mut states: Vec<Scene> = vec![window.scene().clone()];
    let mut names = Vec::new();
    let step = |window: &mut Window, states: &mut Vec<Scene>, names: &mut Vec<String>| {
        assert_ne!(window.scene(), states.last().unwrap());
        states.push(window.scene().clone());
        names.push(next_undo(window).unwrap());
    };
    let middle = Pos2::new(470.0, 400.0);
    let by = Vec2::new(60.0, 25.0);

    window.drag(PointerButton::Primary, middle, middle + by);
    step(&mut window, &mut states, &mut names);
    window.drag(PointerButton::Middle, middle, middle + by);
    step(&mut window, &mut states, &mut names);
    set_number(&mut window, "Lens radius", "0.25");
    step(&mut window, &mut states, &mut names);
    window.operate("Shadows: Off");
    step(&mut window, &mut states, &mut names);
    window.click("Add light");
    step(&mut window, &mut states, &mut names);
    window.click("Kind: Disk");
    step(&mut window, &mut states, &mut names);
    window.click("Select pyramid");
    set_number(&mut window, "Scale", "1.5");
    step(&mut window, &mut states, &mut names);
    window.operate("New material");
    step(&mut window, &mut states, &mut names);
    window.press(Modifiers::NONE, Key::Delete);
    step(&mut window, &mut states, &mut names);
    assert_eq!(
        names,
        [
            "moving the camera",
            "moving the camera",
            "changing the lens radius",
            "changing the shadows",
            "adding light 2",
            "changing the kind of light 2",
            "scaling pyramid",
            "adding material clay 2",
            "removing pyramid",
        ]
    );

    for state in states.iter().rev().skip(1) {
        undo(&mut window);
        assert_eq!(window.scene(), state);
    }
    assert!(!window.app().document().is_modified());
    assert_eq!(next_undo(&window), None);
    undo(&mut window);
    for state in states.iter().skip(1) {
        window.press(REDO, Key::Z);
        assert_eq!(window.scene(), state);
    }
    window.press(REDO, Key::Z);
    assert_eq!(window.scene(), states.last().unwrap());

    // The other key; and what was removed is selected again.
    undo(&mut window);
    assert!(window.has("Duplicate object"));
    window.press(Modifiers::COMMAND, Key::Y);
    assert_eq!(window.scene(), states.last().unwrap());
    window.settle();
}

/// Turning the wheel is one step, and so is a drag over a number.
#[test]
fn a_gesture_is_one_step() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    window.harness.hover_at(Pos2::new(470.0, 400.0));
    for _ in 0..3 {
        window.harness.event(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: Vec2::new(0.0, 1.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        window.harness.run_steps(8);
    }
    assert_eq!(next_undo(&window), None, "the wheel may turn on");
    window.harness.run_steps(60);
    assert_eq!(next_undo(&window).as_deref(), Some("moving the camera"));
    undo(&mut window);
    assert_eq!(window.scene(), &before);

    let exposure = window.harness.get_by_label("Field of view").rect().center();
    window.drag(
        PointerButton::Primary,
        exposure,
        exposure + Vec2::new(40.0, 0.0),
    );
    assert_ne!(window.scene(), &before);
    undo(&mut window);
    assert_eq!(window.scene(), &before);
    assert_eq!(next_undo(&window), None);
}

/// While a text is typed, Ctrl+Z belongs to the text.
#[test]
fn a_text_field_keeps_its_own_undo() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.click("Select pyramid");
    window.press(Modifiers::NONE, Key::F2);
    let name = window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name");
    assert!(
        name.is_focused(),
        "renaming begins in the field of the name"
    );
    name.type_text(" of stone");
    window.harness.run_steps(2);
    undo(&mut window);
    assert_eq!(window.scene().lights.len(), 2);
    let name = window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name");
    name.type_text(" of clay");
    window.harness.run_steps(2);
    window.press(Modifiers::NONE, Key::Enter);
    assert_ne!(window.scene().objects[0].name, "pyramid");
    assert_eq!(next_undo(&window).as_deref(), Some("renaming pyramid"));
    undo(&mut window);
    assert_eq!(window.scene().objects[0].name, "pyramid");
}

#[test]
fn parts_are_copied_pasted_duplicated_and_removed() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    // There is one camera, and nothing was copied.
    for event in [Event::Copy, Event::Paste("text".to_owned())] {
        window.harness.event(event);
        window.harness.run_steps(2);
    }
    assert_eq!(next_undo(&window), None);

    window.click("Select pyramid");
    window.press(Modifiers::COMMAND, Key::D);
    assert_eq!(window.scene().objects[1].name, "pyramid 2");
    window.harness.event(Event::Copy);
    window.harness.run_steps(2);
    window.harness.event(Event::Paste("pyramid 2".to_owned()));
    window.harness.run_steps(2);
    assert_eq!(window.scene().objects[2].name, "pyramid 3");
    window.press(Modifiers::NONE, Key::Delete);
    window.operate("Remove object");
    assert_eq!(window.scene().objects.len(), 1);
    assert!(window.has("Scale"), "a neighbour is selected");

    // By the menus; what is undone is named there.
    window.click("Edit");
    window.click("Undo removing pyramid 2");
    assert_eq!(window.scene().objects.len(), 2);
    window.click("Edit");
    assert!(window.has("Redo removing pyramid 2"));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.has("Redo removing pyramid 2"), "the menu is closed");
    window.click("Edit");
    window.click("Redo removing pyramid 2");
    assert_eq!(window.scene().objects.len(), 1);
    window
        .harness
        .get_by_label("Select Light 1")
        .click_secondary();
    window.harness.run_steps(3);
    window.click("Duplicate");
    assert_eq!(window.scene().lights.len(), 2);
    window.settle();
}

/// An edit that is undone while its render is looked at restarts it; a move of the camera shows the preview.
#[test]
fn undoing_shows_what_it_does() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F);
    window.operate("Shadows: Off");
    window.render();
    undo(&mut window);
    assert_eq!(window.app().view(), View::Picture);
    assert_eq!(
        window.app().messages().last_news(),
        "Undone: changing the shadows"
    );
    undo(&mut window);
    assert_eq!(window.app().view(), View::Preview);
    assert_eq!(next_undo(&window), None);
}

/// What was typed is not lost by looking at something else, and Escape takes it back.
#[test]
fn a_material_has_the_name_that_was_typed() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let names =
        |window: &Window| -> Vec<String> { window.scene().materials.keys().cloned().collect() };
    let before = names(&window);
    window.operate("Add material");
    let added = names(&window)
        .into_iter()
        .find(|name| !before.contains(name))
        .unwrap();
    let title = window.harness.get_by_label_contains("Materials  ").rect();
    window.click_at(title.left_center() - egui::vec2(10.0, 0.0));
    for (text, key) in [("given up", Some(Key::Escape)), ("marble", None)] {
        window.operate(&format!("Select {added}"));
        window.press(Modifiers::NONE, Key::F2);
        window.press(Modifiers::COMMAND, Key::A);
        let field = window
            .harness
            .get_by_role_and_label(Role::TextInput, "Name");
        field.type_text(text);
        window.harness.run_steps(2);
        match key {
            Some(key) => {
                window.press(Modifiers::NONE, key);
                assert!(names(&window).contains(&added));
            }
            None => window.click("Select Camera"),
        }
    }
    assert!(names(&window).contains(&"marble".to_owned()));
    assert!(!names(&window).contains(&added));
    undo(&mut window);
    assert!(names(&window).contains(&added));
}

#[test]
fn a_light_is_renamed_and_called_so_everywhere() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    window.press(Modifiers::NONE, Key::F2);
    window.enter("Name", "key");
    assert_eq!(window.scene().light_names, ["key"]);
    assert!(window.has("Select key") && !window.has("Select Light 1"));
    assert_eq!(next_undo(&window).as_deref(), Some("renaming light 1"));
    window.press(Modifiers::COMMAND, Key::D);
    assert!(window.has("Select key 2"));
    assert_eq!(next_undo(&window).as_deref(), Some("adding key 2"));
    window.click("Select key");
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.scene().light_names, ["key 2"]);
    assert_eq!(next_undo(&window).as_deref(), Some("removing key"));
    for _ in 0..3 {
        undo(&mut window);
    }
    assert!(window.has("Select Light 1"));
    assert!(!window.app().document().is_modified());
}

/// In every mode: undone and saved like other settings, and rendered with.
#[test]
fn a_sampler_is_chosen_in_the_panel() {
    for mode in ["direct", "path", "ao", "normals"] {
        let files = Files::new();
        let path = files.write("room.toml", &format!("{SCENE}mode = \"{mode}\"\n"));
        let mut window = Window::open(&path);
        let even = library_hash(window.scene());
        window.operate("Sampler: Independent");
        assert_eq!(window.scene().render.sampler, SamplerChoice::Independent);
        assert_eq!(next_undo(&window).as_deref(), Some("changing the sampler"));
        window.press(Modifiers::COMMAND, Key::S);
        window.until_saved(&path);
        assert_eq!(load(&path).render.sampler, SamplerChoice::Independent);
        window.render();
        assert_eq!(window.hash(), library_hash(window.scene()), "{mode}");
        assert_ne!(window.hash(), even, "{mode}");
        window.operate("Sampler: Sobol");
        assert_eq!(window.scene().render.sampler, SamplerChoice::Sobol);
    }
}
