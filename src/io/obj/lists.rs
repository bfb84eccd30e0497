//! From OBJ, whose corners name position, normal and texture coordinate separately, to a mesh with one of each per vertex.

use super::corner::Corner;
use crate::geometry::TriangleMesh;
use crate::io::mesh_reading::{Attribute, TooMany, split};
use crate::math::{DVec2, DVec3, Vec3};

/// The lists of a file that corners name, and what its vertices have of their own.
pub struct Lists {
    /// Of the vertices.
    pub positions: Vec<DVec3>,
    /// Of the vertices, or none.
    pub colors: Option<Vec<Vec3>>,
    /// `None` where the mesh is to have none; else every corner names one that is there.
    pub normals: Option<Vec<DVec3>>,
    /// `None` where the mesh is to have none; a corner that names none that is there has `(0, 0)`.
    pub texture_coordinates: Option<Vec<DVec2>>,
}

impl Lists {
    /// The mesh of these triangles, whose vertices have one normal and one texture coordinate each; `go_on` as in [`split`].
    ///
    /// # Errors
    /// When there are more vertices than can be numbered.
    ///
    /// # Panics
    /// When a corner names no normal where the mesh is to have some.
    pub fn into_mesh(
        self,
        triangles: &[[Corner; 3]],
        go_on: impl FnMut(u64) -> Option<()>,
    ) -> Result<Option<TriangleMesh>, TooMany> {
        let mut mesh = TriangleMesh {
            positions: self.positions,
            colors: self.colors,
            ..TriangleMesh::default()
        };
        let normal = |normals: &[DVec3], corner: &Corner| {
            normals[corner.normal().expect("every corner has a normal") as usize]
        };
        let texture = |textures: &[DVec2], corner: &Corner| {
            let named = corner
                .texture()
                .and_then(|index| textures.get(index as usize));
            named.copied().unwrap_or_default()
        };
        let is_whole = match (&self.normals, &self.texture_coordinates) {
            (None, None) => {
                let plain = |triangle: &[Corner; 3]| triangle.map(|corner| corner.position);
                mesh.triangles = triangles.iter().map(plain).collect();
                Some(())
            }
            (Some(normals), None) => {
                let attribute = |corner: &Corner| normal(normals, corner);
                split_into(&mut mesh, triangles, attribute, go_on)?
                    .map(|normals| mesh.normals = Some(normals))
            }
            (None, Some(textures)) => {
                let attribute = |corner: &Corner| texture(textures, corner);
                split_into(&mut mesh, triangles, attribute, go_on)?
                    .map(|textures| mesh.texture_coordinates = Some(textures))
            }
            (Some(normals), Some(textures)) => {
                let attribute =
                    |corner: &Corner| (normal(normals, corner), texture(textures, corner));
                split_into(&mut mesh, triangles, attribute, go_on)?.map(|attributes| {
                    mesh.normals = Some(attributes.iter().map(|&(normal, _)| normal).collect());
                    let textures = attributes.into_iter().map(|(_, texture)| texture);
                    mesh.texture_coordinates = Some(textures.collect());
                })
            }
        };
        Ok(is_whole.map(|()| mesh))
    }
}

/// Gives `mesh` these triangles, its vertices split where corners differ, and returns the attribute of each vertex.
fn split_into<A: Attribute>(
    mesh: &mut TriangleMesh,
    triangles: &[[Corner; 3]],
    attribute: impl Fn(&Corner) -> A,
    go_on: impl FnMut(u64) -> Option<()>,
) -> Result<Option<Vec<A>>, TooMany> {
    let corners = triangles.iter().map(|triangle| {
        triangle
            .each_ref()
            .map(|corner| (corner.position, attribute(corner)))
    });
    let Some(split) = split(mesh.positions.len(), corners, go_on)? else {
        return Ok(None);
    };
    split.extend(&mut mesh.positions);
    if let Some(colors) = &mut mesh.colors {
        split.extend(colors);
    }
    mesh.triangles = split.triangles;
    Ok(Some(split.attributes))
}
