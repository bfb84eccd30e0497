//! Scenes some of whose files are not there: they open, keep what they say of them, and take them back from where they are.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::driver::{Files, SCENE, Window, library_hash, load, set_samples};
use crate::keeping::{asks, copy_folder, edit_and_die, open, render_until_kept, renders};
use crate::restoring::kept_scene;
use egui::{Key, Modifiers};
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::picture::Picture;
use raymini::io::write_image;
use raymini::render::Image;
use raymini::scene::{Background, Display, Output, Scene, Textures};

/// The scene with an image on its material, one of its bumps, and one around it.
fn painted() -> String {
    let images = "diffuse_image = \"maps/paint.png\"\nnormal_image = \"maps/bumps.png\"\n\n[background]\nimage = \"sky.exr\"\n\n[[objects]]";
    let painted = SCENE.replace("[[objects]]", images);
    painted.replace("pyramid.off", "pyramid.obj")
}

/// A pyramid with texture coordinates.
const MAPPED: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1.5\nvt 0 0\nvt 1 0\nvt 0.5 1\n\
    f 1/1 2/2 5/3\nf 2/1 3/2 5/3\nf 3/1 4/2 5/3\nf 4/1 1/2 5/3\n";

/// Writes the images of [`painted`] and its mesh below `folder`.
fn write_images(folder: &Path) {
    std::fs::create_dir_all(folder.join("maps")).unwrap();
    let png = |name: &str, colors: [[u8; 3]; 4]| {
        let pixels = colors.concat();
        let image = image::RgbImage::from_raw(2, 2, pixels).unwrap();
        image.save(folder.join("maps").join(name)).unwrap();
    };
    png(
        "paint.png",
        [[200, 10, 10], [9, 99, 9], [10, 10, 200], [255; 3]],
    );
    png(
        "bumps.png",
        [
            [190, 128, 220],
            [128, 60, 220],
            [128, 190, 220],
            [90, 128, 220],
        ],
    );
    let sky = Image {
        width: 4,
        height: 2,
        pixels: (0..8_u8).map(|i| [f32::from(i) / 8.0; 3]).collect(),
    };
    let (display, output) = (Display::default(), Output::default());
    write_image(&sky, &[], &display, &output, &folder.join("sky.exr")).unwrap();
    std::fs::write(folder.join("pyramid.obj"), MAPPED).unwrap();
}

fn asks_about_missing(window: &mut Window) {
    window.until("it is asked about what is missing", |app| {
        matches!(app.dialog(), Some(Dialog::Missing(_)))
    });
}

/// Opens the scene at `path` in `window` as far as the question about what it lacks.
fn open_lacking(window: &mut Window, path: &Path) {
    window.press(Modifiers::COMMAND, Key::O);
    window.enter_path(path);
    asks_about_missing(window);
}

fn save(window: &mut Window) {
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |app| !app.document().is_modified());
}

/// Files are looked at once a second.
fn wait_for_a_look() {
    std::thread::sleep(Duration::from_millis(1200));
}

