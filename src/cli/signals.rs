//! Signals that ask the program to end: SIGINT (Ctrl+C), SIGTERM and, on Linux, SIGHUP of a terminal that is closed; on Windows, which
//! knows no SIGTERM from outside, Ctrl+Break.
//!
//! The first one ends the program at once, unless a command has asked for [`Signals::cancel_instead`]; the second always does, but for
//! SIGHUP, which the system and the shell send one after the other. Either way no temporary file stays behind.

use std::ffi::c_int;
use std::io;
use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::control::CancelToken;
use crate::io::exit_process;

/// The exit code of a program whose terminal is closed: 128 and the number of SIGHUP.
const HUNG_UP: u8 = 129;

/// The signals that are watched and the exit codes that they ask for.
#[cfg(unix)]
fn watched() -> Vec<(c_int, usize)> {
    let mut signals = vec![(SIGINT, 130), (SIGTERM, 143)];
    if !may_ignore_hang_up() {
        signals.push((signal_hook::consts::SIGHUP, usize::from(HUNG_UP)));
    }
    signals
}

/// Whether the program was started to outlive its terminal, as by `nohup`; also where the system does not tell.
#[cfg(unix)]
fn may_ignore_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // The lowest bit is that of signal 1, SIGHUP.
    ignored.is_none_or(|mask| mask & 1 == 1)
}

/// The third is what the C runtime of Windows calls SIGBREAK.
#[cfg(not(unix))]
fn watched() -> Vec<(c_int, usize)> {
    vec![(SIGINT, 130), (SIGTERM, 143), (21, 143)]
}

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
        let watched = watched();
        for &(signal, exit_code) in &watched {
            flag::register_usize(signal, Arc::clone(&received), exit_code)?;
        }
        let mut wait = waiting(&watched)?;
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
        let known = &self.0.exit_code;
        let first = known.compare_exchange(0, code, Ordering::Relaxed, Ordering::Relaxed);
        match self.0.cancels.get() {
            Some(token) if first.is_ok() => token.cancel(),
            Some(_) if code == HUNG_UP => {}
            _ => exit_process(code),
        }
    }
}

/// Waits until there may have been a signal since the last time: what a handler itself may do is next to nothing. To be asked for
/// after what is to be looked at is registered.
#[cfg(unix)]
fn waiting(watched: &[(c_int, usize)]) -> io::Result<impl FnMut() + Send + use<>> {
    use signal_hook::low_level::pipe;
    use std::io::Read;
    use std::os::unix::net::UnixStream;

    let (mut receiver, sender) = UnixStream::pair()?;
    for &(signal, _) in watched {
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
fn waiting(_watched: &[(c_int, usize)]) -> io::Result<impl FnMut() + Send + use<>> {
    const PERIOD: std::time::Duration = std::time::Duration::from_millis(20);
    Ok(|| std::thread::sleep(PERIOD))
}
