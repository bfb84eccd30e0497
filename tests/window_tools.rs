//! Tools of the preview: handles that move, turn and scale, and choosing what is sharp.
#![cfg(feature = "gui")]

mod driver;

use driver::{Files, Window};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::Queryable;
use raymini::gui::tool::Tool;
use raymini::gui::top_bar::View;
use raymini::math::DVec3;
use raymini::scene::{Facing, Light};

/// What undoing would take back.
fn next_undo(window: &Window) -> Option<String> {
    let history = window.app().document().undo_history();
    history.next_undo().map(str::to_owned)
}

fn undo(window: &mut Window) {
    window.press(Modifiers::COMMAND, Key::Z);
}

/// Points of the screen per scene unit at a world point, across the view.
fn points_per_unit(window: &Window, at: DVec3) -> f32 {
    let right = window.scene().camera.axes().unwrap().right;
    (window.on_screen(at + right) - window.on_screen(at)).length()
}

/// A place on the arrow of an axis, from what handles are about.
fn on_arrow(window: &Window, pivot: DVec3, axis: DVec3) -> Pos2 {
    let length = 70.0 / f64::from(points_per_unit(window, pivot));
    window.on_screen(pivot + axis * length)
}

/// The middle of the box of the mesh.
const MIDDLE: DVec3 = DVec3::new(1.0, 0.0, 0.75);

fn button(window: &mut Window, at: Pos2, pressed: bool) {
    window.harness.event(Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(1);
}

#[test]
fn an_object_is_moved_turned_and_scaled_by_handles() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    window.click("Move tool");
    assert!(window.says("Select an object or a light"));
    window.click("Select pyramid");
    let from = on_arrow(&window, MIDDLE, DVec3::X);
    let to = from + (window.on_screen(MIDDLE + DVec3::X) - window.on_screen(MIDDLE));
    window.drag(PointerButton::Primary, from, to);
    let moved = window.scene().objects[0].translate;
    assert!(moved.x > 0.6 && moved.x < 1.5, "{moved}");
    assert_eq!((moved.y, moved.z), (0.0, 0.0));
    assert_eq!(next_undo(&window).as_deref(), Some("moving pyramid"));
    assert_eq!(window.scene().camera, before.camera, "nothing else moves");
    undo(&mut window);
    assert_eq!(window.scene(), &before, "one drag is one step");
    window.settle();

    // The key of another tool; the ring about the line of sight, a quarter turn.
    window.press(Modifiers::NONE, Key::R);
    let middle = window.on_screen(MIDDLE);
    let radius = 84.0 * 1.12;
    let from = middle + Vec2::new(radius, 0.0);
    window.drag(
        PointerButton::Primary,
        from,
        middle + Vec2::new(0.0, -radius),
    );
    assert_eq!(next_undo(&window).as_deref(), Some("turning pyramid"));
    let object = &window.scene().objects[0];
    let center = object.placement().world_from_object(MIDDLE);
    assert!(center.distance(MIDDLE) < 1e-6, "it turns about its middle");
    let axes = before.camera.axes().unwrap();
    let turned = object.placement().linear * axes.right;
    // Perspective tilts the plane of the ring a little against the picture.
    assert!(turned.dot(axes.up) > 0.9, "right turns up: {turned}");
    undo(&mut window);
    window.settle();

    window.press(Modifiers::NONE, Key::S);
    let end = Vec2::new(1.0, -1.0) * (84.0 * 0.9 / 2_f32.sqrt());
    window.drag(PointerButton::Primary, middle + end, middle + end * 2.0);
    let scale = window.scene().objects[0].scale;
    assert!((scale - 2.0).abs() < 0.05, "{scale}");
    assert_eq!(next_undo(&window).as_deref(), Some("scaling pyramid"));
    undo(&mut window);
    assert_eq!(window.scene(), &before);

    // The same key again hides the handles; the mouse looks around.
    window.press(Modifiers::NONE, Key::S);
    window.drag(PointerButton::Primary, middle + end, middle + end * 2.0);
    assert_ne!(window.scene().camera, before.camera);
    window.settle();
}

#[test]
fn a_drag_is_constrained_by_keys_and_cancelled() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    window.click("Select pyramid");
    window.press(Modifiers::NONE, Key::G);
    let from = window.on_screen(MIDDLE);
    window.harness.hover_at(from);
    window.harness.run_steps(1);
    button(&mut window, from, true);
    for step in 1..=4_u8 {
        let by = Vec2::new(30.0, -25.0) * f32::from(step);
        window.harness.hover_at(from + by);
        window.harness.run_steps(1);
    }
    let free = window.scene().objects[0].translate;
    assert!(free.x != 0.0 && free.y != 0.0 && free.z != 0.0, "{free}");
    assert!(window.says("Esc cancels"));
    window.press(Modifiers::NONE, Key::Z);
    let along = window.scene().objects[0].translate;
    assert!(along.x == 0.0 && along.y == 0.0 && along.z > 0.5, "{along}");
    window.press(Modifiers::NONE, Key::Z);
    let across = window.scene().objects[0].translate;
    assert!(across.z == 0.0 && across.x != 0.0, "{across}");
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.scene(), &before);
    // The button is still held, and nothing follows it any more.
    window.harness.hover_at(from);
    window.harness.run_steps(2);
    button(&mut window, from, false);
    window.harness.run_steps(2);
    assert_eq!(window.scene(), &before);
    assert_eq!(next_undo(&window), None);
}

