mod wrong;

use super::*;
use crate::geometry::{TriangleMesh, shapes};
use crate::io::Dropped;
use crate::io::mesh_reading::trials;
use crate::math::{DVec2, DVec3, Vec3, color::linear_from_srgb};

/// A square's vertices in the order around it.
const SQUARE: [[i8; 3]; 4] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];

/// A header of these lines, for the format and after it.
fn header(format: &str, lines: &[&str]) -> String {
    format!(
        "ply\nformat {format} 1.0\n{}\nend_header\n",
        lines.join("\n")
    )
}

/// A square of two triangles as text, with these properties of vertices, faces, and data.
fn square(vertex: &[&str], faces: &[&str], data: &str) -> String {
    let lines = [&["element vertex 4"], vertex, faces].concat();
    header("ascii", &lines) + data
}

const XYZ: [&str; 3] = ["property float x", "property float y", "property float z"];
const FACES: [&str; 2] = ["element face 2", "property list uchar int vertex_indices"];
const DATA: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

fn plain() -> String {
    square(&XYZ, &FACES, DATA)
}

/// A number in the bytes of a type.
fn encoded(value: i8, kind: &str, is_big: bool) -> Vec<u8> {
    let mut bytes = match kind {
        "char" => vec![value.to_le_bytes()[0]],
        "uchar" => vec![u8::try_from(value).expect("not negative")],
        "short" => i16::from(value).to_le_bytes().to_vec(),
        "ushort" => u16::try_from(value)
            .expect("not negative")
            .to_le_bytes()
            .to_vec(),
        "int" => i32::from(value).to_le_bytes().to_vec(),
        "uint" => u32::try_from(value)
            .expect("not negative")
            .to_le_bytes()
            .to_vec(),
        "float" => f32::from(value).to_le_bytes().to_vec(),
        "double" => f64::from(value).to_le_bytes().to_vec(),
        _ => unreachable!("{kind}"),
    };
    if is_big {
        bytes.reverse();
    }
    bytes
}

