//! Meshes as OFF text, in numbers that read back as the same `f64`.

use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::{Decimals, encoded, srgb_byte};
use crate::math::Vec3;
use std::io::{self, Write};

/// Writes a mesh as the text of an OFF file, with normals (`N` in its keyword), colours (`C`) and texture coordinates (`ST`) where it has
/// any. Colours are whole numbers where bytes stand for all of them.
///
/// Reading the text gives the same mesh, apart from triangles without area, which readers drop, and the last digit of colours that
/// no byte stands for.
///
/// # Errors
/// What `out` returns.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let prefixes = [
        (mesh.texture_coordinates.is_some(), "ST"),
        (mesh.colors.is_some(), "C"),
        (mesh.normals.is_some(), "N"),
    ];
    for (_, prefix) in prefixes.iter().filter(|(is_there, _)| *is_there) {
        write!(out, "{prefix}")?;
    }
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    write!(out, "OFF\n{vertices} {faces} 0\n")?;
    let mut channels = mesh.colors.iter().flatten().flat_map(Vec3::to_array);
    let are_bytes = channels.all(|channel| srgb_byte(channel).is_some());
    for (vertex, &position) in mesh.positions.iter().enumerate() {
        write!(out, "{}", Decimals(&position.to_array()))?;
        if let Some(normals) = &mesh.normals {
            write!(out, " {}", Decimals(&normals[vertex].to_array()))?;
        }
        if let Some(colors) = &mesh.colors {
            write_color(colors[vertex], are_bytes, out)?;
        }
        if let Some(coordinates) = &mesh.texture_coordinates {
            write!(out, " {}", Decimals(&coordinates[vertex].to_array()))?;
        }
        writeln!(out)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}

/// Writes a colour and that it is opaque, which also tells how far its numbers go.
fn write_color(color: Vec3, as_bytes: bool, out: &mut dyn Write) -> io::Result<()> {
    let channels = color.to_array();
    if as_bytes {
        let bytes = channels.map(|channel| srgb_byte(channel).unwrap_or_default());
        let [red, green, blue] = bytes;
        write!(out, " {red} {green} {blue} 255")
    } else {
        let channels = channels.map(|channel| f64::from(encoded(channel)));
        write!(out, " {} 1", Decimals(&channels))
    }
}
