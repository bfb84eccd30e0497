//! Colours, normals and texture coordinates.

use super::*;
use crate::math::{Vec3, color::linear_from_srgb};

/// What the colour of a vertex is written as, and what it means.
#[test]
fn colors_of_vertices_are_srgb_to_one_or_to_255() {
    let linear = |encoded: [f32; 3]| Vec3::from(encoded.map(linear_from_srgb));
    let cases = [
        ("OFF", "255 0 51", linear([1.0, 0.0, 0.2])),
        ("COFF", "255 0 51", linear([1.0, 0.0, 0.2])),
        ("COFF", "255 0 51 255", linear([1.0, 0.0, 0.2])),
        // Nearly black: the alpha tells.
        ("COFF", "1 0 1 255", linear([1.0 / 255.0, 0.0, 1.0 / 255.0])),
        ("COFF", "0.5 0 1", linear([0.5, 0.0, 1.0])),
        ("COFF", ".5 0. 1.0 0.25", linear([0.5, 0.0, 1.0])),
        ("COFF", "1 0 1 1", Vec3::new(1.0, 0.0, 1.0)),
    ];
    for (keyword, color, expected) in cases {
        let vertices = SQUARE.replace('\n', &format!(" {color}\n"));
        let file = read(format!("{keyword}\n4 1 0\n{vertices}3 0 1 2\n")).expect("valid");
        assert_eq!(
            file.mesh.colors,
            Some(vec![expected; 4]),
            "{keyword} {color}"
        );
        assert_eq!(file.warnings, Vec::<String>::new());
    }
    let text = "OFF\n3 1 0\n0 0 0\n1 0 0 0 0 0\n0 1 0\n3 0 1 2\n";
    let colors = read(text).expect("valid").mesh.colors;
    assert_eq!(colors, Some(vec![Vec3::ONE, Vec3::ZERO, Vec3::ONE]));
}

#[test]
fn colors_of_faces_split_the_vertices_between_them() {
    let faces = "3 0 1 2 255 0 0\n3 0 2 3 0 0 255 128\n3 0 3 1 255 0 0\n3 1 3 2\n";
    let vertices = SQUARE.replace('\n', " 0 0 1\n");
    let file = read(format!("NOFF\n4 4 0\n{vertices}{faces}")).expect("valid");
    let mesh = file.mesh;
    let expected = [[0, 1, 2], [4, 5, 3], [0, 6, 1], [7, 8, 9]];
    assert_eq!(mesh.triangles, expected);
    let corners = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    let colors = [Vec3::X, Vec3::Z, Vec3::X, Vec3::ONE];
    for (index, (corners, color)) in corners.into_iter().zip(colors).enumerate() {
        let places = corners.map(|vertex| mesh.positions[vertex]);
        assert_eq!(mesh.corners(index), places);
        let of_corners = mesh.triangles[index].map(|vertex| {
            let colors = mesh.colors.as_ref().expect("some");
            colors[vertex as usize]
        });
        assert_eq!(of_corners, [color; 3]);
    }
    assert_eq!(mesh.normals, Some(vec![DVec3::Z; 10]));
    assert_eq!(file.warnings, Vec::<String>::new());
}

#[test]
fn every_attribute_is_found_where_the_keyword_says() {
    let (normal, texture) = (DVec3::new(0.0, 0.6, 0.8), DVec2::new(0.25, -2.0));
    let cases = [
        ("STCNOFF", "0 0.6 0.8 255 0 0 255 0.25 -2"),
        ("STCNOFF", "0 0.6 0.8 255 0 0 0.25 -2"),
        ("NCSTOFF", "255 0 0 255 0 0.6 0.8 0.25 -2"),
        ("NCSTOFF", "255 0 0 0 0.6 0.8 0.25 -2"),
    ];
    for (keyword, numbers) in cases {
        let vertices = SQUARE.replace('\n', &format!(" {numbers}\n"));
        let mesh = read(format!("{keyword}\n4 1 0\n{vertices}3 0 1 2\n"));
        let mesh = mesh.expect("valid").mesh;
        assert_eq!(mesh.normals, Some(vec![normal; 4]), "{keyword} {numbers}");
        assert_eq!(mesh.texture_coordinates, Some(vec![texture; 4]));
        assert_eq!(mesh.colors, Some(vec![Vec3::X; 4]));
    }
}

#[test]
fn normals_are_kept_as_written() {
    let text = "NOFF\n3 1 0\n0 0 0 0 0 2\n1 0 0 0 0 0\n0 1 0 1 0 0\n3 0 1 2\n";
    let normals = read(text).expect("valid").mesh.normals;
    assert_eq!(normals, Some(vec![DVec3::Z * 2.0, DVec3::ZERO, DVec3::X]));
}