/// The square in binary, coordinates, lengths of lists and their items of these types; its face has all four corners.
fn binary(is_big: bool, coordinate: &str, length: &str, item: &str) -> Vec<u8> {
    let format = if is_big {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let of_vertex = ["x", "y", "z"].map(|axis| format!("property {coordinate} {axis}"));
    let [x, y, z] = &of_vertex;
    let list = format!("property list {length} {item} vertex_index");
    let mut bytes = header(
        format,
        &["element vertex 4", x, y, z, "element face 1", &list],
    )
    .into_bytes();
    for value in SQUARE.into_iter().flatten() {
        bytes.extend(encoded(value, coordinate, is_big));
    }
    bytes.extend(encoded(4, length, is_big));
    for index in 0..4 {
        bytes.extend(encoded(index, item, is_big));
    }
    bytes
}

fn read(bytes: impl AsRef<[u8]>) -> MeshFile {
    trials::read_right(parse, bytes.as_ref())
}

fn error(bytes: impl AsRef<[u8]>) -> String {
    trials::error(parse, bytes.as_ref())
}

fn assert_is_square(name: &str, bytes: &[u8]) {
    let mesh = trials::read(parse, bytes)
        .unwrap_or_else(|error| panic!("{name}: {error}"))
        .mesh;
    let expected = SQUARE.map(|position| DVec3::from_array(position.map(f64::from)));
    assert_eq!(mesh.positions, expected, "{name}");
    // A polygon's second triangle begins elsewhere.
    let from_least = |[a, b, c]: [u32; 3]| if c < a { [c, a, b] } else { [a, b, c] };
    let triangles: Vec<_> = mesh.triangles.into_iter().map(from_least).collect();
    assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]], "{name}");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn every_way_to_write_a_square_as_text_gives_its_two_triangles() {
    let with = |vertex: &[&str], data: &str| square(vertex, &FACES, data);
    let cases = [
        ("plain", plain()),
        ("CR LF", plain().replace('\n', "\r\n")),
        ("lone CR", plain().replace('\n', "\r")),
        ("a byte order mark", format!("\u{FEFF}{}", plain())),
        (
            "comments",
            plain().replace("element", "comment a # b\nobj_info c\ncomment\nelement"),
        ),
        ("blank lines", plain().replace('\n', "\n\n")),
        ("blanks", plain().replace(' ', " \t").replace('\n', " \n")),
        ("no final newline", plain().trim_end().to_owned()),
        ("words after the last element", plain() + "the end\n"),
        (
            "values on lines of their own",
            square(&XYZ, &FACES, &DATA.replace(' ', "\n")),
        ),
        (
            "whole numbers",
            plain().replace("float", "int").replace("uchar", "double"),
        ),
        (
            "types with sizes",
            plain()
                .replace("float", "float64")
                .replace("uchar", "uint8"),
        ),
        (
            "one polygon",
            plain()
                .replace("face 2", "face 1")
                .replace("3 0 1 2\n3 0 2 3\n", "4 0 1 2 3\n"),
        ),
        (
            "other properties and lists before, between and after",
            with(
                &[
                    "property list uchar float w",
                    XYZ[0],
                    "property int flags",
                    XYZ[1],
                    XYZ[2],
                    "property list int int e",
                ],
                "0 0 9 0 0 0\n1 5 1 9 0 0 0\n2 5 5 1 9 1 0 1 7\n0 0 9 1 0 2 7 7\n3 0 1 2\n3 0 2 3\n",
            ),
        ),
        (
            "another order of coordinates",
            with(
                &[XYZ[2], XYZ[0], XYZ[1]],
                "0 0 0\n0 1 0\n0 1 1\n0 0 1\n3 0 1 2\n3 0 2 3\n",
            ),
        ),
        (
            "other properties of faces",
            square(
                &XYZ,
                &[
                    "element face 2",
                    "property uchar flags",
                    FACES[1],
                    "property list uchar int vertex_index",
                    "property int end",
                ],
                "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 3 0 1 2 3 3 3 3 9\n7 3 0 2 3 0 9\n",
            ),
        ),
        (
            "other elements before, between and after",
            header(
                "ascii",
                &[
                    &[
                        "element camera 1",
                        "property float f",
                        "element nothing 4000000000",
                        "element vertex 4",
                    ],
                    &XYZ[..],
                    &["element edge 2", "property int a", "property int b"],
                    &FACES,
                    &["element tail 1", "property list uchar uchar t"],
                ]
                .concat(),
            ) + "35\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 1\n1 2\n3 0 1 2\n3 0 2 3\n2 8 9\n",
        ),
        (
            "elements without items",
            header(
                "ascii",
                &[
                    &["element tristrips 0", "element face 0", "element vertex 4"],
                    &XYZ[..],
                    &FACES,
                ]
                .concat(),
            ) + DATA,
        ),
    ];
    for (name, text) in cases {
        assert_is_square(name, text.as_bytes());
    }
}

#[test]
fn every_type_and_byte_order_gives_the_square() {
    let types = [
        "char", "uchar", "short", "ushort", "int", "uint", "float", "double",
    ];
    for is_big in [false, true] {
        for coordinate in types {
            for list in types {
                let name = format!("{is_big} {coordinate} {list}");
                assert_is_square(&name, &binary(is_big, coordinate, list, list));
                assert_is_square(&name, &binary(is_big, coordinate, "uchar", list));
            }
        }
    }
}

#[test]
fn binary_data_begins_right_after_the_line_end_of_the_header() {
    let bytes = binary(false, "char", "uchar", "uchar");
    let start = bytes.len() - 17;
    let (header, data) = bytes.split_at(start);
    let header = str::from_utf8(header).expect("text");
    for end in ["\n", "\r\n", "\r"] {
        let mut bytes = header.replace('\n', end).into_bytes();
        bytes.extend(data);
        assert_is_square(end, &bytes);
        // The first byte of data may look like a line end: here, the first coordinate is 10.
        let start = bytes.len() - 17;
        bytes[start] = b'\n';
        assert_eq!(read(bytes).mesh.positions[0].x, 10.0, "{end:?}");
    }
}

