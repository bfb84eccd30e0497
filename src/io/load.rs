//! From paths to a scene with its meshes and images.

mod contents;
mod missing;
mod warnings;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::builtin;
use super::mesh_file::{self, MeshError, MeshFile};
use super::model_loading::{load_models, scene_of_models};
use super::origin::WrittenOrigin;
use super::radiance_file::{RadianceError, RadianceFile, load_radiance};
use super::save::portable_text;
use super::scene_file::{self, SceneFile, SceneFileError};
use super::scene_paths::{absolute_image, absolute_mesh, is_render_file, is_scene_file};
use super::texture_loader::TextureLoader;
use super::whole_file::read_bounded_file;
use crate::control::{CancelToken, Progress};
use crate::scene::{Background, Scene, SceneError, Textures};
use contents::{load_background, load_contents, named_from_root, read_mesh};

pub(super) use contents::work_of;
pub use missing::{
    Found, LoadedWithout, MissingFile, MissingKind, Moves, load_scene_without_missing,
    missing_files, missing_in, moved_along,
};
pub use warnings::{
    READ_FROM_OUTSIDE, STRETCHED, image_warnings, lost_digits_warning, mesh_warnings,
    texture_warnings,
};

/// The most bytes of a scene file. Meshes and images lie in files of their own, so 100,000 lights fit. Parsing takes some 80 times the
/// file's size, and up to 250 times where it is all tables of one short key: every value knows its line and column.
const MOST_SCENE_BYTES: u64 = 16 << 20;

