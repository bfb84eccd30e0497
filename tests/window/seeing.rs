//! Looking closely at a picture: zoom, pan, the pixel under the mouse, the histogram.

use crate::driver::{self, Files, Window};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2};
use egui_kittest::kittest::Queryable;
use raymini::gui::inspector::Samples;
use raymini::gui::jobs::Lane;
use raymini::gui::top_bar::View;
use raymini::math::DVec3;
use raymini::scene::Background;

/// What of the picture is seen.
fn frame(window: &Window) -> Rect {
    window.harness.get_by_label("Viewport").rect()
}

fn turn_wheel(window: &mut Window, at: Pos2, lines: f32) {
    window.harness.hover_at(at);
    window.harness.run_steps(2);
    window.harness.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: Vec2::new(0.0, lines),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(30);
}

#[test]
fn the_picture_is_enlarged_and_moved_and_the_camera_stays() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let camera = window.scene().camera;
    let whole = window.app().zoom().scale();
    let place = frame(&window).center() + Vec2::new(80.0, 40.0);
    window.harness.hover_at(place);
    window.harness.run_steps(2);
    let before = window.app().inspected().unwrap().pixel;
    turn_wheel(&mut window, place, 6.0);
    turn_wheel(&mut window, place, 6.0);
    assert!(window.app().zoom().scale() > whole * 2.0);
    let after = window.app().inspected().unwrap().pixel;
    let apart = before.iter().zip(after).map(|(a, b)| a.abs_diff(b)).max();
    assert!(
        apart.unwrap() <= 1,
        "the pixel under the mouse stays: {before:?} {after:?}"
    );

    // A drag moves the picture, not the camera.
    window.drag(PointerButton::Primary, place, place - Vec2::new(60.0, 0.0));
    let moved = window.app().inspected().unwrap().pixel;
    assert_eq!(moved, after, "the pixel follows the mouse");
    window.harness.hover_at(place);
    window.harness.run_steps(2);
    assert!(window.app().inspected().unwrap().pixel[0] > after[0]);
    assert_eq!(window.scene().camera, camera);
    assert_eq!(window.app().view(), View::Picture);

    window.press(Modifiers::NONE, Key::Num4);
    assert!((window.app().zoom().scale() - 1.0).abs() < 1e-3);
    assert_eq!(frame(&window).size(), Vec2::new(160.0, 120.0));
    assert!(window.says("100 %"));
    window.press(Modifiers::NONE, Key::Plus);
    assert!((window.app().zoom().scale() - 1.5).abs() < 1e-3);
    window.press(Modifiers::NONE, Key::Minus);
    window.press(Modifiers::NONE, Key::Num3);
    assert!((window.app().zoom().scale() - whole).abs() < 1e-3);

    // At a size no texture has, everything still draws.
    for _ in 0..12 {
        window.press(Modifiers::NONE, Key::Plus);
    }
    assert!((window.app().zoom().scale() - 64.0).abs() < 1e-3);
    window.harness.render().unwrap();
    window.press(Modifiers::NONE, Key::Num1);
    let preview = frame(&window);
    turn_wheel(&mut window, preview.center(), 2.0);
    assert_ne!(
        window.scene().camera,
        camera,
        "in the preview it is the camera's"
    );
}

/// A slip of the mouse over a picture that was rendered changes nothing, and it is said where the camera moves.
#[test]
fn a_drag_over_a_whole_picture_leaves_the_scene_alone() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let scene = window.scene().clone();
    let place = frame(&window).center();
    let button = |pos, button, pressed| Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers: Modifiers::NONE,
    };
    for held in [PointerButton::Primary, PointerButton::Middle] {
        window.harness.hover_at(place);
        window.harness.run_steps(1);
        window.harness.event(button(place, held, true));
        window.harness.run_steps(1);
        let to = place + Vec2::new(70.0, 30.0);
        window.harness.hover_at(to);
        window.harness.run_steps(2);
        assert!(window.says("The camera moves in the preview (1)"));
        window.harness.event(button(to, held, false));
        window.harness.run_steps(2);
        assert!(!window.says("The camera moves in the preview"));
    }
    window.clicks_at(place, 2);
    assert_eq!(window.scene(), &scene);
    assert_eq!(window.app().view(), View::Picture);
    assert!(!window.app().document().is_modified());

    // In the preview it moves.
    window.press(Modifiers::NONE, Key::Num1);
    window.drag(PointerButton::Primary, place, place + Vec2::new(70.0, 30.0));
    assert_ne!(window.scene().camera, scene.camera);
}

