//! What an OFF file that is read becomes: faces with their colours, or what is around tetrahedra.

use super::Reader;
use crate::geometry::TriangleMesh;
use crate::geometry::cells::are_tetrahedra;
use crate::io::mesh_file::MeshFile;
use crate::io::mesh_reading::{Malformed, Place, Solid, TooMany, split};
use crate::math::Vec3;

impl Reader<'_> {
    /// The mesh with its colours; `None` when cancelled.
    ///
    /// # Errors
    /// When there are more vertices than can be numbered.
    pub fn finish(mut self) -> Result<Option<MeshFile>, Malformed> {
        let end = self.cursor.position() + self.cursor.remaining();
        let fours = self.fours.take().unwrap_or_default();
        let of_vertices = std::mem::take(&mut self.vertex_colors);
        let of_vertices = of_vertices.into_linear(self.mesh.positions.len());
        if let Some(first) = self.first_face
            && (self.are_cells || are_tetrahedra(&fours))
        {
            self.mesh.colors = of_vertices;
            return self.into_solid(first, &fours).map(Some);
        }
        let of_faces = self.face_colors.into_linear(self.mesh.triangles.len());
        let are_hidden = of_vertices.is_some() && of_faces.is_some();
        self.mesh.colors = of_vertices;
        if let (Some(colors), false) = (of_faces, are_hidden) {
            let watch = &mut self.watch;
            let go_on = |index| watch.report_item(index, end);
            let split = color_faces(&mut self.mesh, &colors, go_on).map_err(|TooMany| {
                let line = self.cursor.line();
                Malformed::in_line(line, "fewer than 2^32 vertices", "another")
            })?;
            if split.is_none() {
                return Ok(None);
            }
        }
        // Cancelling comes too late here: the work is done.
        let _ = self.watch.report(end);
        let notes = self.notes;
        let hidden = "colours of faces are ignored, as vertices have some";
        let warnings = [
            notes
                .colors
                .found("colours that are not of three or four finite numbers are ignored"),
            notes.face_colors.found(hidden).filter(|_| are_hidden),
            notes.textures_not_finite.counted(
                "texture coordinate that is not finite is taken as (0, 0)",
                "texture coordinates that are not finite are taken as (0, 0)",
            ),
            notes.trailing.counted(
                "line of text after the last face is ignored",
                "lines of text after the last face are ignored",
            ),
        ];
        let warnings = warnings.into_iter().flatten();
        Ok(Some(self.tally.into_file("OFF", self.mesh, warnings)))
    }

    /// The faces around tetrahedra, of which the one at `first` is the first.
    fn into_solid(mut self, first: Place, cells: &[[u32; 4]]) -> Result<MeshFile, Malformed> {
        // Cancelling comes too late here: the text is read.
        let _ = self
            .watch
            .report(self.cursor.position() + self.cursor.remaining());
        let mut solid = Solid::of(self.mesh.positions);
        for corners in cells {
            solid.add_cell(first, corners)?;
        }
        let mut file = solid.into_file("OFF");
        let how = if self.are_cells {
            "values of vertices are ignored"
        } else {
            "all faces have four corners and meet as tetrahedra do: they are taken for these"
        };
        file.warnings.push(how.to_owned());
        file.mesh = TriangleMesh {
            positions: file.mesh.positions,
            triangles: file.mesh.triangles,
            normals: self.mesh.normals,
            texture_coordinates: self.mesh.texture_coordinates,
            colors: self.mesh.colors,
        };
        Ok(file)
    }
}

/// Gives each triangle its colour: vertices become several where those of their triangles differ. `go_on` as in [`split`].
fn color_faces(
    mesh: &mut TriangleMesh,
    colors: &[Vec3],
    go_on: impl FnMut(u64) -> Option<()>,
) -> Result<Option<()>, TooMany> {
    let corners = mesh.triangles.iter().zip(colors);
    let corners = corners.map(|(triangle, &color)| triangle.map(|vertex| (vertex, color)));
    let Some(split) = split(mesh.positions.len(), corners, go_on)? else {
        return Ok(None);
    };
    split.extend(&mut mesh.positions);
    if let Some(normals) = &mut mesh.normals {
        split.extend(normals);
    }
    if let Some(coordinates) = &mut mesh.texture_coordinates {
        split.extend(coordinates);
    }
    mesh.triangles = split.triangles;
    mesh.colors = Some(split.attributes);
    Ok(Some(()))
}
