use super::*;
use crate::geometry::{TriangleMesh, shapes};
use crate::io::Dropped;
use crate::io::mesh_parts::PartCutter;
use crate::io::mesh_reading::trials;
use crate::math::Vec3;

/// Four vertices, one line each; the tests put faces behind.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const FACES: &str = "f 1 2 3\nf 1 3 4\n";
/// A texture coordinate and two normals.
const MORE: &str = "vt 0 0\nvn 0 0 1\nvn 0 0 -2\n";

fn read(text: impl AsRef<[u8]>) -> MeshFile {
    trials::read_right(parse, text.as_ref())
}

fn error(text: impl AsRef<[u8]>) -> String {
    trials::error(parse, text.as_ref())
}

#[test]
fn every_way_to_write_a_square_gives_its_two_triangles() {
    let plain = format!("{SQUARE}{FACES}");
    let faces = |faces: &str| format!("{SQUARE}{MORE}{faces}\n");
    let cases = [
        ("plain", plain.clone()),
        ("CR LF", plain.replace('\n', "\r\n")),
        ("lone CR", plain.replace('\n', "\r")),
        ("a byte order mark", format!("\u{FEFF}{plain}")),
        (
            "comments",
            format!("# a\n{}", plain.replace('\n', "# f 1 2 \\\n# \\\n")),
        ),
        (
            "blanks and blank lines",
            plain.replace(' ', " \t").replace('\n', " \n\n "),
        ),
        ("no final newline", plain.trim_end().to_owned()),
        ("colours", plain.replace(" 0\nv", " 0 0.1 255 1e-3\nv")),
        ("weights", plain.replace(" 0\nv", " 0 1.0\nv")),
        ("counted back", format!("{SQUARE}f -4 -3 -2\nf -4 -2 4\n")),
        (
            "counted back on the way",
            format!(
                "{}f -4 -2 -1\n",
                SQUARE.replace("v 0 1", "f -3 -2 -1\nv 0 1")
            ),
        ),
        (
            "faces first",
            "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -1 4\nv 0 1 0\n".into(),
        ),
        ("one polygon", format!("{SQUARE}f 1 2 3 4\n")),
        ("the old keyword", plain.replace('f', "fo")),
        (
            "texture coordinates",
            faces("f 1/1 2/1 3/1\nf 1/1 3/-1 4/99"),
        ),
        ("normals", faces("f 1//1 2//1 3//1\nf 1//-2 3//1 4//1")),
        ("both", faces("f 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/1/1 4/1/1")),
        ("slashes at the end", faces("f 1/ 2// 3/1/\nf 1/ 3/ 4/")),
        ("mixed", faces("f 1/1/1 2//1 3\nf 1/1 3/1/1 4/")),
        (
            "lines joined",
            format!("{SQUARE}f 1\\\n 2 \\\n \\\n3\nf 1 3\\\r\n4 \\"),
        ),
        (
            "joined in vertices",
            format!("{}{FACES}", SQUARE.replacen("0 0 0", "0 \\\n0 0", 1)),
        ),
        (
            "joined where nobody reads",
            format!("o a \\\nf 9 9 9\nmtllib b\\\n\n{plain}"),
        ),
        (
            "objects, groups and materials",
            format!("mtllib a#b.mtl\no 1\ng a b\ns off\n{SQUARE}usemtl # none\ns 1\n{FACES}"),
        ),
        (
            "statements nobody knows",
            format!("{plain}vp 1\ncurv 0 1 1 2\n\0\u{1}\n"),
        ),
        (
            "lines and points",
            format!("{SQUARE}l 1 2\nl 9/9\np 1 2 3\n{FACES}"),
        ),
    ];
    let square = read(&plain).mesh;
    assert_eq!(square.triangles, [[0, 1, 2], [0, 2, 3]]);
    for (name, text) in cases {
        let file = trials::read(parse, text.as_bytes());
        let file = file.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(file.mesh.positions, square.positions, "{name}");
        let from_least = |[a, b, c]: [u32; 3]| if c < a { [c, a, b] } else { [a, b, c] };
        let triangles: Vec<_> = file.mesh.triangles.into_iter().map(from_least).collect();
        assert_eq!(triangles, square.triangles, "{name}");
        let has_normals = ["normals", "both"].contains(&name);
        assert_eq!(
            file.mesh.normals,
            has_normals.then(|| vec![DVec3::Z; 4]),
            "{name}"
        );
    }
}

