//! Tetrahedra, in the two ways they are written.

use super::*;
use crate::io::mesh_reading::all_faces;
use crate::io::mesh_reading::trials::{CUBE, FILLINGS, area_and_volume};
use crate::math::Vec3;

/// As faces of four corners, and as four indices alone, with values of the vertices; neither is taken for the other, nor faces for them.
#[test]
fn tetrahedra_are_told_from_faces() {
    let vertices = |more: &str| {
        CUBE.map(|[x, y, z]| format!("{x} {y} {z}{more}\n"))
            .concat()
    };
    for (filling, inside) in FILLINGS.into_iter().zip([4, 6, 18]) {
        let lines = |begin: &str| {
            let line = |[a, b, c, d]: &[u32; 4]| format!("{begin}{a} {b} {c} {d}\n");
            filling.iter().map(line).collect::<String>()
        };
        let count = filling.len();
        let faces = format!("OFF\n9 {count} 0\n{}{}", vertices(""), lines("4 "));
        let alone = format!("9 {count}\n{}{}", vertices(" 0.25"), lines(""));
        let colored = format!(
            "COFF\n9 {count} 0\n{}{}",
            vertices(" 255 0 0 255"),
            lines("4 ")
        );
        let met = "all faces have four corners and meet as tetrahedra do: they are taken for these";
        for (text, how) in [
            (&faces, met),
            (&colored, met),
            (&alone, "values of vertices are ignored"),
        ] {
            let file = read(text).expect("valid");
            let (area, volume) = area_and_volume(&file);
            assert!((area - 6.0).abs() < 1e-14 && (volume - 1.0).abs() < 1e-14);
            let expected = format!("12 faces outside are shown and {inside} inside are not");
            assert!(file.warnings[0].contains(&expected), "{:?}", file.warnings);
            assert_eq!(file.warnings[1], how);
            let inner = all_faces(&file.mesh.positions, &file.cells);
            assert_eq!(inner.triangles.len(), 12 + inside);
            let red = Some(vec![Vec3::X; 9]);
            assert_eq!(file.mesh.colors, red.filter(|_| text == &colored));
        }
    }
    // Without keyword and edges, faces behind a colour's number each.
    let text = format!("4 2\n{}3 0 1 2\n3 0 2 3\n", SQUARE.replace('\n', " 7\n"));
    assert_eq!(outcome(&text), Ok(vec![[0, 1, 2], [0, 2, 3]]));
    let text = format!("4 2\n{}4 0 1 2 3\n3 0 2 3\n", SQUARE.replace('\n', " 7\n"));
    assert_eq!(read(text).expect("valid").faces, 2);
    let text = format!("4 2\n{}0 1 2 4\n0 1 2 3\n", SQUARE.replace('\n', " 7\n"));
    assert_eq!(
        outcome(&text),
        Err("6: expected four vertex indices below 4, found \"4\"".to_owned())
    );
    let text = format!("4 2\n{}0 1 2 3\n", SQUARE.replace('\n', " 7\n"));
    assert_eq!(
        outcome(&text),
        Err("6: expected tetrahedron 2 of 2, found the end of the file".to_owned())
    );
}
