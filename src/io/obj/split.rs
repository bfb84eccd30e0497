use super::corner::Corner;
use crate::geometry::TriangleMesh;
use crate::io::mesh_reading::Malformed;
use crate::math::DVec3;
use foldhash::fast::RandomState;
use std::collections::HashMap;

/// The mesh whose vertices have one normal each: those of `positions`, and further ones where corners at one position have another
/// normal than the first there. A position without corner has the normal 0.
///
/// `go_on` is asked at every triangle, by its index; `None` when it says so. `last_line`: that of the text, for the error.
///
/// # Errors
/// When there are more vertices than can be numbered.
///
/// # Panics
/// When a corner names no normal, or what is not there.
pub fn by_normals(
    positions: Vec<DVec3>,
    normals: &[DVec3],
    triangles: &[[Corner; 3]],
    last_line: u64,
    mut go_on: impl FnMut(u64) -> Option<()>,
) -> Result<Option<TriangleMesh>, Malformed> {
    let mut of_positions = vec![None; positions.len()];
    let mut further = Further {
        positions,
        normals: Vec::new(),
        vertices: HashMap::default(),
    };
    let mut split = Vec::with_capacity(triangles.len());
    for (index, corners) in (0..).zip(triangles) {
        if go_on(index).is_none() {
            return Ok(None);
        }
        let mut triangle = [0; 3];
        for (vertex, corner) in triangle.iter_mut().zip(corners) {
            let normal = corner.normal().expect("every corner has a normal");
            let normal = normals[normal as usize];
            let of_position: &mut Option<DVec3> = &mut of_positions[corner.position as usize];
            *vertex = if *of_position.get_or_insert(normal) == normal {
                corner.position
            } else {
                further.vertex(corner.position, normal).ok_or_else(|| {
                    Malformed::in_line(last_line, "fewer than 2^32 vertices", "another")
                })?
            };
        }
        split.push(triangle);
    }
    let of_positions = of_positions.into_iter().map(Option::unwrap_or_default);
    Ok(Some(TriangleMesh {
        positions: further.positions,
        triangles: split,
        normals: Some(of_positions.chain(further.normals).collect()),
    }))
}

/// The vertices beyond those of the file.
struct Further {
    /// Those of the file come first.
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    vertices: HashMap<(u32, [u64; 3]), u32, RandomState>,
}

impl Further {
    /// The vertex at a position of the file, with this normal; `None` where there are 2³² already.
    fn vertex(&mut self, position: u32, normal: DVec3) -> Option<u32> {
        let next = u32::try_from(self.positions.len()).ok()?;
        // −0 + 0 is 0.
        let bits = (normal + DVec3::ZERO).to_array().map(f64::to_bits);
        let vertex = *self.vertices.entry((position, bits)).or_insert(next);
        if vertex == next {
            self.positions.push(self.positions[position as usize]);
            self.normals.push(normal);
        }
        Some(vertex)
    }
}
