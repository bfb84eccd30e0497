//! Drives the window as a user does: by the names on its controls, by keys and by the mouse.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, accesskit::Role};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, HarnessBuilder};
use raymini::control::{CancelToken, Progress};
use raymini::gui::dialogs::Dialog;
use raymini::gui::keeping::load_layout;
use raymini::gui::picture::Outcome;
use raymini::gui::{App, AppOptions, FileDialogs, orbit, viewport};
use raymini::io;
use raymini::math::DVec3;
use raymini::render::{PreparedScene, RenderProgress, RenderStats, RunConfig, render};
use raymini::scene::Scene;

/// Longest wait for anything; machines differ, tests must not hang.
pub const DEADLINE: Duration = Duration::from_mins(1);

/// Where the side panel ends, above the status bar.
const PANEL_BOTTOM: f32 = 765.0;

/// A mesh of two pyramids.
pub const MESH: &str = "OFF\n7 10 0\n\
    -1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n0 0 1.5\n3 0 0.5\n3 1 1\n\
    3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n3 2 1 0\n3 3 2 0\n3 1 5 4\n3 5 6 4\n3 2 6 5\n3 1 2 5\n";

pub const SCENE: &str = r#"
[camera]
eye = [2.0, -7.0, 3.0]
target = [0.5, 0.0, 0.5]

[materials.clay]
kind = "phong"
diffuse = [0.8, 0.5, 0.3]
specular = [0.1, 0.1, 0.1]

[[objects]]
name = "pyramid"
mesh = "pyramid.off"
material = "clay"

[[lights]]
kind = "point"
position = [-3.0, -3.0, 4.0]
intensity = [60.0, 60.0, 60.0]

[render]
width = 160
height = 120
samples_per_pixel = 4
"#;

/// A folder with a scene and its mesh.
pub struct Files {
    pub folder: tempfile::TempDir,
}

impl Files {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("pyramid.off"), MESH).unwrap();
        std::fs::write(folder.path().join("room.toml"), SCENE).unwrap();
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).unwrap();
        self.path(name)
    }
}

/// A file that hangs over the window and is let go of.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the window reads by path".to_owned())
    }
}

/// What a window looks like.
pub struct Look {
    /// In points.
    pub size: Vec2,
    pub pixels_per_point: f32,
    pub theme: egui::Theme,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            size: Vec2::new(1280.0, 800.0),
            pixels_per_point: 1.0,
            theme: egui::Theme::Dark,
        }
    }
}

/// The window under test.
pub struct Window {
    pub harness: Harness<'static, App>,
}

impl Window {
    pub fn open(path: &Path) -> Self {
        Self::start(vec![path.to_owned()], true)
    }

    pub fn start(paths: Vec<PathBuf>, with_gpu: bool) -> Self {
        Self::start_keeping(paths, with_gpu, None)
    }

    /// A window that keeps unsaved work in the folder `data`.
    pub fn start_keeping(paths: Vec<PathBuf>, with_gpu: bool, data: Option<PathBuf>) -> Self {
        let builder = Self::builder(&Look::default());
        let builder = if with_gpu { builder.wgpu() } else { builder };
        Self::build(builder, paths, data)
    }

    /// A window that looks like `look`, and keeps unsaved work in the folder `data`.
    pub fn start_as(paths: Vec<PathBuf>, look: &Look, data: Option<PathBuf>) -> Self {
        Self::build(Self::builder(look).wgpu(), paths, data)
    }

    /// [`Self::start_as`] where there is no graphics adapter for the preview.
    pub fn start_without_gpu_as(paths: Vec<PathBuf>, look: &Look) -> Self {
        Self::build(Self::builder(look), paths, None)
    }

    fn builder(look: &Look) -> HarnessBuilder<App> {
        Harness::builder()
            .with_size(look.size)
            .with_pixels_per_point(look.pixels_per_point)
            .with_theme(look.theme)
            .with_step_dt(1.0 / 60.0)
    }

    fn build(builder: HarnessBuilder<App>, paths: Vec<PathBuf>, data: Option<PathBuf>) -> Self {
        let options = AppOptions {
            paths,
            file_dialogs: FileDialogs::PathField,
            layout: data.as_deref().map(load_layout).unwrap_or_default(),
            data_folder: data,
        };
        let harness = builder.build_eframe(move |creation| App::new(creation, options));
        let mut window = Self { harness };
        window.settle();
        window
    }

