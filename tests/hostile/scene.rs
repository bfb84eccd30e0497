use raymini::io::scene_file::{SceneFile, apply_overrides, write};
use raymini::scene::Scene;

use super::{assert_memory, assert_message, measured};

/// Bytes of memory per byte of text: each value of two bytes knows its line and column, the TOML reader keeps tokens, and a table
/// of one short key, which takes four bytes of text, has room for several.
const MEMORY: usize = 256;

/// What begins a line, for TOML a comment, that stands for `--set` with the rest of the line.
const OVERRIDE: &str = "#set ";

/// Reads `bytes` as a scene file, then applies what its lines of `#set KEY=VALUE` say. Each scene that comes out is valid and is
/// the same when written and read again.
pub fn check(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let (read, peak) = measured(|| SceneFile::parse(text, "scene.toml"));
    assert_memory(peak, MEMORY, bytes.len());
    let scene = match read {
        Ok(file) => file.scene,
        Err(error) => return assert_message(&error.to_string()),
    };
    check_scene(&scene);
    let overrides: Vec<String> = text
        .lines()
        .filter_map(|line| line.strip_prefix(OVERRIDE))
        .map(str::to_owned)
        .collect();
    for count in [1, overrides.len()] {
        let assignments = &overrides[..count.min(overrides.len())];
        if let Ok(changed) = apply_overrides(&scene, assignments) {
            check_scene(&changed);
        }
    }
}

fn check_scene(scene: &Scene) {
    assert_eq!(scene.validate(), Ok(()));
    let _ = (scene.warnings(), scene.measured_bounds());
    let text = write(scene);
    let again = SceneFile::parse(&text, "written")
        .unwrap_or_else(|error| panic!("what is written: {error}\n{text}"));
    assert_eq!(again.scene, *scene);
    assert_eq!(write(&again.scene), text);
}
