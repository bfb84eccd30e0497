//! From paths to a scene with its meshes, and back.

use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use super::atomic::write_atomically;
use super::builtin;
use super::mesh_file::{self, MeshError, MeshFile};
use super::scene_file::{self, SceneFile, SceneFileError};
use crate::control::{CancelToken, Progress};
use crate::scene::{Object, Scene, SceneError, presets};

/// A scene ready to be prepared.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The description with its meshes.
    pub scene: Scene,
    /// What was dropped or looks wrong, in sentences.
    pub warnings: Vec<String>,
}

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The scene file could not be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file asked for.
        path: PathBuf,
        /// What the system said, or that the file is not text.
        reason: String,
    },
    /// The scene file has a mistake.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// A mesh named on its own could not be loaded.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Meshes that make no scene, such as one a double cannot measure.
    #[error(transparent)]
    Description(#[from] SceneError),
    /// A scene file among several files.
    #[error("{}: a scene file is opened alone; only meshes can be opened together", path.display())]
    SceneAmongMeshes {
        /// The scene file.
        path: PathBuf,
    },
}

/// Why a scene could not be saved.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write the scene: {reason}", path.display())]
pub struct SaveError {
    /// The file asked for.
    pub path: PathBuf,
    reason: io::Error,
}

/// The scene that is shown when nothing else is named: three creatures on a plane under four lights.
///
/// # Panics
/// Never, as far as tests can tell: the embedded files are checked by one.
#[must_use]
pub fn demo_scene() -> Scene {
    let file =
        SceneFile::parse(builtin::DEMO_SCENE, "demo.toml").expect("the embedded scene is right");
    let mut warnings = Vec::new();
    let loaded = load_meshes(
        &file,
        Path::new("."),
        &mut warnings,
        &CancelToken::new(),
        &Progress::new(),
    );
    loaded
        .expect("the embedded meshes are right")
        .expect("nobody cancels")
}

/// Loads a scene file, or a mesh as a scene of its own. `progress` counts bytes of meshes. `None` when cancelled.
///
/// # Errors
/// What cannot be read or understood, with file and line.
pub fn load_scene(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    load_scenes(&[path.to_owned()], cancel, progress)
}

/// Loads one scene file, or any number of meshes together as a framed and lit scene.
///
/// # Errors
/// What cannot be read or understood, with file and line.
pub fn load_scenes(
    paths: &[PathBuf],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    match paths {
        [path] if is_scene_file(path) => load_scene_file(path, cancel, progress),
        _ => match paths.iter().find(|path| is_scene_file(path)) {
            Some(path) => Err(LoadError::SceneAmongMeshes { path: path.clone() }),
            None => load_bare_meshes(paths, cancel, progress),
        },
    }
}

/// Loads the mesh file at `path`. `progress` counts bytes. `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, or is malformed.
pub fn load_mesh(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    progress.set_total(work_of(&path.to_string_lossy()));
    mesh_file::load_mesh(path, cancel, progress)
}

/// Writes `scene` to `path`, mesh paths made relative to it. The file appears whole or not at all.
///
/// # Errors
/// What the system says.
pub fn save_scene(scene: &Scene, path: &Path) -> Result<(), SaveError> {
    let error = |reason| SaveError {
        path: path.to_owned(),
        reason,
    };
    let absolute = std::path::absolute(path).map_err(error)?;
    let folder = absolute.parent().unwrap_or(&absolute);
    let mut portable = scene.clone();
    for object in &mut portable.objects {
        object.mesh = relative_mesh(&object.mesh, folder);
    }
    let text = scene_file::write(&portable);
    write_atomically(path, |file| file.write_all(text.as_bytes())).map_err(error)
}

