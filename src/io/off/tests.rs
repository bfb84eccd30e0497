use super::*;
use crate::geometry::face_normal;
use crate::io::Dropped;
use crate::io::mesh_reading::all_faces;
use crate::io::mesh_reading::trials::{self, CUBE, FILLINGS, area_and_volume};
use crate::math::{Vec3, color::linear_from_srgb};

/// Four vertices, one line each; the tests put a header before them and faces behind.
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

fn read(text: impl AsRef<[u8]>) -> Result<MeshFile, Malformed> {
    trials::read(parse, text.as_ref())
}

/// The triangles, or the error as a user sees it behind the path.
fn outcome(text: &str) -> Result<Vec<[u32; 3]>, String> {
    match read(text) {
        Ok(file) => Ok(file.mesh.triangles),
        Err(error) => Err(error.to_string().replacen("line ", "", 1)),
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn every_way_to_write_a_square_gives_its_two_triangles() {
    let faces = "3 0 1 2\n3 0 2 3\n";
    let cases = [
        ("plain", format!("OFF\n4 2 0\n{SQUARE}{faces}")),
        (
            "counts on the keyword's line",
            format!("OFF 4 2 0\n{SQUARE}{faces}"),
        ),
        (
            "counts glued to the keyword",
            format!("OFF4 2 0\n{SQUARE}{faces}"),
        ),
        ("no edge count", format!("OFF\n4 2\n{SQUARE}{faces}")),
        (
            "a nonsense edge count",
            format!("OFF\n4 2 -1\n{SQUARE}{faces}"),
        ),
        (
            "counts on three lines",
            format!("OFF\n4\n2\n0\n{SQUARE}{faces}"),
        ),
        ("no keyword", format!("4 2 0\n{SQUARE}{faces}")),
        (
            "no keyword and no edge count",
            format!("4 2\n{SQUARE}{faces}"),
        ),
        ("a small keyword", format!("off\n4 2 0\n{SQUARE}{faces}")),
        (
            "a byte order mark",
            format!("\u{FEFF}OFF\n4 2 0\n{SQUARE}{faces}"),
        ),
        (
            "comments before everything",
            format!("# a\n#\n \t# b\nOFF # c\n# d\n4 2 0 # e\n{SQUARE}{faces}# f"),
        ),
        (
            "comments behind data",
            format!("OFF\n4 2 0\n{}{faces}", SQUARE.replace('\n', "#1 2 3\n")),
        ),
        (
            "comments between lines",
            format!("OFF\n4 2 0\n{}{faces}", SQUARE.replace('\n', "\n# 9 9 9\n")),
        ),
        (
            "blank lines",
            format!(
                "\n\nOFF\n\n4 2 0\n\n{}{faces}\n\n",
                SQUARE.replace('\n', "\n \n\t\n")
            ),
        ),
        (
            "CR LF",
            format!("OFF\n4 2 0\n{SQUARE}{faces}").replace('\n', "\r\n"),
        ),
        (
            "lone CR",
            format!("OFF\n4 2 0\n{SQUARE}{faces}").replace('\n', "\r"),
        ),
        (
            "tabs",
            format!("OFF\n4 2 0\n{SQUARE}{faces}").replace(' ', "\t"),
        ),
        (
            "several and trailing blanks",
            format!("OFF\n4 2 0\n{SQUARE}{faces}")
                .replace(' ', "   ")
                .replace('\n', " \t \n "),
        ),
        (
            "no final newline",
            format!("OFF\n4 2 0\n{SQUARE}{faces}").trim_end().to_owned(),
        ),
        (
            "vertices split over lines",
            format!("OFF\n4 2 0\n{}{faces}", SQUARE.replace(' ', "\n")),
        ),
        (
            "all vertices on one line",
            format!("OFF\n4 2 0\n{}\n{faces}", SQUARE.replace('\n', " ")),
        ),
        (
            "faces split over lines",
            format!("OFF\n4 2 0\n{SQUARE}3 0\n1\n2\n3\n0 2\n3"),
        ),
        (
            "numbers in every spelling",
            format!("OFF\n4 2 0\n+0.0 0. -0\n.1e1 0 0e9\n1 1.0E+0 0\n000 1e-0 0\n{faces}"),
        ),
        (
            "integer colours behind faces",
            format!("OFF\n4 2 0\n{SQUARE}3 0 1 2 255 0 0\n3 0 2 3 0 255 0 128\n"),
        ),
        (
            "real colours behind faces",
            format!("OFF\n4 2 0\n{SQUARE}3 0 1 2 1.0 0.5 0\n3 0 2 3\n"),
        ),
        (
            "a colour index behind faces",
            format!("OFF\n4 2 0\n{SQUARE}3 0 1 2 7\n3 0 2 3 7\n"),
        ),
        (
            "integer colours behind vertices",
            format!("OFF\n4 2 0\n{}{faces}", SQUARE.replace('\n', " 255 0 0\n")),
        ),
        (
            "real colours behind vertices",
            format!(
                "OFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 0.5 0.25 1 0.5\n")
            ),
        ),
        (
            "COFF with integers",
            format!("COFF\n4 2 0\n{}{faces}", SQUARE.replace('\n', " 255 0 0\n")),
        ),
        (
            "COFF with reals",
            format!(
                "COFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " .1 .2 .3 1\n")
            ),
        ),
        (
            "NOFF",
            format!("NOFF\n4 2 0\n{}{faces}", SQUARE.replace('\n', " 0 0 1\n")),
        ),
        (
            "NOFF with undeclared colours",
            format!(
                "NOFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 0 0 1 9 9 9\n")
            ),
        ),
        (
            "CNOFF",
            format!(
                "CNOFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 0 0 1 9 9 9\n")
            ),
        ),
        (
            "STOFF",
            format!(
                "STOFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 0.5 0.5\n")
            ),
        ),
        (
            "NCOFF, normals behind colours",
            format!(
                "NCOFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 9 9 9 255 0 0 1\n")
            ),
        ),
        (
            "CSTOFF in small letters",
            format!(
                "cstoff\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 1 1 1 1 0.5 0.5\n")
            ),
        ),
        (
            "STCNOFF",
            format!(
                "STCNOFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 0 0 1 1 1 1 1 0.5 0.5\n")
            ),
        ),
        (
            "4OFF",
            format!("4OFF\n4 2 0\n0 0 0 5\n2 0 0 2\n.5 .5 0 .5\n0 -3 0 -3\n{faces}"),
        ),
        (
            "4OFF with undeclared colours",
            format!(
                "4OFF\n4 2 0\n{}{faces}",
                SQUARE.replace('\n', " 1 255 0 0\n")
            ),
        ),
        (
            "nOFF of dimension 3",
            format!("nOFF\n3\n4 2 0\n{SQUARE}{faces}"),
        ),
        ("nOFF on one line", format!("nOFF 3 4 2 0\n{SQUARE}{faces}")),
        (
            "words behind the last face",
            format!("OFF\n4 2 0\n{SQUARE}{faces}end of file\n"),
        ),
    ];
    let square = read(format!("OFF\n4 2 0\n{SQUARE}{faces}"))
        .expect("valid")
        .mesh;
    for (name, text) in cases {
        let mesh = read(&text)
            .unwrap_or_else(|error| panic!("{name}: {error}"))
            .mesh;
        assert_eq!(mesh.positions[..4], square.positions, "{name}");
        for index in 0..2 {
            assert_eq!(mesh.corners(index), square.corners(index), "{name}");
        }
        // Vertices are there once where no colours of faces are between them.
        let are_split = name.ends_with("colours behind faces");
        assert_eq!(mesh.positions.len() > 4, are_split, "{name}");
        assert_eq!(mesh.triangles.len(), 2, "{name}");
    }
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let square = |faces: &str| format!("OFF\n4 2 0\n{SQUARE}{faces}");
    let with = |header: &str| format!("{header}\n{SQUARE}3 0 1 2\n3 0 2 3\n");
    let vertex = |vertex: &str| format!("OFF\n1 0 0\n{vertex}\n");
    let start = "OFF (or COFF, NOFF, STOFF, 4OFF) or the numbers of vertices and faces";
    let cases = [
        // The header.
        ("", format!("1: expected {start}, found the end of the file")),
        ("\n# nothing\n", format!("1: expected {start}, found the end of the file")),
        ("ply\nformat ascii 1.0\n", format!("1: expected {start}, found \"ply\"")),
        ("OFFICE\n", format!("1: expected {start}, found \"OFFICE\"")),
        ("OFF\n", "1: expected the number of vertices, found the end of the file".into()),
        ("OFF BINARY\n\0\0\0\u{4}", "1: expected OFF as text, found \"BINARY\"".into()),
        ("OFF\n-4 2 0\n", "2: expected the number of vertices, found \"-4\"".into()),
        ("OFF\n4.0 2 0\n", "2: expected the number of vertices, found \"4.0\"".into()),
        ("OFF\n4\n", "2: expected the number of faces, found the end of the file".into()),
        ("OFF\n4 x 0\n", "2: expected the number of faces, found \"x\"".into()),
        ("OFF\n4 2 x\n", "2: expected the number of edges, found \"x\"".into()),
        ("OFF\n4 2 0 7\n", "2: expected the end of the line after the counts, found \"7\"".into()),
        ("OFF\n99999999999999999999 1 0\n", "2: expected the number of vertices, found \"99999999999999999999\"".into()),
        ("OFF\n5000000000 1 0\n", "2: expected fewer than 2^32 vertices, found \"5000000000\"".into()),
        (&with("nOFF\n4\n4 2 0"), "2: expected the dimension 3 after nOFF, found \"4\"".into()),
        (&with("4nOFF\n3\n4 2 0"), "1: expected OFF of three dimensions, found 4nOFF".into()),
        // The vertices.
        ("OFF\n4000000000 4000000000 0\n", "2: expected vertex 1 of 4000000000, found the end of the file".into()),
        ("OFF\n4 2 0\n0 0 0\n1 0 0\n", "4: expected vertex 3 of 4, found the end of the file".into()),
        ("OFF\n4 2 0\n0 0 0\n1 0\n", "4: expected 3 numbers for vertex 2 of 4, found 2 numbers".into()),
        ("OFF\n4 2 0\n0 0\n1 0 0\n1 1 0\n0 1 0\n", "3: expected 3 numbers for vertex 1 of 4, found 2 numbers".into()),
        (&vertex("0 0 zero"), "3: expected a finite coordinate, found \"zero\"".into()),
        (&vertex("0 nan 0"), "3: expected a finite coordinate, found \"nan\"".into()),
        (&vertex("0 0 -inf"), "3: expected a finite coordinate, found \"-inf\"".into()),
        (&vertex("1e400 0 0"), "3: expected a finite coordinate, found \"1e400\"".into()),
        (&vertex("0,5 0 0"), "3: expected a finite coordinate, found \"0,5\"".into()),
        (&vertex("0 0 0 red"), "3: expected a number, found \"red\"".into()),
        (&vertex("0 0 0 1 2 3 4 5"), "3: expected a colour of at most four numbers after the vertex, found 5 numbers".into()),
        (&vertex("0 0 0 1 1 1 2 2 2"), "3: expected the end of the line after the last vertex, found \"1\"".into()),
        (&with("COFF\n4 2 0"), "3: expected a colour (1, 3 or 4 numbers) after the vertex, found 0 numbers".into()),
        (&with("STOFF\n4 2 0"), "3: expected a texture coordinate (2 numbers) after the vertex, found 0 numbers".into()),
        (&with("NOFF\n4 2 0"), "7: expected 6 numbers for vertex 3 of 4, found 4 numbers".into()),
        ("4OFF\n5 10 10 5\n", "2: expected OFF of three dimensions, found 4OFF with cells".into()),
        (&with("NCOFF\n4 2 0"), "3: expected a colour (1, 3 or 4 numbers) and a normal (3 numbers) after the vertex, found 0 numbers".into()),
        ("CCOFF\n", format!("1: expected {start}, found \"CCOFF\"")),
        ("4OFF\n1 0 0\n1 2 3 0\n", "3: expected a fourth coordinate that is not 0 and leaves the quotients finite, found 0".into()),
        // The faces.
        (&square("3 0 1 2\n"), "7: expected face 2 of 2, found the end of the file".into()),
        (&square(""), "6: expected face 1 of 2, found the end of the file".into()),
        (&square("3 0 1 2\n3 0 2"), "8: expected 3 vertex indices, found 2".into()),
        (&square("3 0 1\n3 0 2 3\n"), "7: expected 3 vertex indices, found 2".into()),
        (&square("3 0 1 9\n3 0 2 3\n"), "7: expected a vertex index below 4, found \"9\"".into()),
        (&square("3 0 1 4\n3 0 2 3\n"), "7: expected a vertex index below 4, found \"4\"".into()),
        (&square("3 0 1 -1\n3 0 2 3\n"), "7: expected a vertex index below 4, found \"-1\"".into()),
        (&square("3 0 1 2.0\n3 0 2 3\n"), "7: expected a vertex index below 4, found \"2.0\"".into()),
        (&square("3 0 1 4294967296\n"), "7: expected a vertex index below 4, found \"4294967296\"".into()),
        (&square("3 0 1 2\n0.5 0.5 0.5\n"), "8: expected the number of corners of face 2 of 2, found \"0.5\"".into()),
        (&square("999999999 0 1 2\n3 0 2 3\n"), "7: expected 999999999 vertex indices, found 3".into()),
        (&square("3 0 1 2 red\n3 0 2 3\n"), "7: expected a colour or the end of the line after the face, found \"red\"".into()),
        (&square("3 0 1 2 1 1 1 1 1\n3 0 2 3\n"), "7: expected a colour of at most four numbers after the face, found 5 numbers".into()),
        // The end.
        (&square("3 0 1 2\n3 0 2 3\n3 1 2 3\n"), "9: expected the end of the file after 2 faces, found \"3\"".into()),
        (&format!("OFF\n3 1 0\n{SQUARE}3 0 1 2\n"), "6: expected the number of corners of face 1 of 1, found \"0\"".into()),
    ];
    for (text, expected) in cases {
        assert_eq!(outcome(text), Err(expected), "{text}");
    }
}

