//! Meshes of Gmsh (`.msh`), text, of the versions 2 to 2.2 and 4.1: sections between `$Name` and `$EndName`.
//!
//! ```text
//! $MeshFormat
//! 2.2 0 8
//! $EndMeshFormat
//! $Nodes
//! 4
//! 1 0 0 0            # number, x, y, z
//! 2 1 0 0
//! 3 0 1 0
//! 4 0 0 1
//! $EndNodes
//! $Elements
//! 1
//! 1 4 2 99 2 1 2 3 4 # number, kind, count of tags, tags, nodes
//! $EndElements
//! ```
//!
//! - Triangles and quadrilaterals are shown, and of tetrahedra, pyramids, prisms and hexahedra the faces that belong to one cell alone,
//!   turned outwards; those that the file gives as triangles too are there once. Of curved ones the corners count. The part `inner` has
//!   all faces of cells.
//! - Points and lines are passed over; kinds nobody knows are counted and left out.
//! - Sections of other names are passed over. `$Nodes` stand before `$Elements`. Each node and element has a line of its own.
//!
//! Counts are never trusted: memory grows with the bytes that are there.
//!
//! Source: Geuzaine & Remacle, Gmsh reference manual, sections on the MSH file formats.

use std::collections::HashMap;
use std::io::{self, Write};

use foldhash::fast::RandomState;

use super::mesh_file::MeshFile;
use super::mesh_reading::{Cursor, Malformed, Place, Solid, Watch, whole};
use super::mesh_writing::Decimals;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::DVec3;

const FIRST: &[u8] = b"$MeshFormat";

/// Whether the text begins as Gmsh's meshes do.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    cursor.find_word() && cursor.word() == Some(FIRST)
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
        version: Version::Two,
        nodes: HashMap::default(),
        solid: Solid::default(),
        corners: Vec::new(),
        items: 0,
    };
    if reader.sections()?.is_none() {
        return Ok(None);
    }
    // Cancelling comes too late here: the text is read.
    let _ = reader.watch.report(bytes.len());
    Ok(Some(reader.solid.into_file("Gmsh")))
}

#[derive(Clone, Copy, PartialEq)]
enum Version {
    /// Lists of nodes and elements.
    Two,
    /// Lists in blocks, one for each part of the body.
    Four,
}

/// What is done with an element.
#[derive(Clone, Copy)]
enum Cell {
    /// Nothing: it has no area.
    Thin,
    /// With so many corners; whether it has further nodes.
    Face(usize, bool),
    /// With a volume, so many corners, and perhaps further nodes.
    Solid(usize, bool),
    Other,
}

impl Cell {
    /// By the numbers of the manual.
    fn of(kind: u64) -> Self {
        match kind {
            1 | 8 | 15 | 26..=28 => Self::Thin,
            2 => Self::Face(3, false),
            3 => Self::Face(4, false),
            4 => Self::Solid(4, false),
            5 => Self::Solid(8, false),
            6 => Self::Solid(6, false),
            7 => Self::Solid(5, false),
            9 | 20..=25 => Self::Face(3, true),
            10 | 16 => Self::Face(4, true),
            11 | 29..=31 => Self::Solid(4, true),
            12 | 17 => Self::Solid(8, true),
            13 | 18 => Self::Solid(6, true),
            14 | 19 => Self::Solid(5, true),
            _ => Self::Other,
        }
    }
}

/// The place in the text, and what stands before it.
struct Reader<'a> {
    cursor: Cursor<'a>,
    watch: Watch<'a>,
    version: Version,
    /// By its number, the index of each node.
    nodes: HashMap<u64, u32, RandomState>,
    solid: Solid,
    /// The corners of the face at hand.
    corners: Vec<u32>,
    /// Nodes and elements so far.
    items: u64,
}

