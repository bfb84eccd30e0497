//! Files that are there whole or not at all.

use std::collections::BTreeSet;
use std::error::Error as _;
use std::fs::{self, File, Metadata, TryLockError};
use std::io::{self, BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{Builder, NamedTempFile};

/// How names of temporary files begin and end.
const PREFIX: &str = ".raymini-";
const SUFFIX: &str = ".part";
/// How many letters stand between.
const RANDOM_LETTERS: usize = 6;

/// Writes a file so that whoever looks at `path`, at any moment, sees the old content or the new, never a part.
///
/// The bytes go to a temporary file in the same folder, are flushed to the disk, and the file is then renamed. If `write`
/// or anything after it fails, the old file is as it was and the temporary one is gone. A new file gets the permissions
/// of any other new file; an old one keeps its own. A symbolic link stays, and what it points to is replaced. What is not
/// a regular file (a device, a pipe) is written to directly.
///
/// # Errors
/// What `write` returns, or that of the system; when the target is a folder, its folder is missing, or it is read-only,
/// the message says so. Messages do not name `path`, except for the missing folder.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let Destination { target, old } = Destination::of(path)?;
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        return write_through(File::options().write(true).open(&target)?, write).map(drop);
    }
    let temporary = Temporary::beside(&target, old.as_ref())?;
    write_through(temporary.file.as_file(), write)?;
    // Some file systems notice only now that they are full.
    temporary.file.as_file().sync_all()?;
    temporary.persist(&target)
}

/// Says what would keep [`write_atomically`] from beginning to write `path`, before work is spent on what goes there: makes the
/// temporary file, and removes it, with those that killed processes left there. The file of that name is not touched.
///
/// # Errors
/// Those of [`write_atomically`], but for what shows only when there is something to write, such as a full disk.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let Destination { target, old } = Destination::of(path)?;
    // To open a pipe, even for a moment, would be noticed at its other end.
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        return Ok(());
    }
    remove_unfinished(&folder_of(&target));
    Temporary::beside(&target, old.as_ref()).map(drop)
}

/// Removes what [`write_atomically`] left in `folder` where a process was killed in the middle of it. What is being written, which its
/// writer has locked, stays.
pub fn remove_unfinished(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_temporary = name.to_str().is_some_and(is_temporary_name);
        // Not a link or a pipe that somebody calls so.
        let is_file = || entry.file_type().is_ok_and(|of| of.is_file());
        if is_temporary
            && is_file()
            && let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // One that stays is in nobody's way.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether temporary files are called so.
fn is_temporary_name(name: &str) -> bool {
    let between = name.strip_prefix(PREFIX);
    let random = between.and_then(|rest| rest.strip_suffix(SUFFIX));
    random.is_some_and(|random| random.len() == RANDOM_LETTERS)
}

/// Ends the process with exit code `code`, whatever it is doing; files that it is writing are as they were, and their temporary
/// ones are gone.
pub fn exit_process(code: u8) -> ! {
    // Held to the end, so that no other thread makes one more.
    let unfinished = unfinished();
    for path in &*unfinished {
        // One that is there already, whole and under its own name, is no longer here; for any other there is no remedy.
        let _ = fs::remove_file(path);
    }
    // At once: exit handlers of libraries, such as graphics drivers, may not expect to run on any thread.
    signal_hook::low_level::exit(code.into())
}

/// The temporary files of this process that are being written.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file, which [`exit_process`] removes as well as dropping it.
struct Temporary {
    file: NamedTempFile,
    listed: Listed,
}

/// A path in [`UNFINISHED`] until it is dropped.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// Where a file is to go.
struct Destination {
    /// The path, with links followed.
    target: PathBuf,
    /// What is there; neither a folder nor a read-only file.
    old: Option<Metadata>,
}

impl Destination {
    fn of(path: &Path) -> io::Result<Self> {
        // A link that leads nowhere is replaced itself.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = match fs::metadata(&target) {
            Ok(old) => Some(old),
            // Too long for the system, say: the temporary file's own name would not tell.
            Err(error) if error.kind() == ErrorKind::InvalidFilename => return Err(error),
            Err(_) => None,
        };
        match &old {
            Some(old) if old.is_dir() => Err(Error::new(
                ErrorKind::IsADirectory,
                "this is a folder, a file was expected",
            )),
            Some(old) if old.is_file() && old.permissions().readonly() => Err(Error::new(
                ErrorKind::PermissionDenied,
                "the file is read-only",
            )),
            _ => Ok(Self { target, old }),
        }
    }
}

