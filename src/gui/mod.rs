//! The window.

pub mod orbit;
pub mod preview;

use std::path::PathBuf;

/// What to open.
#[derive(Debug)]
pub struct OpenRequest {
    /// Files.
    pub paths: Vec<PathBuf>,
}

/// No window.
#[derive(Debug, thiserror::Error)]
#[error("not yet")]
pub struct GuiError;

/// Opens.
///
/// # Errors
/// Always.
pub fn run(_request: OpenRequest) -> Result<(), GuiError> {
    Err(GuiError)
}