/// A scene ready to be prepared.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The description with its meshes and images.
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
    /// An image, of the background or a material, could not be loaded.
    #[error(transparent)]
    Image(#[from] RadianceError),
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

/// The scene that is shown when nothing else is named: three creatures on a plane under four lights.
///
/// # Panics
/// Never, as far as tests can tell: the embedded files are checked by one.
#[must_use]
pub fn demo_scene() -> Scene {
    let file =
        SceneFile::parse(builtin::DEMO_SCENE, "demo.toml").expect("the embedded scene is right");
    let mut warnings = Vec::new();
    let loaded = load_contents(
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

/// Loads a scene file, or a mesh as a scene of its own. `progress` counts bytes of meshes and images.
/// `None` when cancelled.
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
        [path] if is_render_file(path) => load_render_file(path, cancel, progress),
        _ => {
            if let Some(path) = paths.iter().find(|path| is_scene_file(path)) {
                return Err(LoadError::SceneAmongMeshes { path: path.clone() });
            }
            let models = load_models(paths, cancel, progress)?;
            Ok(models.map(scene_of_models).transpose()?)
        }
    }
}

/// Loads the scene file at `path` again, whose scene was `known`: meshes, images and textures that it had are kept as they are, and not
/// read.
/// `None` when cancelled.
///
/// # Errors
/// What cannot be read or understood, with file and line.
pub fn reload_scene(
    path: &Path,
    known: &Scene,
    cancel: &CancelToken,
) -> Result<Option<LoadedScene>, LoadError> {
    let Some(text) = read_text(path, cancel)? else {
        return Ok(None);
    };
    let name = path.display().to_string();
    let mut file = SceneFile::parse(&text, &name)?;
    file.scene.meshes.clone_from(&known.meshes);
    file.scene.images.clone_from(&known.images);
    file.scene.textures.clone_from(&known.textures);
    let mut loaded = load_file(&file, path, cancel, &Progress::new())?;
    if let Some(LoadedScene { scene, .. }) = &mut loaded {
        forget_unused(scene);
    }
    Ok(loaded)
}

/// Lets go of meshes and images that nothing in `scene` names.
fn forget_unused(scene: &mut Scene) {
    let objects = &scene.objects;
    scene
        .meshes
        .retain(|name, _| objects.iter().any(|object| object.mesh == *name));
    let background = &scene.background;
    scene
        .images
        .retain(|name, _| matches!(background, Background::Image { image, .. } if image == name));
    let textures = scene.texture_names();
    scene.textures.retain(|name, _| textures.contains(name));
}

/// Whether there is a file at `path` that holds none of the scenes `known`, as far as scene files hold them: somebody has written another
/// one. What is there and cannot be read is another one, too.
#[must_use]
pub fn holds_other_scene(path: &Path, known: &[Scene]) -> bool {
    if !path.exists() {
        return false;
    }
    let Ok(Some(text)) = read_text(path, &CancelToken::new()) else {
        return true;
    };
    let texts = known
        .iter()
        .filter_map(|scene| portable_text(scene, path).ok());
    let texts: Vec<String> = texts.collect();
    if texts.contains(&text) {
        return false;
    }
    // Written by hand, the same scene looks otherwise.
    let Ok(file) = SceneFile::parse(&text, &path.display().to_string()) else {
        return true;
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    let there = portable_text(&named_from_root(&file, folder), path);
    !there.is_ok_and(|there| texts.contains(&there))
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

/// Loads the image at `path` for a background. `progress` counts bytes. `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, or is malformed.
pub fn load_image(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<RadianceFile>, RadianceError> {
    progress.set_total(work_of(&path.to_string_lossy()));
    load_radiance(path, cancel, progress)
}

/// Changes values of a loaded scene as [`scene_file::apply_overrides`] does, and loads meshes and images that are new by it; their
/// paths are relative to the working folder.
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
            loaded
                .warnings
                .extend(lost_digits_warning(&mesh, [&file.mesh]));
            scene.meshes.insert(mesh, Arc::new(file.mesh));
        }
    }
    let progress = Progress::new();
    let here = Path::new(".");
    load_background(&mut scene, here, &mut loaded.warnings, cancel, &progress)?;
    for image in scene.material_textures_mut().flat_map(Textures::images_mut) {
        *image = absolute_image(image, here);
    }
    let mut loader = TextureLoader::default();
    for image in scene.texture_names() {
        if !scene.textures.contains_key(&image)
            && let Some(file) = loader.load(&image, 0, cancel, &progress)?
        {
            loaded.warnings.extend(texture_warnings(&image, &file));
            scene.textures.insert(image, Arc::new(file.image));
        }
    }
    loaded.scene = scene;
    Ok(())
}

fn load_scene_file(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    match read_text(path, cancel)? {
        Some(text) => load_text(&text, &path.display().to_string(), path, cancel, progress),
        None => Ok(None),
    }
}

/// The text of a scene file; `None` when cancelled.
fn read_text(path: &Path, cancel: &CancelToken) -> Result<Option<String>, LoadError> {
    let unreadable = |reason: String| LoadError::Unreadable {
        path: path.to_owned(),
        reason,
    };
    let bytes = read_bounded_file(
        path,
        "a scene file",
        MOST_SCENE_BYTES,
        cancel,
        &Progress::new(),
    )
    .map_err(unreadable)?;
    let Some(bytes) = bytes else {
        return Ok(None);
    };
    let text = String::from_utf8(bytes).map_err(|error| {
        unreadable(format!(
            "a scene file is UTF-8 text, but byte {} is not",
            error.utf8_error().valid_up_to() + 1
        ))
    })?;
    Ok(Some(text))
}

/// The scene of which a picture was rendered.
fn load_render_file(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let (text, name) = text_of_render(path)?;
    load_text(&text, &name, path, cancel, progress)
}

/// The text of the scene of which a picture was rendered, and what errors call it.
fn text_of_render(path: &Path) -> Result<(String, String), LoadError> {
    let origin = WrittenOrigin::of_render(path).and_then(|origin| {
        let missing = "this picture does not tell what was rendered, as pictures of RayMini do";
        origin.scene.ok_or_else(|| missing.to_owned())
    });
    let text = origin.map_err(|reason| LoadError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    Ok((text, format!("the scene in {}", path.display())))
}

/// The scene of a `text` that errors call `name`, beside the file at `path`.
fn load_text(
    text: &str,
    name: &str,
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let file = SceneFile::parse(text, name)?;
    load_file(&file, path, cancel, progress)
}

/// The scene of `file`, which lies at `path`; `None` when cancelled.
fn load_file(
    file: &SceneFile,
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedScene>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut warnings = Vec::new();
    let scene = load_contents(file, folder, &mut warnings, cancel, progress)?;
    Ok(scene.map(|scene| LoadedScene { scene, warnings }))
}

#[cfg(test)]
mod tests;
