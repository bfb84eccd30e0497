//! Meshes whose digits were lost before their files were written: every command says so, with the figure, and once.

use std::path::Path;
use std::process::Command;

use raymini::geometry::TriangleMesh;
use raymini::geometry::shapes::icosphere;
use raymini::math::DVec3;
use serde_json::Value;
use tempfile::TempDir;

/// What all commands say, without the figures.
const SAID: &str = "the coordinates in the file were rounded to 32 bits up to ";

/// A binary STL file of `mesh`, moved.
fn stl(mesh: &TriangleMesh, by: DVec3) -> Vec<u8> {
    let count = u32::try_from(mesh.triangles.len()).expect("few");
    let mut bytes = vec![0; 80];
    bytes.extend(count.to_le_bytes());
    for face in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        for corner in mesh.corners(face) {
            for coordinate in (corner + by).as_vec3().to_array() {
                bytes.extend(coordinate.to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// What a command prints, and what it warns of.
fn raymini(folder: &Path, arguments: &[&str]) -> (String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raymini"));
    let run = command.current_dir(folder).args(arguments).output();
    let run = run.expect("starts");
    let text = |bytes| String::from_utf8(bytes).expect("is text");
    let (said, warned) = (text(run.stdout), text(run.stderr));
    assert!(run.status.success(), "{arguments:?}: {warned}");
    (said, warned)
}

#[test]
fn every_command_tells_digits_that_were_lost_before() {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("is written");
    };
    let ball = icosphere(3);
    write("far.stl", &stl(&ball, DVec3::X * 2e6));
    write("near.stl", &stl(&ball, DVec3::X * 2.0));
    for name in ["far", "near"] {
        let text = format!(
            "[[objects]]\nmesh = \"{name}.stl\"\n[render]\nwidth = 16\nheight = 12\n\
             [background]\nradiance = [1, 1, 1]\n"
        );
        write(&format!("{name}.toml"), text.as_bytes());
    }
    let commands = |name: &str| {
        ["stl", "toml"].map(|kind| {
            let file = format!("{name}.{kind}");
            let picture = format!("{name}-{kind}.png");
            let (facts, _) = raymini(folder.path(), &["info", &file, "--json"]);
            let rest = ["--size", "16x12", "--spp", "1"];
            let render = [&["render", &file, "-o", &picture], &rest[..]].concat();
            let (_, warned) = raymini(folder.path(), &render);
            let (_, planned) = raymini(folder.path(), &["plan", &file]);
            let facts: Value = serde_json::from_str(&facts).expect("is JSON");
            [facts["warnings"].to_string(), warned, planned]
        })
    };
    for said in commands("far").iter().flatten() {
        assert_eq!(said.matches(SAID).count(), 1, "{said}");
        // From 2²⁰ to 2²¹, numbers are an eighth apart.
        let figure = said.split(SAID).nth(1).expect("is told");
        assert!(figure.starts_with("2.00e6 from their origin"), "{said}");
        assert!(figure.contains(" % of the median edge apart; "), "{said}");
        assert!(figure.contains("move it to the origin"), "{said}");
    }
    for said in commands("near").iter().flatten() {
        assert!(!said.contains(SAID), "{said}");
    }
    // The examination tells more about it, and does not tell it twice.
    let (said, _) = raymini(folder.path(), &["check", "far.stl"]);
    assert_eq!(said.matches(SAID).count(), 1, "{said}");
    let (said, _) = raymini(folder.path(), &["check", "near.stl"]);
    assert!(!said.contains(SAID), "{said}");
}