#[test]
fn the_pixel_under_the_mouse_is_told() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    window.harness.hover_at(Pos2::new(5.0, 5.0));
    window.harness.run_steps(2);
    assert!(window.says("Point at the picture"));

    let picture = frame(&window);
    window.harness.hover_at(picture.center());
    window.harness.run_steps(3);
    let inspected = window.app().inspected().unwrap().clone();
    let [x, y] = inspected.pixel;
    assert!(x.abs_diff(80) <= 1 && y.abs_diff(60) <= 1, "{x} {y}");
    let image = window.app().picture().unwrap().buffer.image();
    assert_eq!(inspected.values.linear, image.pixel(x, y));
    assert!(
        inspected.values.error.is_some(),
        "the error is kept as a layer"
    );
    let surface = inspected.surface.clone().unwrap();
    assert_eq!(
        (surface.object.as_str(), surface.material.as_str()),
        ("pyramid", "clay")
    );
    assert!((4.0..9.0).contains(&surface.distance), "{surface:?}");
    assert_eq!(inspected.samples, Samples::OfEach(4));
    // A flat side that is seen from before and above.
    assert!((surface.normal.length() - 1.0).abs() < 1e-5);
    assert!(
        surface.normal.y < -0.5 && surface.normal.z > 0.3,
        "{surface:?}"
    );
    assert!(window.says(&inspected.values_in_words()));
    assert!(window.says(&inspected.surface_in_words()));

    window
        .harness
        .hover_at(picture.left_top() + Vec2::splat(4.0));
    window.harness.run_steps(3);
    assert_eq!(window.app().inspected().unwrap().surface, None);

    // In the preview, which lies where the picture does, it is the surface alone.
    let centre = picture.center();
    window.press(Modifiers::NONE, Key::Num1);
    window.harness.hover_at(centre);
    window.harness.run_steps(3);
    assert_eq!(frame(&window), picture, "nothing jumps");
    let seen = window.app().seen().unwrap().clone();
    assert_eq!(
        (seen.object.as_str(), seen.material.as_str()),
        ("pyramid", "clay")
    );
    assert!((seen.distance - surface.distance).abs() < 0.05, "{seen:?}");
    assert!(window.says(&seen.in_words()));
    window.press(Modifiers::NONE, Key::Num2);

    // The triangles are no longer those of the picture.
    window.harness.state_mut().document_mut().scene.objects[0].scale = 2.0;
    window.settle();
    window.harness.hover_at(picture.center());
    window.harness.run_steps(3);
    assert_eq!(window.app().inspected().unwrap().surface, None);
}

/// Channels change what is seen, at once and in the next render, and what is told of that, and nothing of what is saved.
#[test]
fn channels_are_seen_alone_and_as_false_colours() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let place = window.on_screen(DVec3::new(0.2, -0.4, 0.8));
    let pixel = |window: &mut Window| {
        window.harness.run_steps(10);
        let screen = window.harness.render().unwrap();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "pixels"
        )]
        let pixel = screen.get_pixel(place.x as u32, place.y as u32);
        [pixel[0], pixel[1], pixel[2]]
    };
    let choose = |window: &mut Window, name: &str| {
        window.operate("Channels");
        window.operate(name);
        window.until("it is shown", |app| !app.works_in(Lane::Encode));
    };
    let all = pixel(&mut window);
    assert!(all[0] > all[2], "clay is reddish: {all:?}");
    choose(&mut window, "Red");
    assert_eq!(pixel(&mut window), [all[0]; 3]);
    choose(&mut window, "Blue");
    assert_eq!(pixel(&mut window), [all[2]; 3]);
    assert!(!window.says("Colours of luminance in stops"));
    choose(&mut window, "False colours");
    assert!(window.says("Colours of luminance in stops"));
    let colours = pixel(&mut window);
    let linear = window.app().picture().unwrap().buffer.image();
    let frame = frame(&window);
    let share = (place - frame.min) / frame.size();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the picture"
    )]
    let [r, g, b] = linear.pixel(
        (share.x * linear.width as f32) as u32,
        (share.y * linear.height as f32) as u32,
    );
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let expected = raymini::gui::false_colors::color(luminance, &window.scene().display);
    let expected = [expected.r(), expected.g(), expected.b()];
    let is_it = |(seen, expected): (&u8, u8)| seen.abs_diff(expected) <= 2;
    assert!(
        colours.iter().zip(expected).all(is_it),
        "{colours:?}, {expected:?}"
    );

    // The inspector tells what is seen, files keep to all channels, and another render is seen in the same way.
    window.harness.hover_at(place);
    window.harness.run_steps(2);
    let told = window.app().inspected().unwrap().values.color;
    let told = [told.r(), told.g(), told.b()];
    let is_near = |(told, seen): (&u8, u8)| told.abs_diff(seen) <= 2;
    assert!(
        told.iter().zip(colours).all(is_near),
        "{told:?}, {colours:?}"
    );
    assert!(window.says(&format!("shown {} {} {}", told[0], told[1], told[2])));
    window.until_says("brighter than white");
    window.render();
    assert_eq!(pixel(&mut window), colours);
    let saved = files.path("seen.png");
    window.save_picture(&saved);
    let png = image::open(&saved).unwrap().to_rgb8();
    assert!(png.pixels().any(|p| p.0 == all), "as it always was");
}

#[test]
fn the_histogram_follows_the_exposure() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.harness.state_mut().document_mut().scene.background = Background::Constant {
        radiance: raymini::scene::Rgb::splat(0.4),
    };
    window.harness.run_steps(2);
    assert!(!window.has("Histogram"), "there is no picture yet");
    window.render();
    let none = "0 % of the picture is cut off at white";
    for (exposure, is_cut) in [(-6.0, false), (4.0, true), (-6.0, false)] {
        window
            .harness
            .state_mut()
            .document_mut()
            .scene
            .display
            .exposure = exposure;
        let deadline = std::time::Instant::now() + driver::DEADLINE;
        window.harness.run_steps(2);
        while window.has(none) == is_cut || !window.has("Histogram") {
            assert!(std::time::Instant::now() < deadline);
            window.harness.run_steps(2);
        }
    }
}

#[test]
fn a_picture_without_light_says_why_it_is_black() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    assert!(!window.says("the picture is black"));
    window
        .harness
        .state_mut()
        .document_mut()
        .scene
        .lights
        .clear();
    window.harness.run_steps(2);
    window.render();
    assert!(window.says("the picture is black: no light and no object shines"));
    let image = window.app().picture().unwrap().buffer.image();
    assert!(image.pixels.iter().all(|rgb| *rgb == [0.0; 3]));
}
