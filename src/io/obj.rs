//! OBJ, the object file format of Wavefront: text, one statement per line.
//!
//! ```text
//! # a square
//! v 0 0 0
//! v 1 0 0
//! v 1 1 0
//! v 0 1 0
//! vn 0 0 1
//! vt 0 0                      # right and up on an image, each from 0 to 1; a third number means nothing
//! f 1/1/1 2/1/1 3/1/1 4/1/1   # or 1, 1/2 or 1//2: vertex, texture coordinate, normal
//! ```
//!
//! - Numbers count from 1, or from −1 back from the last one so far. A face may name vertices that come later.
//! - What follows the three coordinates of a vertex is a weight (one number), which means nothing for faces, or a colour: red,
//!   green and blue, perhaps an alpha, which means nothing. Colours are sRGB from 0 to 1, or to 255 where one exceeds 1.5. In a file
//!   with colours, vertices without are white.
//! - Faces may have any number of corners. Lines (`l`) and points (`p`) are skipped and counted.
//! - Where every corner names a normal, the mesh has them; a vertex becomes several only where its normals differ. Where only some
//!   do, none is used, with a warning. Normals that are not finite are left to the faces around.
//! - Where a corner names a texture coordinate, the mesh has them, and vertices are split likewise; corners without one, or with
//!   one that is not there or not finite, have (0, 0), with a warning.
//! - A `\` at the end of a line joins the next one to it.
//! - `usemtl` begins the faces of a material: they are a part of the file. `mtllib` names files of materials; the name is kept, see
//!   [`super::mtl`].
//! - Objects, groups and smoothing groups mean nothing here. Statements nobody knows, such as those of free-form curves, are ignored
//!   with a warning; a text of such alone is no OBJ file.
//!
//! Source: Wavefront, Advanced Visualizer Manual, appendix B1, 1993.

mod corner;
mod lists;
mod write;

#[cfg(test)]
mod tests;

pub use write::{write, write_parts};

use super::mesh_file::{MaterialLibrary, MeshFile};
use super::mesh_parts::PartsInOrder;
use super::mesh_reading::{
    Colors, Cursor, Malformed, Place, Seen, Tally, TooMany, Watch, number, numbers,
};
use super::mtl;
use crate::control::{CancelToken, Progress};
use crate::math::{DVec2, DVec3};
use corner::{Corner, Counts, Word};
use lists::Lists;

/// Most files of materials that are looked for.
const MOST_LIBRARIES: usize = 100;

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
        colors: Colors::default(),
        normals: Vec::new(),
        textures: Vec::new(),
        triangles: Vec::new(),
        corners: Vec::new(),
        early: EarlyFaces::default(),
        parts: PartsInOrder::default(),
        material: None,
        libraries: Vec::new(),
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
    textures_not_finite: Seen,
    with_textures: Seen,
    without_textures: Seen,
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
    faces: Vec<EarlyFace>,
    corners: Vec<Corner>,
}

#[derive(Clone, Copy, Debug)]
struct EarlyFace {
    line: u64,
    /// The end of its corners among all.
    end: usize,
    /// The number of its part, if it is of one.
    material: Option<u32>,
}

