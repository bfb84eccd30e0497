//! OFF, the Object File Format of Geomview: `[ST][C][N][4][n]OFF`, text.
//!
//! ```text
//! OFF            # keyword, may be missing
//! 4 2 0          # vertices, faces, and edges, which nobody counts and may be missing
//! 0 0 0          # vertices
//! 1 0 0
//! 1 1 0
//! 0 1 0
//! 3 0 1 2        # faces: number of corners, indices from 0, perhaps a colour
//! 3 0 2 3
//! ```
//!
//! The format is a stream of numbers in which line breaks matter only after a face, where a colour may follow. Files in
//! the wild keep one vertex or face per line and put colours after vertices too. The rules here read both:
//!
//! - A vertex or a face that finds too few numbers on its line goes on with the next lines; nothing may then follow it on
//!   its last line. (If something does, the first line was simply short, and is reported.)
//! - Numbers left on a face's line are a colour: none to four.
//! - Numbers left on a vertex's line are a colour if they are at most four; more are further vertices, which must all be
//!   whole. Under `COFF`, `STOFF` and their like each vertex stands on a line of its own, with a colour of one, three
//!   or four numbers and a texture coordinate of two, as the keyword says. Normals come before colours, but behind them under `NCOFF`.
//! - Colours are sRGB, and go to 255 where a number of any is more than 1.5, else to 1; the fourth number means nothing. Those of
//!   faces count where vertices have none: a vertex becomes several where its faces differ. Without colour among some is white.
//! - The counts stand on one line, also that of the keyword, also glued to it (`OFF8 6 0`); alone on its line the first
//!   count may be followed by both others on lines of their own.
//! - Letters of the keyword may be small, except that `N` (normals) and `n` (dimension) differ, and stand in any order. `nOFF` is read
//!   if its dimension is 3; `4nOFF` and `OFF BINARY` are refused. `4OFF` is divided by its fourth coordinate; with a fourth count, that
//!   of the cells of a polytope in four dimensions, it is refused.
//! - Numbers after the last declared face are an error, since a count is wrong then; other text there is a warning.
//!
//! Tetrahedra are written in two ways: as faces of four corners each, which is told by how they meet; and, without keyword and number of
//! edges, as four indices alone on each line, behind vertices with a fourth number, a value that means nothing here. The faces that
//! belong to one of them alone are shown, and the part `inner` has all.
//!
//! Colours of one or two numbers, which name one of a list that is elsewhere, are ignored, with a warning. Faces of fewer than three
//! corners or without area are dropped and counted. A polygon's repeated corner is taken once; its larger remainder
//! is cut into triangles, of which those without area are left out. Counts are never trusted: memory grows with the text.
//!
//! Source: Geomview manual, section on OFF; the order of `NCOFF` as `MeshLab` writes it; tetrahedra as the Topology Toolkit (faces of
//! four corners) and programs for volumes (four indices alone) read them.

mod finish;
mod header;
mod write;

#[cfg(test)]
mod tests;

pub use write::write;

use super::mesh_file::MeshFile;
use super::mesh_reading::{
    Colors, Cursor, Malformed, Place, Seen, Tally, Watch, capacity, number, numbers, whole,
};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::{DVec2, DVec3};
use header::{Header, Keyword, expect_end_of_line};

/// Reads an OFF file from its bytes.
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
    let mut reader = Reader::new(bytes, cancel, progress);
    let header = Header::read(&mut reader.cursor)?;
    if reader.vertices(&header)?.is_none() {
        return Ok(None);
    }
    let read = if header.is_bare && reader.has_cells_ahead(&header) {
        reader.cells(&header)?
    } else {
        reader.faces(&header)?
    };
    if read.is_none() {
        return Ok(None);
    }
    reader.end(&header)?;
    reader.finish()
}

/// Whether the text begins as an OFF file with keyword does.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    let first = cursor.find_word().then(|| cursor.word()).flatten();
    first.and_then(Keyword::of).is_some()
}

/// What the file holds and the mesh will not.
#[derive(Debug, Default)]
struct Notes {
    colors: Seen,
    face_colors: Seen,
    textures_not_finite: Seen,
    trailing: Seen,
}

