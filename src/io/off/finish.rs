//! What an OFF file that is read becomes: faces with their colours.

use super::Reader;
use crate::geometry::TriangleMesh;
use crate::io::mesh_file::MeshFile;
use crate::io::mesh_reading::{Malformed, TooMany, split};
use crate::math::Vec3;

impl Reader<'_> {
    /// The mesh with its colours; `None` when cancelled.
    ///
    /// # Errors
    /// When there are more vertices than can be numbered.
    pub fn finish(mut self) -> Result<Option<MeshFile>, Malformed> {
        let end = self.cursor.position() + self.cursor.remaining();
        let of_vertices = self.vertex_colors.into_linear(self.mesh.positions.len());
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
