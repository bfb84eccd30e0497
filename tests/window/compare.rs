//! Two pictures against each other: wipe, flip, difference, and how far they are apart.

use crate::driver::{DEADLINE, Files, Look, SCENE, Window, set_number, set_samples};
use egui::{Key, Modifiers, PointerButton, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::analysis::{Metrics, mean_flip};
use raymini::gui::compare::{Distance, Mode};
use raymini::gui::jobs::Lane;
use raymini::render::Image;

fn distance(window: &Window) -> Distance {
    let comparison = window.app().comparison().expect("a comparison");
    *comparison.distance().unwrap().as_ref().unwrap()
}

fn measured(window: &mut Window) {
    window.until("it is measured", |app| {
        app.comparison().is_some_and(|c| c.distance().is_some())
    });
}

/// The picture of a render that is on the screen.
fn image(window: &Window) -> Image {
    window.app().picture_on_screen().unwrap().buffer.image()
}

/// What the middle of the left and the right half of the picture look like.
fn halves(window: &mut Window) -> [egui::Color32; 2] {
    let frame = window.rect("Viewport");
    [0.25, 0.75].map(|share| {
        // Below the names of both, above the pyramid.
        let place = frame.lerp_inside(Vec2::new(share, 0.22));
        let [red, green, blue] = window.color_at(place);
        egui::Color32::from_rgb(red, green, blue)
    })
}

#[test]
fn two_renders_are_compared_by_wipe_flip_and_difference() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Renders");
    window.render();
    let before = image(&window);
    window.press(Modifiers::NONE, Key::C);
    assert!(window.app().comparison().is_none(), "there is but one");
    // The same with a background.
    window.harness.state_mut().document_mut().scene.background =
        raymini::scene::Background::Constant {
            radiance: raymini::scene::Rgb::new(0.5, 0.5, 0.0),
        };
    window.harness.run_steps(2);
    window.render();
    let after = image(&window);
    window.press(Modifiers::NONE, Key::C);
    measured(&mut window);
    let metrics = Metrics::measure(&after, &before).unwrap();
    let found = distance(&window);
    assert_eq!(found.rmse, metrics.errors.rmse());
    assert_eq!(found.relmse, metrics.errors.relmse);
    assert_eq!(found.flip, Some(mean_flip(&after, &before).unwrap()));
    assert!(window.says("RMSE") && window.says("relative MSE") && window.says("FLIP 0."));
    window.harness.run_steps(5);

    // A at the left, B at the right of the divider, which the mouse moves.
    let [left, right] = halves(&mut window);
    assert!(left.r() > 100 && right.r() < 20, "{left:?} {right:?}");
    let divider = window.harness.get_by_label("Divider").rect().center();
    let frame = window.harness.get_by_label("Viewport").rect();
    let by = Vec2::new(0.4 * frame.width(), 0.0);
    let camera = window.scene().camera;
    window.drag(PointerButton::Primary, divider, divider + by);
    assert_eq!(
        window.scene().camera,
        camera,
        "the divider moves, not the camera"
    );
    let [left, right] = halves(&mut window);
    assert!(left.r() > 100 && right.r() > 100, "{left:?} {right:?}");

    window.press(Modifiers::NONE, Key::X);
    assert_eq!(window.app().comparison().unwrap().mode, Mode::Flip);
    let [left, right] = halves(&mut window);
    assert!(left.r() < 20 && right.r() < 20, "{left:?} {right:?}");
    window.press(Modifiers::NONE, Key::X);
    let [left, right] = halves(&mut window);
    assert!(left.r() > 100 && right.r() > 100, "{left:?} {right:?}");

    window.click("Compare: Difference");
    window.harness.run_steps(5);
    let [left, _] = halves(&mut window);
    assert!(left.r() > 100 && left.b() == 0, "{left:?}");
    assert!(window.says("white is"));

    // The other one is looked at: they change places.
    assert!(window.says("against 1  "));
    window.click("Show render 1");
    measured(&mut window);
    assert!(window.says("against 2  "));
    let metrics = Metrics::measure(&before, &after).unwrap();
    assert_eq!(distance(&window).rmse, metrics.errors.rmse());
    assert_eq!(distance(&window).relmse, metrics.errors.relmse);
    assert_eq!(window.app().comparison().unwrap().mode, Mode::Difference);
    // In turn too, what was clicked is what is seen.
    window.press(Modifiers::NONE, Key::X);
    assert!(window.app().comparison().unwrap().shows_other);
    window.click("Show render 2");
    assert!(window.says("against 1  "));
    window.harness.run_steps(10);
    let [left, right] = halves(&mut window);
    assert!(left.r() > 100 && right.r() > 100, "{left:?} {right:?}");
    window.click("Close");
    assert!(window.app().comparison().is_none());
}