#[test]
fn lights_and_what_they_aim_at_are_moved() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.click("Kind: Disk");
    let light = |window: &Window| window.scene().lights[1];
    let before = light(&window);
    let target = before.target().expect("it faces the camera's target");

    // By the marker of the target, with any tool.
    let from = window.on_screen(target);
    window.drag(PointerButton::Primary, from, from + Vec2::new(40.0, 10.0));
    let aimed = light(&window).target().unwrap();
    let expected = from + Vec2::new(40.0, 10.0);
    assert!((window.on_screen(aimed) - expected).length() < 1.0);
    assert_eq!(light(&window).position(), before.position());
    assert_eq!(next_undo(&window).as_deref(), Some("aiming light 2"));

    // The handles are at what was pointed at last.
    window.press(Modifiers::NONE, Key::G);
    let from = on_arrow(&window, aimed, DVec3::Z);
    window.drag(PointerButton::Primary, from, from - Vec2::new(0.0, 30.0));
    let lifted = light(&window).target().unwrap();
    assert!(lifted.z > aimed.z + 0.1 && lifted.x == aimed.x, "{lifted}");
    let marker = window.on_screen(before.position());
    window.click_at(marker);
    let from = on_arrow(&window, before.position(), DVec3::Z);
    window.drag(PointerButton::Primary, from, from + Vec2::new(0.0, 20.0));
    assert!(light(&window).position().z < before.position().z);
    assert_eq!(light(&window).target(), Some(lifted));

    // Turning a disk turns where it shines; there is nothing to turn of a point.
    window.press(Modifiers::NONE, Key::R);
    let center = window.on_screen(light(&window).position());
    let radius = 84.0 * 1.12;
    let from = center + Vec2::new(radius, 0.0);
    window.drag(
        PointerButton::Primary,
        from,
        center + Vec2::new(0.0, radius),
    );
    assert_ne!(light(&window).target(), Some(lifted));
    assert_eq!(next_undo(&window).as_deref(), Some("aiming light 2"));
    window.click("Select Light 1");
    assert!(window.says("Only objects and disk lights can be turned"));
    assert!(matches!(
        light(&window),
        Light::Disk {
            facing: Facing::Target(_),
            ..
        }
    ));
}

#[test]
fn a_click_makes_what_is_under_it_sharp() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    let depth = |point: DVec3| {
        let camera = &before.camera;
        camera.axes().unwrap().forward.dot(point - camera.eye)
    };
    window.click("Pick focus");
    assert!(window.says("Nothing is blurred: the lens radius is 0"));
    driver::set_number(&mut window, "Lens radius", "0.2");
    assert!(window.says("Sharp at distance"));
    // The top of the pyramid, which is nearer than what is behind it.
    let top = DVec3::new(0.0, -0.05, 1.42);
    window.click_at(window.on_screen(top));
    let focus = window.scene().camera.focus_distance.expect("was chosen");
    assert!((focus - depth(top)).abs() < 0.1, "{focus} {}", depth(top));
    assert!(window.says("blur 0"));
    assert_eq!(next_undo(&window).as_deref(), Some("changing the focus"));
    assert_eq!(window.app().view(), View::Preview);

    // In the picture too, which stays.
    window.render();
    assert_eq!(window.app().view(), View::Picture);
    let low = DVec3::new(-0.3, -0.85, 0.12);
    window.click_at(window.on_screen(low));
    let focus = window.scene().camera.focus_distance.unwrap();
    assert!((focus - depth(low)).abs() < 0.15, "{focus} {}", depth(low));
    assert_eq!(window.app().view(), View::Picture);
    undo(&mut window);
    assert_eq!(window.app().view(), View::Picture, "nothing has moved");

    // Beside everything there is nothing to make sharp.
    let camera = window.scene().camera;
    let corner = window.harness.get_by_label("Viewport").rect().right_top();
    window.click_at(corner + Vec2::new(-8.0, 8.0));
    assert_eq!(window.scene().camera, camera);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.says("Sharp at distance"));
    window.click_at(window.on_screen(low));
    assert_eq!(window.scene().camera, camera, "a click selects again");
}

/// Every tool is in the menu and on the sheet, and the bar says which is in use.
#[test]
fn tools_have_names_and_keys() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    for tool in Tool::ALL.into_iter().skip(1) {
        window.click(tool.command().label());
        window.click("Edit");
        let label = tool.command().label();
        assert!(
            window.harness.query_all_by_label(label).count() > 1,
            "{label}"
        );
        window.press(Modifiers::NONE, Key::Escape);
        window.press(Modifiers::NONE, Key::F1);
        assert!(window.says(tool.command().description()));
        window.press(Modifiers::NONE, Key::Escape);
    }
}
