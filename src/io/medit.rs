//! Meshes of Medit (`.mesh`), text: sections, each of a keyword, the number of its items, and the items.
//!
//! ```text
//! MeshVersionFormatted 2
//! Dimension 3
//! Vertices
//! 4
//! 0 0 0 0        # x, y, z and a reference, which means nothing here
//! 1 0 0 0
//! 0 1 0 0
//! 0 0 1 0
//! Tetrahedra
//! 1
//! 1 2 3 4 0      # vertices, counted from 1, and a reference
//! End
//! ```
//!
//! - `Triangles` and `Quadrilaterals` are shown, and of `Tetrahedra`, `Pyramids`, `Prisms` and `Hexahedra` the faces that belong to one
//!   cell alone, turned outwards whichever way the cell is given; those that the file gives as triangles too are there once. The part
//!   `inner` has all faces of cells.
//! - All other sections are passed over.
//! - In two dimensions, z is 0. `Vertices` stand before what has them. Keywords may be written in any case.
//!
//! Counts are never trusted: memory grows with the bytes that are there.
//!
//! Source: Pascal Frey, Medit: an interactive mesh visualization software, INRIA technical report 253, 2001.

use super::mesh_file::MeshFile;
use super::mesh_reading::{Cursor, Malformed, Place, Solid, Watch, capacity, number, whole};
use super::mesh_writing::Decimals;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::DVec3;
use std::io::{self, Write};

const FIRST: &[u8] = b"MeshVersionFormatted";

/// Whether the text begins as Medit's meshes do.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    let first = cursor.find_word().then(|| cursor.word()).flatten();
    first.is_some_and(|word| word.eq_ignore_ascii_case(FIRST))
}

/// Reads a mesh from its bytes.
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
        dimensions: 3,
        solid: Solid::default(),
    };
    if reader.sections()?.is_none() {
        return Ok(None);
    }
    // Cancelling comes too late here: the text is read.
    let _ = reader.watch.report(bytes.len());
    Ok(Some(reader.solid.into_file("Medit")))
}

/// The place in the text, and what stands before it.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    dimensions: usize,
    solid: Solid,
}

/// What the items of a section are.
#[derive(Clone, Copy, PartialEq)]
enum Items {
    Vertices,
    /// With so many corners.
    Faces(usize),
    /// With so many corners.
    Cells(usize),
}

