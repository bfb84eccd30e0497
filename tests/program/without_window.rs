//! The program where no window opens: what it does instead, and where it says so.

use std::path::Path;
use std::process::Command;

use crate::command_line::folder;

/// The program in `folder`, where there is no screen.
fn raymini(folder: &Path) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_raymini"));
    program.current_dir(folder);
    for screen in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        program.env_remove(screen);
    }
    program
}

#[test]
fn without_a_screen_the_scene_is_rendered_to_a_file() {
    let folder = folder();
    let output = raymini(folder.path()).arg("scene.toml").output();
    let output = output.expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("No window can be opened") && said.contains("Rendering to scene.png instead"),
        "{said}"
    );
    assert!(folder.path().join("scene.png").exists());
}

/// Nobody has asked for a picture there: not even the one that is rendered anew gives its place to it.
#[test]
fn without_a_screen_no_file_is_written_over() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    let open = |name: &str, expected: &str| {
        let output = raymini(folder.path()).arg(name).output();
        let output = output.expect("starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let expected = format!("Rendering to {expected} instead");
        assert!(said.contains(&expected), "{said}");
    };
    std::fs::write(file("scene.png"), "precious").expect("is written");
    open("scene.toml", "scene-1.png");
    let picture = std::fs::read(file("scene-1.png")).expect("is rendered");
    open("scene.toml", "scene-2.png");
    open("scene-1.png", "scene-1-1.png");
    assert_eq!(
        std::fs::read(file("scene.png")).expect("is there"),
        b"precious"
    );
    assert_eq!(
        std::fs::read(file("scene-1.png")).expect("is there"),
        picture
    );
}

/// Where there is no screen, or no window in the program, it says so.
#[test]
fn the_window_is_measured_only_where_there_is_one() {
    let folder = folder();
    let complaint = |arguments: &[&str], code: i32| {
        let output = raymini(folder.path())
            .args(["bench", "--window"])
            .args(arguments)
            .output()
            .expect("starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(output.stdout.is_empty());
        said
    };
    let said = complaint(&["scene.toml", "--json"], 1);
    let expected = if cfg!(feature = "gui") {
        "no display answers"
    } else {
        "built without its window"
    };
    assert!(said.contains(expected), "{said}");
    assert!(complaint(&["no.toml"], 1).contains("no.toml: there is no such file"));
    assert!(complaint(&["--threads", "2"], 2).contains("--threads"));
}

/// What is shown on the desktop, by programs that only take note of it.
#[cfg(all(feature = "gui", target_os = "linux"))]
mod boxes {
    use std::os::unix::fs::PermissionsExt as _;
    use std::path::Path;
    use std::process::Output;

    use super::raymini;
    use crate::command_line::folder;

    /// Starts the program in `folder` as an icon of the desktop does, with nothing but the programs of `folder`/bin: no terminal shows what it says.
    fn start_from_an_icon(folder: &Path, arguments: &[&str]) -> Output {
        let bin = folder.join("bin");
        let output = raymini(folder).env("PATH", bin).args(arguments).output();
        output.expect("starts")
    }

    /// Puts a program of that name into `folder`/bin that does `script`.
    fn write_program(folder: &Path, name: &str, script: &str) {
        let bin = folder.join("bin");
        std::fs::create_dir_all(&bin).expect("a folder");
        let program = bin.join(name);
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("is written");
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&program, mode).expect("may be run");
    }

    #[test]
    fn who_started_it_from_an_icon_is_told_in_a_box_of_the_desktop() {
        for (program, other) in [("zenity", Some("kdialog")), ("kdialog", None)] {
            let folder = folder();
            // The render does not wait until somebody has read it.
            let script = "turn=0\n\
                while [ ! -e scene.png ] && [ $turn -lt 600 ]; do turn=$((turn + 1)); /bin/sleep 0.1; done\n\
                [ -e scene.png ] && printf '%s\\n' \"$@\" > box";
            write_program(folder.path(), program, script);
            if let Some(other) = other {
                write_program(folder.path(), other, "echo twice > twice");
            }
            let output = start_from_an_icon(folder.path(), &["scene.toml"]);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{said}");
            let shown =
                std::fs::read_to_string(folder.path().join("box")).expect("a box was shown");
            let reason = said
                .lines()
                .find(|line| line.starts_with("No window can be opened"));
            assert!(shown.contains(reason.expect("it says why")), "{shown}");
            let picture = folder.path().join("scene.png");
            let picture = picture.canonicalize().expect("the picture is there");
            assert!(
                shown.contains(&format!("Rendering to {} instead", picture.display())),
                "{shown}"
            );
            assert!(!folder.path().join("twice").exists(), "one box is enough");
        }
    }

    #[test]
    fn an_error_without_a_window_is_told_in_a_box_too_and_no_box_is_no_error() {
        let folder = folder();
        std::fs::write(folder.path().join("broken.toml"), "[render]\nwidht = 3\n")
            .expect("is written");
        write_program(folder.path(), "zenity", "printf '%s\\n' \"$@\" >> box");
        let output = start_from_an_icon(folder.path(), &["broken.toml"]);
        assert_eq!(output.status.code(), Some(1));
        let shown = std::fs::read_to_string(folder.path().join("box")).expect("a box was shown");
        assert!(
            shown.contains("broken.toml:2") && shown.contains("width"),
            "{shown}"
        );

        std::fs::remove_file(folder.path().join("bin/zenity")).expect("is there");
        let output = start_from_an_icon(folder.path(), &["scene.toml"]);
        assert!(output.status.success());
        assert!(folder.path().join("scene.png").exists());
    }
}
