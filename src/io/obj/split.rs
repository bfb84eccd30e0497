use super::corner::Corner;
use crate::geometry::TriangleMesh;
use crate::io::mesh_reading::Malformed;
use crate::math::{DVec2, DVec3, Vec3};
use foldhash::fast::RandomState;
use std::collections::HashMap;

/// The lists of a file that corners name, and what its vertices have of their own.
pub struct Lists {
    /// Of the vertices.
    pub positions: Vec<DVec3>,
    /// Of the vertices, or none.
    pub colors: Option<Vec<Vec3>>,
    /// `None` where the mesh is to have none.
    pub normals: Option<Vec<DVec3>>,
    /// `None` where the mesh is to have none; a corner that names none that is there has `(0, 0)`.
    pub texture_coordinates: Option<Vec<DVec2>>,
}

/// The mesh whose vertices have one normal and one texture coordinate each: those of the file, and further ones where corners at one
/// position have others than the first there. A position without corner has zeros.
///
/// `go_on` is asked at every triangle, by its index; `None` when it says so. `last_line`: that of the text, for the error.
///
/// # Errors
/// When there are more vertices than can be numbered.
///
/// # Panics
/// When a corner names no normal where the mesh is to have some, or what is not there.
pub fn by_attributes(
    lists: Lists,
    triangles: &[[Corner; 3]],
    last_line: u64,
    mut go_on: impl FnMut(u64) -> Option<()>,
) -> Result<Option<TriangleMesh>, Malformed> {
    let Lists {
        positions,
        colors,
        normals,
        texture_coordinates,
    } = lists;
    let attributes = |corner: &Corner| Attributes {
        normal: normals.as_deref().map_or(DVec3::ZERO, |normals| {
            normals[corner.normal().expect("every corner has a normal") as usize]
        }),
        texture: texture_coordinates.as_deref().map_or(DVec2::ZERO, |list| {
            let named = corner.texture().and_then(|index| list.get(index as usize));
            named.copied().unwrap_or_default()
        }),
    };
    let mut of_positions = vec![None; positions.len()];
    let mut further = Further {
        positions,
        colors,
        attributes: Vec::new(),
        vertices: HashMap::default(),
    };
    let mut split = Vec::with_capacity(triangles.len());
    for (index, corners) in (0..).zip(triangles) {
        if go_on(index).is_none() {
            return Ok(None);
        }
        let mut triangle = [0; 3];
        for (vertex, corner) in triangle.iter_mut().zip(corners) {
            let attributes = attributes(corner);
            let of_position: &mut Option<Attributes> = &mut of_positions[corner.position as usize];
            *vertex = if *of_position.get_or_insert(attributes) == attributes {
                corner.position
            } else {
                further.vertex(corner.position, attributes).ok_or_else(|| {
                    Malformed::in_line(last_line, "fewer than 2^32 vertices", "another")
                })?
            };
        }
        split.push(triangle);
    }
    let of_positions = of_positions.into_iter().map(Option::unwrap_or_default);
    let (has_normals, has_texture) = (normals.is_some(), texture_coordinates.is_some());
    drop((normals, texture_coordinates));
    let all: Vec<Attributes> = of_positions.chain(further.attributes).collect();
    Ok(Some(TriangleMesh {
        positions: further.positions,
        triangles: split,
        normals: has_normals.then(|| all.iter().map(|vertex| vertex.normal).collect()),
        texture_coordinates: has_texture.then(|| all.iter().map(|vertex| vertex.texture).collect()),
        colors: further.colors,
    }))
}

/// What may differ between the corners at one position; zeros for what the mesh is not to have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Attributes {
    normal: DVec3,
    texture: DVec2,
}

/// The vertices beyond those of the file.
struct Further {
    /// Those of the file come first.
    positions: Vec<DVec3>,
    /// Likewise.
    colors: Option<Vec<Vec3>>,
    attributes: Vec<Attributes>,
    vertices: HashMap<(u32, [u64; 5]), u32, RandomState>,
}

impl Further {
    /// The vertex at a position of the file, with these attributes; `None` where there are 2³² already.
    fn vertex(&mut self, position: u32, attributes: Attributes) -> Option<u32> {
        let next = u32::try_from(self.positions.len()).ok()?;
        let Attributes { normal, texture } = attributes;
        // −0 + 0 is 0.
        let bits = |value: f64| (value + 0.0).to_bits();
        let key = [normal.x, normal.y, normal.z, texture.x, texture.y].map(bits);
        let vertex = *self.vertices.entry((position, key)).or_insert(next);
        if vertex == next {
            self.positions.push(self.positions[position as usize]);
            if let Some(colors) = &mut self.colors {
                colors.push(colors[position as usize]);
            }
            self.attributes.push(attributes);
        }
        Some(vertex)
    }
}
