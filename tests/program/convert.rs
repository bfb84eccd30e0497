//! `raymini convert` as a user calls it: files, messages, exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use raymini::control::{CancelToken, Progress};
use raymini::geometry::TriangleMesh;
use raymini::io::{load_mesh, load_scene};
use raymini::math::DVec3;
use raymini::scene::{Material, Scene};
use tempfile::TempDir;

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("is written");
    }
    folder
}

fn convert(folder: &TempDir, input: &str, output: &str) -> Output {
    convert_with(folder, &[input, output])
}

fn convert_with(folder: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .arg("convert")
        .args(arguments)
        .output()
        .expect("starts")
}

/// What is printed, and what is warned of.
fn succeed(folder: &TempDir, input: &str, output: &str) -> (String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = convert(folder, input, output);
    let [stdout, stderr] = [stdout, stderr].map(|text| String::from_utf8(text).expect("is text"));
    assert!(status.success(), "{input} {output}: {stderr}");
    (stdout, stderr)
}

fn fail(folder: &TempDir, input: &str, output: &str) -> String {
    let run = convert(folder, input, output);
    assert_eq!(run.status.code(), Some(1));
    String::from_utf8(run.stderr).expect("is text")
}

fn mesh(path: &Path) -> TriangleMesh {
    let loaded = load_mesh(path, &CancelToken::new(), &Progress::new());
    loaded.expect("is right").expect("nobody cancels").mesh
}

/// A tetrahedron of which the last face looks inwards.
const TURNED: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 3 2\n";

#[test]
fn units_axes_and_windings_change_on_the_way() {
    let large = "OFF\n3 1 0\n0 0 0\n10 0 0\n0 10 0\n3 0 1 2\n";
    let folder = folder(&[("a.off", TURNED), ("large.off", large)]);
    for output in ["b.off", "b.obj", "b.glb"] {
        let options = ["--scale", "1000", "--up", "y:z", "--repair-winding"];
        let run = convert_with(&folder, &[&["a.off", output][..], &options].concat());
        let said = String::from_utf8(run.stdout).expect("is text");
        assert!(said.contains("4 triangles, 1 of them turned"), "{said}");
        let changed = mesh(&folder.path().join(output));
        // X stays, Y is up, Z points to where −Y was.
        let [x, y, z] = [DVec3::X, DVec3::Z, DVec3::NEG_Y].map(|axis| axis * 1000.0);
        for (index, expected) in [(0, [DVec3::ZERO, y, x]), (3, [x, y, z])] {
            for (corner, expected) in changed.corners(index).into_iter().zip(expected) {
                assert!((corner - expected).length() < 1e-9, "{corner} {expected}");
            }
        }
    }
    for output in ["c.off", "c.glb"] {
        let run = convert_with(&folder, &["large.off", output, "--scale", "1e308"]);
        assert_eq!(run.status.code(), Some(1));
        let said = String::from_utf8(run.stderr).expect("is text");
        assert!(
            said.contains("coordinates larger than numbers can be"),
            "{said}"
        );
        assert!(!folder.path().join(output).exists());
    }
    for (option, value, expected) in [
        ("--scale", "0", "expected a number above 0"),
        ("--scale", "x", "expected a number above 0"),
        (
            "--up",
            "y",
            "expected two of the axes x, y and z, such as y:z",
        ),
        (
            "--up",
            "y:w",
            "expected two of the axes x, y and z, such as y:z",
        ),
    ] {
        let run = convert_with(&folder, &["a.off", "c.off", option, value]);
        assert_eq!(run.status.code(), Some(2));
        let said = String::from_utf8(run.stderr).expect("is text");
        assert!(said.contains(expected), "{said}");
    }
}

/// What is said of windings, and that the scene's key puts them right: the flipped face no longer looks the other way.
#[test]
fn windings_that_are_not_right_are_told_of() {
    let folder = folder(&[("a.off", TURNED)]);
    let info = |file: &str| {
        let run = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(["info", "--json", file])
            .output()
            .expect("starts");
        serde_json::from_slice::<serde_json::Value>(&run.stdout).expect("is JSON")
    };
    let facts = info("a.off");
    assert_eq!(facts["winding"]["turned"], 1);
    assert_eq!(
        facts["warnings"][0],
        "1 triangle turns the other way round than its neighbours: an object's repair_winding = true puts that right, or raymini convert --repair-winding"
    );
    convert_with(&folder, &["a.off", "b.off", "--repair-winding"]);
    let facts = info("b.off");
    assert_eq!(facts["winding"]["turned"], 0);
    assert_eq!(facts["warnings"], serde_json::json!([]));

    let text = "[[objects]]\nmesh = \"a.off\"\nrepair_winding = true\n";
    fs::write(folder.path().join("a.toml"), text).expect("is written");
    let loaded = load_scene(
        &folder.path().join("a.toml"),
        &CancelToken::new(),
        &Progress::new(),
    );
    let scene = loaded.expect("is right").expect("nobody cancels").scene;
    let object = &scene.objects[0];
    let shown = scene.shown_mesh_of(object).expect("is loaded");
    assert_eq!(
        shown.triangles,
        mesh(&folder.path().join("b.off")).triangles
    );
    let loaded = scene.mesh_of(object).expect("is loaded");
    assert_eq!(
        loaded.triangles,
        mesh(&folder.path().join("a.off")).triangles
    );
}