impl Temporary {
    /// A new file in the target's folder, with the permissions of the file it will replace.
    fn beside(target: &Path, old: Option<&Metadata>) -> io::Result<Self> {
        let folder = folder_of(target);
        if !folder.is_dir() {
            let message = format!("the folder {} does not exist", folder.display());
            return Err(Error::new(ErrorKind::NotFound, message));
        }
        let mut builder = Builder::new();
        builder
            .prefix(PREFIX)
            .suffix(SUFFIX)
            .rand_bytes(RANDOM_LETTERS);
        like_any_new_file(&mut builder);
        let mut unfinished = unfinished();
        let file = locked(|| builder.tempfile_in(&folder)).map_err(|error| {
            // Without the temporary file's name, which tells the user nothing.
            let reason = error
                .source()
                .map_or(error.to_string(), ToString::to_string);
            let message = format!(
                "no file can be made in the folder {}: {reason}",
                folder.display()
            );
            Error::new(error.kind(), message)
        })?;
        unfinished.insert(file.path().to_owned());
        drop(unfinished);
        let listed = Listed(file.path().to_owned());
        if let Some(old) = old {
            file.as_file().set_permissions(old.permissions())?;
        }
        Ok(Self { file, listed })
    }

    /// Gives the file its own name.
    fn persist(self, target: &Path) -> io::Result<()> {
        let Self { file, listed } = self;
        file.persist(target).map_err(|error| error.error)?;
        drop(listed);
        Ok(())
    }
}

/// A file of those that `make` makes, locked as long as it is open: [`remove_unfinished`] of another process may have taken one that was
/// not locked yet for one that nobody writes.
fn locked(mut make: impl FnMut() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    loop {
        let file = make()?;
        let is_taken = match file.as_file().try_lock() {
            Ok(()) => !file.path().exists(),
            Err(TryLockError::WouldBlock) => true,
            // Without locks nobody removes anything.
            Err(TryLockError::Error(_)) => false,
        };
        if !is_taken {
            return Ok(file);
        }
    }
}

