//! A running render on disk: its scene, and what it has reached. A folder of the session's, which goes when the render ends.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::session::Session;
use crate::io::{CheckpointError, load_checkpoint, save_checkpoint, save_scene, write_atomically};
use crate::render::{Checkpoint, Region};
use crate::scene::Scene;

const PREFIX: &str = "render-";
const ABOUT: &str = "about.json";
const SCENE: &str = "scene.toml";
const CHECKPOINT: &str = "checkpoint";

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
            .write_render(|| fs::rename(folder, &self.folder).map_err(in_words))
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
        self.session.write_render(|| {
            let path = self.folder.join(CHECKPOINT);
            if !path.is_file() {
                self.keep_scene(scene)?;
            }
            save_checkpoint(&path, description, checkpoint)
                .map_err(|error| format!("{}: {error}", path.display()))
        })
    }

    /// Writes what belongs to all checkpoints, before the first.
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

    /// The checkpoint that is here, of a render of that description. A file of more than `most_bytes` is not one.
    ///
    /// # Errors
    /// Those of [`load_checkpoint`].
    pub fn checkpoint(
        &self,
        description: &str,
        most_bytes: u64,
    ) -> Result<Checkpoint, CheckpointError> {
        load_checkpoint(&self.folder.join(CHECKPOINT), description, most_bytes)
    }
}

impl Drop for KeptRender {
    fn drop(&mut self) {
        // What stays goes with the session.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// The folder of the render in that of a session that began last and was kept.
pub(super) fn newest_render(session: &Path) -> Option<PathBuf> {
    let number = |folder: &PathBuf| {
        let name = folder.file_name()?.to_str()?;
        name.strip_prefix(PREFIX)?.parse::<usize>().ok()
    };
    let folders = fs::read_dir(session).ok()?.flatten();
    let kept = folders
        .map(|entry| entry.path())
        .filter(|folder| folder.join(CHECKPOINT).is_file());
    kept.filter(|folder| number(folder).is_some())
        .max_by_key(number)
}