/// Whether all of a text on the screen is to be read: it is in `room`, and as wide as its letters, or wrapped.
fn is_readable(window: &Window, part: &str, room: egui::Rect) -> bool {
    let node = window.harness.get_by_label_contains(part);
    let text = node.accesskit_node().value().unwrap_or_default();
    let font = egui::TextStyle::Body.resolve(&window.harness.ctx.global_style());
    let ink = egui::Color32::WHITE;
    let galley = window
        .harness
        .ctx
        .fonts_mut(|fonts| fonts.layout_no_wrap(text, font, ink));
    let rect = node.rect();
    let is_whole = rect.width() + 1.0 >= galley.size().x;
    room.contains_rect(rect) && (is_whole || rect.height() > 1.8 * galley.size().y)
}

/// In a window as small as it gets, and in one of the usual size, all three figures are to be read.
#[test]
fn how_far_two_pictures_are_apart_can_be_read_in_any_window() {
    let files = Files::new();
    for size in [Vec2::new(1280.0, 800.0), Vec2::new(800.0, 520.0)] {
        let look = Look {
            size,
            ..Look::default()
        };
        let mut window = Window::start_as(vec![files.path("room.toml")], &look, None);
        window.render();
        window.operate("Add light");
        window.render();
        window.press(Modifiers::NONE, Key::C);
        measured(&mut window);
        window.harness.run_steps(3);
        let bar = window.rect("Close").union(window.rect("Compare: Wipe"));
        let room = bar.with_max_y(bar.bottom() + 60.0).expand(4.0);
        for figure in ["RMSE", "MSE ", "FLIP 0."] {
            assert!(is_readable(&window, figure, room), "{figure} at {size}");
        }
        // Beside the name of the scene, which has changed, is the switch Live.
        let mark = window.rect("• not saved");
        assert!(mark.right() <= window.rect("Live").left(), "at {size}");
    }
}

/// What is told of a pixel is what is seen there, whichever of both pictures that is.
#[test]
fn what_is_told_of_a_pixel_is_what_is_seen() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.harness.state_mut().document_mut().scene.background =
        raymini::scene::Background::Constant {
            radiance: raymini::scene::Rgb::new(0.5, 0.5, 0.0),
        };
    window.settle();
    window.render();
    // Two pixels, which are stretched over the picture: the right one is blue.
    let halves = image::RgbImage::from_fn(2, 1, |x, _| {
        image::Rgb([0, 0, if x == 0 { 20 } else { 200 }])
    });
    halves.save(files.path("halves.png")).unwrap();
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&files.path("halves.png"));
    measured(&mut window);
    window.harness.run_steps(5);
    let frame = window.rect("Viewport");
    let is_told = |window: &mut Window, share: f32| {
        let place = frame.lerp_inside(Vec2::new(share, 0.12));
        window.harness.hover_at(place);
        window.harness.run_steps(2);
        let told = window.app().inspected().unwrap().seen.color().unwrap();
        // The pointer itself is drawn to the right and below.
        let seen = window.color_at(place - Vec2::splat(4.0));
        let is_near = |(told, seen): (&u8, u8)| told.abs_diff(seen) <= 1;
        let told_channels = [told.r(), told.g(), told.b()];
        assert!(
            told_channels.iter().zip(seen).all(is_near),
            "{told:?}, {seen:?} at {share}"
        );
        window.app().inspected().unwrap().values_in_words()
    };
    // By the divider, A at the left and B at the right.
    assert!(!is_told(&mut window, 0.3).contains("the other"));
    assert!(is_told(&mut window, 0.9).contains("shown 0 0 200, the other"));
    window.press(Modifiers::NONE, Key::X);
    assert!(is_told(&mut window, 0.3).contains("shown 0 0 20, the other"));
    assert!(is_told(&mut window, 0.9).contains("shown 0 0 200, the other"));
    window.press(Modifiers::NONE, Key::X);
    assert!(!is_told(&mut window, 0.9).contains("the other"));

    // The difference is that of two renders.
    window.press(Modifiers::NONE, Key::C);
    window.operate("Add light");
    window.render();
    window.press(Modifiers::NONE, Key::C);
    window.click("Compare: Difference");
    measured(&mut window);
    window.harness.run_steps(5);
    assert!(is_told(&mut window, 0.5).contains("the difference"));
}

