//! Meshes as STL: binary where `f32` holds all positions exactly, else text.

use super::binary::{FACET, TITLE};
use crate::geometry::{TriangleMesh, face_normal};
use crate::io::mesh_writing::{Decimals, fit_f32};
use crate::math::DVec3;
use std::io::{self, Error, ErrorKind, Write};

/// Writes the triangles of a mesh: a binary file where `f32` holds all positions as they are, else a text.
///
/// Reading it gives the same triangles in the same order, apart from those without area, which readers drop. What vertices share
/// besides their position is lost, and so are vertices without triangle and normals.
///
/// # Errors
/// What `out` returns; and that there are more triangles than a binary file numbers.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let facets = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
    if fit_f32(&mesh.positions) {
        write_binary(facets, out)
    } else {
        write_text(facets, out)
    }
}

fn write_binary(
    facets: impl ExactSizeIterator<Item = [DVec3; 3]>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let count = u32::try_from(facets.len()).map_err(|_| {
        let message = format!(
            "{} triangles are more than a binary STL file numbers, {}",
            facets.len(),
            u32::MAX
        );
        Error::new(ErrorKind::FileTooLarge, message)
    })?;
    write!(out, "{:TITLE$}", "Triangles in binary STL by RayMini")?;
    out.write_all(&count.to_le_bytes())?;
    for [a, b, c] in facets {
        let normal = face_normal([a, b, c]).unwrap_or_default();
        let mut facet = [0; FACET];
        let numbers = facet.as_chunks_mut().0.iter_mut();
        let values = [normal, a, b, c].map(|vector| vector.as_vec3().to_array());
        for (bytes, value) in numbers.zip(values.as_flattened()) {
            *bytes = value.to_le_bytes();
        }
        out.write_all(&facet)?;
    }
    Ok(())
}

fn write_text(facets: impl Iterator<Item = [DVec3; 3]>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "solid mesh")?;
    for corners in facets {
        let normal = face_normal(corners).unwrap_or_default();
        write!(
            out,
            "facet normal {}\nouter loop\n",
            Decimals(&normal.to_array())
        )?;
        for corner in corners {
            writeln!(out, "vertex {}", Decimals(&corner.to_array()))?;
        }
        write!(out, "endloop\nendfacet\n")?;
    }
    writeln!(out, "endsolid mesh")
}
