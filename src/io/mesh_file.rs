//! Mesh files of any format: finding the reader, reading the bytes, and saying what went wrong where.
//!
//! A reader takes bytes and knows no path; this module adds the path to its errors.

use super::off;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
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
    /// The bytes could not be read.
    #[error("{name}: {reason}")]
    Unreadable {
        /// The file, as it was asked for.
        name: String,
        /// A plain sentence.
        reason: String,
        /// What the system said, where it was asked.
        source: Option<io::Error>,
    },
    /// The bytes are of a format that has no reader.
    #[error("{name}: {what}; RayMini reads {READABLE_FORMATS}")]
    UnknownFormat {
        /// The file, as it was asked for.
        name: String,
        /// What the file seems to be.
        what: String,
    },
    /// The text breaks the rules of its format.
    #[error("{name}:{line}: {message}")]
    Malformed {
        /// The file, as it was asked for.
        name: String,
        /// The line, counted from 1.
        line: u64,
        /// What was expected there and what was found.
        message: String,
    },
}

/// The formats that have a reader, for messages and file dialogs.
pub const READABLE_FORMATS: &str = "OFF";

/// File name extensions, in lower case, of the formats that have a reader.
pub const READABLE_EXTENSIONS: &[&str] = &["off"];

/// Loads the mesh file at `path`.
///
/// `progress` advances by bytes, each once when it is read and once when it is understood; setting its total is the
/// caller's. Returns `None` when cancelled.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, or is malformed.
pub fn load_mesh(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, MeshError> {
    let name = path.display().to_string();
    let Some(bytes) = read_file(path, &name, cancel, progress)? else {
        return Ok(None);
    };
    read_mesh(&name, &bytes, cancel, progress)
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
    match recognise(name, bytes) {
        Ok(Format::Off) => {
            off::parse(bytes, cancel, progress).map_err(|error| MeshError::Malformed {
                name: name.to_owned(),
                line: error.line,
                message: error.sentence(),
            })
        }
        Err(what) => Err(MeshError::UnknownFormat {
            name: name.to_owned(),
            what,
        }),
    }
}

/// The formats that have a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Off,
}

/// The format of a file: what its content says, and where that says nothing (an OFF file may begin with its counts) the
/// extension of its name. The error says what it seems to be.
fn recognise(name: &str, bytes: &[u8]) -> Result<Format, String> {
    if bytes.is_empty() {
        return Err("the file is empty".to_owned());
    }
    if off::has_keyword(bytes) {
        return Ok(Format::Off);
    }
    if let Some(format) = known_by_content(bytes) {
        return Err(format!("this is a file of the format {format}"));
    }
    let extension = Path::new(name).extension().unwrap_or_default();
    match extension.to_ascii_lowercase().to_str() {
        Some("off") => Ok(Format::Off),
        Some("") | None => Err("this is not a mesh of a known format".to_owned()),
        Some(extension) => Err(format!(
            "files with the extension .{extension} are not read"
        )),
    }
}

/// The format, known but without reader, whose first bytes these are.
fn known_by_content(bytes: &[u8]) -> Option<&'static str> {
    let formats: [(&[u8], &str); 6] = [
        (b"ply", "PLY"),
        (b"solid ", "STL"),
        (b"glTF", "glTF"),
        (b"MeshVersionFormatted", "Medit mesh"),
        (b"$MeshFormat", "Gmsh mesh"),
        (b"\x89PNG", "PNG"),
    ];
    let starts = |(magic, _): &&(&[u8], &str)| bytes.starts_with(magic);
    formats.iter().find(starts).map(|(_, format)| *format)
}

/// All bytes of a regular file, read in pieces so that cancelling answers; `None` when cancelled.
fn read_file(
    path: &Path,
    name: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Vec<u8>>, MeshError> {
    const PIECE: u64 = 1 << 20;
    let failed = |error| unreadable(name, error);
    // Asked before opening: opening a pipe waits for a writer.
    let kind = std::fs::metadata(path).map_err(failed)?;
    if !kind.is_file() {
        let what = if kind.is_dir() {
            "a folder"
        } else {
            "not a regular file"
        };
        return Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason: format!("this is {what}, a mesh file was expected"),
            source: None,
        });
    }
    let mut file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    while !cancel.is_cancelled() {
        match file.by_ref().take(PIECE).read_to_end(&mut bytes) {
            Ok(0) => return Ok(Some(bytes)),
            Ok(count) => progress.advance(count as u64),
            Err(error) => return Err(failed(error)),
        }
    }
    Ok(None)
}

fn unreadable(name: &str, error: io::Error) -> MeshError {
    let reason = match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "you are not allowed to read this file".to_owned(),
        _ => format!("the file cannot be read: {error}"),
    };
    MeshError::Unreadable {
        name: name.to_owned(),
        reason,
        source: Some(error),
    }
}
