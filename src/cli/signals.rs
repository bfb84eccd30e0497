//! Signals that ask the program to end: SIGINT (Ctrl+C) and SIGTERM; on Windows, which knows no SIGTERM from outside, Ctrl+Break.
//!
//! The first one ends the program at once, unless a command has asked for [`Signals::cancel_instead`]; the second always does.
//! Either way no temporary file stays behind.

use std::ffi::c_int;
use std::io;
use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::control::CancelToken;
use crate::io::exit_process;

/// The signals and the exit codes that they ask for.
#[cfg(not(windows))]
const SIGNALS: [(c_int, usize); 2] = [(SIGINT, 130), (SIGTERM, 143)];

/// The third is what the C runtime of Windows calls SIGBREAK.
#[cfg(windows)]
const SIGNALS: [(c_int, usize); 3] = [(SIGINT, 130), (SIGTERM, 143), (21, 143)];

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
        for (signal, exit_code) in SIGNALS {
            flag::register_usize(signal, Arc::clone(&received), exit_code)?;
        }
        let mut wait = waiting()?;
        let watching = signals.clone();
        let watch = move || {
            loop {
                // First, as one may have come before anything waited.
                if let Ok(code @ 1..) = u8::try_from(received.swap(0, Ordering::Relaxed)) {
                    watching.answer(code);
                }
                wait();
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

/// Waits until there may have been a signal since the last time: what a handler itself may do is next to nothing. To be asked for
/// after what is to be looked at is registered.
#[cfg(unix)]
fn waiting() -> io::Result<impl FnMut() + Send> {
    use signal_hook::low_level::pipe;
    use std::io::Read;
    use std::os::unix::net::UnixStream;

    let (mut receiver, sender) = UnixStream::pair()?;
    for (signal, _) in SIGNALS {
        pipe::register(signal, sender.try_clone()?)?;
    }
    // The handlers keep the sender open, so reading fails only where it is interrupted.
    Ok(move || while receiver.read(&mut [0; 1]).is_err() {})
}

#[cfg(not(unix))]
#[expect(
    clippy::unnecessary_wraps,
    reason = "elsewhere the system may not allow it"
)]
fn waiting() -> io::Result<impl FnMut() + Send> {
    const PERIOD: std::time::Duration = std::time::Duration::from_millis(20);
    Ok(|| std::thread::sleep(PERIOD))
}
