//! The window, driven as a user drives it: by the names on its controls, by keys and by the mouse. Runs on software Vulkan
//! without a display; tests that need a GPU fail without an adapter.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::driver::{
    DEADLINE, Files, MESH, SCENE, Window, library_hash, load, set_number, set_samples,
};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, accesskit::Role};
use egui_kittest::kittest::{NodeT, Queryable};
use raymini::control::CancelToken;
use raymini::gui::App;
use raymini::gui::costs::CostState;
use raymini::gui::dialogs::Dialog;
use raymini::gui::jobs::Lane;
use raymini::gui::messages::Severity;
use raymini::gui::picture::{Outcome, Picture};
use raymini::gui::report::Outcome as ReportOutcome;
use raymini::gui::top_bar::View;
use raymini::math::DVec3;
use raymini::render::{Ending, Image, Layer, PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{Background, Display, Light, Output, Shadows, ToneCurve};
use serde_json::Value;

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

#[test]
fn unsaved_work_is_asked_about_before_it_is_replaced() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Cancel");
    assert!(window.app().dialog().is_none());
    assert_eq!(window.scene().lights.len(), 2);

    // Adding keeps what is there.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Add to scene");
    assert_eq!(window.scene().objects.len(), 2);
    assert_eq!(window.scene().objects[1].name, "pyramid 2");
    assert_eq!(window.scene().lights.len(), 2);
    window.settle();

    // Saving first writes the scene, then opens the other.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.click("Save first");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);
    assert_eq!(load(&files.path("room.toml")).objects.len(), 2);
}

#[test]
fn several_meshes_open_as_one_scene() {
    let files = Files::new();
    let other = files.write("other.off", MESH);
    let window = Window::start(vec![files.path("pyramid.off"), other], true);
    assert_eq!(window.scene().objects.len(), 2);
    assert!(!window.scene().lights.is_empty());
    assert!(!window.app().document().is_modified());
}

#[test]
fn a_mesh_of_several_materials_opens_and_is_added_in_parts() {
    let files = Files::new();
    let materials = "newmtl wood\nKd 0.6 0.4 0.2\nnewmtl chrome\nKd 0\nKs 0.9\nillum 3\n";
    files.write("chair.mtl", materials);
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let faces = "usemtl wood\nf 1 2 3\nusemtl chrome\nf 1 3 4\n";
    let chair = files.write("chair.obj", &format!("mtllib chair.mtl\n{vertices}{faces}"));
    let parts = |window: &Window| -> Vec<(String, Option<String>)> {
        let objects = window.scene().objects.iter();
        objects
            .map(|object| (object.name.clone(), object.material.clone()))
            .collect()
    };
    let expected = ["wood", "chrome"].map(|name| (name.to_owned(), Some(name.to_owned())));
    assert_eq!(parts(&Window::open(&chair)), expected);

    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&chair);
    window.import("Add to scene");
    assert_eq!(window.scene().objects.len(), 3);
    assert_eq!(parts(&window)[1..], expected);
    assert_eq!(window.scene().materials["chrome"].kind(), "mirror");
    // It stands in a scene with Z up.
    assert_eq!(window.scene().objects[1].rotate.x, 90.0);
    window.settle();
}

#[test]
fn framing_and_resetting_the_camera() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let home = window.scene().camera;
    window.press(Modifiers::NONE, Key::F);
    let framed = window.scene().camera;
    assert_ne!(framed, home);
    window.press(Modifiers::NONE, Key::Home);
    assert_eq!(window.scene().camera, home);
    window.click("Select pyramid");
    window.press(Modifiers::SHIFT, Key::F);
    assert_eq!(window.scene().camera, framed, "the only object is all");
}

