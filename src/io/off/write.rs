use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::Decimals;
use std::io::{self, Write};

/// Writes a mesh as the text of an OFF file, `NOFF` if it has normals.
///
/// Reading the text gives the same mesh, apart from triangles without area, which readers drop.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let keyword = if mesh.normals.is_some() {
        "NOFF"
    } else {
        "OFF"
    };
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    write!(out, "{keyword}\n{vertices} {faces} 0\n")?;
    for (vertex, &position) in mesh.positions.iter().enumerate() {
        write!(out, "{}", Decimals(&position.to_array()))?;
        if let Some(normals) = &mesh.normals {
            write!(out, " {}", Decimals(&normals[vertex].to_array()))?;
        }
        writeln!(out)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}