/// However large a picture is, another exposure is seen everywhere in it at once, if not as sharp.
#[test]
fn another_exposure_is_seen_everywhere_at_once() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let flat = image::RgbImage::from_pixel(2200, 1500, image::Rgb([100; 3]));
    flat.save(files.path("flat.png")).unwrap();
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&files.path("flat.png"));
    window.until("the other picture is there", |app| {
        app.comparison().is_some() && !app.works_in(Lane::EncodeOther)
    });
    window.press(Modifiers::NONE, Key::X);
    window.harness.run_steps(60);
    let frame = window.rect("Viewport");
    let rows = |window: &mut Window| {
        let screen = window.harness.render().unwrap();
        [0.12, 0.3, 0.6, 0.97].map(|share| {
            let place = frame.lerp_inside(Vec2::new(0.5, share));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "pixels"
            )]
            let pixel = screen.get_pixel(place.x as u32, place.y as u32);
            pixel.0[0]
        })
    };
    let mut before = rows(&mut window)[0];
    for exposure in [2.0, -1.0] {
        let scene = &mut window.harness.state_mut().document_mut().scene;
        scene.display.exposure = exposure;
        let mut looks = vec![before];
        let mut frames_after = 0;
        let deadline = std::time::Instant::now() + DEADLINE;
        while frames_after < 20 {
            assert!(std::time::Instant::now() < deadline);
            window.harness.step();
            let seen = rows(&mut window);
            assert!(seen.iter().all(|&row| row == seen[0]), "{seen:?}");
            if looks.last() != Some(&seen[0]) {
                looks.push(seen[0]);
            }
            frames_after += usize::from(looks.len() > 1);
        }
        assert_eq!(looks.len(), 2, "{looks:?}");
        before = looks[1];
    }
}

/// The divider follows the arrow keys, also when another control was used last.
#[test]
fn the_divider_is_moved_by_keys() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    window.render();
    window.press(Modifiers::NONE, Key::C);
    let at = |window: &Window| window.rect("Divider").center().x;
    let middle = at(&window);
    window.press(Modifiers::NONE, Key::ArrowRight);
    let right = at(&window);
    assert!(right > middle + 5.0);
    window.press(Modifiers::NONE, Key::ArrowLeft);
    window.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(at(&window) < middle - 5.0);
    window.harness.get_by_label("Divider").focus();
    window.harness.run_steps(2);
    window.press(Modifiers::NONE, Key::ArrowRight);
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert!((at(&window) - right).abs() < 1.5, "it keeps the keys");
}

/// Red along a row of the screen, a little below the middle of the picture.
fn row(window: &mut Window) -> Vec<u8> {
    let middle = window.rect("Viewport").center();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "pixels"
    )]
    let [x, y] = [middle.x as u32, middle.y as u32 + 20];
    let screen = window.harness.render().unwrap();
    let columns = x - 200..x + 200;
    columns.map(|x| screen.get_pixel(x, y).0[0]).collect()
}

/// At 100 %, each of its pixels is one of the screen, also beside the edge between two textures, which is in the middle.
#[test]
fn a_picture_wider_than_a_texture_is_seen_to_the_pixel() {
    let files = Files::new();
    let small = "width = 160\nheight = 120\nsamples_per_pixel = 4";
    assert!(SCENE.contains(small));
    let wide = SCENE.replace(small, "width = 8000\nheight = 80\nsamples_per_pixel = 1");
    let mut window = Window::open(&files.write("wide.toml", &wide));
    window.render();
    assert!(!window.says("shown at 1/"));

    // Each pixel is brighter by 37 than the one at its left, modulo 256.
    let shade = |x: u32| u8::try_from(x * 37 % 256).unwrap();
    let stripes = image::RgbImage::from_fn(8000, 80, |x, _| image::Rgb([shade(x); 3]));
    stripes.save(files.path("stripes.png")).unwrap();
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&files.path("stripes.png"));
    window.until("both pictures are there", |app| {
        app.comparison().is_some() && !app.works_in(Lane::EncodeOther)
    });
    window.press(Modifiers::NONE, Key::X);
    window.press(Modifiers::NONE, Key::Num4);
    // Each frame has time for a texture at least, of eight.
    window.harness.run_steps(10);
    let seen = row(&mut window);
    for pair in seen.windows(2) {
        let beyond = pair[1].wrapping_sub(pair[0]).wrapping_sub(37);
        assert!(beyond.wrapping_add(3) <= 6, "{pair:?} in {seen:?}");
    }
}

