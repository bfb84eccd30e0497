//! Keys, quick clicks, menus and the sheet that tells them.

use crate::driver::{Files, Window, set_samples};
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::gui::dialogs::Dialog;
use raymini::gui::picture::Picture;

/// However slow a frame is, every press of a key counts.
#[test]
fn keys_that_come_in_one_frame_all_count() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    for _ in 0..3 {
        window.operate("Add light");
    }
    assert_eq!(window.scene().lights.len(), 4);
    for pressed in [true, false, true, false, true, false] {
        window.harness.input_mut().events.push(Event::Key {
            key: Key::Z,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::COMMAND,
        });
    }
    window.harness.run_steps(2);
    assert_eq!(window.scene().lights.len(), 1);
    assert!(window.app().messages().last_news().starts_with("Undone"));
    window.operate("Add light");
    assert!(!window.app().messages().last_news().starts_with("Undone"));
}

#[test]
fn every_command_is_on_the_sheet() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F1);
    assert!(matches!(window.app().dialog(), Some(Dialog::Shortcuts)));
    for command in raymini::gui::commands::Command::ALL {
        assert!(window.has(command.description()), "{command:?}");
    }
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.app().dialog().is_none());
    for key in [Key::F1, Key::Questionmark] {
        window.press(Modifiers::NONE, key);
        assert!(matches!(window.app().dialog(), Some(Dialog::Shortcuts)));
        window.press(Modifiers::NONE, key);
        assert!(window.app().dialog().is_none(), "{key:?} again");
    }
}

/// What is written in the window, and where the middle of it is.
fn texts_drawn(window: &Window) -> impl Iterator<Item = (&str, Pos2)> {
    let shapes = window.harness.output().shapes.iter();
    shapes.filter_map(|clipped| match &clipped.shape {
        egui::Shape::Text(text) => {
            let place = text.visual_bounding_rect().center();
            Some((text.galley.text(), place))
        }
        _ => None,
    })
}

/// Every command is in a menu, with its keys in the same line, and on the sheet, with the same keys and all others.
#[test]
fn menus_name_the_keys_of_the_sheet() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let ctx = window.harness.ctx.clone();
    let mut seen = Vec::new();
    for menu in ["File", "Edit", "View", "Render menu", "Help"] {
        window.click(menu);
        for command in raymini::gui::commands::Command::ALL {
            let keys = command.shortcut_text(&ctx);
            let is_item = |node: &egui_kittest::Node<'_>| {
                let node = node.accesskit_node();
                node.label()
                    .is_some_and(|label| label.starts_with(command.label()))
            };
            let root = window.harness.root();
            let items = root.children_recursive().filter(is_item);
            let mut rects = items.map(|item| item.rect());
            // Its keys are drawn in the same line.
            let is_named = rects.any(|rect| {
                let mut texts = texts_drawn(&window);
                texts.any(|(text, place)| text == keys && rect.contains(place))
            });
            if is_named {
                seen.push(command);
            }
        }
        window.press(Modifiers::NONE, Key::Escape);
    }
    for command in raymini::gui::commands::Command::ALL {
        assert!(
            seen.contains(&command),
            "no menu names the keys of {command:?}"
        );
    }
    window.press(Modifiers::NONE, Key::F1);
    for command in raymini::gui::commands::Command::ALL {
        let keys: Vec<_> = command.shortcut_texts(&ctx).collect();
        let line = window.harness.get_by_label(command.description()).rect();
        let keys = keys.join(",  ");
        let mut named = window.harness.query_all_by_label(&keys);
        let is_beside = named.any(|text| (text.rect().center().y - line.center().y).abs() < 30.0);
        assert!(is_beside, "{command:?}: {keys}");
    }
}

#[test]
fn the_path_field_goes_into_folders_and_begins_anew() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.press(Modifiers::COMMAND, Key::O);
    let folder = files.folder.path().to_str().unwrap().to_owned();
    window.enter("Path", &format!("/somewhere/{folder}"));
    assert!(matches!(window.app().dialog(), Some(Dialog::Path(_))));
    window.until_says("room.toml");
}

/// However quickly they follow on one another, clicks on Pause and Resume are two; the second one on what takes the place of Render is none.
#[test]
fn quick_clicks_mean_the_button_that_was_aimed_at() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 100_000);
    let place = window.rect("Render").center();
    let click = |window: &mut Window| {
        for pressed in [true, false] {
            window.harness.event(Event::PointerButton {
                pos: place,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            });
        }
        window.harness.step();
    };
    window.harness.event(Event::PointerMoved(place));
    window.harness.step();
    click(&mut window);
    click(&mut window);
    window.harness.run_steps(3);
    let picture = |window: &Window| {
        let picture = window.app().picture().expect("one was asked for");
        (picture.is_running(), picture.is_paused())
    };
    assert_eq!(picture(&window), (true, false));
    for is_paused in [true, false, true, false] {
        window.click(if is_paused { "Pause" } else { "Resume" });
        assert_eq!(picture(&window), (true, is_paused));
    }
}

/// Esc is for what is in front.
#[test]
fn escape_closes_the_report_before_it_cancels_the_render_behind_it() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 1_000_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    assert!(window.app().report().open);
    let is_running = |window: &Window| window.app().picture().is_some_and(Picture::is_running);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.app().report().open && is_running(&window));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!is_running(&window));

    // A button says what it is for.
    window.click("Render");
    window.until("it renders", |app| {
        app.picture().is_some_and(Picture::is_running)
    });
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.click("Cancel");
    assert!(window.app().report().open && !is_running(&window));
}