#[test]
fn numbers_keep_all_their_digits() {
    let positions = read("v 0.1 1e-300 12345678.12345678\n").mesh.positions;
    assert_eq!(positions, [DVec3::new(0.1, 1e-300, 12_345_678.123_456_78)]);
}

#[test]
fn a_concave_polygon_is_cut_into_its_triangles() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 1 2 3 4 5\n";
    let file = read(text);
    assert_eq!((file.faces, file.polygons), (1, 1));
    let area = |index| {
        let [a, b, c] = file.mesh.corners(index);
        (b - a).cross(c - a).z / 2.0
    };
    assert_eq!((0..file.mesh.triangles.len()).map(area).sum::<f64>(), 2.5);
    assert!((0..3).all(|index| area(index) > 0.0));
}

#[test]
fn a_vertex_becomes_several_only_where_its_normals_differ() {
    // The same normal by another number, and with another zero.
    let text = format!(
        "{SQUARE}vn 0 0 1\nvn 0 -0 1\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//3 4//3\nf 3//3 2//2 4//1\n"
    );
    let mesh = read(text).mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 4, 3], [4, 1, 5]]);
    assert_eq!(mesh.positions[4..], [mesh.positions[2], mesh.positions[3]]);
    let (z, x) = (DVec3::Z, DVec3::X);
    assert_eq!(mesh.normals, Some(vec![z, z, z, x, x, z]));
}

/// A seam: two faces that lie apart on the image share an edge in space.
#[test]
fn vertices_are_split_where_their_texture_coordinates_differ() {
    let text = format!(
        "{SQUARE}vt 0 0\nvt 0.5 0\nvt 0.5 1 7\nvt 1 0\nvt 1 -0\nvt 0.1\nvn 0 0 1\nf 1/1 2/2 3/3\nf 1/4 3/3 4/5\nf 3/-4 1/1 4/6\n"
    );
    let file = read(text);
    assert_eq!(file.warnings, Vec::<String>::new());
    let mesh = file.mesh;
    assert_eq!(mesh.validate(), Ok(()));
    assert_eq!(mesh.triangles, [[0, 1, 2], [4, 2, 3], [2, 0, 5]]);
    assert_eq!(mesh.positions[4..], [mesh.positions[0], mesh.positions[3]]);
    let [a, b, c, d, e] = [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (1.0, 0.0), (0.1, 0.0)];
    let expected = [a, b, c, d, d, e].map(|(u, v)| DVec2::new(u, v));
    assert_eq!(mesh.texture_coordinates.as_deref(), Some(&expected[..]));
    assert_eq!(mesh.normals, None);
}

#[test]
fn a_vertex_is_split_by_normal_and_texture_coordinate_together() {
    let text = format!(
        "{SQUARE}vn 0 0 1\nvn 0 1 0\nvt 0 0\nvt 1 0\nf 1/1/1 2/1/1 3/1/1\nf 1/1/2 3/2/1 4/1/1\nf 1/1/1 2/1/1 4/1/1\n"
    );
    let mesh = read(text).mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [4, 5, 3], [0, 1, 3]]);
    let (normals, coordinates) = (
        mesh.normals.expect("some"),
        mesh.texture_coordinates.expect("some"),
    );
    assert_eq!((normals[4], normals[5]), (DVec3::Y, DVec3::Z));
    assert_eq!((coordinates[4], coordinates[5]), (DVec2::ZERO, DVec2::X));
}