#[test]
fn normals_are_kept_as_written() {
    let normals = [
        XYZ,
        [
            "property float nx",
            "property float ny",
            "property float nz",
        ],
    ]
    .concat();
    let data = "0 0 0 0 0 2\n1 0 0 0 0 0\n1 1 0 1 nan 0\n0 1 0 .1 0 0\n3 0 1 2\n3 0 2 3\n";
    let file = read(square(&normals, &FACES, data));
    let expected = [DVec3::Z * 2.0, DVec3::ZERO, DVec3::ZERO, DVec3::X * 0.1];
    assert_eq!(file.mesh.normals.as_deref(), Some(&expected[..]));
    assert_eq!(
        file.warnings,
        ["1 normal that is not finite is ignored (line 15)"]
    );
    let two = [&XYZ[..], &["property float nx", "property float ny"]].concat();
    let data = "0 0 0 0 0\n1 0 0 0 0\n1 1 0 1 0\n0 1 0 0 0\n3 0 1 2\n3 0 2 3\n";
    assert_eq!(read(square(&two, &FACES, data)).mesh.normals, None);
}

#[test]
fn strips_turn_every_second_triangle_and_begin_anew_at_minus_one() {
    let strips = [
        "element tristrips 2",
        "property list int int vertex_indices",
    ];
    let triangles = |data: &str| {
        let data = format!("0 0 0\n1 0 0\n1 1 0\n0 1 0\n{data}");
        let file = read(square(&XYZ, &strips, &data));
        assert_eq!(
            (file.dropped, file.faces),
            (Dropped::default(), file.mesh.triangles.len() as u64)
        );
        file.mesh.triangles
    };
    let square = [[0, 1, 3], [3, 1, 2]];
    assert_eq!(triangles("4 0 1 3 2\n0\n"), square);
    assert_eq!(triangles("7 0 1 3 -1 3 1 2\n0\n"), square);
    assert_eq!(triangles("9 -1 -1 0 1 3 -1 0 1 -1\n3 3 1 2\n"), square);
    // A repeated index leads on and turns.
    assert_eq!(triangles("5 0 1 3 3 2\n2 0 1\n"), [[0, 1, 3]]);
    assert_eq!(
        triangles("6 0 1 3 3 1 2\n0\n"),
        square.map(|[a, b, c]| if a == 3 { [1, 3, 2] } else { [a, b, c] })
    );
    let bad = |data: &str| {
        error(self::square(
            &XYZ,
            &strips,
            &format!("0 0 0\n1 0 0\n1 1 0\n0 1 0\n{data}"),
        ))
    };
    assert_eq!(
        bad("4 0 1 3 -2\n0\n"),
        "line 14: expected a vertex index below 4, found \"-2\""
    );
    assert_eq!(
        bad("4 0 1 3 4\n0\n"),
        "line 14: expected a vertex index below 4, found \"4\""
    );
}

