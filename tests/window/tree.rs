//! The tree of the scene's parts where there are very many.

use std::time::Duration;

use cpu_time::ThreadTime;
use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, TouchPhase, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::scene::Object;

use crate::driver::{Files, Window};

const COUNT: usize = 10_000;

/// A window with a scene of many objects, and a material for every ten.
fn many_parts() -> Window {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let scene = &mut window.harness.state_mut().document_mut().scene;
    let (like, clay) = (scene.objects[0].clone(), scene.materials["clay"].clone());
    scene.objects = (0..COUNT)
        .map(|index| Object {
            name: format!("part {index}"),
            material: Some(format!("clay {}", index / 10)),
            ..like.clone()
        })
        .collect();
    for index in 0..COUNT / 10 {
        let name = format!("clay {index}");
        scene.materials.insert(name, clay.clone());
    }
    window.settle();
    window
}

/// The objects whose rows are there, with their rectangles.
fn rows(window: &Window) -> Vec<(usize, egui::Rect)> {
    let nodes = window.harness.query_all_by_label_contains("Select part");
    let number = |label: String| label.rsplit(' ').next().unwrap().parse().unwrap();
    nodes
        .map(|node| (number(node.accesskit_node().label().unwrap()), node.rect()))
        .collect()
}

/// Turns the wheel over the tree by so many points.
fn scroll(window: &mut Window, points: f32) {
    let place = window.rect("Objects  10000").center();
    window.harness.hover_at(place);
    window.harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: Vec2::new(0.0, points),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(40);
}

/// Processor time of a frame.
fn frame_time(window: &mut Window) -> Duration {
    const FRAMES: u32 = 20;
    let started = ThreadTime::now();
    window.harness.run_steps(FRAMES as usize);
    started.elapsed() / FRAMES
}

/// Rows that nobody sees take no time of a frame, which is printed.
#[test]
fn of_thousands_of_parts_only_rows_near_the_visible_ones_are_there() {
    let mut window = many_parts();
    let first = rows(&window);
    assert!(first.len() < 60, "{} rows", first.len());
    let top = first[0].1.top();
    assert_eq!((first[0].0, first[1].1.top() - top), (0, 23.0));

    // Each is where it would be were all there.
    scroll(&mut window, -100_000.0);
    let scrolled = rows(&window);
    let by = scrolled[0].1.top() - top - scrolled[0].0 as f32 * 23.0;
    assert!(by < -90_000.0, "scrolled by {by}");
    for (index, rect) in &scrolled {
        let expected = top + by + *index as f32 * 23.0;
        assert!((rect.top() - expected).abs() < 0.1, "row {index}");
    }
    let seen = top + 100.0..top + 200.0;
    let in_sight = |(_, rect): &&(usize, egui::Rect)| seen.contains(&rect.center().y);
    let (index, rect) = scrolled.iter().find(in_sight).expect("rows are in sight");
    window.click_at(rect.center());
    window.press(Modifiers::NONE, Key::Delete);
    let name = format!("part {index}");
    let objects = &window.scene().objects;
    assert!(objects.len() == COUNT - 1 && objects.iter().all(|object| object.name != name));

    let many = frame_time(&mut window);
    let scene = &mut window.harness.state_mut().document_mut().scene;
    scene.objects.truncate(1);
    window.settle();
    let one = frame_time(&mut window);
    println!("{many:.1?} for a frame of {COUNT} objects, {one:.1?} of one");
}
