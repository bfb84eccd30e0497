//! The renders of a session: looked at again, saved, restored.

use crate::driver::{Files, SCENE, Window, library_hash, load, set_samples};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use raymini::control::{CancelToken, Progress};
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::document::same_picture;
use raymini::gui::picture::Picture;
use raymini::gui::renders::Facts;
use raymini::gui::top_bar::View;
use raymini::io::{WrittenOrigin, read_image, read_render};
use raymini::render::Layer;
use raymini::render::display::encode_8;
use raymini::scene::Shadows;

/// The numbers of the renders before the present one.
fn past(window: &Window) -> Vec<usize> {
    let entries = window.app().renders().entries().iter();
    entries.map(|entry| entry.facts.number).collect()
}

fn number_on_screen(window: &Window) -> Option<usize> {
    window
        .app()
        .picture_on_screen()
        .map(|picture| picture.number)
}

/// Three renders: with shadows, without, and one that is cancelled. The strip is open.
fn three_renders(files: &Files) -> Window {
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Renders");
    assert!(window.says("the picture is kept here"));
    window.render();
    window.operate("Shadows: Off");
    set_samples(&mut window, 5);
    window.render();
    set_samples(&mut window, 1_000_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
    window.harness.run_steps(5);
    window
}

#[test]
fn renders_are_looked_at_again_and_saved() {
    let files = Files::new();
    let mut window = three_renders(&files);
    assert_eq!(past(&window), [1, 2]);
    let entries = window.app().renders().entries();
    let hashes: Vec<_> = entries
        .iter()
        .map(|e| e.facts.hash().unwrap().to_owned())
        .collect();
    assert_ne!(hashes[0], hashes[1]);
    assert_eq!(window.app().picture().unwrap().number, 3);
    assert!(window.says("cancelled"));

    window.click("Show render 1");
    assert_eq!(number_on_screen(&window), Some(1));
    window.until("it is on the screen", |app| {
        app.picture_on_screen().is_some_and(Picture::is_shown)
    });
    assert!(window.says(&hashes[0][..16]));
    assert!(window.says("direct, 160 × 120, 4 samples"));

    // What is saved is what is looked at.
    let png = files.path("first.png");
    window.click("Save shown picture");
    window.enter_path(&png);
    window.until_saved(&png);
    let picture: &Picture = window.app().picture_on_screen().unwrap();
    let display = picture.scene.display;
    let pixels = picture.buffer.image().pixels;
    assert_eq!(picture.buffer.image().hash(), hashes[0]);
    let expected: Vec<u8> = pixels
        .iter()
        .flat_map(|&rgb| encode_8(rgb, &display))
        .collect();
    assert_eq!(image::open(&png).unwrap().to_rgb8().into_raw(), expected);

    // Keys go from one to the next.
    window.press(Modifiers::NONE, Key::PageDown);
    assert_eq!(number_on_screen(&window), Some(2));
    window.press(Modifiers::NONE, Key::PageDown);
    assert_eq!(number_on_screen(&window), Some(3));
    window.press(Modifiers::NONE, Key::PageDown);
    assert_eq!(number_on_screen(&window), Some(3));
    window.press(Modifiers::NONE, Key::PageUp);
    assert_eq!(number_on_screen(&window), Some(2));

    // A new exposure holds for whatever is looked at.
    window
        .harness
        .state_mut()
        .document_mut()
        .scene
        .display
        .exposure = 1.5;
    window.harness.run_steps(3);
    window.press(Modifiers::NONE, Key::PageUp);
    window.until("it is on the screen", |app| {
        app.picture_on_screen().is_some_and(Picture::is_shown)
    });
    let shown = window.app().picture_on_screen().unwrap();
    assert!((shown.scene.display.exposure - 1.5).abs() < 1e-12);
}

#[test]
fn settings_are_restored_in_one_step_that_can_be_undone() {
    let files = Files::new();
    let mut window = three_renders(&files);
    let before = window.scene().clone();
    assert_eq!(before.render.shadows, Shadows::Off);
    window.click("Show render 1");
    let hash = window
        .app()
        .renders()
        .entry(1)
        .unwrap()
        .facts
        .hash()
        .unwrap()
        .to_owned();
    window.click("Restore settings");
    assert_ne!(window.scene(), &before);
    assert_eq!(window.scene().render.shadows, Shadows::Soft);
    let next = window.app().document().undo_history().next_undo();
    assert_eq!(next, Some("restoring the settings of render 1"));
    window.render();
    assert_eq!(window.hash(), hash);
    assert_eq!(window.hash(), library_hash(window.scene()));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene(), &before);
}

