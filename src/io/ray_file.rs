//! Files of rays: the edge where paths become rows of [`npy`].

use std::path::{Path, PathBuf};

use super::atomic::write_atomically;
use super::npy::{self, RayRow};
use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};

/// Why rays could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct RayFileError {
    /// The file asked for.
    pub path: PathBuf,
    /// What is wrong and what was expected, in a plain sentence.
    pub reason: String,
}

/// Reads the rays of a `.npy` file.
///
/// # Errors
/// When the file cannot be read or holds anything but an array that [`npy::read`] takes.
pub fn load_rays(path: &Path) -> Result<Vec<RayRow>, RayFileError> {
    let error = |reason| RayFileError {
        path: path.to_owned(),
        reason,
    };
    let bytes = read_file(
        path,
        "a file of rays (.npy)",
        &CancelToken::new(),
        &Progress::new(),
    )
    .map_err(error)?
    .unwrap_or_default();
    npy::read(&bytes).map_err(|wrong| error(wrong.to_string()))
}

/// Writes rays to a `.npy` file, which appears whole or not at all.
///
/// # Errors
/// What the system says.
pub fn save_rays(rows: &[RayRow], path: &Path) -> Result<(), RayFileError> {
    write_atomically(path, |out| npy::write(rows, out)).map_err(|reason| RayFileError {
        path: path.to_owned(),
        reason: format!("the rays cannot be written: {reason}"),
    })
}
