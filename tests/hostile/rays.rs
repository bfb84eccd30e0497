use raymini::io::npy::{read, write};

use super::{assert_memory, assert_message, measured};

/// Bytes of memory per byte of the file: rays are kept as they stand there.
const MEMORY: usize = 2;

/// Reads `bytes` as an array of rays. It holds the numbers at the end of the file, bit for bit, and is the same when written and
/// read again.
pub fn check(bytes: &[u8]) {
    let (rows, peak) = measured(|| read(bytes));
    assert_memory(peak, MEMORY, bytes.len());
    let rows = match rows {
        Ok(rows) => rows,
        Err(error) => return assert_message(&error.to_string()),
    };
    let bits = |rows: &[[f32; 7]]| -> Vec<u8> {
        let values = rows.iter().flatten();
        values.flat_map(|value| value.to_le_bytes()).collect()
    };
    let expected = bits(&rows);
    assert!(bytes.ends_with(&expected));

    let mut written = Vec::new();
    write(&rows, &mut written).expect("a vector takes all");
    let again = read(&written).unwrap_or_else(|error| panic!("what is written: {error}"));
    assert_eq!(bits(&again), expected);
}
