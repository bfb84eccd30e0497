//! Files that change on disk while the window shows them.

use std::sync::Arc;

use crate::driver::{Files, MESH, SCENE, Window, library_hash, load, set_samples};
use egui::{Event, Key, Modifiers};
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::jobs::Lane;
use raymini::gui::picture::Picture;
use raymini::math::DVec3;
use raymini::scene::{Light, Scene};

/// A mesh of one triangle.
const TRIANGLE: &str = "OFF\n3 1 0\n0 0 0\n2 0 0\n0 0 2\n3 0 1 2\n";

fn triangles(scene: &Scene) -> u64 {
    scene.triangle_count()
}

/// Waits until the files have been looked at once, so that what is written from now on is a change.
fn watched(files: &Files, name: &str) -> Window {
    let mut window = Window::open(&files.path(name));
    window.harness.run_steps(3);
    std::thread::sleep(std::time::Duration::from_millis(1200));
    window
}

#[test]
fn a_mesh_that_changes_is_read_again_and_one_that_is_broken_is_not() {
    let files = Files::new();
    let mut window = watched(&files, "room.toml");
    window.operate("Add light");
    let scene = window.scene().clone();
    assert_eq!(triangles(&scene), 10);
    files.write("pyramid.off", TRIANGLE);
    window.until("the triangle is there", |app| {
        triangles(&app.document().scene) == 1
    });
    window.settle();
    assert!(
        window
            .app()
            .messages()
            .last_news()
            .contains("pyramid.off has changed")
    );
    assert_eq!(window.scene().camera, scene.camera);
    assert_eq!(window.scene().lights, scene.lights);
    window.render();
    assert_eq!(window.hash(), library_hash(window.scene()));

    // Half a file leaves all as it is, and says so until it is whole.
    files.write("pyramid.off", &MESH[..40]);
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    let banner = window.app().messages().banners()[0].clone();
    assert_eq!(banner.title, "pyramid.off has changed and cannot be read");
    assert!(banner.text.contains("pyramid.off:"), "{}", banner.text);
    assert_eq!(triangles(window.scene()), 1);
    files.write("pyramid.off", MESH);
    window.until("the mesh is back", |app| {
        triangles(&app.document().scene) == 10
    });
    assert!(window.app().messages().banners().is_empty());

    // What was edited can be undone, and the mesh stays the file's.
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene().lights.len(), 1);
    assert_eq!(triangles(window.scene()), 10);
    assert!(!window.app().document().is_modified());
    window.settle();
    window.render();
    assert_eq!(window.hash(), library_hash(&load(&files.path("room.toml"))));
}

