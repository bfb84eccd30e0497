//! The real program in a real window: started under a virtual display, driven by mouse and keyboard, it renders, compares and saves a
//! PNG whose pixels are those of the command line.
//!
//! It needs a virtual X server, a tool that presses keys and a software Vulkan driver, and fails without them. On Debian:
//! `apt install xvfb xdotool mesa-vulkan-drivers libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use egui::{Pos2, Vec2};

use crate::driver::{self, Look};

const DEADLINE: Duration = Duration::from_secs(90);

/// So large that all effects are in sight, in pixels. The screen is as large.
const TALL: [u16; 2] = [1280, 1200];

/// A process that ends with the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual display of its own, at a number that is free.
struct Display {
    _server: Process,
    name: String,
}

impl Display {
    fn start() -> Self {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                &format!("{}x{}x24", TALL[0], TALL[1]),
                "-nolisten",
                "tcp",
                // Else it begins anew, and refuses whoever comes then, when the last window is killed.
                "-noreset",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts; on Debian: apt install xvfb");
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let number: u32 = line.trim().parse().expect("Xvfb says its display");
        Self {
            _server: Process(server),
            name: format!(":{number}"),
        }
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.name)
            .output()
            .expect("xdotool runs; on Debian: apt install xdotool");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }
}

/// Asks again and again until there is an answer.
fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + DEADLINE;
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(Instant::now() < deadline, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(30));
    }
}

/// [`wait_for`], but `None` when it takes longer than `seconds`.
fn wait_briefly<T>(seconds: u64, mut ask: impl FnMut() -> Option<T>) -> Option<T> {
    let deadline = Instant::now() + Duration::from_secs(seconds);
    while Instant::now() < deadline {
        if let Some(answer) = ask() {
            return Some(answer);
        }
        std::thread::sleep(Duration::from_millis(30));
    }
    None
}

fn pixels(path: &Path) -> Option<image::RgbImage> {
    Some(image::open(path).ok()?.to_rgb8())
}

/// A scene of a ram in `folder`, with `samples` samples per pixel.
fn write_scene(folder: &Path, samples: u32) -> PathBuf {
    let ram = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/ram.off");
    let scene = folder.join("room.toml");
    let text = format!(
        "[camera]\neye = [1.0, -4.0, 1.5]\ntarget = [0.0, 0.0, 0.6]\n\
         [background]\nradiance = [0.2, 0.25, 0.3]\n\
         [[objects]]\nmesh = {:?}\nsmooth = true\n\
         [[lights]]\nkind = \"point\"\nposition = [3.0, -3.0, 4.0]\nintensity = [40.0, 40.0, 40.0]\n\
         [render]\nwidth = 320\nheight = 240\nsamples_per_pixel = {samples}\n",
        ram.to_str().unwrap()
    );
    std::fs::write(&scene, text).unwrap();
    scene
}

/// The program with a window.
struct Window<'a> {
    process: Process,
    id: String,
    display: &'a Display,
}

impl<'a> Window<'a> {
    /// Opens `scene`, with `folder` as home of all that is kept, and waits until its title names the scene.
    fn open(display: &'a Display, folder: &Path, scene: &Path) -> Self {
        let log = std::fs::File::create(folder.join("log")).unwrap();
        let mut process = Process(
            Command::new(env!("CARGO_BIN_EXE_raymini"))
                .arg(scene)
                .current_dir(folder)
                .env("DISPLAY", &display.name)
                // A point is a pixel, whatever size the screen says it has.
                .env("WINIT_X11_SCALE_FACTOR", "1")
                .env("XDG_RUNTIME_DIR", folder)
                .env("XDG_DATA_HOME", folder.join("data"))
                .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent")
                .env_remove("WAYLAND_DISPLAY")
                .stderr(log)
                .spawn()
                .expect("the program starts"),
        );
        let id = wait_for("the window", || {
            assert!(
                process.0.try_wait().unwrap().is_none(),
                "the program ended: {}",
                std::fs::read_to_string(folder.join("log")).unwrap_or_default()
            );
            let found = display.xdotool(&["search", "--onlyvisible", "--name", "room.*RayMini"]);
            found.lines().next().map(str::to_owned)
        });
        display.xdotool(&["windowfocus", "--sync", &id]);
        Self {
            process,
            id,
            display,
        }
    }

    fn title(&self) -> String {
        self.display.xdotool(&["getwindowname", &self.id])
    }

    fn press(&self, keys: &str) {
        self.display.xdotool(&["key", keys]);
    }

    /// Its place and size, as the display tells them, a number a line.
    fn geometry(&self) -> String {
        let geometry = ["getwindowgeometry", "--shell", &self.id];
        self.display.xdotool(&geometry)
    }

    /// Makes it [`TALL`].
    fn make_tall(&self) {
        let [width, height] = TALL.map(|side| side.to_string());
        let wanted = [format!("WIDTH={width}"), format!("HEIGHT={height}")];
        wait_for("the window to be tall", || {
            let size = ["windowsize", &self.id, &width, &height];
            self.display.xdotool(&size);
            wait_briefly(5, || {
                let told = self.geometry();
                let has = |line: &String| told.lines().any(|told| told == line);
                wanted.iter().all(has).then_some(())
            })
        });
    }

