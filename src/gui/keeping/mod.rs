//! What outlives the window: unsaved work, in case the program ends before it is saved, the files opened last, and what the window looks like.
//!
//! Everything lies in one folder of the user's data. Each window has a session there, a folder of its own that it holds a lock on: the
//! system gives the lock back however the program ends, so a session that nobody holds and that has a scene in it is work that was lost. So
//! is a render that is kept there while it runs. A window that offers such work holds its lock meanwhile, so several windows never offer or
//! remove the same.

mod layout;
mod recent;
mod render;
mod session;
mod writer;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

pub use layout::{Fold, LEAST_WINDOW, Layout, Theme, load_layout, save_layout};
pub use recent::{MOST_RECENT, load_recent, save_recent};
pub use render::{KeptRender, RenderAbout, scene_of_render};
pub use session::{About, Begun, Lost, Place, Session, begin};
pub use writer::{MOST_WAITING_BYTES, RenderWriter, Subject};

/// The program's folder in the user's data; `None` where the system knows no home.
#[must_use]
pub fn data_folder() -> Option<PathBuf> {
    use etcetera::BaseStrategy;
    let strategy = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(strategy.data_dir().join("raymini"))
}

/// Makes `data` where it is not there, and waits until no other window changes what all share there.
fn lock_shared(data: &Path) -> io::Result<File> {
    std::fs::create_dir_all(data)?;
    let lock = open_lock(&data.join("lock"))?;
    lock.lock()?;
    Ok(lock)
}

/// Opens a file that is there to be locked.
fn open_lock(path: &Path) -> io::Result<File> {
    File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(path)
}