/// Of any type and under any of their names, in any order.
#[test]
fn texture_coordinates_and_colors_are_kept() {
    let properties = [
        &["property uchar blue", "property float texture_v"],
        &XYZ[..],
        &["property uchar red", "property ushort green"],
        &["property double texture_u"],
    ]
    .concat();
    let data = "255 0.5 0 0 0 0 65535 0.1\n0 1 1 0 0 128 0 -3\n0 nan 1 1 0 0 0 0\n0 0 0 1 0 1 0 0\n3 0 1 2\n3 0 2 3\n";
    let file = read(square(&properties, &FACES, data));
    let expected = [(0.1, 0.5), (-3.0, 1.0), (0.0, 0.0), (0.0, 0.0)];
    let expected = expected.map(|(u, v)| DVec2::new(u, v));
    assert_eq!(
        file.mesh.texture_coordinates.as_deref(),
        Some(&expected[..])
    );
    assert_eq!(
        file.warnings,
        ["1 texture coordinate that is not finite is taken as (0, 0) (line 17)"]
    );
    // sRGB by IEC 61966-2-1: ((128/255 + 0.055) / 1.055)^2.4, and 1/255/12.92.
    let colors = file.mesh.colors.expect("some");
    assert_eq!(colors[0], Vec3::new(0.0, 1.0, 1.0));
    assert!((colors[1].x - 0.215_860_53).abs() < 1e-7);
    assert!((colors[3].x - 0.000_303_527).abs() < 1e-9);

    let properties = [
        &XYZ[..],
        &["property float r", "property float g", "property float b"],
    ];
    let data = "0 0 0 1 .5 2\n1 0 0 0 0 0\n1 1 0 -1 nan 0\n0 1 0 0 0 0\n3 0 1 2\n3 0 2 3\n";
    let colors = read(square(&properties.concat(), &FACES, data)).mesh.colors;
    let colors = colors.expect("some");
    assert!(colors[0].abs_diff_eq(Vec3::new(1.0, 0.214_041_14, 1.0), 1e-7));
    assert_eq!(colors[2], Vec3::ZERO);
}

const TEXCOORD: &str = "property list uchar float texcoord";

/// Two triangles that meet along a diagonal, whose ends lie elsewhere on the image for the second one.
#[test]
fn corners_with_texture_coordinates_of_their_own_split_vertices() {
    let vertex = [
        &XYZ[..],
        &[
            "property uchar red",
            "property uchar green",
            "property uchar blue",
        ],
    ]
    .concat();
    let faces = [&FACES[..], &[TEXCOORD]].concat();
    let vertices = "0 0 0 255 0 0\n1 0 0 0 0 0\n1 1 0 0 255 0\n0 1 0 0 0 0\n";
    let data = "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 .5 0 1 1 .5 .25\n";
    let file = read(square(&vertex, &faces, &format!("{vertices}{data}")));
    let mesh = file.mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [4, 2, 3]]);
    let textures = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.25), (0.5, 0.0)];
    let textures = textures.map(|(u, v)| DVec2::new(u, v));
    assert_eq!(mesh.texture_coordinates, Some(textures.to_vec()));
    assert_eq!(mesh.positions[4], DVec3::ZERO);
    let colors = mesh.colors.expect("some");
    assert_eq!(
        [colors[0], colors[2], colors[4]],
        [Vec3::X, Vec3::Y, Vec3::X]
    );
    assert_eq!(file.warnings, Vec::<String>::new());
    assert!(file.parts.is_empty());

    // The list may come first, in binary and for a polygon.
    let lines = [
        "element vertex 4",
        XYZ[0],
        XYZ[1],
        XYZ[2],
        "element face 1",
        TEXCOORD,
        FACES[1],
    ];
    let mut bytes = header("binary_big_endian", &lines).into_bytes();
    for value in SQUARE.into_iter().flatten() {
        bytes.extend(f32::from(value).to_be_bytes());
    }
    bytes.push(8);
    for value in [0.0_f32, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0] {
        bytes.extend(value.to_be_bytes());
    }
    bytes.push(4);
    for index in 0..4_u32 {
        bytes.extend(index.to_be_bytes());
    }
    let mesh = read(bytes).mesh;
    let corners: Vec<_> = SQUARE
        .map(|[x, y, _]| DVec2::new(x.into(), y.into()))
        .to_vec();
    assert_eq!(mesh.texture_coordinates, Some(corners));
}