/// A click selects what is under it, scrolling comes nearer to it, a double click turns the camera to it.
#[test]
fn the_mouse_selects_zooms_and_aims() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let on_the_pyramid = window.on_screen(DVec3::new(0.0, -0.6, 0.6));
    window.click_at(on_the_pyramid);
    assert!(window.has("Scale"), "the object's properties show");
    assert_eq!(window.scene().camera, load(&files.path("room.toml")).camera);

    let before = window.scene().camera;
    window.harness.hover_at(on_the_pyramid);
    window.harness.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(30);
    let nearer = window.scene().camera;
    assert!(nearer.eye.length() < before.eye.length() * 0.95);
    let still_there = window.on_screen(DVec3::new(0.0, -0.6, 0.6));
    assert!(still_there.distance(on_the_pyramid) < 8.0);

    window.clicks_at(still_there, 2);
    let aimed = window.scene().camera;
    assert_eq!(aimed.eye, nearer.eye);
    let target = aimed.target;
    assert!(
        target.distance(DVec3::new(0.0, -0.6, 0.6)) < 0.3,
        "{target}, before {}",
        nearer.target
    );
}

#[test]
fn a_lights_marker_moves_the_light() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F);
    let scene = window.scene();
    let camera = scene.camera;
    let position = scene.lights[0].position();
    // Where the marker is not in view, the camera steps back first.
    let eye = camera.target + (camera.eye - camera.target) * 3.0;
    window.harness.state_mut().document_mut().scene.camera.eye = eye;
    window.harness.run_steps(2);
    let marker = window.on_screen(position);
    window.drag(
        PointerButton::Primary,
        marker,
        marker + Vec2::new(40.0, 0.0),
    );
    let moved = window.scene().lights[0].position();
    assert_ne!(moved, position);
    assert_eq!(window.scene().camera.eye, eye, "the camera stays");
    assert!(
        window
            .on_screen(moved)
            .distance(marker + Vec2::new(40.0, 0.0))
            < 3.0
    );
}

/// A light that is dragged by its marker is where it was once Esc is pressed, and nothing is left to undo.
#[test]
fn esc_puts_a_dragged_light_back() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let camera = &mut window.harness.state_mut().document_mut().scene.camera;
    camera.eye = camera.target + (camera.eye - camera.target) * 3.0;
    window.settle();
    window.harness.run_steps(2);
    let before = window.scene().clone();
    let undo = window.app().document().undo_history().next_undo();
    let undo = undo.map(str::to_owned);
    let marker = window.on_screen(before.lights[0].position());
    let press = |pressed| Event::PointerButton {
        pos: marker,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.harness.hover_at(marker);
    window.harness.run_steps(1);
    window.harness.event(press(true));
    for step in 1..=3_u8 {
        let by = Vec2::new(25.0, 10.0) * f32::from(step);
        window.harness.hover_at(marker + by);
        window.harness.run_steps(1);
    }
    assert_ne!(window.scene().lights[0], before.lights[0]);
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.scene(), &before);
    // The button is still held, and nothing follows it any more.
    window.harness.hover_at(marker + Vec2::new(-40.0, 30.0));
    window.harness.run_steps(2);
    window.harness.event(press(false));
    window.harness.run_steps(2);
    assert_eq!(window.scene(), &before);
    let history = window.app().document().undo_history();
    assert_eq!(history.next_undo().map(str::to_owned), undo);
}

fn write_image(path: &Path) {
    let pixel = |i: u8| image::Rgb([f32::from(i), 2.0, 30.0 - f32::from(i)]);
    let pixels: Vec<_> = (0..32).map(pixel).collect();
    image::codecs::hdr::HdrEncoder::new(std::fs::File::create(path).unwrap())
        .encode(&pixels, 8, 4)
        .unwrap();
}

/// An image dropped on the window lights the scene, turns in the panel, and is saved with it.
#[test]
fn a_dropped_image_becomes_the_background() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let sky = files.path("sky.hdr");
    write_image(&sky);
    window.drop_file(sky);
    window.until("the image is there", |app| {
        matches!(app.document().scene.background, Background::Image { .. })
    });
    window.settle();
    assert_eq!(
        window.app().messages().last_news(),
        "The background is sky.hdr"
    );
    assert!(window.app().document().is_modified());
    assert!(window.has("Rotation"), "its properties show");
    window.render();
    let hash = window.hash();
    assert_eq!(hash, library_hash(window.scene()));

    if let Background::Image { rotation, .. } =
        &mut window.harness.state_mut().document_mut().scene.background
    {
        rotation.0 = 75.0;
    }
    window.harness.run_steps(2);
    window.render();
    assert_ne!(window.hash(), hash);

    let toml = files.path("lit.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&toml);
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert_eq!(library_hash(&load(&toml)), window.hash());
}

