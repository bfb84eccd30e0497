//! The window, driven as a user drives it: by the names on its controls, by keys and by the mouse. Runs on software Vulkan
//! without a display; tests that need a GPU fail without an adapter.

use std::time::{Duration, Instant};

use crate::driver::{DEADLINE, Files, SCENE, Window, library_hash, load, set_number, set_samples};
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::control::CancelToken;
use raymini::gui::App;
use raymini::gui::costs::CostState;
use raymini::gui::dialogs::Dialog;
use raymini::gui::messages::Severity;
use raymini::gui::picture::Outcome;
use raymini::gui::top_bar::View;
use raymini::render::{Image, Layer, PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{Light, Shadows, ToneCurve};

/// The main job: open, look around, render, watch, cancel, render to the end, save, open again.
#[test]
fn open_orbit_render_cancel_save_reopen() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    assert_eq!(window.app().document().name(), "room");
    assert!(!window.app().document().is_modified());

    // Looking around moves the camera about its target and marks the scene as changed.
    let before = window.scene().camera;
    let middle = Pos2::new(470.0, 400.0);
    window.drag(
        PointerButton::Primary,
        middle,
        middle + Vec2::new(60.0, 25.0),
    );
    let after = window.scene().camera;
    assert_ne!(after.eye, before.eye);
    assert_eq!(after.target, before.target);
    assert!(window.app().document().is_modified());
    assert_eq!(window.app().view(), View::Preview);
    window.drag(
        PointerButton::Middle,
        middle,
        middle + Vec2::new(-20.0, 10.0),
    );
    assert_ne!(window.scene().camera.target, after.target);

    // A long render streams in and stops when told to.
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture()
            .is_some_and(|p| p.first_tile.is_some() || p.progress.samples.fraction() > 0.0)
    });
    assert!(window.has("Cancel"));
    assert_eq!(window.app().view(), View::Picture);
    window.click("Cancel");
    assert_eq!(window.app().picture().unwrap().outcome, Outcome::Cancelled);
    window.until("threads have stopped", |app| app.render_threads() == 0);

    // The finished picture is the library's, bit for bit.
    set_samples(&mut window, 3);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
    let share = window.app().picture().unwrap().progress.samples.fraction();
    assert!((share - 1.0).abs() < 1e-12);

    // It is saved by shortcut and a typed path, and holds what the window shows.
    let png = files.path("out.png");
    window.save_picture(&png);
    let saved = image::open(&png).unwrap().to_rgb8();
    assert_eq!(saved.dimensions(), (160, 120));

    // The scene is saved with the new camera, and opens again to the same picture.
    let toml = files.path("changed.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&toml);
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert_eq!(window.app().document().name(), "changed");
    let hash = window.hash();
    assert_eq!(library_hash(&load(&toml)), hash);
    let mut again = Window::open(&toml);
    again.render();
    assert_eq!(again.hash(), hash);
}

#[test]
fn a_broken_file_gets_a_banner_and_the_scene_stays() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    let broken = files.write("broken.toml", "[camera]\neye = [0, 0\n");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&broken);
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    let banner = window.app().messages().banners()[0].clone();
    assert_eq!(banner.severity, Severity::Error);
    assert!(banner.text.contains("broken.toml:"), "{}", banner.text);
    assert_eq!(window.scene(), &before);
    assert_eq!(window.app().document().name(), "room");
    assert!(banner.text.ends_with("The scene you had is still here."));
    window.click("Dismiss");
    assert!(window.app().messages().banners().is_empty());
    window.render();
    assert_eq!(window.hash(), library_hash(&before));

    // Unsaved work is not asked about for nothing.
    window.operate("Add light");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&broken);
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    assert!(window.app().dialog().is_none());
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.write("other.toml", SCENE));
    window.until("it is asked", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    window.click("Save first");
    window.until("it is open", |app| app.document().name() == "other");
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);

    // At the start there is no scene that could still be here.
    let window = Window::open(&broken);
    let banner = &window.app().messages().banners()[0];
    assert!(banner.text.contains("broken.toml:"), "{}", banner.text);
    assert!(!banner.text.contains("still here"), "{}", banner.text);
}

