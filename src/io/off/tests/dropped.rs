//! What is dropped or ignored, and what is not.

use super::*;
use crate::io::Dropped;

#[test]
fn faces_without_area_are_dropped_and_counted() {
    let cases = [
        ("3 0 1 1", "a repeated index"),
        ("3 0 1 4", "a repeated position"),
        ("3 0 2 5", "corners on a line"),
        ("3 0 6 7", "decimals on a line up to their rounding"),
        ("4 0 2 5 0", "a polygon that goes there and back"),
        ("5 0 0 0 1 1", "a polygon of two corners, repeated"),
    ];
    for (face, name) in cases {
        let extra = "1 0 0\n2 2 0\n0.1 0.3 0\n0.3 0.9 0\n";
        let text = format!("OFF\n8 2 0\n{SQUARE}{extra}3 0 1 2\n{face}\n");
        let file = read(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(file.mesh.triangles, [[0, 1, 2]], "{name}");
        assert_eq!(file.dropped.degenerate, 1, "{name}");
        assert_eq!(
            file.warnings,
            ["1 face without area was dropped (line 12)"],
            "{name}"
        );
    }
}

#[test]
fn slivers_and_tiny_triangles_stay() {
    let text =
        "OFF\n6 2 0\n0 0 0\n1 0 0\n0.5 1e-12 0\n0 0 0\n1e-200 0 0\n0 1e-200 0\n3 0 1 2\n3 3 4 5\n";
    let file = read(text).expect("valid");
    assert_eq!(file.mesh.triangles.len(), 2);
    assert_eq!(file.dropped, Dropped::default());
}

#[test]
fn points_and_lines_are_dropped_and_counted() {
    let text = format!("OFF\n4 4 0\n{SQUARE}1 0\n2 0 1\n2 3 3\n3 0 1 2\n");
    let file = read(text).expect("valid");
    assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(
        (
            file.faces,
            file.dropped.too_few_corners,
            file.dropped.total()
        ),
        (4, 3, 3)
    );
    assert_eq!(
        file.warnings,
        ["3 faces with fewer than three corners were dropped (the first on line 7)"]
    );
}

#[test]
fn a_polygon_that_repeats_a_corner_takes_it_once() {
    let text = format!("OFF\n4 2 0\n{SQUARE}4 0 1 2 2\n5 0 0 1 2 3\n");
    let file = read(text).expect("valid");
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 1, 2], [2, 3, 0]]);
    assert_eq!((file.polygons, file.dropped.total()), (2, 0));
}

#[test]
fn unused_and_duplicate_vertices_stay_where_they_are() {
    let text = format!("OFF\n6 1 0\n9 9 9\n{SQUARE}0 0 0\n3 5 2 3\n");
    let mesh = read(text).expect("valid").mesh;
    assert_eq!((mesh.positions.len(), mesh.triangles), (6, vec![[5, 2, 3]]));
}

#[test]
fn what_is_ignored_is_said_once() {
    let text = format!(
        "OFF\n4 2 0\n{}3 0 1 2 9 9 9\n3 0 2 3\nthe end\n",
        SQUARE.replace('\n', " 1 0 0\n")
    );
    assert_eq!(
        read(text).expect("valid").warnings,
        [
            "colours of faces are ignored, as vertices have some (the first on line 7)",
            "1 line of text after the last face is ignored (line 9)"
        ]
    );
    let text = format!(
        "STOFF\n4 1 0\n{}3 0 1 2 7\n",
        SQUARE.replace('\n', " 1 nan\n")
    );
    assert_eq!(
        read(text).expect("valid").warnings,
        [
            "colours that are not of three or four finite numbers are ignored (the first on line 7)",
            "4 texture coordinates that are not finite are taken as (0, 0) (the first on line 3)"
        ]
    );
}