    fn point_at(&self, place: Pos2) {
        let [x, y] = [place.x, place.y].map(|at| format!("{at:.0}"));
        let to = ["mousemove", "--window", &self.id, &x, &y];
        self.display.xdotool(&to);
        // Until a frame has seen it there.
        std::thread::sleep(Duration::from_millis(200));
    }

    /// Whether something is not saved, as its title tells.
    fn is_modified(&self) -> bool {
        self.title().contains('•')
    }

    /// Drags in the preview until the camera has moved. Before the preview is there, nothing can be dragged.
    fn orbit(&self) {
        wait_for("the camera to be dragged", || {
            self.point_at(Pos2::new(400.0, 500.0));
            self.display.xdotool(&["mousedown", "1"]);
            for x in [420.0, 450.0, 480.0] {
                self.point_at(Pos2::new(x, 490.0));
            }
            self.display.xdotool(&["mouseup", "1"]);
            wait_briefly(3, || self.is_modified().then_some(()))
        });
    }

    /// Clicks at `place` of the [`TALL`] window until something has changed that is not saved.
    fn edit_at(&self, place: Pos2) {
        assert!(!self.is_modified());
        let what = format!("the click at {place} to change something");
        wait_for(&what, || {
            self.make_tall();
            self.point_at(place);
            self.display.xdotool(&["click", "1"]);
            let change = wait_briefly(3, || self.is_modified().then_some(()));
            if change.is_none() {
                eprintln!("not yet: {:?}, {}", self.title(), self.geometry());
            }
            change
        });
    }

    /// Saves the scene to its file.
    fn save_scene(&self) {
        wait_for("the work to be saved", || {
            self.press("ctrl+s");
            wait_briefly(3, || (!self.is_modified()).then_some(()))
        });
    }

    /// Renders to the end: F5 does, and the title says how far.
    fn render(&self) {
        self.start_render();
        wait_for("the render to end", || {
            (!self.title().contains('%')).then_some(())
        });
    }

    /// Presses `keys` until the title says that a render runs.
    fn start_render(&self) {
        wait_for("the render to start", || {
            self.press("F5");
            wait_briefly(5, || self.title().contains('%').then_some(()))
        });
    }

    /// Ends it as the system does that has no memory left.
    #[cfg(unix)]
    fn kill(&mut self) {
        self.process.0.kill().unwrap();
        let status = self.process.0.wait().unwrap();
        let signal = std::os::unix::process::ExitStatusExt::signal(&status);
        assert_eq!(signal, Some(9));
    }

    /// Closes it, as nothing is unsaved.
    fn quit(mut self) {
        self.press("ctrl+q");
        let status = wait_for("the program to end", || self.process.0.try_wait().unwrap());
        assert!(status.success(), "{status}");
    }
}

/// Where a [`TALL`] window on `scene` has the button that switches shadows off: one that is laid out the same tells, by its name.
fn place_of_shadows_off(scene: &Path) -> Pos2 {
    let look = Look {
        size: Vec2::from(TALL.map(f32::from)),
        ..Look::default()
    };
    let window = driver::Window::start_as(vec![scene.to_owned()], &look, None);
    let place = window.rect("Shadows: Off").center();
    assert!(place.y < look.size.y - 50.0, "{place} is out of sight");
    place
}

/// Launch, orbit, render, switch an effect, compare, save, quit.
#[test]
fn the_real_window_renders_and_saves_what_the_command_line_does() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write_scene(folder.path(), 128);
    let shadows_off = place_of_shadows_off(&scene);
    let display = Display::start();
    let window = Window::open(&display, folder.path(), &scene);
    window.make_tall();
    window.orbit();
    window.render();

    // What is saved is told from what the click changes.
    window.save_scene();
    window.edit_at(shadows_off);
    window.render();

    // C compares with the render before; what is saved is still the picture that is looked at.
    window.press("c");
    std::thread::sleep(Duration::from_secs(1));

    // Ctrl+E asks for a path; it is typed.
    let saved = folder.path().join("window.png");
    wait_for("the picture to be saved", || {
        window.press("ctrl+e");
        std::thread::sleep(Duration::from_millis(1500));
        window.press("ctrl+a");
        display.xdotool(&["type", "--delay", "20", saved.to_str().unwrap()]);
        window.press("Return");
        let picture = wait_briefly(5, || pixels(&saved));
        if picture.is_none() {
            window.press("Escape");
        }
        picture
    });

    window.save_scene();
    let text = std::fs::read_to_string(&scene).unwrap();
    assert!(!text.contains(EYE), "{text}");
    assert!(text.contains("shadows = \"off\""), "{text}");
    let by_command = folder.path().join("command.png");
    let status = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .args(["render", scene.to_str().unwrap(), "-o"])
        .arg(&by_command)
        .stderr(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    let (window_picture, command_picture) = (pixels(&saved).unwrap(), pixels(&by_command).unwrap());
    assert_eq!(window_picture.dimensions(), (320, 240));
    assert!(window_picture == command_picture, "the pictures differ");
    window.quit();
}

