//! Signals that ask the program to end: SIGINT (Ctrl+C) and SIGTERM.
//!
//! The first one ends the program at once, unless a command has asked for [`Signals::cancel_instead`]; the second always does.
//! Either way no temporary file stays behind.

use std::io;
use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::control::CancelToken;
use crate::io::exit_process;

/// How long a signal may wait for its answer. What a handler itself may do is next to nothing, so it leaves a note that is looked
/// at so often.
const PERIOD: Duration = Duration::from_millis(20);

/// What is known about signals; clones see the same.
#[derive(Clone, Debug, Default)]
pub struct Signals(Arc<Known>);

#[derive(Debug, Default)]
struct Known {
    /// What the first signal cancels, where it does not end the program.
    cancels: OnceLock<CancelToken>,
    /// 0 before the first signal.
    exit_code: AtomicU8,
}

impl Signals {
    /// Watches from now on, until the program ends.
    ///
    /// # Errors
    /// When the system does not let signals be watched.
    pub fn watch() -> io::Result<Self> {
        let signals = Self::default();
        let received = Arc::new(AtomicUsize::new(0));
        for (signal, exit_code) in [(SIGINT, 130), (SIGTERM, 143)] {
            flag::register_usize(signal, Arc::clone(&received), exit_code)?;
        }
        let watching = signals.clone();
        let watch = move || {
            loop {
                std::thread::sleep(PERIOD);
                if let Ok(code @ 1..) = u8::try_from(received.swap(0, Ordering::Relaxed)) {
                    watching.answer(code);
                }
            }
        };
        std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(watch)?;
        Ok(signals)
    }

    /// A token that from now on the first signal cancels, in place of ending the program.
    #[must_use]
    pub fn cancel_instead(&self) -> CancelToken {
        self.0.cancels.get_or_init(CancelToken::new).clone()
    }

    /// The exit code that the first signal asks for, 128 and its number as shells count; `None` before it.
    #[must_use]
    pub fn exit_code(&self) -> Option<u8> {
        Some(self.0.exit_code.load(Ordering::Relaxed)).filter(|&code| code > 0)
    }

    fn answer(&self, code: u8) {
        let is_first = self.0.exit_code.swap(code, Ordering::Relaxed) == 0;
        match self.0.cancels.get() {
            Some(token) if is_first => token.cancel(),
            _ => exit_process(code),
        }
    }
}
