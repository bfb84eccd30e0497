//! From paths of mesh files to what they bring into a scene, with the images of their materials.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::load::{LoadedScene, lost_digits_warning, texture_warnings, work_of};
use super::mesh_file::{self, MeshError};
use super::mesh_source::MeshSource;
use super::model::{self, Model};
use super::part_name::file_and_part;
use super::texture_loader::TextureLoader;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::scene::{Scene, SceneError, presets};

/// Loads the mesh file at `path` as the objects it brings into a scene. `progress` counts bytes. `None` when cancelled.
///
/// # Errors
/// Those of [`load_mesh`](super::load_mesh).
pub fn load_model(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Model>, MeshError> {
    progress.set_total(work_of(&path.to_string_lossy()));
    read_model(path, cancel, progress)
}

/// What a file holds now of meshes that were read from it before.
#[derive(Clone, Debug)]
pub struct ReadAgain {
    /// The meshes and what scenes call them.
    pub meshes: Vec<(String, Arc<TriangleMesh>)>,
    /// What is to be said of the file, in sentences.
    pub warnings: Vec<String>,
}

/// Loads the meshes that scenes call `names`, each the file at `path` or a part of it. `None` when cancelled.
///
/// # Errors
/// Those of [`load_mesh`](super::load_mesh), and that a part is no longer there.
pub fn load_again(
    path: &Path,
    names: &[String],
    cancel: &CancelToken,
) -> Result<Option<ReadAgain>, MeshError> {
    let Some(source) = mesh_file::load_source(path, cancel, &Progress::new())? else {
        return Ok(None);
    };
    let file = path.to_string_lossy();
    let warnings = source.warnings().iter();
    let mut warnings: Vec<String> = warnings
        .map(|warning| format!("{file}: {warning}"))
        .collect();
    let (parts, whole): (Vec<_>, Vec<_>) = names
        .iter()
        .partition(|name| file_and_part(name).1.is_some());
    let mut meshes = Vec::with_capacity(names.len());
    let mut taker = source.taker();
    for name in parts {
        if let (_, Some(part)) = file_and_part(name) {
            meshes.push((name.clone(), taker.take(&file, part)?));
        }
    }
    drop(taker);
    if let [name] = whole[..] {
        let whole = source.into_whole(&file)?;
        meshes.push((name.clone(), Arc::new(whole.mesh)));
    }
    let read = meshes.iter().map(|(_, mesh)| &**mesh);
    warnings.extend(lost_digits_warning(&file, read));
    Ok(Some(ReadAgain { meshes, warnings }))
}

/// Loads files of meshes as what they bring into a scene, in their order. `progress` counts bytes. `None` when cancelled.
///
/// # Errors
/// Those of [`load_mesh`](super::load_mesh).
pub fn load_models(
    paths: &[PathBuf],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Vec<Model>>, MeshError> {
    let work = paths.iter().map(|path| work_of(&path.to_string_lossy()));
    progress.set_total(work.sum());
    // As the user wrote them, for messages.
    let models = paths.iter().map(|path| {
        let mut model = read_model(path, cancel, progress)?;
        if let Some(model) = &mut model {
            model.warnings.extend(name_warning(path));
        }
        Ok(model)
    });
    models.collect()
}

/// What is to be said of a file whose name, with its folders', no scene can hold, which is text.
fn name_warning(path: &Path) -> Option<String> {
    let absolute = std::path::absolute(path).ok()?;
    absolute.to_str().is_none().then(|| {
        format!(
            "{}: the file's name or that of a folder is not Unicode, which scenes need: a saved scene or the one in a picture cannot find it \
             again",
            path.display()
        )
    })
}

/// The models of files as one scene: framed, and lit where they have no lights. Which way is up is for the first to say.
///
/// # Errors
/// When the objects cannot be measured.
pub fn scene_of_models(models: Vec<Model>) -> Result<LoadedScene, SceneError> {
    let mut scene = Scene::default();
    let mut warnings = Vec::new();
    let mut up = None;
    let mut camera = None;
    for model in models {
        camera = camera.or(model.camera);
        for light in model.scene.named_lights() {
            scene.add_light(light);
        }
        warnings.extend(model.warnings);
        up.get_or_insert(model.up);
        scene.join(model.scene);
    }
    for object in &mut scene.objects {
        object.material = object
            .material
            .take()
            .or_else(|| presets::object().material);
    }
    presets::light_and_frame(&mut scene, up.unwrap_or_default())?;
    if let Some(camera) = camera {
        scene.camera = presets::aimed(camera, &scene.measured_bounds()?);
    }
    Ok(LoadedScene { scene, warnings })
}

/// The model of a file. `None` when cancelled.
fn read_model(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Model>, MeshError> {
    let name = path.to_string_lossy();
    let model = if let (_, Some(_)) = file_and_part(&name) {
        let file = mesh_file::load_mesh(path, cancel, progress)?;
        file.and_then(|file| model::of_mesh_file(path, file, cancel))
    } else {
        match mesh_file::load_source(path, cancel, progress)? {
            None => None,
            Some(MeshSource::Mesh(file)) => model::of_mesh_file(path, *file, cancel),
            Some(MeshSource::Scene(gltf)) => Some(model::of_gltf(path, &gltf)),
        }
    };
    Ok(model.and_then(|model| load_model_textures(model, cancel, progress)))
}

/// The model with the images of its materials; those that cannot be loaded are left out, with a warning. `None` when cancelled.
fn load_model_textures(
    mut model: Model,
    cancel: &CancelToken,
    progress: &Progress,
) -> Option<Model> {
    let names = model.scene.texture_names();
    let work: u64 = names.iter().map(|name| work_of(name)).sum();
    progress.add_to_total(work);
    let mut loader = TextureLoader::default();
    for name in names {
        match loader.load(&name, work_of(&name), cancel, progress) {
            Ok(None) => return None,
            Ok(Some(file)) => {
                model.warnings.extend(texture_warnings(&name, &file));
                if file.image.is_grey() && leave_out_normals(&mut model.scene, &name) {
                    model.warnings.push(format!(
                        "{name}: this is an image of heights, where one of normals was expected; it is left out"
                    ));
                }
                if model.scene.texture_names().contains(&name) {
                    model.scene.textures.insert(name, Arc::new(file.image));
                }
            }
            Err(error) => {
                model
                    .warnings
                    .push(format!("{error}; the image is left out"));
                for textures in model.scene.material_textures_mut() {
                    textures.leave_out(&name);
                }
            }
        }
    }
    Some(model)
}

/// Takes the image called `name` away from materials that have it for normals; whether there are any.
fn leave_out_normals(scene: &mut Scene, name: &str) -> bool {
    // Of all of them, not up to the first.
    let had = scene
        .material_textures_mut()
        .map(|textures| textures.leave_out_normals(name));
    had.fold(false, |any, had| any | had)
}
