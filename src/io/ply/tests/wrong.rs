use super::*;

const TYPES: &str = "a type: char, uchar, short, ushort, int, uint, float or double";

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn what_is_wrong_is_named_with_its_line() {
    let lines = |lines: &[&str]| header("ascii", lines);
    let data = |data: &str| square(&XYZ, &FACES, &format!("0 0 0\n1 0 0\n1 1 0\n0 1 0\n{data}"));
    let vertex = |data: &str| square(&XYZ, &FACES, data);
    let cases = [
        // The header.
        (
            String::new(),
            "1: expected ply in the first line, found \"\"",
        ),
        (
            "plys\n".into(),
            "1: expected ply in the first line, found \"plys\"",
        ),
        (
            "ply 1\n".into(),
            "1: expected the end of the line after ply, found \"1\"",
        ),
        (
            "ply\n".into(),
            "1: expected end_header, found the end of the file",
        ),
        (
            "ply\nend_header\n".into(),
            "2: expected a line with the format before end_header, found none",
        ),
        (
            "ply\nformat text 1.0\n".into(),
            "2: expected the format ascii, binary_little_endian or binary_big_endian, found \"text\"",
        ),
        (
            "ply\nformat\n".into(),
            "2: expected the format ascii, binary_little_endian or binary_big_endian, found \"\"",
        ),
        (
            lines(&["vertex 3"]),
            "3: expected format, comment, obj_info, element, property or end_header, found \"vertex\"",
        ),
        (
            lines(&["property float x"]),
            "3: expected an element before its first property, found none",
        ),
        (
            lines(&["element"]),
            "3: expected the name of the element, found the end of the line",
        ),
        (
            lines(&["element vertex"]),
            "3: expected the number of the element's items, found \"\"",
        ),
        (
            lines(&["element vertex -1"]),
            "3: expected the number of the element's items, found \"-1\"",
        ),
        (
            lines(&["element vertex 1 2"]),
            "3: expected the end of the line after the element, found \"2\"",
        ),
        (
            lines(&["element vertex 4294967296"]),
            "3: expected fewer than 2^32 vertices, found \"4294967296\"",
        ),
        (
            lines(&["element a 1", "property half x"]),
            &format!("4: expected {TYPES}, found \"half\""),
        ),
        (
            lines(&["element a 1", "property list int x"]),
            &format!("4: expected {TYPES}, found \"x\""),
        ),
        (
            lines(&["element a 1", "property list int"]),
            &format!("4: expected {TYPES}, found \"\""),
        ),
        (
            lines(&["element a 1", "property int"]),
            "4: expected the name of the property, found the end of the line",
        ),
        (
            lines(&["element a 1", "property int a b"]),
            "4: expected the end of the line after the property, found \"b\"",
        ),
        (
            plain().replace("end_header\n", "end_header 1\n"),
            "9: expected the end of the line after end_header, found \"1\"",
        ),
        (
            plain().replace("float z", "float w"),
            "3: expected vertices with the properties x, y and z, found no z",
        ),
        (
            plain().replace("property float x\n", ""),
            "3: expected vertices with the properties x, y and z, found no x",
        ),
        (
            plain().replace("float y", "list int int y"),
            "3: expected vertices with the properties x, y and z, found no y",
        ),
        (
            plain().replace("vertex_indices", "corners"),
            "7: expected a list vertex_indices in each face, found none",
        ),
        (
            plain().replace("list uchar int", "int"),
            "7: expected a list vertex_indices in each face, found none",
        ),
        (
            plain()
                .replace("element face", "element tristrips")
                .replace("_indices", ""),
            "7: expected a list vertex_indices in each strip, found none",
        ),
        (
            lines(&[FACES[0], FACES[1], "element vertex 3"]),
            "3: expected the element vertex before each face, found none",
        ),
        (
            lines(&["element vertex 0", "element vertex 0"]),
            "4: expected one element vertex, found another",
        ),
        // The vertices.
        (
            vertex(""),
            "9: expected vertex 1 of 4, found the end of the file",
        ),
        (
            vertex("0 0 0\n1 0 0\n1 1"),
            "12: expected vertex 3 of 4, found the end of the file",
        ),
        (
            vertex("0 0\n1 0 0\n1 1 0\n"),
            "10: expected all values of vertex 1 of 4, found 2 values",
        ),
        (
            vertex("0\n1 0 0\n1 1 0\n"),
            "10: expected all values of vertex 1 of 4, found 1 value",
        ),
        (
            vertex("0 0 zero\n"),
            "10: expected a number, found \"zero\"",
        ),
        (
            vertex("0 0 nan\n"),
            "10: expected a finite coordinate, found \"nan\"",
        ),
        (
            vertex("0 0 0\n0 -1e400 0\n"),
            "11: expected a finite coordinate, found \"-1e400\"",
        ),
        (
            vertex("0 0 0 7\n"),
            "10: expected the end of the line after vertex 1 of 4, found \"7\"",
        ),
        // The faces.
        (
            data(""),
            "13: expected face 1 of 2, found the end of the file",
        ),
        (
            data("3 0 1 2\n"),
            "14: expected face 2 of 2, found the end of the file",
        ),
        (
            data("3 0 1 2\n3 0 1"),
            "15: expected face 2 of 2, found the end of the file",
        ),
        (
            data("3 0 1\n3 0 2 3\n"),
            "14: expected all values of face 1 of 2, found 3 values",
        ),
        (
            data("3 0 1 4\n"),
            "14: expected a vertex index below 4, found \"4\"",
        ),
        (
            data("3 0 1 -1\n"),
            "14: expected a vertex index below 4, found \"-1\"",
        ),
        (
            data("3 0 1.5 5\n"),
            "14: expected a vertex index below 4, found \"1.5\"",
        ),
        (
            data("3 0 1 4294967296\n"),
            "14: expected a vertex index below 4, found \"4294967296\"",
        ),
        (data("3 0 1 x\n"), "14: expected a number, found \"x\""),
        (
            data("-3 0 1 2\n"),
            "14: expected the length of a list of face 1 of 2, found \"-3\"",
        ),
        (
            data("4000000000 0 1 2\n3 0 2 3\n"),
            "15: expected face 1 of 2, found the end of the file",
        ),
        (
            data("3 0 1 2 3\n"),
            "14: expected the end of the line after face 1 of 2, found \"3\"",
        ),
        // The end.
        (
            data("3 0 1 2\n3 0 2 3\n3 1 2 3\n"),
            "16: expected the end of the file after the last element, found \"3\"",
        ),
        (
            lines(&["element a 1", "property list int int a", "property int b"]) + "-1\n",
            "7: expected the length of a list of item 1 of 1, found \"-1\"",
        ),
        (
            lines(&["element a 2", "property int b"]) + "1 2\n",
            "6: expected the end of the line after item 1 of 2, found \"2\"",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), format!("line {expected}"));
    }
}

