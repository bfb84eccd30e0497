//! Reading STL text. The normals of facets are skipped: the order of the corners says which side is outside.

use super::binary::too_many_vertices;
use super::weld::Weld;
use crate::geometry::TriangleMesh;
use crate::io::mesh_file::MeshFile;
use crate::io::mesh_reading::{Cursor, Malformed, Place, Tally, Watch};
use crate::math::DVec3;

/// Whether the bytes begin as a text does: with `solid`, and no zero byte soon after, as there is in binary files.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    /// Bytes in which the first facet begins.
    const BEGINNING: usize = 256;
    let mut cursor = Cursor::new(bytes);
    let first = cursor.find_word().then(|| cursor.word()).flatten();
    let beginning = &bytes[..bytes.len().min(BEGINNING)];
    first.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !beginning.contains(&0)
}

/// Reads a text; `None` when cancelled.
pub fn parse(bytes: &[u8], watch: Watch) -> Result<Option<MeshFile>, Malformed> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes),
        weld: Weld::default(),
        tally: Tally::default(),
        triangles: Vec::new(),
        corners: Vec::new(),
        solid: None,
    };
    let read = reader.solids(watch)?;
    Ok(read.map(|()| reader.finish()))
}

/// The place in the text, and the triangles before it.
struct Reader<'a> {
    cursor: Cursor<'a>,
    weld: Weld,
    tally: Tally,
    triangles: Vec<[u32; 3]>,
    /// The corners of the facet at hand.
    corners: Vec<u32>,
    /// The line where the solid at hand begins.
    solid: Option<u64>,
}

impl Reader<'_> {
    /// Reads all solids, of which the last may be left open; `None` when cancelled.
    fn solids(&mut self, mut watch: Watch) -> Result<Option<()>, Malformed> {
        let mut index = 0;
        loop {
            if watch.report_item(index, self.cursor.position()).is_none() {
                return Ok(None);
            }
            index += 1;
            if !self.cursor.find_word() {
                // Cancelling comes too late here: the work is done.
                let _ = watch.report(self.cursor.position());
                return Ok(Some(()));
            }
            let line = self.cursor.line();
            let word = self.cursor.word().unwrap_or_default();
            let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
            if self.solid.is_none() && is(b"solid") {
                self.solid = Some(line);
                self.cursor.rest_of_line();
            } else if self.solid.is_some() && is(b"endsolid") {
                self.solid = None;
                self.cursor.rest_of_line();
            } else if self.solid.is_some() && is(b"facet") {
                self.facet(line)?;
            } else {
                let expected = match self.solid {
                    Some(_) => "facet or endsolid",
                    None => "solid or the end of the file",
                };
                return Err(Malformed::at_token(line, expected, word));
            }
        }
    }

    /// Reads a facet behind its keyword, on this line.
    fn facet(&mut self, line: u64) -> Result<(), Malformed> {
        self.expect(&["normal"])?;
        for _ in 0..3 {
            // What the normal is does not matter, but that there is one.
            self.cursor.next_word("the three numbers of the normal")?;
        }
        self.expect(&["outer", "loop"])?;
        self.corners.clear();
        loop {
            let word = self.cursor.next_word("vertex or endloop")?;
            if word.eq_ignore_ascii_case(b"endloop") {
                break;
            }
            if !word.eq_ignore_ascii_case(b"vertex") {
                return Err(Malformed::at_token(
                    self.cursor.line(),
                    "vertex or endloop",
                    word,
                ));
            }
            let mut coordinate = || self.cursor.next_coordinate();
            let position = DVec3::new(coordinate()?, coordinate()?, coordinate()?);
            let vertex = self.weld.vertex(position);
            let place = Place::Line(self.cursor.line());
            self.corners
                .push(vertex.ok_or_else(|| too_many_vertices(place))?);
        }
        self.expect(&["endfacet"])?;
        let (place, positions) = (Place::Line(line), &self.weld.positions);
        self.tally
            .add_face(place, &mut self.corners, positions, &mut self.triangles);
        Ok(())
    }

    fn expect(&mut self, keywords: &[&str]) -> Result<(), Malformed> {
        for keyword in keywords {
            let word = self.cursor.next_word(keyword)?;
            if !word.eq_ignore_ascii_case(keyword.as_bytes()) {
                return Err(Malformed::at_token(self.cursor.line(), *keyword, word));
            }
        }
        Ok(())
    }

    fn finish(self) -> MeshFile {
        let warning = self.solid.map(|line| {
            format!("endsolid is missing (solid stands on line {line}); the file may be cut off")
        });
        let mesh = TriangleMesh {
            positions: self.weld.positions,
            triangles: self.triangles,
            ..TriangleMesh::default()
        };
        self.tally.into_file("STL", mesh, warning)
    }
}
