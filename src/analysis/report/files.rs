//! The files of a report.

use std::path::{Path, PathBuf};

use super::error::ReportError;
use super::study::Study;
use super::{to_chart, to_csv, to_json, to_markdown};
use crate::io::{self, ImageFileError};
use crate::scene::Output;

/// What a report is written to, the file to read first in front.
pub const REPORT_FILES: [&str; 5] = [
    "report.md",
    "report.svg",
    PICTURE_FILE,
    "report.json",
    "report.csv",
];

/// The small picture of what was rendered.
pub(super) const PICTURE_FILE: &str = "report.png";

/// Makes the folder, and sees whether the files can be written: before work is spent on what could not be.
///
/// # Errors
/// When either is refused.
pub(super) fn make_folder(folder: &Path) -> Result<(), ReportError> {
    std::fs::create_dir_all(folder).map_err(|reason| ReportError::Folder {
        path: folder.to_owned(),
        reason,
    })?;
    for path in REPORT_FILES.map(|name| folder.join(name)) {
        io::check_writable(&path).map_err(|reason| ReportError::File { path, reason })?;
    }
    Ok(())
}

/// Where a report goes: the folder that was asked for, or where that fails after all, a new one in the system's folder for
/// temporary files, so that hours of renders are not lost.
pub(super) struct Refuge<'a> {
    folder: &'a Path,
    /// The other folder, and why it is needed.
    other: Option<(PathBuf, ReportError)>,
}

impl<'a> Refuge<'a> {
    pub(super) fn of(folder: &'a Path) -> Self {
        Self {
            folder,
            other: None,
        }
    }

    /// Writes what `study` holds.
    ///
    /// # Errors
    /// What the system says, where nothing can be written anywhere.
    pub(super) fn write(&mut self, study: &Study) -> Result<(), ReportError> {
        if let Some((place, _)) = &self.other {
            return write(study, place);
        }
        let Err(reason) = write(study, self.folder) else {
            return Ok(());
        };
        let prefix = io::rescue_prefix(self.folder);
        let Ok(place) = tempfile::Builder::new().prefix(&prefix).tempdir() else {
            return Err(reason);
        };
        if write(study, place.path()).is_err() {
            return Err(reason);
        }
        self.other = Some((place.keep(), reason));
        Ok(())
    }

    /// What is to be said when all is done.
    ///
    /// # Errors
    /// Where the report is, if it is not in the folder that was asked for.
    pub(super) fn end(self) -> Result<(), ReportError> {
        self.other.map_or(Ok(()), |(place, reason)| {
            let reason = Box::new(reason);
            Err(ReportError::Elsewhere { reason, place })
        })
    }
}

/// Writes what `study` holds, each file whole or not at all.
///
/// # Errors
/// What the system says.
fn write(study: &Study, folder: &Path) -> Result<(), ReportError> {
    let texts = [
        ("report.md", to_markdown(study)),
        ("report.svg", to_chart(study).to_svg()),
        ("report.json", to_json(study)),
        ("report.csv", to_csv(study)),
    ];
    for (name, text) in texts {
        let path = folder.join(name);
        let written = io::write_atomically(&path, |file| file.write_all(text.as_bytes()));
        written.map_err(|reason| ReportError::File { path, reason })?;
    }
    write_picture(study, folder)
}

/// Writes what the scene as it is looks like, where that is known.
fn write_picture(study: &Study, folder: &Path) -> Result<(), ReportError> {
    let (Some(picture), Some(base)) = (&study.picture, study.variants.first()) else {
        return Ok(());
    };
    let path = folder.join(PICTURE_FILE);
    let output = Output::default();
    let written = io::write_image(picture, &[], &base.scene.display, &output, &path);
    written.map_err(|error| match error {
        ImageFileError::Unwritable { path, reason } => ReportError::File { path, reason },
        error @ ImageFileError::UnknownFormat { .. } => ReportError::File {
            path,
            reason: std::io::Error::other(error),
        },
    })
}
