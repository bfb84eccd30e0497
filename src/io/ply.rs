//! Triangles as a PLY file of the plainest kind: binary little endian, vertices `float x y z`, faces `uchar 3, int × 3`.
//!
//! It is what other programs read without asking questions; normals and colours are left out.

use std::io::{self, Error, ErrorKind, Write};

/// Writes a mesh. `vertices` and `faces` are counts followed by as many items, so that no copy of a large mesh is needed.
///
/// # Errors
/// What `out` returns; and that there are more vertices than the faces' `int` can number.
pub fn write(
    vertices: (u64, impl Iterator<Item = [f32; 3]>),
    faces: (u64, impl Iterator<Item = [u32; 3]>),
    out: &mut dyn Write,
) -> io::Result<()> {
    let (vertex_count, vertices) = vertices;
    let (face_count, faces) = faces;
    if vertex_count > i32::MAX as u64 {
        let message = format!(
            "{vertex_count} vertices are more than a PLY file numbers, {}",
            i32::MAX
        );
        return Err(Error::new(ErrorKind::FileTooLarge, message));
    }
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {vertex_count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {face_count}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for value in vertices.flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
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
        write(
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
        let error = write((1 << 31, vertices), (0, faces), &mut Vec::new());
        assert!(
            error
                .expect_err("too many")
                .to_string()
                .contains("2147483647")
        );
    }
}
