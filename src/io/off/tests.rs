//! What OFF files say, however they are written, and what is written back.

mod attributes;
mod dropped;
mod tetrahedra;
mod wrong;

use super::*;
use crate::geometry::face_normal;
use crate::io::mesh_reading::trials;

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
fn an_empty_mesh_is_read_and_warned_about() {
    for text in ["OFF\n0 0 0\n", "0 0", "OFF\n1 0 0\n0 0 0\n"] {
        let file = read(text).expect("valid");
        assert_eq!(file.warnings, ["the mesh has no triangles"], "{text}");
    }
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