/// Whoever writes a mesh again that has not changed holds nothing up.
#[test]
fn a_mesh_that_is_written_again_as_it_was_restarts_nothing() {
    let files = Files::new();
    let mut window = watched(&files, "room.toml");
    set_samples(&mut window, 100_000);
    window.click("Render");
    window.until("it renders", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    let mesh = |app: &App| {
        let meshes = &app.document().scene.meshes;
        Arc::clone(meshes.values().next().expect("a mesh"))
    };
    let before = mesh(window.app());
    let started = |app: &App| [Lane::Prepare, Lane::Render].map(|lane| app.jobs_started(lane));
    let jobs = started(window.app());
    files.write("pyramid.off", MESH);
    window.until("it is read again", |app| {
        app.messages().last_news() == "pyramid.off was written again, unchanged"
    });
    window.harness.run_steps(3);
    assert!(Arc::ptr_eq(&mesh(window.app()), &before));
    assert_eq!(started(window.app()), jobs);
    assert!(window.app().picture().is_some_and(Picture::is_running));
    window.press(Modifiers::NONE, Key::Escape);
}

/// A scene file that is read again is a step to undo, and a mesh that changes after that is the file's in every step.
#[test]
fn files_change_before_and_after_an_undo() {
    let files = Files::new();
    let mut window = watched(&files, "room.toml");
    let red = |scene: &Scene| scene.lights[0].emission().x;
    files.write("room.toml", &SCENE.replace("60.0, 60.0, 60.0", "7, 9, 9"));
    window.until("the light is another", |app| {
        red(&app.document().scene) == 7.0
    });
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(red(window.scene()), 60.0);
    assert!(window.app().document().is_modified());

    files.write("pyramid.off", TRIANGLE);
    window.until("the triangle is there", |app| {
        triangles(&app.document().scene) == 1
    });
    window.settle();
    assert_eq!(red(window.scene()), 60.0, "what was undone stays so");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!((red(window.scene()), triangles(window.scene())), (7.0, 1));
    assert!(!window.app().document().is_modified());

    // The file changes again while an older state is looked at: that is not thrown away without a question.
    window.press(Modifiers::COMMAND, Key::Z);
    files.write("room.toml", &SCENE.replace("60.0, 60.0, 60.0", "8, 9, 9"));
    window.until("it is asked", App::asks_to_reload);
    assert_eq!(red(window.scene()), 60.0);
    window.click("Read it again");
    window.until("the file's light is there", |app| {
        red(&app.document().scene) == 8.0
    });
    window.settle();
    window.render();
    assert_eq!(window.hash(), library_hash(&load(&files.path("room.toml"))));
}

#[test]
fn a_scene_file_that_changes_is_read_again_where_nothing_is_lost_and_asked_about_else() {
    let files = Files::new();
    let mut window = watched(&files, "room.toml");
    let brighter = |emission: u32| SCENE.replace("60.0, 60.0, 60.0", &format!("{emission}, 9, 9"));
    files.write("room.toml", &brighter(7));
    let red = |scene: &Scene| scene.lights[0].emission().x;
    window.until("the light is another", |app| {
        red(&app.document().scene) == 7.0
    });
    assert!(!window.app().document().is_modified());

    // A mistake in it leaves the scene as it is.
    files.write("room.toml", "[camera]\neye = [0, 0\n");
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    assert_eq!(red(window.scene()), 7.0);

    // With unsaved work it is a question.
    window.operate("Add light");
    files.write("room.toml", &brighter(8));
    window.until("it is asked", App::asks_to_reload);
    assert!(window.says("room has changed on disk"));
    assert_eq!((red(window.scene()), window.scene().lights.len()), (7.0, 2));
    window.click("Keep mine");
    assert!(!window.has("Read it again"));
    assert_eq!(window.scene().lights.len(), 2);

    files.write("room.toml", &brighter(19));
    window.until("it is asked again", App::asks_to_reload);
    window.click("Read it again");
    window.until("the file's light is there", |app| {
        red(&app.document().scene) == 19.0
    });
    assert!(!window.app().document().is_modified());
    assert!(window.app().messages().banners().is_empty());
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!((red(window.scene()), window.scene().lights.len()), (7.0, 2));

    // Saving is not a change from elsewhere.
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the scene is saved", |app| !app.document().is_modified());
    window.operate("Add light");
    for _ in 0..150 {
        window.harness.run_steps(1);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(!window.app().asks_to_reload());
    assert_eq!(window.scene().lights.len(), 3);
}

/// What is edited while a changed scene file is being read is not lost without a question.
#[test]
fn an_edit_made_while_the_scene_file_is_read_is_asked_about() {
    let files = Files::new();
    let mut window = watched(&files, "room.toml");
    files.write("room.toml", &SCENE.replace("60.0, 60.0, 60.0", "7, 9, 9"));
    window.just_until("the file is being read", |app| app.works_in(Lane::Reload));
    let scene = &mut window.harness.state_mut().document_mut().scene;
    scene.lights.push(Light::Point {
        position: DVec3::ONE,
        intensity: DVec3::ONE,
    });
    let edited = scene.clone();
    window.until("it is asked", App::asks_to_reload);
    assert_eq!(window.scene(), &edited);
    window.click("Read it again");
    window.until("the file's light is there", |app| {
        app.document().scene.lights[0].emission().x == 7.0
    });
    assert_eq!(window.scene(), &load(&files.path("room.toml")));
    assert!(!window.app().asks_to_reload());
}

/// Also where the window has not seen yet that it has changed: nobody's work is lost without a question.
#[test]
fn saving_asks_before_it_replaces_what_another_program_has_written() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    let held = || std::fs::read_to_string(files.path("room.toml")).unwrap();
    let save = |window: &mut Window| window.press(Modifiers::COMMAND, Key::S);
    let is_asked = |app: &App| matches!(app.dialog(), Some(Dialog::Overwrite(_)));
    window.operate("Add light");
    let other = SCENE.replace("60.0, 60.0, 60.0", "7, 9, 9");
    files.write("room.toml", &other);
    save(&mut window);
    window.until("it is asked", is_asked);
    assert!(window.has("Overwrite room.toml?"));
    window.click("Cancel");
    assert_eq!(held(), other);
    assert!(window.app().document().is_modified());

    // Another file is another way; also out of the window.
    window.ask_to_close();
    window.click("Save first");
    window.until("it is asked", is_asked);
    window.click("Save as…");
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.app().dialog().is_none() && window.app().document().is_modified());
    assert_eq!(held(), other);

    save(&mut window);
    window.until("it is asked", is_asked);
    window.click("Overwrite");
    window.until("it is saved", |app| !app.document().is_modified());
    assert_eq!(load(&files.path("room.toml")).lights.len(), 2);

    // What the window has written itself it does not ask about, however quickly one saves, nor about the same scene in other words.
    window.operate("Add light");
    save(&mut window);
    window.operate("Add light");
    save(&mut window);
    window.until("it is saved", |app| !app.document().is_modified());
    files.write("room.toml", &format!("# mine\n{}", held()));
    window.operate("Add light");
    save(&mut window);
    window.until("it is saved", |app| !app.document().is_modified());
    assert_eq!(load(&files.path("room.toml")).lights.len(), 5);
}