#[test]
fn the_line_is_right_with_every_kind_of_line_end() {
    let text = format!("OFF\n4 2 0\n\n# comment\n{SQUARE}3 0 1 9\n3 0 2 3\n");
    for end in ["\n", "\r\n", "\r"] {
        let error = read(text.replace('\n', end)).expect_err("index 9");
        assert_eq!(error.place, Place::Line(9));
    }
}

#[test]
fn bytes_that_are_not_text_are_an_error_or_a_comment() {
    let error = read(b"OFF\n1 0 0\n0 \xFF\xFE 0\n").expect_err("not a number");
    assert_eq!(
        error.to_string(),
        "line 3: expected a finite coordinate, found \"\u{FFFD}\u{FFFD}\""
    );
    let file = read(b"OFF # caf\xE9\n1 0 0\n0 0 0\n").expect("only the comment is Latin-1");
    assert_eq!(file.mesh.positions.len(), 1);
}

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
fn an_empty_mesh_is_read_and_warned_about() {
    for text in ["OFF\n0 0 0\n", "0 0", "OFF\n1 0 0\n0 0 0\n"] {
        let file = read(text).expect("valid");
        assert_eq!(file.warnings, ["the mesh has no triangles"], "{text}");
    }
}

#[test]
fn normals_are_kept_as_written() {
    let text = "NOFF\n3 1 0\n0 0 0 0 0 2\n1 0 0 0 0 0\n0 1 0 1 0 0\n3 0 1 2\n";
    let normals = read(text).expect("valid").mesh.normals;
    assert_eq!(normals, Some(vec![DVec3::Z * 2.0, DVec3::ZERO, DVec3::X]));
}