#[test]
fn faces_that_show_images_are_parts() {
    let faces = [&FACES[..], &[TEXCOORD, "property int texnumber"]].concat();
    let face = |corners: &str, image: i8| format!("3 {corners} 6 0 0 1 0 1 1 {image}\n");
    let text = |images: &str, numbers: [i8; 2]| {
        let faces = square(&XYZ, &faces, &DATA[..24])
            .replace("element vertex", &format!("{images}element vertex"));
        faces + &face("0 1 2", numbers[0]) + &face("0 2 3", numbers[1])
    };
    let two = "comment TextureFile wood.png\ncomment made by hand\ncomment TextureFile a b.jpg\n";
    for (images, numbers, expected) in [
        (two, [1, 0], &["a b.jpg", "wood.png"][..]),
        (two, [0, 7], &["wood.png", ""]),
        (two, [-1, 1], &["", "a b.jpg"]),
        ("comment TextureFile wood.png\n", [0, 0], &["wood.png"]),
        ("comment TextureFiles\n", [0, 0], &[]),
    ] {
        let file = read(text(images, numbers));
        let names: Vec<_> = file.parts.names().collect();
        assert_eq!(names, expected);
        assert_eq!(file.mesh.triangles.len(), 2);
    }
    // All faces show the first where they do not say which; without coordinates, none.
    let vertex = [&XYZ[..], &["property float s", "property float t"]].concat();
    let data = "0 0 0 0 0\n1 0 0 0 0\n1 1 0 0 0\n0 1 0 0 0\n3 0 1 2\n3 0 2 3\n";
    let named = |text: String| text.replace("element vertex", &format!("{two}element vertex"));
    let file = read(named(square(&vertex, &FACES, data)));
    assert_eq!(file.parts.names().collect::<Vec<_>>(), ["wood.png"]);
    assert!(file.parts_are_images && read(named(plain())).parts.is_empty());
}

#[test]
fn corners_without_texture_coordinates_are_told_of() {
    let vertex = [&XYZ[..], &["property float s", "property float t"]].concat();
    let faces = [&FACES[..], &[TEXCOORD]].concat();
    let vertices = "0 0 0 9 9\n1 0 0 9 9\n1 1 0 9 9\n0 1 0 9 9\n";
    let data = "3 0 1 2 0\n3 0 2 3 6 0 nan 0 0 1 1\n";
    let file = read(square(&vertex, &faces, &format!("{vertices}{data}")));
    assert_eq!(
        file.warnings,
        [
            "1 texture coordinate that is not finite is taken as (0, 0) (line 18)",
            "1 face has no texture coordinates at all corners; they are taken as (0, 0) (line 17)",
            "texture coordinates of vertices are ignored, as faces have their own",
        ]
    );
    let textures = [DVec2::ZERO, DVec2::ZERO, DVec2::ZERO, DVec2::ONE];
    assert_eq!(file.mesh.texture_coordinates, Some(textures.to_vec()));
    let short = square(&XYZ, &faces, &format!("{}3 0 1 2 6 0 0\n", &DATA[..24]));
    assert_eq!(
        error(short),
        "line 15: expected face 1 of 2, found the end of the file"
    );
}

#[test]
fn what_is_ignored_is_said_once() {
    let vertex = [
        &XYZ[..],
        &[
            "property uchar red",
            "property uchar green",
            "property float s",
        ],
    ]
    .concat();
    let faces = [
        "element face 1",
        FACES[1],
        "property uchar red",
        "element edge 1",
        "property int a",
    ];
    let file = read(square(
        &vertex,
        &faces,
        "0 0 0 9 9 .1\n1 0 0 9 9 .1\n1 1 0 9 9 .1\n0 1 0 9 9 .1\n4 0 1 2 3 9\n5\n",
    ));
    assert_eq!(
        file.warnings,
        [
            "colours that vertices do not have whole are ignored (the first on line 7)",
            "texture coordinates that vertices do not have whole are ignored (the first on line 9)",
            "1 element of another kind is ignored (line 13)",
        ]
    );
    assert_eq!(
        read(plain() + "the end\n").warnings,
        ["text after the last element is ignored (line 16)"]
    );
    let mut bytes = binary(false, "float", "uchar", "int");
    bytes.push(0);
    assert_eq!(
        read(&bytes).warnings,
        ["1 byte after the last element are ignored"]
    );
}

