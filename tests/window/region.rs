//! Renders that rest, and renders of a part of the picture, in the window.

use std::time::{Duration, Instant};

use crate::driver::{Files, Window, library_hash, set_number, set_samples};
use egui::{Key, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::control::CancelToken;
use raymini::gui::App;
use raymini::gui::picture::{Outcome, Picture};
use raymini::gui::threads::cores;
use raymini::gui::top_bar::View;
use raymini::render::{Image, PreparedScene, Region, RenderProgress, RunConfig, render};
use raymini::scene::Scene;

fn picture(window: &Window) -> &Picture {
    window.app().picture().expect("a picture")
}

/// What the library makes of `region` of `scene`.
fn library_picture(scene: &Scene, region: Option<Region>) -> Image {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    let prepared = prepared.unwrap().unwrap();
    let (run, progress) = (RunConfig::default(), RenderProgress::default());
    let outcome = render(&prepared, region, &run, &progress, None);
    outcome.unwrap().image
}

fn start_long_render(window: &mut Window, samples: u32) {
    set_samples(window, samples);
    window.click("Render");
    window.until("the render goes on", |app| {
        app.picture()
            .is_some_and(|p| p.first_tile.is_some() && p.progress.samples.done() > 0)
    });
}

/// Starts a render that has something to show and pauses it before it ends, however fast the machine is.
fn start_and_pause(window: &mut Window) {
    for samples in [200, 800, 3_200, 12_800, 51_200] {
        start_long_render(window, samples);
        window.press(Modifiers::NONE, Key::P);
        if picture(window).is_paused() {
            return;
        }
    }
    panic!("every render ended before it could be paused");
}

fn is_over(app: &App) -> bool {
    app.picture().is_some_and(|picture| !picture.is_running())
}

#[test]
fn a_render_rests_goes_on_and_ends_with_the_same_bits() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_and_pause(&mut window);
    assert!(window.says("Paused: 160 × 120") && window.has("Resume"));
    std::thread::sleep(Duration::from_millis(60));
    let elapsed = picture(&window).elapsed();
    let (done, share) = {
        let samples = &picture(&window).progress.samples;
        (samples.done(), samples.fraction())
    };
    let started = Instant::now();
    while started.elapsed() < Duration::from_millis(300) {
        window.harness.step();
    }
    assert_eq!(picture(&window).progress.samples.done(), done);
    assert_eq!(picture(&window).elapsed(), elapsed, "the time stands still");
    assert!(share > 0.0 && share < 1.0);
    window.click("Resume");
    assert!(!picture(&window).is_paused());
    window.until("the render ends", is_over);
    assert_eq!(window.hash(), library_hash(window.scene()));
    assert!(picture(&window).elapsed() >= elapsed);
}

/// What the status bar says of a render.
fn told(window: &Window) -> String {
    let line = window
        .harness
        .query_all_by_label_contains("160 × 120")
        .next();
    let line = line.expect("it is told of");
    // Where a label keeps its text.
    line.accesskit_node().value().unwrap_or_default()
}

/// How long it still takes is said while it runs, and stands still while it rests.
#[test]
fn the_time_that_is_left_is_told_and_stands_still_in_a_pause() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window, 100_000);
    assert!(told(&window).starts_with("Rendering"));
    window.until("the rest is known", |app| {
        app.picture().is_some_and(|p| p.remaining().is_some())
    });
    assert!(told(&window).contains(" left"), "{}", told(&window));
    window.press(Modifiers::NONE, Key::P);
    assert!(picture(&window).is_paused());
    // What was begun is a few samples, however long they take.
    let done = |window: &Window| picture(window).progress.samples.done();
    let mut before = done(&window);
    loop {
        std::thread::sleep(Duration::from_millis(100));
        let now = done(&window);
        if std::mem::replace(&mut before, now) == now {
            break;
        }
    }
    window.harness.run_steps(2);
    let (words, left) = (told(&window), picture(&window).remaining());
    assert!(
        words.starts_with("Paused:") && words.contains(" left"),
        "{words}"
    );
    assert!(left.is_some());
    std::thread::sleep(Duration::from_millis(300));
    window.harness.run_steps(2);
    assert_eq!((told(&window), picture(&window).remaining()), (words, left));
    window.press(Modifiers::NONE, Key::P);
    window.harness.run_steps(2);
    assert!(told(&window).starts_with("Rendering") && told(&window).contains(" left"));
    window.press(Modifiers::NONE, Key::Escape);
}

