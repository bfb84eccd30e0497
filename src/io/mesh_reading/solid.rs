//! Meshes for simulations, made of cells with a volume: of their faces, those that no two cells share are shown.

use super::malformed::{Malformed, Place};
use super::notes::{Seen, numbers};
use super::tally::Tally;
use crate::geometry::TriangleMesh;
use crate::geometry::cells::{CellFaces, Cells};
use crate::io::mesh_file::MeshFile;
use crate::math::DVec3;

/// The cells of a mesh for simulations: faces, and cells with a volume, of which the faces outside are shown.
#[derive(Debug, Default)]
pub struct Solid {
    /// All vertices.
    pub positions: Vec<DVec3>,
    /// Of faces that the file gives, beside those of cells.
    pub triangles: Vec<[u32; 3]>,
    cells: Cells,
    /// The first of them.
    first_cell: Option<Place>,
    /// Cells of other kinds.
    pub others: Seen,
    /// Cells with further vertices on their edges.
    pub curved: Seen,
    pub tally: Tally,
}

impl Solid {
    /// Vertices, and nothing between them yet.
    pub fn of(positions: Vec<DVec3>) -> Self {
        Self {
            positions,
            ..Self::default()
        }
    }

    /// Adds a face at `place`; what is in `corners` afterwards is nobody's.
    pub fn add_face(&mut self, place: Place, corners: &mut Vec<u32>) {
        self.tally
            .add_face(place, corners, &self.positions, &mut self.triangles);
    }

    /// Adds a cell at `place`, of a number of corners that [`Cells::push`] takes.
    ///
    /// # Errors
    /// That there are too many.
    pub fn add_cell(&mut self, place: Place, corners: &[u32]) -> Result<(), Malformed> {
        if self.cells.len() >= Cells::MOST {
            return Err(Malformed::at(place, "at most 2^29 cells", "another"));
        }
        self.first_cell.get_or_insert(place);
        self.cells.push(corners);
        Ok(())
    }

    /// What the file of this `format` held: its faces, and those around its cells, each once.
    pub fn into_file(mut self, format: &'static str) -> MeshFile {
        let mut warnings = Vec::new();
        if let Some(place) = self.first_cell {
            let faces = CellFaces::of(&self.positions, &self.cells);
            // Most files give the faces outside as well.
            self.triangles.retain(|&face| !faces.has(face));
            for mut corners in faces.outside() {
                let (positions, triangles) = (&self.positions, &mut self.triangles);
                self.tally
                    .add_face(place, &mut corners, positions, triangles);
            }
            warnings.push(summary(&self.cells, &faces));
        }
        warnings.extend(self.others.counted(
            "cell of an unknown kind is ignored",
            "cells of unknown kinds are ignored",
        ));
        warnings.extend(self.curved.counted(
            "curved cell is taken as one between its corners",
            "curved cells are taken as ones between their corners",
        ));
        let mesh = TriangleMesh {
            positions: self.positions,
            triangles: self.triangles,
            ..TriangleMesh::default()
        };
        MeshFile {
            cells: self.cells,
            ..self.tally.into_file(format, mesh, warnings)
        }
    }
}

/// What became of cells, in words.
fn summary(cells: &Cells, faces: &CellFaces<'_>) -> String {
    let of = match (cells.len(), cells.are_tetrahedra()) {
        (1, true) => "1 tetrahedron".to_owned(),
        (count, true) => format!("{count} tetrahedra"),
        (count, false) => numbers(count, "cell"),
    };
    let outside = numbers(faces.outside().len(), "face");
    let inner = faces.inner();
    let mut text = format!("of {of}, {outside} outside are shown and {inner} inside are not");
    if inner > 0 {
        text += " (the part #inner has them)";
    }
    for (count, what) in [
        (faces.inverted, "were inside out and have been turned"),
        (faces.flat, "have no volume"),
    ] {
        if count > 0 {
            text = format!("{text}; {count} {what}");
        }
    }
    text
}

/// The faces of all cells, each once, those outside and those between two cells, as the mesh of a part.
pub fn all_faces(positions: &[DVec3], cells: &Cells) -> TriangleMesh {
    let mut tally = Tally::default();
    let mut triangles = Vec::new();
    for mut corners in CellFaces::of(positions, cells).all() {
        tally.add_face(Place::Byte(0), &mut corners, positions, &mut triangles);
    }
    TriangleMesh {
        positions: positions.to_vec(),
        triangles,
        ..TriangleMesh::default()
    }
}