/// However many messages wait, the preview keeps most of the window.
#[test]
fn messages_leave_the_preview_its_room() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let height = |window: &Window| window.rect("Viewport").height();
    let before = height(&window);
    for name in ["first.toml", "second.toml", "third.toml"] {
        let broken = files.write(name, "[camera]\neye = [0, 0\n");
        window.press(Modifiers::COMMAND, Key::O);
        window.enter_path(&broken);
        let is_told = |app: &App| {
            let banners = app.messages().banners();
            banners.iter().any(|banner| banner.text.contains(name))
        };
        window.until("a banner shows", is_told);
    }
    assert!(window.says("and 1 older message"));
    assert!(height(&window) > 0.6 * before, "{}", height(&window));
    window.click("Dismiss all");
    assert_eq!(height(&window), before);
}

/// The file as it was saved is opened, not as it was read before that.
#[test]
fn the_same_file_is_opened_as_it_was_saved_just_now() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.operate("Add light");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("room.toml"));
    window.until("it is asked", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    window.click("Save first");
    window.until("it is open", |app| {
        app.messages().last_news() == "Undo brings room back"
    });
    assert_eq!(window.scene().lights.len(), 2);
    assert!(!window.app().document().is_modified());
}

#[test]
fn lights_are_added_and_removed() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    assert_eq!(window.scene().lights.len(), 2);
    assert!(window.has("Select Light 2"));
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.click("Remove light");
    window.click("Remove light");
    assert!(window.scene().lights.is_empty());
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
}

#[test]
fn a_light_becomes_a_disk_and_occlusion_darkens() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    window.click("Kind: Disk");
    assert!(matches!(window.scene().lights[0], Light::Disk { .. }));
    window.operate("Occlusion");
    window.operate("Shadows: Hard");
    window.render();
    assert!(window.scene().render.ambient_occlusion.enabled);
    assert_eq!(window.scene().render.shadows, Shadows::Hard);
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.click("Kind: Point");
    assert!(matches!(window.scene().lights[0], Light::Point { .. }));
}

/// Geometry edits are prepared in the background, and a render asked for meanwhile waits for the newest state.
#[test]
fn a_render_uses_the_newest_edits() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select pyramid");
    window.click("Smooth");
    window.render();
    assert!(window.scene().objects[0].smooth);
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// The picture's rays from the eye are those before wherever only lights differ; the panel says what else is left out.
#[test]
fn the_plan_is_shown_and_another_light_keeps_the_rays_from_the_eye() {
    let files = Files::new();
    let path = files.write("room.toml", &format!("{SCENE}antialiasing = false\n"));
    let mut window = Window::open(&path);
    window.operate("Plan");
    for line in [
        "left out, as Anti-aliasing is off",
        "Lights: 1 of 1 shine",
        "Materials: 1 of 1 on objects (matt, highlights)",
        "Rays look for 10 triangles in the wide tree",
    ] {
        assert!(window.says(line), "{line}");
    }
    window.render();
    let camera_rays = |window: &Window| window.finished().1.rays.camera;
    assert_eq!(camera_rays(&window), 160 * 120);
    window.click("Add light");
    window.render();
    assert_eq!(window.scene().lights.len(), 2);
    assert_eq!(camera_rays(&window), 0);
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// Costs are measured beside the window, given up for a render, and told to be old when the scene has changed.
#[test]
fn costs_are_measured_and_give_way_to_a_render() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.operate("Plan");
    window.operate("Measure costs");
    assert!(matches!(window.app().costs(), CostState::Measuring(_)));
    assert!(window.has("Cancel measuring"));
    window.render();
    assert!(matches!(window.app().costs(), CostState::Unknown));
    window.press(Modifiers::NONE, Key::F7);
    window.operate("Cancel measuring");
    assert!(matches!(window.app().costs(), CostState::Unknown));

    window.operate("Measure costs");
    window.until("costs are known", |app| {
        matches!(app.costs(), CostState::Known { .. })
    });
    let CostState::Known { costs, .. } = window.app().costs() else {
        unreachable!("as was waited for");
    };
    let mut effects = costs.effects.iter();
    assert!(effects.any(|(effect, _)| effect.name() == "shadows"));
    assert!(window.says("Part of the time") && window.says("What is left out would add"));
    assert!(!window.says("before the last changes"));
    // Beside each switch too, in whole per cent; a row that says so names the effect.
    let panel = window.rect("Select Camera");
    for (effect, row) in [
        ("shadows", "With shadows"),
        ("antialiasing", "Anti-aliasing"),
    ] {
        let CostState::Known { costs, .. } = window.app().costs() else {
            unreachable!("as was waited for");
        };
        let mut effects = costs.effects.iter();
        let (_, share) = effects.find(|(known, _)| known.name() == effect).unwrap();
        let told = format!("{:.0} % time", (100.0 * share.value).round() + 0.0);
        let row = window.harness.get_all_by_label(row).next().unwrap().rect();
        let mut figures = window.harness.query_all_by_label_contains(&told);
        let is_beside = |place: egui::Rect| {
            (place.center().y - row.center().y).abs() < 20.0 && place.right() < panel.right()
        };
        assert!(figures.any(|figure| is_beside(figure.rect())), "{told}");
    }
    window.operate("Anti-aliasing");
    assert!(window.says("before the last changes"));

    // Another scene has costs of its own.
    window.operate("Anti-aliasing");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.settle();
    assert_eq!(window.scene().objects.len(), 1);
    assert!(matches!(window.app().costs(), CostState::Unknown));
}

