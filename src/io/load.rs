//! From paths to a scene with its meshes and images, and back.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::atomic::write_atomically;
use super::builtin;
use super::mesh_file::{self, MeshError, MeshFile};
use super::mesh_source::MeshSource;
use super::model_loading::load_models;
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
use crate::scene::{Background, Material, Scene, SceneError, Textures};

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
        _ => match paths.iter().find(|path| is_scene_file(path)) {
            Some(path) => Err(LoadError::SceneAmongMeshes { path: path.clone() }),
            None => load_models(paths, cancel, progress),
        },
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
    for image in texture_names_mut(&mut portable) {
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
    for image in texture_names_mut(&mut scene) {
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
    for image in texture_names_mut(&mut scene) {
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

/// The names of the images of all materials, to be changed.
fn texture_names_mut(scene: &mut Scene) -> impl Iterator<Item = &mut String> {
    let textures = scene
        .materials
        .values_mut()
        .filter_map(Material::textures_mut);
    textures.flat_map(Textures::images_mut)
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
mod tests {
    use super::*;
    use crate::scene::Texels;

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

    /// A folder with an image and a scene in a folder beside it that names the image.
    fn scene_under_a_sky() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let image = crate::render::Image {
            width: 4,
            height: 2,
            pixels: (0..8_u8).map(|i| [f32::from(i); 3]).collect(),
        };
        let path = folder.path().join("sky.exr");
        let scene = Scene::default();
        crate::io::write_image(&image, &[], &scene.display, &scene.output, &path)
            .expect("is written");
        std::fs::create_dir(folder.path().join("scenes")).expect("is made");
        let path = folder.path().join("scenes/a.toml");
        let text = "[background]\nimage = \"../sky.exr\"\nrotation = 30\n\
                    [[objects]]\nmesh = \"builtin:ground\"\n";
        std::fs::write(&path, text).expect("is written");
        (folder, path)
    }

    fn load(path: &Path) -> Result<LoadedScene, LoadError> {
        let progress = Progress::new();
        let loaded = load_scene(path, &CancelToken::new(), &progress)?.expect("nobody cancels");
        assert_eq!(progress.done(), progress.total());
        Ok(loaded)
    }

    #[test]
    fn a_background_image_is_loaded_saved_and_found_again() {
        let (folder, path) = scene_under_a_sky();
        let LoadedScene { scene, warnings } = load(&path).expect("is right");
        assert_eq!(warnings, Vec::<String>::new());
        let map = scene
            .background_image()
            .expect("is loaded")
            .expect("is one");
        assert_eq!(map.row(1)[2], [6.0; 3]);

        // Saved elsewhere, the scene still finds its image, by a path relative to itself.
        std::fs::create_dir_all(folder.path().join("b/c")).expect("is made");
        let other = folder.path().join("b/c/other.toml");
        save_scene(&scene, &other).expect("is written");
        let text = std::fs::read_to_string(&other).expect("is there");
        assert!(text.contains("image = \"../../sky.exr\""), "{text}");
        assert_eq!(load(&other).expect("is right").scene, scene);
    }

    #[test]
    fn an_image_that_cannot_be_loaded_is_an_error_at_its_place() {
        let (folder, path) = scene_under_a_sky();
        std::fs::write(folder.path().join("sky.exr"), "OFF\n").expect("is written");
        let found = load(&path).expect_err("is no image").to_string();
        let at = format!("{}:2:9: ", path.display());
        let expected = "sky.exr: this is not a known kind of image; expected OpenEXR";
        assert!(
            found.starts_with(&at) && found.contains(expected),
            "{found}"
        );
    }

    #[test]
    fn overrides_load_a_background_image() {
        let (folder, path) = scene_under_a_sky();
        let mut loaded = load(&path).expect("is right");
        let set = |loaded: &mut LoadedScene, assignment: String| {
            override_scene(loaded, &[assignment], &CancelToken::new())
        };
        set(&mut loaded, "background.radiance=[1,1,1]".into()).expect("is right");
        let sky = folder.path().join("sky.exr");
        loaded.scene.images.clear();
        let assignment = format!("background.image={}", sky.display());
        set(&mut loaded, assignment).expect("is right");
        assert!(
            loaded
                .scene
                .background_image()
                .is_ok_and(|map| map.is_some())
        );
        let error = set(&mut loaded, "background.image=/nowhere/a.exr".into());
        let error = error.expect_err("is not there").to_string();
        assert_eq!(error, "/nowhere/a.exr: there is no such file");
    }

    /// A folder with a texture of one white texel and a scene in a folder beside it that names it twice.
    fn textured_scene() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let white = crate::render::Image {
            width: 1,
            height: 1,
            pixels: vec![[1.0; 3]],
        };
        let scene = Scene::default();
        let path = folder.path().join("white.png");
        crate::io::write_image(&white, &[], &scene.display, &scene.output, &path)
            .expect("is written");
        std::fs::create_dir(folder.path().join("scenes")).expect("is made");
        let path = folder.path().join("scenes/a.toml");
        let text = "[materials.a]\ndiffuse_image = \"../white.png\"\n\
                    normal_image = \"./../white.png\"\n[materials.b]\nspecular = [0, 0, 0]\n\
                    [[objects]]\nmesh = \"builtin:ground\"\nmaterial = \"a\"\n";
        std::fs::write(&path, text).expect("is written");
        (folder, path)
    }

    #[test]
    fn textures_are_loaded_once_saved_and_found_again() {
        let (folder, path) = textured_scene();
        let LoadedScene { scene, warnings } = load(&path).expect("is right");
        assert_eq!(warnings, Vec::<String>::new());
        assert_eq!(scene.textures.len(), 1);
        let names = scene.texture_names();
        let name = names.first().expect("one is named");
        let texture = scene.texture(name).expect("is loaded");
        assert_eq!(*texture.texels(), Texels::Bytes(vec![[255; 3]]));

        std::fs::create_dir_all(folder.path().join("b/c")).expect("is made");
        let other = folder.path().join("b/c/other.toml");
        save_scene(&scene, &other).expect("is written");
        let text = std::fs::read_to_string(&other).expect("is there");
        assert!(
            text.contains("diffuse_image = \"../../white.png\""),
            "{text}"
        );
        assert_eq!(load(&other).expect("is right").scene, scene);
    }

    #[test]
    fn a_texture_that_cannot_be_loaded_is_an_error_at_its_place() {
        let (folder, path) = textured_scene();
        std::fs::remove_file(folder.path().join("white.png")).expect("is there");
        let found = load(&path).expect_err("is not there").to_string();
        let image = folder.path().join("white.png");
        let (path, image) = (path.display(), image.display());
        assert_eq!(
            found,
            format!("{path}:2:17: {image}: there is no such file")
        );
    }

    #[test]
    fn overrides_load_textures() {
        let (folder, path) = textured_scene();
        let mut loaded = load(&path).expect("is right");
        loaded.scene.textures.clear();
        let image = folder.path().join("white.png");
        let assignment = format!("materials.b.diffuse_image={}", image.display());
        override_scene(&mut loaded, &[assignment], &CancelToken::new()).expect("is right");
        let material = &loaded.scene.materials["b"];
        let textures = material.textures().expect("phong");
        let image = textures.diffuse_image.as_deref().expect("is set");
        assert!(loaded.scene.texture(image).is_ok());
        let assignment = "materials.b.normal_image=/nowhere/a.png".to_owned();
        let error = override_scene(&mut loaded, &[assignment], &CancelToken::new());
        let error = error.expect_err("is not there").to_string();
        assert_eq!(error, "/nowhere/a.png: there is no such file");
    }

    /// A scene may name what lies beside it or beside its folder; reading anything else is said, links or not.
    #[test]
    fn what_a_scene_reads_from_far_away_is_said() {
        let root = tempfile::tempdir().expect("a folder");
        let path = |name: &str| root.path().join(name);
        for folder in ["project/scenes/parts", "project/assets", "private"] {
            std::fs::create_dir_all(path(folder)).expect("is made");
        }
        let triangle = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        for mesh in [
            "project/scenes/parts/a.off",
            "project/assets/a.off",
            "private/a.off",
        ] {
            std::fs::write(path(mesh), triangle).expect("is written");
        }
        let warnings = |mesh: &str| {
            let text = format!("[[objects]]\nmesh = {mesh:?}\n");
            std::fs::write(path("project/scenes/a.toml"), text).expect("is written");
            load(&path("project/scenes/a.toml"))
                .expect("is right")
                .warnings
        };
        let absolute = path("project/assets/a.off");
        for near in [
            "parts/a.off",
            "../assets/a.off",
            "builtin:ground",
            &absolute.to_string_lossy(),
        ] {
            assert_eq!(warnings(near), Vec::<String>::new(), "{near}");
        }
        let far = path("private/a.off");
        let far = far.to_string_lossy();
        let around = std::fs::canonicalize(path("project")).expect("exists");
        let expected = |read: &str| {
            let around = around.display();
            vec![format!(
                "{read}: the scene file reads this from outside of {around}"
            )]
        };
        for mesh in ["../../private/a.off", &far] {
            assert_eq!(warnings(mesh), expected(&far), "{mesh}");
        }
        #[cfg(unix)]
        {
            let link = path("project/scenes/link.off");
            std::os::unix::fs::symlink(path("private/a.off"), &link).expect("is made");
            assert_eq!(warnings("link.off"), expected(&link.to_string_lossy()));
        }

        // An image likewise.
        let image = crate::render::Image {
            width: 2,
            height: 1,
            pixels: vec![[1.0; 3]; 2],
        };
        let sky = path("private/sky.exr");
        let scene = Scene::default();
        crate::io::write_image(&image, &[], &scene.display, &scene.output, &sky)
            .expect("is written");
        let text = "[background]\nimage = \"../../private/sky.exr\"\n";
        std::fs::write(path("project/scenes/b.toml"), text).expect("is written");
        let loaded = load(&path("project/scenes/b.toml")).expect("is right");
        assert_eq!(loaded.warnings, expected(&sky.to_string_lossy()));
    }

    #[test]
    fn a_scene_that_is_read_again_keeps_the_meshes_it_still_has() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        for (mesh, x) in [("a.off", 1), ("b.off", 2), ("c.off", 3)] {
            let text = format!("OFF\n3 1 0\n0 0 0\n{x} 0 0\n0 1 0\n3 0 1 2\n");
            std::fs::write(path(mesh), text).expect("is written");
        }
        let write = |meshes: &[&str]| {
            let object = |mesh: &&str| format!("[[objects]]\nmesh = {mesh:?}\n");
            let text: String = meshes.iter().map(object).collect();
            std::fs::write(path("scene.toml"), text).expect("is written");
        };
        write(&["a.off", "b.off"]);
        let before = load(&path("scene.toml")).expect("is right").scene;
        // What has changed on disk is known from elsewhere, and read from there.
        std::fs::write(path("b.off"), "no mesh").expect("is written");
        write(&["b.off", "c.off"]);
        let again = reload_scene(&path("scene.toml"), &before, &CancelToken::new());
        let again = again.expect("is right").expect("nobody cancels").scene;
        let mesh = |scene: &Scene, name: &str| {
            let name = path(name).to_string_lossy().into_owned();
            scene.meshes.get(&name).cloned()
        };
        assert!(mesh(&again, "a.off").is_none() && again.meshes.len() == 2);
        let [old, new] = [&before, &again].map(|scene| mesh(scene, "b.off").expect("is there"));
        assert!(Arc::ptr_eq(&old, &new));
        assert_eq!(mesh(&again, "c.off").expect("is read").positions[1].x, 3.0);
    }

    #[test]
    fn the_scenes_of_this_repository_load_without_a_warning() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let entries = std::fs::read_dir(folder).expect("a folder");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let scenes: Vec<PathBuf> = paths.filter(|path| is_scene_file(path)).collect();
        assert!(scenes.len() > 10);
        for path in scenes {
            let loaded = load(&path).expect("is right");
            assert_eq!(loaded.warnings, Vec::<String>::new(), "{}", path.display());
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
