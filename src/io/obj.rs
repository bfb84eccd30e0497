//! OBJ, the object file format of Wavefront: text, one statement per line.
//!
//! ```text
//! # a square
//! v 0 0 0
//! v 1 0 0
//! v 1 1 0
//! v 0 1 0
//! vn 0 0 1
//! f 1//1 2//1 3//1 4//1      # or 1, 1/2 or 1/2/1: vertex, texture coordinate, normal
//! ```
//!
//! - Numbers count from 1, or from −1 back from the last one so far. A face may name vertices that come later.
//! - What follows the three coordinates of a vertex is a weight (one number), which means nothing for faces, or a colour.
//! - Faces may have any number of corners. Lines (`l`) and points (`p`) are skipped and counted.
//! - Where every corner names a normal, the mesh has them; a vertex becomes several only where its normals differ. Where only some
//!   do, none is used, with a warning. Normals that are not finite are left to the faces around.
//! - A `\` at the end of a line joins the next one to it.
//! - Objects, groups and smoothing groups mean nothing here. Colours, texture coordinates and materials are ignored with a warning,
//!   as are statements nobody knows, such as those of free-form curves; a text of such alone is no OBJ file.
//!
//! Source: Wavefront, Advanced Visualizer Manual, appendix B1, 1993.

mod corner;
mod split;
mod write;

#[cfg(test)]
mod tests;

pub use write::write;

use super::mesh_file::MeshFile;
use super::mesh_reading::{Cursor, Malformed, Place, Seen, Tally, Watch, number, numbers};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::DVec3;
use corner::{Corner, Word};

/// Whether the text begins as OBJ files do.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    let first = cursor.find_word().then(|| cursor.word()).flatten();
    matches!(
        first,
        Some(b"v" | b"vn" | b"vt" | b"o" | b"g" | b"mtllib" | b"usemtl")
    )
}

/// Reads an OBJ file from its bytes.
///
/// `progress` advances by the bytes read; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// The first line that breaks the rules above.
pub fn parse(
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, Malformed> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes),
        watch: Watch::new(cancel, progress),
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
        corners: Vec::new(),
        early: EarlyFaces::default(),
        tally: Tally::default(),
        notes: Notes::default(),
    };
    if reader.statements()?.is_none() || reader.early_faces()?.is_none() {
        return Ok(None);
    }
    reader.finish()
}

/// What the file holds and the mesh will not.
#[derive(Debug, Default)]
struct Notes<'a> {
    colors: Seen,
    textures: Seen,
    materials: Seen,
    lines_and_points: Seen,
    normals_not_finite: Seen,
    with_normals: Seen,
    without_normals: Seen,
    unknown: Seen,
    /// The first statement nobody knows: its line and its word.
    first_unknown: Option<(u64, &'a [u8])>,
}

/// Faces with vertices or normals that come after them.
#[derive(Debug, Default)]
struct EarlyFaces {
    /// The line of each, and the end of its corners among all.
    faces: Vec<(u64, usize)>,
    corners: Vec<Corner>,
}

/// The place in the text, and what stands before it.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Vec<[Corner; 3]>,
    /// Those of the face at hand.
    corners: Vec<Corner>,
    early: EarlyFaces,
    tally: Tally,
    notes: Notes<'a>,
}

impl<'a> Reader<'a> {
    /// Reads all statements; `None` when cancelled.
    fn statements(&mut self) -> Result<Option<()>, Malformed> {
        let mut index = 0;
        while self.cursor.find_word() {
            let position = self.cursor.position();
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            index += 1;
            let line = self.cursor.line();
            let place = Place::Line(line);
            match self.cursor.word().unwrap_or_default() {
                b"v" => {
                    self.vertex(line)?;
                    continue;
                }
                b"f" | b"fo" => {
                    self.face(line)?;
                    continue;
                }
                b"vn" => self.normal(line)?,
                b"vt" => self.notes.textures.at(place),
                b"l" | b"p" => self.notes.lines_and_points.at(place),
                b"usemtl" => self.notes.materials.at(place),
                b"o" | b"g" | b"s" | b"mtllib" => {}
                word => {
                    self.notes.unknown.at(place);
                    self.notes.first_unknown.get_or_insert((line, word));
                }
            }
            self.skip_statement();
        }
        match self.notes.first_unknown {
            Some((line, word)) if self.positions.is_empty() && self.tally.faces == 0 => {
                let expected = "v, vn, vt, f or another keyword of OBJ";
                Err(Malformed::at_token(line, expected, word))
            }
            _ => Ok(Some(())),
        }
    }

