use crate::geometry::TriangleMesh;
use crate::math::DVec3;
use std::fmt::Write;

/// The mesh as the text of an OFF file, `NOFF` if it has normals.
///
/// Every number is the shortest that reads back as the same `f64`; reading the text gives the same mesh, apart from
/// triangles without area, which readers drop.
#[must_use]
pub fn write(mesh: &TriangleMesh) -> String {
    let keyword = if mesh.normals.is_some() {
        "NOFF"
    } else {
        "OFF"
    };
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let mut text = format!("{keyword}\n{vertices} {faces} 0\n");
    for (vertex, &position) in mesh.positions.iter().enumerate() {
        push_vector(&mut text, position);
        if let Some(normals) = &mesh.normals {
            text.push(' ');
            push_vector(&mut text, normals[vertex]);
        }
        text.push('\n');
    }
    for [a, b, c] in &mesh.triangles {
        push(&mut text, format_args!("3 {a} {b} {c}\n"));
    }
    text
}

fn push_vector(text: &mut String, vector: DVec3) {
    push_number(text, vector.x);
    text.push(' ');
    push_number(text, vector.y);
    text.push(' ');
    push_number(text, vector.z);
}

/// Appends a number; plain digits would be hundreds long for the extreme ones.
fn push_number(text: &mut String, value: f64) {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) {
        push(text, format_args!("{value}"));
    } else {
        push(text, format_args!("{value:e}"));
    }
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments)
        .expect("writing to a string cannot fail");
}
