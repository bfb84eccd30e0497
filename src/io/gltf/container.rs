//! The two forms of a file: JSON alone, or the chunks of a GLB.

use crate::io::mesh_reading::{Malformed, Place};

/// The first bytes of a GLB.
const MAGIC: &[u8] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");
/// Bytes before the first chunk: magic, version, length.
const HEADER: usize = 12;

/// What a file holds.
#[derive(Debug)]
pub struct Container<'a> {
    pub json: &'a [u8],
    /// The data of the first buffer, in a GLB.
    pub binary: Option<&'a [u8]>,
}

/// Whether these are the bytes of a GLB.
pub fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Takes a file apart. What follows the chunks of a GLB, or is a chunk of another kind, is skipped.
pub fn take_apart(bytes: &[u8]) -> Result<Container<'_>, Malformed> {
    if !is_binary(bytes) {
        return Ok(Container {
            json: bytes,
            binary: None,
        });
    }
    let version = number_at(bytes, 4)?;
    if version != 2 {
        return Err(Malformed::at(
            Place::Byte(4),
            "version 2 of GLB",
            version.to_string(),
        ));
    }
    let length = number_at(bytes, 8)?;
    let whole = usize::try_from(length)
        .ok()
        .and_then(|length| bytes.get(..length));
    let Some(whole) = whole.filter(|whole| whole.len() >= HEADER) else {
        let found = format!("{} of them", bytes.len());
        return Err(Malformed::at(
            Place::Byte(8),
            format!("{length} bytes, as the file says"),
            found,
        ));
    };
    let (json, next) = chunk(whole, HEADER, JSON, "a chunk of JSON")?;
    let has_more = next < whole.len();
    let binary = has_more
        .then(|| chunk(whole, next, BINARY, "a chunk of binary data"))
        .transpose()?;
    Ok(Container {
        json,
        binary: binary.map(|(data, _)| data),
    })
}

/// The data of the chunk of this `kind` at a place, and where the next one begins.
fn chunk<'a>(
    bytes: &'a [u8],
    at: usize,
    kind: u32,
    expected: &str,
) -> Result<(&'a [u8], usize), Malformed> {
    let place = Place::Byte(at as u64);
    let length = number_at(bytes, at)?;
    let found = number_at(bytes, at + 4)?;
    if found != kind {
        return Err(Malformed::at(
            place,
            expected,
            format!("one of kind {found:#010x}"),
        ));
    }
    let data = &bytes[at + 8..];
    let end = usize::try_from(length).unwrap_or(usize::MAX);
    let Some(data) = data.get(..end) else {
        return Err(Malformed::at(
            place,
            format!("{expected} of {length} bytes"),
            format!("{} bytes", data.len()),
        ));
    };
    Ok((data, at + 8 + end))
}

fn number_at(bytes: &[u8], at: usize) -> Result<u32, Malformed> {
    let four = bytes.get(at..).and_then(|rest| rest.first_chunk());
    let four = four.ok_or_else(|| {
        Malformed::at(Place::Byte(at as u64), "four bytes", "the end of the file")
    })?;
    Ok(u32::from_le_bytes(*four))
}
