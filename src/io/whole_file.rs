//! Opening and reading files. Only regular ones are read, and none for which there is no memory; errors leave the path to the caller.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::control::{CancelToken, Progress};
use crate::memory::require;

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
    require_memory(path, 1)?;
    read_bounded_file(path, expected, u64::MAX, cancel, progress)
}

/// Says whether there is memory for a file `times` over, as it is needed for it and for what comes of it. Of a file that cannot be
/// found it says nothing.
///
/// # Errors
/// That there is not, in a plain sentence that does not name the file.
pub fn require_memory(path: &Path, times: u64) -> Result<(), String> {
    let length = std::fs::metadata(path).map_or(0, |file| file.len());
    require(length.saturating_mul(times))
        .map_err(|short| format!("reading this file takes about {short}"))
}

/// [`read_file`] of at most `most_bytes`; of a file that is larger, no more is read.
///
/// # Errors
/// Those of [`read_file`], and that the file is too large.
pub fn read_bounded_file(
    path: &Path,
    expected: &str,
    most_bytes: u64,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Vec<u8>>, String> {
    const PIECE: u64 = 1 << 20;
    let mut file = open_file(path, expected)?;
    let length = file.metadata().map_or(0, |file| file.len());
    let mut bytes = Vec::with_capacity(usize::try_from(length.min(most_bytes)).unwrap_or(0));
    while !cancel.is_cancelled() {
        // The length that the system tells is no promise: a file can grow while it is read.
        match file.by_ref().take(PIECE).read_to_end(&mut bytes) {
            Ok(0) => return Ok(Some(bytes)),
            Ok(_) if bytes.len() as u64 > most_bytes => {
                let most = most_bytes >> 20;
                return Err(format!(
                    "the file is too large: {expected} has at most {most} MiB"
                ));
            }
            Ok(count) => progress.advance(count as u64),
            Err(error) => return Err(in_words(&error)),
        }
    }
    Ok(None)
}

/// Opens a regular file; `expected`: what it is to be, for the message.
///
/// # Errors
/// Why it cannot be read, in a plain sentence that does not name the file.
pub fn open_file(path: &Path, expected: &str) -> Result<File, String> {
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
    File::open(path).map_err(|error| in_words(&error))
}

fn in_words(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "you are not allowed to read this file".to_owned(),
        _ => format!("the file cannot be read: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_than_the_bound_is_kept() {
        const BOUND: u64 = 2 << 20;
        let file = tempfile::NamedTempFile::new().expect("a file");
        let read = || {
            let (cancel, progress) = (CancelToken::new(), Progress::new());
            read_bounded_file(file.path(), "a scene file", BOUND, &cancel, &progress)
        };
        file.as_file().set_len(BOUND).expect("a hole");
        let bytes = read().expect("fits").expect("nobody cancels");
        assert_eq!(bytes.len() as u64, BOUND);
        file.as_file().set_len(BOUND + 1).expect("a hole");
        let expected = "the file is too large: a scene file has at most 2 MiB";
        assert_eq!(read().expect_err("is too large"), expected);
    }
}