/// What is under a small picture is to be read, however narrow that is.
#[test]
fn the_line_under_a_narrow_picture_is_not_cut_off() {
    let files = Files::new();
    let size = "width = 160\nheight = 120";
    assert!(SCENE.contains(size));
    let narrow = SCENE.replace(size, "width = 20\nheight = 200");
    let mut window = Window::open(&files.write("narrow.toml", &narrow));
    window.click("Renders");
    window.render();
    window.harness.run_steps(3);
    let facts = Facts::of(window.app().picture().unwrap());
    let line = format!("1  {}", facts.result());
    assert!(line.contains("noise"), "{line}");
    let (font, ink) = (egui::FontId::proportional(11.0), egui::Color32::WHITE);
    let galley = window
        .harness
        .ctx
        .fonts_mut(|fonts| fonts.layout_no_wrap(line, font, ink));
    assert!(window.rect("Show render 1").width() >= galley.size().x);
}

/// Until a click on Forget is no second one of a double click.
fn wait_after_forgetting(window: &mut Window) {
    window.harness.run_steps(40);
}

/// The next render comes under the pointer, and the second of two quick clicks is not meant for it.
#[test]
fn a_double_click_forgets_one_render() {
    let files = Files::new();
    let mut window = three_renders(&files);
    let forget = window.rect("Forget").center();
    window.clicks_at(forget, 2);
    assert_eq!(past(&window), [1, 2]);
    wait_after_forgetting(&mut window);
    window.click_at(forget);
    assert_eq!(past(&window), [1]);
}

/// The last render is forgotten as any other, and the one before is looked at.
#[test]
fn the_last_render_is_forgotten_too() {
    let files = Files::new();
    let mut window = three_renders(&files);
    for (present, left) in [(3, vec![1, 2]), (2, vec![1]), (1, vec![])] {
        assert_eq!(number_on_screen(&window), Some(present));
        window.click("Forget");
        assert_eq!(past(&window), left);
        assert!(window.app().picture().is_none());
        wait_after_forgetting(&mut window);
    }
    assert_eq!(window.app().view(), View::Preview);
    window.click("Render");
    window.until("another render has begun", |app| app.picture().is_some());
    assert_eq!(
        number_on_screen(&window),
        Some(4),
        "no number means two renders"
    );
}

#[test]
fn renders_are_forgotten_and_outlive_their_scene() {
    let files = Files::new();
    let mut window = three_renders(&files);
    window.click("Show render 2");
    window.click("Forget");
    assert_eq!(past(&window), [1]);
    assert_eq!(number_on_screen(&window), Some(3));
    window
        .harness
        .get_by_label("Show render 1")
        .click_secondary();
    window.harness.run_steps(3);
    let restore = window.harness.query_all_by_label("Restore settings");
    assert_eq!(restore.count(), 2, "beside the strip, and in the menu");
    window.press(Modifiers::NONE, Key::Escape);

    // The scene is unsaved; another one takes its place, and the renders stay.
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&files.path("pyramid.off"));
    window.import("Replace");
    window.click("Replace");
    window.until("the mesh is open", |app| app.document().name() == "pyramid");
    window.settle();
    assert_eq!(past(&window), [1, 3]);
    assert_eq!(window.app().view(), View::Preview);
    window.click("Show render 1");
    assert_eq!(number_on_screen(&window), Some(1));
    window.press(Modifiers::NONE, Key::Num1);
    assert_eq!(number_on_screen(&window), None);

    // A render of the new scene goes on with the numbers.
    let render = &mut window.harness.state_mut().document_mut().scene.render;
    (render.width, render.height) = (64, 48);
    window.render();
    assert_eq!(number_on_screen(&window), Some(4));
}

