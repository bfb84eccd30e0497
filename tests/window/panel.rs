//! The side panel with names and numbers that nobody foresaw, and what the list and the tools do about what is added and selected.

use crate::driver::{Files, SCENE, Window, set_number};
use egui::{Key, Modifiers, PointerButton, Pos2, accesskit::Toggled};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::math::DVec3;
use raymini::scene::{Light, Object};

/// Letters that have no room in a row of the list.
const LONG: &str = "a name of forty-seven letters that has no room!!";

/// Whether both are the same but for a point of the width of a text.
fn is_about(a: egui::Rect, b: egui::Rect) -> bool {
    a.min == b.min && (a.max - b.max).length() < 1.5
}

#[test]
fn neither_long_names_nor_long_numbers_widen_the_panel() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    let field = window.rect("Position X");
    window.enter("Name", LONG);
    window.settle();
    assert_eq!(window.scene().objects[0].name, LONG);
    for number in ["12345678.123456789", "1e300", "-1e-300", "123456789012"] {
        set_number(&mut window, "Position X", number);
        assert!(is_about(window.rect("Position X"), field), "{number}");
    }
    window.click("Select Light 1");
    let field = window.rect("Intensity amount");
    set_number(&mut window, "Intensity amount", "1e300");
    assert!(is_about(window.rect("Intensity amount"), field));
}

#[test]
fn numbers_are_typed_as_sums_and_what_is_none_is_refused_with_a_word() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    let intensity = |window: &Window| match window.scene().lights[0] {
        Light::Point { intensity, .. } => intensity,
        Light::Disk { .. } => panic!("a point light"),
    };
    set_number(&mut window, "Intensity amount", "2*3");
    assert_eq!(intensity(&window), DVec3::splat(6.0));
    for refused in ["nan", "1e400", "7 apples", "2*"] {
        set_number(&mut window, "Intensity amount", refused);
        assert_eq!(intensity(&window), DVec3::splat(6.0), "{refused}");
        assert!(window.says("is not a number"), "{refused}");
    }
    set_number(&mut window, "Samples", "nan");
    assert_eq!(window.scene().render.samples_per_pixel, 4);
}

/// A row without anything to read could not be told from a gap.
#[test]
fn a_name_of_spaces_is_none() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    window.enter("Name", "   ");
    window.click("Select Light 1");
    window.enter("Name", "  ");
    window.settle();
    assert!(window.has("Select Object 1"));
    assert!(window.has("Select Light 1"));
}

/// The ball of the material shows the image; why the object does not is told beside it.
#[test]
fn an_image_that_does_not_show_is_told_of() {
    let files = Files::new();
    let paint = image::RgbImage::from_pixel(2, 2, image::Rgb([200, 30, 30]));
    paint.save(files.path("paint.png")).unwrap();
    let painted = "diffuse_image = \"paint.png\"\n\n[[objects]]";
    let scene = SCENE.replace("[[objects]]", painted);
    let mut window = Window::open(&files.write("painted.toml", &scene));
    let told = "an image, but the mesh has no texture coordinates: it does not show here";
    assert!(!window.says(told));
    window.click("Select pyramid");
    assert!(window.says(told));
}

/// Numbers are shown short, but going through their fields changes nothing.
#[test]
fn a_field_that_is_only_looked_at_keeps_every_digit() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let exact = 0.123_456_789_012_345_67;
    window.harness.state_mut().document_mut().scene.camera.eye.x = exact;
    window.settle();
    window.harness.get_by_label("Eye X").focus();
    window.harness.run_steps(2);
    window.press(Modifiers::NONE, Key::Tab);
    window.harness.run_steps(2);
    assert_eq!(window.scene().camera.eye.x.to_bits(), exact.to_bits());
}

#[test]
fn the_list_scrolls_to_what_it_added() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let scene = &mut window.harness.state_mut().document_mut().scene;
    let like = scene.objects[0].clone();
    scene.objects = (0..40)
        .map(|index| Object {
            name: format!("part {index}"),
            ..like.clone()
        })
        .collect();
    window.settle();
    let in_sight = |window: &Window, name: &str| {
        let list = window.rect("Scene").bottom()..window.rect("Scene").bottom() + 340.0;
        list.contains(&window.rect(name).center().y)
    };
    assert!(!in_sight(&window, "Select Light 1"));
    window.operate("Add light");
    window.harness.run_steps(60);
    assert!(in_sight(&window, "Select Light 2"));
    // The group of materials is folded.
    window.operate("Add material");
    window.harness.run_steps(60);
    assert!(in_sight(&window, "Select material"));
    assert!(window.has("Ball of material"), "it is selected");
}

