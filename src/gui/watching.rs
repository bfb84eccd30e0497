//! Files that may change on disk while the window shows what was read from them.
//!
//! A job looks at them once a second, without a frame being drawn: that takes some microseconds, and works on network drives and
//! where files are replaced by others of their name. A change is told when the file has stayed as it is from one look to the next, so
//! that one that is still being written is waited for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use super::event::Event;
use super::jobs::Job;

/// Time between two looks.
const INTERVAL: Duration = Duration::from_secs(1);

/// What tells one state of a file from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    modified: Option<SystemTime>,
    bytes: u64,
}

impl Stamp {
    /// The stamp of no file.
    const OTHER: Self = Self {
        modified: None,
        bytes: u64::MAX,
    };

    /// The stamp of the file at `path`; `None` where there is none now.
    fn of(path: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(path).ok()?;
        Some(Self {
            modified: metadata.modified().ok(),
            bytes: metadata.len(),
        })
    }
}

/// Whether a file that was read is not there any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
enum Absence {
    /// It is there, or may be about to be replaced.
    #[default]
    None,
    /// It is not, which was not told yet.
    New,
    Told,
}

/// A file, as it was read and as it was seen last.
#[derive(Clone, Copy, Debug, Default)]
struct Watched {
    /// `None` until it is looked at.
    read: Option<Stamp>,
    seen: Option<Stamp>,
    /// When reading it began, as far as that is known.
    began: Option<SystemTime>,
    absence: Absence,
    /// How often the window has accepted it.
    accepted: u64,
    /// Whether nothing that shows is from it now: it is not looked at, and what is known of it stays.
    rests: bool,
}

impl Watched {
    /// Takes in how the file is now; whether it is to be read again.
    fn look(&mut self, now: Option<Stamp>) -> bool {
        let is_settled = self.seen == now;
        self.seen = now;
        let Some(now) = now else {
            // It may be about to be replaced, or is missing: then it is new when it comes.
            let read = *self.read.get_or_insert(Stamp::OTHER);
            if is_settled && read != Stamp::OTHER && self.absence == Absence::None {
                self.absence = Absence::New;
            }
            return false;
        };
        self.absence = Absence::None;
        let is_newer = now.modified.zip(self.began).is_some_and(|(a, b)| a > b);
        let read = *self
            .read
            .get_or_insert(if is_newer { Stamp::OTHER } else { now });
        if read == now || !is_settled {
            return false;
        }
        self.read = Some(now);
        true
    }
}

/// The files that are watched. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct FileWatch(Arc<Mutex<BTreeMap<PathBuf, Watched>>>);

impl FileWatch {
    /// Watches these files from now on and no others. Those that were ever watched go on being so, with what is known of them; of the others
    /// what was written after `began` is a change: they were being read then.
    pub fn set_files(&self, files: impl IntoIterator<Item = PathBuf>, began: Option<SystemTime>) {
        let mut watched = self.lock();
        for file in watched.values_mut() {
            file.rests = true;
        }
        for path in files {
            let new = Watched {
                began,
                ..Watched::default()
            };
            watched.entry(path).or_insert(new).rests = false;
        }
    }

    /// The file at `path` was read anew, by a job that began then: nothing that was known of it before counts.
    pub fn forget(&self, path: &Path, began: Option<SystemTime>) {
        if let Some(file) = self.lock().get_mut(path) {
            *file = Watched {
                began,
                accepted: file.accepted + 1,
                rests: file.rests,
                ..Watched::default()
            };
        }
    }

    /// What the file at `path` holds is not what the window has, and is told once more when it is looked at next.
    pub fn tell_again(&self, path: &Path) {
        if let Some(file) = self.lock().get_mut(path) {
            file.read = Some(Stamp::OTHER);
        }
    }

    /// The file at `path` is now as the window has it: it has written or read it. Of one that is not watched yet this counts as soon as
    /// it is.
    pub fn accept(&self, path: &Path) {
        let mut watched = self.lock();
        let file = watched.entry(path.to_owned()).or_default();
        *file = Watched {
            accepted: file.accepted + 1,
            rests: file.rests,
            ..Watched::default()
        };
    }

    /// Looks at all files once; returns those that are to be read again.
    fn look(&self) -> Vec<PathBuf> {
        self.look_by(Stamp::of)
    }

    /// [`Self::look`], with what finds the stamp of the file at a path.
    fn look_by(&self, stamp_of: impl Fn(&Path) -> Option<Stamp>) -> Vec<PathBuf> {
        let watched = self.lock();
        let of_file = |(path, file): (&PathBuf, &Watched)| (path.clone(), file.accepted);
        let is_looked_at = |(_, file): &(&PathBuf, &Watched)| !file.rests;
        let files: Vec<_> = watched.iter().filter(is_looked_at).map(of_file).collect();
        // Looking may take its time where files are far away.
        drop(watched);
        let stamps: Vec<_> = files.iter().map(|(path, _)| stamp_of(path)).collect();
        let mut watched = self.lock();
        let changed = files.into_iter().zip(stamps).filter(|(file, stamp)| {
            let (path, accepted) = file;
            let file = watched.get_mut(path);
            // The stamp of one that was accepted meanwhile may be from before.
            let file = file.filter(|file| file.accepted == *accepted);
            file.is_some_and(|file| file.look(*stamp))
        });
        changed.map(|((path, _), _)| path).collect()
    }