/// Numbers that no 32 bits hold, normals, and a polygon.
const BENT: &str =
    "NOFF\n4 2 0\n0.1 0 0 0 0 1\n1 0 1e-40 0 0 .3\n1 1 0 0 1 1\n0 1 0 1 0 1\n3 0 1 2\n3 0 2 3\n";

#[test]
fn a_mesh_goes_through_all_formats() {
    let folder = folder(&[("a.off", BENT)]);
    let path = |name: &str| folder.path().join(name);
    let steps = [
        ("a.off", "b.obj", "OBJ"),
        ("b.obj", "c.ply", "PLY"),
        ("c.ply", "d.OFF", "OFF"),
    ];
    for (from, to, format) in steps {
        let (said, warned) = succeed(&folder, from, to);
        let expected = format!("{to}: {format}, 4 vertices, 2 triangles\n");
        assert_eq!((said, warned), (expected, String::new()));
        assert_eq!(mesh(&path(to)), mesh(&path("a.off")));
    }
    let (_, warned) = succeed(&folder, "d.OFF", "e.stl");
    let expected = "warning: e.stl: normals are left out: STL holds triangles alone\n";
    assert_eq!(warned, expected);
    let (read, original) = (mesh(&path("e.stl")), mesh(&path("a.off")));
    assert_eq!(read.positions, original.positions);
    assert_eq!(read.triangles, original.triangles);
}

/// What a GLB holds of a mesh: 32 bits of positions, said where they are not enough.
#[test]
fn a_mesh_goes_to_glb_and_back() {
    let short = BENT
        .replace("0.1 0 0", "0.5 0 0")
        .replace("0 0 .3", "0 0 1");
    let folder = folder(&[
        ("a.off", BENT),
        (
            "short.off",
            &short
                .replace("1e-40", "0.25")
                .replace("0 1 1", "0 0 1")
                .replace("1 0 1\n", "0 0 1\n"),
        ),
    ]);
    let path = |name: &str| folder.path().join(name);
    let (said, warned) = succeed(&folder, "a.off", "a.glb");
    assert_eq!(said, "a.glb: glTF, 4 vertices, 2 triangles\n");
    assert_eq!(
        warned,
        "warning: a.glb: positions are rounded to 32 bits, as glTF holds them\n"
    );
    let (_, warned) = succeed(&folder, "short.off", "b.glb");
    assert_eq!(warned, "");
    let (said, _) = succeed(&folder, "b.glb", "c.off");
    assert_eq!(said, "c.off: OFF, 4 vertices, 2 triangles\n");
    assert_eq!(mesh(&path("b.glb")), mesh(&path("short.off")));
    assert_eq!(mesh(&path("c.off")), mesh(&path("short.off")));
}

/// Materials go from OBJ to glTF and back, each to its kind.
#[test]
fn materials_go_through_both_formats_that_hold_them() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl wood\nf 1 2 3\nusemtl chrome\nf 1 3 4\n";
    let mtl = "newmtl wood\nKd 0.5 0.25 0\nKs 0.25 0.25 0.25\nNs 60\nnewmtl chrome\nKd 0 0 0\nKs 0.5 0.5 0.5\nillum 3\n";
    let folder = folder(&[("a.obj", obj), ("a.mtl", mtl)]);
    let (said, warned) = succeed(&folder, "a.obj", "b.glb");
    assert_eq!(
        (said.as_str(), warned.as_str()),
        ("b.glb: glTF, 6 vertices, 2 triangles, 2 materials\n", "")
    );
    let (said, warned) = succeed(&folder, "b.glb", "c.obj");
    assert_eq!(
        (said.as_str(), warned.as_str()),
        ("c.obj: OBJ, 6 vertices, 2 triangles, 2 materials\n", "")
    );
    let scene = |name: &str| {
        let loaded = load_scene(
            &folder.path().join(name),
            &CancelToken::new(),
            &Progress::new(),
        );
        loaded.expect("is right").expect("nobody cancels").scene
    };
    let (first, last) = (scene("a.obj"), scene("c.obj"));
    assert_eq!(first.bounds(), last.bounds());
    assert_eq!(last.materials["chrome"], first.materials["chrome"]);
    let wood = |scene: &Scene| match &scene.materials["wood"] {
        Material::Phong {
            diffuse,
            specular,
            shininess,
            ..
        } => (*diffuse, *specular, *shininess),
        other => panic!("{other:?}"),
    };
    let ((a, b, c), (x, y, z)) = (wood(&first), wood(&last));
    assert!((a - x).length() < 1e-12 && (b - y).length() < 1e-12 && (c - z).abs() < 1e-9);
    let (_, warned) = succeed(&folder, "a.obj", "d.ply");
    assert_eq!(
        warned,
        "warning: d.ply: materials are left out: PLY holds none\n"
    );
}

