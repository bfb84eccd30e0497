//! Whether the desktop showed a file dialog at all.
//!
//! `rfd` answers in the same way when the user cancels and when there is no dialog to show, as where no portal answers and there is no
//! zenity either: with no path. Which of them it was it only logs, on the thread that asks, so that is listened to. How long the answer
//! took says nothing: on a busy machine a failure takes longer than a user.

use std::cell::Cell;
use std::sync::Once;

use log::{Level, LevelFilter, Log, Metadata, Record};

/// Where `rfd` logs that its last resort, zenity, could not be started. What failed before that it logs from modules below.
const LAST_RESORT: &str = "rfd::backend::xdg_desktop_portal";

thread_local! {
    /// Whether this thread has asked in vain.
    static IN_VAIN: Cell<bool> = const { Cell::new(false) };
}

/// Hears what `rfd` logs.
struct Listener;

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() == Level::Error && metadata.target() == LAST_RESORT
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            IN_VAIN.set(true);
        }
    }

    fn flush(&self) {}
}

/// What `ask` returns, which shows a dialog of `rfd`, and whether the desktop had one to show.
pub fn was_shown<R>(ask: impl FnOnce() -> R) -> (R, bool) {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        // The program has no other logger.
        if log::set_logger(&Listener).is_ok() {
            log::set_max_level(LevelFilter::Error);
        }
    });
    IN_VAIN.set(false);
    let answer = ask();
    (answer, !IN_VAIN.get())
}
