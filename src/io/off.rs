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
//!   or four numbers and a texture coordinate of two, as the keyword says.
//! - The counts stand on one line, also that of the keyword, also glued to it (`OFF8 6 0`); alone on its line the first
//!   count may be followed by both others on lines of their own.
//! - Letters of the keyword may be small, except that `N` (normals) and `n` (dimension) differ. `nOFF` is read if
//!   its dimension is 3; `4nOFF` and `OFF BINARY` are refused. `4OFF` is divided by its fourth coordinate.
//! - Numbers after the last declared face are an error, since a count is wrong then; other text there is a warning.
//!
//! Colours and texture coordinates are checked to be numbers and then ignored, with a warning. Faces of fewer than three
//! corners or without area are dropped and counted. A polygon's repeated corner is taken once; its larger remainder
//! is cut into triangles, of which those without area are left out. Counts are never trusted: memory grows with the text.

mod write;

#[cfg(test)]
mod tests;

pub use write::write;

use super::mesh_file::MeshFile;
use super::mesh_reading::{
    Cursor, Malformed, Place, Seen, Tally, Watch, capacity, number, numbers, whole,
};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::DVec3;

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
    let header = reader.header()?;
    if reader.vertices(&header)?.is_none() || reader.faces(&header)?.is_none() {
        return Ok(None);
    }
    reader.end(&header)?;
    Ok(Some(reader.finish()))
}

/// Whether the text begins as an OFF file with keyword does.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    let first = cursor.find_word().then(|| cursor.word()).flatten();
    first.and_then(Keyword::of).is_some()
}

/// The keyword's prefixes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "five prefixes, each there or not"
)]
struct Keyword {
    /// `ST`: texture coordinates follow the vertices.
    texture: bool,
    /// `C`: colours do.
    color: bool,
    /// `N`: normals do.
    normal: bool,
    /// `4`: positions are homogeneous.
    homogeneous: bool,
    /// `n`: the dimension is given.
    dimension: bool,
}

impl Keyword {
    /// The keyword at the start of `word`, and what is glued to it.
    fn of(word: &[u8]) -> Option<(Self, &[u8])> {
        let mut rest = word;
        let mut take = |prefix: &[u8], any_case: bool| {
            let (head, tail) = rest.split_at_checked(prefix.len())?;
            let found = head == prefix || any_case && head.eq_ignore_ascii_case(prefix);
            found.then(|| rest = tail)
        };
        let keyword = Self {
            texture: take(b"ST", true).is_some(),
            color: take(b"C", true).is_some(),
            normal: take(b"N", false).is_some(),
            homogeneous: take(b"4", true).is_some(),
            dimension: take(b"n", false).is_some(),
        };
        take(b"OFF", true)?;
        let is_whole = rest.is_empty() || rest[0].is_ascii_digit();
        is_whole.then_some((keyword, rest))
    }
}

/// What the beginning of the file says about the rest.
#[derive(Clone, Copy, Debug)]
struct Header {
    keyword: Keyword,
    vertices: u64,
    faces: u64,
}

impl Header {
    /// Numbers of a vertex that are read: its position and its normal.
    fn numbers_per_vertex(&self) -> usize {
        let position = if self.keyword.homogeneous { 4 } else { 3 };
        let normal = if self.keyword.normal { 3 } else { 0 };
        position + normal
    }
}

/// What the file holds and the mesh will not.
#[derive(Debug, Default)]
struct Notes {
    colors: Seen,
    textures: Seen,
    trailing: Seen,
}