/// What is there can be worked with, and no object is lost by that.
#[test]
fn a_scene_opens_without_a_mesh_that_is_missing_and_gets_it_later() {
    let files = Files::new();
    let two = "\n[[objects]]\nname = \"ram\"\nmesh = \"meshes/ram.off\"\nmaterial = \"clay\"\ntranslate = [1.0, 2.0, 3.0]\n";
    let path = files.write("two.toml", &(SCENE.to_owned() + two));
    let mut window = Window::open(&files.path("room.toml"));
    open_lacking(&mut window, &path);
    assert!(window.says("two.toml lacks 1 file"));
    let mesh = files.path("meshes").join("ram.off");
    assert!(window.says(&format!("ram: there is no file {}", mesh.display())));
    window.click("Cancel");
    assert_eq!(window.app().document().name(), "room");
    open_lacking(&mut window, &path);
    window.click("Open without");
    window.until("it is open", |app| app.document().name() == "two");
    window.settle();
    assert!(!window.app().document().is_modified());
    assert_eq!(window.scene().objects.len(), 2);
    let warning = &window.app().messages().banners()[0];
    assert!(
        warning.text.contains("ram has no triangles"),
        "{}",
        warning.text
    );
    window.click("Dismiss");
    window.render();
    let without = window.hash();
    let alone = load(&files.path("room.toml"));
    assert_eq!(without, library_hash(&alone));
    window.click("Select ram");
    let missing = format!("File missing: {}", mesh.display());
    assert!(window.says(&missing));
    window.click("Select pyramid");
    assert!(!window.says("File missing"));

    // Saving keeps what it is called and where it is, and the mesh shows once it is there.
    window.operate("Add light");
    save(&mut window);
    let saved = std::fs::read_to_string(&path).unwrap();
    assert!(saved.contains("\"meshes/ram.off\""), "{saved}");
    wait_for_a_look();
    std::fs::create_dir(files.path("meshes")).unwrap();
    // Moved there, it is older than the scene.
    std::fs::copy(files.path("pyramid.off"), &mesh).unwrap();
    window.until("it is read", |app| {
        let name = mesh.to_string_lossy();
        app.document().scene.meshes[&*name].triangles.len() == 10
    });
    assert!(!window.app().document().is_modified());
    window.click("Select ram");
    assert!(!window.says("File missing"));
    let again = load(&path);
    assert_eq!(again.objects, window.scene().objects);
    assert_eq!(again.triangle_count(), 20);
}

/// Materials show their plain colours and the background is black: the picture is that of the scene that has no images.
#[test]
fn a_scene_opens_without_images_that_are_missing_and_gets_them_later() {
    let files = Files::new();
    write_images(files.folder.path());
    let path = files.write("painted.toml", &painted());
    let whole = load(&path);
    let away = files.path("away");
    std::fs::create_dir(&away).unwrap();
    for name in ["maps", "sky.exr"] {
        std::fs::rename(files.path(name), away.join(name)).unwrap();
    }
    let mut window = Window::open(&files.path("room.toml"));
    open_lacking(&mut window, &path);
    assert!(window.says("painted.toml lacks 3 files"));
    let sky = files.path("sky.exr");
    assert!(window.says(&format!(
        "the background: there is no file {}",
        sky.display()
    )));
    window.click("Open without");
    window.until("it is open", |app| app.document().name() == "painted");
    window.settle();
    let told = window.app().messages().banners()[0].text.clone();
    for part in [
        "the background is black",
        "material clay shows its plain colour",
    ] {
        assert!(told.contains(part), "{told}");
    }
    window.click("Dismiss");
    let mut plain = whole.clone();
    plain.background = Background::default();
    for textures in plain.material_textures_mut() {
        *textures = Textures::default();
    }
    window.render();
    assert_eq!(window.hash(), library_hash(&plain));
    window.click("Select Background");
    assert!(window.says(&format!("File missing: {}", sky.display())));
    window.click("Select pyramid");
    let paint = files.path("maps").join("paint.png");
    assert!(window.says(&format!("File missing: {}", paint.display())));

    window.operate("Add light");
    save(&mut window);
    let saved = std::fs::read_to_string(&path).unwrap();
    for name in ["maps/paint.png", "maps/bumps.png", "sky.exr"] {
        assert!(saved.contains(&format!("\"{name}\"")), "{name} in {saved}");
    }
    wait_for_a_look();
    for name in ["maps", "sky.exr"] {
        std::fs::rename(away.join(name), files.path(name)).unwrap();
    }
    window.until("all is there", |app| {
        let scene = &app.document().scene;
        let material = &scene.materials["clay"];
        scene.absent_textures(material).next().is_none() && scene.absent_background().is_none()
    });
    window.settle();
    assert!(!window.app().document().is_modified());
    window.render();
    assert_eq!(window.hash(), library_hash(&load(&path)));
    assert_eq!(load(&path).materials, whole.materials);
}

