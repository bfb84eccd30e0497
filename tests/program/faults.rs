//! The built program where the world around it fails: files that cannot be written or read, and signals.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use raymini::control::{CancelToken, Progress};
use raymini::io;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a scene of the built-in ground alone.
fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let scene = "[[objects]]\nmesh = \"builtin:ground\"\n[background]\nradiance = [1, 1, 1]\n";
    std::fs::write(folder.path().join("scene.toml"), scene).expect("is written");
    folder
}

fn raymini(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raymini"));
    command.current_dir(folder).args(arguments);
    command
}

/// The exit code of a program that has ended, and its complaint.
fn complaint(output: &Output) -> (Option<i32>, String) {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), text)
}

/// Runs the program where it must fail with exit code 1; its complaint.
fn fail(folder: &Path, arguments: &[&str]) -> String {
    let output = raymini(folder, arguments).output().expect("starts");
    let (code, text) = complaint(&output);
    assert_eq!(code, Some(1), "{arguments:?}: {text}");
    text
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn has_extension(name: &str, extension: &str) -> bool {
    Path::new(name).extension().is_some_and(|e| e == extension)
}

/// The scene does not exist, so whoever complains about the output has done so before any work.
#[test]
fn what_cannot_be_written_is_found_before_the_render() {
    let folder = folder();
    for name in ["folder.png", "folder.json"] {
        std::fs::create_dir(folder.path().join(name)).expect("a folder");
    }
    let picture = |output| vec!["render", "none.toml", "-o", output];
    let with_stats = |stats| [picture("a.png"), vec!["--stats", stats]].concat();
    let mut cases = vec![
        (
            picture("no/a.png"),
            "no/a.png: cannot write the picture: the folder no does not exist",
        ),
        (
            picture("folder.png"),
            "folder.png: cannot write the picture: this is a folder",
        ),
        (
            with_stats("no/a.json"),
            "no/a.json: cannot write the stats: the folder no does not exist",
        ),
        (
            with_stats("folder.json"),
            "folder.json: cannot write the stats: this is a folder",
        ),
    ];
    let long = format!("{}.png", "a".repeat(300));
    cases.push((picture(&long), ".png: cannot write the picture: "));
    if cfg!(target_os = "linux") {
        let expected = "cannot write the picture: no file can be made in the folder /proc";
        cases.push((picture("/proc/a.png"), expected));
    }
    for (arguments, expected) in cases {
        let said = fail(folder.path(), &arguments);
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    let expected = ["folder.json", "folder.png", "scene.toml"];
    assert_eq!(names(folder.path()), expected);
}

#[test]
fn a_report_that_cannot_be_written_is_found_before_the_reference() {
    let folder = folder();
    std::fs::create_dir_all(folder.path().join("out/report.md")).expect("a folder");
    let endless = "report scene.toml -o out --spp 65536";
    let command = raymini(folder.path(), &endless.split(' ').collect::<Vec<_>>());
    let (code, said) = complaint(&output_in_time(command));
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("report.md: cannot write the report: this is a folder"),
        "{said}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_picture_whose_disk_is_full_is_not_lost() {
    let folder = folder();
    let refuge = folder.path().join("temporary");
    std::fs::create_dir(&refuge).expect("a folder");
    std::os::unix::fs::symlink("/dev/full", folder.path().join("full.exr")).expect("a link");
    let arguments = "render scene.toml -o full.exr --stats stats.json --size 8x6 --spp 4";
    let output = raymini(folder.path(), &arguments.split(' ').collect::<Vec<_>>())
        .env("TMPDIR", &refuge)
        .output()
        .expect("starts");
    let (code, said) = complaint(&output);
    assert_eq!(code, Some(1), "{said}");
    let kept = names(&refuge);
    assert!(kept.len() == 1 && kept[0].starts_with("full-") && has_extension(&kept[0], "exr"));
    let place = refuge.join(&kept[0]);
    let expected = format!("the picture is in {} instead", place.display());
    assert!(
        said.contains("full.exr: cannot write the picture: ") && said.contains(&expected),
        "{said}"
    );

    let info = raymini(&refuge, &["info", &kept[0], "--json"]).output();
    let facts: Value = serde_json::from_slice(&info.expect("starts").stdout).expect("is JSON");
    let stats = std::fs::read(folder.path().join("stats.json")).expect("is written");
    let stats: Value = serde_json::from_slice(&stats).expect("is JSON");
    assert_eq!(facts["image_hash"], stats["image_hash"]);
}

#[test]
#[cfg(target_os = "linux")]
fn the_stats_are_written_where_nobody_can_be_told_what_it_took() {
    let folder = folder();
    let arguments = "render scene.toml -o a.png --stats stats.json --size 8x6 --spp 4";
    let full = std::fs::File::create("/dev/full").expect("opens");
    let status = raymini(folder.path(), &arguments.split(' ').collect::<Vec<_>>())
        .stdout(full)
        .status();
    assert_eq!(status.expect("starts").code(), Some(1));
    assert_eq!(names(folder.path()), ["a.png", "scene.toml", "stats.json"]);
}

#[test]
#[cfg(target_os = "linux")]
fn figures_that_cannot_be_written_are_printed() {
    let folder = folder();
    let arguments = "render scene.toml -o a.png --stats /dev/full --size 8x6 --spp 4";
    let arguments: Vec<_> = arguments.split(' ').collect();
    let output = raymini(folder.path(), &arguments).output().expect("starts");
    let (code, said) = complaint(&output);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("/dev/full: cannot write the stats: ")
            && said.contains("the figures are printed instead"),
        "{said}"
    );
    let printed = String::from_utf8(output.stdout).expect("is text");
    let json = &printed[printed.find("{\n").expect("JSON")..];
    let stats: Value = serde_json::from_str(json).expect("is JSON");
    let info = raymini(folder.path(), &["info", "a.png", "--json"]).output();
    let facts: Value = serde_json::from_slice(&info.expect("starts").stdout).expect("is JSON");
    assert_eq!(stats["image_hash"], facts["image_hash"]);
    assert_eq!(names(folder.path()), ["a.png", "scene.toml"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_report_whose_disk_is_full_is_not_lost() {
    let folder = folder();
    let refuge = folder.path().join("temporary");
    std::fs::create_dir(&refuge).expect("a folder");
    std::fs::create_dir(folder.path().join("out")).expect("a folder");
    std::os::unix::fs::symlink("/dev/full", folder.path().join("out/report.json")).expect("a link");
    let arguments = "report scene.toml -o out --size 8x6 --spp 16 --seeds 2 --exact 1,1,1 --set render.mode=direct";
    let output = raymini(folder.path(), &arguments.split(' ').collect::<Vec<_>>())
        .env("TMPDIR", &refuge)
        .output()
        .expect("starts");
    let (code, said) = complaint(&output);
    assert_eq!(code, Some(1), "{said}");
    let kept = names(&refuge);
    assert!(kept.len() == 1 && kept[0].starts_with("out-"), "{kept:?}");
    let place = refuge.join(&kept[0]);
    let expected = format!("the report is in {} instead", place.display());
    assert!(
        said.contains("report.json: cannot write the report: ") && said.contains(&expected),
        "{said}"
    );
    let files = names(&place);
    for name in raymini::analysis::report::REPORT_FILES {
        assert!(files.iter().any(|file| file == name), "{name}: {files:?}");
    }
    let json = std::fs::read(place.join("report.json")).expect("is written");
    let facts: Value = serde_json::from_slice(&json).expect("is JSON");
    assert_eq!(facts["seeds"].as_array().map(Vec::len), Some(2));
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(
        printed.contains("reference: ") && printed.contains("as the scene says: "),
        "{printed}"
    );
    assert!(!printed.contains("out: report.md"), "{printed}");
}

/// What a program that must end by itself within 20 seconds leaves behind; a hang fails the test in place of stopping it.
fn output_in_time(mut command: Command) -> Output {
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let started = Instant::now();
    while child.try_wait().expect("can be asked").is_none() {
        if started.elapsed() > Duration::from_secs(20) {
            child.kill().expect("can be ended");
            panic!("{command:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().expect("can be read")
}

#[test]
#[cfg(unix)]
fn pipes_and_devices_are_refused_as_any_kind_of_input() {
    let folder = folder();
    for name in ["p.toml", "p.off", "p.png", "p.exr", "p.npy"] {
        let status = Command::new("mkfifo")
            .arg(folder.path().join(name))
            .status();
        assert!(status.expect("starts").success());
    }
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.toml")).expect("a link");
    let sky = "[background]\nimage = \"p.exr\"\n";
    std::fs::write(folder.path().join("sky.toml"), sky).expect("is written");
    let cases = [
        "render p.toml -o a.png",
        "render zero.toml -o a.png",
        "render p.off -o a.png",
        "render sky.toml -o a.png",
        "info p.toml",
        "info zero.toml",
        "info p.off",
        "info p.png",
        "info p.exr",
        "compare p.png p.exr",
        "report scene.toml -o report --reference p.exr",
        "bench scene.toml --rays p.npy",
    ];
    for arguments in cases {
        let command = raymini(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        let (code, said) = complaint(&output_in_time(command));
        assert_eq!(code, Some(1), "{arguments}: {said}");
        assert!(
            said.contains("this is not a regular file"),
            "{arguments}: {said}"
        );
    }
}

/// The mesh is written over, cut off and removed while its picture is made, which takes a second or more.
#[test]
fn a_mesh_that_changes_while_it_is_rendered_stays_as_it_was() {
    let folder = folder();
    let mesh = folder.path().join("m.off");
    std::fs::write(&mesh, "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").expect("is written");
    let arguments = |name: &str| {
        format!(
            "render m.off -o {name}.png --stats {name}.json --spp 64 --size 320x240 --threads 1 \
             --checkpoint {name} --checkpoint-every 0.1"
        )
    };
    let start = |name: &str| {
        let mut command = raymini(
            folder.path(),
            &arguments(name).split(' ').collect::<Vec<_>>(),
        );
        command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts")
    };
    let finish = |child: Child| {
        let (code, said) = complaint(&child.wait_with_output().expect("can be read"));
        assert_eq!(code, Some(0), "{said}");
    };
    finish(start("before"));
    let mut changed = start("changed");
    // A checkpoint is there: the mesh has been read.
    let has_ended = |child: &mut Child| child.try_wait().expect("can be asked").is_some();
    while !folder.path().join("changed").exists() && !has_ended(&mut changed) {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!has_ended(&mut changed), "it was too fast to be disturbed");
    std::fs::write(&mesh, "OFF 3").expect("is written");
    std::fs::remove_file(&mesh).expect("is removed");
    finish(changed);
    let facts = ["before", "changed"].map(|name| {
        let stats = std::fs::read(folder.path().join(format!("{name}.json"))).expect("is written");
        let stats: Value = serde_json::from_slice(&stats).expect("is JSON");
        stats["image_hash"].clone()
    });
    assert!(facts[0].is_string());
    assert_eq!(facts[0], facts[1]);
}

/// What is open stays readable when its name goes, on Unix; what is cut off in the middle is an error that says where it ends, unless it
/// has been read by then.
#[cfg(unix)]
#[test]
fn a_mesh_that_goes_while_it_is_read_is_read_or_refused() {
    const VERTICES: usize = 4_000_000;
    let folder = TempDir::new().expect("a folder");
    let mesh = folder.path().join("m.off");
    let text = format!(
        "OFF {VERTICES} 1 0\n{}3 0 1 2\n",
        "1 2 3\n".repeat(VERTICES)
    );
    let read_while = |disturb: &dyn Fn()| {
        std::fs::write(&mesh, &text).expect("is written");
        let progress = Progress::new();
        std::thread::scope(|scope| {
            let reader = scope.spawn(|| io::load_mesh(&mesh, &CancelToken::new(), &progress));
            while progress.done() == 0 && !reader.is_finished() {
                std::hint::spin_loop();
            }
            disturb();
            reader.join().expect("nothing panics")
        })
    };
    let vertices = |file: Option<io::MeshFile>| file.expect("not cancelled").mesh.positions.len();
    let removed = read_while(&|| std::fs::remove_file(&mesh).expect("is removed"));
    assert_eq!(removed.map(vertices).ok(), Some(VERTICES));

    let cut_off = read_while(&|| {
        let file = std::fs::File::options().write(true).open(&mesh);
        file.and_then(|file| file.set_len(text.len() as u64 / 2))
            .expect("is cut off");
    });
    match cut_off {
        Ok(file) => assert_eq!(vertices(file), VERTICES),
        Err(error) => {
            let error = error.to_string();
            // In the middle of a line, or of the file.
            assert!(error.contains("m.off:"), "{error}");
            assert!(error.contains("expected "), "{error}");
        }
    }
}

#[test]
fn a_scene_file_beyond_the_bound_is_refused() {
    let folder = folder();
    let file = std::fs::File::create(folder.path().join("large.toml")).expect("is made");
    file.set_len((16 << 20) + 1).expect("a hole");
    let said = fail(folder.path(), &["info", "large.toml"]);
    assert!(
        said.contains("large.toml: the file is too large: a scene file has at most 16 MiB"),
        "{said}"
    );
}

/// Under a limit of 4 GB, which any machine can set.
#[test]
#[cfg(target_os = "linux")]
fn a_picture_that_memory_does_not_hold_is_refused_in_words() {
    let folder = folder();
    let large = "render scene.toml --size 16384x16384 --spp 4 --threads 2";
    for output in ["a.png", "a.exr"] {
        let limited = format!(
            "ulimit -v 4000000; exec {} {large} -o {output}",
            env!("CARGO_BIN_EXE_raymini")
        );
        let mut command = Command::new("sh");
        command.current_dir(folder.path()).args(["-c", &limited]);
        let (code, said) = complaint(&output_in_time(command));
        assert_eq!(code, Some(1), "{said}");
        assert!(
            said.contains("error: the picture needs ") && said.contains("GB of memory"),
            "{said}"
        );
    }
    assert_eq!(names(folder.path()), ["scene.toml"]);
}

#[cfg(unix)]
mod signals {
    use super::*;

    /// A render that takes hours. With 65,536 rays to a sample its first pass alone takes far longer than a test waits.
    const ENDLESS: &str =
        "render scene.toml -o a.exr --stats stats.json --size 160x120 --spp 65536";

    fn start(folder: &Path, arguments: &str) -> Child {
        raymini(folder, &arguments.split(' ').collect::<Vec<_>>())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts")
    }

    fn send(signal: &str, child: &Child) {
        let kill = format!("kill -{signal} {}", child.id());
        let status = Command::new("sh").args(["-c", &kill]).status();
        assert!(status.expect("starts").success());
    }

    fn wait() {
        std::thread::sleep(Duration::from_secs(1));
    }

    #[test]
    fn the_first_ends_a_render_with_the_samples_it_has() {
        let mut signals = vec![("INT", 130), ("TERM", 143)];
        // Elsewhere nothing tells whether the program was started to outlive its terminal.
        if cfg!(target_os = "linux") {
            signals.push(("HUP", 129));
        }
        for (signal, code) in signals {
            let folder = folder();
            let child = start(folder.path(), ENDLESS);
            wait();
            send(signal, &child);
            let (found, said) = complaint(&child.wait_with_output().expect("ends"));
            assert_eq!(found, Some(code), "{said}");
            assert!(
                said.contains("interrupted: the picture has the samples taken so far"),
                "{said}"
            );
            assert_eq!(names(folder.path()), ["a.exr", "scene.toml", "stats.json"]);
            let stats = std::fs::read(folder.path().join("stats.json")).expect("is written");
            let stats: Value = serde_json::from_slice(&stats).expect("is JSON");
            assert_eq!(stats["ending"], "interrupted");
            let most = stats["sample_range"][1].as_u64().expect("a number");
            assert!((1..65536).contains(&most), "{most}");
            let info = raymini(folder.path(), &["info", "a.exr", "--json"]).output();
            let facts: Value =
                serde_json::from_slice(&info.expect("starts").stdout).expect("is JSON");
            assert_eq!(facts["image_hash"], stats["image_hash"]);
        }
    }

    #[test]
    fn the_second_ends_at_once_and_leaves_the_old_picture() {
        let folder = folder();
        std::fs::write(folder.path().join("a.exr"), "old").expect("is written");
        let slow = "--set render.mode=ao --set render.ambient_occlusion.samples=65536";
        let child = start(folder.path(), &format!("{ENDLESS} {slow}"));
        wait();
        send("INT", &child);
        std::thread::sleep(Duration::from_millis(300));
        send("INT", &child);
        let output = child.wait_with_output().expect("ends");
        assert_eq!(output.status.code(), Some(130));
        assert_eq!(names(folder.path()), ["a.exr", "scene.toml"]);
        let old = std::fs::read(folder.path().join("a.exr")).expect("is there");
        assert_eq!(old, b"old");
    }

    /// The system tells who runs in a terminal that is closed, and the shell does so again.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_closed_terminal_that_is_told_twice_loses_no_picture() {
        let folder = folder();
        // The tiles that are begun take longer than it takes to tell.
        let slow = "--set render.mode=ao --set render.ambient_occlusion.samples=1024";
        let child = start(
            folder.path(),
            &format!("{ENDLESS} {slow} --checkpoint kept"),
        );
        wait();
        for _ in 0..2 {
            send("HUP", &child);
            std::thread::sleep(Duration::from_millis(5));
        }
        let (code, said) = complaint(&child.wait_with_output().expect("ends"));
        assert_eq!(code, Some(129), "{said}");
        assert!(said.contains("kept: --resume goes on from here"), "{said}");
        let left = names(folder.path());
        assert!(left.contains(&"kept".to_owned()), "{left:?}");
        assert!(!left.iter().any(|name| name.starts_with('.')), "{left:?}");
    }

    /// As `nohup` starts it.
    #[test]
    #[cfg(target_os = "linux")]
    fn who_is_to_outlive_the_terminal_does() {
        let folder = folder();
        let program = env!("CARGO_BIN_EXE_raymini");
        let ignoring = format!("trap '' HUP; exec '{program}' {ENDLESS} --seconds 2");
        let child = Command::new("sh")
            .args(["-c", &ignoring])
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        wait();
        send("HUP", &child);
        let (code, said) = complaint(&child.wait_with_output().expect("ends"));
        assert_eq!(code, Some(0), "{said}");
        let stats = std::fs::read(folder.path().join("stats.json")).expect("is written");
        let stats: Value = serde_json::from_slice(&stats).expect("is JSON");
        assert_eq!(stats["ending"], "time");
    }

    /// The tiles that are begun are done before the program ends, so there is something as soon as a tile has begun.
    #[test]
    fn what_there_is_before_every_pixel_has_a_sample_goes_to_a_name_of_its_own() {
        let folder = folder();
        std::fs::write(folder.path().join("a.exr"), "old").expect("is written");
        let slow = "--set render.mode=ao --set render.ambient_occlusion.samples=65536";
        let said = [1.0, 2.0].map(|seconds| {
            let child = start(folder.path(), &format!("{ENDLESS} {slow}"));
            std::thread::sleep(Duration::from_secs_f64(seconds));
            send("TERM", &child);
            let (code, said) = complaint(&child.wait_with_output().expect("ends"));
            assert_eq!(code, Some(143), "{said}");
            said
        });
        let is_kept = |said: &String| said.contains("black where there are none");
        let has_nothing = |said: &String| said.contains("no picture is written");
        assert!(said.iter().any(is_kept), "{said:?}");
        assert!(
            said.iter().all(|said| is_kept(said) || has_nothing(said)),
            "{said:?}"
        );
        assert_eq!(
            names(folder.path()),
            ["a.exr", "a.unfinished.exr", "scene.toml", "stats.json"]
        );
        let old = std::fs::read(folder.path().join("a.exr")).expect("is there");
        assert_eq!(old, b"old");
        let info = raymini(folder.path(), &["info", "a.unfinished.exr"]).output();
        assert!(info.expect("starts").status.success());
    }

    /// Waits until there is a file, or a folder, of that name.
    fn wait_for(path: &Path) {
        let started = Instant::now();
        while !path.exists() {
            assert!(
                started.elapsed() < Duration::from_mins(1),
                "{}",
                path.display()
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    #[test]
    fn a_report_that_a_signal_ends_says_what_there_is() {
        let folder = folder();
        let report = "report scene.toml -o out --size 64x48";
        let many = format!("{report} --spp 64 --seeds 1000 --exact 1,1,1");
        let child = start(folder.path(), &many);
        wait_for(&folder.path().join("out/report.csv"));
        send("INT", &child);
        let output = child.wait_with_output().expect("ends");
        let (code, said) = complaint(&output);
        assert_eq!(code, Some(130), "{said}");
        assert!(
            said.contains("interrupted: the report in out holds "),
            "{said}"
        );
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(printed.contains("as the scene says: "), "{printed}");

        let endless = format!("{report} --reference-samples 16777216");
        let child = start(folder.path(), &endless.replace("out", "none"));
        wait_for(&folder.path().join("none"));
        send("TERM", &child);
        let (code, said) = complaint(&child.wait_with_output().expect("ends"));
        assert_eq!(code, Some(143), "{said}");
        assert!(said.contains("no report is written"), "{said}");
        assert!(names(&folder.path().join("none")).is_empty());
    }

    fn is_part(name: &str) -> bool {
        has_extension(name, "part")
    }

    /// A render that has written something of its picture, and goes on doing so.
    fn writing(folder: &Path) -> Child {
        let large = "render scene.toml -o a.png --size 4096x2048 --spp 1 --mode normals";
        let mut child = start(folder, large);
        let is_begun = || {
            let mut parts = names(folder).into_iter().filter(|name| is_part(name));
            let size = |name| std::fs::metadata(folder.join(name)).map_or(0, |part| part.len());
            parts.any(|name| size(name) > 0)
        };
        while !is_begun() {
            let ended = child.try_wait().expect("can be asked");
            assert!(ended.is_none(), "the write was not seen");
            std::thread::sleep(Duration::from_millis(2));
        }
        child
    }

    /// A killed process removes nothing; the next one that writes there does, and leaves alone what another still writes.
    #[test]
    fn the_next_render_removes_what_a_killed_one_left_and_nothing_else() {
        let folder = folder();
        let path = folder.path();
        let small = ["render", "scene.toml", "-o", "b.png", "--size", "8x8"];
        let mut killed = writing(path);
        killed.kill().expect("runs");
        killed.wait().expect("ends");
        assert_eq!(names(path).iter().filter(|name| is_part(name)).count(), 1);

        let render_beside = || {
            let output = raymini(path, &small).output().expect("starts");
            assert!(output.status.success(), "{}", complaint(&output).1);
            names(path)
        };
        assert_eq!(render_beside(), ["b.png", "scene.toml"]);

        let mut living = writing(path);
        send("STOP", &living);
        let left = render_beside();
        let parts = left.iter().filter(|name| is_part(name)).count();
        assert_eq!(parts, 1, "{left:?}");
        send("CONT", &living);
        assert!(living.wait().expect("ends").success());
        assert_eq!(names(path), ["a.png", "b.png", "scene.toml"]);
    }

    /// Two signals in the middle of a write: the temporary file goes with the program.
    #[test]
    fn no_temporary_file_outlives_a_write_that_a_signal_ends() {
        let folder = folder();
        let mut child = writing(folder.path());
        send("TERM", &child);
        std::thread::sleep(Duration::from_millis(60));
        send("TERM", &child);
        assert_eq!(child.wait().expect("ends").code(), Some(143));
        let left = names(folder.path());
        assert!(!left.iter().any(|name| is_part(name)), "{left:?}");
    }
}