#[test]
fn what_is_wrong_in_binary_data_is_named_with_its_byte() {
    let whole = binary(true, "float", "int", "int");
    let start = whole.len() - 48 - 20;
    let changed = |at: usize, bytes: &[u8]| {
        let mut file = whole.clone();
        file.splice(start + at..start + at + bytes.len(), bytes.iter().copied());
        error(file)
    };
    let at = |byte: usize, sentence: &str| format!("byte {}: expected {sentence}", start + byte);
    let truncated = |length: usize| error(&whole[..start + length]);
    assert_eq!(
        truncated(0),
        at(0, "vertex 1 of 4, found the end of the file")
    );
    assert_eq!(
        truncated(13),
        at(13, "vertex 2 of 4, found the end of the file")
    );
    assert_eq!(
        truncated(51),
        at(51, "face 1 of 1, found the end of the file")
    );
    assert_eq!(
        truncated(67),
        at(67, "face 1 of 1, found the end of the file")
    );
    assert_eq!(
        changed(16, &f32::NAN.to_be_bytes()),
        at(16, "a finite coordinate, found NaN")
    );
    assert_eq!(
        changed(48, &(-1_i32).to_be_bytes()),
        at(48, "the length of a list of face 1 of 1, found -1")
    );
    assert_eq!(
        changed(48, &i32::MAX.to_be_bytes()),
        at(68, "face 1 of 1, found the end of the file")
    );
    assert_eq!(
        changed(60, &4_i32.to_be_bytes()),
        at(60, "a vertex index below 4, found 4")
    );
    assert_eq!(
        changed(60, &(-1_i32).to_be_bytes()),
        at(60, "a vertex index below 4, found -1")
    );
    let lists = ["element a 1", "property list uint double l"];
    let lists = header("binary_little_endian", &lists);
    let expected = format!(
        "byte {}: expected item 1 of 1, found the end of the file",
        lists.len() + 8
    );
    assert_eq!(error([lists.as_bytes(), &[0xFF; 8]].concat()), expected);
    assert_eq!(
        error(lists.as_bytes()),
        expected.replace(&(lists.len() + 8).to_string(), &lists.len().to_string())
    );
}