/// Dropping opens a picture that tells what was rendered; another one in the same format becomes the background.
#[test]
fn a_dropped_picture_is_opened_where_it_tells_what_was_rendered() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    let render = files.path("render.exr");
    window.save_picture(&render);

    let sky = files.path("sky.exr");
    let white = Image {
        width: 8,
        height: 4,
        pixels: vec![[1.0; 3]; 32],
    };
    let (display, output) = (Display::default(), Output::default());
    raymini::io::write_image(&white, &[], &display, &output, &sky).unwrap();
    let is_lit_by_image = |app: &App| {
        let background = &app.document().scene.background;
        matches!(background, Background::Image { .. })
    };
    window.drop_file(sky);
    window.until("the image is there", is_lit_by_image);
    window.settle();

    window.drop_file(render);
    window.until("unsaved work is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    window.click("Replace");
    window.until("it is open", |app| app.document().name() == "render");
    window.settle();
    assert!(!is_lit_by_image(window.app()));
    let picture = window.app().picture_on_screen().expect("it is in the file");
    let Outcome::Opened { hash: opened, .. } = &picture.outcome else {
        panic!("the picture is {:?}", picture.outcome);
    };
    assert_eq!(opened.as_ref(), Some(&hash));
}

#[test]
fn an_image_that_cannot_be_read_gets_a_banner_and_the_background_stays() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let before = window.scene().clone();
    let broken = files.write("sky.exr", "no image");
    window.press(Modifiers::COMMAND, Key::B);
    window.enter_path(&broken);
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    let banner = window.app().messages().banners()[0].clone();
    assert_eq!(banner.title, "Cannot use sky.exr as the background");
    assert!(banner.text.contains("expected OpenEXR"), "{}", banner.text);
    assert_eq!(window.scene(), &before);
}

#[test]
fn dropped_files_open() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.drop_file(files.path("pyramid.off"));
    window.import("Replace");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    window.settle();
    assert_eq!(window.scene().objects.len(), 1);
}

#[test]
fn closing_asks_about_unsaved_work() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Add light");
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Save first");
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);
}

/// Questions wait for one another, and none is answered by what was meant for another one.
#[test]
fn what_comes_from_outside_waits_for_the_question_that_shows() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.click("Add light");
    window.ask_to_close();
    window.click("Save first");
    let is_path = |app: &App| matches!(app.dialog(), Some(Dialog::Path(_)));
    assert!(is_path(window.app()), "there is no file yet");
    window.drop_file(files.path("pyramid.off"));
    window.harness.step();
    window.until("the mesh is read", |app| !app.works_in(Lane::Load));
    assert!(is_path(window.app()), "the path is still being typed");
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Unsaved(_))));
    window.click("Cancel");
    assert!(is_path(window.app()), "it comes back");
    window.press(Modifiers::NONE, Key::Escape);
    assert!(matches!(window.app().dialog(), Some(Dialog::Import(_))));
    window.click("Add to scene");
    assert_eq!(window.scene().objects.len(), 2);
    // Closing was given up with the path: saving now closes nothing.
    window.press(Modifiers::COMMAND, Key::S);
    window.enter_path(&files.path("saved.toml"));
    window.until("the scene is saved", |app| !app.document().is_modified());
    assert!(!is_told_to_close(&window));
}

/// Whether the window told the desktop in the last frame to close it.
pub fn is_told_to_close(window: &Window) -> bool {
    let output = window.harness.output().viewport_output.values();
    let mut commands = output.flat_map(|viewport| &viewport.commands);
    commands.any(|command| *command == egui::ViewportCommand::Close)
}

/// Starts a render that does not end by itself, with nothing unsaved.
fn start_long_render(window: &mut Window) {
    set_samples(window, 100_000);
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the scene is saved", |app| !app.document().is_modified());
    window.press(Modifiers::NONE, Key::F5);
    window.until("it runs", |app| {
        app.picture()
            .is_some_and(|picture| picture.first_tile.is_some())
    });
}

