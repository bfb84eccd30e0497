//! Rays as arrays of NumPy: version 1.0, `<f4`, C order, shape `(n, 7)`, and nothing else.
//!
//! A row holds a ray's origin, its direction and where it ends, in multiples of the direction.
//! Source: NumPy Enhancement Proposal 1, A Simple File Format for NumPy Arrays.

use std::io::{self, Write};

/// A ray as a row of the array: origin, direction, largest parameter.
pub type RayRow = [f32; COLUMNS];

/// Numbers per row.
const COLUMNS: usize = 7;

/// What every file starts with: the magic word and version 1.0.
const PREFIX: &[u8; 8] = b"\x93NUMPY\x01\x00";

/// Where the dictionary starts: behind the prefix and its own length in two bytes.
const DICTIONARY: usize = PREFIX.len() + 2;

/// The header is filled up with spaces to a multiple of this.
const ALIGNMENT: usize = 64;

/// Why bytes are not an array of rays: the first thing that is wrong with them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("byte {byte}: expected {expected}, found {found}")]
pub struct NpyError {
    /// The byte it stands at, counted from 0.
    pub byte: usize,
    /// What would have been right there.
    pub expected: &'static str,
    /// What is there instead; text from the file is quoted and cut short.
    pub found: String,
}

/// The rows of the array in `bytes`, which are those of a whole file.
///
/// # Errors
/// The first thing that is wrong. Memory is taken for bytes that are there, whatever the header says.
pub fn read(bytes: &[u8]) -> Result<Vec<RayRow>, NpyError> {
    let error = |byte, expected, found: String| NpyError {
        byte,
        expected,
        found,
    };
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(error(0, "an array of NumPy (.npy)", "other data".into()));
    }
    if !bytes.starts_with(PREFIX) {
        let found = bytes.get(6..8).map_or_else(
            || "the end of the file".into(),
            |version| format!("version {}.{}", version[0], version[1]),
        );
        return Err(error(6, "version 1.0 of the format", found));
    }
    let end = |byte| error(byte, "the rest of the header", "the end of the file".into());
    let Some(&[low, high]) = bytes.get(PREFIX.len()..DICTIONARY) else {
        return Err(end(bytes.len()));
    };
    let start = DICTIONARY + usize::from(u16::from_le_bytes([low, high]));
    let Some(header) = bytes.get(..start) else {
        return Err(end(bytes.len()));
    };
    let rows = Cursor {
        bytes: header,
        byte: DICTIONARY,
    }
    .rows()?;
    let (values, rest) = bytes[start..].as_chunks::<4>();
    let (found, rest) = (values.as_chunks::<COLUMNS>(), rest);
    let (whole, part) = found;
    if whole.len() as u64 != rows || !part.is_empty() || !rest.is_empty() {
        let found = format!("{} bytes for {rows} rows", bytes.len() - start);
        return Err(error(start, "28 bytes per row of the shape", found));
    }
    let row = |row: &[[u8; 4]; COLUMNS]| row.map(f32::from_le_bytes);
    Ok(whole.iter().map(row).collect())
}

/// Writes `rows` as [`read`] takes them.
///
/// # Errors
/// What `out` returns.
pub fn write(rows: &[RayRow], out: &mut dyn Write) -> io::Result<()> {
    let mut header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {COLUMNS}), }}",
        rows.len()
    );
    while !(DICTIONARY + header.len() + 1).is_multiple_of(ALIGNMENT) {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).map_err(io::Error::other)?;
    out.write_all(PREFIX)?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    for value in rows.iter().flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}

/// A place in the header: a dictionary as Python writes it.
struct Cursor<'a> {
    /// All bytes up to the header's end, so that places are those of the file.
    bytes: &'a [u8],
    byte: usize,
}

