//! Tools of the preview: handles that move, turn and scale, and choosing what is sharp.

use crate::driver::{self, Files, Window};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
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

/// Takes hold of the pyramid with the tool that moves, and carries it a little.
fn carry_pyramid(window: &mut Window) -> Pos2 {
    window.click("Select pyramid");
    window.press(Modifiers::NONE, Key::G);
    let from = window.on_screen(MIDDLE);
    window.harness.hover_at(from);
    window.harness.run_steps(1);
    button(window, from, true);
    let mut at = from;
    for _ in 0..3 {
        at += Vec2::new(20.0, -15.0);
        window.harness.hover_at(at);
        window.harness.run_steps(1);
    }
    at
}

/// While something is held, keys are about that alone.
#[test]
fn no_command_disturbs_what_is_held() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.operate("Add light");
    let before = window.scene().clone();
    let at = carry_pyramid(&mut window);
    assert_ne!(window.scene().objects, before.objects);
    for (modifiers, key) in [
        (Modifiers::NONE, Key::Delete),
        (Modifiers::NONE, Key::B),
        (Modifiers::COMMAND, Key::D),
        (Modifiers::COMMAND, Key::Y),
        (Modifiers::NONE, Key::R),
    ] {
        window.press(modifiers, key);
        assert_eq!(window.scene().objects.len(), 1, "{key:?}");
        assert_eq!(window.scene().lights, before.lights, "{key:?}");
        assert!(!window.app().region().is_drawing);
    }
    // With Ctrl, which snaps, the letters are axes and no commands.
    window.press(Modifiers::COMMAND, Key::Z);
    let along = window.scene().objects[0].translate;
    assert!(along.x == 0.0 && along.y == 0.0 && along.z > 0.3, "{along}");
    window.harness.event(Event::Cut);
    window.harness.run_steps(2);
    let along = window.scene().objects[0].translate;
    assert!(
        along.x != 0.0 && along.y == 0.0 && along.z == 0.0,
        "{along}"
    );
    button(&mut window, at, false);
    window.harness.run_steps(2);
    assert_eq!(next_undo(&window).as_deref(), Some("moving pyramid"));
    undo(&mut window);
    assert_eq!(window.scene(), &before);
    window.settle();
}

/// A scene that arrives while something of the scene before is held stays as it is in its file.
#[test]
fn what_is_held_is_let_go_of_when_another_scene_arrives() {
    let files = Files::new();
    let other = driver::SCENE.replace("mesh = ", "translate = [0.0, 5.0, 0.0]\nmesh = ");
    let other = files.write("other.toml", &other);
    let mut window = Window::open(&files.path("room.toml"));
    let at = carry_pyramid(&mut window);
    window.drop_file(other.clone());
    window.harness.run_steps(3);
    window.operate("Replace");
    window.until("the other scene is there", |app| {
        app.document().name() == "other"
    });
    for step in 1..=3_u8 {
        window
            .harness
            .hover_at(at + Vec2::splat(12.0) * f32::from(step));
        window.harness.run_steps(1);
    }
    button(&mut window, at, false);
    window.harness.run_steps(2);
    assert_eq!(window.scene(), &driver::load(&other));
    window.settle();
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

#[test]
fn cameras_are_remembered_and_gone_back_to() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let home = window.scene().camera;
    window.press(Modifiers::NONE, Key::N);
    assert_eq!(window.scene().camera, home, "there is none yet");
    window.press(Modifiers::NONE, Key::M);
    assert_eq!(
        next_undo(&window).as_deref(),
        Some("adding bookmark view 1")
    );
    let middle = Pos2::new(470.0, 400.0);
    let by = Vec2::new(60.0, 25.0);
    window.drag(PointerButton::Primary, middle, middle + by);
    let second = window.scene().camera;
    window.operate("Add bookmark");
    window.enter("Name of bookmark 2", "from the side");
    let names = window.scene().bookmarks.iter().map(|b| b.name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["view 1", "from the side"]);
    assert_eq!(next_undo(&window).as_deref(), Some("changing a bookmark"));

    window.operate("Go to bookmark 1");
    assert_eq!(window.scene().camera, home);
    window.press(Modifiers::NONE, Key::N);
    assert_eq!(window.scene().camera, second);
    window.press(Modifiers::NONE, Key::N);
    assert_eq!(window.scene().camera, home, "round and round");
    window.press(Modifiers::SHIFT, Key::N);
    assert_eq!(window.scene().camera, second);
    undo(&mut window);
    assert_eq!(window.scene().camera, home);

    window.drag(PointerButton::Primary, middle, middle - by);
    let third = window.scene().camera;
    window.operate("Set bookmark 1");
    assert_eq!(window.scene().bookmarks[0].camera, third);
    window.operate("Remove bookmark 2");
    assert_eq!(
        next_undo(&window).as_deref(),
        Some("removing bookmark from the side")
    );
    assert_eq!(window.scene().bookmarks.len(), 1);

    // The scene file keeps them.
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the scene is saved", |app| !app.document().is_modified());
    let saved = driver::load(&files.path("room.toml"));
    assert_eq!(saved.bookmarks, window.scene().bookmarks);
}

