//! Scenes some of whose mesh files are not there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::contents::named_from_root;
use super::{LoadError, LoadedScene, load_file, read_text};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::io::builtin;
use crate::io::part_name::file_and_part;
use crate::io::scene_file::SceneFile;

/// A mesh that a scene names, and whose file is not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingMesh {
    /// What its object is called.
    pub object: String,
    /// Where it was looked for.
    pub path: PathBuf,
    /// What the scene calls it.
    mesh: String,
}

/// The meshes that the scene file at `path` lacks, in the order of its objects; none where it cannot be understood.
#[must_use]
pub fn missing_meshes(path: &Path, cancel: &CancelToken) -> Vec<MissingMesh> {
    let file = parse(path, cancel).ok().flatten();
    file.map_or_else(Vec::new, |file| missing_in(&file, path))
}

/// Loads the scene file at `path`; meshes whose files are not there are empty. `progress` counts bytes of meshes and images.
/// `None` when cancelled.
///
/// # Errors
/// What else cannot be read or understood, with file and line.
pub fn load_scene_without_missing(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let Some(mut file) = parse(path, cancel)? else {
        return Ok(None);
    };
    let missing = missing_in(&file, path);
    for MissingMesh { mesh, .. } in &missing {
        let empty = Arc::new(TriangleMesh::default());
        file.scene.meshes.insert(mesh.clone(), empty);
    }
    let mut loaded = load_file(&file, path, cancel, progress)?;
    if let Some(LoadedScene { warnings, .. }) = &mut loaded {
        let warning = |MissingMesh { object, path, .. }: MissingMesh| {
            let path = path.display();
            format!("{object} has no triangles: there is no file {path}")
        };
        warnings.extend(missing.into_iter().map(warning));
    }
    Ok(loaded)
}

fn parse(path: &Path, cancel: &CancelToken) -> Result<Option<SceneFile>, LoadError> {
    let Some(text) = read_text(path, cancel)? else {
        return Ok(None);
    };
    Ok(Some(SceneFile::parse(&text, &path.display().to_string())?))
}

/// The meshes that `file`, which lies at `path`, lacks.
fn missing_in(file: &SceneFile, path: &Path) -> Vec<MissingMesh> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let objects = named_from_root(file, folder).objects.into_iter();
    let missing = objects.enumerate().filter_map(|(index, object)| {
        let is_built_in = object.mesh.starts_with(builtin::PREFIX);
        let path = PathBuf::from(file_and_part(&object.mesh).0);
        let is_missing = !is_built_in && !path.exists();
        let name = if object.name.is_empty() {
            format!("object {}", index + 1)
        } else {
            object.name
        };
        is_missing.then_some(MissingMesh {
            object: name,
            path,
            mesh: object.mesh,
        })
    });
    missing.collect()
}