/// Keys and mouse take a core from the render, and give it back as soon as nobody uses them.
#[test]
fn a_core_is_left_to_whoever_works_in_the_window() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window, 100_000);
    let allowed = |app: &App| app.picture().expect("a picture").throttle().allowed();
    // Where there is but one core, none can be spared.
    let left_over = match cores() {
        1 => usize::MAX,
        cores => cores - 1,
    };
    let frame = window.rect("Viewport");
    for by_key in [true, false] {
        window.just_until("nobody works in the window", |app| {
            allowed(app) == usize::MAX
        });
        if by_key {
            // It means nothing to the window.
            window.harness.key_press(Key::K);
        } else {
            window.harness.hover_at(frame.center());
        }
        window.harness.step();
        assert_eq!(allowed(window.app()), left_over, "by key: {by_key}");
    }
    assert!(picture(&window).is_running());
    window.press(Modifiers::NONE, Key::Escape);
}

/// A paused render goes on as it was when it was started; what was edited meanwhile shows with the next.
#[test]
fn edits_in_a_pause_change_nothing_about_the_render_that_goes_on() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_and_pause(&mut window);
    let scene = window.scene().clone();
    window.operate("Add light");
    window.harness.run_steps(5);
    assert!(picture(&window).is_paused(), "it is not started anew");
    assert!(window.says("Resume goes on without, F5 restarts"));
    window.click("Resume");
    window.until("the render ends", is_over);
    assert_eq!(window.hash(), library_hash(&scene));
    let as_it_was = window.hash();
    window.render();
    assert_ne!(window.hash(), as_it_was);
    assert_eq!(window.hash(), library_hash(window.scene()));

    // An edit after the pause starts it anew, as ever.
    start_long_render(&mut window, 100_000);
    window.click("Pause");
    window.click("Resume");
    window.operate("Remove light");
    window.harness.run_steps(5);
    assert_eq!(picture(&window).scene.lights.len(), 1);
}

#[test]
fn a_paused_render_is_cancelled_and_replaced() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window, 100_000);
    window.click("Pause");
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(picture(&window).outcome, Outcome::Cancelled);
    window.until("threads have stopped", |app| app.render_threads() == 0);

    start_long_render(&mut window, 100_000);
    window.click("Pause");
    set_samples(&mut window, 2);
    window.press(Modifiers::NONE, Key::F5);
    window.until("the render ends", is_over);
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.until("threads have stopped", |app| app.render_threads() == 0);

    // One that rests does so beside another scene, until that is rendered.
    start_long_render(&mut window, 100_000);
    window.click("Pause");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.click("Replace");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    window.settle();
    assert!(picture(&window).is_paused());
    let render = &mut window.harness.state_mut().document_mut().scene.render;
    (render.width, render.height) = (64, 48);
    window.press(Modifiers::NONE, Key::F5);
    window.until("the render ends", |app| {
        let width = app.picture().map(|picture| picture.scene.render.width);
        width == Some(64) && is_over(app)
    });
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.until("threads have stopped", |app| app.render_threads() == 0);
}

/// The region is drawn over the preview, shows in its place, is saved alone, and has the pixels of the whole.
#[test]
fn a_region_has_the_pixels_of_the_whole_picture() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let whole = library_picture(window.scene(), None);
    let frame = window.rect("Viewport");
    let at =
        |x: f32, y: f32| -> Pos2 { frame.min + egui::vec2(x / 160.0, y / 120.0) * frame.size() };
    window.press(Modifiers::NONE, Key::B);
    assert!(window.app().region().is_drawing);
    let before = window.scene().camera;
    window.drag(PointerButton::Primary, at(100.0, 90.0), at(40.0, 30.0));
    assert_eq!(window.scene().camera, before, "the mouse drew");
    assert!(!window.app().region().is_drawing, "and is free again");
    let region = Region {
        x: 40,
        y: 30,
        width: 60,
        height: 60,
    };
    assert_eq!(window.app().region().part([160, 120]).region, region);

    window.render();
    assert_eq!(window.app().view(), View::Picture);
    let made = picture(&window).buffer.image();
    assert_eq!((made.width, made.height), (60, 60));
    for y in 0..60 {
        for x in 0..60 {
            assert_eq!(made.pixel(x, y), whole.pixel(x + 40, y + 30));
        }
    }
    assert_eq!(
        window.hash(),
        library_picture(window.scene(), Some(region)).hash(),
        "that of `raymini render --region`"
    );
    let samples = &picture(&window).progress.samples;
    assert_eq!(samples.total(), 60 * 60 * 4, "what is left is the region's");
    assert!(window.says("60 × 60 of 160 × 120"));

    // Saving writes the region.
    let png = files.path("region.png");
    window.save_picture(&png);
    assert_eq!(image::open(&png).unwrap().to_rgb8().dimensions(), (60, 60));

    // It keeps what it shows at another size, can be typed, and is cleared.
    window.operate("Scene");
    // On the way there it may be a single pixel.
    for (width, height) in [("1", "1"), ("320", "240")] {
        set_number(&mut window, "Width", width);
        set_number(&mut window, "Height", height);
    }
    let part = window.app().region().part([320, 240]);
    assert_eq!((part.region.x, part.region.width), (80, 120));
    set_number(&mut window, "Region width", "1000");
    let part = window.app().region().part([320, 240]);
    assert_eq!((part.region.x, part.region.width), (80, 240));
    window.click("Clear region");
    assert!(!window.app().region().is_chosen());
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));

    // Nothing of it was an edit of the scene but the size.
    for _ in 0..4 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert!(!window.app().document().is_modified());
}

