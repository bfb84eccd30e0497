//! Files that are dropped on the window: scenes, meshes, pictures, and images that become the background.

use std::path::Path;

use crate::driver::{Files, MESH, Window, library_hash, load};
use egui::{Key, Modifiers};
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::picture::Outcome;
use raymini::render::Image;
use raymini::scene::{Background, Display, Output};

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