    pub fn app(&self) -> &App {
        self.harness.state()
    }

    pub fn scene(&self) -> &Scene {
        &self.app().document().scene
    }

    /// Draws frames until `holds`.
    pub fn until(&mut self, what: &str, holds: impl Fn(&App) -> bool) {
        self.just_until(what, holds);
        self.harness.run_steps(2);
    }

    /// [`Self::until`], and not a frame more.
    pub fn just_until(&mut self, what: &str, holds: impl Fn(&App) -> bool) {
        let deadline = Instant::now() + DEADLINE;
        while !holds(self.app()) {
            assert!(Instant::now() < deadline, "waited in vain until {what}");
            self.harness.step();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Draws frames until `part` is somewhere to be read.
    pub fn until_says(&mut self, part: &str) {
        let deadline = Instant::now() + DEADLINE;
        while !self.says(part) {
            assert!(Instant::now() < deadline, "{part:?} is not told");
            self.harness.step();
        }
    }

    /// Until files are read and the scene is prepared, or a message says why not.
    pub fn settle(&mut self) {
        self.until("the scene is ready", |app| {
            !app.is_settling() || !app.messages().banners().is_empty()
        });
    }

    /// Saves the picture on the screen by shortcut and a typed path.
    pub fn save_picture(&mut self, path: &Path) {
        self.press(Modifiers::COMMAND, Key::E);
        self.enter_path(path);
        self.until_saved(path);
    }

    /// Until the window tells that it has saved what was to go to `path`.
    pub fn until_saved(&mut self, path: &Path) {
        let news = format!("Saved {}", path.display());
        self.until("it is saved", |app| app.messages().last_news() == news);
    }

    /// Asks the window to close, as the desktop does.
    pub fn ask_to_close(&mut self) {
        fn events(window: &mut Window) -> &mut Vec<egui::ViewportEvent> {
            let viewports = &mut window.harness.input_mut().viewports;
            &mut viewports.entry(egui::ViewportId::ROOT).or_default().events
        }
        events(self).push(egui::ViewportEvent::Close);
        self.harness.step();
        events(self).clear();
        self.harness.run_steps(2);
    }

    /// Clicks a control where it is, which must be in sight.
    pub fn click(&mut self, name: &str) {
        let control = self.harness.get_by_label(name);
        let window = self.harness.ctx.content_rect();
        let place = control.rect().center();
        assert!(window.contains(place), "{name} is out of sight");
        control.click();
        self.harness.run_steps(3);
    }

    /// Clicks a control as assistive technology does, also where it is scrolled out of sight.
    pub fn operate(&mut self, name: &str) {
        self.harness.get_by_label(name).click_accesskit();
        self.harness.run_steps(3);
    }

    pub fn has(&self, name: &str) -> bool {
        self.harness.query_by_label(name).is_some()
    }

    /// Where the control called `name` is on the screen.
    pub fn rect(&self, name: &str) -> egui::Rect {
        self.harness.get_by_label(name).rect()
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    /// Types a path into the path field and confirms it.
    pub fn enter_path(&mut self, path: &Path) {
        self.enter("Path", path.to_str().unwrap());
    }

    /// Types into the text field called `name`, in place of what is there.
    pub fn fill(&mut self, name: &str, text: &str) {
        let field = self.harness.get_by_role_and_label(Role::TextInput, name);
        field.focus();
        self.harness.run_steps(1);
        self.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.harness.run_steps(1);
        let field = self.harness.get_by_role_and_label(Role::TextInput, name);
        field.type_text(text);
        self.harness.run_steps(2);
    }

    /// [`Self::fill`], and confirms it.
    pub fn enter(&mut self, name: &str, text: &str) {
        self.fill(name, text);
        self.harness.key_press(Key::Enter);
        self.harness.run_steps(3);
    }

    /// Where a world point is on the screen.
    pub fn on_screen(&self, point: DVec3) -> Pos2 {
        let frame = self.harness.get_by_label("Viewport").rect();
        let size = viewport::picture_size(frame);
        let (position, _) = orbit::project(&self.scene().camera, size, point).unwrap();
        #[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
        let offset = Vec2::new(position.x as f32, position.y as f32);
        frame.min + offset
    }

    pub fn click_at(&mut self, position: Pos2) {
        self.clicks_at(position, 1);
    }

    /// Clicks so quickly that several clicks are one multiple click.
    pub fn clicks_at(&mut self, position: Pos2, count: usize) {
        self.harness.hover_at(position);
        self.harness.run_steps(1);
        for pressed in [true, false].repeat(count) {
            self.harness.event(Event::PointerButton {
                pos: position,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            });
            self.harness.run_steps(1);
        }
        self.harness.run_steps(1);
    }

    pub fn drag(&mut self, button: PointerButton, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.run_steps(1);
        let press = |pos, pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.harness.event(press(from, true));
        self.harness.run_steps(1);
        for step in 1..=4_u8 {
            self.harness
                .hover_at(from + (to - from) * (f32::from(step) / 4.0));
            self.harness.run_steps(1);
        }
        self.harness.event(press(to, false));
        self.harness.run_steps(2);
    }

    /// Drops a file on the window, which reads it from the next frame on.
    pub fn drop_file(&mut self, path: PathBuf) {
        let dropped = std::sync::Arc::new(Dropped(path));
        self.harness.input_mut().dropped_files.push(dropped);
    }

    /// Waits until it is asked what becomes of meshes that were read, and answers by the button called `answer`.
    pub fn import(&mut self, answer: &str) {
        self.harness.step();
        self.until("it is asked what becomes of the mesh", |app| {
            matches!(app.dialog(), Some(Dialog::Import(_)))
        });
        self.click(answer);
    }

    /// What the window looks like at a place.
    pub fn color_at(&mut self, place: Pos2) -> [u8; 3] {
        let screen = self.harness.render().unwrap();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "pixels"
        )]
        let [red, green, blue, _] = screen.get_pixel(place.x as u32, place.y as u32).0;
        [red, green, blue]
    }

    pub fn render(&mut self) {
        let number = |app: &App| app.picture().map(|picture| picture.number);
        let before = number(self.app());
        self.click("Render");
        self.until("the picture is finished", |app| {
            let picture = app.picture().filter(|_| number(app) != before);
            picture.is_some_and(|picture| !picture.is_running())
        });
    }

    pub fn hash(&self) -> String {
        self.finished().0
    }

    /// Hash and statistics of the finished picture.
    pub fn finished(&self) -> (String, RenderStats) {
        match &self.app().picture().expect("a picture").outcome {
            Outcome::Finished { hash, stats } => (hash.clone(), **stats),
            other => panic!("the picture is {other:?}"),
        }
    }

    pub fn says(&self, part: &str) -> bool {
        self.harness
            .query_all_by_label_contains(part)
            .next()
            .is_some()
    }
}

/// The hash of the picture that the library makes of `scene`.
pub fn library_hash(scene: &Scene) -> String {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    let prepared = prepared.unwrap().unwrap();
    let run = RunConfig {
        threads: 1,
        ..RunConfig::default()
    };
    let outcome = render(&prepared, None, &run, &RenderProgress::default(), None);
    outcome.unwrap().image.hash()
}

pub fn load(path: &Path) -> Scene {
    let loaded = io::load_scene(path, &CancelToken::new(), &Progress::new());
    loaded.unwrap().unwrap().scene
}

/// Types the number of samples into its field.
pub fn set_samples(window: &mut Window, samples: u32) {
    set_number(window, "Samples", &samples.to_string());
    assert_eq!(window.scene().render.samples_per_pixel, samples);
}

/// Types a number into the field called `name`.
pub fn set_number(window: &mut Window, name: &str, number: &str) {
    // What a user scrolls to first.
    let field = window.harness.get_by_label(name);
    if field.rect().bottom() > PANEL_BOTTOM {
        field.scroll_to_me();
        window.harness.run_steps(30);
    }
    window.harness.get_by_label(name).click();
    window.harness.run_steps(2);
    window
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.harness.run_steps(1);
    window.harness.event(Event::Text(number.to_owned()));
    window.harness.run_steps(1);
    window.harness.key_press(Key::Enter);
    window.harness.run_steps(2);
}
