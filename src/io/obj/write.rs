use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::Decimals;
use std::io::{self, Write};

/// Writes a mesh as the text of an OBJ file, with its normals where it has any.
///
/// Reading the text gives the same mesh, apart from triangles without area, which readers drop, and the normals of vertices that
/// no triangle uses.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    for &position in &mesh.positions {
        writeln!(out, "v {}", Decimals(position))?;
    }
    for &normal in mesh.normals.iter().flatten() {
        writeln!(out, "vn {}", Decimals(normal))?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        if mesh.normals.is_some() {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        } else {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}