/// The place in the text, and what stands before it.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    positions: Vec<DVec3>,
    colors: Colors,
    normals: Vec<DVec3>,
    textures: Vec<DVec2>,
    triangles: Vec<[Corner; 3]>,
    /// The corners of the face at hand.
    corners: Vec<Corner>,
    early: EarlyFaces,
    parts: PartsInOrder<'a>,
    /// The number of the part that faces are of at present.
    material: Option<u32>,
    libraries: Vec<MaterialLibrary>,
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
                b"vt" => self.texture(line)?,
                b"l" | b"p" => self.notes.lines_and_points.at(place),
                b"usemtl" => self.material(),
                b"mtllib" => self.library(line),
                b"o" | b"g" | b"s" => {}
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
        let (mut more, mut rest) = (0, DVec3::ZERO);
        while let Some(word) = self.word() {
            let Some(value) = number(word) else {
                return Err(Malformed::at_token(line, "a number", word));
            };
            if let Some(channel) = AsMut::<[f64; 3]>::as_mut(&mut rest).get_mut(more) {
                *channel = value;
            }
            more += 1;
        }
        match more {
            0 | 1 => {}
            3 | 4 => self.colors.push(self.positions.len(), rest),
            _ => self.notes.colors.at(Place::Line(line)),
        }
        Ok(())
    }

    fn texture(&mut self, line: u64) -> Result<(), Malformed> {
        let place = Place::Line(line);
        let mut coordinate = DVec2::ZERO;
        let Some(first) = self.word() else {
            return Err(Malformed::in_line(line, "1 to 3 numbers", "0 numbers"));
        };
        // The second is left out where images are of one dimension; the third, of three, means nothing here.
        let words = [Some(first), self.word()];
        for (axis, word) in words.into_iter().enumerate() {
            if let Some(word) = word {
                coordinate[axis] =
                    number(word).ok_or_else(|| Malformed::at_token(line, "a number", word))?;
            }
        }
        self.notes.textures.at(place);
        if !coordinate.is_finite() {
            self.notes.textures_not_finite.at(place);
            coordinate = DVec2::ZERO;
        }
        self.textures.push(coordinate);
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

    /// The faces that follow are of another material.
    fn material(&mut self) {
        let name = mtl::name_in(self.cursor.rest_of_line());
        let number = self.parts.number(name);
        self.material = Some(number);
        self.parts.go_on(self.triangles.len(), number);
    }

    fn library(&mut self, line: u64) {
        let name = mtl::name_in(self.cursor.rest_of_line());
        let name = String::from_utf8_lossy(name).into_owned();
        let is_new = !name.is_empty() && self.libraries.iter().all(|known| known.name != name);
        if is_new && self.libraries.len() < MOST_LIBRARIES {
            self.libraries.push(MaterialLibrary { line, name });
        }
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

    fn counts(&self) -> Counts {
        Counts {
            positions: self.positions.len(),
            normals: self.normals.len(),
            textures: self.textures.len(),
        }
    }

    fn face(&mut self, line: u64) -> Result<(), Malformed> {
        self.corners.clear();
        let mut is_early = false;
        while let Some(word) = self.word() {
            let word = Word { line, word };
            let corner = Corner::read(word, self.counts())?;
            is_early |= corner.is_beyond(self.positions.len(), self.normals.len());
            self.corners.push(corner);
        }
        if is_early {
            self.early.corners.append(&mut self.corners);
            self.early.faces.push(EarlyFace {
                line,
                end: self.early.corners.len(),
                material: self.material,
            });
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
        if self.corners.iter().any(|corner| corner.texture().is_none()) {
            self.notes.without_textures.at(place);
        } else if !self.corners.is_empty() {
            self.notes.with_textures.at(place);
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
        for (index, face) in (0..).zip(early.faces) {
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            let EarlyFace {
                line,
                end,
                material,
            } = face;
            let material = material.unwrap_or_else(|| self.parts.number(b""));
            self.parts.go_on(self.triangles.len(), material);
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

    /// The mesh, with normals if all faces have them, and texture coordinates if any has; `None` when cancelled.
    fn finish(mut self) -> Result<Option<MeshFile>, Malformed> {
        let end = self.cursor.position();
        let notes = &self.notes;
        let some_have = notes.with_normals.count > 0;
        let has_triangles = !self.triangles.is_empty();
        let all_have = some_have && notes.without_normals.count == 0 && has_triangles;
        let are_mapped =
            notes.with_textures.count > 0 && !self.textures.is_empty() && has_triangles;
        let is_missing = |corner: &&Corner| {
            let textures = self.textures.len();
            corner
                .texture()
                .is_some_and(|index| index as usize >= textures)
        };
        let missing = if are_mapped {
            self.triangles.iter().flatten().filter(is_missing).count()
        } else {
            0
        };
        let mesh = Lists {
            colors: self.colors.into_linear(self.positions.len()),
            positions: self.positions,
            normals: all_have.then_some(self.normals),
            texture_coordinates: are_mapped.then_some(self.textures),
        };
        let (watch, last_line) = (&mut self.watch, self.cursor.line());
        let mesh = mesh.into_mesh(&self.triangles, |index| watch.report_item(index, end));
        let mesh = mesh.map_err(|TooMany| {
            Malformed::in_line(last_line, "fewer than 2^32 vertices", "another")
        })?;
        let Some(mesh) = mesh else {
            return Ok(None);
        };
        // Cancelling comes too late here: the work is done.
        let _ = self.watch.report(end);
        let partly = |seen: &Seen| {
            seen.counted(
                "face has no normals, so those of all are ignored",
                "faces have no normals, so those of all are ignored",
            )
        };
        let unmapped = notes.without_textures.counted(
            "face has no texture coordinates; they are taken as (0, 0)",
            "faces have no texture coordinates; they are taken as (0, 0)",
        );
        let unused = "texture coordinates are ignored, as no face has them at all its corners";
        let absent = format!(
            "corners name texture coordinates that are not there, {missing} in all; they are taken as (0, 0)"
        );
        let warnings = [
            notes.normals_not_finite.counted(
                "normal that is not finite is ignored",
                "normals that are not finite are ignored",
            ),
            some_have.then(|| partly(&notes.without_normals)).flatten(),
            notes.colors.found("colours are ignored"),
            notes.textures_not_finite.counted(
                "texture coordinate that is not finite is taken as (0, 0)",
                "texture coordinates that are not finite are taken as (0, 0)",
            ),
            unmapped.filter(|_| are_mapped),
            notes.textures.found(unused).filter(|_| !are_mapped),
            (missing > 0).then_some(absent),
            notes
                .lines_and_points
                .counted("line or point is ignored", "lines and points are ignored"),
            notes.unknown.counted(
                "statement of another kind is ignored",
                "statements of other kinds are ignored",
            ),
        ];
        let warnings = warnings.into_iter().flatten();
        let file = self.tally.into_file("OBJ", mesh, warnings);
        Ok(Some(MeshFile {
            parts: self.parts.into_parts(file.mesh.triangles.len()),
            libraries: self.libraries,
            ..file
        }))
    }
}