/// A header may claim anything: what is reserved depends on the bytes that are there.
#[test]
fn counts_reserve_no_more_than_the_text_can_hold() {
    assert_eq!(capacity(u64::MAX, 10), 10);
    assert_eq!(capacity(3, 10), 3);
    let text = format!("OFF\n4000000000 4000000000 0\n{}", SQUARE.repeat(100));
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let mut reader = Reader::new(text.as_bytes(), &cancel, &progress);
    let header = Header::read(&mut reader.cursor).expect("a valid header");
    reader
        .vertices(&header)
        .expect_err("400 of 4000000000 vertices");
    assert!(reader.mesh.positions.capacity() <= text.len());
    let text = format!("OFF\n4 4000000000 0\n{SQUARE}3 0 1 2\n");
    let mut reader = Reader::new(text.as_bytes(), &cancel, &progress);
    let header = Header::read(&mut reader.cursor).expect("a valid header");
    reader.vertices(&header).expect("four vertices");
    reader.faces(&header).expect_err("1 of 4000000000 faces");
    assert!(reader.mesh.triangles.capacity() <= text.len());
}

#[test]
fn cancelling_stops_it() {
    trials::assert_cancels(parse, grid(40).0.as_bytes());
}

#[test]
fn what_is_written_reads_back_the_same() {
    let extremes = [0.1, -1e300, 5e-324, f64::MAX, 1e-5, 1e16, 123_456.789, -0.0];
    let mut mesh = read(grid(5).0).expect("valid").mesh;
    for (position, x) in mesh.positions.iter_mut().zip(extremes) {
        position.z = x;
    }
    mesh.triangles.retain(|&[a, b, c]| {
        face_normal([a, b, c].map(|vertex| mesh.positions[vertex as usize])).is_some()
    });
    assert_eq!(read(written(&mesh)).expect("valid").mesh, mesh);
    mesh.normals = Some(mesh.positions.clone());
    assert_eq!(read(written(&mesh)).expect("valid").mesh, mesh);
}