/// What is read stays, by whatever name it is to be written over.
#[test]
fn a_mesh_does_not_take_the_place_of_what_it_is_read_from() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n";
    let folder = folder(&[("a.off", BENT), ("b.obj", obj)]);
    let path = |name: &str| folder.path().join(name);
    let mut cases = vec![
        ("a.off", "a.off"),
        ("a.off", "./a.off"),
        ("b.obj#a", "b.obj"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.off", path("link.off")).expect("a link");
        fs::hard_link(path("a.off"), path("hard.off")).expect("a link");
        cases.extend([("a.off", "link.off"), ("link.off", "a.off")]);
        cases.extend([("a.off", "hard.off"), ("hard.off", "a.off")]);
    }
    for (input, output) in cases {
        let said = fail(&folder, input, output);
        let expected = format!(
            "error: {output}: the mesh is read from it; what is written needs a name of its own\n"
        );
        assert_eq!(said, expected);
        assert_eq!(fs::read_to_string(path("a.off")).expect("is there"), BENT);
        assert_eq!(fs::read_to_string(path("b.obj")).expect("is there"), obj);
    }
}

/// Materials go to a file that nobody has named: only the same content may be there.
#[test]
fn materials_take_the_place_of_no_other_file() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    let folder = folder(&[("a.obj", obj), ("a.mtl", "newmtl red\nKd 1 0 0\n")]);
    let path = |name: &str| folder.path().join(name);
    let precious = "newmtl precious\n";
    fs::write(path("b.mtl"), precious).expect("is written");
    let expected = "error: b.mtl: the materials would go here, and there is a file with other content already; remove or rename it, or write the \
                    OBJ file under another name\n";
    // With an OBJ file of that name, and without.
    for _ in 0..2 {
        assert_eq!(fail(&folder, "a.obj", "b.obj"), expected);
        let kept = fs::read_to_string(path("b.mtl")).expect("is there");
        assert_eq!(kept, precious);
        fs::write(path("b.obj"), "old").expect("is written");
    }
    assert_eq!(fs::read_to_string(path("b.obj")).expect("is there"), "old");

    // Again, with the materials that it has written.
    for _ in 0..2 {
        succeed(&folder, "a.obj", "c.obj");
    }
    let written = fs::read_to_string(path("c.mtl")).expect("is there");
    fs::write(path("a.mtl"), "newmtl red\nKd 0.5 0 0\n").expect("is written");
    assert!(fail(&folder, "a.obj", "c.obj").starts_with("error: c.mtl: "));
    assert_eq!(
        fs::read_to_string(path("c.mtl")).expect("is there"),
        written
    );
}

#[test]
fn warnings_of_what_is_read_are_shown() {
    let folder = folder(&[("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")]);
    let (_, warned) = succeed(&folder, "a.obj", "b.off");
    assert_eq!(
        warned,
        "warning: a.obj: 1 line or point is ignored (line 5)\n"
    );
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_no_file() {
    let folder = folder(&[("a.off", BENT), ("bad.ply", "ply\nformat\n")]);
    let expected = "error: a.gltf: a mesh is written to a file with the extension .off, .obj, .ply, .stl, .mesh, .msh, .glb\n";
    assert_eq!(fail(&folder, "a.off", "a.gltf"), expected);
    let expected = "error: bad.ply:2: expected the format ascii, binary_little_endian or binary_big_endian, found \"\"\n";
    assert_eq!(fail(&folder, "bad.ply", "b.off"), expected);
    assert_eq!(
        fail(&folder, "none.ply", "b.off"),
        "error: none.ply: there is no such file\n"
    );
    let expected = "error: no/b.off: cannot write the mesh: the folder no does not exist\n";
    assert_eq!(fail(&folder, "a.off", "no/b.off"), expected);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
}

/// A place in binary data is a byte, in a text a line.
#[test]
fn info_names_places_in_both_kinds_of_files() {
    let folder = folder(&[
        ("a.stl", "solid\nfacet\n"),
        (
            "a.ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n123",
        ),
    ]);
    let info = |name: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raymini"));
        let run = command
            .current_dir(folder.path())
            .args(["info", name])
            .output();
        String::from_utf8(run.expect("starts").stderr).expect("is text")
    };
    assert_eq!(
        info("a.stl"),
        "error: a.stl:2: expected normal, found the end of the file\n"
    );
    assert_eq!(
        info("a.ply"),
        "error: a.ply: byte 118: expected vertex 1 of 1, found the end of the file\n"
    );
}