#[test]
fn faces_without_area_are_dropped_and_points_have_no_triangles() {
    let data = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 1\n2 0 1\n";
    let file = read(square(&XYZ, &FACES, data));
    assert_eq!(
        file.dropped,
        Dropped {
            degenerate: 1,
            too_few_corners: 1
        }
    );
    let data = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let file = read(square(&XYZ, &[], data));
    assert_eq!(file.mesh.positions.len(), 4);
    assert_eq!(file.warnings, ["the mesh has no triangles"]);
}

/// A header may claim anything: what is reserved depends on the bytes that are there.
#[test]
fn counts_reserve_no_more_than_the_data_can_hold() {
    for (format, data) in [
        ("ascii", &b"0 0 0\n"[..]),
        ("binary_little_endian", &[0; 12]),
    ] {
        let lines = [&["element vertex 4000000000"], &XYZ[..]].concat();
        let bytes = [header(format, &lines).as_bytes(), data].concat();
        assert!(
            error(bytes).ends_with("expected vertex 2 of 4000000000, found the end of the file")
        );
    }
}

#[test]
fn what_is_written_reads_back_the_same() {
    let mut mesh = shapes::icosphere(2);
    assert_eq!(written(&mesh), mesh);
    mesh.normals = Some(
        mesh.positions
            .iter()
            .map(|p| p.as_vec3().as_dvec3())
            .collect(),
    );
    assert_eq!(written(&mesh), mesh);
    mesh.positions
        .clone_from(mesh.normals.as_ref().expect("has some"));
    assert_eq!(written(&mesh), mesh);
    // Coordinates that 32 bits hold, and such that they do not; colours that are bytes.
    for digit in [0.25, 0.1] {
        let coordinates = mesh.positions.iter().map(|p| DVec2::new(p.x + digit, 1e-9));
        mesh.texture_coordinates = Some(coordinates.collect());
        let code = |vertex: usize| (vertex * 37 % 256) as f32 / 255.0;
        let colors =
            (0..mesh.positions.len()).map(|vertex| Vec3::splat(linear_from_srgb(code(vertex))));
        mesh.colors = Some(colors.collect());
        assert_eq!(written(&mesh), mesh);
    }
    let (bytes, colors) = (
        Vec3::splat(linear_from_srgb(0.2)),
        mesh.colors
            .insert(vec![Vec3::splat(0.3); mesh.positions.len()]),
    );
    colors[0] = bytes;
    let read = written(&mesh).colors.expect("some");
    assert!((read[0] - bytes).length() < 1e-7 && (read[1] - 0.3).length() < 1e-6);
    assert_eq!(written(&TriangleMesh::default()), TriangleMesh::default());
}

fn written(mesh: &TriangleMesh) -> TriangleMesh {
    let mut bytes = Vec::new();
    write(mesh, &mut bytes).expect("a vector takes all");
    read(bytes).mesh
}

#[test]
fn cancelling_stops_it() {
    for bytes in [
        plain().into_bytes(),
        binary(true, "short", "char", "double"),
    ] {
        trials::assert_cancels(parse, &bytes);
    }
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let strips = [
        "element tristrips 1",
        "property list int int vertex_indices",
    ];
    let strips = square(
        &XYZ,
        &strips,
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n6 0 1 3 2 -1 0\n",
    );
    let mut ball = Vec::new();
    write(&shapes::icosphere(0), &mut ball).expect("a vector takes all");
    let files = [
        plain().into_bytes(),
        binary(true, "short", "char", "uint"),
        strips.into_bytes(),
        ball,
    ];
    let scraps: [&[u8]; 12] = [
        b"",
        b"\n",
        b"\r",
        b" ",
        b"-1",
        b"9999999999",
        b"1e999",
        b"nan",
        b"\xFF\xFF\xFF\xFF",
        b"\0\0\0\0",
        b"list ",
        b"element face 9\n",
    ];
    trials::assert_mutations_are_read_or_refused(parse, &files, &scraps);
}
