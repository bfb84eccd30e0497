//! A file of meshes that was read, whatever its format: its whole, and its parts.

use std::path::Path;
use std::sync::Arc;

use super::gltf::{self, Gltf};
use super::material_library::path_below;
use super::mesh_file::{INNER, MEMORY_PER_BYTE, MeshError, MeshFile};
use super::mesh_parts::PartCutter;
use super::mesh_reading::all_faces;
use super::shorten::shortened;
use super::whole_file::{read_file, require_memory};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::memory::require;

/// What a file held.
#[derive(Debug)]
pub enum MeshSource {
    /// Triangles of one mesh, perhaps in parts.
    Mesh(Box<MeshFile>),
    /// A scene of meshes.
    Scene(Box<Gltf>),
}

/// Name of the format of scenes.
pub const GLTF: &str = "glTF";

/// The scene in the `bytes` of the file at `path`, and in others that it names; `None` when cancelled. `progress` counts the bytes of
/// all.
///
/// # Errors
/// Those of [`gltf::parse`].
pub fn read_gltf(
    path: &Path,
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Gltf>, MeshError> {
    require(gltf::memory_of_records(bytes)).map_err(|short| MeshError::Unreadable {
        name: path.display().to_string(),
        reason: format!("reading this file takes about {short}"),
    })?;
    let mut load = |name: &str| load_beside(path, name, cancel, progress);
    let read = gltf::parse(bytes, &mut load, cancel, progress);
    read.map_err(|error| MeshError::Malformed {
        name: path.display().to_string(),
        error,
    })
}

/// The bytes of the file called `name` in the document at `path`, which must lie beside it or below; `None` when cancelled.
/// `progress` learns of it, and counts its bytes.
///
/// # Errors
/// Why it is not read, in words.
pub fn load_beside(
    path: &Path,
    name: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Vec<u8>>, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = path_below(name, folder)?;
    require_memory(&file, MEMORY_PER_BYTE)?;
    let length = std::fs::metadata(&file).map_or(0, |file| file.len());
    progress.add_to_total(length);
    read_file(&file, "a file of data", cancel, progress)
}

impl MeshSource {
    /// What is to be said of the file, in sentences without its name.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Mesh(file) => &file.warnings,
            Self::Scene(gltf) => &gltf.warnings,
        }
    }

    /// All of it as one mesh; `name` is what the file is called.
    ///
    /// # Errors
    /// That it is too much for one mesh.
    pub fn into_whole(self, name: &str) -> Result<MeshFile, MeshError> {
        let gltf = match self {
            Self::Mesh(file) => return Ok(*file),
            Self::Scene(gltf) => gltf,
        };
        let mesh = gltf.whole().map_err(|reason| MeshError::Unreadable {
            name: name.to_owned(),
            reason,
        })?;
        Ok(MeshFile {
            mesh,
            format: GLTF,
            faces: gltf.faces,
            dropped: gltf.dropped,
            warnings: gltf.warnings,
            ..MeshFile::default()
        })
    }

    /// Whoever takes parts of it.
    #[must_use]
    pub fn taker(&self) -> PartTaker<'_> {
        match self {
            Self::Mesh(file) if !file.cells.is_empty() => PartTaker::Cells(file),
            Self::Mesh(file) => PartTaker::Cut(PartCutter::new(&file.mesh, &file.parts)),
            Self::Scene(gltf) => PartTaker::Share(gltf),
        }
    }
}

/// Takes parts out of a file that was read.
pub enum PartTaker<'a> {
    /// By cutting them.
    Cut(PartCutter<'a>),
    /// By finding the faces of cells.
    Cells(&'a MeshFile),
    /// As they are.
    Share(&'a Gltf),
}

impl PartTaker<'_> {
    /// The `part` of the file called `name`.
    ///
    /// # Errors
    /// That there is none, and what parts there are.
    pub fn take(&mut self, name: &str, part: &str) -> Result<Arc<TriangleMesh>, MeshError> {
        let taken = match self {
            Self::Cut(cutter) => cutter.cut(part).map(Arc::new),
            Self::Cells(file) => {
                let faces = || all_faces(&file.mesh.positions, &file.cells);
                (part == INNER).then(|| Arc::new(faces()))
            }
            Self::Share(gltf) => gltf.parts.get(part).cloned(),
        };
        taken.ok_or_else(|| {
            let reason = match self {
                Self::Cut(cutter) => no_such_part(part, cutter.names()),
                Self::Cells(_) => no_such_part(part, [INNER].into_iter()),
                Self::Share(gltf) => no_such_part(part, gltf.parts.keys().map(String::as_str)),
            };
            MeshError::Unreadable {
                name: name.to_owned(),
                reason,
            }
        })
    }
}

/// What is said where none of the parts that are called so is `part`.
fn no_such_part<'a>(part: &str, names: impl ExactSizeIterator<Item = &'a str>) -> String {
    const MOST_SHOWN: usize = 8;
    let count = names.len();
    let shown = names.take(MOST_SHOWN);
    let shown: Vec<_> = shown
        .map(|name| format!("\"{}\"", shortened(name)))
        .collect();
    let known = match count {
        0 => "has no parts of different materials".to_owned(),
        _ if count > MOST_SHOWN => format!("has {count} parts, such as {}", shown.join(", ")),
        _ => format!("has {}", shown.join(", ")),
    };
    format!("there is no part \"{}\"; the file {known}", shortened(part))
}
