//! From the faces of a file to triangles: polygons are cut, faces without area are dropped, and both are counted.

use super::malformed::Place;
use super::notes::Seen;
use crate::geometry::{self, TriangleMesh, polygon};
use crate::io::mesh_file::{Dropped, MeshFile};
use crate::math::DVec3;

/// The corner of a face as a format gives it.
pub trait Corner: Copy {
    /// The index of its position.
    fn position(self) -> usize;
}

impl Corner for u32 {
    fn position(self) -> usize {
        self as usize
    }
}

/// What became of the faces of a file.
#[derive(Debug, Default)]
pub struct Tally {
    /// Faces in the file, the dropped ones included.
    pub faces: u64,
    polygons: u64,
    degenerate: Seen,
    too_few_corners: Seen,
    crossing: Seen,
}

impl Tally {
    /// Adds the face at `place` to `triangles`, cut where it has more than three corners, or drops it. What is in `corners`
    /// afterwards is nobody's.
    ///
    /// # Panics
    /// When a corner has none of the positions.
    pub fn add_face<C: Corner>(
        &mut self,
        place: Place,
        corners: &mut Vec<C>,
        positions: &[DVec3],
        triangles: &mut Vec<[C; 3]>,
    ) {
        self.faces += 1;
        match corners[..] {
            [] | [_] | [_, _] => return self.too_few_corners.at(place),
            [a, b, c] => {
                if has_area([a, b, c], positions) {
                    return triangles.push([a, b, c]);
                }
            }
            _ => {
                self.polygons += 1;
                let before = triangles.len();
                self.add_polygon(place, corners, positions, triangles);
                if triangles.len() > before {
                    return;
                }
            }
        }
        self.degenerate.at(place);
    }

    fn add_polygon<C: Corner>(
        &mut self,
        place: Place,
        corners: &mut Vec<C>,
        positions: &[DVec3],
        triangles: &mut Vec<[C; 3]>,
    ) {
        let position = |corner: &C| positions[corner.position()];
        corners.dedup_by(|a, b| position(a) == position(b));
        while corners.len() > 1 && corners.first().map(position) == corners.last().map(position) {
            corners.pop();
        }
        let points: Vec<DVec3> = corners.iter().map(position).collect();
        let cut = polygon::triangulate(&points);
        if cut.crosses_itself {
            self.crossing.at(place);
        }
        let cut = cut.triangles.into_iter();
        let cut = cut.map(|triangle| triangle.map(|corner| corners[corner as usize]));
        triangles.extend(cut.filter(|&triangle| has_area(triangle, positions)));
    }

    /// How many faces were cut, and how many left out.
    #[must_use]
    pub fn counts(&self) -> (u64, Dropped) {
        let dropped = Dropped {
            degenerate: self.degenerate.count,
            too_few_corners: self.too_few_corners.count,
        };
        (self.polygons, dropped)
    }

    /// What is to be said of faces.
    pub fn warnings(&self) -> impl Iterator<Item = String> + use<> {
        let of_faces = [
            self.degenerate.counted(
                "face without area was dropped",
                "faces without area were dropped",
            ),
            self.too_few_corners.counted(
                "face with fewer than three corners was dropped",
                "faces with fewer than three corners were dropped",
            ),
            self.crossing.counted(
                "polygon crosses itself; its triangles may overlap",
                "polygons cross themselves; their triangles may overlap",
            ),
        ];
        of_faces.into_iter().flatten()
    }

    /// What a file of this `format` held, where `mesh` is made of these faces. `warnings`: what its reader has to say besides.
    pub fn into_file(
        self,
        format: &'static str,
        mut mesh: TriangleMesh,
        warnings: impl IntoIterator<Item = String>,
    ) -> MeshFile {
        mesh.triangles.shrink_to_fit();
        let mut warnings: Vec<_> = self.warnings().chain(warnings).collect();
        let (polygons, dropped) = self.counts();
        if mesh.triangles.is_empty() {
            warnings.push("the mesh has no triangles".to_owned());
        }
        MeshFile {
            mesh,
            format,
            faces: self.faces,
            polygons,
            dropped,
            warnings,
            ..MeshFile::default()
        }
    }
}

fn has_area<C: Corner>(triangle: [C; 3], positions: &[DVec3]) -> bool {
    geometry::has_area(triangle.map(|corner| positions[corner.position()]))
}