#[test]
fn closing_asks_before_a_render_is_given_up() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    for answer in ["Go on", "Give up and close"] {
        window.ask_to_close();
        assert!(matches!(window.app().dialog(), Some(Dialog::Running)));
        assert!(window.app().picture().is_some_and(Picture::is_running));
        window.harness.get_by_label(answer).click();
        let mut is_closed = false;
        for _ in 0..4 {
            window.harness.step();
            is_closed |= is_told_to_close(&window);
        }
        assert_eq!(is_closed, answer != "Go on");
    }
}

#[test]
fn what_is_done_beside_a_render_is_told() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    start_long_render(&mut window);
    window.press(Modifiers::COMMAND, Key::E);
    window.enter_path(&files.path("part.png"));
    let news = "Saved what there is to";
    window.until("it is saved", |app| {
        app.messages().last_news().starts_with(news)
    });
    assert!(window.app().picture().is_some_and(Picture::is_running));
    assert!(window.says(news));
}

/// A picture that is being written shows, holds up closing and is cancelled by its button.
#[cfg(unix)]
#[test]
fn saving_a_picture_can_be_cancelled() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    // Writing to a pipe waits until somebody reads from it.
    let pipe = files.path("pipe.png");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    window.press(Modifiers::COMMAND, Key::E);
    window.enter_path(&pipe);
    assert!(window.says("Saving pipe.png"));
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Running)));
    assert!(window.has("Give up saving the picture?"));
    window.click("Go on");
    assert!(window.app().dialog().is_none());
    window.click("Cancel saving the picture");
    // Open both ways, it waits for nobody.
    let mut ends = std::fs::File::options();
    let reader = ends.read(true).write(true).open(&pipe).unwrap();
    window.until("it is told", |app| {
        app.messages().last_news() == "Saving cancelled"
    });
    assert!(!window.has("Cancel saving the picture"));
    assert!(!window.says("Saving pipe.png"));
    drop(reader);
}

/// However slow a frame is, every press of a key counts.
#[test]
fn keys_that_come_in_one_frame_all_count() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    for _ in 0..3 {
        window.operate("Add light");
    }
    assert_eq!(window.scene().lights.len(), 4);
    for pressed in [true, false, true, false, true, false] {
        window.harness.input_mut().events.push(Event::Key {
            key: Key::Z,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::COMMAND,
        });
    }
    window.harness.run_steps(2);
    assert_eq!(window.scene().lights.len(), 1);
    assert!(window.app().messages().last_news().starts_with("Undone"));
    window.operate("Add light");
    assert!(!window.app().messages().last_news().starts_with("Undone"));
}

#[test]
fn the_path_field_goes_into_folders_and_begins_anew() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.press(Modifiers::COMMAND, Key::O);
    let folder = files.folder.path().to_str().unwrap().to_owned();
    window.enter("Path", &format!("/somewhere/{folder}"));
    assert!(matches!(window.app().dialog(), Some(Dialog::Path(_))));
    window.until_says("room.toml");
}

/// The extension that is added counts.
#[test]
fn a_file_that_will_be_replaced_is_told_of() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.fill("Path", files.path("room").to_str().unwrap());
    window.until_says("A file of this name is there");
    let scene_file = || std::fs::read_to_string(files.path("room.toml")).unwrap();
    // Enter goes no further than to ask, and then nowhere.
    window.press(Modifiers::NONE, Key::Enter);
    assert!(window.has("Replace room.toml?"));
    window.press(Modifiers::NONE, Key::Enter);
    assert!(matches!(window.app().dialog(), Some(Dialog::Path(_))));
    window.enter_path(&files.path("room.toml"));
    window.click("Cancel");
    assert!(window.app().dialog().is_none());
    assert_eq!(scene_file(), SCENE);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&files.path("room"));
    window.click("Replace");
    window.until_saved(&files.path("room.toml"));
    assert_ne!(scene_file(), SCENE);
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