/// Lost work opens without its mesh, is not harmed by that, and can be saved as it is.
#[test]
fn lost_work_whose_mesh_is_gone_is_restored_with_all_it_says_of_it() {
    let files = Files::new();
    let data = files.path("data");
    edit_and_die(&files, &data);
    let [mesh, away] = ["pyramid.off", "away.off"].map(|name| files.path(name));
    std::fs::rename(&mesh, &away).unwrap();
    let start = || Window::start_keeping(Vec::new(), true, Some(data.clone()));
    let mut window = start();
    asks(&mut window);
    window.click("Restore");
    asks_about_missing(&mut window);
    assert!(window.says("The unsaved work on room lacks 1 file"));
    assert!(window.says(&format!("pyramid: there is no file {}", mesh.display())));
    window.click("Cancel");
    assert!(window.says("The unsaved work on room is offered again at the next start"));
    drop(window);

    // Restored, it is killed once more before it is saved.
    let mut window = start();
    asks(&mut window);
    window.click("Restore");
    asks_about_missing(&mut window);
    window.click("Open without");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    assert_eq!(window.scene().lights.len(), 3);
    let told = &window.app().messages().banners()[0];
    assert!(
        told.text.contains("pyramid has no triangles"),
        "{}",
        told.text
    );
    window.click("Dismiss");
    window.operate("Add light");
    window.until("it is kept", App::is_work_kept);
    let kept = std::fs::read_to_string(kept_scene(&data)).unwrap();
    assert!(kept.contains("pyramid.off\""), "{kept}");
    drop(window);

    let mut window = start();
    asks(&mut window);
    window.click("Restore");
    asks_about_missing(&mut window);
    window.click("Open without");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    assert!(window.app().document().is_modified());
    save(&mut window);
    std::fs::rename(&away, &mesh).unwrap();
    let room = load(&files.path("room.toml"));
    assert_eq!((room.lights.len(), room.triangle_count()), (4, 10));
    assert_eq!(room.objects[0].name, "pyramid");
    assert_eq!(room.objects[0].material.as_deref(), Some("clay"));
}

/// A folder `new` to which all that belongs to the scene has moved but for the scene; the scene.
fn moved_away(files: &Files) -> (PathBuf, PathBuf) {
    let new = files.path("new");
    write_images(&new);
    std::fs::copy(files.path("pyramid.off"), new.join("other.off")).unwrap();
    let other = "\n[[objects]]\nname = \"other\"\nmesh = \"other.off\"\n";
    (new, files.write("painted.toml", &(painted() + other)))
}

fn names(scene: &Scene) -> Vec<String> {
    let meshes = scene.objects.iter().map(|object| object.mesh.clone());
    let mut names: Vec<_> = meshes.chain(scene.texture_names()).collect();
    if let Background::Image { image, .. } = &scene.background {
        names.push(image.clone());
    }
    names
}

/// One file is named by the user, the others are found beside it; all of it is one step to undo, and saved when the user says so.
#[test]
fn files_that_have_moved_are_located() {
    let files = Files::new();
    let (new, path) = moved_away(&files);
    let before = std::fs::read_to_string(&path).unwrap();
    let mut window = Window::open(&files.path("room.toml"));
    open_lacking(&mut window, &path);
    assert!(window.says("painted.toml lacks 5 files"));
    window.click("Locate pyramid.obj");
    window.enter_path(&files.path("none.obj"));
    window.until_says("There is no file");
    assert!(window.says("painted.toml lacks 5 files"));
    window.click("Locate pyramid.obj");
    assert!(window.says("Locate the mesh"));
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.says("painted.toml lacks 5 files"));

    // What is no mesh is said at once where its name tells, and asked about again where only its contents do. What was found beside it stays so.
    let paint = new.join("maps").join("paint.png");
    for (lacks, wrong) in [
        ("pyramid.obj", &paint),
        ("paint.png", &new.join("other.off")),
    ] {
        window.click(&format!("Locate {lacks}"));
        window.enter_path(wrong);
        window.until_says(&format!("{} is not", wrong.display()));
        assert!(window.says("painted.toml lacks 5 files"));
    }
    window.click("Locate pyramid.obj");
    window.enter_path(&files.write("new/broken.obj", "f 1 2 3\n"));
    window.until_says("painted.toml lacks nothing any more");
    window.click("Open");
    asks_about_missing(&mut window);
    assert!(window.says("painted.toml lacks 1 file"));
    assert!(window.says("broken.obj:1: "));

    window.click("Locate pyramid.obj");
    window.enter_path(&new.join("pyramid.obj"));
    window.until_says("painted.toml lacks nothing any more");
    assert!(window.says(&format!("material clay: found at {}", paint.display())));
    window.click("Open");
    window.until("it is open", |app| app.document().name() == "painted");
    window.settle();
    assert!(window.app().messages().banners().is_empty());
    let moved = names(window.scene());
    let is_new = |name: &String| Path::new(name).starts_with(&new);
    assert!(moved.len() == 5 && moved.iter().all(is_new), "{moved:?}");
    assert_eq!(window.scene().triangle_count(), 14);
    assert!(window.app().document().is_modified());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), before);
    window.render();
    let picture = window.hash();

    let history = window.app().document().undo_history();
    assert_eq!(history.next_undo(), Some("locating files"));
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(!window.app().document().is_modified());
    assert!(!names(window.scene()).iter().any(is_new));
    assert_eq!(window.scene().triangle_count(), 0);
    assert_eq!(window.scene().objects.len(), 2);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(names(window.scene()), moved);
    save(&mut window);
    let saved = std::fs::read_to_string(&path).unwrap();
    assert!(saved.contains("\"new/maps/paint.png\""), "{saved}");
    assert_eq!(library_hash(&load(&path)), picture);
}