/// Images of materials are read again as meshes are, in every step to undo.
#[test]
fn an_image_of_a_material_that_changes_is_read_again() {
    let files = Files::new();
    let paint = |color: [u8; 3]| {
        let image = image::RgbImage::from_pixel(2, 2, image::Rgb(color));
        image.save(files.path("paint.png")).unwrap();
    };
    paint([200, 10, 10]);
    let painted = SCENE.replace(
        "[[objects]]",
        "diffuse_image = \"paint.png\"\n\n[[objects]]",
    );
    files.write("room.toml", &painted);
    let mut window = watched(&files, "room.toml");
    window.operate("Add light");
    let texels = |scene: &Scene| {
        let image = scene.textures.values().next().expect("an image");
        image.texels().clone()
    };
    let before = texels(window.scene());
    paint([10, 200, 10]);
    window.until("the paint is another", |app| {
        texels(&app.document().scene) != before
    });
    let expected = load(&files.path("room.toml"));
    assert_eq!(texels(window.scene()), texels(&expected));
    assert_eq!(window.scene().lights.len(), 2, "the edit is still there");
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(texels(window.scene()), texels(&expected));
    assert!(!window.app().document().is_modified());

    // Written again as it is, it stays the very same.
    let there = Arc::clone(window.scene().textures.values().next().expect("an image"));
    paint([10, 200, 10]);
    window.until("it is read again", |app| {
        app.messages().last_news() == "paint.png was written again, unchanged"
    });
    let image = window.scene().textures.values().next();
    assert!(image.is_some_and(|image| Arc::ptr_eq(image, &there)));
}

/// Undoes that many edits in one frame, so that nothing is looked at on the way.
fn undo(window: &mut Window, edits: usize) {
    press_z(window, Modifiers::COMMAND, edits);
}

/// [`undo`], the other way.
fn redo(window: &mut Window, edits: usize) {
    press_z(window, Modifiers::COMMAND | Modifiers::SHIFT, edits);
}

fn press_z(window: &mut Window, modifiers: Modifiers, times: usize) {
    for pressed in [true, false].repeat(times) {
        window.harness.input_mut().events.push(Event::Key {
            key: Key::Z,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        });
    }
    window.harness.run_steps(3);
    window.settle();
}

/// Undoes that many edits and does them again.
fn there_and_back(window: &mut Window, edits: usize) {
    undo(window, edits);
    assert_eq!(window.app().document().name(), "other");
    look_a_while(window);
    redo(window, edits);
    look_a_while(window);
}

/// Draws frames until files were looked at several times.
fn look_a_while(window: &mut Window) {
    let started = std::time::Instant::now();
    while started.elapsed() < std::time::Duration::from_millis(3500) {
        window.harness.step();
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// Undoing leads to another scene and back: what the window has written itself is still no change, and what another program has is.
#[test]
fn a_file_that_was_saved_has_not_changed_when_undoing_leads_back_to_it() {
    let files = Files::new();
    let room = files.path("room.toml");
    let other = files.write("other.toml", SCENE);
    let mut window = Window::open(&other);
    let save = |window: &mut Window| {
        window.press(Modifiers::COMMAND, Key::S);
        window.until("it is saved", |app| !app.document().is_modified());
    };
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(&room);
    window.until("it is open", |app| app.document().name() == "room");
    window.settle();
    window.operate("Add light");
    save(&mut window);
    window.operate("Add light");
    there_and_back(&mut window, 3);
    assert_eq!(window.scene().lights.len(), 3);
    assert!(!window.app().asks_to_reload(), "nobody else wrote it");

    // The same where it is saved under another name.
    let third = files.path("third.toml");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.enter_path(&third);
    window.until("it is saved", |app| !app.document().is_modified());
    window.operate("Add light");
    there_and_back(&mut window, 4);
    assert_eq!(window.app().document().path(), Some(third.as_path()));
    assert!(!window.app().asks_to_reload());

    // What is decided stays decided, and what is not is asked again.
    files.write("third.toml", &SCENE.replace("60.0, 60.0", "7.0, 7.0"));
    window.until("it is asked", App::asks_to_reload);
    there_and_back(&mut window, 4);
    assert!(window.app().asks_to_reload());
    window.click("Keep mine");
    there_and_back(&mut window, 4);
    assert_eq!(window.scene().lights.len(), 4);
    assert!(!window.app().asks_to_reload());

    // Written while another scene shows, it is told of on the way back.
    undo(&mut window, 4);
    files.write("third.toml", &SCENE.replace("60.0, 60.0", "17.0, 7.0"));
    redo(&mut window, 4);
    window.until("it is asked", App::asks_to_reload);
}