/// What is edited beside a running render does not start it anew, also when it is looked at again: only what is edited while it is looked at does.
#[test]
fn a_running_render_goes_on_until_it_is_edited_while_it_is_looked_at() {
    let files = Files::new();
    let mut window = three_renders(&files);
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("tiles arrive", |app| {
        app.picture()
            .is_some_and(|p| p.is_running() && p.first_tile.is_some())
    });
    window.click("Show render 1");
    window.operate("Shadows: Soft");
    window.harness.run_steps(5);
    let running = window.app().picture().unwrap();
    assert!(running.is_running());
    assert_eq!(running.scene.render.shadows, Shadows::Off);
    assert_eq!(number_on_screen(&window), Some(1));

    let started = running.started();
    let goes_on = |window: &mut Window| {
        window.harness.run_steps(5);
        let running = window.app().picture().expect("it runs");
        assert!(running.is_running() && running.started() == started);
        assert_eq!(number_on_screen(window), Some(4));
        assert!(window.says("settings changed: F5 restarts"));
    };
    window.click("Show render 4");
    goes_on(&mut window);
    // The same with settings that are restored, and with a camera that is moved in the preview.
    window.click("Show render 1");
    window.click("Restore settings");
    window.click("Show render 4");
    goes_on(&mut window);
    window.click("Preview");
    let middle = window.rect("Viewport").center();
    let camera = window.scene().camera;
    let to = middle + egui::Vec2::new(60.0, 20.0);
    window.drag(egui::PointerButton::Primary, middle, to);
    assert_ne!(window.scene().camera, camera);
    window.click("Picture");
    goes_on(&mut window);

    // Edited now, it starts anew with all of it; what was replaced is not kept.
    set_samples(&mut window, 90_000);
    window.operate("Shadows: Off");
    window.until("it starts anew", |app| {
        app.picture()
            .is_some_and(|p| p.is_running() && p.started() != started)
    });
    let picture = window.app().picture().unwrap();
    assert!(same_picture(&picture.scene, window.scene()));
    assert_eq!(past(&window), [1, 2, 3]);
    window.click("Cancel");
    window.until("threads have stopped", |app| app.render_threads() == 0);
}