/// A picture that tells what was rendered is opened as scenes are, and shows what was rendered.
#[test]
fn a_picture_opens_without_a_mesh_that_is_missing() {
    let files = Files::new();
    let mut window = Window::open(&files.path("room.toml"));
    window.render();
    let hash = window.hash();
    let picture = files.path("render.exr");
    window.save_picture(&picture);
    std::fs::rename(files.path("pyramid.off"), files.path("moved.off")).unwrap();
    let mut window = Window::open(&picture);
    asks_about_missing(&mut window);
    window.click("Locate pyramid.off");
    window.enter_path(&files.path("moved.off"));
    window.until_says("render.exr lacks nothing any more");
    window.click("Open");
    window.until("it is open", |app| app.document().name() == "render");
    window.settle();
    assert!(window.app().picture_on_screen().is_some());
    assert_eq!(window.scene().triangle_count(), 10);
    assert_eq!(library_hash(window.scene()), hash);
}

/// A render is not gone on with without a mesh it is of, nor lost: it waits until the mesh is there.
#[test]
fn an_interrupted_render_waits_for_its_mesh_and_goes_on_where_that_is_located() {
    let files = Files::new();
    let [data, killed] = ["data", "killed"].map(|name| files.path(name));
    let mut window = open(&files.path("room.toml"), &data);
    set_samples(&mut window, 300);
    let rendered = window.scene().clone();
    render_until_kept(&mut window, &data);
    window.click("Add light");
    window.until("the work is kept", App::is_work_kept);
    copy_folder(&data, &killed);
    window.click("Cancel");
    drop(window);
    let [old, new] = ["pyramid.off", "new/pyramid.off"].map(|name| files.path(name));
    std::fs::create_dir(files.path("new")).unwrap();
    std::fs::rename(&old, &new).unwrap();
    let expected = library_hash(&rendered);
    let again = files.path("again");
    copy_folder(&killed, &again);

    let restore = |data: &Path| {
        let mut window = Window::start_keeping(Vec::new(), true, Some(data.to_owned()));
        asks(&mut window);
        window.click("Restore");
        asks_about_missing(&mut window);
        window
    };
    let mut window = restore(&killed);
    window.click("Open without");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    let waits = |app: &App| {
        let banners = app.messages().banners();
        let mut titles = banners.iter().map(|banner| banner.title.as_str());
        titles.any(|title| title == "The interrupted render waits")
    };
    assert!(waits(window.app()) && window.app().picture().is_none());
    // It stays also where the work beside it is saved and goes.
    save(&mut window);
    window.until("nothing is kept", App::is_work_kept);
    assert_eq!(renders(&killed).len(), 1);
    drop(window);
    std::fs::copy(&new, &old).unwrap();
    let mut window = open(&files.path("room.toml"), &killed);
    asks(&mut window);
    window.click("Go on");
    let is_finished = |app: &App| app.picture().is_some_and(|picture| !picture.is_running());
    window.until("it is finished", is_finished);
    assert_eq!(window.hash(), expected);
    drop(window);

    std::fs::remove_file(&old).unwrap();
    let mut window = restore(&again);
    window.click("Locate pyramid.off");
    window.enter_path(&new);
    window.until_says("lacks nothing any more");
    window.click("Open");
    window.until("the render goes on", |app| {
        app.picture().and_then(Picture::goes_on_from).is_some()
    });
    window.until("it is finished", is_finished);
    assert_eq!(window.hash(), expected);
    assert_eq!(names(window.scene()), [new.to_string_lossy()]);
    assert_eq!(window.scene().lights.len(), 2);
}