/// What is drawn in the picture, and what is switched on, moves nothing in the panel: the next click hits what it was aimed at.
#[test]
fn neither_a_region_nor_boxes_move_what_is_below_them() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let places =
        |window: &Window| ["Threads", "Show boxes", "Shadows: Soft"].map(|name| window.rect(name));
    let before = places(&window);
    window.operate("Show boxes");
    window.settle();
    let frame = window.rect("Viewport");
    window.press(Modifiers::NONE, Key::B);
    let [from, to] = [0.25, 0.75].map(|share| frame.lerp_inside(egui::Vec2::splat(share)));
    window.drag(PointerButton::Primary, from, to);
    assert!(window.app().region().is_chosen());
    assert!(window.says(" box"), "they are counted");
    assert_eq!(places(&window), before);
    window.click("Select Camera");
    window.press(Modifiers::SHIFT, Key::B);
    assert_eq!(places(&window), before);
    // The numbers that are always there make a region of the whole picture.
    set_number(&mut window, "Region left", "40");
    let part = window.app().region().part([160, 120]);
    assert_eq!((part.region.x, part.region.width), (40, 120));
}

/// The room for what is told of the structure is there before the structure.
#[test]
fn the_structure_that_is_built_moves_nothing() {
    let files = Files::new();
    let height = |window: &Window| window.rect("Show boxes").top() - window.rect("Seed").top();
    let nothing = Window::open(&files.write("nothing.toml", "[render]\nwidth = 64\n"));
    assert!(nothing.says("none is built yet"));
    let room = Window::open(&files.path("room.toml"));
    assert!(!room.says("none is built yet"));
    assert_eq!(height(&room), height(&nothing));
}

#[test]
fn escape_gives_up_the_tool_before_the_selection() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    window.press(Modifiers::NONE, Key::G);
    let is_moving = |window: &Window| {
        let node = window.harness.get_by_label("Move tool");
        node.accesskit_node().toggled() == Some(Toggled::True)
    };
    assert!(is_moving(&window));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!is_moving(&window) && window.has("Duplicate object"));
    window.press(Modifiers::NONE, Key::G);
    assert!(is_moving(&window), "the key takes the tool up again");
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.has("Duplicate object"));
}

#[test]
fn the_focus_tool_offers_to_open_the_lens() {
    let files = Files::new();
    let path = files.write("room.toml", &format!("{SCENE}depth_of_field = false\n"));
    let mut window = Window::open(&path);
    window.press(Modifiers::NONE, Key::D);
    assert!(window.says("the lens radius is 0"));
    window.click("Open the lens");
    assert!(window.scene().camera.aperture_radius > 0.0);
    assert!(window.scene().render.depth_of_field);
    assert!(!window.has("Open the lens") && window.says("Orange is blurred"));
}

#[test]
fn handles_out_of_sight_are_told_of() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    window.press(Modifiers::NONE, Key::G);
    assert!(!window.says("out of sight"));
    set_number(&mut window, "Position X", "40");
    window.settle();
    assert!(window.says("The handles are out of sight"));
}

/// A point on an edge of the box along the object's own axes is drawn on, and that of the box along the world's is not.
#[test]
fn the_box_around_a_turned_object_is_turned_with_it() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    set_number(&mut window, "Rotation Z", "45");
    window.settle();
    // The mesh reaches from (-1, -1, 0) to (3, 1, 1.5).
    let half = 0.5_f64.sqrt();
    let turned = |x: f64, y: f64, z: f64| DVec3::new((x - y) * half, (x + y) * half, z);
    let edge = window.on_screen(turned(1.4, -1.0, 1.5));
    // A corner of the box along the axes of the world.
    let off = window.on_screen(DVec3::new(-2.0 * half, 4.0 * half, 1.5));
    assert!(is_accented(&mut window, edge));
    assert!(!is_accented(&mut window, off));
}

/// Whether one of the pixels around `place` has the colour of what is selected.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "pixels of the screen"
)]
fn is_accented(window: &mut Window, place: Pos2) -> bool {
    let screen = window.harness.render().unwrap();
    let (x, y) = (place.x as i32, place.y as i32);
    let near = (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (x + dx, y + dy)));
    let mut colors = near.map(|(x, y)| screen.get_pixel(x as u32, y as u32).0);
    colors.any(|[r, _, b, _]| i32::from(b) - i32::from(r) > 70)
}
