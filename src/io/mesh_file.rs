//! Mesh files of any format: finding the reader, reading the bytes, and saying what went wrong where.
//!
//! A reader takes bytes and knows no path; this module adds the path to its errors.

use super::gltf;
use super::mesh_format::{MeshFormat, READABLE_FORMATS};
use super::mesh_parts::MeshParts;
use super::mesh_reading::{Malformed, Place};
use super::mesh_source::{self, GLTF, MeshSource};
use super::part_name::file_and_part;
use super::whole_file::{read_file, require_memory};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::geometry::cells::Cells;
use crate::scene::presets::UpAxis;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;

/// What a mesh file held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The triangles, valid in the sense of [`TriangleMesh::validate`].
    pub mesh: TriangleMesh,
    /// Short name of the format, as people write it: `OFF`.
    pub format: &'static str,
    /// Faces in the file, the dropped ones included.
    pub faces: u64,
    /// Faces with more than three corners among them.
    pub polygons: u64,
    /// Faces that were left out.
    pub dropped: Dropped,
    /// What the file holds and the mesh does not, in sentences, with line numbers where the format has lines.
    pub warnings: Vec<String>,
    /// Which triangles wear which material; empty where the file says nothing of materials.
    pub parts: MeshParts,
    /// Whether parts are called as the images they show, beside this file, in place of their materials.
    pub parts_are_images: bool,
    /// The cells with a volume that it holds, of whose faces `mesh` has those outside. All of them are the part `inner`.
    pub cells: Cells,
    /// The files of materials that it names.
    pub libraries: Vec<MaterialLibrary>,
}

/// The part of a file with cells that has all faces of them, each once: those outside, and those between two cells.
pub const INNER: &str = "inner";

/// A file of materials as another file names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialLibrary {
    /// The line that names it.
    pub line: u64,
    /// One name, which may hold blanks, or several between blanks.
    pub name: String,
}

impl MeshFile {
    /// Which way is most likely up: most programs that write OBJ take Y for it, glTF is so, others take Z.
    #[must_use]
    pub fn likely_up(&self) -> UpAxis {
        if [MeshFormat::Obj.name(), GLTF].contains(&self.format) {
            UpAxis::Y
        } else {
            UpAxis::Z
        }
    }
}

/// How many faces were left out, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Faces without area: a corner repeated or all corners on a line, as [`face_normal`](crate::geometry::face_normal)
    /// decides it.
    pub degenerate: u64,
    /// Points and lines written as faces with fewer than three corners.
    pub too_few_corners: u64,
}

impl Dropped {
    /// All faces that were left out.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.degenerate + self.too_few_corners
    }
}

/// Why a mesh could not be loaded. Every message begins with the file's name.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The bytes could not be read, or there are none.
    #[error("{name}: {reason}")]
    Unreadable {
        /// The file, as it was asked for.
        name: String,
        /// A plain sentence.
        reason: String,
    },
    /// The bytes are of a format that has no reader.
    #[error("{name}: {what}; RayMini reads {READABLE_FORMATS}")]
    UnknownFormat {
        /// The file, as it was asked for.
        name: String,
        /// What the file seems to be.
        what: String,
    },
    /// The bytes break the rules of their format.
    #[error("{}", in_file(name, error))]
    Malformed {
        /// The file, as it was asked for.
        name: String,
        /// What was expected where, and what was found.
        error: Malformed,
    },
}

/// The error as compilers write it: `path:line: …`.
fn in_file(name: &str, error: &Malformed) -> String {
    let sentence = error.sentence();
    match error.place {
        Place::Line(line) => format!("{name}:{line}: {sentence}"),
        place @ (Place::Byte(_) | Place::Item(..)) => format!("{name}: {place}: {sentence}"),
    }
}

/// So many bytes are foreseen for each byte of a file: itself, and a mesh that is at most three times as large, as that of short
/// numbers is. (Corners of large polygons may take six; files of such alone are small.)
pub const MEMORY_PER_BYTE: u64 = 4;

