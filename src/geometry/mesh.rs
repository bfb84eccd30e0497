use crate::math::{DBounds, DVec3};

/// A triangle mesh in its own coordinates, as a file gave it: `f64`, indexed, before any transform.
///
/// Invariant (kept by the loaders, checked by [`TriangleMesh::validate`]): every index is in range, every position and
/// normal finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Three indices into `positions` per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One shading normal per vertex where the file gave them; not necessarily of unit length.
    pub normals: Option<Vec<DVec3>>,
}

impl TriangleMesh {
    /// The corners of triangle `index`.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[must_use]
    pub fn corners(&self, index: usize) -> [DVec3; 3] {
        self.triangles[index].map(|vertex| self.positions[vertex as usize])
    }

    /// The box around all triangles; vertices that no triangle uses do not count.
    #[must_use]
    pub fn bounds(&self) -> DBounds {
        let corners = self.triangles.iter().flatten();
        DBounds::of_points(corners.map(|&vertex| self.positions[vertex as usize]))
    }

    /// Says what breaks the invariant of this type, if anything does.
    ///
    /// # Errors
    /// A sentence that names the first offending vertex or triangle.
    pub fn validate(&self) -> Result<(), String> {
        if let Some(vertex) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(format!(
                "vertex {vertex} is not finite: {}",
                self.positions[vertex]
            ));
        }
        if let Some(normals) = &self.normals {
            if normals.len() != self.positions.len() {
                return Err(format!(
                    "{} normals for {} vertices",
                    normals.len(),
                    self.positions.len()
                ));
            }
            if let Some(vertex) = normals.iter().position(|n| !n.is_finite()) {
                return Err(format!(
                    "the normal of vertex {vertex} is not finite: {}",
                    normals[vertex]
                ));
            }
        }
        let out_of_range =
            |triangle: &[u32; 3]| triangle.iter().any(|&v| v as usize >= self.positions.len());
        match self.triangles.iter().position(out_of_range) {
            Some(t) => Err(format!(
                "triangle {t} uses vertices {:?} of {}",
                self.triangles[t],
                self.positions.len()
            )),
            None => Ok(()),
        }
    }
}
