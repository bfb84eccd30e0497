//! The files of a report.

use std::path::Path;

use super::error::ReportError;
use super::study::Study;
use super::{to_chart, to_csv, to_json, to_markdown};
use crate::io;

/// What a report is written to, the file to read first in front.
pub const REPORT_FILES: [&str; 4] = ["report.md", "report.svg", "report.json", "report.csv"];

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

/// Writes what `study` holds, each file whole or not at all.
///
/// # Errors
/// What the system says.
pub(super) fn write(study: &Study, folder: &Path) -> Result<(), ReportError> {
    let texts = [
        to_markdown(study),
        to_chart(study).to_svg(),
        to_json(study),
        to_csv(study),
    ];
    for (name, text) in REPORT_FILES.into_iter().zip(texts) {
        let path = folder.join(name);
        let written = io::write_atomically(&path, |file| file.write_all(text.as_bytes()));
        written.map_err(|reason| ReportError::File { path, reason })?;
    }
    Ok(())
}
