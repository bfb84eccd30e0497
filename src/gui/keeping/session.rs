//! Unsaved work and running renders on disk: one folder per window, and what windows before left behind.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::render::{KeptRender, RenderAbout, newest_render, renders_in, scene_of_render};
use super::{lock_shared, open_lock};
use crate::io::{remove_unfinished, save_scene, write_atomically};
use crate::scene::Scene;

/// The scene as it was edited last: a scene file like any other.
const SCENE: &str = "scene.toml";
/// What the scene belongs to.
const ABOUT: &str = "about.json";
const LOCK: &str = "lock";

/// What unsaved work belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// What people call the scene.
    pub name: String,
    /// The scene file that it was opened from or saved to last.
    pub path: Option<PathBuf>,
}

/// A folder that nobody else touches as long as this value lives.
#[derive(Debug)]
struct Held {
    folder: PathBuf,
    /// `None` once the folder is removed.
    lock: Option<File>,
}

impl Held {
    /// The session in `folder`, if no window holds it.
    fn of(folder: PathBuf) -> Option<Self> {
        let lock = open_lock(&folder.join(LOCK)).ok()?;
        lock.try_lock().ok()?;
        Some(Self {
            folder,
            lock: Some(lock),
        })
    }

    /// Writes unsaved work, whole or not at all.
    fn keep(&self, scene: &Scene, about: &About) -> Result<(), String> {
        let folder = &self.folder;
        let text = serde_json::to_string_pretty(about).map_err(|e| e.to_string())?;
        write_atomically(&folder.join(ABOUT), |file| file.write_all(text.as_bytes()))
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        save_scene(scene, &folder.join(SCENE)).map_err(|error| error.to_string())
    }

    /// Removes unsaved work, and no render.
    fn clear(&self) {
        // What is not there needs no removing.
        let _ = fs::remove_file(self.folder.join(SCENE));
    }

