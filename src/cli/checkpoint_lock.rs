//! One checkpoint belongs to one render at a time.
//!
//! The lock is on an empty file beside the checkpoint, which itself is another file after every time that it is kept. It is the system's:
//! it ends with the process, however that ends, and the empty file that may then be left keeps nobody out.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Keeps other renders from a checkpoint while it lives.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// Unlocked when it is closed.
    _file: File,
}

impl Lock {
    /// Takes the checkpoint at `path`, there or not; `None` where another render has it.
    ///
    /// # Errors
    /// When no file can be made beside it.
    pub fn of(path: &Path) -> io::Result<Option<Self>> {
        let path = beside(&fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()));
        loop {
            let mut options = File::options();
            let file = options.write(true).create(true).truncate(false);
            let file = file.open(&path)?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                // A file system without locks is no reason not to render.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // Whoever had it may have removed it since it was opened.
            if is_at(&file, &path) {
                return Ok(Some(Self { path, _file: file }));
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is locked, so that nobody else can have taken it. One that stays keeps nobody out.
        let _ = fs::remove_file(&self.path);
    }
}

/// The name of the file that is locked.
fn beside(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".raymini-lock");
    path.with_file_name(name)
}

/// Whether `file` is the one that `path` names.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |found: fs::Metadata| (found.dev(), found.ino());
    let (own, named) = (file.metadata().map(place), fs::metadata(path).map(place));
    own.is_ok_and(|own| named.is_ok_and(|named| named == own))
}

/// Whether there is a file of that name, which is as much as can be told.
#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_is_taken_once_and_free_again_with_nothing_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let (kept, other) = (folder.path().join("kept"), folder.path().join("other"));
        let take = |path: &Path| Lock::of(path).expect("can be locked");
        // As a killed process leaves it.
        fs::write(beside(&kept), "").expect("is written");
        let lock = take(&kept).expect("nobody has it");
        // The checkpoint is another file each time that it is kept.
        fs::write(&kept, "there").expect("is written");
        assert!(take(&kept).is_none());
        assert!(take(&folder.path().join("./kept")).is_none());
        assert!(take(&other).is_some());
        drop(lock);
        assert!(take(&kept).is_some());
        fs::remove_file(&kept).expect("is there");
        let left = fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 0);
        assert!(Lock::of(&folder.path().join("none/kept")).is_err());
    }
}
