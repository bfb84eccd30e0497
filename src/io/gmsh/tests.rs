use std::fmt::Write as _;

use super::*;
use crate::io::mesh_reading::trials::{self, CUBE, FILLINGS, area_and_volume};

fn read(text: impl AsRef<[u8]>) -> MeshFile {
    trials::read_right(parse, text.as_ref())
}

fn error(text: impl AsRef<[u8]>) -> String {
    trials::error(parse, text.as_ref())
}

/// Numbers of nodes with gaps between them.
fn number(index: u32) -> u32 {
    10 * index + 3
}

fn nodes_of_two() -> String {
    let line = |(index, [x, y, z]): (u32, [f64; 3])| format!("{} {x} {y} {z}\n", number(index));
    let lines: String = (0..).zip(CUBE).map(line).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a b\"\n$EndPhysicalNames\n$Nodes\n9\n{lines}$EndNodes\n"
    )
}

/// Elements of a kind each, with one tag.
fn elements_of_two(elements: &[(u32, &[u32])]) -> String {
    let line = |(kind, corners): &(u32, &[u32])| {
        let corners = corners.iter().map(|&index| format!(" {}", number(index)));
        format!("1 {kind} 1 99{}\n", corners.collect::<String>())
    };
    let lines: String = elements.iter().map(line).collect();
    format!("$Elements\n{}\n{lines}$EndElements\n", elements.len())
}

/// In blocks: a vertex with a parameter, the others; then the tetrahedra, and a line.
fn version_four(filling: &[[u32; 4]]) -> String {
    let mut text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n".to_owned();
    text += "$Nodes\n2 9 3 83\n1 5 1 1\n3\n0 0 0 0.5\n3 1 0 8\n";
    text.extend((1..9).map(|index| format!("{}\n", number(index))));
    text.extend(CUBE[1..].iter().map(|[x, y, z]| format!("{x} {y} {z}\n")));
    let _ = write!(
        text,
        "$EndNodes\n$Elements\n2 {} 1 99\n1 5 1 1\n1 3 13\n3 1 4 {}\n",
        filling.len() + 1,
        filling.len()
    );
    text.extend(filling.iter().map(|&corners| {
        let [a, b, c, d] = corners.map(number);
        format!("7 {a} {b} {c} {d}\n")
    }));
    text + "$EndElements\n"
}

#[test]
fn a_cube_of_tetrahedra_shows_its_six_sides() {
    for (filling, inside) in FILLINGS.into_iter().zip([4, 6, 18]) {
        let elements: Vec<(u32, &[u32])> = filling.iter().map(|c| (4, &c[..])).collect();
        let two = nodes_of_two() + &elements_of_two(&elements);
        for text in [two, version_four(filling)] {
            let file = read(&text);
            assert_eq!((file.format, file.mesh.triangles.len()), ("Gmsh", 12));
            let (area, volume) = area_and_volume(&file);
            assert!((area - 6.0).abs() < 1e-14 && (volume - 1.0).abs() < 1e-14);
            let expected = format!("12 faces outside are shown and {inside} inside are not");
            assert!(file.warnings[0].contains(&expected), "{:?}", file.warnings);
        }
    }
}

#[test]
fn faces_lines_and_cells_of_all_kinds_are_told_apart() {
    let elements: [(u32, &[u32]); 8] = [
        (15, &[0]),
        (1, &[0, 1]),
        (2, &[0, 1, 2]),
        (3, &[0, 1, 3, 2]),
        (9, &[4, 5, 7, 0, 0, 0]),
        (5, &[0, 1, 3, 2, 4, 5, 7, 6]),
        (11, &[0, 1, 2, 4, 8, 8, 8, 8, 8, 8]),
        (777, &[]),
    ];
    let file = read(nodes_of_two() + &elements_of_two(&elements));
    // Of the faces that the file gives, all belong to the hexahedron: two triangles to each of its sides, and the four of the
    // second-order tetrahedron, one of which is half a side.
    assert_eq!(file.mesh.triangles.len(), 12 + 4);
    assert_eq!(
        file.warnings,
        [
            "of 2 cells, 10 faces outside are shown and 0 inside are not",
            "1 cell of an unknown kind is ignored (line 29)",
            "2 curved cells are taken as ones between their corners (the first on line 26)",
        ]
    );
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let start = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    let cases = [
        (
            "$MeshFormat\n3 0 8\n".into(),
            "line 2: expected the version 2, 2.1, 2.2 or 4.1, found \"3\"",
        ),
        (
            "$MeshFormat\n4.1 1 8\n".into(),
            "line 2: expected 0 for text: binary files are not read, found \"1\"",
        ),
        (
            format!("{start}Nodes\n"),
            "line 4: expected a section such as $Nodes, found \"Nodes\"",
        ),
        (
            format!("{start}$A\n1 2\n"),
            "line 5: expected $EndA after line 4, found the end of the file",
        ),
        (
            format!("{start}$Nodes\n2\n1 0 0 0\n1 0 0 0\n"),
            "line 7: expected a number of its own for each node, found 1 again",
        ),
        (
            format!("{start}$Nodes\n9999999999\n1 0 0 0\n"),
            "line 6: expected the number of a node, found the end of the file",
        ),
        (
            format!("{start}$Nodes\n1\n1 0 0 nan\n"),
            "line 6: expected a finite coordinate, found \"nan\"",
        ),
        (
            nodes_of_two() + "$Elements\n1\n1 4 0 3 13 23 4\n",
            "line 22: expected the number of a node, found \"4\"",
        ),
        (
            nodes_of_two() + "$Elements\n1\n1 4 0 3 13\n",
            "line 22: expected all nodes of the element, found the end of the line",
        ),
        (
            nodes_of_two() + "$Elements\n0\n$End\n",
            "line 22: expected $EndElements, found \"$End\"",
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
    trials::assert_cancels(parse, version_four(FILLINGS[1]).as_bytes());
    trials::assert_cancels(parse, nodes_of_two().as_bytes());
}

#[test]
fn random_mutations_never_panic_nor_hang() {
    let elements: Vec<(u32, &[u32])> = FILLINGS[0].iter().map(|c| (4, &c[..])).collect();
    let two = nodes_of_two() + &elements_of_two(&elements);
    let scraps: [&[u8]; 10] = [
        b"",
        b"\n",
        b" ",
        b"-1",
        b"99999999999999999999",
        b"nan",
        b"$Nodes",
        b"$EndNodes",
        b"$",
        b"4.1",
    ];
    let files = [two.into_bytes(), version_four(FILLINGS[2]).into_bytes()];
    trials::assert_mutations_are_read_or_refused(parse, &files, &scraps);
}