/// Loads the mesh file at `path`, or the part of one that a name such as `a.obj#red` means.
///
/// `progress` advances by bytes, each once when it is read and once when it is understood; setting its total is the
/// caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, is malformed, or has no such part.
pub fn load_mesh(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    let name = path.to_string_lossy();
    let (file, part) = file_and_part(&name);
    let file_path = if part.is_some() {
        Path::new(file)
    } else {
        path
    };
    let Some(source) = load_source(file_path, cancel, progress)? else {
        return Ok(None);
    };
    let Some(part) = part else {
        return source.into_whole(file).map(Some);
    };
    let mesh = source.taker().take(file, part)?;
    Ok(Some(MeshFile {
        mesh: Arc::unwrap_or_clone(mesh),
        format: match &source {
            MeshSource::Mesh(file) => file.format,
            MeshSource::Scene(_) => GLTF,
        },
        warnings: source.warnings().to_vec(),
        ..MeshFile::default()
    }))
}

/// Loads a file of meshes, which has all its parts.
///
/// # Errors
/// Those of [`load_mesh`].
pub fn load_source(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshSource>, MeshError> {
    let name = path.display().to_string();
    let bytes = require_memory(path, MEMORY_PER_BYTE)
        .and_then(|()| read_file(path, "a mesh file", cancel, progress));
    let unreadable = |reason| MeshError::Unreadable {
        name: name.clone(),
        reason,
    };
    let Some(bytes) = bytes.map_err(unreadable)? else {
        return Ok(None);
    };
    if gltf::has_keyword(&bytes) {
        let read = mesh_source::read_gltf(path, &bytes, cancel, progress)?;
        return Ok(read.map(|gltf| MeshSource::Scene(Box::new(gltf))));
    }
    let file = read_mesh(&name, &bytes, cancel, progress)?;
    Ok(file.map(|file| MeshSource::Mesh(Box::new(file))))
}

/// The mesh in `bytes`, which are those of a whole file; `name` stands for the path in messages, and its extension counts.
///
/// `progress` advances by the bytes understood; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the bytes are of a format without reader, or malformed.
pub fn parse_mesh(
    name: &str,
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    read_mesh(name, bytes, cancel, progress)
}

fn read_mesh(
    name: &str,
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    if bytes.is_empty() {
        return Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason: "the file is empty".to_owned(),
        });
    }
    let format = MeshFormat::recognise(name, bytes).map_err(|what| MeshError::UnknownFormat {
        name: name.to_owned(),
        what,
    })?;
    let parsed = format.parse(bytes, cancel, progress);
    parsed.map_err(|error| MeshError::Malformed {
        name: name.to_owned(),
        error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use tempfile::TempDir;

    const TRIANGLE: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

    /// A folder with one file in it, and the file's path.
    fn file(name: &str, bytes: impl AsRef<[u8]>) -> (TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("written");
        (folder, path)
    }

    fn load(path: &Path) -> Result<MeshFile, MeshError> {
        let loaded = load_mesh(path, &CancelToken::new(), &Progress::new())?;
        Ok(loaded.expect("nobody cancelled"))
    }

    /// What a user reads about a file with this name and content, after its folder.
    fn message(name: &str, bytes: impl AsRef<[u8]>) -> String {
        let (folder, path) = file(name, bytes);
        let error = load(&path).expect_err("not a mesh").to_string();
        let folder = format!("{}/", folder.path().display());
        error
            .strip_prefix(&folder)
            .expect("the path comes first")
            .to_owned()
    }

    #[test]
    fn a_mesh_is_known_by_content_and_then_by_extension() {
        for name in ["a.off", "a.OFF", "a.obj", "a"] {
            let (_folder, path) = file(name, TRIANGLE);
            let loaded = load(&path).expect("an OFF file");
            assert_eq!((loaded.format, loaded.faces), ("OFF", 1), "{name}");
        }
        let without_keyword = TRIANGLE.trim_start_matches("OFF\n");
        let (_folder, path) = file("a.off", without_keyword);
        assert_eq!(
            load(&path).expect("an OFF file").mesh.triangles,
            [[0, 1, 2]]
        );
        assert_eq!(
            message("a.txt", without_keyword),
            format!(
                "a.txt: files with the extension .txt are not read; RayMini reads {READABLE_FORMATS}"
            )
        );
    }

    #[test]
    fn what_cannot_be_read_is_said_in_plain_words() {
        assert_eq!(message("a.off", ""), "a.off: the file is empty");
        assert_eq!(
            message("a.step", "ISO-10303-21;\n"),
            format!(
                "a.step: files with the extension .step are not read; RayMini reads {READABLE_FORMATS}"
            )
        );
        for (name, text, begins) in [
            (
                "a.glb",
                "xlTF\u{2}",
                "binary glTF begins with \"glTF\", this file with \"xlTF\"",
            ),
            (
                "a.GLB",
                "\u{0}\n",
                "binary glTF begins with \"glTF\", this file with \"\\x00\\n\"",
            ),
            (
                "a.gltf",
                "<html>",
                "the text of glTF begins with \"{\", this file with \"<htm\"",
            ),
        ] {
            let expected = format!(
                "{name}: this is not glTF, or it is damaged: {begins}; RayMini reads {READABLE_FORMATS}"
            );
            assert_eq!(message(name, text), expected);
        }
        assert_eq!(
            message("a.off", "glTF"),
            "a.off: byte 4: expected four bytes, found the end of the file"
        );
        assert_eq!(
            message("a.obj", b"\xff\xfev\0 \0"),
            format!(
                "a.obj: this is a file of the format UTF-16, where UTF-8 is read; RayMini reads {READABLE_FORMATS}"
            )
        );
        assert_eq!(
            message("a", "\0\0"),
            format!("a: this is not a mesh of a known format; RayMini reads {READABLE_FORMATS}")
        );
        assert_eq!(
            message("ram.off", TRIANGLE.replace("3 0 1 2", "3 0 1 9")),
            "ram.off:6: expected a vertex index below 3, found \"9\""
        );
        assert_eq!(
            message("x.off", "<html>\n"),
            "x.off:1: expected OFF (or COFF, NOFF, STOFF, 4OFF) or the numbers of vertices and faces, found \"<html>\""
        );
    }

    #[test]
    fn missing_files_and_folders_are_said_in_plain_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let missing = folder.path().join("ram.off");
        let error = load(&missing).expect_err("no file").to_string();
        assert_eq!(
            error,
            format!("{}: there is no such file", missing.display())
        );
        let error = load(folder.path()).expect_err("a folder").to_string();
        let expected = format!(
            "{}: this is a folder, a mesh file was expected",
            folder.path().display()
        );
        assert_eq!(error, expected);
        let error = load(&folder.path().join("a\0b"))
            .expect_err("no name")
            .to_string();
        assert!(error.contains("the file cannot be read"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_before_they_are_read() {
        let error = load(Path::new("/dev/zero"))
            .expect_err("endless")
            .to_string();
        assert_eq!(
            error,
            "/dev/zero: this is not a regular file, a mesh file was expected"
        );
    }

    #[test]
    fn embedded_bytes_are_read_under_their_name() {
        let (cancel, progress) = (CancelToken::new(), Progress::new());
        let parsed = parse_mesh("builtin:ram", TRIANGLE.as_bytes(), &cancel, &progress);
        assert!(parsed.expect("an OFF file").is_some());
        assert_eq!(progress.done(), 36);
        let error = parse_mesh("builtin:ram", b"OFF\n1\n", &cancel, &progress).expect_err("short");
        assert_eq!(
            error.to_string(),
            "builtin:ram:2: expected the number of faces, found the end of the file"
        );
    }

    #[test]
    fn progress_counts_reading_and_understanding_and_cancel_stops_both() {
        let (_folder, path) = file("a.off", TRIANGLE);
        let (cancel, progress) = (CancelToken::new(), Progress::new());
        load_mesh(&path, &cancel, &progress)
            .expect("an OFF file")
            .expect("not cancelled");
        assert_eq!(progress.done(), 72);
        cancel.cancel();
        assert!(
            load_mesh(&path, &cancel, &progress)
                .expect("no error")
                .is_none()
        );
    }
}