#[test]
fn a_picture_is_compared_with_an_image_file() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let exr = files.path("reference.exr");
    window.save_picture(&exr);
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&exr);
    measured(&mut window);
    assert_eq!(distance(&window).differing_pixels, 0);
    assert!(window.says("reference.exr"));
    window.press(Modifiers::NONE, Key::C);
    assert!(window.app().comparison().is_none());

    // Of another size: both are shown, and it is said why there is no number.
    image::RgbImage::new(7, 5)
        .save(files.path("small.png"))
        .unwrap();
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&files.path("small.png"));
    measured(&mut window);
    assert!(window.says("the sizes differ"));
    window.click("Compare: Difference");

    let broken = files.write("broken.png", "no picture");
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&broken);
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    assert_eq!(window.app().messages().banners()[0].title, "Cannot compare");
    // It is no longer so once something is compared.
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&exr);
    window.until("it is compared", |app| app.messages().banners().is_empty());
    assert!(window.says("reference.exr"));
}

/// A PNG holds what a screen showed: what exposure and tone curve have made of the light there is no difference, and what is shown of it stays.
#[test]
fn a_render_is_as_near_to_the_png_saved_of_it_as_bytes_are_fine() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.harness.state_mut().document_mut().scene.background =
        raymini::scene::Background::Constant {
            radiance: raymini::scene::Rgb::new(0.5, 0.2, 3.0),
        };
    window.operate("Tone curve: ACES");
    set_number(&mut window, "Exposure", "1");
    window.settle();
    window.render();
    let png = files.path("shown.png");
    window.save_picture(&png);
    window.press(Modifiers::SHIFT, Key::C);
    window.enter_path(&png);
    measured(&mut window);
    // Half of a byte's step where the sRGB curve is steepest: 2.4 / 1.055 at white.
    let half_a_step = 0.5 / 255.0 * 2.4 / 1.055;
    let found = distance(&window);
    assert!(found.rmse > 0.0 && found.rmse < half_a_step, "{found:?}");
    assert!(window.says("exposure 1 stop, tone curve ACES"));

    window.press(Modifiers::NONE, Key::X);
    window.harness.run_steps(10);
    let seen = halves(&mut window);
    let frame = window.rect("Viewport");
    window
        .harness
        .hover_at(frame.lerp_inside(Vec2::new(0.3, 0.22)));
    window.harness.run_steps(2);
    let told = window.app().inspected().unwrap().values_in_words();
    assert!(
        told.contains(", the other") && !told.contains("other 0"),
        "{told}"
    );
    set_number(&mut window, "Exposure", "-3");
    window.until("it is shown", |app| !app.works_in(Lane::EncodeOther));
    window.harness.run_steps(10);
    assert_eq!(halves(&mut window), seen);
}

/// A render that still runs is measured again and again, so its error against a reference falls on the screen.
#[test]
fn a_running_render_is_compared_until_it_is_done() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    set_samples(&mut window, 400);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.press(Modifiers::NONE, Key::C);
    window.until("the picture is finished", |app| {
        !app.picture().unwrap().is_running()
    });
    let reference = window.app().renders().picture(1).unwrap().buffer.image();
    let expected = Metrics::measure(&image(&window), &reference).unwrap();
    window.until("the finished picture is measured", |app| {
        let found = app.comparison().and_then(|c| c.distance());
        found.is_some_and(|d| d.as_ref().is_ok_and(|d| d.rmse == expected.errors.rmse()))
    });
}

/// A picture that still changes is not one to compare with: whoever looks at the other one sees that alone.
#[test]
fn the_other_picture_is_looked_at_alone_while_the_first_is_rendered() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Renders");
    window.render();
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture()
            .is_some_and(|p| p.is_running() && p.first_tile.is_some())
    });
    window.press(Modifiers::NONE, Key::C);
    assert!(window.app().comparison().is_some());
    window.click("Show render 1");
    assert!(window.app().comparison().is_none());
    assert_eq!(window.app().picture_on_screen().unwrap().number, 1);
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
}