/// Exporters name coordinates they do not write, and leave out those of faces without an image.
#[test]
fn texture_coordinates_that_are_not_there_are_zero() {
    let text = format!(
        "{SQUARE}vt 1 1\nvt nan 0\nf 1/1 2/2 3/9\nf 1/-9 3/0 4/1\nf 1 2 4\nf 1/1 2/1 4/1\n"
    );
    let file = read(text);
    let coordinates = file.mesh.texture_coordinates.expect("some");
    let of = |triangle: [u32; 3]| triangle.map(|vertex| coordinates[vertex as usize]);
    let (zero, one) = (DVec2::ZERO, DVec2::ONE);
    assert_eq!(of(file.mesh.triangles[0]), [one, zero, zero]);
    assert_eq!(of(file.mesh.triangles[1]), [zero, zero, one]);
    assert_eq!(of(file.mesh.triangles[2]), [zero; 3]);
    assert_eq!(of(file.mesh.triangles[3]), [one; 3]);
    assert_eq!(
        file.warnings,
        [
            "1 texture coordinate that is not finite is taken as (0, 0) (line 6)",
            "2 faces have no texture coordinates; they are taken as (0, 0) (the first on line 8)",
            "corners name texture coordinates that are not there, 1 in all; they are taken as (0, 0)",
        ]
    );
    let file = read(format!("{SQUARE}f 1/1 2/2 3/3\n"));
    assert_eq!(
        (file.mesh.texture_coordinates, file.warnings),
        (None, Vec::new())
    );
}

