//! Progress on a terminal.

use std::io::IsTerminal;
use std::time::Duration;

use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::time_left;
use crate::control::CancelToken;

/// Letters that are kept for the bar: a shorter one shows nothing.
const LEAST_BAR: usize = 10;

/// What stands before the bar, and the spaces around it: `100 % ` and one more.
const AROUND_BAR: usize = 7;

/// A stage that takes less than this many seconds is not shown: it would flicker.
const SHORT_STAGE: f64 = 0.3;

/// What a bar shows.
pub(super) struct HowFar {
    /// The done part of the whole, `0..=1`.
    pub fraction: f64,
    /// The time left in words; `None`: at the pace so far.
    pub left: Option<String>,
    /// What else is said, the first thing first to be kept where the terminal is narrow.
    pub messages: Vec<String>,
}

impl From<(f64, String)> for HowFar {
    fn from((fraction, message): (f64, String)) -> Self {
        Self {
            fraction,
            left: None,
            messages: vec![message],
        }
    }
}

/// Runs `work` with its progress shown on a terminal, and nothing shown where there is none. `how_far` tells the done part of
/// the whole, and what to say about it.
pub(super) fn show<T, H: Into<HowFar>>(
    how_far: impl Fn() -> H + Sync,
    work: impl FnOnce() -> T,
) -> T {
    let style = "{percent:>3} % {wide_bar} {msg}";
    let draw = |bar: &ProgressBar| {
        let HowFar {
            fraction,
            left,
            messages,
        } = how_far().into();
        let elapsed = bar.elapsed().as_secs_f64();
        let left = left.unwrap_or_else(|| time_left::at_this_pace(fraction, elapsed));
        bar.set_position(thousandths(fraction));
        let room = width().saturating_sub(AROUND_BAR + LEAST_BAR);
        bar.set_message(fitted(room, elapsed, &left, &messages));
    };
    draw_while(style, draw, work)
}

/// Runs `work`, a stage before what has a bar: its name, the done part `0..=1` and the time it has taken are shown, and no bar, which would
/// begin again after it.
pub(super) fn show_stage<T>(
    name: &str,
    fraction: impl Fn() -> f64 + Sync,
    work: impl FnOnce() -> T,
) -> T {
    let draw = |bar: &ProgressBar| {
        let elapsed = bar.elapsed().as_secs_f64();
        if elapsed > SHORT_STAGE {
            let percent = thousandths(fraction()) / 10;
            let line = format!("{name}: {percent} %, {} elapsed", clock(elapsed));
            bar.set_message(line.chars().take(width()).collect::<String>());
        }
    };
    draw_while("{msg}", draw, work)
}

/// Letters in a line of the terminal, but the last, behind which some terminals begin another.
fn width() -> usize {
    usize::from(Term::stderr().size().1).saturating_sub(1)
}

/// Runs `work`, and `draw` again and again meanwhile, where there is a terminal.
fn draw_while<T>(style: &str, draw: impl Fn(&ProgressBar) + Sync, work: impl FnOnce() -> T) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(style);
    bar.set_style(style.expect("the template is right"));
    let finished = CancelToken::new();
    std::thread::scope(|scope| {
        // Also where the work panics: the scope waits for its thread.
        let ending = CancelWhenDropped(&finished);
        scope.spawn(|| {
            while !finished.is_cancelled() {
                draw(&bar);
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        let result = work();
        drop(ending);
        bar.finish_and_clear();
        result
    })
}

/// What is said beside the bar, in at most `room` letters as far as that is possible: of the messages the last goes first, then the range
/// of the time left, then the other messages, and at the end the time that has passed.
fn fitted(room: usize, elapsed: f64, left: &str, messages: &[String]) -> String {
    let times = |left: &str| format!("{} elapsed, {left} left", clock(elapsed));
    let short = left.split(" (").next().unwrap_or(left);
    let said: Vec<&str> = messages.iter().map(String::as_str).collect();
    let said: Vec<&str> = said.into_iter().filter(|text| !text.is_empty()).collect();
    let with = |left: &str, count: usize| {
        let times = std::iter::once(times(left));
        let all = times.chain(said[..count].iter().map(|&text| text.to_owned()));
        all.collect::<Vec<_>>().join(", ")
    };
    let fewer = said.len() - usize::from(said.len() > 1);
    let lines = [with(left, said.len()), with(left, fewer)];
    let shorter = (1..=said.len()).rev().map(|count| with(short, count));
    // A long name says something without its end too.
    let left_room = room.saturating_sub(times(short).chars().count() + 2);
    let cut = said.first().filter(|_| left_room >= LEAST_BAR).map(|text| {
        let begin: String = text.chars().take(left_room - 1).collect();
        format!("{}, {begin}…", times(short))
    });
    let lines = lines.into_iter().chain(shorter).chain(cut);
    let mut lines = lines.chain([times(short)]);
    lines
        .find(|line| line.chars().count() <= room)
        .unwrap_or_else(|| format!("{short} left"))
}

/// A time as a clock shows it, `00:01:05`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "whole seconds since the start"
)]
fn clock(seconds: f64) -> String {
    let seconds = seconds as u64;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    format!("{hours:02}:{minutes:02}:{:02}", seconds % 60)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// At 80 letters all but the forecast has room, at 60 the times alone; nothing is cut in the middle, and nothing needs a second line.
    #[test]
    fn a_narrow_terminal_leaves_out_the_forecast_first_and_then_the_rays() {
        let messages = ["noise 5.12 %", "12.3 Mrays/s", "noise of 3 % at 18 s"].map(str::to_owned);
        let line = |width: usize, left: &str| {
            let line = fitted(width - AROUND_BAR - LEAST_BAR, 65.4, left, &messages);
            assert!(
                line.chars().count() + AROUND_BAR + LEAST_BAR <= width,
                "{line}"
            );
            line
        };
        let all = "00:01:05 elapsed, 2.9 s left, noise 5.12 %, 12.3 Mrays/s, noise of 3 % at 18 s";
        assert_eq!(line(120, "2.9 s"), all);
        for (width, left, expected) in [
            (
                80,
                "2.9 s",
                "00:01:05 elapsed, 2.9 s left, noise 5.12 %, 12.3 Mrays/s",
            ),
            (
                80,
                "20 s (15 s to 90 s)",
                "00:01:05 elapsed, 20 s left, noise 5.12 %, 12.3 Mrays/s",
            ),
            (60, "2.9 s", "00:01:05 elapsed, 2.9 s left, noise 5.12 %"),
            (50, "2.9 s", "00:01:05 elapsed, 2.9 s left"),
            (40, "2.9 s", "2.9 s left"),
        ] {
            assert_eq!(line(width, left), expected);
        }
        let long = "render.light_sampling=bsdf, seed 1 of 5".to_owned();
        let cut = "00:01:05 elapsed, 2.9 s left, render.light_sampl…";
        assert_eq!(fitted(49, 65.4, "2.9 s", &[long]), cut);
        assert_eq!(
            fitted(40, 0.0, "?", &[String::new()]),
            "00:00:00 elapsed, ? left"
        );
    }
}