    /// The next word of this statement.
    fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            let word = self.cursor.word()?;
            let Some((b'\\', before)) = word.split_last() else {
                return Some(word);
            };
            if self.cursor.line_has_word() {
                return Some(word);
            }
            self.cursor.leave_line();
            if !before.is_empty() {
                return Some(before);
            }
        }
    }

    fn skip_statement(&mut self) {
        loop {
            let rest = self.cursor.rest_of_line();
            if !rest.ends_with(b"\\") || rest.contains(&b'#') || !self.cursor.leave_line() {
                return;
            }
        }
    }

    fn vertex(&mut self, line: u64) -> Result<(), Malformed> {
        let position = self.vector(line)?;
        if !position.is_finite() {
            let found = format!("({}, {}, {})", position.x, position.y, position.z);
            return Err(Malformed::in_line(line, "finite coordinates", found));
        }
        self.positions.push(position);
        let mut more = 0;
        while let Some(word) = self.word() {
            if number(word).is_none() {
                return Err(Malformed::at_token(line, "a number", word));
            }
            more += 1;
        }
        if more > 1 {
            self.notes.colors.at(Place::Line(line));
        }
        Ok(())
    }

    fn normal(&mut self, line: u64) -> Result<(), Malformed> {
        let mut normal = self.vector(line)?;
        if !normal.is_finite() {
            self.notes.normals_not_finite.at(Place::Line(line));
            normal = DVec3::ZERO;
        }
        self.normals.push(normal);
        Ok(())
    }

    /// Reads three numbers of the statement that begins on `line`.
    fn vector(&mut self, line: u64) -> Result<DVec3, Malformed> {
        let mut vector = DVec3::ZERO;
        for axis in 0..3 {
            let Some(word) = self.word() else {
                return Err(Malformed::in_line(
                    line,
                    "3 numbers",
                    numbers(axis, "number"),
                ));
            };
            vector[axis] =
                number(word).ok_or_else(|| Malformed::at_token(line, "a number", word))?;
        }
        Ok(vector)
    }

    fn face(&mut self, line: u64) -> Result<(), Malformed> {
        self.corners.clear();
        let mut is_early = false;
        while let Some(word) = self.word() {
            let word = Word { line, word };
            let corner = Corner::read(word, self.positions.len(), self.normals.len())?;
            is_early |= corner.is_beyond(self.positions.len(), self.normals.len());
            self.corners.push(corner);
        }
        if is_early {
            self.early.corners.append(&mut self.corners);
            self.early.faces.push((line, self.early.corners.len()));
        } else {
            self.add_face(line);
        }
        Ok(())
    }

    /// Adds the face of the corners at hand.
    fn add_face(&mut self, line: u64) {
        let place = Place::Line(line);
        if self.corners.iter().any(|corner| corner.normal().is_none()) {
            self.notes.without_normals.at(place);
        } else if !self.corners.is_empty() {
            self.notes.with_normals.at(place);
        }
        self.tally.add_face(
            place,
            &mut self.corners,
            &self.positions,
            &mut self.triangles,
        );
    }

    /// Adds the faces whose vertices came later; `None` when cancelled.
    fn early_faces(&mut self) -> Result<Option<()>, Malformed> {
        let early = std::mem::take(&mut self.early);
        let position = self.cursor.position();
        let mut start = 0;
        for (index, (line, end)) in (0..).zip(early.faces) {
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            self.corners.clear();
            for corner in &early.corners[start..end] {
                corner.check(line, self.positions.len(), self.normals.len())?;
                self.corners.push(*corner);
            }
            self.add_face(line);
            start = end;
        }
        Ok(Some(()))
    }

    /// The mesh, with normals if all faces have them; `None` when cancelled.
    fn finish(mut self) -> Result<Option<MeshFile>, Malformed> {
        let end = self.cursor.position();
        let notes = &self.notes;
        let some_have = notes.with_normals.count > 0;
        let all_have = some_have && notes.without_normals.count == 0;
        let mesh = if all_have && !self.triangles.is_empty() {
            let (watch, last_line) = (&mut self.watch, self.cursor.line());
            let split = split::by_normals(
                self.positions,
                &self.normals,
                &self.triangles,
                last_line,
                |index| watch.report_item(index, end),
            )?;
            let Some(mesh) = split else {
                return Ok(None);
            };
            mesh
        } else {
            let plain = |triangle: &[Corner; 3]| triangle.map(|corner| corner.position);
            TriangleMesh {
                positions: self.positions,
                triangles: self.triangles.iter().map(plain).collect(),
                normals: None,
            }
        };
        // Cancelling comes too late here: the work is done.
        let _ = self.watch.report(end);
        let partly = |seen: &Seen| {
            seen.counted(
                "face has no normals, so those of all are ignored",
                "faces have no normals, so those of all are ignored",
            )
        };
        let warnings = [
            notes.normals_not_finite.counted(
                "normal that is not finite is ignored",
                "normals that are not finite are ignored",
            ),
            some_have.then(|| partly(&notes.without_normals)).flatten(),
            notes.colors.found("colours are ignored"),
            notes.textures.found("texture coordinates are ignored"),
            notes.materials.found("materials are ignored"),
            notes
                .lines_and_points
                .counted("line or point is ignored", "lines and points are ignored"),
            notes.unknown.counted(
                "statement of another kind is ignored",
                "statements of other kinds are ignored",
            ),
        ];
        let warnings = warnings.into_iter().flatten();
        Ok(Some(self.tally.into_file("OBJ", mesh, warnings)))
    }
}
