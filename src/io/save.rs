//! A scene to its file, in which meshes and images are found from there.

use std::io;
use std::path::{Path, PathBuf};

use super::atomic::write_atomically;
use super::scene_file;
use super::scene_paths::{relative_mesh, relative_path};
use crate::scene::{Background, Scene, Textures};

/// Why a scene could not be saved.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write the scene: {reason}", path.display())]
pub struct SaveError {
    /// The file asked for.
    pub path: PathBuf,
    reason: io::Error,
}

/// Writes `scene` to `path`, paths of meshes and images made relative to it. The file appears whole or not at all.
///
/// # Errors
/// What the system says.
pub fn save_scene(scene: &Scene, path: &Path) -> Result<(), SaveError> {
    let written = portable_text(scene, path)
        .and_then(|text| write_atomically(path, |file| file.write_all(text.as_bytes())));
    written.map_err(|reason| SaveError {
        path: path.to_owned(),
        reason,
    })
}

/// The text of a scene file at `path`: paths of meshes and images are relative to it.
pub(super) fn portable_text(scene: &Scene, path: &Path) -> io::Result<String> {
    let absolute = std::path::absolute(path)?;
    let folder = absolute.parent().unwrap_or(&absolute);
    let mut portable = scene.clone();
    for object in &mut portable.objects {
        object.mesh = relative_mesh(&object.mesh, folder);
    }
    if let Background::Image { image, .. } = &mut portable.background {
        *image = relative_path(image, folder);
    }
    for image in portable
        .material_textures_mut()
        .flat_map(Textures::images_mut)
    {
        *image = relative_path(image, folder);
    }
    Ok(scene_file::write(&portable))
}
