//! Placeholder until branch `off` is merged.
use std::io::{self, Write};
use std::path::Path;

/// Writes.
///
/// # Errors
/// IO.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = std::fs::File::create(path)?;
    write(&mut file)
}
