use super::*;
use crate::geometry::shapes;
use crate::io::mesh_reading::all_faces;
use crate::io::mesh_reading::trials::{self, CUBE, FILLINGS, area_and_volume};

fn read(text: impl AsRef<[u8]>) -> MeshFile {
    trials::read_right(parse, text.as_ref())
}

fn error(text: impl AsRef<[u8]>) -> String {
    trials::error(parse, text.as_ref())
}

/// The cube's vertices.
fn vertices() -> String {
    let lines = CUBE.map(|[x, y, z]| format!("{x} {y} {z} 7\n")).concat();
    format!("MeshVersionFormatted 2\nDimension 3\nVertices\n9\n{lines}")
}

fn section(keyword: &str, items: &[&[u32]]) -> String {
    let line = |item: &&[u32]| {
        let numbers = item.iter().map(|index| format!("{} ", index + 1));
        numbers.collect::<String>() + "0\n"
    };
    let lines: String = items.iter().map(line).collect();
    format!("{keyword}\n{}\n{lines}", items.len())
}

fn tetrahedra(filling: &[[u32; 4]]) -> String {
    let items: Vec<&[u32]> = filling.iter().map(|corners| &corners[..]).collect();
    section("Tetrahedra", &items)
}

#[test]
fn a_cube_of_tetrahedra_shows_its_six_sides() {
    for (filling, inside) in FILLINGS.into_iter().zip([4, 6, 18]) {
        let file = read(format!("{}{}End\n", vertices(), tetrahedra(filling)));
        assert_eq!((file.format, file.mesh.triangles.len()), ("Medit", 12));
        let (area, volume) = area_and_volume(&file);
        assert!((area - 6.0).abs() < 1e-14 && (volume - 1.0).abs() < 1e-14);
        let expected = format!("12 faces outside are shown and {inside} inside are not");
        assert!(file.warnings[0].contains(&expected), "{:?}", file.warnings);
    }
}

/// Those of its tetrahedra are there once, whichever way the file turns them; others stay as they are.
#[test]
fn faces_beside_tetrahedra_are_kept() {
    let faces = section(
        "Triangles",
        &[&[0, 1, 3], &[0, 3, 2], &[0, 8, 3], &[0, 5, 8]],
    );
    let quads = section("Quadrilaterals", &[&[0, 1, 3, 2]]);
    let text = format!("{}{faces}{quads}", vertices());
    let alone = read(&text);
    assert_eq!((alone.faces, alone.polygons), (5, 1));
    assert_eq!(
        alone.mesh.triangles[..4],
        [[0, 1, 3], [0, 3, 2], [0, 8, 3], [0, 5, 8]]
    );
    assert_eq!(alone.mesh.triangles.len(), 6);
    assert_eq!(alone.warnings, Vec::<String>::new());
    let solid = read(format!("{text}{}", tetrahedra(FILLINGS[1])));
    assert_eq!(solid.mesh.triangles[..2], [[0, 8, 3], [0, 5, 8]]);
    assert_eq!(solid.mesh.triangles.len(), 14);
}

/// A cube as a hexahedron, as two prisms, and as six pyramids around its middle.
#[test]
fn cubes_of_other_cells_show_their_six_sides() {
    let prisms: [&[u32]; 2] = [&[0, 1, 3, 4, 5, 7], &[4, 7, 6, 0, 3, 2]];
    let sides = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];
    let pyramids = sides.map(|[a, b, c, d]| [a, b, c, d, 8]);
    let pyramids: Vec<&[u32]> = pyramids.iter().map(|corners| &corners[..]).collect();
    for (cells, inside) in [
        (section("Hexahedra", &[&[0, 1, 3, 2, 4, 5, 7, 6]]), 0),
        (section("Prisms", &prisms), 1),
        (section("Pyramids", &pyramids), 12),
    ] {
        // The file gives some of the sides as well.
        let given = section("Quadrilaterals", &[&[0, 1, 3, 2], &[4, 6, 7, 5]]);
        for given in [String::new(), given] {
            let file = read(format!("{}{cells}{given}", vertices()));
            assert_eq!(file.mesh.triangles.len(), 12);
            let (area, volume) = area_and_volume(&file);
            assert!((area - 6.0).abs() < 1e-14 && (volume - 1.0).abs() < 1e-14);
            let expected = format!(" outside are shown and {inside} inside are not");
            assert!(file.warnings[0].contains(&expected), "{:?}", file.warnings);
        }
    }
}