/// Changes values of a loaded scene as [`scene_file::apply_overrides`] does, and loads meshes that are new by it; their paths
/// are relative to the working folder.
///
/// # Errors
/// What about an assignment cannot be understood or loaded.
pub fn override_scene(
    loaded: &mut LoadedScene,
    assignments: &[String],
    cancel: &CancelToken,
) -> Result<(), LoadError> {
    if assignments.is_empty() {
        return Ok(());
    }
    let mut scene = scene_file::apply_overrides(&loaded.scene, assignments)?;
    for index in 0..scene.objects.len() {
        let mesh = absolute_mesh(&scene.objects[index].mesh, Path::new("."));
        scene.objects[index].mesh.clone_from(&mesh);
        if !scene.meshes.contains_key(&mesh)
            && let Some(file) = read_mesh(&mesh, cancel, &Progress::new())?
        {
            loaded.warnings.extend(mesh_warnings(&mesh, &file));
            scene.meshes.insert(mesh, Arc::new(file.mesh));
        }
    }
    loaded.scene = scene;
    Ok(())
}

/// Whether `path` is taken for a scene file rather than a mesh.
#[must_use]
pub fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// What a loaded mesh file leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn mesh_warnings(name: &str, file: &MeshFile) -> Vec<String> {
    file.warnings
        .iter()
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

fn load_scene_file(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let unreadable = |reason: String| LoadError::Unreadable {
        path: path.to_owned(),
        reason,
    };
    let bytes = std::fs::read(path)
        .map_err(|error| unreadable(format!("cannot read the scene: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        unreadable(format!(
            "a scene file is UTF-8 text, but byte {} is not",
            error.utf8_error().valid_up_to() + 1
        ))
    })?;
    let file = SceneFile::parse(&text, &path.display().to_string())?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut warnings = Vec::new();
    let scene = load_meshes(&file, folder, &mut warnings, cancel, progress)?;
    Ok(scene.map(|scene| LoadedScene { scene, warnings }))
}

