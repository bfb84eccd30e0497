use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::control::{CancelToken, Progress};

/// All bytes of a regular file, read in pieces so that cancelling answers; `progress` advances by each byte. `None` when
/// cancelled. `expected`: what the file should be, in words: "a mesh file".
///
/// # Errors
/// Why it cannot be read, in a plain sentence that does not name the file.
pub fn read_file(
    path: &Path,
    expected: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Vec<u8>>, String> {
    const PIECE: u64 = 1 << 20;
    // Asked before opening: opening a pipe waits for a writer.
    let kind = std::fs::metadata(path).map_err(|error| in_words(&error))?;
    if !kind.is_file() {
        let what = if kind.is_dir() {
            "a folder"
        } else {
            "not a regular file"
        };
        return Err(format!("this is {what}, {expected} was expected"));
    }
    let mut file = File::open(path).map_err(|error| in_words(&error))?;
    let mut bytes = Vec::new();
    while !cancel.is_cancelled() {
        match file.by_ref().take(PIECE).read_to_end(&mut bytes) {
            Ok(0) => return Ok(Some(bytes)),
            Ok(count) => progress.advance(count as u64),
            Err(error) => return Err(in_words(&error)),
        }
    }
    Ok(None)
}

fn in_words(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "you are not allowed to read this file".to_owned(),
        _ => format!("the file cannot be read: {error}"),
    }
}