#[test]
fn every_command_is_on_the_sheet() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.press(Modifiers::NONE, Key::F1);
    assert!(matches!(window.app().dialog(), Some(Dialog::Shortcuts)));
    for command in raymini::gui::commands::Command::ALL {
        assert!(window.has(command.description()), "{command:?}");
    }
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.app().dialog().is_none());
    for key in [Key::F1, Key::Questionmark] {
        window.press(Modifiers::NONE, key);
        assert!(matches!(window.app().dialog(), Some(Dialog::Shortcuts)));
        window.press(Modifiers::NONE, key);
        assert!(window.app().dialog().is_none(), "{key:?} again");
    }
}

/// What is written in the window, and where the middle of it is.
fn texts_drawn(window: &Window) -> impl Iterator<Item = (&str, Pos2)> {
    let shapes = window.harness.output().shapes.iter();
    shapes.filter_map(|clipped| match &clipped.shape {
        egui::Shape::Text(text) => {
            let place = text.visual_bounding_rect().center();
            Some((text.galley.text(), place))
        }
        _ => None,
    })
}

/// Every command is in a menu, with its keys in the same line, and on the sheet, with the same keys and all others.
#[test]
fn menus_name_the_keys_of_the_sheet() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let ctx = window.harness.ctx.clone();
    let mut seen = Vec::new();
    for menu in ["File", "Edit", "View", "Render menu", "Help"] {
        window.click(menu);
        for command in raymini::gui::commands::Command::ALL {
            let keys = command.shortcut_text(&ctx);
            let is_item = |node: &egui_kittest::Node<'_>| {
                let node = node.accesskit_node();
                node.label()
                    .is_some_and(|label| label.starts_with(command.label()))
            };
            let root = window.harness.root();
            let items = root.children_recursive().filter(is_item);
            let mut rects = items.map(|item| item.rect());
            // Its keys are drawn in the same line.
            let is_named = rects.any(|rect| {
                let mut texts = texts_drawn(&window);
                texts.any(|(text, place)| text == keys && rect.contains(place))
            });
            if is_named {
                seen.push(command);
            }
        }
        window.press(Modifiers::NONE, Key::Escape);
    }
    for command in raymini::gui::commands::Command::ALL {
        assert!(
            seen.contains(&command),
            "no menu names the keys of {command:?}"
        );
    }
    window.press(Modifiers::NONE, Key::F1);
    for command in raymini::gui::commands::Command::ALL {
        let keys: Vec<_> = command.shortcut_texts(&ctx).collect();
        let line = window.harness.get_by_label(command.description()).rect();
        let keys = keys.join(",  ");
        let mut named = window.harness.query_all_by_label(&keys);
        let is_beside = named.any(|text| (text.rect().center().y - line.center().y).abs() < 30.0);
        assert!(is_beside, "{command:?}: {keys}");
    }
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

/// Opens the window of the report by its menu entry, and has it written to `folder`.
fn ask_for_report(window: &mut Window, folder: &Path) {
    window.click("Render menu");
    window.harness.get_by_label_contains("Report…").click();
    window.harness.run_steps(3);
    assert!(window.app().report().open);
    window.enter("Folder", folder.to_str().unwrap());
}

fn wait_for_report(window: &mut Window) {
    window.until("the report is done", |app| !app.report().is_running());
}

