//! A render on disk: its scene, and what it has reached. A folder of the session's, which goes when nobody needs it any more: when the render
//! ends, or, where it took long, when its picture is saved or another render takes its place.
//!
//! What it has reached is a checkpoint now and then, and logs of the blocks of samples that tiles got since. With every checkpoint a new log
//! begins, and those before it go once the checkpoint is there.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::session::Session;
use crate::control::{CancelToken, Progress};
use crate::io::{
    BlockLog, LoggedBlocks, load_checkpoint, save_checkpoint, save_scene, write_atomically,
};
use crate::render::{Checkpoint, Region};
use crate::scene::Scene;

const PREFIX: &str = "render-";
const ABOUT: &str = "about.json";
const SCENE: &str = "scene.toml";
const CHECKPOINT: &str = "checkpoint";
const LOG_PREFIX: &str = "blocks-";

/// What a render is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderAbout {
    /// What people call the scene.
    pub name: String,
    /// The scene file that it was opened from or saved to last.
    pub path: Option<PathBuf>,
    /// The part of the picture.
    pub region: Region,
}

impl RenderAbout {
    /// What the render in `folder` is of.
    ///
    /// # Errors
    /// In words.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(ABOUT);
        let in_words = |reason: &dyn std::fmt::Display| format!("{}: {reason}", path.display());
        let text = fs::read_to_string(&path).map_err(|error| in_words(&error))?;
        serde_json::from_str(&text).map_err(|error| in_words(&error))
    }
}

/// The scene file of the render in `folder`.
#[must_use]
pub fn scene_of_render(folder: &Path) -> PathBuf {
    folder.join(SCENE)
}

/// The place of a render on disk. It is removed with this value, which a process that is killed does not live to do, unless its session is
/// [left](Session::leave). One that such a process left is not removed before it is [accepted](Self::accept).
#[derive(Debug)]
pub struct KeptRender {
    session: Arc<Session>,
    folder: PathBuf,
    about: RenderAbout,
    /// Whether it was left by another process, and nobody went on with it yet.
    is_found: AtomicBool,
    given_up: CancelToken,
    logs: Mutex<Logs>,
}

/// The logs of blocks.
#[derive(Debug, Default)]
struct Logs {
    /// The one that grows; `None` before the first, and where none can be written.
    current: Option<BlockLog>,
    /// Its number.
    number: usize,
    /// The number of the first that this process writes: those before it are of one that was killed.
    first_own: usize,
    /// Whether the scene is on disk, which comes before all else.
    has_scene: bool,
}

impl KeptRender {
    pub(super) fn new(
        session: Arc<Session>,
        folder: &Path,
        number: usize,
        about: RenderAbout,
    ) -> Self {
        Self {
            session,
            folder: folder.join(format!("{PREFIX}{number}")),
            about,
            is_found: AtomicBool::new(false),
            given_up: CancelToken::new(),
            logs: Mutex::default(),
        }
    }

    /// What it is of.
    #[must_use]
    pub fn about(&self) -> &RenderAbout {
        &self.about
    }

    /// The session that it is a part of.
    pub(super) fn session(&self) -> &Arc<Session> {
        &self.session
    }

    /// Has nothing more written here: what is there stays as it is.
    pub fn give_up(&self) {
        self.given_up.cancel();
    }

    /// Whether it is [given up](Self::give_up).
    pub(super) fn given_up(&self) -> &CancelToken {
        &self.given_up
    }

    /// Moves what is in `folder` here, where nothing is yet.
    pub(super) fn take(&self, folder: &Path) -> Result<(), String> {
        let in_words = |error| format!("{}: {error}", folder.display());
        self.session
            .move_render(|| fs::rename(folder, &self.folder).map_err(in_words))?;
        self.is_found.store(true, Ordering::Relaxed);
        let newest = self.log_files().last().map(|(number, _)| *number);
        let first_own = newest.map_or(0, |newest| newest.saturating_add(1));
        *self.logs() = Logs {
            current: None,
            number: first_own,
            first_own,
            has_scene: true,
        };
        Ok(())
    }

    /// Keeps `checkpoint` of a render of `scene` in place of the last one, whole or not at all. `description`: see
    /// [`describe_render`](crate::io::describe_render). The logs before the one that grows go; those of a process that was killed stay where
    /// `needs_old`. When cancelled, all stays as it is.
    ///
    /// # Errors
    /// In words.
    pub fn keep(
        &self,
        scene: &Scene,
        description: &str,
        checkpoint: &Checkpoint,
        needs_old: bool,
        cancel: &CancelToken,
    ) -> Result<(), String> {
        let superseded = {
            let mut logs = self.logs();
            self.session
                .write_render(|| self.keep_scene_once(&mut logs, scene))?;
            let first = if needs_old { logs.first_own } else { 0 };
            first..logs.number
        };
        self.session.write_render(|| {
            let path = self.folder.join(CHECKPOINT);
            let saved = save_checkpoint(&path, description, checkpoint, cancel)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            if saved.is_none() {
                return Ok(());
            }
            let files = self.log_files().into_iter();
            for (_, file) in files.filter(|(number, _)| superseded.contains(number)) {
                // One that stays is of use to nobody, and goes with the folder.
                let _ = fs::remove_file(file);
            }
            Ok(())
        })
    }

