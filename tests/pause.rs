//! A render that is paused again and again.
//!
//! This file is a program of its own, as it measures what the whole program does while the render rests.

mod common;

use std::time::{Duration, Instant};

use common::{diffuse, looking_at_floor};
use cpu_time::ProcessTime;
use raymini::control::CancelToken;
use raymini::render::{PreparedScene, RenderOutcome, RenderProgress, RunConfig, render};
use raymini::scene::{Background, Mode, Rgb};

const THREADS: usize = 3;

fn start(scene: &PreparedScene, run: &RunConfig, progress: &RenderProgress) -> RenderOutcome {
    render(scene, None, run, progress, None).expect("nobody cancels")
}

/// Waits until `holds`.
fn until(what: &str, holds: impl Fn() -> bool) {
    let started = Instant::now();
    while !holds() {
        assert!(started.elapsed() < Duration::from_mins(1), "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_paused_render_rests_and_ends_with_the_bits_and_the_time_of_one_that_is_not() {
    let mut scene = looking_at_floor(0.1, diffuse(0.5));
    scene.background = Background::Constant {
        radiance: Rgb::splat(1.0),
    };
    scene.render.mode = Mode::Path;
    scene.render.width = 120;
    scene.render.height = 100;
    scene.render.samples_per_pixel = 256;
    let scene = PreparedScene::prepare(&scene, None, &CancelToken::new());
    let scene = scene.expect("can be rendered").expect("nobody cancels");
    let run = || RunConfig {
        threads: THREADS,
        ..RunConfig::default()
    };
    let plain = start(&scene, &run(), &RenderProgress::default());

    let (paused, progress) = (run(), RenderProgress::default());
    let started = Instant::now();
    let mut rested = Duration::ZERO;
    let outcome = std::thread::scope(|scope| {
        let worker = scope.spawn(|| start(&scene, &paused, &progress));
        for share in [0.0, 0.1, 0.4] {
            until("the render goes on", || progress.samples.fraction() > share);
            // In between, with one thread less and with one alone.
            paused.throttle.allow(THREADS - 1);
            paused.throttle.allow(1);
            paused.throttle.allow(0);
            let pause = Instant::now();
            // What was begun is a few samples.
            std::thread::sleep(Duration::from_millis(50));
            let (done, processor) = (progress.samples.done(), ProcessTime::now());
            std::thread::sleep(Duration::from_millis(300));
            assert_eq!(progress.samples.done(), done);
            let used = processor.elapsed();
            assert!(used < Duration::from_millis(5), "{used:?} while it rests");
            rested += pause.elapsed();
            paused.throttle.allow(usize::MAX);
        }
        worker.join().expect("does not panic")
    });
    let elapsed = started.elapsed();
    assert_eq!(outcome.image.hash(), plain.image.hash());
    assert_eq!(outcome.stats.rays, plain.stats.rays);
    assert_eq!(outcome.stats.error, plain.stats.error);
    assert!(rested > Duration::from_secs(1));
    let counted = Duration::from_secs_f64(outcome.stats.render_seconds);
    assert!(
        counted + rested < elapsed + Duration::from_millis(20),
        "{counted:?} and {rested:?} of {elapsed:?}"
    );

    // Cancelled while it rests, it ends as soon as it is let go.
    let (cancelled, waiting) = (run(), RenderProgress::default());
    cancelled.throttle.allow(0);
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| render(&scene, None, &cancelled, &waiting, None));
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(waiting.samples.done(), 0);
        assert!(!worker.is_finished());
        cancelled.cancel.cancel();
        cancelled.throttle.allow(usize::MAX);
        assert!(worker.join().expect("does not panic").is_none());
    });

    // With one thread of three, the others do not hold up the end of a pass.
    let alone = run();
    alone.throttle.allow(1);
    let outcome = start(&scene, &alone, &RenderProgress::default());
    assert_eq!(outcome.image.hash(), plain.image.hash());
}
