//! What is wrong with a file, and where; files that are cut off, claim too much or are changed at random.

use super::*;

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