#[test]
fn the_rays_of_a_clicked_pixel_are_shown() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Ray tool");
    assert!(window.says("Click a pixel to see its rays"));
    let top = window.on_screen(DVec3::new(0.2, -0.4, 0.8));
    window.click_at(top);
    let until_traced = |window: &mut Window| {
        let deadline = std::time::Instant::now() + driver::DEADLINE;
        while !window.says("sample") {
            assert!(std::time::Instant::now() < deadline, "no rays come");
            window.harness.step();
        }
    };
    until_traced(&mut window);
    assert!(window.says("sample 0 of 4"));
    assert!(window.says("2 rays: 1 camera, 1 shadow"));
    window.press(Modifiers::NONE, Key::Period);
    let deadline = std::time::Instant::now() + driver::DEADLINE;
    while !window.says("sample 1 of 4") {
        assert!(
            std::time::Instant::now() < deadline,
            "no other sample comes"
        );
        window.harness.step();
    }
    window.harness.render().unwrap();

    // From elsewhere they are still there; of another scene they are not.
    window.drag(PointerButton::Middle, top, top + Vec2::new(30.0, 0.0));
    assert!(window.says("sample 1 of 4"));
    window.click("Add light");
    assert!(window.says("Click a pixel to see its rays"));
    undo(&mut window);

    // A click in the picture shows them in the preview.
    window.render();
    assert_eq!(window.app().view(), View::Picture);
    let top = window.on_screen(DVec3::new(0.2, -0.4, 0.8));
    window.click_at(top);
    window.until("the preview is back", |app| app.view() == View::Preview);
    assert!(window.says("sample 0 of 4"));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.says("sample 0 of 4"));
}

#[test]
fn the_boxes_of_the_structure_are_shown() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let level = |window: &Window| {
        let node = window.harness.get_by_label("Level");
        (node.rect(), node.accesskit_node().is_disabled())
    };
    let (place, is_disabled) = level(&window);
    assert!(is_disabled);
    window.operate("Show boxes");
    assert_eq!(level(&window), (place, false));
    driver::set_number(&mut window, "Level", "0");
    assert!(window.says("1 box"));
    // Ten triangles are two blocks: the kd-tree divides them, and the wide tree at most once.
    window.harness.render().unwrap();
    window.operate("Show boxes");
    assert!(level(&window).1);
}

#[test]
fn steps_are_seen_in_the_picture_and_told_of_a_pixel() {
    let files = Files::new();
    let scene = driver::SCENE.replace("[render]", "[render]\nmode = \"steps\"");
    files.write("steps.toml", &scene);
    let mut window = Window::open(&files.path("steps.toml"));
    window.render();
    assert!(window.has("Colours of 0 to 255 steps"));
    let place = window.on_screen(DVec3::new(0.2, -0.4, 0.8));
    window.harness.hover_at(place);
    window.harness.run_steps(2);
    let visits = window.app().inspected().unwrap().visits.unwrap();
    assert!(visits.blocks > 0);
    let told = format!("steps {} + {}", visits.nodes, visits.blocks);
    assert!(window.says(&told));
}

/// The arrow of a turned object goes where its own axis does, once that is chosen, by key or by button.
#[test]
fn handles_go_along_axes_of_the_object_itself() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.harness.state_mut().document_mut().scene.objects[0]
        .rotate
        .z = 60.0;
    window.settle();
    window.click("Move tool");
    window.click("Select pyramid");
    let object = window.scene().objects[0].clone();
    let middle = object.placement().world_from_object(MIDDLE);
    let own = object.placement().linear * DVec3::X;
    let drag_own = |window: &mut Window| {
        let from = on_arrow(window, middle, own);
        let to = from + (window.on_screen(middle + own) - window.on_screen(middle));
        window.drag(PointerButton::Primary, from, to);
        window.scene().objects[0].translate
    };
    window.press(Modifiers::NONE, Key::W);
    assert!(window.has("Own axes"));
    let moved = drag_own(&mut window);
    assert!(
        moved.dot(own) > 0.6 && moved.cross(own).length() < 1e-9,
        "{moved}"
    );
    undo(&mut window);
    assert_eq!(window.scene().objects[0].translate, DVec3::ZERO);
    // By its button, back to those of the world.
    window.click("Own axes");
    let from = on_arrow(&window, middle, DVec3::X);
    let to = from + (window.on_screen(middle + DVec3::X) - window.on_screen(middle));
    window.drag(PointerButton::Primary, from, to);
    let moved = window.scene().objects[0].translate;
    assert!(moved.x > 0.6, "{moved}");
    assert_eq!((moved.y, moved.z), (0.0, 0.0));
}
