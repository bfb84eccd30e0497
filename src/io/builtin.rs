//! Files inside the program: the demo scene and its meshes, which any scene file can name as `builtin:NAME`.

use super::mesh_file::{MeshError, MeshFile, parse_mesh};
use crate::control::{CancelToken, Progress};

/// What the name of an embedded mesh starts with.
pub const PREFIX: &str = "builtin:";

/// The demo scene's file.
pub const DEMO_SCENE: &str = include_str!("../../scenes/demo.toml");

/// Every embedded mesh: name and bytes of an OFF file.
const MESHES: &[(&str, &[u8])] = &[
    ("ram", include_bytes!("../../assets/ram.off")),
    ("rhino", include_bytes!("../../assets/rhino.off")),
    ("gargoyle", include_bytes!("../../assets/gargoyle.off")),
    ("ground", include_bytes!("../../assets/ground.off")),
];

/// The bytes of an embedded mesh.
pub fn bytes(name: &str) -> Option<&'static [u8]> {
    MESHES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, bytes)| *bytes)
}

/// Reads an embedded mesh. `None` when cancelled.
///
/// # Errors
/// When there is none of that name.
pub fn mesh(
    name: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    let Some(bytes) = bytes(name) else {
        let known: Vec<&str> = MESHES.iter().map(|(name, _)| *name).collect();
        return Err(MeshError::Unreadable {
            name: format!("{PREFIX}{name}"),
            reason: format!(
                "there is no such built-in mesh; there are {}",
                known.join(", ")
            ),
        });
    };
    parse_mesh(&format!("{PREFIX}{name}.off"), bytes, cancel, progress)
}
