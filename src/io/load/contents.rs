//! What a scene file names and does not hold: meshes, the image of the background, and textures.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::LoadError;
use super::warnings::{image_warnings, lost_digits_warning, outside_warning, texture_warnings};
use crate::control::{CancelToken, Progress};
use crate::io::builtin;
use crate::io::mesh_file::{self, MeshError, MeshFile};
use crate::io::mesh_source::MeshSource;
use crate::io::part_name::file_and_part;
use crate::io::radiance_file::{RadianceError, load_radiance};
use crate::io::scene_file::SceneFile;
use crate::io::scene_paths::{absolute_image, absolute_mesh};
use crate::io::texture_loader::TextureLoader;
use crate::scene::{Background, Scene, Textures};

/// The file's scene with its meshes and images, found relative to `folder`; `None` when cancelled.
pub fn load_contents(
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
    progress.add_to_total(work + textures.sum::<u64>());
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
        let (mut whole, mut new) = (None, Vec::new());
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
                    new.push(Arc::clone(&taken));
                    scene.meshes.insert(mesh, taken);
                }
            }
        }
        if let Some((index, mesh)) = whole {
            let file = read.into_whole(&name);
            let file = file.map_err(|error| error_at(index, error))?;
            let file = Arc::new(file.mesh);
            new.push(Arc::clone(&file));
            scene.meshes.insert(mesh, file);
        }
        warnings.extend(lost_digits_warning(&name, new.iter().map(|mesh| &**mesh)));
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

/// Loads the image of the background, if that is one and not loaded yet, relative to `folder`; false when cancelled.
pub fn load_background(
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

pub fn read_mesh(
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
pub fn work_of(mesh: &str) -> u64 {
    let (mesh, _) = file_and_part(mesh);
    match mesh.strip_prefix(builtin::PREFIX) {
        Some(name) => builtin::bytes(name).map_or(0, |bytes| bytes.len() as u64),
        None => std::fs::metadata(mesh).map_or(0, |metadata| 2 * metadata.len()),
    }
}