impl Reader<'_> {
    /// Reads all sections; `None` when cancelled.
    fn sections(&mut self) -> Result<Option<()>, Malformed> {
        self.expect("$MeshFormat")?;
        self.format()?;
        self.expect("$EndMeshFormat")?;
        while self.cursor.find_word() {
            let line = self.cursor.line();
            let word = self.cursor.word().unwrap_or_default();
            let read = match word {
                b"$Nodes" => self.nodes(),
                b"$Elements" => self.elements(),
                [b'$', name @ ..] => self.skip_to_end_of(name),
                _ => return Err(Malformed::at_token(line, "a section such as $Nodes", word)),
            }?;
            if read.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn format(&mut self) -> Result<(), Malformed> {
        const EXPECTED: &str = "the version 2, 2.1, 2.2 or 4.1";
        let word = self.cursor.next_word(EXPECTED)?;
        self.version = match word {
            b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
            b"4.1" => Version::Four,
            _ => return Err(Malformed::at_token(self.cursor.line(), EXPECTED, word)),
        };
        let word = self.cursor.next_word("0 for text")?;
        if word != b"0" {
            let line = self.cursor.line();
            return Err(Malformed::at_token(
                line,
                "0 for text: binary files are not read",
                word,
            ));
        }
        self.cursor.rest_of_line();
        Ok(())
    }

    /// Passes over lines up to `$End` and this name; `None` when cancelled.
    fn skip_to_end_of(&mut self, name: &[u8]) -> Result<Option<()>, Malformed> {
        let end = [b"$End", name].concat();
        let begun = self.cursor.line();
        while self.cursor.leave_line() && self.cursor.find_word() {
            if self.go_on().is_none() {
                return Ok(None);
            }
            if self.cursor.word() == Some(&end[..]) {
                return Ok(Some(()));
            }
        }
        let expected = format!(
            "{} after line {begun}",
            String::from_utf8_lossy(&end[..end.len().min(40)])
        );
        Err(self.cursor.at_end(expected))
    }

    /// Reads nodes behind their keyword; `None` when cancelled.
    fn nodes(&mut self) -> Result<Option<()>, Malformed> {
        let blocks = match self.version {
            Version::Two => 1,
            Version::Four => {
                let blocks = self.cursor.next_count("the number of blocks of nodes")?;
                for _ in 0..3 {
                    self.cursor
                        .next_count("the number of nodes, the least and the largest")?;
                }
                blocks
            }
        };
        let mut numbers = Vec::new();
        for _ in 0..blocks {
            let mut more = 0;
            if self.version == Version::Four {
                let dimension = self.cursor.next_count("the dimension of a block")?;
                self.cursor.next_word("the tag of a block")?;
                let has_parameters = self
                    .cursor
                    .next_count("whether nodes have parameters, 0 or 1")?
                    == 1;
                more = if has_parameters { dimension } else { 0 };
            }
            let count = self.cursor.next_count("the number of nodes")?;
            numbers.clear();
            if self.version == Version::Four {
                for _ in 0..count {
                    if self.go_on().is_none() {
                        return Ok(None);
                    }
                    numbers.push(self.cursor.next_count("the number of a node")?);
                }
            }
            for index in 0..count {
                if self.go_on().is_none() {
                    return Ok(None);
                }
                let number = match self.version {
                    Version::Two => self.cursor.next_count("the number of a node")?,
                    Version::Four => numbers[usize::try_from(index).expect("as many are there")],
                };
                self.node(number)?;
                for _ in 0..more {
                    self.cursor.next_coordinate()?;
                }
            }
        }
        self.expect("$EndNodes")?;
        Ok(Some(()))
    }

    fn node(&mut self, number: u64) -> Result<(), Malformed> {
        let mut coordinate = || self.cursor.next_coordinate();
        let position = DVec3::new(coordinate()?, coordinate()?, coordinate()?);
        let line = self.cursor.line();
        let index = u32::try_from(self.solid.positions.len())
            .map_err(|_| Malformed::in_line(line, "fewer than 2^32 nodes", "another"))?;
        self.solid.positions.push(position);
        if self.nodes.insert(number, index).is_some() {
            let expected = "a number of its own for each node";
            return Err(Malformed::in_line(
                line,
                expected,
                format!("{number} again"),
            ));
        }
        Ok(())
    }

    /// Reads elements behind their keyword; `None` when cancelled.
    fn elements(&mut self) -> Result<Option<()>, Malformed> {
        let blocks = match self.version {
            Version::Two => 1,
            Version::Four => {
                let blocks = self.cursor.next_count("the number of blocks of elements")?;
                for _ in 0..3 {
                    self.cursor
                        .next_count("the number of elements, the least and the largest")?;
                }
                blocks
            }
        };
        for _ in 0..blocks {
            let mut cell = Cell::Other;
            if self.version == Version::Four {
                self.cursor.next_count("the dimension of a block")?;
                self.cursor.next_word("the tag of a block")?;
                cell = Cell::of(self.cursor.next_count("the kind of a block's elements")?);
            }
            for _ in 0..self.cursor.next_count("the number of elements")? {
                if self.go_on().is_none() {
                    return Ok(None);
                }
                self.cursor.next_count("the number of an element")?;
                if self.version == Version::Two {
                    cell = Cell::of(self.cursor.next_count("the kind of an element")?);
                    for _ in 0..self.cursor.next_count("the number of tags")? {
                        self.cursor.next_word("a tag")?;
                    }
                }
                self.cell(cell)?;
                self.cursor.rest_of_line();
            }
        }
        self.expect("$EndElements")?;
        Ok(Some(()))
    }

    fn cell(&mut self, cell: Cell) -> Result<(), Malformed> {
        let line = self.cursor.line();
        let place = Place::Line(line);
        if let Cell::Face(_, true) | Cell::Solid(_, true) = cell {
            self.solid.curved.at(place);
        }
        match cell {
            Cell::Thin => {}
            Cell::Other => self.solid.others.at(place),
            Cell::Face(count, _) | Cell::Solid(count, _) => {
                self.corners.clear();
                for _ in 0..count {
                    let corner = self.corner()?;
                    self.corners.push(corner);
                }
                match cell {
                    Cell::Solid(..) => self.solid.add_cell(place, &self.corners)?,
                    _ => self.solid.add_face(place, &mut self.corners),
                }
            }
        }
        Ok(())
    }

    /// The next node of the element on this line.
    fn corner(&mut self) -> Result<u32, Malformed> {
        let line = self.cursor.line();
        let Some(word) = self.cursor.word() else {
            return Err(Malformed::in_line(
                line,
                "all nodes of the element",
                "the end of the line",
            ));
        };
        let index = whole(word).and_then(|number| self.nodes.get(&number).copied());
        index.ok_or_else(|| Malformed::at_token(line, "the number of a node", word))
    }

    fn expect(&mut self, keyword: &'static str) -> Result<(), Malformed> {
        let word = self.cursor.next_word(keyword)?;
        if word == keyword.as_bytes() {
            return Ok(());
        }
        Err(Malformed::at_token(self.cursor.line(), keyword, word))
    }

    /// Reports at times how far it is; `None` when cancelled.
    fn go_on(&mut self) -> Option<()> {
        self.items += 1;
        self.watch
            .report_item(self.items - 1, self.cursor.position())
    }
}

/// Writes the triangles of a mesh, in the version 2.2. Reading them gives the same mesh, apart from triangles without area, which readers
/// drop.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let (nodes, elements) = (mesh.positions.len(), mesh.triangles.len());
    write!(
        out,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n"
    )?;
    for (number, position) in (1_u64..).zip(&mesh.positions) {
        writeln!(out, "{number} {}", Decimals(&position.to_array()))?;
    }
    write!(out, "$EndNodes\n$Elements\n{elements}\n")?;
    for (number, triangle) in (1_u64..).zip(&mesh.triangles) {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        // A triangle with two tags, as programs expect: physical and elementary part.
        writeln!(out, "{number} 2 2 0 1 {a} {b} {c}")?;
    }
    writeln!(out, "$EndElements")
}

#[cfg(test)]
mod tests;
