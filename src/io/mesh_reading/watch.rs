//! Progress and cancelling while a mesh is read.

use crate::control::{CancelToken, Progress};

/// Where to report how far reading came, and whom to ask whether to go on.
pub struct Watch<'a> {
    cancel: &'a CancelToken,
    progress: &'a Progress,
    reported: usize,
}

impl<'a> Watch<'a> {
    /// Nothing is read yet.
    pub fn new(cancel: &'a CancelToken, progress: &'a Progress) -> Self {
        Self {
            cancel,
            progress,
            reported: 0,
        }
    }

    /// Reports the bytes up to `position`; `None` when cancelled.
    pub fn report(&mut self, position: usize) -> Option<()> {
        self.progress.advance((position - self.reported) as u64);
        self.reported = position;
        (!self.cancel.is_cancelled()).then_some(())
    }

    /// [`Watch::report`] at one in [`REPORT_EVERY`] of the items that are read, this one of number `index`.
    pub fn report_item(&mut self, index: u64, position: usize) -> Option<()> {
        if index.is_multiple_of(REPORT_EVERY) {
            self.report(position)
        } else {
            Some(())
        }
    }

    /// Whether to go on, asked at one in [`REPORT_EVERY`] items; `None` when cancelled.
    pub fn go_on(&self, index: u64) -> Option<()> {
        let is_asked = index.is_multiple_of(REPORT_EVERY);
        (!is_asked || !self.cancel.is_cancelled()).then_some(())
    }
}

/// Vertices or faces between two looks at the cancel token.
const REPORT_EVERY: u64 = 4096;

/// The capacity for `declared` things if the bytes have room for at most `possible`.
pub fn capacity(declared: u64, possible: usize) -> usize {
    usize::try_from(declared).map_or(possible, |declared| declared.min(possible))
}