/// Exposure changes what is shown and saved, at once and without rendering again.
#[test]
fn display_settings_need_no_new_render() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    window.operate("Tone curve: ACES");
    window.harness.run_steps(5);
    assert_eq!(window.scene().display.tone_curve, ToneCurve::Aces);
    assert_eq!(window.hash(), hash);
    let png = files.path("aces.png");
    window.save_picture(&png);
    let saved = image::open(&png).unwrap().to_rgb8();
    let prepared = PreparedScene::prepare(window.scene(), None, &CancelToken::new());
    let outcome = render(
        &prepared.unwrap().unwrap(),
        None,
        &RunConfig::default(),
        &RenderProgress::default(),
        None,
    );
    let display = window.scene().display;
    let expected: Vec<u8> = outcome
        .unwrap()
        .image
        .pixels
        .iter()
        .flat_map(|&rgb| raymini::render::display::encode_8(rgb, &display))
        .collect();
    assert_eq!(saved.into_raw(), expected);
}

/// To look at a panel is no edit.
#[test]
fn every_reach_of_occlusion_stays_as_it_was_read() {
    let files = Files::new();
    let path = files.write(
        "reach.toml",
        "[render.ambient_occlusion]\nenabled = true\nradius = 0.007\n[[objects]]\nmesh = \"pyramid.off\"\n",
    );
    let mut window = Window::open(&path);
    window.harness.run_steps(5);
    assert!(window.has("Occlusion reach"));
    assert_eq!(window.scene().render.ambient_occlusion.radius, 0.007);
    assert!(!window.app().document().is_modified());
}

/// Without a GPU the window builds, says what is missing, and renders.
#[test]
fn without_a_gpu_everything_but_the_preview_works() {
    let files = Files::new();
    let mut window = Window::start(vec![files.path("room.toml")], false);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// Switching an effect while the picture is looked at renders it anew; the figure is printed.
#[test]
fn switching_an_effect_restarts_a_running_render() {
    let mut window = Window::start(Vec::new(), true);
    set_samples(&mut window, 4096);
    window.harness.get_by_label("Render").click();
    window.until("the first tile shows", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    assert_ne!(window.scene().render.shadows, Shadows::Off);
    window.operate("Shadows: Off");
    let news = "Rendering anew, as the scene was edited";
    assert_eq!(window.app().messages().last_news(), news);
    window.until("tiles of the new picture show", |app| {
        app.picture().is_some_and(|p| {
            p.is_running() && p.first_tile.is_some() && p.scene.render.shadows == Shadows::Off
        })
    });
    let restarted = window.app().picture().unwrap().first_tile.unwrap();
    println!("first tile {restarted:.1?} after the switch");

    // In the preview, editing goes on beside the render.
    window.click("Preview");
    window.operate("Shadows: Hard");
    window.harness.run_steps(3);
    assert_eq!(
        window.app().picture().unwrap().scene.render.shadows,
        Shadows::Off
    );
    assert!(window.app().picture().unwrap().is_running());
    window.click("Cancel");
}

/// Layers are kept, looked at, and left out when not wanted.
#[test]
fn a_layer_of_the_picture_is_shown() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let buffer = std::sync::Arc::clone(&window.app().picture().unwrap().buffer);
    assert!(buffer.layers().contains(&Layer::Shadow));
    let layers = buffer.layer_images();
    let shadow = &layers.iter().find(|(l, _)| *l == Layer::Shadow).unwrap().1;
    // Places that are lit, but not white, and places in shadow that are.
    let picture = buffer.image();
    let all_around = |image: &Image, [x, y]: [u32; 2], is: &dyn Fn([f32; 3]) -> bool| {
        let mut near = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| [x, y]));
        near.all(|[x, y]| is(image.pixel(x, y)))
    };
    let mut places = (2..118).flat_map(|y| (2..158).map(move |x| [x, y]));
    let lit = places.find(|&place| {
        all_around(shadow, place, &|value| value == [1.0; 3])
            && all_around(&picture, place, &|value| value[2] < 0.5)
    });
    let lit = lit.expect("a lit part of the pyramid");
    let on_screen = |window: &mut Window, [x, y]: [u32; 2]| {
        let frame = window.rect("Viewport");
        let share = Vec2::new((x as f32 + 0.5) / 160.0, (y as f32 + 0.5) / 120.0);
        window.color_at(frame.min + share * frame.size())
    };
    let blue = on_screen(&mut window, lit)[2];
    assert!(blue < 200, "{blue}");
    window.operate("Layer");
    window.operate("Shadow factor");
    window.harness.run_steps(5);
    assert!(window.has("Layer"));
    assert_eq!(on_screen(&mut window, lit), [255; 3]);
    window.operate("Keep layers");
    window.render();
    assert!(window.app().picture().unwrap().buffer.layers().is_empty());
    assert!(!window.has("Layer"));
}