/// The parser: a place in the text and the mesh read so far.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    notes: Notes,
    mesh: TriangleMesh,
    tally: Tally,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], cancel: &'a CancelToken, progress: &'a Progress) -> Self {
        Self {
            cursor: Cursor::new(bytes),
            watch: Watch::new(cancel, progress),
            notes: Notes::default(),
            mesh: TriangleMesh::default(),
            tally: Tally::default(),
        }
    }

    /// Reads the keyword, if there is one, and the counts.
    fn header(&mut self) -> Result<Header, Malformed> {
        const EXPECTED: &str =
            "OFF (or COFF, NOFF, STOFF, 4OFF) or the numbers of vertices and faces";
        let mut keyword = Keyword::default();
        let mut glued: &[u8] = &[];
        let mut ahead = self.cursor.clone();
        let Some(first) = ahead.find_word().then(|| ahead.word()).flatten() else {
            return Err(self.at_end(EXPECTED));
        };
        let line = ahead.line();
        if let Some((found, rest)) = Keyword::of(first) {
            (keyword, glued) = (found, rest);
            self.cursor = ahead;
        } else if whole(first).is_none() {
            return Err(Malformed::at_token(line, EXPECTED, first));
        }
        self.dimension(keyword, &mut glued)?;
        self.counts(keyword, glued)
    }

    /// Reads the dimension where the keyword announces it, and refuses what cannot be shown.
    fn dimension(&mut self, keyword: Keyword, glued: &mut &'a [u8]) -> Result<(), Malformed> {
        const EXPECTED: &str = "the dimension 3 after nOFF";
        if !keyword.dimension {
            return Ok(());
        }
        if keyword.homogeneous {
            let line = self.cursor.line();
            return Err(Malformed::in_line(line, "OFF of three dimensions", "4nOFF"));
        }
        let word = if glued.is_empty() {
            self.next_word(EXPECTED)?
        } else {
            std::mem::take(glued)
        };
        match whole(word) {
            Some(3) => Ok(()),
            _ => Err(Malformed::at_token(self.cursor.line(), EXPECTED, word)),
        }
    }

    /// Reads the counts; `glued` is the first if it stuck to the keyword.
    fn counts(&mut self, keyword: Keyword, glued: &'a [u8]) -> Result<Header, Malformed> {
        const VERTICES: &str = "the number of vertices";
        const FACES: &str = "the number of faces";
        const EDGES: &str = "the number of edges";
        let word = if glued.is_empty() {
            self.next_word(VERTICES)?
        } else {
            glued
        };
        if word.eq_ignore_ascii_case(b"BINARY") {
            let line = self.cursor.line();
            return Err(Malformed::at_token(line, "OFF as text", word));
        }
        let vertices = self.count(word, VERTICES)?;
        if vertices > u64::from(u32::MAX) {
            let line = self.cursor.line();
            return Err(Malformed::at_token(line, "fewer than 2^32 vertices", word));
        }
        let on_one_line = self.cursor.line_has_word();
        let word = self.next_word(FACES)?;
        let faces = self.count(word, FACES)?;
        if !on_one_line || self.cursor.line_has_word() {
            let word = self.next_word(EDGES)?;
            if number(word).is_none() {
                return Err(Malformed::at_token(self.cursor.line(), EDGES, word));
            }
        }
        self.expect_end_of_line("the end of the line after the counts")?;
        Ok(Header {
            keyword,
            vertices,
            faces,
        })
    }

    fn count(&self, word: &[u8], expected: &str) -> Result<u64, Malformed> {
        whole(word).ok_or_else(|| Malformed::at_token(self.cursor.line(), expected, word))
    }

    /// Reads all vertices; `None` when cancelled.
    fn vertices(&mut self, header: &Header) -> Result<Option<()>, Malformed> {
        let shortest = 2 * header.numbers_per_vertex();
        let capacity = capacity(header.vertices, self.cursor.remaining() / shortest);
        self.mesh.positions.reserve_exact(capacity);
        if header.keyword.normal {
            self.mesh.normals = Some(Vec::with_capacity(capacity));
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
        self.expect_end_of_line("the end of the line after the last vertex")?;
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
            return Err(self.at_end(format!("vertex {} of {}", index + 1, header.vertices)));
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
        let value = number(word).filter(|value| value.is_finite());
        value.ok_or_else(|| Malformed::at_token(self.cursor.line(), "a finite coordinate", word))
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
        if let Some(normals) = &mut self.mesh.normals {
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
        let line = self.cursor.line();
        let count = self.cursor.words_on_line();
        let texture = if header.keyword.texture { 2 } else { 0 };
        let color = count.checked_sub(texture);
        let declared = header.keyword.color || header.keyword.texture;
        match color {
            Some(1..=4) if !declared => self.notes.colors.at(Place::Line(line)),
            Some(1 | 3 | 4) if header.keyword.color => self.notes.colors.at(Place::Line(line)),
            Some(0) if !header.keyword.color => {}
            _ if !declared && count.is_multiple_of(header.numbers_per_vertex()) => {
                *shared_line = line;
                return Ok(());
            }
            _ => {
                let expected = if declared {
                    format!("{} after the vertex", declared_extras(header.keyword))
                } else {
                    "a colour of at most four numbers after the vertex".to_owned()
                };
                return Err(Malformed::in_line(line, expected, numbers(count, "number")));
            }
        }
        if texture > 0 {
            self.notes.textures.at(Place::Line(line));
        }
        self.skip_numbers("a number")
    }

    /// Reads the rest of the line as numbers nobody needs.
    fn skip_numbers(&mut self, expected: &str) -> Result<(), Malformed> {
        while let Some(word) = self.cursor.word() {
            if number(word).is_none() {
                return Err(Malformed::at_token(self.cursor.line(), expected, word));
            }
        }
        Ok(())
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
            let TriangleMesh {
                positions,
                triangles,
                ..
            } = &mut self.mesh;
            self.tally
                .add_face(Place::Line(line), &mut corners, positions, triangles);
        }
        Ok(Some(()))
    }

    /// Reads one face into `corners` and returns the line it begins on.
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
            return Err(self.at_end(format!("face {} of {}", index + 1, header.faces)));
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
        if self.cursor.line_has_word() {
            self.face_color()?;
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

    fn face_color(&mut self) -> Result<(), Malformed> {
        let line = self.cursor.line();
        let count = self.cursor.words_on_line();
        if count > 4 {
            let expected = "a colour of at most four numbers after the face";
            return Err(Malformed::in_line(line, expected, numbers(count, "number")));
        }
        self.notes.colors.at(Place::Line(line));
        self.skip_numbers("a colour or the end of the line after the face")
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

    fn finish(mut self) -> MeshFile {
        let end = self.cursor.position() + self.cursor.remaining();
        // Cancelling comes too late here: the work is done.
        let _ = self.watch.report(end);
        let Notes {
            colors,
            textures,
            trailing,
        } = self.notes;
        let warnings = [
            colors.found("colours are ignored"),
            textures.found("texture coordinates are ignored"),
            trailing.counted(
                "line of text after the last face is ignored",
                "lines of text after the last face are ignored",
            ),
        ];
        let warnings = warnings.into_iter().flatten();
        self.tally.into_file("OFF", self.mesh, warnings)
    }

    fn next_word(&mut self, expected: &str) -> Result<&'a [u8], Malformed> {
        if !self.cursor.find_word() {
            return Err(self.at_end(expected));
        }
        Ok(self.cursor.word().unwrap_or_default())
    }

    fn expect_end_of_line(&mut self, expected: &str) -> Result<(), Malformed> {
        match self.cursor.word() {
            Some(word) => Err(Malformed::at_token(self.cursor.line(), expected, word)),
            None => Ok(()),
        }
    }

    fn at_end(&self, expected: impl Into<String>) -> Malformed {
        Malformed::in_line(self.cursor.line(), expected, "the end of the file")
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

/// What the keyword says must follow a vertex's position and normal.
fn declared_extras(keyword: Keyword) -> &'static str {
    match (keyword.color, keyword.texture) {
        (true, true) => "a colour (1, 3 or 4 numbers) and a texture coordinate (2 numbers)",
        (true, false) => "a colour (1, 3 or 4 numbers)",
        _ => "a texture coordinate (2 numbers)",
    }
}