impl<'a> Cursor<'a> {
    /// Number of rows, if the dictionary says what is read here.
    fn rows(mut self) -> Result<u64, NpyError> {
        let (mut rows, mut has_type, mut has_order) = (None, false, false);
        self.take("{", "a dictionary: {")?;
        while !self.skip("}") {
            match self.quoted()? {
                b"descr" => {
                    self.take(":", "a colon")?;
                    self.text(b"<f4", "'<f4', numbers of 32 bits, lowest byte first")?;
                    has_type = true;
                }
                b"fortran_order" => {
                    self.take(":", "a colon")?;
                    self.take("False", "False: row after row")?;
                    has_order = true;
                }
                b"shape" => {
                    self.take(":", "a colon")?;
                    rows = Some(self.shape()?);
                }
                key => {
                    self.byte -= key.len() + 2;
                    return Err(self.error("'descr', 'fortran_order' or 'shape'"));
                }
            }
            if !self.skip(",") && !self.at("}") {
                return Err(self.error("a comma, or the dictionary's end: }"));
            }
        }
        let missing = match (has_type, has_order, rows) {
            (false, ..) => "the key 'descr' before the dictionary ends",
            (_, false, _) => "the key 'fortran_order' before the dictionary ends",
            (_, _, None) => "the key 'shape' before the dictionary ends",
            (true, true, Some(rows)) => {
                self.skip_spaces();
                return if self.byte == self.bytes.len() {
                    Ok(rows)
                } else {
                    Err(self.error("nothing behind the dictionary"))
                };
            }
        };
        self.byte -= 1;
        Err(self.error(missing))
    }

    fn shape(&mut self) -> Result<u64, NpyError> {
        const SHAPE: &str = "a shape of (n, 7)";
        self.take("(", SHAPE)?;
        self.skip_spaces();
        let digits = self.rest().iter().take_while(|c| c.is_ascii_digit());
        let digits = &self.rest()[..digits.count()];
        let rows = str::from_utf8(digits)
            .ok()
            .and_then(|text| text.parse().ok());
        let rows = rows.ok_or_else(|| self.error("a number of rows"))?;
        self.byte += digits.len();
        self.take(",", SHAPE)?;
        self.take("7", SHAPE)?;
        self.skip(",");
        self.take(")", SHAPE)?;
        Ok(rows)
    }

