//! Models to files that hold materials: OBJ with MTL beside it, and GLB.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::atomic::write_atomically;
use super::merging::merge;
use super::model::Model;
use super::{gltf, mtl, obj};

/// A format of files that hold objects with materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFormat {
    /// Wavefront's, with the materials in a second file.
    Obj,
    /// glTF in one binary file.
    Glb,
}

/// Why a model could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The system's reason; an old file of that name is as it was.
    #[error("{}: cannot write the mesh: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// The model does not fit into the format.
    #[error("{}: {reason}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// A plain sentence.
        reason: String,
    },
}

impl ModelFormat {
    /// The format that a file of this name's extension has.
    #[must_use]
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_ascii_lowercase();
        match extension.to_str()? {
            "obj" => Some(Self::Obj),
            "glb" => Some(Self::Glb),
            _ => None,
        }
    }

    /// The name, as people write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Glb => "glTF",
        }
    }
}

/// Writes `model` to `path`; each file appears whole or not at all. Materials of OBJ go to a file beside it, which takes the place of no
/// other. Returns what the format does not hold, in sentences.
///
/// # Errors
/// What the system says, that the model does not fit, or that there is another file where the materials would go.
pub fn write_model(
    model: &Model,
    format: ModelFormat,
    path: &Path,
) -> Result<Vec<String>, WriteError> {
    let unwritable = |path: &Path| {
        let path = path.to_owned();
        |reason| WriteError::Unwritable { path, reason }
    };
    let scene = &model.scene;
    match format {
        ModelFormat::Glb => {
            write_atomically(path, |out| gltf::write(scene, model.camera.as_ref(), out))
                .map_err(unwritable(path))?;
            Ok(gltf::losses(scene))
        }
        ModelFormat::Obj => {
            let merged =
                merge(&scene.objects, &scene.meshes).map_err(|reason| WriteError::Unfit {
                    path: path.to_owned(),
                    reason,
                })?;
            let worn = scene
                .objects
                .iter()
                .map(|object| object.material.as_deref().unwrap_or_default());
            let worn: Vec<(usize, &str)> = merged.firsts.iter().copied().zip(worn).collect();
            let has_materials = !scene.materials.is_empty();
            let library = path.with_extension("mtl");
            let name = library
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            if has_materials {
                let mut text = Vec::new();
                let materials = &scene.materials;
                let materials = materials.iter().map(|(name, of)| (name.as_str(), of));
                mtl::write(materials, &mut text).map_err(unwritable(&library))?;
                if library.symlink_metadata().is_ok() {
                    // Nobody has named it, and other files may use it.
                    refuse_other(&library, &text)?;
                } else {
                    write_atomically(&library, |out| out.write_all(&text))
                        .map_err(unwritable(&library))?;
                }
            }
            let (name, worn) = if has_materials {
                (name.as_deref(), &worn[..])
            } else {
                (None, &[][..])
            };
            write_atomically(path, |out| obj::write_parts(&merged.mesh, name, worn, out))
                .map_err(unwritable(path))?;
            Ok(losses_of_obj(model))
        }
    }
}

/// Refuses the file of materials at `path`, which is there, where it does not hold `text`.
fn refuse_other(path: &Path, text: &[u8]) -> Result<(), WriteError> {
    let metadata = fs::metadata(path).ok();
    // Pipes and devices would keep who reads them.
    let may_hold =
        metadata.is_some_and(|found| found.is_file() && found.len() == text.len() as u64);
    if may_hold && fs::read(path).is_ok_and(|there| there == text) {
        return Ok(());
    }
    Err(WriteError::Unfit {
        path: path.to_owned(),
        reason: "the materials would go here, and there is a file with other content already; remove or rename it, or write the OBJ file \
                 under another name"
            .to_owned(),
    })
}

/// What of a model an OBJ file and its MTL file do not hold.
fn losses_of_obj(model: &Model) -> Vec<String> {
    let scene = &model.scene;
    let absorbs = |material: &crate::scene::Material| matches!(material, crate::scene::Material::Glass { attenuation, .. } if *attenuation != crate::scene::Rgb::ZERO);
    let lost = [
        (!scene.lights.is_empty(), "lights are left out"),
        (model.camera.is_some(), "the camera is left out"),
        (
            scene.materials.values().any(absorbs),
            "what glass absorbs is left out",
        ),
        (
            !scene.texture_names().is_empty(),
            "images of materials are left out",
        ),
    ];
    let lost = lost.into_iter().filter(|(is_lost, _)| *is_lost);
    lost.map(|(_, what)| what.to_owned()).collect()
}