/// The parser: a place in the text and the mesh read so far.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    notes: Notes,
    mesh: TriangleMesh,
    vertex_colors: Colors,
    /// Of the triangles.
    face_colors: Colors,
    tally: Tally,
    /// Vertices with one number behind them.
    values: u64,
    /// The corners of all faces, as long as each has four and no colour.
    fours: Option<Vec<[u32; 4]>>,
    /// Whether these are tetrahedra.
    are_cells: bool,
    /// The first of the faces.
    first_face: Option<Place>,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], cancel: &'a CancelToken, progress: &'a Progress) -> Self {
        Self {
            cursor: Cursor::new(bytes),
            watch: Watch::new(cancel, progress),
            notes: Notes::default(),
            mesh: TriangleMesh::default(),
            vertex_colors: Colors::default(),
            face_colors: Colors::default(),
            tally: Tally::default(),
            values: 0,
            fours: Some(Vec::new()),
            are_cells: false,
            first_face: None,
        }
    }

    /// Reads all vertices; `None` when cancelled.
    fn vertices(&mut self, header: &Header) -> Result<Option<()>, Malformed> {
        let shortest = 2 * header.numbers_per_vertex();
        let capacity = capacity(header.vertices, self.cursor.remaining() / shortest);
        self.mesh.positions.reserve_exact(capacity);
        if header.keyword.normal {
            self.mesh.normals = Some(Vec::with_capacity(capacity));
        }
        if header.keyword.texture {
            self.mesh.texture_coordinates = Some(Vec::with_capacity(capacity));
        }
        // The line that holds several vertices, once there is one.
        let mut shared_line = 0;
        for index in 0..header.vertices {
            let position = self.cursor.position();
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            self.vertex(header, index, &mut shared_line)?;
        }
        expect_end_of_line(
            &mut self.cursor,
            "the end of the line after the last vertex",
        )?;
        Ok(Some(()))
    }

    /// Reads one vertex and what stands behind it.
    fn vertex(
        &mut self,
        header: &Header,
        index: u64,
        shared_line: &mut u64,
    ) -> Result<(), Malformed> {
        if !self.cursor.find_word() {
            let expected = format!("vertex {} of {}", index + 1, header.vertices);
            return Err(self.cursor.at_end(expected));
        }
        let line = self.cursor.line();
        let mut values = [0.0; 7];
        let values = &mut values[..header.numbers_per_vertex()];
        let mut on_first_line = None;
        for (read, value) in values.iter_mut().enumerate() {
            if !self.cursor.line_has_word() {
                on_first_line.get_or_insert(read);
            }
            if !self.cursor.find_word() {
                let read = on_first_line.unwrap_or(read);
                return Err(short_vertex(line, header, index, read));
            }
            *value = self.coordinate()?;
        }
        self.add_vertex(header, values)?;
        match on_first_line {
            Some(read) if self.cursor.line_has_word() => {
                return Err(short_vertex(line, header, index, read));
            }
            _ => {}
        }
        let is_declared = header.keyword.color || header.keyword.texture;
        if is_declared || self.cursor.line_has_word() && *shared_line != line {
            self.rest_of_vertex_line(header, shared_line)?;
        }
        Ok(())
    }

    /// Reads the next word as a finite number.
    fn coordinate(&mut self) -> Result<f64, Malformed> {
        let word = self.cursor.word().unwrap_or_default();
        self.cursor.coordinate(word)
    }

    fn add_vertex(&mut self, header: &Header, values: &[f64]) -> Result<(), Malformed> {
        let (mut position, mut rest) = (DVec3::from_slice(values), &values[3..]);
        if header.keyword.homogeneous {
            position /= rest[0];
            if !position.is_finite() {
                let expected = "a fourth coordinate that is not 0 and leaves the quotients finite";
                return Err(Malformed::in_line(
                    self.cursor.line(),
                    expected,
                    rest[0].to_string(),
                ));
            }
            rest = &rest[1..];
        }
        self.mesh.positions.push(position);
        if let (Some(normals), false) = (&mut self.mesh.normals, rest.is_empty()) {
            normals.push(DVec3::from_slice(rest));
        }
        Ok(())
    }

    /// Reads what follows a vertex on its line: a colour, a texture coordinate, or, left for later, further vertices.
    fn rest_of_vertex_line(
        &mut self,
        header: &Header,
        shared_line: &mut u64,
    ) -> Result<(), Malformed> {
        const EXPECTED: &str = "a number";
        let keyword = header.keyword;
        let line = self.cursor.line();
        let count = self.cursor.words_on_line();
        let color = count.checked_sub(header.numbers_behind_color());
        let declared = keyword.color || keyword.texture;
        let of_color = match color {
            Some(numbers @ 1..=4) if !declared => numbers,
            Some(numbers @ (1 | 3 | 4)) if keyword.color => numbers,
            Some(0) if !keyword.color => 0,
            _ if !declared && count.is_multiple_of(header.numbers_per_vertex()) => {
                *shared_line = line;
                return Ok(());
            }
            _ => {
                let expected = if declared {
                    format!("{} after the vertex", declared_extras(keyword))
                } else {
                    "a colour of at most four numbers after the vertex".to_owned()
                };
                return Err(Malformed::in_line(line, expected, numbers(count, "number")));
            }
        };
        self.values += u64::from(of_color == 1);
        if let Some((color, alpha)) = self.color(of_color, EXPECTED)? {
            self.vertex_colors.push(self.mesh.positions.len(), color);
            self.vertex_colors.measure(alpha);
        }
        if keyword.normal_is_late {
            let normal = [self.coordinate()?, self.coordinate()?, self.coordinate()?];
            let normals = self.mesh.normals.get_or_insert_default();
            normals.push(DVec3::from_array(normal));
        }
        if keyword.texture {
            let mut texture = DVec2::new(self.number(EXPECTED)?, self.number(EXPECTED)?);
            if !texture.is_finite() {
                self.notes.textures_not_finite.at(Place::Line(line));
                texture = DVec2::ZERO;
            }
            let coordinates = self.mesh.texture_coordinates.get_or_insert_default();
            coordinates.push(texture);
        }
        Ok(())
    }

    /// Reads a colour of so many numbers, at most four, and its alpha, 0 where there is none; `None` where it says no colour.
    fn color(&mut self, count: usize, expected: &str) -> Result<Option<(DVec3, f64)>, Malformed> {
        let mut channels = [0.0; 4];
        for channel in &mut channels[..count] {
            *channel = self.number(expected)?;
        }
        let [red, green, blue, alpha] = channels;
        let is_color = count >= 3 && channels.iter().all(|channel| channel.is_finite());
        if count > 0 && !is_color {
            self.notes.colors.at(Place::Line(self.cursor.line()));
        }
        Ok(is_color.then_some((DVec3::new(red, green, blue), alpha)))
    }

    /// Reads the next word of the line as a number.
    fn number(&mut self, expected: &str) -> Result<f64, Malformed> {
        let word = self.cursor.word().unwrap_or_default();
        number(word).ok_or_else(|| Malformed::at_token(self.cursor.line(), expected, word))
    }

    /// Whether four indices on each line are what follows, behind a value of each vertex, and not faces, whose lines begin with 3 where
    /// they have four numbers.
    fn has_cells_ahead(&self, header: &Header) -> bool {
        if header.vertices == 0 || self.values < header.vertices {
            return false;
        }
        let mut ahead = self.cursor.clone();
        while ahead.find_word() {
            if ahead.words_on_line() != 4 {
                return false;
            }
            if ahead.word() != Some(b"3") {
                return true;
            }
            ahead.rest_of_line();
        }
        false
    }

    /// Reads tetrahedra that are four indices alone; `None` when cancelled.
    fn cells(&mut self, header: &Header) -> Result<Option<()>, Malformed> {
        self.are_cells = true;
        let mut cells = Vec::new();
        for index in 0..header.faces {
            let position = self.cursor.position();
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            if !self.cursor.find_word() {
                let expected = format!("tetrahedron {} of {}", index + 1, header.faces);
                return Err(self.cursor.at_end(expected));
            }
            let line = self.cursor.line();
            self.first_face.get_or_insert(Place::Line(line));
            let mut corners = [0; 4];
            for corner in &mut corners {
                let word = self.cursor.word().unwrap_or_default();
                *corner = self.vertex_index(word).ok_or_else(|| {
                    let expected = format!("four vertex indices below {}", header.vertices);
                    Malformed::at_token(line, expected, word)
                })?;
            }
            let expected = "the end of the line after a tetrahedron";
            expect_end_of_line(&mut self.cursor, expected)?;
            cells.push(corners);
        }
        self.fours = Some(cells);
        Ok(Some(()))
    }

    /// Reads all faces; `None` when cancelled.
    fn faces(&mut self, header: &Header) -> Result<Option<()>, Malformed> {
        const SHORTEST_TRIANGLE: usize = "3 0 1 2\n".len();
        let capacity = capacity(header.faces, self.cursor.remaining() / SHORTEST_TRIANGLE);
        self.mesh.triangles.reserve_exact(capacity);
        let mut corners = Vec::new();
        for index in 0..header.faces {
            let position = self.cursor.position();
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            let line = self.face(header, index, &mut corners)?;
            let color = self.face_color()?;
            self.first_face.get_or_insert(Place::Line(line));
            match (<[u32; 4]>::try_from(&corners[..]), &mut self.fours) {
                (Ok(corners), Some(fours)) if color.is_none() => fours.push(corners),
                _ => self.fours = None,
            }
            let TriangleMesh {
                positions,
                triangles,
                ..
            } = &mut self.mesh;
            let before = triangles.len();
            self.tally
                .add_face(Place::Line(line), &mut corners, positions, triangles);
            if let Some((color, alpha)) = color {
                self.notes.face_colors.at(Place::Line(line));
                self.face_colors.fill(before..triangles.len(), color);
                self.face_colors.measure(alpha);
            }
        }
        Ok(Some(()))
    }

    /// Reads one face into `corners`, up to its colour, and returns the line it begins on.
    fn face(
        &mut self,
        header: &Header,
        index: u64,
        corners: &mut Vec<u32>,
    ) -> Result<u64, Malformed> {
        let expected = || {
            format!(
                "the number of corners of face {} of {}",
                index + 1,
                header.faces
            )
        };
        if !self.cursor.find_word() {
            let expected = format!("face {} of {}", index + 1, header.faces);
            return Err(self.cursor.at_end(expected));
        }
        let line = self.cursor.line();
        let word = self.cursor.word().unwrap_or_default();
        let size = whole(word).filter(|&size| size > 0);
        let size = size.ok_or_else(|| Malformed::at_token(line, expected(), word))?;
        corners.clear();
        for _ in 0..size {
            let Some(word) = self.cursor.word() else {
                self.rest_of_long_face(line, size, corners)?;
                break;
            };
            let vertex = self.vertex_index(word).ok_or_else(|| {
                let expected = format!("a vertex index below {}", header.vertices);
                Malformed::at_token(line, expected, word)
            })?;
            corners.push(vertex);
        }
        Ok(line)
    }

    /// Goes on with a face on the lines after `line`, its first, until it has `size` corners.
    fn rest_of_long_face(
        &mut self,
        line: u64,
        size: u64,
        corners: &mut Vec<u32>,
    ) -> Result<(), Malformed> {
        let on_first_line = corners.len();
        while (corners.len() as u64) < size {
            let word = self
                .cursor
                .find_word()
                .then(|| self.cursor.word())
                .flatten();
            match word.and_then(|word| self.vertex_index(word)) {
                Some(vertex) => corners.push(vertex),
                None => return Err(short_face(line, size, on_first_line)),
            }
        }
        if self.cursor.line_has_word() {
            return Err(short_face(line, size, on_first_line));
        }
        Ok(())
    }

    fn vertex_index(&self, word: &[u8]) -> Option<u32> {
        let index = u32::try_from(whole(word)?).ok()?;
        ((index as usize) < self.mesh.positions.len()).then_some(index)
    }

    /// Reads the colour of a face, if there is one left on its line, and its alpha.
    fn face_color(&mut self) -> Result<Option<(DVec3, f64)>, Malformed> {
        if !self.cursor.line_has_word() {
            return Ok(None);
        }
        let count = self.cursor.words_on_line();
        if count > 4 {
            let expected = "a colour of at most four numbers after the face";
            let line = self.cursor.line();
            return Err(Malformed::in_line(line, expected, numbers(count, "number")));
        }
        self.color(count, "a colour or the end of the line after the face")
    }

    /// Looks at what follows the last face.
    fn end(&mut self, header: &Header) -> Result<(), Malformed> {
        if self.cursor.find_word() {
            let line = self.cursor.line();
            let word = self.cursor.word().unwrap_or_default();
            if number(word).is_some() {
                let expected = format!("the end of the file after {} faces", header.faces);
                return Err(Malformed::at_token(line, expected, word));
            }
            self.notes.trailing.at(Place::Line(line));
        }
        Ok(())
    }
}

fn short_vertex(line: u64, header: &Header, index: u64, read: usize) -> Malformed {
    let wanted = header.numbers_per_vertex();
    let expected = format!(
        "{wanted} numbers for vertex {} of {}",
        index + 1,
        header.vertices
    );
    Malformed::in_line(line, expected, numbers(read, "number"))
}

fn short_face(line: u64, size: u64, found: usize) -> Malformed {
    Malformed::in_line(line, format!("{size} vertex indices"), found.to_string())
}

/// What the keyword says must follow a vertex's position, and its normal where that comes first.
fn declared_extras(keyword: Keyword) -> &'static str {
    match (keyword.color, keyword.normal_is_late, keyword.texture) {
        (true, false, true) => "a colour (1, 3 or 4 numbers) and a texture coordinate (2 numbers)",
        (true, true, true) => {
            "a colour (1, 3 or 4 numbers), a normal (3 numbers) and a texture coordinate (2 numbers)"
        }
        (true, true, false) => "a colour (1, 3 or 4 numbers) and a normal (3 numbers)",
        (true, false, false) => "a colour (1, 3 or 4 numbers)",
        (false, ..) => "a texture coordinate (2 numbers)",
    }
}