/// The file of a region tells where it lies, and is compared there with the whole picture.
#[test]
fn the_file_of_a_region_is_compared_where_it_lies() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let frame = window.rect("Viewport");
    let at =
        |x: f32, y: f32| -> Pos2 { frame.min + egui::vec2(x / 160.0, y / 120.0) * frame.size() };
    window.press(Modifiers::NONE, Key::B);
    window.drag(PointerButton::Primary, at(100.0, 90.0), at(40.0, 30.0));
    window.render();
    let paths = ["region.exr", "region.png"].map(|name| files.path(name));
    for path in &paths {
        window.save_picture(path);
    }
    window.press(Modifiers::SHIFT, Key::B);
    window.render();
    assert_eq!(picture(&window).buffer.image().width, 160);
    for path in &paths {
        window.press(Modifiers::SHIFT, Key::C);
        window.enter_path(path);
        window.until("it is measured", |app| {
            let comparison = app.comparison();
            comparison.is_some_and(|comparison| comparison.distance().is_some())
        });
        assert!(window.says("over 60 × 60 that both show"), "{path:?}");
        let comparison = window.app().comparison().unwrap();
        let found = comparison.distance().unwrap().as_ref().unwrap();
        // A byte is at most 1/255 off.
        assert!(found.rmse < 1.0 / 255.0, "{found:?} of {path:?}");
        // Beside the region there is nothing of it, right of the divider.
        window.harness.hover_at(at(130.0, 10.0));
        window.harness.run_steps(2);
        let told = window.app().inspected().unwrap().values_in_words();
        assert!(told.contains("nothing shown here"), "{told}");
        window.press(Modifiers::NONE, Key::C);
    }
}

/// A region that begins or ends beside the picture goes to its edge.
#[test]
fn a_region_is_drawn_from_beside_the_picture() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let frame = window.rect("Viewport");
    let before = window.scene().clone();
    let beside = frame.left_top() - egui::vec2(0.0, 8.0);
    window.press(Modifiers::NONE, Key::B);
    window.drag(PointerButton::Primary, beside, frame.center());
    let region = window.app().region().part([160, 120]).region;
    assert_eq!((region.x, region.y), (0, 0));
    assert!(region.width.abs_diff(80) <= 1 && region.height.abs_diff(60) <= 1);
    assert!(!window.app().region().is_drawing);

    // Another drag, after the tool went away, is no edit.
    window.drag(PointerButton::Primary, frame.center(), beside);
    assert_eq!(window.app().region().part([160, 120]).region, region);
    assert_eq!(window.scene(), &before);
    assert_eq!(window.app().view(), View::Picture);
}

