//! From paths to a scene with its meshes and images, and back.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::atomic::write_atomically;
use super::builtin;
use super::mesh_file::{self, MeshError, MeshFile};
use super::mesh_source::MeshSource;
use super::model_loading::{load_models, scene_of_models};
use super::origin::WrittenOrigin;
use super::part_name::file_and_part;
use super::radiance_file::{RadianceError, RadianceFile, load_radiance};
use super::scene_file::{self, SceneFile, SceneFileError};
use super::scene_paths::{
    absolute_image, absolute_mesh, is_render_file, is_scene_file, relative_mesh, relative_path,
};
use super::texture_file::TextureFile;
use super::texture_loader::TextureLoader;
use super::whole_file::read_bounded_file;
use crate::control::{CancelToken, Progress};
use crate::scene::{Background, Scene, SceneError, Textures};

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
    let loaded = load_parts(
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
        let objects = &scene.objects;
        scene
            .meshes
            .retain(|name, _| objects.iter().any(|object| object.mesh == *name));
        let background = &scene.background;
        scene.images.retain(
            |name, _| matches!(background, Background::Image { image, .. } if image == name),
        );
        let textures = scene.texture_names();
        scene.textures.retain(|name, _| textures.contains(name));
    }
    Ok(loaded)
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

/// What a loaded mesh file leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn mesh_warnings(name: &str, file: &MeshFile) -> Vec<String> {
    file.warnings
        .iter()
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

/// What an image file loaded as a background leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn image_warnings(name: &str, file: &RadianceFile) -> Vec<String> {
    let (width, height) = (file.map.width(), file.map.height());
    let stretched = format!(
        "the image is {width}×{height}; one that shows all directions is twice as wide as high, so it is stretched"
    );
    let is_stretched = u64::from(width) != 2 * u64::from(height);
    file.warnings
        .iter()
        .chain(is_stretched.then_some(&stretched))
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

/// What the file of a texture leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn texture_warnings(name: &str, file: &TextureFile) -> Vec<String> {
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
    let origin = WrittenOrigin::of_file(path).and_then(|origin| {
        let missing = "this picture does not tell what was rendered, as pictures of RayMini do";
        origin.scene.ok_or_else(|| missing.to_owned())
    });
    let text = origin.map_err(|reason| LoadError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    let name = format!("the scene in {}", path.display());
    load_text(&text, &name, path, cancel, progress)
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
    let scene = load_parts(file, folder, &mut warnings, cancel, progress)?;
    Ok(scene.map(|scene| LoadedScene { scene, warnings }))
}

/// The file's scene with its meshes and images, found relative to `folder`; `None` when cancelled.
fn load_parts(
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
    let meshes = scene.objects.iter().map(|object| work_of(&object.mesh));
    let image = match &scene.background {
        Background::Image { image, .. } => work_of(&absolute_image(image, folder)),
        _ => 0,
    };
    let work = meshes.sum::<u64>() + image;
    for image in scene.material_textures_mut().flat_map(Textures::images_mut) {
        *image = absolute_image(image, folder);
    }
    let textures = scene.texture_names();
    let textures = textures.iter().map(|image| work_of(image));
    progress.set_total(work + textures.sum::<u64>());
    if load_meshes(&mut scene, file, folder, warnings, cancel, progress)?.is_none() {
        return Ok(None);
    }
    let whole = load_background(&mut scene, folder, warnings, cancel, progress)
        .map_err(|error| file.error_at("background.image", error.to_string()))?;
    if let (true, Background::Image { image, .. }) = (whole, &scene.background) {
        warnings.extend(outside_warning(image, folder));
    }
    let whole = whole && load_textures(file, &mut scene, folder, warnings, cancel, progress)?;
    Ok(whole.then_some(scene))
}