    /// The files that were read and are not there any more, each once until it is there again.
    fn take_gone(&self) -> Vec<PathBuf> {
        let mut watched = self.lock();
        let gone = watched
            .iter_mut()
            .filter(|(_, file)| file.absence == Absence::New);
        let gone = gone.map(|(path, file)| {
            file.absence = Absence::Told;
            path.clone()
        });
        gone.collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Watched>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Looks at the files again and again, and tells which have changed.
pub fn watch(job: &Job<Event>, files: &FileWatch) {
    while !job.cancel.is_cancelled() {
        let changed = files.look();
        if !changed.is_empty() {
            job.send(Event::FilesChanged(changed));
        }
        let gone = files.take_gone();
        if !gone.is_empty() {
            job.send(Event::FilesGone(gone));
        }
        std::thread::sleep(INTERVAL);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_once_and_when_the_file_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.off");
        let files = FileWatch::default();
        std::fs::write(&path, "1").unwrap();
        files.set_files([path.clone()], None);
        let changed = || files.look().len();
        assert_eq!([changed(), changed()], [0, 0], "nothing has changed");
        std::fs::write(&path, "12").unwrap();
        assert_eq!(changed(), 0, "it may still be written");
        std::fs::write(&path, "123").unwrap();
        assert_eq!([changed(), changed(), changed()], [0, 1, 0]);

        // Gone is no change, is told of once, and back is one.
        std::fs::remove_file(&path).unwrap();
        assert_eq!(changed(), 0);
        assert!(files.take_gone().is_empty(), "another may take its place");
        assert_eq!([changed(), changed()], [0, 0]);
        assert_eq!(files.take_gone(), std::slice::from_ref(&path));
        assert_eq!(changed(), 0);
        assert!(files.take_gone().is_empty());
        std::fs::write(&path, "1234").unwrap();
        assert_eq!([changed(), changed(), changed()], [0, 1, 0]);

        // What the window has written itself is none.
        std::fs::write(&path, "12345").unwrap();
        files.accept(&path);
        assert_eq!([changed(), changed(), changed()], [0, 0, 0]);
    }

    #[test]
    fn files_that_stay_keep_what_is_known_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let files = FileWatch::default();
        std::fs::write(&a, "1").unwrap();
        files.set_files([a.clone()], None);
        files.look();
        std::fs::write(&a, "12").unwrap();
        std::fs::write(&b, "1").unwrap();
        files.set_files([a.clone(), b.clone()], None);
        assert_eq!([files.look(), files.look()].concat(), [a]);
    }

    /// Also where it is watched only after it was written, as of a scene that is saved under another name.
    #[test]
    fn what_the_window_writes_itself_is_no_change() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saved");
        let files = FileWatch::default();
        let began = SystemTime::now() - Duration::from_secs(5);
        std::fs::write(&path, "1").unwrap();
        files.accept(&path);
        files.set_files([path], Some(began));
        assert_eq!([files.look(), files.look(), files.look()].concat().len(), 0);
    }

    /// Undoing may lead away from a file and back to it.
    #[test]
    fn what_is_known_of_a_file_stays_while_it_is_not_watched() {
        let folder = tempfile::tempdir().unwrap();
        let [saved, changed, anew] = ["saved", "changed", "anew"].map(|name| {
            let path = folder.path().join(name);
            std::fs::write(&path, "1").unwrap();
            path
        });
        let all = [&saved, &changed, &anew].map(PathBuf::clone);
        let began = SystemTime::now() - Duration::from_secs(5);
        let files = FileWatch::default();
        files.set_files(all.clone(), None);
        files.look();
        std::fs::write(&saved, "12").unwrap();
        files.accept(&saved);
        files.look();
        files.set_files([], Some(began));
        for path in [&changed, &anew] {
            std::fs::write(path, "12").unwrap();
        }
        assert_eq!([files.look(), files.look()].concat().len(), 0);
        files.forget(&anew, Some(SystemTime::now() + Duration::from_secs(5)));
        files.set_files(all, Some(began));
        let found: Vec<_> = (0..4).flat_map(|_| files.look()).collect();
        assert_eq!(found, std::slice::from_ref(&changed), "once");
        files.tell_again(&changed);
        assert_eq!([files.look(), files.look()].concat(), [changed]);
    }

    /// Also where it is written while the watch looks.
    #[test]
    fn what_is_accepted_during_a_look_is_no_change() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saved");
        let files = FileWatch::default();
        std::fs::write(&path, "1").unwrap();
        files.set_files([path.clone()], None);
        let save_after_look = |path: &Path| {
            let stamp = Stamp::of(path);
            std::fs::write(path, "12").unwrap();
            files.accept(path);
            stamp
        };
        assert!(files.look_by(save_after_look).is_empty());
        assert_eq!([files.look(), files.look(), files.look()].concat().len(), 0);
        // Another's change after that is one.
        std::fs::write(&path, "123").unwrap();
        assert_eq!([files.look(), files.look()].concat(), [path]);
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let [before, after] = ["before", "after"].map(|name| folder.path().join(name));
        for path in [&before, &after] {
            std::fs::write(path, "1").unwrap();
        }
        let written = Stamp::of(&before).unwrap().modified.unwrap();
        let began = written + Duration::from_secs(5);
        let file = std::fs::File::options().append(true).open(&after).unwrap();
        file.set_modified(began + Duration::from_secs(5)).unwrap();
        let files = FileWatch::default();
        files.set_files([before, after.clone()], Some(began));
        let found: Vec<_> = (0..4).flat_map(|_| files.look()).collect();
        assert_eq!(found, [after], "once");
    }
}