impl Reader<'_> {
    /// Reads all sections; `None` when cancelled.
    fn sections(&mut self) -> Result<Option<()>, Malformed> {
        let first = self.cursor.next_word("MeshVersionFormatted")?;
        if !first.eq_ignore_ascii_case(FIRST) {
            let line = self.cursor.line();
            return Err(Malformed::at_token(line, "MeshVersionFormatted", first));
        }
        self.cursor.next_count("the version of the format")?;
        while self.cursor.find_word() {
            let line = self.cursor.line();
            let keyword = self.cursor.word().unwrap_or_default().to_ascii_lowercase();
            let read = match &keyword[..] {
                b"end" => break,
                b"dimension" => self.dimension().map(Some),
                b"vertices" => self.items(Items::Vertices),
                b"triangles" => self.items(Items::Faces(3)),
                b"quadrilaterals" => self.items(Items::Faces(4)),
                b"tetrahedra" => self.items(Items::Cells(4)),
                b"pyramids" => self.items(Items::Cells(5)),
                b"prisms" => self.items(Items::Cells(6)),
                b"hexahedra" => self.items(Items::Cells(8)),
                [letter, ..] if letter.is_ascii_alphabetic() => Ok(self.skip()),
                word => return Err(Malformed::at_token(line, "a keyword of Medit", word)),
            }?;
            if read.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn dimension(&mut self) -> Result<(), Malformed> {
        let word = self.cursor.next_word("the dimension, 2 or 3")?;
        self.dimensions = match word {
            b"2" => 2,
            b"3" => 3,
            _ => {
                let line = self.cursor.line();
                return Err(Malformed::at_token(line, "the dimension, 2 or 3", word));
            }
        };
        Ok(())
    }

    /// Passes over numbers up to the next keyword; `None` when cancelled.
    fn skip(&mut self) -> Option<()> {
        let mut index = 0;
        while self.cursor.find_word() {
            self.watch.report_item(index, self.cursor.position())?;
            index += 1;
            let mut ahead = self.cursor.clone();
            if number(ahead.word().unwrap_or_default()).is_none() {
                break;
            }
            self.cursor = ahead;
        }
        Some(())
    }

    /// Reads a section behind its keyword; `None` when cancelled.
    fn items(&mut self, items: Items) -> Result<Option<()>, Malformed> {
        /// The fewest bytes of an item: a number and a blank for each of two.
        const LEAST_BYTES: usize = 4;
        let what = match items {
            Items::Vertices => "vertices",
            Items::Faces(3) => "triangles",
            Items::Faces(_) => "quadrilaterals",
            Items::Cells(4) => "tetrahedra",
            Items::Cells(5) => "pyramids",
            Items::Cells(6) => "prisms",
            Items::Cells(_) => "hexahedra",
        };
        let line = self.cursor.line();
        if items != Items::Vertices && self.solid.positions.is_empty() {
            let expected = format!("Vertices before {what}");
            return Err(Malformed::in_line(line, expected, "none"));
        }
        let count = self.cursor.next_count(&format!("the number of {what}"))?;
        let possible = self.cursor.remaining() / LEAST_BYTES;
        if items == Items::Vertices {
            if !self.solid.positions.is_empty() {
                return Err(Malformed::in_line(
                    line,
                    "one section of Vertices",
                    "another",
                ));
            }
            self.solid
                .positions
                .reserve_exact(capacity(count, possible));
        }
        let mut corners = Vec::new();
        for index in 0..count {
            if self
                .watch
                .report_item(index, self.cursor.position())
                .is_none()
            {
                return Ok(None);
            }
            let item = || format!("item {} of {count} {what}", index + 1);
            self.cursor.find_word();
            let place = Place::Line(self.cursor.line());
            match items {
                Items::Vertices => self.vertex(&item)?,
                Items::Faces(corner_count) | Items::Cells(corner_count) => {
                    corners.clear();
                    for _ in 0..corner_count {
                        corners.push(self.index(&item)?);
                    }
                    match items {
                        Items::Cells(_) => self.solid.add_cell(place, &corners)?,
                        _ => self.solid.add_face(place, &mut corners),
                    }
                }
            }
            // The reference.
            let line = self.cursor.line();
            let word = self.cursor.next_word(&item())?;
            if number(word).is_none() {
                return Err(Malformed::at_token(line, "a reference, a number", word));
            }
        }
        Ok(Some(()))
    }

    fn vertex(&mut self, item: &dyn Fn() -> String) -> Result<(), Malformed> {
        let mut position = DVec3::ZERO;
        for axis in 0..self.dimensions {
            let word = self.cursor.next_word(&item())?;
            position[axis] = self.cursor.coordinate(word)?;
        }
        if u32::try_from(self.solid.positions.len()).is_err() {
            let line = self.cursor.line();
            return Err(Malformed::in_line(
                line,
                "fewer than 2^32 vertices",
                "another",
            ));
        }
        self.solid.positions.push(position);
        Ok(())
    }

    /// The next number as that of a vertex, from 0.
    fn index(&mut self, item: &dyn Fn() -> String) -> Result<u32, Malformed> {
        let word = self.cursor.next_word(&item())?;
        let count = self.solid.positions.len();
        let index = whole(word).and_then(|index| index.checked_sub(1));
        let index = index.and_then(|index| u32::try_from(index).ok());
        index
            .filter(|&index| (index as usize) < count)
            .ok_or_else(|| {
                let expected = format!("a vertex number from 1 to {count}");
                Malformed::at_token(self.cursor.line(), expected, word)
            })
    }
}

/// Writes the triangles of a mesh. Reading them gives the same mesh, apart from triangles without area, which readers drop.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "MeshVersionFormatted 2\nDimension 3\nVertices\n{}\n",
        mesh.positions.len()
    )?;
    for position in &mesh.positions {
        writeln!(out, "{} 0", Decimals(&position.to_array()))?;
    }
    if !mesh.triangles.is_empty() {
        write!(out, "Triangles\n{}\n", mesh.triangles.len())?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        writeln!(out, "{a} {b} {c} 0")?;
    }
    writeln!(out, "End")
}

#[cfg(test)]
mod tests;
