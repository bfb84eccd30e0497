//! Progress on a terminal.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::control::CancelToken;

/// Runs `work` with its progress shown on a terminal, and nothing shown where there is none. `how_far` tells the done part of
/// the whole, and what to say about it.
pub(super) fn show<T>(how_far: impl Fn() -> (f64, String) + Sync, work: impl FnOnce() -> T) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(
        "{percent:>3} % {wide_bar} {elapsed_precise} left {eta} {msg}",
    );
    bar.set_style(style.expect("the template is right"));
    let finished = CancelToken::new();
    std::thread::scope(|scope| {
        // Also where the work panics: the scope waits for its thread.
        let ending = CancelWhenDropped(&finished);
        scope.spawn(|| {
            while !finished.is_cancelled() {
                let (fraction, message) = how_far();
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of 1000"
                )]
                bar.set_position((fraction * 1000.0) as u64);
                bar.set_message(message);
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        let result = work();
        drop(ending);
        bar.finish_and_clear();
        result
    })
}

/// Cancels a token when it goes.
struct CancelWhenDropped<'a>(&'a CancelToken);

impl Drop for CancelWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.cancel();
    }
}
