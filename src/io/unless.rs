//! Writing that can be cancelled.

use std::io::{self, Seek, SeekFrom, Write};

use crate::control::CancelToken;

/// A writer that fails as soon as it is cancelled, so that whoever writes to it gives up.
pub struct Unless<'a, W> {
    /// Asked before every piece.
    pub cancel: &'a CancelToken,
    /// Where it writes.
    pub inner: W,
}

/// Fails once it is cancelled.
///
/// # Errors
/// Then.
pub fn check(cancel: &CancelToken) -> io::Result<()> {
    if cancel.is_cancelled() {
        return Err(cancelled());
    }
    Ok(())
}

/// What fails then.
pub fn cancelled() -> io::Error {
    io::Error::other("cancelled")
}

impl<W: Write> Write for Unless<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        /// No more bytes go at once, so that cancelling answers between pieces.
        const PIECE: usize = 1 << 20;
        check(self.cancel)?;
        self.inner.write(&bytes[..bytes.len().min(PIECE)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Unless<'_, W> {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.inner.seek(place)
    }
}
