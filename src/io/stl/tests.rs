use super::*;
use crate::geometry::{TriangleMesh, shapes};
use crate::io::Dropped;
use crate::io::mesh_reading::trials;
use crate::math::DVec3;

/// Two triangles that make a square.
const SQUARE: &str = "solid a square
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 1 1 0
    endloop
  endfacet
  facet normal 0 0 1
    outer loop
      vertex -0 0 0
      vertex 1 1 0
      vertex 0 1 0
    endloop
  endfacet
endsolid a square
";

/// The square in binary, with this text in its title.
fn binary(title: &str) -> Vec<u8> {
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend(2_u32.to_le_bytes());
    let facets = [
        [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
        ],
        [
            [0.0, 0.0, 0.0],
            [-0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
    ];
    for facet in facets {
        for number in facet.as_flattened() {
            bytes.extend(f32::to_le_bytes(*number));
        }
        bytes.extend([0, 0]);
    }
    bytes
}

fn read(bytes: impl AsRef<[u8]>) -> MeshFile {
    trials::read_right(parse, bytes.as_ref())
}

fn error(bytes: impl AsRef<[u8]>) -> String {
    trials::error(parse, bytes.as_ref())
}

#[test]
fn every_way_to_write_a_square_gives_its_two_triangles() {
    let text = |from: &str, to: &str| SQUARE.replace(from, to).into_bytes();
    let followed = [binary("solid"), vec![7; 3]].concat();
    let cases = [
        ("plain", SQUARE.into()),
        ("no name", text(" a square", "")),
        ("a name with keywords", text("a square", "facet # normal")),
        ("capital letters", SQUARE.to_uppercase().into_bytes()),
        ("CR LF", text("\n", "\r\n")),
        ("lone CR", text("\n", "\r")),
        (
            "a byte order mark",
            format!("\u{FEFF}{SQUARE}").into_bytes(),
        ),
        (
            "one line after the first",
            SQUARE
                .replace('\n', " ")
                .replacen("e ", "e\n", 1)
                .into_bytes(),
        ),
        (
            "a line for each word",
            SQUARE
                .replace(' ', "\n")
                .replace("a\nsquare", "")
                .into_bytes(),
        ),
        (
            "normals that are none",
            text("normal 0 0 1", "normal nan -inf x"),
        ),
        (
            "two solids",
            text(
                "1 1 0\n    endloop\n  endfacet",
                "1 1 0\n    endloop\n  endfacet\nendsolid b\nsolid\n",
            ),
        ),
        ("no end", text("endsolid a square\n", "")),
        ("binary", binary("")),
        ("binary that begins with solid", binary("solid a square")),
        (
            "binary that looks like a text",
            binary("solid a\nfacet normal 0 0 1\nouter loop\n"),
        ),
        ("binary with more behind", followed),
    ];
    for (name, bytes) in cases {
        let file = trials::read(parse, &bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let expected = expected.map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(file.mesh.positions, expected, "{name}");
        assert!(file.mesh.positions[0].x.is_sign_positive(), "{name}");
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{name}");
        assert_eq!(file.mesh.normals, None);
        assert_eq!(
            (file.format, file.faces, file.polygons),
            ("STL", 2, 0),
            "{name}"
        );
    }
}

#[test]
fn only_corners_of_the_very_same_position_are_joined() {
    let near = SQUARE.replacen("vertex 1 1 0", "vertex 1 1.0000000000000002 0", 1);
    assert_eq!(read(near).mesh.triangles, [[0, 1, 2], [0, 3, 4]]);
    // 0.1 and 0.1 + 2⁻⁶⁰ are one number, which is not that of 0.1 in 32 bits.
    let text = SQUARE.replace("vertex 1 1 0", "vertex 0.1 1 0");
    assert_eq!(read(text).mesh.positions[2].x, 0.1);
}

#[test]
fn what_is_wrong_in_a_text_is_named_with_its_line() {
    let cut =
        |after: &str| SQUARE[..SQUARE.find(after).expect("is there") + after.len()].to_owned();
    let cases = [
        (
            SQUARE.replacen("facet", "face", 1),
            "2: expected facet or endsolid, found \"face\"",
        ),
        (
            SQUARE.replacen("facet normal", "facet", 1),
            "2: expected normal, found \"0\"",
        ),
        (
            SQUARE.replacen("0 0 1", "0 0", 1),
            "3: expected outer, found \"loop\"",
        ),
        (
            SQUARE.replacen("loop", "", 1),
            "4: expected loop, found \"vertex\"",
        ),
        (
            SQUARE.replacen("vertex", "vertices", 1),
            "4: expected vertex or endloop, found \"vertices\"",
        ),
        (
            SQUARE.replacen("vertex 1 0 0", "vertex 1 0", 1),
            "6: expected a finite coordinate, found \"vertex\"",
        ),
        (
            SQUARE.replacen("1 0 0", "1 nan 0", 1),
            "5: expected a finite coordinate, found \"nan\"",
        ),
        (
            SQUARE.replacen("1 0 0", "1 1e400 0", 1),
            "5: expected a finite coordinate, found \"1e400\"",
        ),
        (
            SQUARE.replacen("1 0 0", "1,5 0 0", 1),
            "5: expected a finite coordinate, found \"1,5\"",
        ),
        (
            SQUARE.replacen("1 0 0", "1 0 0 7", 1),
            "5: expected vertex or endloop, found \"7\"",
        ),
        (
            SQUARE.replacen("endfacet", "", 1),
            "9: expected endfacet, found \"facet\"",
        ),
        (
            SQUARE.replacen("endfacet", "endsolid", 1),
            "8: expected endfacet, found \"endsolid\"",
        ),
        (
            format!("{SQUARE}facet"),
            "17: expected solid or the end of the file, found \"facet\"",
        ),
        (
            cut("normal 0 0"),
            "2: expected the three numbers of the normal, found the end of the file",
        ),
        (cut("outer"), "3: expected loop, found the end of the file"),
        (
            cut("1 1"),
            "6: expected a finite coordinate, found the end of the file",
        ),
        (
            cut("1 1 0"),
            "6: expected vertex or endloop, found the end of the file",
        ),
        (
            cut("endloop"),
            "7: expected endfacet, found the end of the file",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), format!("line {expected}"));
    }
}

#[test]
fn what_is_wrong_in_a_binary_file_is_named_with_its_byte() {
    let whole = binary("solid");
    let before = "expected the 84 bytes before the triangles of a binary STL file";
    assert_eq!(error(""), format!("byte 0: {before}, found 0 bytes"));
    assert_eq!(
        error(&whole[..83]),
        format!("byte 83: {before}, found 83 bytes")
    );
    let expected = "byte 84: expected 2 triangles of 50 bytes, found 99 bytes";
    assert_eq!(error(&whole[..183]), expected);
    let mut many = whole.clone();
    many[80..84].fill(0xFF);
    let expected = "byte 84: expected 4294967295 triangles of 50 bytes, found 100 bytes";
    assert_eq!(error(many), expected);
    let mut bad = whole;
    bad[84 + 50 + 24..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let expected = "byte 158: expected finite coordinates, found (NaN, 1, 0)";
    assert_eq!(error(bad), expected);
}

#[test]
fn what_is_lost_is_said() {
    let polygon = "solid\nfacet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 1 1 0 vertex 0 1 0 endloop endfacet\n";
    let file = read(format!(
        "{polygon}facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 0 0 vertex 1 1 0 endloop endfacet"
    ));
    assert_eq!(
        (file.faces, file.polygons, file.mesh.triangles.len()),
        (2, 1, 2)
    );
    assert_eq!(
        file.dropped,
        Dropped {
            degenerate: 1,
            too_few_corners: 0
        }
    );
    assert_eq!(
        file.warnings,
        [
            "1 face without area was dropped (line 3)",
            "endsolid is missing (solid stands on line 1); the file may be cut off"
        ]
    );
    let mut bytes = binary("");
    bytes[84 + 49] = 1;
    bytes.extend([0; 2]);
    assert_eq!(
        read(bytes).warnings,
        [
            "attributes, which may be colours, are ignored (the first at byte 84)",
            "2 bytes after the last triangle are ignored"
        ]
    );
    for empty in ["solid\nendsolid\n".into(), [0; 84].to_vec()] {
        assert_eq!(read(empty).warnings, ["the mesh has no triangles"]);
    }
}

/// A mesh that is written has the same triangles when it is read, in 32 bits where these hold them all.
#[test]
fn what_is_written_reads_back_the_same() {
    let mut mesh = shapes::icosphere(2);
    for is_binary in [false, true] {
        let mut bytes = Vec::new();
        write(&mesh, &mut bytes).expect("a vector takes all");
        assert_eq!(
            (has_length(&bytes), has_keyword(&bytes)),
            (is_binary, !is_binary)
        );
        let read = read(bytes).mesh;
        let corners = |mesh: &TriangleMesh| -> Vec<_> {
            (0..mesh.triangles.len())
                .map(|index| mesh.corners(index))
                .collect()
        };
        assert_eq!(corners(&read), corners(&mesh));
        assert_eq!(read.positions.len(), mesh.positions.len());
        for position in &mut mesh.positions {
            *position = position.as_vec3().as_dvec3();
        }
    }
}

#[test]
fn cancelling_stops_it() {
    trials::assert_cancels(parse, SQUARE.as_bytes());
    trials::assert_cancels(parse, &binary(""));
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let scraps: [&[u8]; 9] = [
        b"",
        b"\n",
        b" ",
        b"1e999",
        b"nan",
        b"\xFF\xFF\xFF\x7F",
        b"\0\0\0\0",
        b"endloop ",
        b"vertex 1 2 3 ",
    ];
    let files = [SQUARE.into(), binary(""), binary("solid")];
    trials::assert_mutations_are_read_or_refused(parse, &files, &scraps);
}
