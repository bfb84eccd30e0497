//! A thousand renders that are started and cancelled in a row leave no thread and no byte behind.
//!
//! This file is a program of its own, as it counts what the whole program holds.

mod common;

use std::time::{Duration, Instant};

use common::{diffuse, looking_at_floor};
use peak_alloc::PeakAlloc;
use raymini::control::CancelToken;
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{Background, Mode, Rgb};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const RENDERS: u32 = 1000;

/// Threads of this program; `None` where the system does not tell.
fn threads() -> Option<usize> {
    Some(std::fs::read_dir("/proc/self/task").ok()?.count())
}

/// Starts a render that would take hours and cancels it when it has traced `rays` rays, or before it has begun.
fn cancel_after(scene: &PreparedScene, rays: u64) {
    let run = RunConfig {
        threads: 2,
        ..RunConfig::default()
    };
    let progress = RenderProgress::default();
    let outcome = std::thread::scope(|scope| {
        let worker = scope.spawn(|| render(scene, None, &run, &progress, None));
        while progress.rays() < rays {
            std::thread::yield_now();
        }
        run.cancel.cancel();
        worker.join().expect("does not panic")
    });
    assert!(outcome.is_none());
}

/// Waits until there are at most `bound` threads: those of a render that has ended take a moment to go.
fn threads_fall_to(bound: Option<usize>) -> Result<(), usize> {
    let Some(bound) = bound else { return Ok(()) };
    let started = Instant::now();
    let found = || threads().expect("was told before");
    while found() > bound {
        if started.elapsed() > Duration::from_mins(1) {
            return Err(found());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

#[test]
fn a_thousand_cancelled_renders_leave_nothing_behind() {
    let mut scene = looking_at_floor(0.1, diffuse(0.5));
    scene.background = Background::Constant {
        radiance: Rgb::splat(1.0),
    };
    scene.render.mode = Mode::Path;
    scene.render.width = 200;
    scene.render.height = 150;
    scene.render.samples_per_pixel = 1 << 20;
    let scene = PreparedScene::prepare(&scene, None, &CancelToken::new());
    let scene = scene.expect("can be rendered").expect("nobody cancels");
    // What is made once stays.
    let alone = threads();
    for turn in 0..20 {
        cancel_after(&scene, turn);
    }
    // The queues of the thread pools free what they drop in their own time, and only while they are used: the least that is held
    // after some renders has little of that.
    let least_held = || {
        let held = (0..20).map(|turn| {
            cancel_after(&scene, turn);
            assert_eq!(threads_fall_to(alone), Ok(()));
            MEMORY.current_usage()
        });
        held.min().expect("there are some")
    };
    let before = least_held();
    for turn in 0..RENDERS {
        cancel_after(&scene, u64::from(turn * turn % 5000));
    }
    // What a render left would be a pointer or more.
    let less_than_a_pointer_each = before + (RENDERS as usize - 1) * size_of::<usize>();
    let after = least_held();
    assert!(
        after <= less_than_a_pointer_each,
        "{before} to {after} bytes"
    );
}