/// The picture on screen from a file that a window saved, in another window.
#[test]
fn a_saved_picture_opens_with_its_scene() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    let layers = window.app().picture().unwrap().buffer.layer_images();
    assert!(layers.iter().any(|(layer, _)| *layer == Layer::Error));
    let save = |window: &mut Window, name: &str| {
        let path = files.path(name);
        window.save_picture(&path);
        path
    };
    let linear = save(&mut window, "plain.exr");
    let shown = save(&mut window, "plain.png");
    window.operate("Tone curve: ACES");
    window.harness.run_steps(5);
    let looks = save(&mut window, "aces.png");
    drop(window);

    let mut window = Window::open(&linear);
    window.until("it is on the screen", |app| {
        app.picture_on_screen().is_some_and(Picture::is_shown)
    });
    assert_eq!(window.app().view(), View::Picture);
    assert!(window.says("from plain.exr"));
    assert_eq!(past(&window), [1]);
    let facts = &window.app().renders().entries()[0].facts;
    assert_eq!(facts.hash(), Some(hash.as_str()), "the very pixels");
    assert!(facts.noise.is_some_and(|noise| noise > 0.0));
    assert!(window.app().picture().is_none(), "nothing is rendered");
    let opened = window.app().picture_on_screen().unwrap();
    assert_eq!(opened.buffer.layer_images(), layers);
    window.operate("Layer");
    window.operate("Error of each pixel");
    window.harness.run_steps(5);
    assert!(window.says("W/m²/sr or more"));
    // Saved again, it still tells how wrong it is, and all else there was.
    let again = save(&mut window, "again.exr");
    let [first, second] = [&linear, &again].map(|path| WrittenOrigin::of_file(path).unwrap().error);
    assert!(first.is_some());
    assert_eq!(first, second);
    let progress = Progress::new();
    let kept = read_render(&again, &CancelToken::new(), &progress);
    assert_eq!(kept.unwrap().unwrap().layers.unwrap(), layers);
    window.operate("Layer");
    window.operate("Whole picture");

    // It is one to compare with, as any other.
    window.render();
    assert_eq!(window.hash(), hash);
    window.press(Modifiers::NONE, Key::C);
    window.until("they are the same", |app| {
        let distance = app.comparison().and_then(|c| c.distance());
        distance.is_some_and(|d| d.as_ref().is_ok_and(|d| d.rmse == 0.0))
    });

    let window_of = |path: &std::path::Path| {
        let mut window = Window::open(path);
        window.settle();
        window
    };
    let window = window_of(&shown);
    let entry = &window.app().renders().entries()[0];
    assert!(entry.facts.hash().is_none(), "eight bits are not the light");
    assert_eq!(window.app().view(), View::Picture);
    // What a tone curve made of it cannot be taken back.
    let window = window_of(&looks);
    assert!(window.app().renders().entries().is_empty());
    assert_eq!(window.app().view(), View::Preview);
}

/// A file that has rounded a picture tells the hash of what was rendered, also when it is saved again, and never that of the rounded pixels.
#[test]
fn a_rounded_picture_that_is_saved_again_has_the_hash_of_the_render() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    let shown = files.path("shown.png");
    window.save_picture(&shown);
    drop(window);

    let mut window = Window::open(&shown);
    window.until("it is on the screen", |app| {
        app.picture_on_screen().is_some_and(Picture::is_shown)
    });
    assert!(!window.says(&hash[..8]), "what is shown is rounded");
    let told = |path: &std::path::Path| WrittenOrigin::of_file(path).unwrap().rendered_hash;
    let [png, exr] = ["again.png", "again.exr"].map(|name| files.path(name));
    for path in [&shown, &png, &exr] {
        if *path != shown {
            window.save_picture(path);
        }
        assert_eq!(told(path).as_ref(), Some(&hash), "{}", path.display());
        assert_ne!(read_image(path).unwrap().image.hash(), hash);
    }
    drop(window);
    let mut window = Window::open(&exr);
    window.settle();
    let entry = &window.app().renders().entries()[0];
    assert_eq!(entry.facts.hash(), None, "they are not the light");
    let png = files.path("once more.png");
    window.save_picture(&png);
    assert_eq!(told(&png), Some(hash));
}

/// A render goes on with its own scene while another is open, and there is undone to it. What it has reached when another is asked for is
/// among the renders.
#[test]
fn a_render_goes_on_while_another_scene_is_open() {
    let files = Files::new();
    let long = SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 100_000");
    files.write("room.toml", &long);
    let other = files.write("other.toml", SCENE);
    let mut window = Window::open(&files.path("room.toml"));
    window.click("Render");
    window.until("it runs", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.drop_file(other);
    window.harness.step();
    window.until("the other is open", |app| app.document().name() == "other");
    window.settle();
    let of_room = "a picture of room: F5 renders this scene instead";
    for key in [Key::Num1, Key::Num2] {
        window.press(Modifiers::NONE, key);
        assert!(window.says(of_room));
    }
    let samples = |app: &App| {
        let picture = app.picture().filter(|picture| picture.is_running());
        picture.map(|picture| picture.progress.samples.done())
    };
    let before = samples(window.app()).expect("it runs");
    window.until("it goes on", |app| samples(app) > Some(before));

    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.app().document().name(), "room");
    assert!(!window.says(of_room) && !window.says("settings changed"));
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(window.app().document().name(), "other");
    window.settle();
    assert!(window.says(of_room) && samples(window.app()).is_some());
    window.ask_to_close();
    assert!(matches!(window.app().dialog(), Some(Dialog::Running)));
    window.click("Go on");

    window.press(Modifiers::NONE, Key::F5);
    window.until("the other is rendered", |app| {
        let picture = app.picture();
        picture.is_some_and(|picture| picture.number == 2 && !picture.is_running())
    });
    assert_eq!(window.hash(), library_hash(window.scene()));
    let entries = window.app().renders().entries();
    assert_eq!(entries.len(), 1);
    assert_eq!(entries[0].scene.render.samples_per_pixel, 100_000);
    assert!(!window.says(of_room));
}

