use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

/// Measures a render in wall time and in time of all processors of this process, and can be stopped for what is not rendering.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    cpu_started: ProcessTime,
    paused: Duration,
    cpu_paused: Duration,
}

impl Clock {
    pub fn start() -> Self {
        Self {
            started: Instant::now(),
            cpu_started: ProcessTime::now(),
            paused: Duration::ZERO,
            cpu_paused: Duration::ZERO,
        }
    }

    /// Wall time since the start, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.started.elapsed().saturating_sub(self.paused)).as_secs_f64()
    }

    /// Processor time since the start, in seconds.
    pub fn cpu_seconds(&self) -> f64 {
        (self.cpu_started.elapsed().saturating_sub(self.cpu_paused)).as_secs_f64()
    }

    /// Does `work`, whose time does not count.
    pub fn pause(&mut self, work: impl FnOnce()) {
        let (started, cpu_started) = (Instant::now(), ProcessTime::now());
        work();
        self.paused += started.elapsed();
        self.cpu_paused += cpu_started.elapsed();
    }
}