fn written(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = Vec::new();
    write(mesh, &mut text).expect("a vector takes all");
    text
}

/// A bumpy grid of n × n squares, some with comments and colours, and its number of triangles.
fn grid(n: u32) -> (String, usize) {
    use std::fmt::Write;
    let mut text = format!("OFF\n{} {} 0\n", (n + 1) * (n + 1), n * n);
    for j in 0..=n {
        for i in 0..=n {
            let z = f64::from((i * 7 + j * 13) % 5) * 0.1;
            writeln!(text, "{} {} {z}", f64::from(i) * 0.37, f64::from(j) * 0.11)
                .expect("a string");
        }
    }
    for corner in (0..n * n).map(|square| square / n * (n + 1) + square % n) {
        let [a, b, c, d] = [corner, corner + 1, corner + n + 2, corner + n + 1];
        let end = if corner % 3 == 0 {
            " 10 20 30 # red"
        } else {
            ""
        };
        writeln!(text, "4 {a} {b} {c} {d}{end}").expect("a string");
    }
    (text, (2 * n * n) as usize)
}

/// Every prefix of a file is an error, unless only the end of the last line is missing.
#[test]
fn truncated_files_are_errors() {
    let (text, triangles) = grid(6);
    let last_line = text.trim_end().rfind('\n').expect("many lines") + 1;
    for length in 0..last_line {
        assert!(
            read(&text.as_bytes()[..length]).is_err(),
            "first {length} bytes"
        );
    }
    assert_eq!(read(&text).expect("valid").mesh.triangles.len(), triangles);
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let seeds = [
        grid(4).0,
        format!(
            "STCNOFF\n4 2 0\n{}3 0 1 2\n3 0 2 3\n",
            SQUARE.replace('\n', " 0 0 1 1 1 1 1 0 0\n")
        ),
        format!(
            "4OFF 4 1\r\n{}4 0 1 2 3\r\n",
            SQUARE.replace('\n', " 2\r\n")
        ),
    ];
    let scraps: [&[u8]; 14] = [
        b"",
        b"\n",
        b"\r",
        b" ",
        b"#",
        b"-",
        b".",
        b"9999999999",
        b"1e999",
        b"nan",
        b"\xFF",
        b"\0",
        b"OFF",
        b"3 0 1 2\n",
    ];
    let seeds = seeds.map(String::into_bytes);
    trials::assert_mutations_are_read_or_refused(parse, &seeds, &scraps);
}