/// Another scene may be open by now. Saving does not write the one that was rendered over its file, nor over what the other is by now.
#[test]
fn settings_of_another_scene_are_restored_as_a_scene_without_a_file() {
    let files = Files::new();
    let one = files.write("one.toml", &SCENE.replace("60.0, 60.0", "7.0, 7.0"));
    let room = files.path("room.toml");
    let mut window = Window::open(&room);
    window.click("Renders");
    window.render();
    let (hash, rendered) = (window.hash(), window.scene().clone());
    open_other(&mut window, &one);
    let edited = window.scene().clone();
    assert!(!same_picture(&edited, &rendered));
    window.click("Show render 1");
    window.click("Restore settings");
    window.settle();
    let document = window.app().document();
    assert_eq!((document.name(), document.path()), ("room", None));
    assert!(document.is_modified(), "it is in no file");
    assert!(same_picture(window.scene(), &rendered));
    assert_eq!(number_on_screen(&window), Some(1));

    window.press(Modifiers::COMMAND, Key::S);
    assert!(matches!(window.app().dialog(), Some(Dialog::Path(_))));
    let third = files.path("third.toml");
    window.enter_path(&third);
    window.until("it is saved", |app| !app.document().is_modified());
    assert_eq!(load(&third), rendered);
    assert_eq!(load(&one), edited);
    assert_eq!(std::fs::read_to_string(&room).unwrap(), SCENE);

    // One step back is what was open, with its file.
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.app().document().path(), Some(one.as_path()));
    assert_eq!(window.scene(), &edited);
    assert!(!window.app().document().is_modified());
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(window.app().document().path(), Some(third.as_path()));
    window.settle();
    window.render();
    assert_eq!(window.hash(), hash);
}

/// One that has no file is itself again: there is none to write over.
#[test]
fn settings_of_a_mesh_that_was_open_before_bring_it_back() {
    let files = Files::new();
    let mut window = Window::open(&files.path("pyramid.off"));
    window.click("Renders");
    let before = window.app().document().file_number();
    set_samples(&mut window, 2);
    window.render();
    set_samples(&mut window, 16);
    let room = files.path("room.toml");
    open_other(&mut window, &room);
    window.click("Show render 1");
    assert!(window.says("a picture of pyramid"));
    window.click("Restore settings");
    window.settle();
    let document = window.app().document();
    assert_eq!((document.name(), document.path()), ("pyramid", None));
    assert_eq!(document.file_number(), before);
    assert_eq!(window.scene().render.samples_per_pixel, 2);
    assert!(!window.says("a picture of"));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.app().document().path(), Some(room.as_path()));
}

/// Opens the scene at `path` in place of what is there, which is not saved.
fn open_other(window: &mut Window, path: &std::path::Path) {
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(path);
    let path = path.to_owned();
    window.until("it is open", |app| {
        let is_asked = matches!(app.dialog(), Some(Dialog::Unsaved(_)));
        is_asked || app.document().path() == Some(path.as_path())
    });
    if window.app().dialog().is_some() {
        window.click("Replace");
    }
    assert_eq!(window.app().document().path(), Some(path.as_path()));
    window.settle();
}
