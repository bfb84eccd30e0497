//! Triangles as a PLY file, binary little endian, as other programs read it without asking questions.

use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::{encoded, fit_f32, srgb_byte};
use crate::math::Vec3;
use std::io::{self, Error, ErrorKind, Write};

/// Writes a mesh, with normals, texture coordinates and colours where it has any. Numbers are `float` where that holds them all as
/// they are, else `double`, and colours `uchar` where bytes stand for all of them: the file reads back as the same mesh, but for
/// triangles without area, which readers drop, and for the last digit of colours that no byte stands for.
///
/// # Errors
/// What `out` returns; and that there are more vertices than the faces' `int` can number.
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let normals = mesh.normals.as_deref();
    let coordinates = mesh.texture_coordinates.as_deref();
    let colors = mesh.colors.as_deref();
    let type_of = |is_float| if is_float { "float" } else { "double" };
    let short_positions = fit_f32(&mesh.positions);
    let short_normals = fit_f32(normals.unwrap_or_default());
    let short_coordinates = coordinates.unwrap_or_default().iter();
    let short_coordinates = short_coordinates
        .copied()
        .all(|uv| uv.as_vec2().as_dvec2() == uv);
    let channels = || colors.unwrap_or_default().iter().flat_map(Vec3::to_array);
    let byte_colors = channels().all(|channel| srgb_byte(channel).is_some());

    let mut properties: Vec<(&str, &[&str])> = vec![(type_of(short_positions), &["x", "y", "z"])];
    if normals.is_some() {
        properties.push((type_of(short_normals), &["nx", "ny", "nz"]));
    }
    if coordinates.is_some() {
        properties.push((type_of(short_coordinates), &["s", "t"]));
    }
    if colors.is_some() {
        let kind = if byte_colors { "uchar" } else { "float" };
        properties.push((kind, &["red", "green", "blue"]));
    }
    let faces = mesh.triangles.len() as u64;
    write_header(mesh.positions.len() as u64, &properties, faces, out)?;
    for (vertex, position) in mesh.positions.iter().enumerate() {
        write_numbers(&position.to_array(), short_positions, out)?;
        if let Some(normals) = normals {
            write_numbers(&normals[vertex].to_array(), short_normals, out)?;
        }
        if let Some(coordinates) = coordinates {
            write_numbers(&coordinates[vertex].to_array(), short_coordinates, out)?;
        }
        for channel in colors.iter().flat_map(|colors| colors[vertex].to_array()) {
            match srgb_byte(channel).filter(|_| byte_colors) {
                Some(byte) => out.write_all(&[byte])?,
                None => out.write_all(&encoded(channel).to_le_bytes())?,
            }
        }
    }
    write_faces(mesh.triangles.iter().copied(), out)
}

/// Writes triangles of `f32`. `vertices` and `faces` are counts followed by as many items, so that no copy of a large mesh is
/// needed.
///
/// # Errors
/// Those of [`write()`].
pub fn write_triangles(
    vertices: (u64, impl Iterator<Item = [f32; 3]>),
    faces: (u64, impl Iterator<Item = [u32; 3]>),
    out: &mut dyn Write,
) -> io::Result<()> {
    let (vertex_count, vertices) = vertices;
    let (face_count, faces) = faces;
    let properties: [(&str, &[&str]); 1] = [("float", &["x", "y", "z"])];
    write_header(vertex_count, &properties, face_count, out)?;
    for value in vertices.flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
    write_faces(faces, out)
}

/// `properties` of the vertices: a type, and the names of numbers of it.
fn write_header(
    vertices: u64,
    properties: &[(&str, &[&str])],
    faces: u64,
    out: &mut dyn Write,
) -> io::Result<()> {
    if vertices > i32::MAX as u64 {
        let message = format!(
            "{vertices} vertices are more than a PLY file numbers, {}",
            i32::MAX
        );
        return Err(Error::new(ErrorKind::FileTooLarge, message));
    }
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n"
    )?;
    for (kind, names) in properties {
        for name in *names {
            writeln!(out, "property {kind} {name}")?;
        }
    }
    write!(
        out,
        "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

#[expect(clippy::cast_possible_truncation, reason = "where nothing is lost")]
fn write_numbers(numbers: &[f64], is_float: bool, out: &mut dyn Write) -> io::Result<()> {
    for &number in numbers {
        if is_float {
            out.write_all(&(number as f32).to_le_bytes())?;
        } else {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    Ok(())
}

fn write_faces(faces: impl Iterator<Item = [u32; 3]>, out: &mut dyn Write) -> io::Result<()> {
    for corners in faces {
        out.write_all(&[3])?;
        for corner in corners {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Read back by the header's words and fixed strides, as a program without a PLY library does.
    #[test]
    fn a_mesh_is_found_in_its_bytes() {
        let vertices = [[0.0_f32, -1.5, 2.0], [1.0, 0.0, 0.25], [3.0, 1e30, -0.0]];
        let faces = [[0_u32, 1, 2], [2, 1, 0]];
        let mut bytes = Vec::new();
        write_triangles(
            (3, vertices.into_iter()),
            (2, faces.into_iter()),
            &mut bytes,
        )
        .expect("a vector takes all");

        let end = b"end_header\n";
        let header = bytes.windows(end.len()).position(|part| part == end);
        let (header, data) = bytes.split_at(header.expect("there is an end") + end.len());
        let lines: Vec<_> = str::from_utf8(header).expect("text").lines().collect();
        assert_eq!(
            lines,
            [
                "ply",
                "format binary_little_endian 1.0",
                "element vertex 3",
                "property float x",
                "property float y",
                "property float z",
                "element face 2",
                "property list uchar int vertex_indices",
                "end_header",
            ]
        );
        assert_eq!(data.len(), 3 * 12 + 2 * 13);
        for (vertex, bytes) in vertices.iter().zip(data.chunks(12)) {
            let read: Vec<_> = bytes
                .as_chunks()
                .0
                .iter()
                .map(|&b| f32::from_le_bytes(b))
                .collect();
            assert_eq!(read, vertex);
        }
        for (face, bytes) in faces.iter().zip(data[36..].chunks(13)) {
            assert_eq!(bytes[0], 3);
            let corners = bytes[1..].as_chunks().0;
            let read: Vec<_> = corners.iter().map(|&b| u32::from_le_bytes(b)).collect();
            assert_eq!(read, face);
        }
    }

    #[test]
    fn more_vertices_than_can_be_numbered_are_refused() {
        let (vertices, faces) = (std::iter::empty(), std::iter::empty());
        let error = write_triangles((1 << 31, vertices), (0, faces), &mut Vec::new());
        assert!(
            error
                .expect_err("too many")
                .to_string()
                .contains("2147483647")
        );
    }
}