    fn remove(&mut self) {
        // Where an open file keeps the rest, as on some systems, that is nothing to offer.
        self.clear();
        for render in renders_in(&self.folder) {
            let _ = fs::remove_file(scene_of_render(&render));
        }
        // An open file keeps its folder on some systems.
        self.lock = None;
        // What stays is offered, or removed, at the next start.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// The place of this window's unsaved work. It stays until [`Session::end`], so that it also outlives a fault of the window.
#[derive(Debug)]
pub struct Session {
    folder: PathBuf,
    held: Mutex<Held>,
    /// Renders that were given a place.
    renders: AtomicUsize,
    /// Threads that write renders, and may have files open.
    writers: AtomicUsize,
    /// Whether renders may not be kept any more. Whoever writes one shares it; whoever moves or removes one has it alone.
    is_over: RwLock<bool>,
    /// Whether all of it is for the next window.
    is_left: AtomicBool,
}

impl Session {
    /// Removes what was kept: it is saved, or was given up.
    fn clear(&self) {
        self.held().clear();
    }

    /// Removes all of it, as the window closes: the user has decided about the work. Nothing can be kept any more. Waits for what is
    /// being written.
    pub fn end(&self) {
        *self.is_over.write().unwrap_or_else(PoisonError::into_inner) = true;
        self.held().remove();
    }

    /// From now on nothing of it is removed, so that the next window finds it: the user has not decided about the work.
    pub fn leave(&self) {
        self.is_left.store(true, Ordering::Relaxed);
    }

    /// Whether it is [left](Self::leave).
    pub(super) fn is_left(&self) -> bool {
        self.is_left.load(Ordering::Relaxed)
    }

    /// A place for the render of `about`, which has nothing yet.
    #[must_use]
    pub fn place_render(self: &Arc<Self>, about: RenderAbout) -> KeptRender {
        let number = self.renders.fetch_add(1, Ordering::Relaxed);
        KeptRender::new(Arc::clone(self), &self.folder, number, about)
    }

    /// Does `write`, which writes a render, unless the session is over. Meanwhile it does not end.
    pub(super) fn write_render(
        &self,
        write: impl FnOnce() -> Result<(), String>,
    ) -> Result<(), String> {
        let is_over = self.is_over.read().unwrap_or_else(PoisonError::into_inner);
        if *is_over { Ok(()) } else { write() }
    }

    /// [`Self::write_render`] while nobody else writes one.
    pub(super) fn move_render(
        &self,
        write: impl FnOnce() -> Result<(), String>,
    ) -> Result<(), String> {
        let is_over = self.is_over.write().unwrap_or_else(PoisonError::into_inner);
        if *is_over { Ok(()) } else { write() }
    }

    /// Takes note of a thread that writes a render, until what is returned is dropped.
    pub(super) fn begin_writing(self: &Arc<Self>) -> Writing {
        self.writers.fetch_add(1, Ordering::Relaxed);
        Writing(Arc::clone(self))
    }

    /// Whether threads write renders, and may have files open.
    #[must_use]
    pub fn has_writers(&self) -> bool {
        self.writers.load(Ordering::Relaxed) > 0
    }

    /// Moves the render in `folder` to where the next window finds it.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn leave_render(&self, folder: &Path) -> io::Result<()> {
        let missing = || io::Error::from(io::ErrorKind::NotFound);
        let sessions = self.folder.parent().ok_or_else(missing)?;
        // Filled here and moved as a whole: who begins meanwhile removes folders with nothing in them.
        let left = tempfile::Builder::new()
            .prefix("left-")
            .tempdir_in(&self.folder)?
            .keep();
        fs::rename(folder, left.join(folder.file_name().ok_or_else(missing)?))?;
        fs::rename(&left, sessions.join(left.file_name().ok_or_else(missing)?))
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A thread that writes a render.
#[derive(Debug)]
pub(super) struct Writing(Arc<Session>);

impl Drop for Writing {
    fn drop(&mut self) {
        self.0.writers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Work that a window left behind that did not end as windows do. Nobody else is offered it as long as this value lives.
#[derive(Clone, Debug)]
pub struct Lost {
    /// What it belongs to.
    pub about: About,
    /// When it was last edited, or the render kept.
    pub edited: SystemTime,
    folder: PathBuf,
    held: Arc<Mutex<Held>>,
    /// The folder of a window that went on with it, where that left its render.
    held_beside: Option<Arc<Mutex<Held>>>,
    /// `None` where nothing was unsaved.
    scene: Option<PathBuf>,
    render: Option<PathBuf>,
}

impl Lost {
    /// What is left in the folder of `held`; gives that back where nothing is.
    fn of(held: Held) -> Result<Self, Held> {
        // Nobody writes here any more.
        for folder in renders_in(&held.folder).chain([held.folder.clone()]) {
            remove_unfinished(&folder);
        }
        let scene = Some(held.folder.join(SCENE)).filter(|scene| scene.is_file());
        let render = newest_render(&held.folder);
        let about = scene
            .as_ref()
            .map_or(render.as_ref(), |_| Some(&held.folder));
        let Some(folder) = about else {
            return Err(held);
        };
        let about = fs::read_to_string(folder.join(ABOUT)).unwrap_or_default();
        let about = serde_json::from_str(&about).unwrap_or_else(|_| About {
            name: "untitled".to_owned(),
            path: None,
        });
        let newest = scene.as_ref().unwrap_or(folder);
        let edited = fs::metadata(newest).and_then(|m| m.modified());
        Ok(Self {
            about,
            edited: edited.unwrap_or(SystemTime::UNIX_EPOCH),
            folder: held.folder.clone(),
            held: Arc::new(Mutex::new(held)),
            held_beside: None,
            scene,
            render,
        })
    }

    /// Takes in `other`, where that is only a render, of this work that lacks one; gives it back where not.
    fn join(&mut self, other: Self) -> Option<Self> {
        let is_its_render = self.scene.is_some()
            && self.render.is_none()
            && other.scene.is_none()
            && self.about == other.about;
        if !is_its_render {
            return Some(other);
        }
        self.render = other.render;
        self.held_beside = Some(other.held);
        None
    }

    /// The scene file; `None` where all was saved, and only a render was lost.
    #[must_use]
    pub fn scene_file(&self) -> Option<&Path> {
        self.scene.as_deref()
    }

    /// Where it is, but for a render that another window left.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The folder of the render that was interrupted.
    #[must_use]
    pub fn render(&self) -> Option<&Path> {
        self.render.as_deref()
    }

    /// Moves the render that was interrupted into `session`.
    ///
    /// # Errors
    /// In words.
    pub fn move_render(
        &self,
        session: &Arc<Session>,
        about: RenderAbout,
    ) -> Result<Option<KeptRender>, String> {
        let moved = self.render.as_ref().map(|folder| {
            let kept = session.place_render(about);
            let moved = kept.take(folder);
            moved.map(|()| kept)
        });
        moved.transpose()
    }

    /// Takes note that its render is of no use to anybody.
    pub fn give_up_render(&mut self) {
        self.render = None;
    }

    /// Removes what was edited: it is saved, or was given up. A render that is still here stays, for the next window to find.
    pub fn clear(self) {
        let render = self.render.as_ref();
        let render = render.filter(|render| scene_of_render(render).is_file());
        for mut held in self.all_held() {
            if render.is_some_and(|render| render.starts_with(&held.folder)) {
                held.clear();
            } else {
                held.remove();
            }
        }
    }

    /// Removes it for good, with its render.
    pub fn discard(self) {
        self.all_held().for_each(|mut held| held.remove());
    }

    fn all_held(&self) -> impl Iterator<Item = MutexGuard<'_, Held>> {
        let all = self.held_beside.iter().chain([&self.held]);
        all.map(|held| held.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Where unsaved work is kept.
#[derive(Clone, Debug)]
pub enum Place {
    /// With all else of the window.
    Session(Arc<Session>),
    /// Of restored work: where it was found.
    Found(Lost),
}

impl Place {
    /// Writes unsaved work there, whole or not at all.
    ///
    /// # Errors
    /// In words.
    pub fn keep(&self, scene: &Scene, about: &About) -> Result<(), String> {
        let held = match self {
            Self::Session(session) => session.held(),
            Self::Found(lost) => lost.held(),
        };
        held.keep(scene, about)
    }

    /// Removes what was kept there: it is saved, or was given up.
    pub fn clear(self) {
        match self {
            Self::Session(session) => session.clear(),
            Self::Found(lost) => lost.clear(),
        }
    }
}

/// What a window starts with.
#[derive(Debug)]
pub struct Begun {
    /// Where its unsaved work goes.
    pub session: Session,
    /// What others left behind, last edited first.
    pub lost: Vec<Lost>,
}

/// Begins a session in the folder `data`, and looks for lost work there. Remains without work in them are removed.
///
/// # Errors
/// What the system says.
pub fn begin(data: &Path) -> io::Result<Begun> {
    // Between a folder and its lock nobody looks.
    let shared = lock_shared(data)?;
    let sessions = data.join("sessions");
    fs::create_dir_all(&sessions)?;
    let mut lost = Vec::new();
    for entry in fs::read_dir(&sessions)?.flatten() {
        let Some(held) = Held::of(entry.path()) else {
            continue;
        };
        match Lost::of(held) {
            Ok(found) => lost.push(found),
            Err(mut held) => held.remove(),
        }
    }
    lost.sort_by_key(|lost| std::cmp::Reverse(lost.edited));
    let lost = with_their_renders(lost);
    let folder = tempfile::Builder::new()
        .prefix(&format!("{}-", std::process::id()))
        .tempdir_in(&sessions)?
        .keep();
    let held = Held::of(folder).ok_or_else(|| {
        let text = "the folder for unsaved work cannot be locked";
        io::Error::new(io::ErrorKind::Unsupported, text)
    })?;
    drop(shared);
    Ok(Begun {
        session: Session {
            folder: held.folder.clone(),
            held: Mutex::new(held),
            renders: AtomicUsize::new(0),
            writers: AtomicUsize::new(0),
            is_over: RwLock::new(false),
            is_left: AtomicBool::new(false),
        },
        lost,
    })
}

/// The lost work, newest first, each with its render. A window that restores work goes on with its render in a folder of its own, while the work
/// stays where it was found: killed, it leaves them apart, and asked about one without the other, nobody would know that both are there.
fn with_their_renders(lost: Vec<Lost>) -> Vec<Lost> {
    let (renders, mut works): (Vec<_>, Vec<_>) =
        lost.into_iter().partition(|lost| lost.scene.is_none());
    for render in renders {
        let apart = works
            .iter_mut()
            .try_fold(render, |render, work| work.join(render).ok_or(()));
        works.extend(apart);
    }
    works.sort_by_key(|lost| std::cmp::Reverse(lost.edited));
    works
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{CancelToken, Progress};
    use crate::io::{demo_scene, load_scene};

    #[test]
    fn work_of_a_killed_window_is_found_until_it_is_discarded() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("data");
        let Begun { session, lost } = begin(&data).unwrap();
        assert!(lost.is_empty());
        let mut scene = demo_scene();
        scene.camera.eye.x += 1.0;
        let path = Some(PathBuf::from("/scenes/room.toml"));
        let about = About {
            name: "room".to_owned(),
            path: path.clone(),
        };
        session.held().keep(&scene, &about).unwrap();

        // A window beside it leaves it alone, and a closed one leaves nothing.
        let beside = begin(&data).unwrap();
        assert!(beside.lost.is_empty());
        beside.session.end();
        // A process that ends gives back its locks.
        let unfinished = session.folder.join(".raymini-abc123.part");
        fs::write(&unfinished, "half of it").unwrap();
        drop(session);

        let Begun { session, mut lost } = begin(&data).unwrap();
        assert!(!unfinished.exists(), "it is of no use to anybody");
        assert_eq!(lost.len(), 1);
        let work = lost.pop().unwrap();
        assert_eq!(work.about.name, "room");
        assert_eq!(work.about.path, path);
        let loaded = load_scene(
            work.scene_file().unwrap(),
            &CancelToken::new(),
            &Progress::new(),
        );
        assert_eq!(loaded.unwrap().unwrap().scene.camera, scene.camera);
        // Nobody else is offered it meanwhile; who puts it off is asked again.
        let others = || {
            let Begun { session, lost } = begin(&data).unwrap();
            session.end();
            lost
        };
        assert!(others().is_empty());
        drop(work);
        let work = others().pop().unwrap();
        work.discard();
        assert!(others().is_empty());
        session.end();
        let left = fs::read_dir(data.join("sessions")).unwrap().count();
        assert_eq!(left, 0);
    }

    /// Work that was restored stays where it was found, and its render goes on elsewhere: killed again, they are one thing to restore.
    #[test]
    fn work_is_found_with_its_render_that_another_window_left() {
        let data = tempfile::tempdir().unwrap();
        let about = |name: &str| About {
            name: name.to_owned(),
            path: Some(PathBuf::from(format!("/scenes/{name}.toml"))),
        };
        let scene = demo_scene();
        let leave_render = |name: &str| {
            let session = Arc::new(begin(data.path()).unwrap().session);
            let About { name, path } = about(name);
            let region = crate::render::Region::full(4, 3);
            let kept = session.place_render(RenderAbout { name, path, region });
            kept.begin_log(&scene, "render").unwrap();
            session.leave();
        };
        let Begun { session, .. } = begin(data.path()).unwrap();
        session.held().keep(&scene, &about("room")).unwrap();
        drop(session);
        leave_render("room");
        leave_render("hall");

        let Begun { session, lost } = begin(data.path()).unwrap();
        let found = |lost: &Lost| (lost.scene_file().is_some(), lost.render().is_some());
        let mut all: Vec<_> = lost
            .iter()
            .map(|it| (&it.about.name[..], found(it)))
            .collect();
        all.sort_unstable();
        assert_eq!(all, [("hall", (false, true)), ("room", (true, true))]);
        // The work is saved, and its render waits; of the other render nobody has use.
        for mut lost in lost {
            if lost.about.name == "hall" {
                lost.give_up_render();
            }
            lost.clear();
        }
        session.end();
        let Begun { session, lost } = begin(data.path()).unwrap();
        let all: Vec<_> = lost
            .iter()
            .map(|it| (&it.about.name[..], found(it)))
            .collect();
        assert_eq!(all, [("room", (false, true))]);
        lost.into_iter().for_each(Lost::discard);
        session.end();
        let left = fs::read_dir(data.path().join("sessions")).unwrap().count();
        assert_eq!(left, 0);
    }

    #[test]
    fn saved_work_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let Begun { session, .. } = begin(folder.path()).unwrap();
        let about = About {
            name: "demo".to_owned(),
            path: None,
        };
        session.held().keep(&demo_scene(), &about).unwrap();
        session.clear();
        drop(session);
        assert!(begin(folder.path()).unwrap().lost.is_empty());
    }
}
