//! Rules by which renders end, changed while they run and after, and what the status bar says meanwhile.

use crate::driver::{Files, Window, library_hash, load, set_number, set_samples};
use egui::{Key, Modifiers};
use raymini::gui::App;
use raymini::gui::costs::CostState;
use raymini::gui::picture::{Outcome, Picture};
use raymini::render::Ending;

fn picture(window: &Window) -> &Picture {
    window.app().picture().expect("a picture")
}

fn is_over(app: &App) -> bool {
    app.picture().is_some_and(|picture| !picture.is_running())
}

fn start_long_render(window: &mut Window) {
    set_samples(window, 1_000_000);
    window.click("Render");
    window.until("the render goes on", |app| {
        app.picture()
            .is_some_and(|p| p.first_tile.is_some() && p.progress.samples.done() > 0)
    });
}

/// Samples of a pixel that the running render ends with soon, after a pass that it would make anyway.
fn a_few_more_samples(window: &Window) -> u32 {
    let picture = picture(window);
    let pixels = picture.scene.render.pixel_count();
    let taken = picture.progress.samples.done().div_ceil(pixels);
    u32::try_from((taken / 16 + 2) * 16).expect("not that many")
}

/// Other rules, and nothing else, do not begin a render anew: it ends by them, with the bits of one that had them from the start.
#[test]
fn a_running_render_takes_over_other_samples() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    window.click("Pause");
    let (number, started) = (picture(&window).number, picture(&window).started());
    let samples = a_few_more_samples(&window);
    set_samples(&mut window, samples);
    let samples = picture(&window).scene.render.samples_per_pixel;
    assert_eq!(samples, window.scene().render.samples_per_pixel);
    assert!(!window.says("settings changed"));
    window.click("Resume");
    window.until("the render ends", is_over);
    assert_eq!(picture(&window).started(), started);
    assert_eq!(picture(&window).number, number);
    assert_eq!(window.hash(), library_hash(window.scene()));
    assert!(!window.says("changed on the way"));
}

/// A time that is set while a render runs ends it.
#[test]
fn a_running_render_takes_over_a_time() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    let started = picture(&window).started();
    window.operate("Stop after");
    set_number(&mut window, "Time to stop after", "0.5");
    window.until("the render ends", is_over);
    assert_eq!(picture(&window).started(), started);
    assert_eq!(window.finished().1.ending, Ending::Time);
}

/// A render that is done takes more samples when it may, and keeps those it has.
#[test]
fn a_finished_render_goes_on_to_more_samples() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    assert!(!window.has("Continue"), "it has all there are");
    set_samples(&mut window, 12);
    assert!(window.says("Continue takes its samples along"));
    window.click("Continue");
    window.until("the render ends", is_over);
    assert_eq!(picture(&window).goes_on_from(), Some(4.0 / 12.0));
    assert_eq!(picture(&window).number, 2);
    assert_eq!(window.hash(), library_hash(window.scene()));
    assert!(!window.has("Continue"));
    assert!(
        window.app().estimated_time().is_none(),
        "it was no whole render"
    );
    // Another edit makes it another picture.
    set_samples(&mut window, 16);
    assert!(window.has("Continue"));
    window.operate("Keep layers");
    assert!(!window.has("Continue"), "it has no layers");
    window.operate("Keep layers");
    assert!(window.has("Continue"));
    window.operate("Shadows: Off");
    assert!(!window.has("Continue"));
}

#[test]
fn a_cancelled_render_goes_on_where_it_was() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    window.click("Cancel");
    assert_eq!(picture(&window).outcome, Outcome::Cancelled);
    window.until("what it reached is there", |app| {
        app.picture().is_some_and(|p| p.reached().is_there())
    });
    let samples = a_few_more_samples(&window);
    set_samples(&mut window, samples);
    window.press(Modifiers::SHIFT, Key::F5);
    window.until("the render ends", is_over);
    assert!(
        picture(&window)
            .goes_on_from()
            .is_some_and(|share| share > 0.0)
    );
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// Where the clock ends it, time is what is told of it before and after, although it has next to none of its samples.
#[test]
fn a_render_that_the_clock_ends_goes_on_at_the_share_that_it_was_cancelled_at() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.operate("Stop after");
    set_number(&mut window, "Time to stop after", "5");
    start_long_render(&mut window);
    window.until("much of its time is over", |app| {
        app.picture().is_some_and(|p| p.progress.share() > 0.4)
    });
    window.click("Cancel");
    let cancelled_at = picture(&window).progress.share();
    window.until("what it reached is there", |app| {
        app.picture().is_some_and(|p| p.reached().is_there())
    });
    window.press(Modifiers::SHIFT, Key::F5);
    window.just_until("it goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    let goes_on_from = picture(&window).goes_on_from().expect("it goes on");
    // Tiles that were in hand take a moment to end.
    assert!(
        (goes_on_from - cancelled_at).abs() < 0.1,
        "{cancelled_at}, then {goes_on_from}"
    );
    window.click("Cancel");
}