    /// What stands between quotes; the cursor is behind them.
    fn quoted(&mut self) -> Result<&'a [u8], NpyError> {
        const KEY: &str = "a key in quotes";
        self.skip_spaces();
        let quote = match self.rest().first() {
            Some(quote @ (b'\'' | b'"')) => *quote,
            _ => return Err(self.error(KEY)),
        };
        let inside = &self.bytes[self.byte + 1..];
        let length = inside.iter().position(|&c| c == quote);
        let length = length.ok_or_else(|| self.error(KEY))?;
        self.byte += length + 2;
        Ok(&inside[..length])
    }

    fn text(&mut self, text: &[u8], expected: &'static str) -> Result<(), NpyError> {
        self.skip_spaces();
        let before = self.byte;
        if self.quoted().is_ok_and(|found| found == text) {
            return Ok(());
        }
        self.byte = before;
        Err(self.error(expected))
    }

    fn take(&mut self, text: &str, expected: &'static str) -> Result<(), NpyError> {
        if self.skip(text) {
            Ok(())
        } else {
            Err(self.error(expected))
        }
    }

    /// Moves behind `text` if that comes next.
    fn skip(&mut self, text: &str) -> bool {
        let is_there = self.at(text);
        if is_there {
            self.byte += text.len();
        }
        is_there
    }

    fn at(&mut self, text: &str) -> bool {
        self.skip_spaces();
        self.rest().starts_with(text.as_bytes())
    }

    fn skip_spaces(&mut self) {
        let spaces = self.rest().iter().take_while(|c| c.is_ascii_whitespace());
        self.byte += spaces.count();
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.byte..]
    }

    fn error(&self, expected: &'static str) -> NpyError {
        const MOST: usize = 24;
        let rest = self.rest();
        let found = if rest.is_empty() {
            "the end of the header".to_owned()
        } else {
            format!("\"{}\"", rest[..rest.len().min(MOST)].escape_ascii())
        };
        NpyError {
            byte: self.byte,
            expected,
            found,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(rows: &[RayRow]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(rows, &mut bytes).expect("a vector takes all");
        bytes
    }

    fn rows(count: usize) -> Vec<RayRow> {
        let value = |index: usize| match index % 11 {
            0 => f32::INFINITY,
            1 => -0.0,
            _ => index as f32 * 0.37 - 2.0,
        };
        let row = |row: usize| std::array::from_fn(|column| value(row * COLUMNS + column));
        (0..count).map(row).collect()
    }

    /// A file with that dictionary and so many bytes of data.
    fn file(dictionary: &str, data: usize) -> Vec<u8> {
        let mut bytes = PREFIX.to_vec();
        let length = u16::try_from(dictionary.len()).expect("short");
        bytes.extend(length.to_le_bytes());
        bytes.extend(dictionary.as_bytes());
        bytes.resize(bytes.len() + data, 0);
        bytes
    }

    #[test]
    fn rays_survive_writing_and_reading() {
        for count in [0, 1, 2, 1000] {
            let rows = rows(count);
            let bytes = written(&rows);
            assert_eq!((bytes.len() - count * 28) % ALIGNMENT, 0);
            assert_eq!(read(&bytes).as_ref(), Ok(&rows));
        }
    }

    /// As `numpy.save` of NumPy 2 writes `zeros((2, 7), 'f4')`, and as others may.
    #[test]
    fn other_writers_are_understood() {
        let numpy = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 7), }      \n";
        for dictionary in [
            numpy,
            "{\"shape\":(2,7),\"fortran_order\":False,\"descr\":\"<f4\"}",
            " { 'fortran_order' : False , 'descr' : '<f4' , 'shape' : ( 2 , 7 , ) } ",
        ] {
            let read = read(&file(dictionary, 56));
            assert_eq!(read, Ok(vec![[0.0; 7]; 2]), "{dictionary}");
        }
    }

    #[test]
    fn each_kind_of_damage_is_named_where_it_is() {
        let with = |descr: &str, order: &str, shape: &str| {
            let dictionary =
                format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
            file(&dictionary, 56)
        };
        let good = with("'<f4'", "False", "(2, 7)");
        assert!(read(&good).is_ok());
        let version = [b"\x93NUMPY\x02\x00".as_slice(), &good[8..]].concat();
        let key = "{'descr': '<f4', 'color': 3}";
        let cases: [(Vec<u8>, usize, &str, &str); 18] = [
            (Vec::new(), 0, "NumPy", "other data"),
            (b"PK\x03\x04 a zip".to_vec(), 0, "NumPy", "other data"),
            (b"\x93NUMPY".to_vec(), 6, "version 1.0", "end of the file"),
            (version, 6, "version 1.0", "version 2.0"),
            (
                good[..9].to_vec(),
                9,
                "rest of the header",
                "end of the file",
            ),
            (
                good[..50].to_vec(),
                50,
                "rest of the header",
                "end of the file",
            ),
            (with("'<f8'", "False", "(2, 7)"), 20, "'<f4'", "'<f8"),
            (with("'>f4'", "False", "(2, 7)"), 20, "'<f4'", "'>f4"),
            (with("'<f4'", "True", "(2, 7)"), 44, "False", "True"),
            (with("'<f4'", "False", "(2, 6)"), 64, "(n, 7)", "6"),
            (with("'<f4'", "False", "(14,)"), 64, "(n, 7)", ")"),
            (
                with("'<f4'", "False", "(-2, 7)"),
                61,
                "number of rows",
                "-2",
            ),
            (
                with("'<f4'", "False", "(99999999999999999999, 7)"),
                61,
                "number of rows",
                "999",
            ),
            (
                with("'<f4'", "False", "(3, 7)"),
                70,
                "28 bytes per row",
                "56 bytes for 3 rows",
            ),
            (
                with("'<f4'", "False", "(18446744073709551615, 7)"),
                89,
                "28 bytes",
                "56 bytes",
            ),
            (
                file(key, 0),
                27,
                "'descr', 'fortran_order' or 'shape'",
                "'color",
            ),
            (file("{'descr': '<f4'}", 0), 25, "'fortran_order'", "}"),
            (file("{'descr", 0), 11, "a key in quotes", "'descr"),
        ];
        for (bytes, byte, expected, found) in cases {
            let error = read(&bytes).expect_err(expected);
            assert!(error.expected.contains(expected), "{error}");
            assert!(error.found.contains(found), "{error}");
            assert_eq!(error.byte, byte, "{error}");
        }
        let more = [good.as_slice(), &[0]].concat();
        let error = read(&more).expect_err("a byte too many");
        assert_eq!(error.found, "57 bytes for 2 rows");
        let behind = file(
            "{'descr': '<f4', 'fortran_order': False, 'shape': (0, 7)} x",
            0,
        );
        let error = read(&behind).expect_err("text behind the dictionary");
        assert_eq!(error.found, "\"x\"");
    }

    /// Whatever the bytes: an answer, no panic.
    #[test]
    fn no_change_of_a_byte_panics() {
        let good = written(&rows(3));
        for index in 0..good.len() {
            for value in [0, b'\'', b'{', b'9', 0xff] {
                let mut bytes = good.clone();
                bytes[index] = value;
                let _ = read(&bytes);
            }
            assert!(read(&good[..index]).is_err());
        }
    }
}