/// The part has each face once: those outside look outwards, and the others, from both sides, fill what is within.
#[test]
fn the_inner_part_has_every_face_once() {
    for (filling, inside) in FILLINGS.into_iter().zip([4, 6, 18]) {
        let file = read(format!("{}{}", vertices(), tetrahedra(filling)));
        let inner = all_faces(&file.mesh.positions, &file.cells);
        assert_eq!(inner.triangles.len(), 12 + inside);
        assert_eq!(inner.validate(), Ok(()));
        let mut faces: Vec<_> = inner.triangles.clone();
        for face in &mut faces {
            face.sort_unstable();
        }
        faces.sort_unstable();
        let mut expected: Vec<_> = filling
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]])
            .collect();
        for face in &mut expected {
            face.sort_unstable();
        }
        expected.sort_unstable();
        expected.dedup();
        assert_eq!(faces, expected);
    }
}

#[test]
fn sections_of_other_kinds_are_passed_over() {
    let plain = format!("{}{}", vertices(), section("Triangles", &[&[0, 1, 2]]));
    let expected = read(&plain).mesh;
    for text in [
        plain
            .replace("Vertices", "\nVERTICES # all\n")
            .replace("Dimension 3", "dimension\n3"),
        format!("{plain}Edges 2\n1 2 0\n2 3 0\nNormals\n1\n0 0 1e0\nEnd\nwhat is this"),
        plain.replace("Triangles", "Corners\n1\n1\nRidges 0\nTriangles"),
        plain.replace('\n', "\r\n"),
    ] {
        let file = read(&text);
        assert_eq!(
            (file.mesh, file.warnings),
            (expected.clone(), Vec::new()),
            "{text}"
        );
    }
    let flat =
        "MeshVersionFormatted 1 Dimension 2 Vertices 3 0 0 1 1 0 1 0 1 1 Triangles 1 1 2 3 0";
    let file = read(flat);
    assert_eq!(file.mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let start = "MeshVersionFormatted 2\nDimension 3\n";
    let cases = [
        (
            "MeshVersion 2\n".into(),
            "line 1: expected MeshVersionFormatted, found \"MeshVersion\"",
        ),
        (
            "MeshVersionFormatted\n".into(),
            "line 1: expected the version of the format, found the end of the file",
        ),
        (
            "MeshVersionFormatted 2\nDimension 4\n".into(),
            "line 2: expected the dimension, 2 or 3, found \"4\"",
        ),
        (
            format!("{start}Triangles\n1\n1 2 3 0\n"),
            "line 3: expected Vertices before triangles, found none",
        ),
        (
            format!("{start}Vertices\n2\n0 0 0 0\n0 inf 0 0\n"),
            "line 6: expected a finite coordinate, found \"inf\"",
        ),
        (
            format!("{start}Vertices\n99999999999\n0 0 0 0\n"),
            "line 5: expected item 2 of 99999999999 vertices, found the end of the file",
        ),
        (
            format!("{start}Vertices\n1\n0 0 0 x\n"),
            "line 5: expected a reference, a number, found \"x\"",
        ),
        (
            format!("{start}Vertices\n1\n0 0 0 0\n5\n"),
            "line 6: expected a keyword of Medit, found \"5\"",
        ),
        (
            format!("{}Tetrahedra\n1\n1 2 3 10 0\n", vertices()),
            "line 16: expected a vertex number from 1 to 9, found \"10\"",
        ),
        (
            format!("{}Triangles\n1\n0 1 2 0\n", vertices()),
            "line 16: expected a vertex number from 1 to 9, found \"0\"",
        ),
        (
            format!("{}Vertices\n1\n", vertices()),
            "line 14: expected one section of Vertices, found another",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), expected);
    }
}

#[test]
fn what_is_written_reads_back_the_same() {
    trials::assert_written_is_read(write, parse);
}

#[test]
fn cancelling_stops_it() {
    trials::assert_cancels(
        parse,
        format!("{}{}", vertices(), tetrahedra(FILLINGS[0])).as_bytes(),
    );
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let solid = format!("{}{}", vertices(), tetrahedra(FILLINGS[2])).into_bytes();
    let mut ball = Vec::new();
    write(&shapes::icosphere(0), &mut ball).expect("a vector takes all");
    let scraps: [&[u8]; 10] = [
        b"",
        b"\n",
        b" ",
        b"-1",
        b"99999999999999999999",
        b"nan",
        b"Tetrahedra",
        b"Vertices",
        b"End",
        b"#",
    ];
    trials::assert_mutations_are_read_or_refused(parse, &[solid, ball], &scraps);
}
