//! Progress on a terminal.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::time_left;
use crate::control::CancelToken;

/// What a bar shows.
pub(super) struct HowFar {
    /// The done part of the whole, `0..=1`.
    pub fraction: f64,
    /// The time left in words; `None`: at the pace so far.
    pub left: Option<String>,
    /// What else is said.
    pub message: String,
}

impl From<(f64, String)> for HowFar {
    fn from((fraction, message): (f64, String)) -> Self {
        Self {
            fraction,
            left: None,
            message,
        }
    }
}

/// Runs `work` with its progress shown on a terminal, and nothing shown where there is none. `how_far` tells the done part of
/// the whole, and what to say about it.
pub(super) fn show<T, H: Into<HowFar>>(
    how_far: impl Fn() -> H + Sync,
    work: impl FnOnce() -> T,
) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(
        "{percent:>3} % {wide_bar} {elapsed_precise} left {prefix} {msg}",
    );
    bar.set_style(style.expect("the template is right"));
    let finished = CancelToken::new();
    std::thread::scope(|scope| {
        // Also where the work panics: the scope waits for its thread.
        let ending = CancelWhenDropped(&finished);
        scope.spawn(|| {
            while !finished.is_cancelled() {
                let HowFar {
                    fraction,
                    left,
                    message,
                } = how_far().into();
                let elapsed = bar.elapsed().as_secs_f64();
                let left = left.unwrap_or_else(|| time_left::at_this_pace(fraction, elapsed));
                bar.set_position(thousandths(fraction));
                bar.set_prefix(left);
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

/// The done part in thousandths, of which as many whole per cent are shown: 100 when all is done, and not before.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of 1000"
)]
fn thousandths(fraction: f64) -> u64 {
    let rounded_below = 994;
    let thousandths = (fraction * 1000.0) as u64;
    if fraction < 1.0 {
        thousandths.min(rounded_below)
    } else {
        thousandths
    }
}

/// Cancels a token when it goes.
struct CancelWhenDropped<'a>(&'a CancelToken);

impl Drop for CancelWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.cancel();
    }
}