/// The file's scene with its meshes, found relative to `folder`; `None` when cancelled.
fn load_meshes(
    file: &SceneFile,
    folder: &Path,
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Scene>, LoadError> {
    let mut scene = file.scene.clone();
    for object in &mut scene.objects {
        object.mesh = absolute_mesh(&object.mesh, folder);
    }
    progress.set_total(
        scene
            .objects
            .iter()
            .map(|object| work_of(&object.mesh))
            .sum(),
    );
    for index in 0..scene.objects.len() {
        let mesh = scene.objects[index].mesh.clone();
        if scene.meshes.contains_key(&mesh) {
            progress.advance(work_of(&mesh));
            continue;
        }
        let loaded = read_mesh(&mesh, cancel, progress)
            .map_err(|error| file.error_at(&format!("objects.{index}.mesh"), error.to_string()))?;
        let Some(loaded) = loaded else {
            return Ok(None);
        };
        warnings.extend(mesh_warnings(&mesh, &loaded));
        scene.meshes.insert(mesh, Arc::new(loaded.mesh));
    }
    Ok(Some(scene))
}

fn load_bare_meshes(
    paths: &[PathBuf],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let mut scene = Scene::default();
    let mut warnings = Vec::new();
    let meshes: Vec<String> = paths
        .iter()
        .map(|path| absolute_mesh(&path.to_string_lossy(), Path::new(".")))
        .collect();
    progress.set_total(meshes.iter().map(|mesh| work_of(mesh)).sum());
    for (path, mesh) in paths.iter().zip(meshes) {
        // As the user wrote it, for messages.
        let Some(loaded) = mesh_file::load_mesh(path, cancel, progress)? else {
            return Ok(None);
        };
        warnings.extend(mesh_warnings(&path.display().to_string(), &loaded));
        let name = path
            .file_stem()
            .map_or_else(|| mesh.clone(), |stem| stem.to_string_lossy().into_owned());
        scene.objects.push(Object {
            name,
            mesh: mesh.clone(),
            ..presets::object()
        });
        scene.meshes.insert(mesh, Arc::new(loaded.mesh));
    }
    presets::light_and_frame(&mut scene)?;
    Ok(Some(LoadedScene { scene, warnings }))
}

fn read_mesh(
    mesh: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    match mesh.strip_prefix(builtin::PREFIX) {
        Some(name) => builtin::mesh(name, cancel, progress),
        None => mesh_file::load_mesh(Path::new(mesh), cancel, progress),
    }
}

/// The work of loading a mesh, in the unit of its progress: every byte is read once and understood once.
fn work_of(mesh: &str) -> u64 {
    match mesh.strip_prefix(builtin::PREFIX) {
        Some(name) => builtin::bytes(name).map_or(0, |bytes| bytes.len() as u64),
        None => std::fs::metadata(mesh).map_or(0, |metadata| 2 * metadata.len()),
    }
}

/// The name under which a scene keeps the mesh that a file in `folder` calls `written`: a path from the root, so that it means
/// the same wherever the scene is saved.
#[must_use]
pub fn absolute_mesh(written: &str, folder: &Path) -> String {
    if written.starts_with(builtin::PREFIX) {
        return written.to_owned();
    }
    let path = folder.join(written);
    // Fails for an empty path only, which then cannot be read either.
    let path = std::path::absolute(&path).unwrap_or(path);
    without_dots(&path).to_string_lossy().into_owned()
}

/// `path` without `.` and without `x/..`, so that one file has one name.
fn without_dots(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(result.components().next_back(), Some(Component::Normal(_))) =>
            {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

/// How a scene file in `folder`, an absolute path, calls the mesh kept under the name `mesh`.
fn relative_mesh(mesh: &str, folder: &Path) -> String {
    let (path, folder) = (Path::new(mesh), without_dots(folder));
    let (mut there, mut here) = (path.components().peekable(), folder.components().peekable());
    // On another drive, or built in: the full name.
    if !path.is_absolute() || there.peek() != here.peek() {
        return mesh.to_owned();
    }
    while there.peek().is_some() && there.peek() == here.peek() {
        there.next();
        here.next();
    }
    let steps: PathBuf = here.map(|_| Component::ParentDir).chain(there).collect();
    // Scene files use the slash of the web on every system.
    steps
        .components()
        .map(|c| c.as_os_str().to_string_lossy())
        .collect::<Vec<_>>()
        .join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesh_names_survive_moving_the_scene() {
        let name = absolute_mesh("../assets/./ram.off", Path::new("/home/a/scenes"));
        assert_eq!(name, "/home/a/assets/ram.off");
        assert_eq!(
            relative_mesh(&name, Path::new("/home/a/scenes")),
            "../assets/ram.off"
        );
        assert_eq!(
            relative_mesh(&name, Path::new("/home/b")),
            "../a/assets/ram.off"
        );
        assert_eq!(relative_mesh(&name, Path::new("/home/a/assets")), "ram.off");
        assert_eq!(absolute_mesh("builtin:ram", Path::new("/x")), "builtin:ram");
        assert_eq!(relative_mesh("builtin:ram", Path::new("/x")), "builtin:ram");
    }

    #[test]
    fn progress_ends_at_its_total() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
            .expect("is written");
        let twice = "[[objects]]\nmesh = \"a.off\"\n[[objects]]\nmesh = \"builtin:ground\"\n[[objects]]\nmesh = \"a.off\"\n";
        std::fs::write(path("scene.toml"), twice).expect("is written");
        for name in ["a.off", "scene.toml"] {
            let progress = Progress::new();
            load_scene(&path(name), &CancelToken::new(), &progress)
                .expect("is right")
                .expect("nobody cancels");
            assert!(progress.total() > 0, "{name}");
            assert_eq!(progress.done(), progress.total(), "{name}");
        }
    }

    #[test]
    fn the_demo_scene_is_whole() {
        let scene = demo_scene();
        assert_eq!(scene.lights.len(), 4);
        assert_eq!(scene.objects.len(), 4);
        assert!(scene.triangle_count() > 30_000);
        assert_eq!(scene.validate(), Ok(()));
    }
}
