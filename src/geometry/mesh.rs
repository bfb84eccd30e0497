//! Triangle meshes as files give them: indexed, in `f64` and their own coordinates, counter-clockwise seen from outside.

use crate::math::{DBounds, DVec2, DVec3, Vec3};

/// A triangle mesh in its own coordinates, as a file gave it: `f64`, indexed, before any transform.
///
/// Invariant (kept by the loaders, checked by [`TriangleMesh::validate`]): every index is in range, every list for the vertices
/// as long as that of their positions, every number finite, every colour at least 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Three indices into `positions` per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One shading normal per vertex where the file gave them; not necessarily of unit length.
    pub normals: Option<Vec<DVec3>>,
    /// Where each vertex lies on an image, if the file says so: `(0, 0)` is its lower left corner, `(1, 1)` its upper right one, and beyond
    /// that the image repeats.
    pub texture_coordinates: Option<Vec<DVec2>>,
    /// One colour per vertex where the file gave them: linear RGB, white `(1, 1, 1)`.
    pub colors: Option<Vec<Vec3>>,
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
        let is_color = |c: Vec3| c.is_finite() && c.min_element() >= 0.0;
        self.validate_attribute("normal", self.normals.as_deref(), DVec3::is_finite)?;
        let coordinates = self.texture_coordinates.as_deref();
        self.validate_attribute("texture coordinate", coordinates, DVec2::is_finite)?;
        self.validate_attribute("colour", self.colors.as_deref(), is_color)?;
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

    /// Says what is wrong with one value for each vertex, called `what`, if anything is.
    fn validate_attribute<T: Copy + std::fmt::Display>(
        &self,
        what: &str,
        values: Option<&[T]>,
        is_right: impl Fn(T) -> bool,
    ) -> Result<(), String> {
        let vertices = self.positions.len();
        let Some(values) = values else {
            return Ok(());
        };
        if values.len() != vertices {
            let count = values.len();
            return Err(format!("{count} {what}s for {vertices} vertices"));
        }
        match values.iter().position(|&value| !is_right(value)) {
            Some(vertex) => {
                let value = values[vertex];
                Err(format!(
                    "the {what} of vertex {vertex} is not finite, or negative: {value}"
                ))
            }
            None => Ok(()),
        }
    }
}
