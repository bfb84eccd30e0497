//! Renders that end by rules, and the error that is told of them.

use crate::driver::{Files, Window, load, set_number, set_samples};
use egui::{Key, Modifiers};
use raymini::render::{Ending, Layer};

/// A render ends at the noise that is asked for, and the plot shows how it came there, beside the renders before.
#[test]
fn a_render_stops_at_a_noise_and_its_course_is_plotted() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Error plot");
    assert!(window.has("Render, and see the error fall"));
    set_samples(&mut window, 64);
    window.render();
    assert_eq!(window.finished().1.ending, Ending::Samples);
    assert!(window.says("all samples taken"));
    assert!(window.says("64 samples per pixel"));

    window.operate("Stop at noise");
    assert_eq!(window.scene().render.stop.noise, Some(0.03));
    assert!(window.says("at most: if they do not reach it"));
    set_samples(&mut window, 4096);
    assert!(!window.says("at most: if they do not reach it"));
    set_number(&mut window, "Noise to stop at", "1.5");
    assert_eq!(window.scene().render.stop.noise, Some(0.015));
    window.click("Select Light 1");
    window.click("Kind: Disk");
    window.render();
    let (_, stats) = window.finished();
    assert_eq!(stats.ending, Ending::Noise);
    assert!(stats.error.unwrap().noise().value <= 0.015);
    assert!(window.says("down to 1.5 %"));
    assert!(window.has("1.5 % is reached"));
    let share = window.app().picture().unwrap().progress.samples.fraction();
    assert!((share - 1.0).abs() < 1e-12);

    // Both renders are in the plot, each with its points and its name.
    let plot = window.app().error_plot();
    let past: Vec<_> = plot.past().collect();
    assert_eq!(past.len(), 1);
    assert_eq!(past[0].name, "room, direct");
    assert!(past[0].points.len() >= 5);
    let picture = window.app().picture().unwrap();
    assert!(picture.errors().len() >= 3);
    assert_eq!(picture.name, "4,096 samples, stop at 1.5 %, other lights");
    assert!(window.says("1  room, direct"));
    assert!(window.says("2  4,096 samples"));
    window.press(Modifiers::NONE, Key::F8);
    window.harness.run_steps(30);
    assert!(!window.says("1  room, direct"));

    // The scene's file keeps when to stop.
    let toml = files.path("stops.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&toml);
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert_eq!(load(&toml).render, window.scene().render);
}

/// What cannot be rendered cannot be set.
#[test]
fn a_stop_at_a_noise_needs_the_estimate() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    assert!(!window.has("Adaptive"));
    window.operate("Estimate error");
    assert!(!window.scene().render.error_estimate);
    window.operate("Stop after");
    assert_eq!(window.scene().render.stop.seconds, Some(10.0));
    assert!(!window.has("Adaptive"), "it takes an estimate");
    window.operate("Stop at noise");
    assert!(window.scene().render.error_estimate, "it is switched on");
    window.operate("Estimate error");
    assert!(window.scene().render.error_estimate, "it cannot go");
    window.operate("Adaptive");
    assert!(!window.scene().render.adaptive);
    assert!(window.scene().validate().is_ok());
    window.operate("Stop at noise");
    window.operate("Stop after");
    assert_eq!(window.scene().render.stop, raymini::scene::Stop::default());
    window.operate("Estimate error");
    assert!(!window.scene().render.error_estimate);
    window.click("Error plot");
    window.render();
    assert!(window.says("is not estimated"));
}

#[test]
fn a_render_stops_when_its_time_is_up() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 100_000);
    window.operate("Stop after");
    set_number(&mut window, "Time to stop after", "0.5");
    window.render();
    assert_eq!(window.finished().1.ending, Ending::Time);
    assert!(window.says("time is up"));
}

/// The error of each pixel is a layer to look at and to save.
#[test]
fn the_error_of_each_pixel_is_shown_and_saved() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 64);
    window.render();
    let buffer = std::sync::Arc::clone(&window.app().picture().unwrap().buffer);
    assert_eq!(buffer.layers().last(), Some(&Layer::Error));
    assert_eq!(buffer.shown_error_scale(), None);
    window.operate("Layer");
    window.operate("Error of each pixel");
    window.harness.run_steps(5);
    let scale = buffer.shown_error_scale().unwrap();
    assert!(scale > 0.0 && scale < 1.0, "{scale}");
    assert!(window.says("W/m²/sr or more"));
    let (_, errors) = buffer.layer_images().pop().unwrap();
    assert!(errors.pixels.iter().any(|rgb| rgb[1] > 0.0));

    // A render that is looked at in this way shows its own errors.
    window.render();
    let again = window.app().picture().unwrap();
    assert!(again.buffer.shown_error_scale().is_some());
    assert!(again.first_tile.is_some());

    let exr = files.path("layers.exr");
    window.save_picture(&exr);
    let file = exr::meta::MetaData::read_from_file(&exr, false).unwrap();
    let channels = &file.headers[0].channels.list;
    assert!(
        channels
            .iter()
            .any(|c| c.name.to_string().starts_with("error.")),
        "{channels:?}"
    );
}
