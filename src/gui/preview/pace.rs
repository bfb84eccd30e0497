//! How many triangles a device draws in the time that a frame may take.
//!
//! The speed is a guess by the kind of device at first. It is measured whenever the preview comes to rest, by drawing the same again with few
//! pixels: what pixels take does not depend on how many triangles there are.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use eframe::wgpu;

/// How long drawing triangles may take while what is seen changes, in seconds.
const MOVING: f64 = 0.05;
/// The same once it rests.
const RESTING: f64 = 0.25;
/// How long what is drawn must be the same to be at rest.
pub(super) const REST: Duration = Duration::from_millis(250);
/// The share of a new measurement in what is known.
const WEIGHT: f64 = 0.5;
/// What takes less than this is not told apart from nothing.
const RESOLUTION: Duration = Duration::from_millis(2);
/// A driver that takes longer than this has other troubles.
const PATIENCE: Duration = Duration::from_secs(20);

/// How quick a device is.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// Drawn whatever it takes.
    least: u64,
    /// In triangles per second.
    speed: Arc<Mutex<f64>>,
    is_measuring: Arc<AtomicBool>,
}

/// As many triangles as any device draws within a frame. `software`: whether the processor plays the GPU.
#[must_use]
pub fn least_triangles(software: bool) -> u64 {
    if software { 300_000 } else { 3_000_000 }
}

impl Pace {
    /// `software`: whether the processor plays the GPU.
    pub(super) fn new(software: bool) -> Self {
        let guess = if software { 6e6 } else { 4e8 };
        Self {
            least: least_triangles(software),
            speed: Arc::new(Mutex::new(guess)),
            is_measuring: Arc::default(),
        }
    }

    /// How many triangles a frame may have, while what is seen changes or once it rests.
    pub(super) fn triangles(&self, is_moving: bool) -> u64 {
        let seconds = if is_moving { MOVING } else { RESTING };
        let speed = *self.speed.lock().unwrap_or_else(PoisonError::into_inner);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number of triangles"
        )]
        let triangles = (speed * seconds) as u64;
        triangles.max(self.least)
    }

    /// Takes note of how long `commands` take, which draw `triangles`, once what was handed to `queue` before is done. Never waits.
    pub(super) fn measure(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        triangles: u64,
        commands: wgpu::CommandBuffer,
    ) {
        // What few take is no measure of many.
        if triangles < self.least / 2 || self.is_measuring.swap(true, Ordering::Relaxed) {
            return;
        }
        let (pace, device, queue) = (self.clone(), device.clone(), queue.clone());
        thread::spawn(move || {
            if wait_for(&device, &queue).is_some() {
                queue.submit([commands]);
                if let Some(took) = wait_for(&device, &queue) {
                    let measured = triangles as f64 / took.max(RESOLUTION).as_secs_f64();
                    let mut speed = pace.speed.lock().unwrap_or_else(PoisonError::into_inner);
                    *speed += (measured - *speed) * WEIGHT;
                }
            }
            pace.is_measuring.store(false, Ordering::Relaxed);
        });
    }
}

/// Waits until all that was handed to `queue` is done, and says how long that took. `None` where the device is lost or takes too long.
fn wait_for(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Duration> {
    let started = Instant::now();
    let is_done = Arc::new(AtomicBool::new(false));
    let done = Arc::clone(&is_done);
    queue.on_submitted_work_done(move || done.store(true, Ordering::Relaxed));
    // The driver tells only when it is asked. Waiting within it would hold up the window.
    while !is_done.load(Ordering::Relaxed) {
        if device.poll(wgpu::PollType::Poll).is_err() || started.elapsed() > PATIENCE {
            return None;
        }
        thread::sleep(Duration::from_millis(1));
    }
    Some(started.elapsed())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_device_draws_something_and_more_at_rest() {
        for software in [true, false] {
            let pace = Pace::new(software);
            assert!(pace.triangles(true) >= least_triangles(software));
            assert!(pace.triangles(false) > pace.triangles(true));
            *pace.speed.lock().unwrap() = 0.0;
            assert_eq!(pace.triangles(false), least_triangles(software));
        }
    }
}
