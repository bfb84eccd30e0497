//! What keeps a report from being made, in words for the user.

use std::io;
use std::path::PathBuf;

use crate::io::{LoadError, PictureError};
use crate::render::PictureTooLarge;
use crate::scene::SceneError;

/// Why there is no report, or why it stopped.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The settings that are laid over the scene.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// One of the comparisons.
    #[error("{text}: {reason}")]
    Comparison {
        /// Its number among the comparisons, from 0.
        index: usize,
        /// As it was given.
        text: String,
        /// What is wrong with it.
        reason: ComparisonError,
    },
    /// The picture that is to be the reference.
    #[error(transparent)]
    Reference(#[from] PictureError),
    /// The picture that is to be the reference is of another size.
    #[error(
        "{}: the reference is {}×{} pixels, but the scene's picture is {}×{}",
        path.display(), reference.0, reference.1, picture.0, picture.1
    )]
    ReferenceSize {
        /// The picture's file.
        path: PathBuf,
        /// Width and height of what the file holds, in pixels.
        reference: (u32, u32),
        /// Width and height of what is rendered.
        picture: (u32, u32),
    },
    /// The picture that is to be the reference holds no radiance.
    #[error(
        "{}: this PNG holds what a screen shows with {display}, not the radiance that renders are measured against: render the reference \
        to an OpenEXR file (.exr), and give that",
        path.display()
    )]
    ReferenceDisplay {
        /// The picture's file.
        path: PathBuf,
        /// The keys of the scene that changed its radiance, with their values.
        display: String,
    },
    /// The folder is not there and cannot be made.
    #[error("{}: the folder cannot be made: {reason}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The report cannot be written.
    #[error("{}: cannot write the report: {reason}", path.display())]
    File {
        /// The file, or the folder where no file can be made in it.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The report could not be written where it was to be, and is kept elsewhere.
    #[error("{reason}; the report is in {} instead", place.display())]
    Elsewhere {
        /// The first thing that kept it from being written.
        reason: Box<ReportError>,
        /// The folder that it is in.
        place: PathBuf,
    },
    /// The pictures do not fit.
    #[error(transparent)]
    Memory(#[from] PictureTooLarge),
    /// A scene that cannot be rendered.
    #[error(transparent)]
    Render(#[from] SceneError),
}

/// What is wrong with a comparison.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// It changes nothing.
    #[error("expected KEY=VALUE, such as render.light_sampling=nee")]
    Empty,
    /// A key, a value, or a file they name.
    #[error("{}", without_option(.0))]
    Scene(LoadError),
    /// It makes a picture that cannot be laid over the others.
    #[error("all pictures must be of one size")]
    Size,
}

/// The message alone where the comparison, which is named before it, says already what it is about.
fn without_option(error: &LoadError) -> String {
    match error {
        LoadError::Scene(error) => error.message.clone(),
        error => error.to_string(),
    }
}