/// Its size and place are part of what an earlier render is gone back to, and it is compared with what a whole picture shows there.
#[test]
fn a_region_is_restored_and_compared_with_the_whole() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let frame = window.rect("Viewport");
    window.press(Modifiers::NONE, Key::B);
    let quarter = frame.min + frame.size() / 4.0;
    window.drag(PointerButton::Primary, quarter, frame.center());
    window.render();
    assert!(picture(&window).name.ends_with(", region"));
    let part = picture(&window).buffer.part();
    assert!(!part.is_whole());
    window.press(Modifiers::NONE, Key::C);
    window.until("the distance is known", |app| {
        app.comparison().is_some_and(|c| c.distance().is_some())
    });
    let size = format!("{} × {}", part.region.width, part.region.height);
    assert!(window.says(&format!(
        "the same, bit for bit  ·  over {size} that both show"
    )));
    window.press(Modifiers::NONE, Key::C);
    window.press(Modifiers::SHIFT, Key::B);
    assert!(!window.app().region().is_chosen());
    window.press(Modifiers::NONE, Key::F6);
    window.click("Restore settings");
    assert_eq!(window.app().region().part([160, 120]), part);

    // Esc in the middle of drawing leaves what was there, and nothing is drawn when the tool is taken again.
    let at = |x: f32, y: f32| frame.min + frame.size() * egui::vec2(x, y);
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.press(Modifiers::NONE, Key::B);
    window.harness.hover_at(at(0.6, 0.6));
    window.harness.run_steps(1);
    window.harness.event(button(at(0.6, 0.6), true));
    window.harness.run_steps(1);
    window.harness.hover_at(at(0.9, 0.9));
    window.harness.run_steps(2);
    assert_ne!(window.app().region().part([160, 120]), part);
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.app().region().part([160, 120]), part);
    window.press(Modifiers::NONE, Key::B);
    window.harness.hover_at(at(0.8, 0.7));
    window.harness.run_steps(2);
    assert_eq!(window.app().region().part([160, 120]), part);
    window.harness.event(button(at(0.8, 0.7), false));
    window.harness.run_steps(2);
    window.press(Modifiers::NONE, Key::Escape);

    // Esc puts the tool away, and a click with it takes all of the picture.
    window.press(Modifiers::NONE, Key::B);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.app().region().is_drawing && window.app().region().is_chosen());
    window.press(Modifiers::NONE, Key::B);
    let center = window.rect("Region to render").center();
    window.click_at(center);
    assert!(!window.app().region().is_chosen());
}

/// The time of a render is told when it is asked for, by name or by the mouse that rests on Render, and only of the scene as it is.
#[test]
fn the_time_of_a_render_is_told_when_asked_for() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    assert!(window.has("How long?"));
    assert_eq!(window.app().estimated_time(), None);
    window.click("How long?");
    window.until("the time is known", |app| app.estimated_time().is_some());
    let short = window.app().estimated_time().unwrap();
    assert!(!short.is_bound && short.seconds.value > 0.0);
    assert!(short.seconds.contains(short.seconds.value) && !window.has("How long?"));

    // A thousand times the samples take longer, and that is another question.
    set_samples(&mut window, 4_000);
    assert_eq!(window.app().estimated_time(), None);
    let render = window.rect("Render").center();
    window.harness.hover_at(render);
    window.until("the time is known", |app| app.estimated_time().is_some());
    let long = window.app().estimated_time().unwrap();
    assert!(long.seconds.value > 20.0 * short.seconds.value);

    // What was rendered is known without asking.
    set_samples(&mut window, 2);
    window.render();
    let known = window.app().estimated_time().unwrap().seconds;
    let elapsed = picture(&window).elapsed().as_secs_f64();
    assert_eq!(
        (known.low, known.value, known.high),
        (elapsed, elapsed, elapsed)
    );
}

/// The file tells which part of the picture it is, so nothing has changed since.
#[test]
fn a_saved_region_opens_as_what_was_rendered() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let frame = window.rect("Viewport");
    window.press(Modifiers::NONE, Key::B);
    let quarter = frame.min + frame.size() / 4.0;
    window.drag(PointerButton::Primary, quarter, frame.center());
    window.render();
    let (hash, part) = (window.hash(), picture(&window).buffer.part());
    assert!(!part.is_whole());
    let saved = ["part.exr", "part.png"].map(|name| files.path(name));
    for path in &saved {
        window.save_picture(path);
    }
    drop(window);
    for path in &saved {
        let mut window = Window::open(path);
        window.until("it is on the screen", |app| {
            app.picture_on_screen().is_some_and(Picture::is_shown)
        });
        assert!(window.says("of 160 × 120, from part."));
        assert!(!window.says("settings changed since"));
        assert_eq!(
            window.app().picture_on_screen().unwrap().buffer.part(),
            part
        );
        window.render();
        assert_eq!(window.hash(), hash);
        // Saved again, it still tells.
        let again = path.with_added_extension("exr");
        window.save_picture(&again);
        let origin = raymini::io::WrittenOrigin::of_file(&again).unwrap();
        assert_eq!(origin.region, Some(part.region));
    }
}
