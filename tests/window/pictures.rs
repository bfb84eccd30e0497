//! Pictures of the window in all its states, to be looked at: nothing but that tells whether text is cut off, lies over other text, or is hard
//! to read.
//!
//! `cargo test --test window pictures:: -- --ignored` makes them, in the folder that `RAYMINI_PICTURES` names, else in `target/tmp/pictures`: at
//! 1280 × 800 and 1920 × 1080 points, and at two pixels to a point, dark and light.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::driver::{DEADLINE, Files, Look, SCENE, Window, set_number};
use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::Queryable;
use raymini::gui::App;
use raymini::gui::dialogs::Dialog;
use raymini::gui::jobs::Lane;
use raymini::gui::picture::Picture;
use raymini::scene::{Mode, Scene, Stop};

/// Where pictures of one look go, and how many there are.
struct Album {
    folder: PathBuf,
    count: usize,
}

impl Album {
    fn of(name: &str) -> Self {
        let folder = std::env::var_os("RAYMINI_PICTURES").map_or_else(
            || Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures"),
            PathBuf::from,
        );
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Self { folder, count: 0 }
    }

    /// Takes a picture of the window as it is.
    fn take(&mut self, window: &mut Window, name: &str) {
        window.harness.run_steps(8);
        self.take_at_once(window, name);
    }

    fn take_at_once(&mut self, window: &mut Window, name: &str) {
        self.count += 1;
        let file = format!("{:02} {name}.png", self.count);
        let picture = window.harness.render().unwrap();
        picture.save(self.folder.join(file)).unwrap();
    }
}

fn scene_mut(window: &mut Window) -> &mut Scene {
    &mut window.harness.state_mut().document_mut().scene
}

fn is_over(app: &App) -> bool {
    app.picture().is_some_and(|picture| !picture.is_running())
}