/// Killed with SIGKILL in the first second of a render, after an edit: the next start offers the work, the render goes on, and saving writes
/// the scene.
#[cfg(unix)]
#[test]
fn what_was_edited_before_a_kill_is_restored() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write_scene(folder.path(), 1_000_000);
    let before = std::fs::read_to_string(&scene).unwrap();
    let display = Display::start();
    let mut window = Window::open(&display, folder.path(), &scene);

    // F frames all, which moves the camera; a second later that is on disk.
    wait_for("the camera to move", || {
        window.press("f");
        wait_briefly(3, || window.title().contains('•').then_some(()))
    });
    window.start_render();
    std::thread::sleep(Duration::from_secs(1));
    window.kill();
    assert_eq!(std::fs::read_to_string(&scene).unwrap(), before);

    let after = restored(&display, folder.path(), &scene, true);
    assert!(!after.contains(EYE), "{after}");
    assert!(after.contains("samples_per_pixel = 1000000"), "{after}");
}

/// Killed with SIGKILL while the mouse drags the camera, after a step of that: all but the last second of the drag is there.
#[cfg(unix)]
#[test]
fn what_is_dragged_at_a_kill_is_restored_but_for_the_last_second() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write_scene(folder.path(), 64);
    let display = Display::start();
    let mut window = Window::open(&display, folder.path(), &scene);
    let go_to = |x: u32| display.xdotool(&["mousemove", &x.to_string(), "400"]);
    // Until the preview is there, nothing can be dragged.
    wait_for("the camera to be dragged", || {
        go_to(400);
        std::thread::sleep(Duration::from_millis(300));
        display.xdotool(&["mousedown", "1"]);
        for x in [420, 440, 460] {
            std::thread::sleep(Duration::from_millis(150));
            go_to(x);
        }
        let is_dragged = wait_briefly(3, || window.title().contains('•').then_some(()));
        if is_dragged.is_none() {
            display.xdotool(&["mouseup", "1"]);
        }
        is_dragged
    });
    std::thread::sleep(Duration::from_millis(1500));
    go_to(520);
    std::thread::sleep(Duration::from_millis(100));
    window.kill();
    display.xdotool(&["mouseup", "1"]);
    let after = restored(&display, folder.path(), &scene, false);
    assert!(!after.contains(EYE), "{after}");
}

/// The camera of the scene.
const EYE: &str = "eye = [1.0, -4.0, 1.5]";

/// Opens the window again on `scene`, has it restore what is offered and save it; returns the file. `goes_on`: whether a render goes on, which
/// is cancelled.
#[cfg(unix)]
fn restored(display: &Display, folder: &Path, scene: &Path, goes_on: bool) -> String {
    assert!(std::fs::read_to_string(scene).unwrap().contains(EYE));
    let window = Window::open(display, folder, scene);
    assert!(!window.title().contains('•'));
    wait_for("the work to be restored", || {
        window.press("Return");
        wait_briefly(3, || window.title().contains('•').then_some(()))
    });
    window.save_scene();
    if goes_on {
        let renders = || window.title().contains('%');
        wait_for("the render to go on", || renders().then_some(()));
        wait_for("the render to be cancelled", || {
            window.press("Escape");
            wait_briefly(3, || (!renders()).then_some(()))
        });
    }
    window.quit();
    std::fs::read_to_string(scene).unwrap()
}

/// How often threads of the process have run so far, but for those of the crate `blocking`, by which the desktop's accessibility bus
/// is listened to: they look twice a second whether there is anything to do.
#[cfg(target_os = "linux")]
fn turns(process: u32) -> u64 {
    let threads = std::fs::read_dir(format!("/proc/{process}/task")).unwrap();
    let turns_of = |thread: std::io::Result<std::fs::DirEntry>| {
        let status = std::fs::read_to_string(thread.ok()?.path().join("status")).ok()?;
        let numbers = |key: &str| {
            let lines = status.lines().filter(|line| line.contains(key));
            let numbers =
                lines.filter_map(|line| line.split_whitespace().last()?.parse::<u64>().ok());
            numbers.sum::<u64>()
        };
        let is_of_bus = status.starts_with("Name:\tblocking-");
        (!is_of_bus).then(|| numbers("ctxt_switches"))
    };
    threads.filter_map(turns_of).sum()
}

/// With a mesh open and nobody at the mouse, one thread of the program's wakes, once a second, to look whether files have changed: no frame
/// is drawn, which would take dozens of turns.
#[cfg(target_os = "linux")]
#[test]
fn an_idle_window_uses_no_processor() {
    const SECONDS: u64 = 5;
    let folder = tempfile::tempdir().unwrap();
    let scene = write_scene(folder.path(), 4);
    let display = Display::start();
    let window = Window::open(&display, folder.path(), &scene);
    let process = window.process.0.id();
    wait_for("the window to be idle", || {
        let before = turns(process);
        std::thread::sleep(Duration::from_secs(SECONDS));
        // A look may be cut in two by another program.
        (turns(process) <= before + 2 * SECONDS).then_some(())
    });
    window.quit();
}