fn json_of(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("report.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Keys without values: what a reader of a file can rely on. Whether a time is foreseen is up to the clock.
fn keys_of(value: &Value) -> Value {
    match value {
        Value::Object(fields) => {
            let keys = fields.iter().map(|(key, value)| {
                let keys = match key.as_str() {
                    "time_to" => Value::Null,
                    _ => keys_of(value),
                };
                (key.clone(), keys)
            });
            keys.collect()
        }
        Value::Array(items) => items.iter().map(keys_of).collect(),
        _ => Value::Null,
    }
}

/// The report of what the window shows, not of what is on disk, is the one the command makes once the scene is saved.
#[test]
fn a_report_is_the_commands_of_the_scene_as_it_is() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Select Light 1");
    window.click("Kind: Disk");
    assert!(window.app().document().is_modified());
    let folder = files.path("new/report");
    ask_for_report(&mut window, &folder);
    assert!(window.says("changes that are not saved included"));
    set_number(&mut window, "Seeds", "2");
    set_number(&mut window, "Picture width", "32");
    set_number(&mut window, "Picture height", "24");
    window.click("Compare with");
    window
        .harness
        .get_by_label_contains("4 shadow rays")
        .click();
    window.harness.run_steps(3);
    assert!(window.says("4 renders, after one of 256 samples"));
    window.click("Start");
    assert!(window.app().report().is_running());
    wait_for_report(&mut window);

    let run = window.app().report().run().expect("its result shows");
    assert_eq!(run.outcome, ReportOutcome::Finished);
    assert_eq!(run.folder, folder);
    let findings = run.findings().expect("there are some");
    assert_eq!(findings.variants.len(), 2);
    assert_eq!(findings.variants[0].1.points.len(), 5);
    assert!(findings.chart.curves.iter().all(|c| !c.points.is_empty()));
    assert!(window.says("noise after"));
    assert!(window.says("render.shadow_samples=4"));
    assert!(window.says(folder.to_str().unwrap()));
    // The scene keeps its size, and its changes are still not saved.
    assert_eq!(window.scene().render.width, 160);
    assert!(window.app().document().is_modified());

    let toml = files.path("saved.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&toml);
    window.until("the scene is saved", |app| !app.document().is_modified());
    let by_command = files.path("by-command");
    let status = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .arg("report")
        .arg(&toml)
        .args(["--seeds", "2", "--size", "32x24", "--compare"])
        .args(["render.shadow_samples=4", "-o"])
        .arg(&by_command)
        .stdout(Stdio::null())
        .status();
    assert!(status.unwrap().success());
    let (ours, commands) = (json_of(&folder), json_of(&by_command));
    assert_eq!(keys_of(&ours), keys_of(&commands));
    assert_eq!(ours["finished"], true);
    assert_eq!(ours["settings"], commands["settings"]);
    assert_eq!(ours["reference"]["rmse"], commands["reference"]["rmse"]);
    for points in ["/points", "/variants/0/points"] {
        for (point, expected) in std::iter::zip(
            ours.pointer(points).unwrap().as_array().unwrap(),
            commands.pointer(points).unwrap().as_array().unwrap(),
        ) {
            for key in ["samples_per_pixel", "true_relmse", "estimated_relmse"] {
                assert_eq!(point[key], expected[key], "{key} in {points}");
            }
        }
    }
    let lines = |folder: &Path, name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        text.lines().map(str::to_owned).collect()
    };
    for name in ["report.svg", "report.csv"] {
        let [ours, commands] = [&folder, &by_command].map(|folder| lines(folder, name));
        assert_eq!(ours[0], commands[0], "{name}");
    }
    // Its title is what the scene was called, which was not saved under that name.
    let headings = |folder| {
        let lines = lines(folder, "report.md").into_iter();
        let headings = lines.filter(|line| line.starts_with('#')).skip(1);
        headings.collect::<Vec<_>>()
    };
    assert_eq!(headings(&folder), headings(&by_command));
    assert!(headings(&folder).contains(&"## Summary".to_owned()));

    // The next report starts from the same wishes.
    window.click("New report");
    assert!(window.says("4 renders, after one of 256 samples"));
}

/// However quickly they follow on one another, clicks on Pause and Resume are two; the second one on what takes the place of Render is none.
#[test]
fn quick_clicks_mean_the_button_that_was_aimed_at() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 100_000);
    let place = window.rect("Render").center();
    let click = |window: &mut Window| {
        for pressed in [true, false] {
            window.harness.event(Event::PointerButton {
                pos: place,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            });
        }
        window.harness.step();
    };
    window.harness.event(Event::PointerMoved(place));
    window.harness.step();
    click(&mut window);
    click(&mut window);
    window.harness.run_steps(3);
    let picture = |window: &Window| {
        let picture = window.app().picture().expect("one was asked for");
        (picture.is_running(), picture.is_paused())
    };
    assert_eq!(picture(&window), (true, false));
    for is_paused in [true, false, true, false] {
        window.click(if is_paused { "Pause" } else { "Resume" });
        assert_eq!(picture(&window), (true, is_paused));
    }
}

