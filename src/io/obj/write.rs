//! Meshes as OBJ text, in numbers that read back as the same `f64`.

use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::{Decimals, encoded};
use crate::io::mtl;
use std::io::{self, Write};

/// Writes a mesh as the text of an OBJ file, with normals, texture coordinates and colours where it has any.
///
/// Reading the text gives the same mesh, apart from triangles without area, which readers drop, the normals and texture coordinates
/// of vertices that no triangle uses, and the last digit of colours that no byte stands for.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    write_parts(mesh, None, &[], out)
}

/// [`write()`] of a mesh with materials: those of the file called `library`, and from which triangle on each is worn, in order.
///
/// # Errors
/// What `out` returns.
pub fn write_parts(
    mesh: &TriangleMesh,
    library: Option<&str>,
    materials: &[(usize, &str)],
    out: &mut dyn Write,
) -> io::Result<()> {
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    let mut materials = materials.iter().peekable();
    for (vertex, &position) in mesh.positions.iter().enumerate() {
        write!(out, "v {}", Decimals(&position.to_array()))?;
        if let Some(colors) = &mesh.colors {
            let channels = colors[vertex].to_array();
            let channels = channels.map(|channel| f64::from(encoded(channel)));
            write!(out, " {}", Decimals(&channels))?;
        }
        writeln!(out)?;
    }
    for normal in mesh.normals.iter().flatten() {
        writeln!(out, "vn {}", Decimals(&normal.to_array()))?;
    }
    for coordinate in mesh.texture_coordinates.iter().flatten() {
        writeln!(out, "vt {}", Decimals(&coordinate.to_array()))?;
    }
    let (has_texture, has_normal) = (mesh.texture_coordinates.is_some(), mesh.normals.is_some());
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        while let Some((_, name)) = materials.next_if(|(first, _)| *first <= index) {
            writeln!(out, "usemtl {}", mtl::plain(name))?;
        }
        write!(out, "f")?;
        for corner in triangle.map(|vertex| u64::from(vertex) + 1) {
            match (has_texture, has_normal) {
                (false, false) => write!(out, " {corner}")?,
                (true, false) => write!(out, " {corner}/{corner}")?,
                (false, true) => write!(out, " {corner}//{corner}")?,
                (true, true) => write!(out, " {corner}/{corner}/{corner}")?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
