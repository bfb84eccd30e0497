use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

/// Measures a render in wall time and in time of all processors of this process, and can be stopped for what is not rendering.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    cpu_started: ProcessTime,
    paused: Duration,
    cpu_paused: Duration,
    /// What had passed when it was started.
    seconds_before: f64,
    cpu_seconds_before: f64,
}

impl Clock {
    /// A clock that goes on from so many seconds of wall time and of all processors.
    pub fn start_at(seconds: f64, cpu_seconds: f64) -> Self {
        Self {
            started: Instant::now(),
            cpu_started: ProcessTime::now(),
            paused: Duration::ZERO,
            cpu_paused: Duration::ZERO,
            seconds_before: seconds,
            cpu_seconds_before: cpu_seconds,
        }
    }

    /// Wall time since the start, in seconds.
    pub fn seconds(&self) -> f64 {
        let here = self.started.elapsed().saturating_sub(self.paused);
        self.seconds_before + here.as_secs_f64()
    }

    /// Processor time since the start, in seconds.
    pub fn cpu_seconds(&self) -> f64 {
        let here = self.cpu_started.elapsed().saturating_sub(self.cpu_paused);
        self.cpu_seconds_before + here.as_secs_f64()
    }

    /// Does `work`, whose time does not count.
    pub fn pause(&mut self, work: impl FnOnce()) {
        let (started, cpu_started) = (Instant::now(), ProcessTime::now());
        work();
        self.paused += started.elapsed();
        self.cpu_paused += cpu_started.elapsed();
    }
}
