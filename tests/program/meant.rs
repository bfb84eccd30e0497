//! What the program does with files that a user did not mean, or cannot mean: it says so, and leaves them alone.

use serde_json::Value;

use crate::command_line::{facts, fail, folder, raymini, succeed};

/// What a command writes under names of its own is no reason to lose what it reads.
#[test]
fn what_a_folder_of_files_is_made_from_is_not_written_over() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    succeed(folder.path(), &["convert", "tetra.off", "mesh.ply"]);
    succeed(
        folder.path(),
        &[
            "render",
            "mesh.ply",
            "-o",
            "whole.png",
            "--spp",
            "1",
            "--size",
            "8x6",
        ],
    );
    for (name, command) in [
        ("mesh.ply", &["bench", "mesh.ply", "--write", "."][..]),
        ("whole.png", &["plan", "whole.png", "--contributions", "."]),
    ] {
        let before = std::fs::read(file(name)).expect("exists");
        let complaint = fail(folder.path(), 1, command);
        assert!(
            complaint.contains("the scene is read from it"),
            "{complaint}"
        );
        assert_eq!(std::fs::read(file(name)).expect("exists"), before);
    }
}

/// Nobody is told of an option that he has not given.
#[test]
fn complaints_name_the_options_that_were_given() {
    fn with(more: &str) -> Vec<&str> {
        let more: Vec<_> = more.split(' ').collect();
        [&["render", "scene.toml", "-o", "out.png"], &more[..]].concat()
    }

    let folder = folder();
    let said = fail(folder.path(), 2, &with("--size 65536x65536"));
    assert!(
        said.contains("--size") && said.contains("268435456 pixels together"),
        "{said}"
    );
    let said = fail(folder.path(), 1, &with("--set render=3 --size 96x54"));
    assert!(said.contains("--set render=3: "), "{said}");
    let said = fail(
        folder.path(),
        1,
        &with("--set render.phong=classic --mode path"),
    );
    assert!(said.contains("--set render.phong=classic: "), "{said}");
    std::fs::write(
        folder.path().join("classic.toml"),
        "[[objects]]\nmesh = \"tetra.off\"\n[render]\nphong = \"classic\"\n",
    )
    .expect("is written");
    let render = ["render", "classic.toml", "-o", "out.png", "--mode", "path"];
    let said = fail(
        folder.path(),
        1,
        &[&render[..], &["--size", "96x54"]].concat(),
    );
    assert!(said.contains("error: --size 96x54 --mode path: "), "{said}");

    let noise = raymini(folder.path(), &with("--spp 2 --noise 1e-300"));
    let said = String::from_utf8_lossy(&noise.stderr);
    assert!(
        said.contains(
            "noise is not down to 1.00e-298 %: pixels have all the samples that --spp allows"
        ),
        "{said}"
    );
    let few = "--set render.samples_per_pixel=2 --noise 1e-9";
    let noise = raymini(folder.path(), &with(few));
    let said = String::from_utf8_lossy(&noise.stderr);
    assert!(
        said.contains("the samples that render.samples_per_pixel allows"),
        "{said}"
    );
}

/// What is said before the picture's data does not vouch for it.
#[test]
fn info_tells_of_a_picture_that_is_cut_off() {
    let folder = folder();
    let (whole, cut) = (folder.path().join("out.png"), folder.path().join("cut.png"));
    succeed(
        folder.path(),
        &["render", "scene.toml", "-o", "out.png", "--spp", "1"],
    );
    assert_eq!(
        facts(folder.path(), "out.png")["warnings"],
        Value::Array(Vec::new())
    );
    let bytes = std::fs::read(whole).expect("is written");
    // The end of the file and a part of its last rows.
    std::fs::write(cut, &bytes[..bytes.len() - 60]).expect("is written");
    let facts = facts(folder.path(), "cut.png");
    assert_eq!(facts["width"], 64);
    let warning = facts["warnings"][0].as_str().expect("a warning");
    assert!(warning.contains("not a whole PNG file"), "{warning}");
}

/// A scene is text, and cannot hold every name of a file.
#[test]
#[cfg(target_os = "linux")]
fn a_mesh_that_no_scene_can_name_is_warned_of() {
    use std::os::unix::ffi::OsStrExt as _;

    let folder = folder();
    let name = std::ffi::OsStr::from_bytes(b"t\xff.off");
    std::fs::copy(folder.path().join("tetra.off"), folder.path().join(name)).expect("is copied");
    let render = |mesh: &std::ffi::OsStr| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .arg("render")
            .arg(mesh)
            .args(["-o", "out.png", "--spp", "1", "--size", "8x6"])
            .output()
            .expect("starts");
        assert!(output.status.success());
        String::from_utf8(output.stderr).expect("is text")
    };
    assert!(render(name).contains("is not Unicode"));
    assert!(!render("tetra.off".as_ref()).contains("is not Unicode"));
}