    /// Begins a log of blocks of a render of `scene`, after those that are there, unless the session is over.
    ///
    /// # Errors
    /// In words. Nothing is logged then.
    pub fn begin_log(&self, scene: &Scene, description: &str) -> Result<(), String> {
        let mut logs = self.logs();
        logs.current = None;
        logs.number += 1;
        self.session.write_render(|| {
            self.keep_scene_once(&mut logs, scene)?;
            let path = self.log_file(logs.number);
            let log = BlockLog::create(&path, description)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            logs.current = Some(log);
            Ok(())
        })
    }

    /// Adds a block, given as a [record](crate::io::block_record), to the log that was begun last, if there is one. Where that fails, the log
    /// goes, to leave its room to others; the next checkpoint makes good for it.
    pub fn log_block(&self, record: &[u8]) {
        let mut logs = self.logs();
        let appended = logs.current.as_mut().map(|log| log.append(record));
        if let Some(Err(_)) = appended {
            logs.current = None;
            let _ = fs::remove_file(self.log_file(logs.number));
        }
    }

    /// Takes note that it is gone on with, or of no use: from now on it goes with this value.
    pub fn accept(&self) {
        self.is_found.store(false, Ordering::Relaxed);
    }

    /// Leaves it to be found by the next window, where another process left it and it is not [accepted](Self::accept).
    pub fn leave(&self) {
        if self.is_found.swap(false, Ordering::Relaxed) {
            let in_words = |error: std::io::Error| error.to_string();
            let leave = || self.session.leave_render(&self.folder).map_err(in_words);
            // Where it cannot be moved, it goes with the session.
            let _ = self.session.move_render(leave);
        }
    }

    /// Closes the log that grows: the render ends.
    pub fn end_log(&self) {
        self.logs().current = None;
    }

    fn keep_scene_once(&self, logs: &mut Logs, scene: &Scene) -> Result<(), String> {
        if !logs.has_scene {
            self.keep_scene(scene)?;
            logs.has_scene = true;
        }
        Ok(())
    }

    /// Writes `scene` in place of the one that is here, which differs in nothing but when it ends, where one is.
    ///
    /// # Errors
    /// In words.
    pub fn keep_scene_anew(&self, scene: &Scene) -> Result<(), String> {
        let logs = self.logs();
        if !logs.has_scene {
            return Ok(());
        }
        self.session.write_render(|| self.keep_scene(scene))
    }

    /// Writes what belongs to all that is kept.
    fn keep_scene(&self, scene: &Scene) -> Result<(), String> {
        let in_words = |error| format!("{}: {error}", self.folder.display());
        let text = serde_json::to_string_pretty(&self.about).map_err(|error| error.to_string())?;
        fs::create_dir_all(&self.folder).map_err(in_words)?;
        write_atomically(&self.folder.join(ABOUT), |file| {
            file.write_all(text.as_bytes())
        })
        .map_err(in_words)?;
        save_scene(scene, &scene_of_render(&self.folder)).map_err(|error| error.to_string())
    }