/// Loads the meshes of all objects, each file once; `None` when cancelled.
fn load_meshes(
    scene: &mut Scene,
    file: &SceneFile,
    folder: &Path,
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<()>, LoadError> {
    // The objects of each file, in the order of the first.
    let mut files: Vec<(String, Vec<usize>)> = Vec::new();
    let mut numbers = HashMap::new();
    for (index, object) in scene.objects.iter().enumerate() {
        let (name, _) = file_and_part(&object.mesh);
        let number = *numbers.entry(name).or_insert(files.len());
        if number == files.len() {
            files.push((name.to_owned(), Vec::new()));
        }
        files[number].1.push(index);
    }
    for (name, objects) in files {
        let mut meshes = objects.iter().map(|&index| &scene.objects[index].mesh);
        if meshes.all(|mesh| scene.meshes.contains_key(mesh)) {
            progress.advance(work_of(&name) * objects.len() as u64);
            continue;
        }
        let error_at = |index: usize, error: MeshError| {
            file.error_at(&format!("objects.{index}.mesh"), error.to_string())
        };
        let read = match name.strip_prefix(builtin::PREFIX) {
            Some(name) => builtin::mesh(name, cancel, progress)
                .map(|file| file.map(|file| MeshSource::Mesh(Box::new(file)))),
            None => mesh_file::load_source(Path::new(&name), cancel, progress),
        };
        let Some(read) = read.map_err(|error| error_at(objects[0], error))? else {
            return Ok(None);
        };
        warnings.extend(outside_warning(&name, folder));
        warnings.extend(
            read.warnings()
                .iter()
                .map(|warning| format!("{name}: {warning}")),
        );
        let mut whole = None;
        let mut parts = read.taker();
        for &index in &objects {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            let mesh = scene.objects[index].mesh.clone();
            if scene.meshes.contains_key(&mesh) {
                continue;
            }
            match file_and_part(&mesh) {
                (_, None) => whole = Some((index, mesh)),
                (name, Some(part)) => {
                    let taken = parts.take(name, part);
                    let taken = taken.map_err(|error| error_at(index, error))?;
                    scene.meshes.insert(mesh, taken);
                }
            }
        }
        if let Some((index, mesh)) = whole {
            let file = read.into_whole(&name);
            let file = file.map_err(|error| error_at(index, error))?;
            scene.meshes.insert(mesh, Arc::new(file.mesh));
        }
        progress.advance(work_of(&name) * (objects.len() as u64 - 1));
    }
    Ok(Some(()))
}

/// Loads all images of materials, which are named from the root; `folder`: that of the scene file. False when cancelled.
fn load_textures(
    file: &SceneFile,
    scene: &mut Scene,
    folder: &Path,
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<bool, LoadError> {
    let mut loader = TextureLoader::default();
    for image in scene.texture_names() {
        if scene.textures.contains_key(&image) {
            progress.advance(work_of(&image));
            continue;
        }
        let loaded = loader
            .load(&image, work_of(&image), cancel, progress)
            .map_err(|error| {
                let key = key_of_texture(scene, &image);
                file.error_at(&key.unwrap_or_default(), error.to_string())
            })?;
        let Some(loaded) = loaded else {
            return Ok(false);
        };
        warnings.extend(outside_warning(&image, folder));
        warnings.extend(texture_warnings(&image, &loaded));
        scene.textures.insert(image, Arc::new(loaded.image));
    }
    Ok(true)
}

/// The first key of the scene file that names the texture `image`.
fn key_of_texture(scene: &Scene, image: &str) -> Option<String> {
    scene.materials.iter().find_map(|(name, material)| {
        let textures = material.textures()?;
        let keys = [
            ("diffuse_image", &textures.diffuse_image),
            ("normal_image", &textures.normal_image),
        ];
        let key = keys.iter().find(|(_, name)| name.as_deref() == Some(image));
        key.map(|(key, _)| format!("materials.{name}.{key}"))
    })
}

/// What is said when a scene file in `folder` has a mesh or image read from outside of the folder that holds `folder`. Scenes
/// and meshes in folders side by side are how people keep them; what lies further away the author of the file need not know.
/// Links are followed: the path may look harmless.
fn outside_warning(path: &str, folder: &Path) -> Option<String> {
    if path.starts_with(builtin::PREFIX) {
        return None;
    }
    let is_here = folder.as_os_str().is_empty();
    let folder = std::fs::canonicalize(if is_here { Path::new(".") } else { folder }).ok()?;
    // Everything lies in the root.
    let is_folder = |folder: &&Path| folder.parent().is_some();
    let around = folder.parent().filter(is_folder).unwrap_or(&folder);
    let (file, _) = file_and_part(path);
    let real = std::fs::canonicalize(file).unwrap_or_else(|_| file.into());
    let outside = !real.starts_with(around);
    outside.then(|| {
        format!(
            "{path}: the scene file reads this from outside of {}",
            around.display()
        )
    })
}

/// Loads the image of the background, if that is one and not loaded yet, relative to `folder`; false when cancelled.
fn load_background(
    scene: &mut Scene,
    folder: &Path,
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<bool, RadianceError> {
    let Background::Image { image, .. } = &mut scene.background else {
        return Ok(true);
    };
    *image = absolute_image(image, folder);
    if scene.images.contains_key(image) {
        return Ok(true);
    }
    let Some(loaded) = load_radiance(Path::new(image), cancel, progress)? else {
        return Ok(false);
    };
    warnings.extend(image_warnings(image, &loaded));
    scene.images.insert(image.clone(), Arc::new(loaded.map));
    Ok(true)
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
pub(super) fn work_of(mesh: &str) -> u64 {
    let (mesh, _) = file_and_part(mesh);
    match mesh.strip_prefix(builtin::PREFIX) {
        Some(name) => builtin::bytes(name).map_or(0, |bytes| bytes.len() as u64),
        None => std::fs::metadata(mesh).map_or(0, |metadata| 2 * metadata.len()),
    }
}

#[cfg(test)]
mod tests;
