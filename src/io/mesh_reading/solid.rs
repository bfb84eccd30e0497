use super::malformed::Place;
use super::notes::{Seen, numbers};
use super::tally::Tally;
use crate::geometry::TriangleMesh;
use crate::geometry::tetrahedra::Boundary;
use crate::io::mesh_file::MeshFile;
use crate::math::DVec3;

/// The cells of a mesh for simulations, as far as they are read: faces, and tetrahedra, of which the faces outside are shown.
#[derive(Debug, Default)]
pub struct Solid {
    /// All vertices.
    pub positions: Vec<DVec3>,
    /// Of faces that the file gives, beside those of tetrahedra.
    pub triangles: Vec<[u32; 3]>,
    /// Four vertices each.
    pub tetrahedra: Vec<[u32; 4]>,
    /// The first of them.
    first_tetrahedron: Option<Place>,
    /// Cells of other kinds.
    pub others: Seen,
    /// Cells with further vertices on their edges.
    pub curved: Seen,
    pub tally: Tally,
}

impl Solid {
    /// Adds a face at `place`; what is in `corners` afterwards is nobody's.
    pub fn add_face(&mut self, place: Place, corners: &mut Vec<u32>) {
        self.tally
            .add_face(place, corners, &self.positions, &mut self.triangles);
    }

    /// Adds a tetrahedron at `place`; false where there are too many.
    pub fn add_tetrahedron(&mut self, place: Place, corners: [u32; 4]) -> bool {
        /// More could not have their faces numbered.
        const MOST: usize = (1 << 30) - 1;
        self.first_tetrahedron.get_or_insert(place);
        self.tetrahedra.push(corners);
        self.tetrahedra.len() <= MOST
    }

    /// What the file of this `format` held: its faces, and those around its tetrahedra, each once.
    pub fn into_file(mut self, format: &'static str) -> MeshFile {
        let mut warnings = Vec::new();
        if let Some(place) = self.first_tetrahedron {
            let boundary = Boundary::of(&self.positions, &self.tetrahedra);
            // Most files give the faces outside as well.
            self.triangles.retain(|&face| !boundary.has_face(face));
            for &face in &boundary.triangles {
                self.add_face(place, &mut face.to_vec());
            }
            warnings.push(summary(self.tetrahedra.len(), &boundary));
        }
        warnings.extend(self.others.counted(
            "cell that is no triangle, quadrilateral or tetrahedron is ignored",
            "cells that are no triangles, quadrilaterals or tetrahedra are ignored",
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
        self.tally.into_file(format, mesh, warnings)
    }
}

/// What became of so many tetrahedra, in words.
fn summary(count: usize, boundary: &Boundary) -> String {
    let of = match count {
        1 => "1 tetrahedron".to_owned(),
        _ => format!("{count} tetrahedra"),
    };
    let outside = numbers(boundary.triangles.len(), "face");
    let mut text = format!(
        "of {of}, {outside} outside are shown and {} inside are not",
        boundary.inner_faces
    );
    for (count, what) in [
        (boundary.inverted, "were inside out and have been turned"),
        (boundary.flat, "have no volume"),
    ] {
        if count > 0 {
            text = format!("{text}; {count} {what}");
        }
    }
    text
}