/// While an older picture is looked at, the bar goes on telling of the render that runs.
#[test]
fn the_running_render_is_told_of_beside_an_older_one() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Renders");
    window.render();
    start_long_render(&mut window);
    window.click("Show render 1");
    window.harness.run_steps(3);
    assert_eq!(window.app().picture_on_screen().map(|p| p.number), Some(1));
    assert!(window.says("all samples taken"), "the older one");
    assert!(window.has("Progress") && window.says("Rendering"));
    window.click("Cancel");
    window.until("the render ends", is_over);
    assert!(!window.has("Progress"));
}

/// With the panel closed, too.
#[test]
fn measuring_costs_shows_its_progress_and_is_cancelled_in_the_bar() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F9);
    window.press(Modifiers::NONE, Key::F7);
    assert!(window.has("Measuring costs") && window.has("Progress"));
    window.click("Cancel measuring");
    assert!(matches!(window.app().costs(), CostState::Unknown));
    assert!(!window.has("Measuring costs"));
}

/// It may have fewer samples than it has: it ends with those, and they are what it is called by.
#[test]
fn a_cancelled_render_that_has_more_samples_than_it_may_loses_none() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    window.until("it has more", |app| {
        let picture = app.picture().expect("a picture");
        picture.progress.samples.done() > 40 * picture.scene.render.pixel_count()
    });
    window.click("Cancel");
    window.until("what it reached is there", |app| {
        app.picture().is_some_and(|p| p.reached().is_there())
    });
    set_samples(&mut window, 8);
    assert!(window.says("Continue takes its samples along"));
    window.click("Continue");
    window.until("the render ends", is_over);
    assert_eq!(
        picture(&window).goes_on_from().map(|share| share > 0.5),
        Some(true)
    );
    let stats = window.finished().1;
    let [samples, most] = stats.sample_range;
    assert!(samples >= 40 && samples == most);
    let mut scene = window.scene().clone();
    assert_eq!(scene.render.samples_per_pixel, 8);
    scene.render.samples_per_pixel = samples;
    assert_eq!(window.hash(), library_hash(&scene));
    assert!(
        picture(&window)
            .name
            .contains(&format!("{samples} samples"))
    );
}

/// Undoing is about the scene: a render that runs goes on as it was asked to.
#[test]
fn undone_rules_do_not_end_a_running_render() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    set_samples(&mut window, 900_000);
    let of_render = |window: &Window| picture(window).scene.render.samples_per_pixel;
    assert_eq!(of_render(&window), 900_000);
    let started = picture(&window).started();
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().render.samples_per_pixel, 1_000_000);
    assert!(window.says("The running render keeps its own stop rules"));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().render.samples_per_pixel, 4);
    window.harness.run_steps(3);
    assert!(picture(&window).is_running() && picture(&window).started() == started);
    assert_eq!(of_render(&window), 900_000);
    set_samples(&mut window, 800_000);
    assert_eq!(of_render(&window), 800_000);
    window.click("Cancel");
}

/// It has more samples than it may: whoever saves it or restores its settings gets what makes the picture.
#[test]
fn a_picture_that_had_more_samples_than_it_may_tells_those_it_has() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Renders");
    start_long_render(&mut window);
    window.until("it has more", |app| {
        let picture = app.picture().expect("a picture");
        picture.progress.samples.done() > 40 * picture.scene.render.pixel_count()
    });
    set_samples(&mut window, 8);
    window.until("the render ends", is_over);
    let (hash, stats) = window.finished();
    let [samples, most] = stats.sample_range;
    assert!(samples >= 40 && samples == most);
    assert!(window.says(&format!("direct, 160 × 120, {samples} samples")));
    let saved = files.path("saved.exr");
    window.save_picture(&saved);
    assert_eq!(window.scene().render.samples_per_pixel, 8);
    window.click("Restore settings");
    assert_eq!(window.scene().render.samples_per_pixel, samples);
    drop(window);

    let written = load(&saved);
    assert_eq!(written.render.samples_per_pixel, samples);
    assert_eq!(library_hash(&written), hash);
}
