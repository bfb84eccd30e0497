//! A running render on disk: its scene, and what it has reached. A folder of the session's, which goes when the render ends.
//!
//! What it has reached is a checkpoint now and then, and logs of the blocks of samples that tiles got since. With every checkpoint a new log
//! begins, and those before it go once the checkpoint is there.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::session::Session;
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

/// The place of a render on disk. It is removed with this value, which a process that is killed does not live to do.
#[derive(Debug)]
pub struct KeptRender {
    session: Arc<Session>,
    folder: PathBuf,
    about: RenderAbout,
    logs: Mutex<Logs>,
}

/// The logs of blocks.
#[derive(Debug, Default)]
struct Logs {
    /// The one that grows, and its number.
    current: Option<BlockLog>,
    number: usize,
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
            logs: Mutex::default(),
        }
    }

    /// What it is of.
    #[must_use]
    pub fn about(&self) -> &RenderAbout {
        &self.about
    }

    /// Moves what is in `folder` here, where nothing is yet.
    pub(super) fn take(&self, folder: &Path) -> Result<(), String> {
        let in_words = |error| format!("{}: {error}", folder.display());
        self.session
            .write_render(|| fs::rename(folder, &self.folder).map_err(in_words))?;
        let newest = self.log_files().last().map(|(number, _)| number + 1);
        *self.logs() = Logs {
            current: None,
            number: newest.unwrap_or_default(),
            has_scene: true,
        };
        Ok(())
    }

    /// Keeps `checkpoint` of a render of `scene` in place of the last one, whole or not at all. `description`: see
    /// [`describe_render`](crate::io::describe_render).
    ///
    /// # Errors
    /// In words.
    pub fn keep(
        &self,
        scene: &Scene,
        description: &str,
        checkpoint: &Checkpoint,
    ) -> Result<(), String> {
        // Tiles that are done from now on are not in the checkpoint.
        let first_after = {
            let mut logs = self.logs();
            logs.number += 1;
            self.begin_log(&mut logs, scene, description)?;
            logs.number
        };
        self.session.write_render(|| {
            let path = self.folder.join(CHECKPOINT);
            save_checkpoint(&path, description, checkpoint)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            let files = self.log_files().into_iter();
            for (_, superseded) in files.filter(|(number, _)| *number < first_after) {
                // One that stays is of use to nobody, and goes with the folder.
                let _ = fs::remove_file(superseded);
            }
            Ok(())
        })
    }

    /// Keeps a block of a render of `scene`, given as a [record](crate::io::block_record), beside the last checkpoint.
    ///
    /// # Errors
    /// In words.
    pub fn keep_block(
        &self,
        scene: &Scene,
        description: &str,
        record: &[u8],
    ) -> Result<(), String> {
        let mut logs = self.logs();
        if logs.current.is_none() {
            self.begin_log(&mut logs, scene, description)?;
        }
        let appended = logs.current.as_mut().map(|log| log.append(record));
        appended
            .unwrap_or(Ok(()))
            .map_err(|error| format!("{}: {error}", self.log_file(logs.number).display()))
    }

    /// Begins the log that is next by number, unless the session is over.
    fn begin_log(&self, logs: &mut Logs, scene: &Scene, description: &str) -> Result<(), String> {
        self.session.write_render(|| {
            if !logs.has_scene {
                self.keep_scene(scene)?;
                logs.has_scene = true;
            }
            let path = self.log_file(logs.number);
            let log = BlockLog::create(&path, description)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            logs.current = Some(log);
            Ok(())
        })
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

    /// The checkpoint that is here, of a render of that description; `None` where there is none. A file of more than `most_bytes` is
    /// not one.
    ///
    /// # Errors
    /// Those of [`load_checkpoint`], in words.
    pub fn checkpoint(
        &self,
        description: &str,
        most_bytes: u64,
    ) -> Result<Option<Checkpoint>, String> {
        let path = self.folder.join(CHECKPOINT);
        if !path.is_file() {
            return Ok(None);
        }
        let loaded = load_checkpoint(&path, description, most_bytes);
        loaded.map(Some).map_err(|error| error.reason)
    }

    /// The blocks that are here, of a render of that description.
    #[must_use]
    pub fn blocks(&self, description: &str) -> LoggedBlocks {
        let files = self.log_files().into_iter();
        let paths: Vec<_> = files.map(|(_, path)| path).collect();
        LoggedBlocks::read(&paths, description)
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
        // What stays goes with the session.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// The folder of the render in that of a session that began last and was kept.
pub(super) fn newest_render(session: &Path) -> Option<PathBuf> {
    let folders = numbered(session, PREFIX).into_iter();
    let mut kept = folders.filter(|(_, folder)| scene_of_render(folder).is_file());
    kept.next_back().map(|(_, folder)| folder)
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
