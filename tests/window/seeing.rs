//! Looking closely at a picture: zoom, pan, the pixel under the mouse, the histogram.

use crate::driver::{self, Files, Window};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2};
use egui_kittest::kittest::Queryable;
use raymini::gui::inspector::Samples;
use raymini::gui::top_bar::View;
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
    turn_wheel(&mut window, place, 6.0);
    let before = window.app().inspected().unwrap().pixel;
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

    // The triangles are no longer those of the picture.
    window.harness.state_mut().document_mut().scene.objects[0].scale = 2.0;
    window.settle();
    window.harness.hover_at(picture.center());
    window.harness.run_steps(3);
    assert_eq!(window.app().inspected().unwrap().surface, None);
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