    /// What is here of a render of that description: the checkpoint, where there is one, and the blocks. A checkpoint of more than `most_bytes`
    /// is none. `None` when cancelled; `progress` advances by the bytes that are read and looked through, and knows how many there are.
    ///
    /// # Errors
    /// Those of [`load_checkpoint`](crate::io::load_checkpoint), in words.
    pub fn read(
        &self,
        description: &str,
        most_bytes: u64,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<(Option<Checkpoint>, LoggedBlocks)>, String> {
        let length = |path: &Path| fs::metadata(path).map_or(0, |file| file.len());
        let files = self.log_files().into_iter();
        let logs: Vec<_> = files.map(|(_, path)| path).collect();
        let path = self.folder.join(CHECKPOINT);
        let in_logs: u64 = logs.iter().map(|log| length(log)).sum();
        progress.set_total(2 * length(&path) + in_logs);
        let checkpoint = if path.is_file() {
            let loaded = load_checkpoint(&path, description, most_bytes, cancel, progress);
            match loaded.map_err(|error| error.reason)? {
                Some(checkpoint) => Some(checkpoint),
                None => return Ok(None),
            }
        } else {
            None
        };
        let blocks = LoggedBlocks::read_unless(&logs, description, cancel, progress);
        Ok(blocks.map(|blocks| (checkpoint, blocks)))
    }

    fn log_file(&self, number: usize) -> PathBuf {
        self.folder.join(format!("{LOG_PREFIX}{number}"))
    }

    /// The logs on disk and their numbers, in that order.
    fn log_files(&self) -> Vec<(usize, PathBuf)> {
        numbered(&self.folder, LOG_PREFIX)
    }

    fn logs(&self) -> MutexGuard<'_, Logs> {
        self.logs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for KeptRender {
    fn drop(&mut self) {
        self.logs().current = None;
        if self.session.is_left() {
            return;
        }
        self.leave();
        // What stays goes with the session.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// The folders of renders in that of a session, as they began.
pub(super) fn renders_in(session: &Path) -> impl DoubleEndedIterator<Item = PathBuf> + use<> {
    let folders = numbered(session, PREFIX).into_iter();
    folders.map(|(_, folder)| folder)
}

/// The folder of the render in that of a session that began last and was kept.
pub(super) fn newest_render(session: &Path) -> Option<PathBuf> {
    renders_in(session).rfind(|folder| scene_of_render(folder).is_file())
}

/// What lies in `folder` under names that are `prefix` and a number, by number.
fn numbered(folder: &Path, prefix: &str) -> Vec<(usize, PathBuf)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<_> = entries
        .filter_map(|entry| {
            let name = entry.file_name();
            let number = name.to_str()?.strip_prefix(prefix)?.parse().ok()?;
            Some((number, entry.path()))
        })
        .collect();
    found.sort_unstable();
    found
}

#[cfg(test)]
mod tests {
    use super::super::{Begun, begin};
    use super::*;
    use crate::io::demo_scene;
    use crate::render::PreparedScene;

    /// What is in the folder of a render, but for the scene.
    fn names(kept: &KeptRender) -> Vec<String> {
        let entries = fs::read_dir(&kept.folder).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names
            .filter(|name| name != ABOUT && name != SCENE)
            .collect();
        names.sort();
        names
    }

    #[test]
    fn logs_go_with_the_checkpoint_that_has_what_is_in_them() {
        let data = tempfile::tempdir().unwrap();
        let Begun { session, .. } = begin(data.path()).unwrap();
        let session = Arc::new(session);
        let mut scene = demo_scene();
        (scene.render.width, scene.render.height) = (4, 3);
        let region = Region::full(4, 3);
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let checkpoint = Checkpoint::before(&prepared.unwrap().unwrap(), region, &[]);
        let about = RenderAbout {
            name: "demo".to_owned(),
            path: None,
            region,
        };
        let killed = session.place_render(about.clone());
        let keep = |kept: &KeptRender, needs_old| {
            kept.begin_log(&scene, "demo").unwrap();
            let never = CancelToken::new();
            kept.keep(&scene, "demo", &checkpoint, needs_old, &never)
                .unwrap();
        };
        killed.log_block(b"before there is a log");
        killed.begin_log(&scene, "demo").unwrap();
        assert_eq!(names(&killed), ["blocks-1"]);
        keep(&killed, false);
        assert_eq!(names(&killed), ["blocks-2", "checkpoint"]);

        // Who goes on needs the logs of before until all in them is taken.
        let kept = session.place_render(about);
        kept.take(&killed.folder).unwrap();
        keep(&kept, true);
        keep(&kept, true);
        assert_eq!(names(&kept), ["blocks-2", "blocks-5", "checkpoint"]);
        keep(&kept, false);
        assert_eq!(names(&kept), ["blocks-6", "checkpoint"]);
        let folder = kept.folder.clone();
        kept.accept();
        drop(kept);
        assert!(!folder.exists());
    }

    /// However often it is asked for, until something comes of it.
    #[test]
    fn a_render_that_nobody_goes_on_with_is_found_again() {
        let data = tempfile::tempdir().unwrap();
        let mut scene = demo_scene();
        (scene.render.width, scene.render.height) = (4, 3);
        let about = RenderAbout {
            name: "demo".to_owned(),
            path: None,
            region: Region::full(4, 3),
        };
        let Begun { session, .. } = begin(data.path()).unwrap();
        let session = Arc::new(session);
        let killed = session.place_render(about.clone());
        killed.begin_log(&scene, "demo").unwrap();
        let mut folder = killed.folder.clone();
        for is_accepted in [false, false, true] {
            let kept = session.place_render(about.clone());
            kept.take(&folder).unwrap();
            assert_eq!(names(&kept), ["blocks-1"]);
            if is_accepted {
                kept.accept();
            }
            drop(kept);
            let Begun {
                session: other,
                lost,
            } = begin(data.path()).unwrap();
            assert_eq!(lost.len(), usize::from(!is_accepted));
            if let Some(found) = lost.first().and_then(|lost| lost.render()) {
                folder = found.to_owned();
            }
            other.end();
        }
        assert!(!folder.exists());
    }
}