/// Lost work on what is opened is asked about before what that lacks, and nothing is asked twice.
#[test]
fn lost_work_goes_before_what_its_file_lacks() {
    let files = Files::new();
    let [data, again] = ["data", "again"].map(|name| files.path(name));
    edit_and_die(&files, &data);
    copy_folder(&data, &again);
    let [mesh, moved] = ["pyramid.off", "moved.off"].map(|name| files.path(name));
    std::fs::rename(&mesh, &moved).unwrap();
    let room = files.path("room.toml");
    let mut window = open(&room, &data);
    asks(&mut window);
    window.click("Restore");
    asks_about_missing(&mut window);
    assert!(window.says("The unsaved work on room lacks 1 file"));
    window.click("Locate pyramid.off");
    window.enter_path(&moved);
    window.until_says("The unsaved work on room lacks nothing any more");
    window.click("Open");
    window.until("it is restored", |app| app.document().name() == "room");
    window.settle();
    window.harness.run_steps(5);
    assert!(window.app().dialog().is_none(), "all is answered");
    assert_eq!(window.scene().lights.len(), 3);
    assert_eq!(window.scene().triangle_count(), 10);
    drop(window);

    // Later, the file is opened as ever.
    let mut window = open(&room, &again);
    asks(&mut window);
    window.click("Later");
    asks_about_missing(&mut window);
    assert!(window.says("room.toml lacks 1 file"));
    window.click("Locate pyramid.off");
    window.enter_path(&moved);
    window.until_says("room.toml lacks nothing any more");
    window.click("Open");
    window.until("it is open", |app| app.document().name() == "room");
    window.settle();

    // What was found is there for other scenes, too.
    let other = files.write("other.toml", SCENE);
    open_lacking(&mut window, &other);
    assert!(window.says("other.toml lacks nothing any more"));
}

/// What the open scene lacks is located beside what says so, as a step to undo; and what goes while it is open is told of.
#[test]
fn files_are_located_in_an_open_scene() {
    let files = Files::new();
    let (new, path) = moved_away(&files);
    let mut window = Window::open(&files.path("room.toml"));
    open_lacking(&mut window, &path);
    window.click("Open without");
    window.until("it is open", |app| app.document().name() == "painted");
    window.settle();
    window.click("Dismiss");
    let before = window.scene().clone();
    window.click("Select pyramid");
    assert!(window.says("File missing"));
    window.click("Locate pyramid.obj");
    assert!(window.says("Locate the mesh"));
    window.enter_path(&new.join("sky.exr"));
    window.until_says("sky.exr is not a mesh");
    assert_eq!(window.scene(), &before);
    window.click("Dismiss");

    window.click("Locate pyramid.obj");
    window.enter_path(&new.join("pyramid.obj"));
    window.until("it is there", |app| {
        app.document().scene.triangle_count() == 14
    });
    window.settle();
    assert!(!window.says("File missing"));
    let moved = names(window.scene());
    let is_new = |name: &String| Path::new(name).starts_with(&new);
    assert!(moved.len() == 5 && moved.iter().all(is_new), "{moved:?}");
    assert!(window.app().document().is_modified());
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.scene(), &before);
    assert!(window.says("File missing"));
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(names(window.scene()), moved);
    save(&mut window);
    window.settle();
    window.render();
    assert_eq!(window.hash(), library_hash(&load(&path)));

    wait_for_a_look();
    std::fs::rename(new.join("other.off"), files.path("other.off")).unwrap();
    window.until_says("Not there any more: other.off");
    assert_eq!(window.scene().triangle_count(), 14);
}