/// Draws frames for so long.
fn rest(window: &mut Window, time: Duration) {
    let end = Instant::now() + time;
    while Instant::now() < end {
        window.harness.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn key(window: &mut Window, key: Key) {
    window.press(Modifiers::NONE, key);
}

fn middle(window: &Window) -> Pos2 {
    window.harness.get_by_label("Viewport").rect().center()
}

fn press_at(window: &mut Window, at: Pos2, pressed: bool) {
    window.harness.event(egui::Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    });
    window.harness.run_steps(1);
}

/// Scrolls the side panel so far that a control is seen.
fn scroll_to(window: &mut Window, name: &str) {
    window
        .harness
        .get_all_by_label(name)
        .next()
        .unwrap()
        .scroll_to_me();
    rest(window, Duration::from_millis(500));
}

/// The menus, the sheet, and the panels of all parts of the demo.
fn editing(window: &mut Window, album: &mut Album) {
    window.until("all balls are there", |app| !app.works_in(Lane::Balls));
    album.take(window, "start");
    for menu in ["File", "Edit", "View", "Render menu", "Help"] {
        window.click(menu);
        album.take(window, &format!("menu {menu}"));
        key(window, Key::Escape);
    }
    key(window, Key::F1);
    album.take(window, "sheet");
    key(window, Key::Escape);

    let object = window.scene().objects[0].name.clone();
    window.click("Select Background");
    album.take(window, "background");
    window.click("Select Light 1");
    window.until("what the light brings is known", |app| {
        !app.works_in(Lane::Contributions)
    });
    album.take(window, "light");
    window.click(&format!("Select {object}"));
    album.take(window, "object");
    for tool in ["Move tool", "Rotate tool", "Scale tool"] {
        window.click(tool);
        album.take(window, tool);
    }
    key(window, Key::W);
    window.click("Move tool");
    album.take(window, "own axes");
    key(window, Key::Q);
    let title = window.harness.get_by_label_contains("Materials  ").rect();
    window.click_at(title.left_center() - Vec2::new(10.0, 0.0));
    let material = window.scene().materials.keys().next().unwrap().clone();
    scroll_to(window, &format!("Select {material}"));
    window.operate(&format!("Select {material}"));
    window.until("all balls are there", |app| !app.works_in(Lane::Balls));
    album.take(window, "material with ball");
    window.operate("Presets of materials");
    window.until("all balls are there", |app| !app.works_in(Lane::Balls));
    album.take(window, "presets with balls");
    key(window, Key::Escape);

    window.operate("Select Camera");
    key(window, Key::M);
    window.drag(
        PointerButton::Primary,
        middle(window),
        middle(window) + Vec2::new(90.0, 20.0),
    );
    key(window, Key::M);
    album.take(window, "bookmarks");
    let camera = &mut scene_mut(window).camera;
    camera.aperture_radius = 0.02 * camera.eye.distance(camera.target);
    key(window, Key::D);
    let at = middle(window);
    window.click_at(at);
    album.take(window, "focus");
    key(window, Key::D);
    scene_mut(window).camera.aperture_radius = 0.0;
    scroll_to(window, "Effects");
    window.until("what effects bring is known", |app| {
        !app.contributions().is_missing() && !app.works_in(Lane::Contributions)
    });
    album.take(window, "effects with contributions");
    window.operate("Contribution of shadows");
    album.take(window, "contribution of shadows");
    window.operate("Close window");
    window.operate("Plan");
    scroll_to(window, "Measure costs");
    album.take(window, "plan");
    key(window, Key::F7);
    rest(window, Duration::from_millis(800));
    album.take(window, "costs being measured");
    key(window, Key::Escape);
    scroll_to(window, "Display");
    album.take(window, "display");
    window.operate("Plan");
    scroll_to(window, "Show boxes");
    window.operate("Show boxes");
    album.take(window, "boxes of the tree");
    window.operate("Show boxes");
    key(window, Key::T);
    album.take(window, "ray tool");
    let at = middle(window);
    window.click_at(at);
    rest(window, Duration::from_millis(600));
    album.take(window, "rays of a pixel");
    key(window, Key::Escape);
    key(window, Key::Q);
}

/// A render from its start to its end, and what is seen of it.
fn rendering(window: &mut Window, album: &mut Album) {
    window.harness.get_by_label("Render").hover();
    rest(window, Duration::from_millis(1500));
    window.until("the time is told", |app| !app.works_in(Lane::Time));
    album.take(window, "time told before");
    let scene = scene_mut(window);
    scene.render.samples_per_pixel = 4096;
    scene.render.stop = Stop::default();
    key(window, Key::F5);
    window.until("tiles show", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    rest(window, Duration::from_millis(1500));
    album.take_at_once(window, "rendering with tiles outlined");
    key(window, Key::P);
    album.take(window, "paused");
    key(window, Key::Escape);
    album.take(window, "cancelled");
    let area = window.harness.get_by_label("Viewport").rect();
    key(window, Key::B);
    window.harness.hover_at(area.lerp_inside(Vec2::splat(0.3)));
    window.harness.run_steps(1);
    press_at(window, area.lerp_inside(Vec2::splat(0.3)), true);
    window
        .harness
        .hover_at(area.lerp_inside(Vec2::new(0.7, 0.75)));
    window.harness.run_steps(2);
    album.take(window, "region being drawn");
    press_at(window, area.lerp_inside(Vec2::new(0.7, 0.75)), false);
    scene_mut(window).render.samples_per_pixel = 32;
    key(window, Key::F5);
    window.until("the region is done", is_over);
    album.take(window, "region finished");
    window.press(Modifiers::SHIFT, Key::B);
}

/// A finished picture, and what is seen of it.
fn looking(window: &mut Window, album: &mut Album) {
    key(window, Key::F5);
    window.until("the picture is done", is_over);
    window
        .harness
        .hover_at(middle(window) + Vec2::new(31.0, 17.0));
    rest(window, Duration::from_millis(500));
    album.take(window, "finished with inspector");
    scroll_to(window, "Channels");
    rest(window, Duration::from_millis(800));
    album.take(window, "histogram");
    for channels in ["False colours", "Luminance", "All colours"] {
        window.operate("Channels");
        window.operate(channels);
        rest(window, Duration::from_millis(400));
        album.take(window, channels);
    }
    window.operate("Layer");
    album.take(window, "layers to choose");
    window.operate("Error of each pixel");
    rest(window, Duration::from_millis(400));
    album.take(window, "error of each pixel");
    window.operate("Layer");
    window.operate("Whole picture");
    key(window, Key::F8);
    rest(window, Duration::from_millis(300));
    album.take(window, "error plot");
    key(window, Key::F8);
    key(window, Key::Num4);
    album.take(window, "pixel for pixel");
    key(window, Key::Num3);
}

/// Two pictures, other modes, and what else is shown of renders.
fn comparing(window: &mut Window, album: &mut Album) {
    scene_mut(window).render.seed = 7;
    key(window, Key::F5);
    window.until("another picture is done", is_over);
    key(window, Key::F6);
    rest(window, Duration::from_millis(400));
    album.take(window, "history");
    key(window, Key::C);
    window.until("it is measured", |app| {
        app.comparison().is_some_and(|c| c.distance().is_some())
    });
    album.take(window, "wipe");
    key(window, Key::X);
    album.take(window, "flip");
    window.click("Compare: Difference");
    rest(window, Duration::from_millis(400));
    album.take(window, "difference");
    key(window, Key::C);
    key(window, Key::F6);
    scene_mut(window).render.mode = Mode::Steps;
    key(window, Key::F5);
    window.until("the picture of steps is done", is_over);
    album.take(window, "steps through the tree");
    scene_mut(window).render.mode = Mode::Direct;
    scene_mut(window).render.samples_per_pixel = 4096;
    key(window, Key::L);
    window.until("the live picture shows", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    rest(window, Duration::from_millis(900));
    album.take_at_once(window, "live");
    key(window, Key::L);
    key(window, Key::Escape);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    album.take(window, "report");
    key(window, Key::Escape);
}

/// Questions and messages.
fn questions(files: &Files, window: &mut Window, album: &mut Album) {
    window.press(Modifiers::COMMAND, Key::O);
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Path")
        .focus();
    rest(window, Duration::from_millis(300));
    album.take(window, "path field");
    key(window, Key::Escape);
    window.drop_file(files.write("broken.toml", "[camera]\neye = [0, 0\n"));
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    album.take(window, "broken scene");
    window.harness.state_mut().dismiss_messages();
    window.drop_file(files.path("pyramid.off"));
    window.harness.step();
    window.until("it is asked what becomes of the mesh", |app| {
        matches!(app.dialog(), Some(Dialog::Import(_)))
    });
    album.take(window, "import question");
    key(window, Key::Escape);
    window.operate("Add light");
    window.drop_file(files.path("room.toml"));
    window.until("unsaved work is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    album.take(window, "unsaved question");
    key(window, Key::Escape);
    let hovered = egui::HoveredFile {
        path: Some(files.path("room.toml")),
        ..egui::HoveredFile::default()
    };
    window.harness.input_mut().hovered_files.push(hovered);
    window.harness.run_steps(2);
    album.take(window, "drop hint");
    window.harness.input_mut().hovered_files.clear();
    window.harness.run_steps(2);
    window.drop_file(files.path("missing.off"));
    window.until("a banner shows", |app| !app.messages().banners().is_empty());
    album.take(window, "missing file");
    window.harness.state_mut().dismiss_messages();
    let camera = &mut scene_mut(window).camera;
    camera.target = camera.eye;
    window.settle();
    album.take(window, "scene that cannot be rendered");
}

/// What a window finds that was killed before.
fn recovery(files: &Files, look: &Look, album: &mut Album) {
    let data = files.path("data");
    let room = files.path("room.toml");
    let mut window = Window::start_as(vec![room.clone()], look, Some(data.clone()));
    window.operate("Add light");
    window.until("the work is kept", App::is_work_kept);
    drop(window);
    let mut window = Window::start_as(vec![room], look, Some(data));
    window.until("lost work is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Recovery(_)))
    });
    album.take(&mut window, "recovery");
}

/// A report that is done, and the picture of a render in its file, opened again.
fn results(look: &Look, album: &mut Album) {
    let files = Files::new();
    let mut window = Window::start_as(vec![files.path("room.toml")], look, None);
    key(&mut window, Key::F5);
    window.until("the picture is done", is_over);
    let saved = files.path("room.exr");
    window.save_picture(&saved);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    let folder = files.path("report");
    window.enter("Folder", folder.to_str().unwrap());
    set_number(&mut window, "Seeds", "2");
    set_number(&mut window, "Picture width", "32");
    set_number(&mut window, "Picture height", "24");
    window.click("Start");
    window.until("the report is done", |app| !app.report().is_running());
    album.take(&mut window, "report done");
    drop(window);
    let mut window = Window::start_as(vec![saved], look, None);
    window.until("the picture shows", |app| {
        app.picture_on_screen().is_some_and(Picture::is_shown)
    });
    album.take(&mut window, "picture opened");
}

/// Files that change beside unsaved work.
fn changed_files(look: &Look, album: &mut Album) {
    let files = Files::new();
    let mut window = Window::start_as(vec![files.path("room.toml")], look, None);
    // The files are looked at once a second; what is written after that is a change.
    rest(&mut window, Duration::from_millis(1300));
    window.operate("Add light");
    files.write("room.toml", &SCENE.replace("60.0, 60.0, 60.0", "7, 9, 9"));
    window.until("it is asked", App::asks_to_reload);
    album.take(&mut window, "scene file changed");
    window.click("Keep mine");
    files.write("pyramid.off", "OFF\n3 1 0\n0 0 0\n2 0 0\n0 0 2\n3 0 1 2\n");
    window.until("the mesh is read again", |app| {
        app.messages().last_news().contains("has changed")
    });
    window.settle();
    album.take(&mut window, "mesh read again");
}

/// A scene some of whose files are not there, asked about and opened.
fn missing_files(look: &Look, album: &mut Album) {
    let files = Files::new();
    let gone = "\n[[objects]]\nname = \"ram\"\nmesh = \"gone/ram.off\"\n[background]\nimage = \"gone/sky.exr\"\n";
    let path = files.write("lacking.toml", &format!("{SCENE}{gone}"));
    let mut window = Window::start_as(vec![path], look, None);
    window.until("it is asked about what is missing", |app| {
        matches!(app.dialog(), Some(Dialog::Missing(_)))
    });
    album.take(&mut window, "missing files");
    window.click("Locate ram.off");
    window.enter_path(&files.path("pyramid.off"));
    window.until_says("found at");
    album.take(&mut window, "missing file located");
    window.click("Open without");
    window.until("it is open", |app| app.document().name() == "lacking");
    window.settle();
    window.click("Select Background");
    album.take(&mut window, "opened without a file");
}

/// Closing the window while something would be lost.
fn closing(look: &Look, album: &mut Album) {
    let files = Files::new();
    let long = SCENE.replace("samples_per_pixel = 4", "samples_per_pixel = 100_000");
    let mut window = Window::start_as(vec![files.write("long.toml", &long)], look, None);
    key(&mut window, Key::F5);
    window.until("tiles show", |app| {
        app.picture().is_some_and(|p| p.first_tile.is_some())
    });
    window.ask_to_close();
    window.until("the render is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Running))
    });
    album.take(&mut window, "closing with a render");
    for _ in 0..2 {
        // The question, then the render.
        key(&mut window, Key::Escape);
    }
    window.operate("Add light");
    window.ask_to_close();
    window.until("unsaved work is asked about", |app| {
        matches!(app.dialog(), Some(Dialog::Unsaved(_)))
    });
    album.take(&mut window, "closing with unsaved work");
}

/// An empty scene, one of many lights, and a window without a preview.
fn extremes(files: &Files, look: &Look, album: &mut Album) {
    let empty = files.write("empty.toml", "[camera]\neye = [0, -1, 0]\n");
    let mut window = Window::start_as(vec![empty], look, None);
    album.take(&mut window, "empty scene");
    let room = files.path("room.toml");
    let mut many = Window::start_as(vec![room.clone()], look, None);
    let lights = &mut scene_mut(&mut many).lights;
    let light = lights[0];
    lights.extend(std::iter::repeat_n(light, 30));
    many.settle();
    album.take(&mut many, "many lights");
    let mut blind = Window::start_without_gpu_as(vec![room], look);
    album.take(&mut blind, "no preview");
}

fn take_all(name: &str, look: &Look) {
    let mut album = Album::of(name);
    let files = Files::new();
    let mut window = Window::start_as(Vec::new(), look, None);
    // Smaller than usual, to be there sooner.
    let render = &mut scene_mut(&mut window).render;
    [render.width, render.height] = [640, 360];
    let started = Instant::now();
    editing(&mut window, &mut album);
    rendering(&mut window, &mut album);
    looking(&mut window, &mut album);
    comparing(&mut window, &mut album);
    questions(&files, &mut window, &mut album);
    recovery(&files, look, &mut album);
    results(look, &mut album);
    changed_files(look, &mut album);
    missing_files(look, &mut album);
    closing(look, &mut album);
    extremes(&files, look, &mut album);
    println!("{} in {:.0?}", album.folder.display(), started.elapsed());
    assert!(started.elapsed() < 20 * DEADLINE);
}

fn look(size: [f32; 2], pixels_per_point: f32, theme: egui::Theme) -> Look {
    Look {
        size: size.into(),
        pixels_per_point,
        theme,
    }
}

#[test]
#[ignore = "makes pictures to be looked at"]
fn dark() {
    take_all("dark", &look([1280.0, 800.0], 1.0, egui::Theme::Dark));
}

#[test]
#[ignore = "makes pictures to be looked at"]
fn light() {
    take_all("light", &look([1280.0, 800.0], 1.0, egui::Theme::Light));
}

#[test]
#[ignore = "makes pictures to be looked at"]
fn large() {
    take_all("large", &look([1920.0, 1080.0], 1.0, egui::Theme::Dark));
}

#[test]
#[ignore = "makes pictures to be looked at"]
fn fine() {
    take_all("fine", &look([1280.0, 800.0], 2.0, egui::Theme::Light));
}
