//! How long a render takes: since it was asked for, and until its end.

use std::time::{Duration, Instant};

use super::Picture;

/// From this part of a render on, the time it takes is told by its own pace rather than by what was expected of it.
const KNOWN_SHARE: f64 = 0.1;

impl Picture {
    /// When the render was asked for.
    #[must_use]
    pub fn started(&self) -> Instant {
        self.started
    }

    /// Takes note that it goes on with a render that was interrupted when `share_done` of it, `0..=1`, was done, after `time`.
    pub fn go_on_after(&mut self, time: Duration, share_done: f64) {
        self.before = Some((time, share_done));
        if let Some(kept) = &self.kept {
            kept.accept();
        }
    }

    /// Takes note that it is expected to take so many `seconds`, where that is known.
    pub fn expect_time(&mut self, seconds: Option<f64>) {
        let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        self.expected_time = time.filter(|time| !time.is_zero());
    }

    /// How far what is there of it on disk is read, `0..=1`, while it is.
    #[must_use]
    pub fn reading(&self) -> Option<f64> {
        let is_read = self.is_running() && self.before.is_none() && self.reading.total() > 0;
        is_read.then(|| self.reading.fraction())
    }

    /// Which part was done when it was interrupted, where it was, `0..=1`.
    #[must_use]
    pub fn goes_on_from(&self) -> Option<f64> {
        self.before.map(|(_, share_done)| share_done)
    }

    /// Time since the render was asked for, up to its end, without pauses; with that before it was interrupted.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        let before = self.before.map_or(Duration::ZERO, |(time, _)| time);
        before + self.elapsed_here()
    }

    /// [`Self::elapsed`], in this session.
    pub(super) fn elapsed_here(&self) -> Duration {
        self.elapsed
            .unwrap_or_else(|| self.throttle().time_since(self.started))
    }

    /// Time the rest takes: until the noise is low enough where that is foreseen, else at the pace so far; `None` while that is
    /// a guess.
    #[must_use]
    pub fn remaining(&self) -> Option<Duration> {
        self.remaining_after(self.elapsed())
    }

    /// [`Self::remaining`], where [`Self::elapsed`] is `elapsed`.
    pub(super) fn remaining_after(&self, elapsed: Duration) -> Option<Duration> {
        let until = self.progress.seconds_until_time_is_up();
        let until = until.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let by_samples = self.remaining_by_samples(elapsed);
        until.into_iter().chain(by_samples).min()
    }

    fn remaining_by_samples(&self, elapsed: Duration) -> Option<Duration> {
        let known = self
            .errors
            .get(self.before_rules.errors..)
            .unwrap_or_default();
        if let Some((point, stop)) = known.last().and_then(|p| Some((p, p.time_to_stop?))) {
            let end = stop
                .value
                .min(self.scene.render.stop.seconds.unwrap_or(f64::INFINITY));
            let since = elapsed.saturating_sub(self.newest_error);
            let since = since.as_secs_f64();
            return Duration::try_from_secs_f64((end - point.seconds - since).max(0.0)).ok();
        }
        let [done, left] = self.progress.samples_done_and_left();
        let done = done / (done + left).max(1.0);
        let Some(expected) = self.expected_time else {
            return time_left(done, elapsed);
        };
        // The first samples may take longer than others do, or less.
        let (expected, elapsed) = (expected.as_secs_f64(), elapsed.as_secs_f64());
        let trust = (done / KNOWN_SHARE).max(elapsed / expected).min(1.0);
        let by_pace = if done > 0.0 { elapsed / done } else { expected };
        let whole = expected + trust * (by_pace - expected);
        Duration::try_from_secs_f64((whole - elapsed).max(0.0)).ok()
    }

    /// Million rays per second so far; `None` before there are any to speak of.
    #[must_use]
    pub fn mrays_per_second(&self) -> Option<f64> {
        let seconds = self.elapsed_here().as_secs_f64();
        let rate = self.progress.rays() as f64 / seconds.max(1e-9) / 1e6;
        (seconds > 0.2 && rate >= 0.005).then_some(rate)
    }
}

/// Time that the rest of some work takes at the pace so far; `None` while that is a guess. `done`: the done part, `0..=1`.
#[must_use]
pub fn time_left(done: f64, elapsed: Duration) -> Option<Duration> {
    let elapsed = elapsed.as_secs_f64();
    // Long renders tell it after a second, of which a first part of a hundredth takes minutes.
    let known = done > 0.01 && elapsed > 0.2 || done > 0.001 && elapsed > 1.0;
    known
        .then(|| Duration::try_from_secs_f64(elapsed * (1.0 - done) / done).ok())
        .flatten()
}
