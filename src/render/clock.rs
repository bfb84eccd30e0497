//! The time a render takes, wall and processor time in seconds, without pauses and without the work of those who watch.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use crate::control::Throttle;

/// Measures a render in wall time and in processor time of the threads that render, and can be stopped for what is not rendering. It
/// stands still while the render is paused. What else the process does, such as drawing a window, does not count.
#[derive(Debug)]
pub struct Clock {
    /// When it was started, earlier by the time that had been paused until then.
    started: Instant,
    /// Tells of pauses.
    throttle: Throttle,
    /// Wall time that does not count.
    uncounted: Duration,
    /// Wall time and processor time before it was started.
    seconds_before: f64,
    cpu_seconds_before: f64,
    /// Nanoseconds of wall time and processor time of work that was not done again.
    ahead: Arc<AtomicU64>,
    cpu_ahead: AtomicU64,
    /// Processor time of the thread that leads, when the clock was started.
    lead_started: Duration,
    lead_paused: Duration,
    /// Nanoseconds of processor time: of the thread that leads, and of each other, as it [noted](Self::note) them last.
    lead: AtomicU64,
    others: Vec<AtomicU64>,
}

/// Processor time of this thread since it began.
fn thread_time() -> Duration {
    ThreadTime::now().as_duration()
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

fn seconds(nanoseconds: &AtomicU64) -> f64 {
    Duration::from_nanos(nanoseconds.load(Ordering::Relaxed)).as_secs_f64()
}

/// The wall time of a render for whoever watches it: that of its [`Clock`], but for what is left out there.
#[derive(Debug)]
pub struct Timer {
    /// When it was started, earlier by the time that had been paused until then.
    started: Instant,
    throttle: Throttle,
    seconds_before: f64,
    ahead: Arc<AtomicU64>,
}

impl Timer {
    /// Wall time since the start, in seconds.
    pub fn seconds(&self) -> f64 {
        let here = self.throttle.time_since(self.started).as_secs_f64();
        self.seconds_before + here + seconds(&self.ahead)
    }
}

impl Clock {
    /// A clock that goes on from `seconds` of wall time and `cpu_seconds` of processor time. The thread that calls leads; `others` more
    /// begin now. It stands still whenever `throttle` pauses them.
    pub fn start_at(seconds: f64, cpu_seconds: f64, others: usize, throttle: &Throttle) -> Self {
        let now = Instant::now();
        Self {
            started: now.checked_sub(throttle.paused_time()).unwrap_or(now),
            throttle: throttle.clone(),
            uncounted: Duration::ZERO,
            seconds_before: seconds,
            cpu_seconds_before: cpu_seconds,
            ahead: Arc::default(),
            cpu_ahead: AtomicU64::new(0),
            lead_started: thread_time(),
            lead_paused: Duration::ZERO,
            lead: AtomicU64::new(0),
            others: (0..others).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// Tells its time to others.
    pub fn timer(&self) -> Timer {
        Timer {
            started: self.started,
            throttle: self.throttle.clone(),
            seconds_before: self.seconds_before,
            ahead: Arc::clone(&self.ahead),
        }
    }

    /// Wall time since the start, in seconds.
    pub fn seconds(&self) -> f64 {
        self.seconds_here() + seconds(&self.ahead)
    }

    fn seconds_here(&self) -> f64 {
        let here = self
            .throttle
            .time_since(self.started)
            .saturating_sub(self.uncounted);
        self.seconds_before + here.as_secs_f64()
    }

    /// Goes on from `seconds` of wall time and `cpu_seconds` of processor time at least: what they were spent on is there without doing it
    /// again.
    pub fn bring_forward(&self, seconds: f64, cpu_seconds: f64) {
        let bring = |ahead: &AtomicU64, missing: f64| {
            let missing = Duration::try_from_secs_f64(missing).unwrap_or_default();
            ahead.fetch_max(nanoseconds(missing), Ordering::Relaxed);
        };
        bring(&self.ahead, seconds - self.seconds_here());
        bring(&self.cpu_ahead, cpu_seconds - self.cpu_seconds_here());
    }

    /// Takes note of the processor time of the thread that calls, which has this `number` among the others.
    pub fn note(&self, number: usize) {
        self.others[number].store(nanoseconds(thread_time()), Ordering::Relaxed);
    }

    /// The same for the thread that leads.
    pub fn note_lead(&self) {
        let here = thread_time().saturating_sub(self.lead_started + self.lead_paused);
        self.lead.store(nanoseconds(here), Ordering::Relaxed);
    }

    /// Processor time since the start as far as it was noted, in seconds.
    pub fn cpu_seconds(&self) -> f64 {
        self.cpu_seconds_here() + seconds(&self.cpu_ahead)
    }

    fn cpu_seconds_here(&self) -> f64 {
        let all = self.others.iter().chain([&self.lead]);
        let here: u64 = all.map(|time| time.load(Ordering::Relaxed)).sum();
        self.cpu_seconds_before + Duration::from_nanos(here).as_secs_f64()
    }

    /// Leaves this much wall time out of account.
    pub fn leave_out(&mut self, time: Duration) {
        self.uncounted += time;
    }

    /// Does `work`, whose time does not count, on the thread that leads.
    pub fn pause(&mut self, work: impl FnOnce()) {
        let (started, lead_started) = (self.throttle.time_since(self.started), thread_time());
        work();
        self.uncounted += self
            .throttle
            .time_since(self.started)
            .saturating_sub(started);
        self.lead_paused += thread_time().saturating_sub(lead_started);
    }
}
