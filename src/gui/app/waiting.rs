//! A render between being asked for and its beginning: it waits for its geometry.

use std::time::Instant;

use crate::gui::recovering::Interrupted;

/// A render that was asked for.
#[derive(Debug)]
pub(super) struct WaitingRender {
    pub asked: Instant,
    /// What it goes on with; `None` where it is one of the scene as it is.
    pub interrupted: Option<Interrupted>,
    /// Whether it takes up the samples of the present one, which ended by other rules.
    pub continues: bool,
    /// Whether it only follows what is edited, and is soon another.
    pub follows: bool,
}

impl WaitingRender {
    /// One of the scene as it is, asked for now.
    pub fn new() -> Self {
        Self {
            asked: Instant::now(),
            interrupted: None,
            continues: false,
            follows: false,
        }
    }
}
