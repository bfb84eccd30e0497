//! `raymini render --checkpoint`: renders that are ended by force or by signal go on to the same bits, and files that are damaged,
//! or of something else, are refused with a reason.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = r#"
[camera]
eye = [0.0, -5.0, 2.0]
target = [0.0, 0.0, 0.0]
vertical_fov = 40.0

[background]
zenith = [0.2, 0.3, 0.6]
horizon = [0.8, 0.8, 0.8]

[[objects]]
name = "floor"
mesh = "builtin:ground"
scale = 4.0

[[objects]]
name = "wall"
mesh = "wall.off"
rotate = [80.0, 0.0, 10.0]

[[lights]]
kind = "disk"
center = [1.0, -1.0, 3.0]
target = [0.0, 0.0, 0.0]
radius = 0.5
radiance = [9.0, 8.0, 7.0]

[render]
width = 72
height = 60
samples_per_pixel = 64
ambient_occlusion = { enabled = true, samples = 16, radius = 0.5 }
"#;

const WALL: &str = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

/// A folder with a scene of a mesh of its own.
fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in [("scene.toml", SCENE), ("wall.off", WALL)] {
        std::fs::write(folder.path().join(name), text).expect("is written");
    }
    folder
}

fn raymini(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raymini"));
    command.current_dir(folder).args(arguments.split(' '));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(folder: &Path, arguments: &str) -> Output {
    raymini(folder, arguments).output().expect("starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs the program where it must end with that exit code; its complaint.
#[track_caller]
fn fail(folder: &Path, arguments: &str, code: i32) -> String {
    let output = run(folder, arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments}: {text}");
    text
}

/// Runs the program where it must succeed.
#[track_caller]
fn succeed(folder: &Path, arguments: &str) -> String {
    fail(folder, arguments, 0)
}

/// What a stats file says that does not depend on time and threads.
fn facts(folder: &Path, name: &str) -> Value {
    let bytes = std::fs::read(folder.join(name)).expect("is written");
    let mut facts: Value = serde_json::from_slice(&bytes).expect("is JSON");
    let keys = facts.as_object_mut().expect("is a table");
    for key in [
        "load_seconds",
        "build_seconds",
        "render_seconds",
        "first_tile_seconds",
        "peak_memory_bytes",
        "threads",
        "time_to",
    ] {
        assert!(keys.remove(key).is_some(), "{key}");
    }
    facts
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The changes to the scene of each kind of render, and the picture's extension.
const KINDS: [(&str, &str); 3] = [
    ("--set render.adaptive=false", "png"),
    ("--noise 1e-6", "png"),
    ("--noise 1e-6 --region 5,7,60,50", "exr"),
];

#[cfg(unix)]
mod signals {
    use std::process::Child;
    use std::time::{Duration, Instant, SystemTime};

    use super::*;

    fn kept_at(folder: &Path) -> Option<SystemTime> {
        let file = std::fs::metadata(folder.join("kept")).ok()?;
        Some(file.modified().expect("is told"))
    }

    /// Waits until another checkpoint is there; false where the program ends before.
    fn wait_for_checkpoint(folder: &Path, child: &mut Child, before: Option<SystemTime>) -> bool {
        let started = Instant::now();
        while kept_at(folder) == before || kept_at(folder).is_none() {
            assert!(started.elapsed() < Duration::from_mins(1), "no checkpoint");
            if child.try_wait().expect("can be asked").is_some() {
                return false;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        true
    }

    /// Renders on until a checkpoint is there and sends that signal then; the exit code, none where it ended by force, and what
    /// was said.
    fn interrupt(folder: &Path, arguments: &str, signal: &str) -> (Option<i32>, String) {
        let before = kept_at(folder);
        let resume = if before.is_some() { " --resume" } else { "" };
        let mut child = raymini(folder, &format!("{arguments}{resume}"))
            .spawn()
            .expect("starts");
        if wait_for_checkpoint(folder, &mut child, before) {
            let kill = format!("kill -{signal} {}", child.id());
            // It may have ended by now.
            let _ = Command::new("sh").args(["-c", &kill]).output();
        }
        let output = child.wait_with_output().expect("ends");
        (output.status.code(), said(&output))
    }

    /// Renders of each kind, ended again and again by that signal.
    fn check_interruptions(signal: &str, code: Option<i32>, least: u32) {
        for (changes, extension) in KINDS {
            let folder = folder();
            let folder = folder.path();
            let render = format!("render scene.toml {changes}");
            succeed(folder, &format!("{render} -o a.{extension} --stats a.json"));

            let render = format!("{render} -o b.{extension} --stats b.json --checkpoint kept");
            let mut interruptions = 0;
            loop {
                let threads = 1 + interruptions % 2;
                let arguments = format!("{render} --threads {threads} --checkpoint-every 0.05");
                let (found, said) = interrupt(folder, &arguments, signal);
                if found == Some(0) {
                    break;
                }
                assert_eq!(found, code, "{said}");
                assert!(
                    code.is_none() || said.contains("kept: --resume goes on from here"),
                    "{said}"
                );
                interruptions += 1;
                if interruptions == 4 {
                    succeed(folder, &format!("{render} --resume"));
                    break;
                }
            }
            assert!(interruptions >= least, "{interruptions} interruptions");
            assert_eq!(
                facts(folder, "b.json"),
                facts(folder, "a.json"),
                "{changes}"
            );
            assert!(!folder.join("kept").exists());
        }
    }

    #[test]
    fn what_is_ended_by_force_goes_on_to_the_same_bits() {
        check_interruptions("KILL", None, 2);
    }

    #[test]
    fn what_is_ended_by_signal_goes_on_to_the_same_bits() {
        check_interruptions("TERM", Some(143), 2);
    }

    /// One pass takes seconds here, so the checkpoint lies within it: some tiles have a sample and others none.
    #[test]
    fn a_signal_before_every_pixel_has_a_sample_loses_no_tile() {
        let folder = folder();
        let folder = folder.path();
        let render = "render scene.toml --spp 2 --set render.ambient_occlusion.samples=1024";
        succeed(folder, &format!("{render} -o a.png --stats a.json"));
        let once = format!("{render} -o b.png --stats b.json --checkpoint kept");
        let arguments = format!("{once} --threads 1 --checkpoint-every 0");
        let (code, said) = interrupt(folder, &arguments, "INT");
        assert_eq!(code, Some(130), "{said}");
        assert!(
            said.contains("no picture is written") && said.contains("--resume goes on from here"),
            "{said}"
        );
        assert!(!folder.join("b.png").exists());
        let said = succeed(folder, &format!("{once} --resume"));
        assert!(said.contains("kept: going on from 0."), "{said}");
        assert_eq!(facts(folder, "b.json"), facts(folder, "a.json"));
    }

    #[test]
    fn a_checkpoint_that_a_render_keeps_is_refused_to_others() {
        let folder = folder();
        let folder = folder.path();
        let render = "render scene.toml -o b.png --checkpoint kept";
        let arguments = format!("{render} --spp 65536 --checkpoint-every 0 --threads 1");
        let mut child = raymini(folder, &arguments).spawn().expect("starts");
        assert!(wait_for_checkpoint(folder, &mut child, None));
        for other in [render.to_owned(), format!("{render} --resume")] {
            let said = fail(folder, &other.replace("b.png", "c.png"), 1);
            let expected = "kept: the checkpoint is in use by another render";
            assert!(said.contains(expected), "{said}");
        }
        // What is ended by force leaves the checkpoint free.
        child.kill().expect("is ended");
        child.wait().expect("has ended");
        let said = fail(folder, render, 1);
        assert!(said.contains("kept: there is a file already"), "{said}");
        std::fs::remove_file(folder.join("kept")).expect("is there");
        succeed(folder, &format!("{render} --spp 1"));
        let left: Vec<_> = names(folder);
        assert!(left.iter().all(|name| !name.contains("lock")), "{left:?}");
    }

    /// What goes on from the checkpoint in a folder of [`interrupted`].
    pub const GO_ON: &str = "render scene.toml -o b.png --checkpoint kept --resume";

    /// A folder with the scene and a checkpoint of it.
    pub fn interrupted() -> TempDir {
        let folder = folder();
        let render = "render scene.toml -o b.png --checkpoint kept --checkpoint-every 0";
        let (code, said) = interrupt(folder.path(), render, "KILL");
        assert_eq!(code, None, "{said}");
        folder
    }
}

#[test]
#[cfg(unix)]
fn damage_anywhere_is_refused() {
    let folder = signals::interrupted();
    let folder = folder.path();
    let path = folder.join("kept");
    let whole = std::fs::read(&path).expect("is there");
    let mut damaged: Vec<Vec<u8>> = Vec::new();
    for part in 0..50 {
        let place = part * whole.len() / 50;
        let mut flipped = whole.clone();
        flipped[place] ^= 1 << (part % 8);
        damaged.extend([flipped, whole[..place].to_vec()]);
    }
    let last = whole.len() - 1;
    damaged.push([&whole[..last], &[whole[last] ^ 1]].concat());
    damaged.push([&whole[..], b"\n"].concat());
    for (number, bytes) in damaged.iter().enumerate() {
        std::fs::write(&path, bytes).expect("is written");
        let said = fail(folder, signals::GO_ON, 1);
        let expected = match number {
            0 | 1 => "kept: this is not a checkpoint of a render",
            _ => "kept: the checkpoint is damaged: what it holds is not what was written",
        };
        assert!(said.contains(expected), "{number}: {said}");
    }

    // Later versions say so in the first line, whatever follows.
    let line = whole
        .iter()
        .position(|&byte| byte == b'\n')
        .expect("a line");
    let later = [b"RayMini checkpoint 9", &whole[line..]].concat();
    std::fs::write(&path, later).expect("is written");
    let said = fail(folder, signals::GO_ON, 1);
    assert!(said.contains("of another version of RayMini"), "{said}");
}

#[test]
fn something_else_is_refused() {
    let folder = folder();
    let folder = folder.path();
    let resume = |file: &str| format!("render scene.toml -o a.png --checkpoint {file} --resume");
    std::fs::write(folder.join("empty"), "").expect("is written");
    std::fs::create_dir(folder.join("folder")).expect("a folder");
    for (file, expected) in [
        (
            "scene.toml",
            "scene.toml: this is not a checkpoint of a render",
        ),
        ("empty", "empty: this is not a checkpoint of a render"),
        (
            "folder",
            "folder: cannot write the checkpoint: this is a folder",
        ),
        (
            "none",
            "none: there is no checkpoint to go on from; leave --resume out",
        ),
        ("no/none", "no/none: there is no checkpoint to go on from"),
    ] {
        let said = fail(folder, &resume(file), 1);
        assert!(said.contains(expected), "{said}");
    }
    // A file far larger than any checkpoint of this picture, all holes.
    let file = std::fs::File::create(folder.join("large")).expect("is made");
    std::io::Write::write_all(&mut &file, b"RayMini checkpoint 3\n").expect("is written");
    file.set_len(1 << 36).expect("a hole");
    let said = fail(folder, &resume("large"), 1);
    assert!(said.contains("large: the file is too large: "), "{said}");
}

#[test]
fn mistakes_are_found_before_the_scene_is_read() {
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("there"), "hours").expect("is written");
    for (arguments, code, expected) in [
        ("--resume", 2, "--checkpoint <FILE>"),
        ("--checkpoint-every 5", 2, "--checkpoint <FILE>"),
        (
            "--checkpoint a --checkpoint-every x",
            2,
            "a number of seconds",
        ),
        (
            "--checkpoint there",
            1,
            "there: there is a file already, maybe of a render",
        ),
        (
            "--checkpoint no/a",
            1,
            "cannot write the checkpoint: the folder no does not exist",
        ),
        (
            "--checkpoint ./a.png",
            1,
            "a.png: the checkpoint needs a file of its own",
        ),
        (
            "--stats b --checkpoint b",
            1,
            "b: the checkpoint needs a file of its own",
        ),
    ] {
        let said = fail(
            folder,
            &format!("render none.toml -o a.png {arguments}"),
            code,
        );
        assert!(said.contains(expected), "{arguments}: {said}");
    }
    assert_eq!(names(folder), ["scene.toml", "there", "wall.off"]);
    let there = std::fs::read(folder.join("there")).expect("is there");
    assert_eq!(there, b"hours");
}

#[test]
#[cfg(unix)]
fn another_render_is_refused_with_what_differs() {
    let folder = signals::interrupted();
    let folder = folder.path();
    let refused = |changes: &str, expected: &str| {
        let said = fail(folder, &format!("{}{changes}", signals::GO_ON), 1);
        let expected = format!("kept: it is a checkpoint of another render: {expected}");
        assert!(said.contains(&expected), "{said}");
    };
    refused(" --seed 3", "render.seed is 0, here 3");
    refused(" --region 0,0,72,59", "region is 0,0,72,60, here 0,0,72,59");
    refused(" --spp 1", "render.error_estimate is true, here false");
    refused(
        " --set objects.1.scale=2",
        "objects.1.scale is 1.0, here 2.0",
    );
    let exr = signals::GO_ON.replace("b.png", "b.exr");
    let said = fail(folder, &exr, 1);
    assert!(
        said.contains("another render: layers is [], here [\"emission\", "),
        "{said}"
    );
    let wall: PathBuf = folder.join("wall.off");
    std::fs::write(&wall, WALL.replace("1 1 0", "1 1.5 0")).expect("is written");
    refused("", "objects.1.mesh is \"wall.off with the SHA-256 ");
    // With the wall as it was, and moved with the scene, it goes on.
    std::fs::write(&wall, WALL).expect("is written");
    let kept = std::fs::read(folder.join("kept")).expect("is there");
    let elsewhere = self::folder();
    std::fs::write(elsewhere.path().join("kept"), kept).expect("is written");
    let said = succeed(elsewhere.path(), signals::GO_ON);
    assert!(said.contains("kept: going on from "), "{said}");
}

/// When it ends is no part of what is rendered: more samples, and the same bits as by these from the start.
#[test]
#[cfg(unix)]
fn an_interrupted_render_goes_on_by_other_rules() {
    let image_hash = |folder: &Path| facts(folder, "stats.json")["image_hash"].clone();
    let folder = signals::interrupted();
    let folder = folder.path();
    let kept = std::fs::read(folder.join("kept")).expect("is there");
    let go_on = |rules: &str| {
        std::fs::write(folder.join("kept"), &kept).expect("is written");
        let said = succeed(
            folder,
            &format!("{} --stats stats.json {rules}", signals::GO_ON),
        );
        assert!(said.contains("kept: going on from "), "{said}");
    };
    go_on("--spp 96");
    let more = image_hash(folder);
    succeed(
        folder,
        "render scene.toml -o c.png --stats stats.json --spp 96",
    );
    assert_eq!(image_hash(folder), more);
    go_on("--noise 0.9 --seconds 600");
    assert_eq!(facts(folder, "stats.json")["ending"], "noise");
}

/// Under a limit on the size of files that the picture keeps and the checkpoint does not.
#[test]
#[cfg(unix)]
fn a_checkpoint_that_cannot_be_written_ends_no_render() {
    let folder = folder();
    let folder = folder.path();
    let limited = format!(
        "trap '' XFSZ; ulimit -f 64; exec {} render scene.toml -o a.png --spp 8 --checkpoint kept --checkpoint-every 0",
        env!("CARGO_BIN_EXE_raymini")
    );
    let mut command = Command::new("sh");
    let output = command.current_dir(folder).args(["-c", &limited]).output();
    let output = output.expect("starts");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let warning = "warning: kept: cannot write the checkpoint: ";
    assert_eq!(said.matches(warning).count(), 1, "{said}");
    assert!(said.contains("; the render goes on"), "{said}");
    assert_eq!(names(folder), ["a.png", "scene.toml", "wall.off"]);
}
