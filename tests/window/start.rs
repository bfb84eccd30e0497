//! What the window does before its first picture, and what it does not.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::driver::{DEADLINE, Files, Window};
use egui::{Key, Modifiers};
use raymini::control::Progress;
use raymini::gui::event::Event;
use raymini::gui::jobs::{Jobs, Lane, News};
use raymini::gui::worker::{self, Placed};
use raymini::io;
use raymini::render::PreparedScene;
use raymini::scene::{AcceleratorChoice, Scene};

/// What the window is told while `scene` is prepared, in order: what it can draw, and what it can render.
fn told_of(scene: &Scene, before: Option<(Placed, PreparedScene)>) -> (Placed, PreparedScene) {
    let mut jobs = Jobs::new(egui::Context::default());
    let scene = scene.clone();
    jobs.start(Lane::Prepare, move |job| {
        let (placed, prepared) = before.unzip();
        worker::prepare(
            job,
            &scene,
            placed,
            prepared.as_ref(),
            None,
            &Progress::new(),
        );
    });
    let deadline = Instant::now() + DEADLINE;
    let mut next = || {
        loop {
            match jobs.next_event() {
                Some(News::Event(event)) => return event,
                Some(News::Panicked(_, message)) => panic!("{message}"),
                None => std::thread::sleep(Duration::from_millis(1)),
            }
            assert!(Instant::now() < deadline, "no news");
        }
    };
    let Event::Placed(placed) = next() else {
        panic!("first what can be drawn")
    };
    let Event::Prepared(Ok(prepared)) = next() else {
        panic!("then what can be rendered")
    };
    (*placed, *prepared)
}

#[test]
fn the_first_picture_waits_for_no_tree() {
    let mut scene = io::demo_scene();
    scene.render.accelerator = AcceleratorChoice::KdTree;
    let (placed, prepared) = told_of(&scene, None);
    assert_eq!(placed.geometry.accelerator().name(), "brute-force");
    assert_eq!(prepared.geometry().accelerator().name(), "kd-tree");
    assert_eq!(placed.object_bounds.len(), scene.objects.len());

    // A light changes neither.
    scene.lights.pop();
    let geometry = Arc::clone(prepared.geometry());
    let placed = Placed {
        geometry: Arc::clone(&geometry),
        ..placed
    };
    let (placed, prepared) = told_of(&scene, Some((placed, prepared)));
    assert!(Arc::ptr_eq(&placed.geometry, &geometry));
    assert!(Arc::ptr_eq(prepared.geometry(), &geometry));

    // Another object is drawn first again.
    scene.objects.pop();
    let (placed, prepared) = told_of(&scene, Some((placed, prepared)));
    assert_eq!(placed.geometry.accelerator().name(), "brute-force");
    assert_eq!(placed.object_bounds.len(), scene.objects.len());
    assert_eq!(prepared.geometry().objects().len(), scene.objects.len());
}

#[test]
fn a_scene_that_cannot_be_rendered_says_so() {
    let mut scene = io::demo_scene();
    scene.camera.target = scene.camera.eye;
    let mut jobs = Jobs::new(egui::Context::default());
    jobs.start(Lane::Prepare, move |job| {
        worker::prepare(job, &scene, None, None, None, &Progress::new());
    });
    let deadline = Instant::now() + DEADLINE;
    let event = loop {
        if let Some(event) = jobs.next_event() {
            break event;
        }
        assert!(Instant::now() < deadline, "no news");
        std::thread::sleep(Duration::from_millis(1));
    };
    let News::Event(Event::Prepared(Err(problem))) = event else {
        panic!("{event:?}")
    };
    assert!(problem.contains("camera"), "{problem}");
}

/// Reading the files, preparing the scene and looking for lost work: nothing else is begun for the first picture. What the panels show of
/// materials comes after it, and from then on files are looked at.
#[test]
fn a_window_begins_nothing_that_was_not_asked_for() {
    let files = Files::new();
    let data = tempfile::tempdir().unwrap();
    let mut window = Window::start_keeping(
        vec![files.path("room.toml")],
        true,
        Some(data.path().to_owned()),
    );
    window.harness.run_steps(30);
    let started = |lane| window.app().jobs_started(lane);
    for lane in [Lane::Load, Lane::Prepare, Lane::Begin] {
        assert_eq!(started(lane), 1, "{lane:?}");
    }
    let others = [
        Lane::Render,
        Lane::Encode,
        Lane::Thumbnails,
        Lane::Histogram,
        Lane::Compare,
        Lane::EncodeOther,
        Lane::CompareFile,
        Lane::SaveScene,
        Lane::SavePicture,
        Lane::Dialog,
        Lane::List,
        Lane::Report,
        Lane::Costs,
        Lane::Time,
        Lane::Trace,
        Lane::Reload,
        Lane::ShowFolder,
        Lane::Discard,
    ];
    for lane in others {
        assert_eq!(started(lane), 0, "{lane:?}");
    }
}

/// Nor does one without anything to render keep still about why F5 does nothing.
#[test]
fn a_scene_without_objects_says_why_it_is_not_rendered() {
    let files = Files::new();
    let mut window = Window::open(&files.write("nothing.toml", "[render]\nwidth = 64\n"));
    window.press(Modifiers::NONE, Key::F5);
    assert!(window.app().picture().is_none());
    assert!(window.says("There is nothing to render yet"));
}