/// It is told at once and goes with its reason, while a picture is looked at too.
#[test]
fn what_cannot_be_rendered_is_told_as_long_as_it_is_so() {
    const PROBLEM: &str = "This scene cannot be rendered as it is";
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    assert!(!window.says(PROBLEM));
    let before = window.scene().camera;
    let fields = ["Target X", "Target Y", "Target Z"].into_iter();
    for (field, value) in fields.zip(before.eye.to_array()) {
        set_number(&mut window, field, &value.to_string());
    }
    assert_eq!(window.scene().camera.target, before.eye);
    assert!(window.says(PROBLEM) && window.says("a point other than the eye"));
    assert!(
        window
            .harness
            .get_by_label("Render")
            .accesskit_node()
            .is_disabled()
    );
    set_number(&mut window, "Target Y", "0");
    assert!(!window.says(PROBLEM));
    window.render();
    window.finished();
}

/// The window says what rays look for triangles in, and the picture does not depend on it.
#[test]
fn another_structure_gives_the_same_picture() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    let in_use = |window: &Window, name: &str| {
        let start = format!("{name}, ");
        window.harness.query_by_label_contains(&start).is_some()
    };
    assert!(in_use(&window, "wide"));
    assert!(window.has("Tree"));
    for (choice, name) in [("kd-tree", "kd-tree"), ("Every triangle", "brute-force")] {
        window.operate("Structure");
        window.operate(choice);
        window.settle();
        window.render();
        assert!(in_use(&window, name), "{name} is not shown");
        assert!(!window.has("Tree"));
        assert_eq!(window.hash(), hash, "{name}");
    }
}

/// Cancel to idle threads, on a scene of 100,000 triangles. The figures are printed, not judged: machines differ.
#[test]
fn the_first_tile_comes_at_once_and_cancel_is_obeyed() {
    let mut window = Window::start(Vec::new(), true);
    assert!(window.scene().triangle_count() > 100_000);
    set_samples(&mut window, 4096);
    window.harness.get_by_label("Render").click();
    window.until("the first tile shows", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    let first_tile = window.app().picture().unwrap().first_tile.unwrap();

    let mut frames: Vec<Duration> = (0..100)
        .map(|_| {
            let started = Instant::now();
            window.harness.step();
            started.elapsed()
        })
        .collect();
    frames.sort();

    window.harness.get_by_label("Cancel").click();
    let asked = Instant::now();
    window.harness.step();
    while window.app().render_threads() > 0 {
        assert!(asked.elapsed() < DEADLINE, "the render does not stop");
        std::thread::sleep(Duration::from_millis(1));
    }
    let cancelled = asked.elapsed();
    println!(
        "first tile after {first_tile:.1?}; frames of {:.1?} (median) and {:.1?} (99 of 100); idle {cancelled:.1?} after Cancel",
        frames[50], frames[98]
    );
}