#[test]
fn colors_of_vertices_are_srgb() {
    let text = "v 0 0 0 1 0.5 0\nv 1 0 0\nv 1 1 0 0 0 0.02 1\nv 0 1 0 nan -1 3e9\nf 1 2 3\n";
    // 3e9 is beyond 255: everything counts to that.
    let dark = read(text).mesh.colors.expect("some");
    assert!(dark[0].max_element() < 0.001 && dark[3] == Vec3::new(0.0, 0.0, 1.0));
    let colors = read(text.replace("3e9", "1.01")).mesh.colors.expect("some");
    // ((0.5 + 0.055) / 1.055)^2.4 and 0.02 / 12.92, by IEC 61966-2-1.
    let expected = [
        Vec3::new(1.0, 0.214_041_14, 0.0),
        Vec3::ONE,
        Vec3::new(0.0, 0.0, 0.001_547_987_6),
        Vec3::new(0.0, 0.0, 1.0),
    ];
    for (color, expected) in colors.iter().zip(expected) {
        assert!(color.abs_diff_eq(expected, 1e-7), "{color} {expected}");
    }
    // Bytes written as they are.
    let bytes = read("v 0 0 0 255 128 0\nv 1 0 0 0 0 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
    let colors = bytes.mesh.colors.expect("some");
    // 188 is half of the light: 128 is ((128 / 255 + 0.055) / 1.055)^2.4.
    assert!(colors[0].abs_diff_eq(Vec3::new(1.0, 0.215_860_53, 0.0), 1e-7));
    assert_eq!(
        read("v 0 0 0 0.5\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n")
            .mesh
            .colors,
        None
    );
}

#[test]
fn normals_of_some_faces_are_not_used() {
    let file = read(format!("{SQUARE}{MORE}f 1//1 2//1 3//1\nf 1//1 3 4//1\n"));
    assert_eq!(file.mesh.normals, None);
    assert_eq!(
        file.warnings,
        [
            "1 face has no normals, so those of all are ignored (line 9)",
            "texture coordinates are ignored, as no face has them at all its corners (the first on line 5)"
        ]
    );
    let file = read(format!("{SQUARE}vn nan 0 0\nvn 0 0 1\nf 1//1 2//2 3//2\n"));
    let normals = vec![DVec3::ZERO, DVec3::Z, DVec3::Z, DVec3::ZERO];
    assert_eq!(file.mesh.normals, Some(normals));
    assert_eq!(
        file.warnings,
        ["1 normal that is not finite is ignored (line 5)"]
    );
    assert_eq!(read(format!("{SQUARE}{MORE}{FACES}")).warnings.len(), 1);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn what_is_wrong_is_named_with_its_line() {
    let face = |face: &str| format!("{SQUARE}{MORE}f {face}\n");
    let corner = "a corner such as 1, 1/2, 1//3 or 1/2/3";
    let keyword = "v, vn, vt, f or another keyword of OBJ";
    let cases = [
        (
            "<html>\n\nhello".into(),
            format!("1: expected {keyword}, found \"<html>\""),
        ),
        (
            "o a\nversion 2\n".into(),
            format!("2: expected {keyword}, found \"version\""),
        ),
        (
            "v 0 0\n".into(),
            "1: expected 3 numbers, found 2 numbers".into(),
        ),
        ("v".into(), "1: expected 3 numbers, found 0 numbers".into()),
        (
            "\nv 0 0 zero\n".into(),
            "2: expected a number, found \"zero\"".into(),
        ),
        (
            "v 0 0 0 red\n".into(),
            "1: expected a number, found \"red\"".into(),
        ),
        (
            "v 0 nan 0\n".into(),
            "1: expected finite coordinates, found (0, NaN, 0)".into(),
        ),
        (
            "v 0 0 -1e400\n".into(),
            "1: expected finite coordinates, found (0, 0, -inf)".into(),
        ),
        (
            "vn 1 2\n".into(),
            "1: expected 3 numbers, found 2 numbers".into(),
        ),
        (
            "vn 1 2 x\n".into(),
            "1: expected a number, found \"x\"".into(),
        ),
        (face("1 2 x"), format!("8: expected {corner}, found \"x\"")),
        (
            face("1 2 3.0"),
            format!("8: expected {corner}, found \"3.0\""),
        ),
        (
            face("1 2 3/1/1/1"),
            format!("8: expected {corner}, found \"3/1/1/1\""),
        ),
        (
            face("1 2 /1"),
            format!("8: expected {corner}, found \"/1\""),
        ),
        (
            face("1 2 3/x"),
            format!("8: expected {corner}, found \"3/x\""),
        ),
        (face("1 2 -"), format!("8: expected {corner}, found \"-\"")),
        (
            face("1 \\ 2"),
            format!("8: expected {corner}, found \"\\\\\""),
        ),
        (
            face("1 2 0"),
            "8: expected a vertex number above 0 or from -4 to -1, found \"0\"".into(),
        ),
        (
            face("1 2 -5//1"),
            "8: expected a vertex number above 0 or from -4 to -1, found \"-5//1\"".into(),
        ),
        (
            face("1//1 2//1 3//0"),
            "8: expected a normal number above 0 or from -2 to -1, found \"3//0\"".into(),
        ),
        (
            face("1//1 2//1 3//-3"),
            "8: expected a normal number above 0 or from -2 to -1, found \"3//-3\"".into(),
        ),
        (
            face("1 2 99999999999999999999"),
            "8: expected a vertex number above 0 or from -4 to -1, found \"99999999999999999999\""
                .into(),
        ),
        (
            face("1 2 5"),
            "8: expected a vertex number of at most 4, found 5".into(),
        ),
        (
            face("1//1 2//1 3//3"),
            "8: expected a normal number of at most 2, found 3".into(),
        ),
        (
            "f -1 1 2\n".into(),
            "1: expected a vertex number above 0, found \"-1\"".into(),
        ),
        (
            "f 1 2 3\n\nf 1 2 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".into(),
            "3: expected a vertex number of at most 3, found 9".into(),
        ),
        (
            format!("{SQUARE}f 1 2 \\\n9 \\\n\\\n4\n"),
            "5: expected a vertex number of at most 4, found 9".into(),
        ),
        (
            format!("{SQUARE}f 1 2 \\\n3\nf x\n"),
            format!("7: expected {corner}, found \"x\""),
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), format!("line {expected}"));
    }
}

#[test]
fn what_is_lost_is_said() {
    let file = read(format!(
        "{}vt 0 0\nusemtl a\nusemtl b\nf 1 1 2\nf\nf 1\nf 1 2\nl 1 2\np 1\ncurv 0\nf 1 2 3\n",
        SQUARE.replace("0\n", "0 1 0 0\n")
    ));
    assert_eq!(
        file.dropped,
        Dropped {
            degenerate: 1,
            too_few_corners: 3
        }
    );
    assert_eq!((file.format, file.faces), ("OBJ", 5));
    assert_eq!(
        file.warnings,
        [
            "1 face without area was dropped (line 8)",
            "3 faces with fewer than three corners were dropped (the first on line 9)",
            "texture coordinates are ignored, as no face has them at all its corners (the first on line 5)",
            "2 lines and points are ignored (the first on line 12)",
            "1 statement of another kind is ignored (line 14)",
        ]
    );
    let dropped = read(format!("{SQUARE}{MORE}f 1//1 1//1 2//2\n"));
    assert_eq!(dropped.mesh.normals, None, "there is nothing to shade");
    for empty in ["", "# nothing\n", "o a\n", "v 0 0 0\np 1\n"] {
        assert_eq!(
            read(empty).warnings.last().map(String::as_str),
            Some("the mesh has no triangles"),
            "{empty}"
        );
    }
}

#[test]
fn materials_make_parts() {
    // The second face comes before its vertices, which makes it the last triangle.
    let text = format!(
        "mtllib a b.mtl # c\nmtllib\nmtllib a b.mtl\nusemtl Material #25\n{SQUARE}f 1 2 3\nf 1 3 5\nusemtl  red \nf 1 3 4\nusemtl none\n\
         usemtl Material #25\nf 2 3 4\nv 0 0 1\n"
    );
    let file = read(&text);
    assert_eq!(
        file.mesh.triangles,
        [[0, 1, 2], [0, 2, 3], [1, 2, 3], [0, 2, 4]]
    );
    assert_eq!(
        file.parts.names().collect::<Vec<_>>(),
        ["Material #25", "red"]
    );
    let libraries: Vec<_> = file
        .libraries
        .iter()
        .map(|l| (l.line, l.name.as_str()))
        .collect();
    assert_eq!(libraries, [(1, "a b.mtl")]);
    let mut cutter = PartCutter::new(&file.mesh, &file.parts);
    let red = cutter.cut("red").expect("is there");
    assert_eq!((red.positions.len(), red.triangles), (3, vec![[0, 1, 2]]));
    let other = cutter.cut("Material #25").expect("is there");
    let corners: Vec<_> = (0..3).map(|i| other.corners(i)).collect();
    assert_eq!(corners, [0, 2, 3].map(|i| file.mesh.corners(i)));
    assert!(read(format!("{SQUARE}{FACES}")).parts.is_empty());
    let unnamed = read(format!(
        "{SQUARE}f 1 2 9\nf 1 2 3\nusemtl a\nf 1 3 4\n{}",
        "v 0 0 2\n".repeat(5)
    ));
    assert_eq!(unnamed.parts.names().collect::<Vec<_>>(), ["", "a"]);
}

#[test]
fn what_is_written_reads_back_the_same() {
    let mut mesh = shapes::icosphere(2);
    let written = |mesh: &TriangleMesh| {
        let mut text = Vec::new();
        write(mesh, &mut text).expect("a vector takes all");
        read(text).mesh
    };
    assert_eq!(written(&mesh), mesh);
    mesh.normals = Some(mesh.positions.iter().map(|p| *p * 3.0).collect());
    // Two vertices at one place.
    mesh.positions[0] = mesh.positions[1];
    mesh.triangles
        .retain(|triangle| !(triangle.contains(&0) && triangle.contains(&1)));
    assert_eq!(written(&mesh), mesh);
}

#[test]
fn cancelling_stops_it() {
    trials::assert_cancels(parse, format!("{SQUARE}{FACES}").as_bytes());
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let files = [
        format!("{SQUARE}{FACES}"),
        format!("{SQUARE}{MORE}f 1//1 2/1/1 3//-1\nf -1/1/2 -2//1 -3//2\n"),
        format!("f 1 2 \\\n3\n{SQUARE}l 1 2\nusemtl a\nf 1 2 3 4 \\\n1\n"),
    ];
    let scraps: [&[u8]; 13] = [
        b"",
        b"\n",
        b" ",
        b"\\\n",
        b"/",
        b"//",
        b"-",
        b"1e999",
        b"nan",
        b"4294967296",
        b"#",
        b"\nf 9 8 7\n",
        b"\nv 1 2 3\n",
    ];
    trials::assert_mutations_are_read_or_refused(parse, &files.map(String::into_bytes), &scraps);
}