/// The folder that holds `target`; the current one for a bare name.
fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Lets the system's mask decide the permissions; those of temporary files are private otherwise.
#[cfg(unix)]
fn like_any_new_file(builder: &mut Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

/// Elsewhere new files inherit their permissions from the folder.
#[cfg(not(unix))]
fn like_any_new_file(_builder: &mut Builder<'_, '_>) {}

/// Runs `write` with a buffer before `file`.
fn write_through(
    file: impl Write,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut buffer = BufWriter::new(file);
    write(&mut buffer)?;
    buffer.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn folder() -> TempDir {
        tempfile::tempdir().expect("a temporary folder")
    }

    /// The names in a folder, to see that nothing is left behind.
    fn names(folder: &TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder.path()).expect("a folder");
        let name = |entry: io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<_> = entries
            .map(name)
            .map(|n| n.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn write_text(path: &Path, text: &str) -> io::Result<()> {
        write_atomically(path, |out| out.write_all(text.as_bytes()))
    }

    #[test]
    fn the_new_content_replaces_the_old() {
        let folder = folder();
        let path = folder.path().join("picture.png");
        for text in ["first", "second, and longer", ""] {
            write_text(&path, text).expect("written");
            assert_eq!(fs::read_to_string(&path).expect("a file"), text);
            assert_eq!(names(&folder), ["picture.png"]);
        }
    }

    /// By hand: an unlocked file of such a name is what a killed process leaves.
    #[test]
    fn what_was_left_unfinished_goes_and_what_is_being_written_stays() {
        let folder = folder();
        let path = |name: &str| folder.path().join(name);
        for name in [
            ".raymini-a1B2c3.part",
            ".raymini-notes-of-mine.part",
            "a.part",
        ] {
            fs::write(path(name), "text").expect("is written");
        }
        fs::create_dir(path(".raymini-folder.part")).expect("a folder");
        write_atomically(&path("picture.png"), |out| {
            remove_unfinished(folder.path());
            check_writable(&path("other.png"))?;
            // The folder, the two of other names, and the one that is being written.
            assert_eq!(names(&folder).len(), 4);
            out.write_all(b"whole")
        })
        .expect("written");
        let expected = [
            ".raymini-folder.part",
            ".raymini-notes-of-mine.part",
            "a.part",
            "picture.png",
        ];
        assert_eq!(names(&folder), expected);
        let written = fs::read_to_string(path("picture.png"));
        assert_eq!(written.expect("a file"), "whole");
    }

    /// Another process takes each new file for one that was left, before it is locked or after it is made.
    #[test]
    fn a_file_that_is_removed_before_it_is_locked_is_made_again() {
        let folder = folder();
        let mut made = 0;
        let mut others = Vec::new();
        let file = locked(|| {
            let file = NamedTempFile::new_in(folder.path())?;
            made += 1;
            match made {
                1 => fs::remove_file(file.path())?,
                2 => {
                    let other = File::open(file.path())?;
                    other.lock()?;
                    others.push(other);
                }
                _ => {}
            }
            Ok(file)
        });
        let file = file.expect("is made");
        assert_eq!(made, 3);
        assert!(file.path().exists());
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = folder();
        let path = folder.path().join("picture.png");
        write_text(&path, "old").expect("written");
        let error = write_atomically(&path, |out| {
            out.write_all(&vec![b'x'; 1 << 20])?;
            assert_eq!(names(&folder).len(), 2);
            Err(Error::new(ErrorKind::StorageFull, "no space left"))
        });
        assert_eq!(error.expect_err("no space").kind(), ErrorKind::StorageFull);
        assert_eq!(fs::read_to_string(&path).expect("a file"), "old");
        assert_eq!(names(&folder), ["picture.png"]);
    }

    #[test]
    fn a_panic_leaves_the_old_file_and_nothing_else() {
        let folder = folder();
        let path = folder.path().join("picture.png");
        write_text(&path, "old").expect("written");
        let panicking = || write_atomically(&path, |_| panic!("as the test wants"));
        assert!(std::panic::catch_unwind(panicking).is_err());
        assert_eq!(fs::read_to_string(&path).expect("a file"), "old");
        assert_eq!(names(&folder), ["picture.png"]);
    }

    #[test]
    fn folders_and_missing_folders_are_named() {
        let folder = folder();
        let error = write_text(folder.path(), "text").expect_err("a folder");
        assert_eq!(error.to_string(), "this is a folder, a file was expected");
        let missing = folder.path().join("no/such");
        let error = write_text(&missing.join("a.png"), "text").expect_err("no folder");
        let expected = format!("the folder {} does not exist", missing.display());
        assert_eq!(error.to_string(), expected);
        assert!(names(&folder).is_empty());
    }

    #[test]
    fn what_could_not_be_written_is_known_before() {
        let folder = folder();
        let path = folder.path().join("picture.png");
        write_text(&path, "old").expect("written");
        check_writable(&path).expect("can be written");
        check_writable(&folder.path().join("new.png")).expect("can be written");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "old");
        assert_eq!(names(&folder), ["picture.png"]);

        let missing = folder.path().join("no/a.png");
        let long = folder.path().join(format!("{}.png", "a".repeat(300)));
        let cases = [folder.path(), &missing, &path.join("a.png"), &long];
        for wrong in cases {
            let early = check_writable(wrong).expect_err("cannot be written");
            let late = write_text(wrong, "text").expect_err("cannot be written");
            assert_eq!(early.to_string(), late.to_string());
        }
    }

    #[test]
    fn a_bare_name_lies_in_the_current_folder() {
        assert_eq!(folder_of(Path::new("a.png")), Path::new("."));
        assert_eq!(folder_of(Path::new("b/a.png")), Path::new("b"));
    }

    #[test]
    fn a_read_only_file_is_refused() {
        let folder = folder();
        let path = folder.path().join("a.png");
        write_text(&path, "old").expect("written");
        let mut permissions = fs::metadata(&path).expect("a file").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).expect("permissions");
        let error = write_text(&path, "new").expect_err("read-only");
        assert_eq!(error.kind(), ErrorKind::PermissionDenied);
        assert_eq!(fs::read_to_string(&path).expect("a file"), "old");
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{PermissionsExt, symlink};

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).expect("a file").permissions().mode() & 0o777
        }

        #[test]
        fn permissions_are_those_of_any_new_file_or_of_the_old_one() {
            let folder = folder();
            let (ordinary, path) = (folder.path().join("a"), folder.path().join("b"));
            fs::write(&ordinary, "text").expect("written");
            write_text(&path, "text").expect("written");
            assert_eq!(mode(&path), mode(&ordinary));
            for kept in [0o600, 0o664, 0o755] {
                fs::set_permissions(&path, fs::Permissions::from_mode(kept)).expect("permissions");
                write_text(&path, "again").expect("written");
                assert_eq!(mode(&path), kept);
            }
        }

        #[test]
        fn a_link_stays_and_its_target_is_replaced() {
            let folder = folder();
            let (path, link) = (folder.path().join("a"), folder.path().join("link"));
            write_text(&path, "old").expect("written");
            symlink(&path, &link).expect("a link");
            write_text(&link, "new").expect("written");
            assert!(link.is_symlink());
            assert_eq!(fs::read_to_string(&path).expect("a file"), "new");
        }

        #[test]
        fn a_device_is_written_to_and_stays() {
            let null = Path::new("/dev/null");
            write_text(null, "text").expect("written");
            assert!(!fs::metadata(null).expect("a device").is_file());
        }
    }
}