/// A report stops a render, refuses others, lets the scene be edited, and stops at once when told to.
#[test]
fn a_report_has_the_processor_to_itself_until_it_is_cancelled() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    let folder = files.path("report");
    ask_for_report(&mut window, &folder);
    assert!(window.says("The render that is going on is stopped first"));
    window.click("Start");
    assert_eq!(window.app().picture().unwrap().outcome, Outcome::Cancelled);
    window.until("the reference is rendered", |app| {
        let run = app.report().run();
        run.is_some_and(|run| run.progress.how_far().0 > 0.0)
    });

    window.click("Hide");
    assert!(!window.app().report().open);
    assert!(window.says("Report: reference"));
    window.press(Modifiers::NONE, Key::F5);
    assert_eq!(window.app().picture().unwrap().outcome, Outcome::Cancelled);
    window.click("Add light");
    assert_eq!(window.scene().lights.len(), 2);
    assert!(window.app().report().is_running());

    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.click("Cancel report");
    assert!(!window.app().report().is_running());
    window.until("threads have stopped", |app| app.render_threads() == 0);
    assert!(!folder.join("report.json").exists());
    assert_eq!(window.app().messages().last_news(), "Report cancelled");
    // What was typed is still there, and rendering is possible again.
    let field = window
        .harness
        .get_by_role_and_label(Role::TextInput, "Folder");
    assert_eq!(field.value().as_deref(), folder.to_str());
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.app().report().open);
    set_samples(&mut window, 2);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));
}

/// Reports that are stopped in the middle keep what was measured, on the screen and on disk.
#[test]
fn a_cancelled_report_keeps_what_it_has_measured() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let folder = files.path("report");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.click("Choose the folder");
    window.enter_path(&folder);
    set_number(&mut window, "Seeds", "1000");
    window.click("Start");
    window.until("a render is measured", |app| {
        app.report()
            .run()
            .is_some_and(|run| run.findings().is_some())
    });
    window.press(Modifiers::NONE, Key::Escape);
    let run = window.app().report().run().expect("what is known shows");
    assert_eq!(run.outcome, ReportOutcome::Cancelled);
    assert!(window.says("this is what was measured until then"));
    window.until("threads have stopped", |app| app.render_threads() == 0);
    let facts = json_of(&folder);
    assert_eq!(facts["finished"], false);
    assert_eq!(facts["points"].as_array().unwrap().len(), 5);
}

#[test]
fn mistakes_in_a_report_are_told_where_they_are_made() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let folder = files.path("report");
    ask_for_report(&mut window, &files.path("pyramid.off/report"));
    set_number(&mut window, "Seeds", "1");
    window.click("Start");
    wait_for_report(&mut window);
    assert!(window.says("the folder cannot be made"));

    window.enter("Folder", folder.to_str().unwrap());
    window.click("Compare with");
    window.click("Other settings");
    for (wrong, expected) in [
        ("", "expected KEY=VALUE"),
        ("render.filtre=tent", "filtre"),
        ("render.filter=tentt", "tentt"),
        ("render.width=25", "all pictures must be of one size"),
    ] {
        window.enter("Comparison 1", wrong);
        window.click("Start");
        wait_for_report(&mut window);
        assert!(window.says(expected), "{expected}");
        assert!(!window.says("--"), "options are the command's");
    }
    window.click("Remove comparison 1");
    assert!(!window.says("all pictures must be of one size"));

    window.click("Reference: Exact");
    window.enter("Its radiance", "1,1");
    window.click("Start");
    assert!(!window.app().report().is_running());
    assert!(window.says("expected red, green, blue"));
    window.click("Reference: File");
    window.click("Choose the reference");
    window.enter_path(&files.path("none.exr"));
    window.click("Start");
    wait_for_report(&mut window);
    assert!(window.says("none.exr: "));
    assert!(!folder.exists(), "nothing is made before all is right");

    // Nothing of it has changed the scene, and all put right it goes through.
    assert!(!window.app().document().is_modified());
    window.click("Reference: Exact");
    window.enter("Its radiance", "1, 1, 1");
    window.click("Start");
    wait_for_report(&mut window);
    assert_eq!(json_of(&folder)["reference"]["kind"], "exact");
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
