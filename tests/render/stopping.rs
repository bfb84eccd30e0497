//! When renders end: by the clock before there is a whole picture, and by rules that change on the way or after.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use crate::common::{add, diffuse, rectangle, run};
use crate::error::{from_picture, true_error};
use raymini::control::CancelToken;
use raymini::math::DVec3;
use raymini::render::{
    Checkpoint, Ending, LiveRules, PreparedScene, RenderOutcome, RenderProgress, RunConfig, Sight,
    StopRules, TilePixels, Watch, render_watched, resume,
};
use raymini::scene::{Background, Camera, Mode, RenderSettings, Rgb, Scene, Stop};

/// A floor and a wall under an even sky: noisy where they meet.
fn corner() -> Scene {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0);
    let wall = rectangle(DVec3::new(0.0, 1.0, 0.5), DVec3::X, DVec3::Z);
    add(&mut scene, "floor", floor, diffuse(0.8));
    add(&mut scene, "wall", wall, diffuse(0.5));
    scene.background = Background::Constant {
        radiance: Rgb::splat(1.0),
    };
    scene.camera = Camera {
        eye: DVec3::new(1.0, -4.0, 2.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 70,
        height: 50,
        samples_per_pixel: 16,
        max_bounces: 3,
        ..RenderSettings::default()
    };
    scene
}

fn with_samples(samples: u32) -> Scene {
    let mut scene = corner();
    scene.render.samples_per_pixel = samples;
    scene
}

fn prepared(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared.expect("can be rendered").expect("nobody cancels")
}

fn rules(samples_per_pixel: u32, stop: Stop) -> StopRules {
    StopRules {
        samples_per_pixel,
        stop,
    }
}

/// Renders `scene`, and sets `changed` rules as soon as it has taken more than so many samples of a pixel. `has_room`: to go back to what was
/// there before the last pass. Returns the picture, and whether the rules led elsewhere.
fn changed_on_the_way(
    scene: &Scene,
    after: u64,
    changed: StopRules,
    has_room: bool,
) -> (RenderOutcome, bool) {
    let live = LiveRules::new(StopRules::of(&scene.render));
    let run = RunConfig {
        threads: 2,
        has_room,
        rules: Some(live.clone()),
        ..RunConfig::default()
    };
    let progress = RenderProgress::default();
    let is_set = AtomicBool::new(false);
    let on_tile = |_: &TilePixels<'_>| {
        if progress.samples.done() > after * scene.render.pixel_count()
            && !is_set.swap(true, Ordering::Relaxed)
        {
            live.set(changed);
        }
    };
    let watch = Watch {
        on_tile: Some(&on_tile),
        ..Watch::default()
    };
    let outcome = render_watched(&prepared(scene), None, &run, &progress, watch);
    (outcome.expect("nobody cancels"), live.lead_elsewhere())
}

/// The first pass takes several seconds; the render ends when its time is up.
#[test]
fn time_ends_a_render_before_there_is_a_whole_picture() {
    let mut scene = corner();
    scene.render.mode = Mode::Ao;
    (scene.render.width, scene.render.height) = (640, 480);
    scene.render.ambient_occlusion.samples = 2000;
    scene.render.stop.seconds = Some(0.2);
    let outcome = run(&scene);
    let stats = outcome.stats;
    assert_eq!(stats.ending, Ending::Time);
    assert_eq!((stats.sample_range, stats.passes), ([0, 1], 0));
    assert!(stats.is_cut_short && stats.samples > 0 && stats.error.is_none());
    assert!(stats.samples < scene.render.pixel_count() / 2, "{stats:?}");
}

/// Renders `scene`, by one thread, and has it end when so many tiles are done, of six in each pass over the picture.
fn interrupted_after(tiles: usize, scene: &Scene) -> RenderOutcome {
    let run = RunConfig {
        threads: 1,
        ..RunConfig::default()
    };
    let done = AtomicUsize::new(0);
    let on_tile = |_: &TilePixels<'_>| {
        if done.fetch_add(1, Ordering::Relaxed) + 1 == tiles {
            run.interrupt.cancel();
        }
    };
    let watch = Watch {
        on_tile: Some(&on_tile),
        ..Watch::default()
    };
    let progress = RenderProgress::default();
    let outcome = render_watched(&prepared(scene), None, &run, &progress, watch);
    outcome.expect("nobody cancels")
}

/// It is that of a render of as many samples, and says how many passes it has.
#[test]
fn a_render_that_is_interrupted_between_passes_is_whole() {
    let found = interrupted_after(7 * 6, &with_samples(64));
    let whole = run(&with_samples(12));
    assert_eq!(found.stats.ending, Ending::Interrupted);
    assert_eq!(found.stats.sample_range, [12; 2]);
    assert_eq!((found.stats.passes, found.stats.is_cut_short), (7, false));
    assert_eq!(found.image.hash(), whole.image.hash());
    assert_eq!(found.stats.error, whole.stats.error);
}

/// Four tiles of six got the pass from 8 to 12 samples. What is told of that picture holds the truth, as far as another one of 1024 samples
/// knows it.
#[test]
fn the_error_of_a_render_that_is_interrupted_is_that_of_the_samples_it_has() {
    let found = interrupted_after(6 * 6 + 4, &with_samples(64));
    let stats = found.stats;
    assert_eq!(stats.ending, Ending::Interrupted);
    assert_eq!(stats.sample_range, [8, 12]);
    assert_eq!((stats.passes, stats.is_cut_short), (6, true));
    let error = stats.error.expect("there are enough samples");
    assert_eq!(error.samples_per_pixel, stats.samples_per_pixel);
    let mut reference = with_samples(1024);
    reference.render.seed = 1;
    let reference = run(&reference).image;
    let [_, truth] = true_error(&found.image, from_picture(&reference));
    assert!(
        error.relmse.contains(truth),
        "{error:?}, in truth {truth:e}"
    );
}

/// As many samples as the new rules say, with the bits that they give from the start: from a whole pass on, and from one that was shorter as
/// nobody knew of the new rules then.
#[test]
fn a_render_goes_on_to_more_samples_with_the_same_bits() {
    for (first, then, after) in [(16, 64, 3), (20, 40, 17), (20, 100, 3), (100, 24, 3)] {
        let (found, leads_elsewhere) = changed_on_the_way(
            &with_samples(first),
            after,
            rules(then, Stop::default()),
            true,
        );
        let whole = run(&with_samples(then));
        assert_eq!(found.image.hash(), whole.image.hash(), "{first} to {then}");
        assert_eq!(found.stats.error, whole.stats.error, "{first} to {then}");
        assert_eq!(found.stats.sample_range, [then; 2]);
        assert!(!leads_elsewhere, "{first} to {then}");
    }
}

/// Without memory to go back, the last pass stays as short as it is, which is told.
#[test]
fn where_passes_are_cut_otherwise_that_is_told() {
    let (found, leads_elsewhere) =
        changed_on_the_way(&with_samples(20), 17, rules(40, Stop::default()), false);
    assert_eq!(found.stats.sample_range, [40; 2]);
    assert!(leads_elsewhere);
}

/// Fewer samples than are taken already end the render after the pass that is going on.
#[test]
fn a_render_that_has_more_than_enough_ends() {
    let (found, _) =
        changed_on_the_way(&with_samples(1 << 16), 12, rules(4, Stop::default()), true);
    assert_eq!(found.stats.ending, Ending::Samples);
    assert_eq!(found.stats.sample_range, [16; 2]);
}

/// A noise to stop at, set early enough, decides as it would have from the start; set later, it finds pixels that were not chosen by it.
#[test]
fn noise_may_become_the_rule_on_the_way() {
    let noise = Stop {
        noise: Some(0.02),
        ..Stop::default()
    };
    let most = 1 << 12;
    let mut scene = with_samples(most);
    scene.render.stop = noise;
    let whole = run(&scene);
    assert_eq!(whole.stats.ending, Ending::Noise);
    for (after, leads_elsewhere) in [(5, false), (33, true)] {
        let (found, told) =
            changed_on_the_way(&with_samples(most), after, rules(most, noise), true);
        assert_eq!(found.stats.ending, Ending::Noise);
        assert_eq!(told, leads_elsewhere, "after {after}");
        if !leads_elsewhere {
            assert_eq!(found.image.hash(), whole.image.hash());
        }
    }
}

/// What a render had reached when it ended, and its picture.
fn reached(scene: &Scene, cancel_after: Option<u64>) -> (Checkpoint, Option<RenderOutcome>) {
    let run = RunConfig {
        threads: 2,
        has_room: true,
        ..RunConfig::default()
    };
    let progress = RenderProgress::default();
    let kept = Mutex::new(None);
    let at_end = |checkpoint| *kept.lock().expect("one thread") = Some(checkpoint);
    let on_tile = |_: &TilePixels<'_>| {
        if cancel_after
            .is_some_and(|after| progress.samples.done() > after * scene.render.pixel_count())
        {
            run.cancel.cancel();
        }
    };
    let watch = Watch {
        on_tile: Some(&on_tile),
        at_end: Some(&at_end),
        ..Watch::default()
    };
    let outcome = render_watched(&prepared(scene), None, &run, &progress, watch);
    let kept = kept.into_inner().expect("one thread");
    (kept.expect("is handed on"), outcome)
}

/// A render that was cancelled, and one that was done, go on to what a longer one is from the start.
#[test]
fn what_has_ended_goes_on_with_the_same_bits() {
    for (first, cancel_after, then) in [(16, None, 32), (20, None, 50), (64, Some(9), 64)] {
        let (checkpoint, outcome) = reached(&with_samples(first), cancel_after);
        assert_eq!(outcome.is_some(), cancel_after.is_none());
        let scene = with_samples(then);
        let whole = run(&scene);
        let before = with_samples(first).render;
        assert!(!checkpoint.leads_elsewhere(&before, &scene.render));
        let checkpoint = checkpoint.with_rules_of(&scene.render);
        let share = checkpoint.share_done(0);
        assert!(share > 0.1 && share < 0.9, "{share}");
        let progress = RenderProgress::default();
        progress.go_on_at(share);
        let begun = Mutex::new(Vec::new());
        let on_tile = |_: &TilePixels<'_>| begun.lock().expect("no panic").push(progress.share());
        let watch = Watch {
            on_tile: Some(&on_tile),
            ..Watch::default()
        };
        let run = RunConfig::default();
        let found = resume(&prepared(&scene), checkpoint, &run, &progress, watch);
        let found = found.expect("nobody cancels");
        assert_eq!(found.image.hash(), whole.image.hash(), "{first} to {then}");
        assert_eq!(found.stats.error, whole.stats.error);
        let shares = begun.into_inner().expect("no panic");
        assert!(shares.iter().all(|&s| s >= share), "it begins where it was");
    }
}

/// A picture that came down to a noise is brought down further.
#[test]
fn a_lower_noise_is_reached_from_where_a_higher_one_was() {
    let mut scene = with_samples(1 << 12);
    scene.render.stop.noise = Some(0.03);
    let (checkpoint, outcome) = reached(&scene, None);
    let before = outcome.expect("nobody cancels").stats;
    assert_eq!(before.ending, Ending::Noise);
    scene.render.stop.noise = Some(0.015);
    let checkpoint = checkpoint.with_rules_of(&scene.render);
    let (run, progress) = (RunConfig::default(), RenderProgress::default());
    let after = resume(
        &prepared(&scene),
        checkpoint,
        &run,
        &progress,
        Watch::default(),
    );
    let after = after.expect("nobody cancels").stats;
    assert_eq!(after.ending, Ending::Noise);
    assert!(after.samples > before.samples);
    let noise = after.error.expect("is measured").noise().value;
    assert!(noise <= 0.015, "{noise}");
}

/// The bar follows the clock where that ends the render, from the first moment on, and never goes back.
#[test]
fn what_is_done_follows_the_rule_that_ends_the_render() {
    let limit = 0.6;
    let mut scene = with_samples(1 << 20);
    scene.render.stop.seconds = Some(limit);
    let scene = prepared(&scene);
    let progress = RenderProgress::default();
    let started = Instant::now();
    let seen = Mutex::new(Vec::new());
    let on_tile = |_: &TilePixels<'_>| {
        let left = progress
            .seconds_until_time_is_up()
            .expect("the clock ends it");
        let seconds = started.elapsed().as_secs_f64();
        seen.lock()
            .expect("no panic")
            .push((progress.share(), left, seconds));
    };
    let watch = Watch {
        on_tile: Some(&on_tile),
        ..Watch::default()
    };
    let run = RunConfig {
        threads: 1,
        ..RunConfig::default()
    };
    let outcome = render_watched(&scene, None, &run, &progress, watch);
    assert_eq!(outcome.expect("nobody cancels").stats.ending, Ending::Time);
    assert_eq!(progress.share(), 1.0);
    let seen = seen.into_inner().expect("no panic");
    let mut last = 0.0;
    for (share, left, seconds) in seen {
        // The clock of the render began later than this one.
        assert!(
            share <= seconds / limit + 1e-6 || share == 1.0,
            "{share} after {seconds} s"
        );
        assert!(
            (share - (1.0 - left / limit)).abs() < 0.05,
            "{share}, {left} s left"
        );
        assert!(share >= last);
        last = share;
    }
    assert!(last > 0.7, "{last}");
}

/// What is known beforehand of a render that stops at a noise is where its bar goes, until it knows better.
#[test]
fn a_guess_of_the_samples_leads_until_the_error_is_known() {
    let mut scene = with_samples(1 << 16);
    scene.render.stop.noise = Some(0.02);
    let pixels = scene.render.pixel_count();
    for guess in [None, Some(40 * pixels)] {
        let progress = RenderProgress::default();
        if let Some(samples) = guess {
            progress.expect_samples(samples);
        }
        let seen = Mutex::new(Vec::new());
        let on_tile = |_: &TilePixels<'_>| {
            let told = (progress.samples.done(), progress.share(), progress.sight());
            seen.lock().expect("no panic").push(told);
        };
        let watch = Watch {
            on_tile: Some(&on_tile),
            ..Watch::default()
        };
        let run = RunConfig {
            threads: 1,
            ..RunConfig::default()
        };
        let outcome = render_watched(&prepared(&scene), None, &run, &progress, watch);
        let stats = outcome.expect("nobody cancels").stats;
        assert_eq!(stats.ending, Ending::Noise);
        let seen = seen.into_inner().expect("no panic");
        let early: Vec<_> = seen
            .iter()
            .filter(|(done, ..)| *done <= 3 * pixels)
            .collect();
        assert!(!early.is_empty());
        for (done, share, sight) in early {
            let whole = guess.unwrap_or(pixels << 16) as f64;
            assert!((share - *done as f64 / whole).abs() < 1e-9, "{share}");
            let known = if guess.is_some() {
                Sight::Guess
            } else {
                Sight::Bound
            };
            assert_eq!(*sight, known);
        }
        assert_eq!(seen.last().map(|told| told.2), Some(Sight::Known));
        for pair in seen.windows(2) {
            let [(before, low, _), (done, share, _)] = [pair[0], pair[1]];
            assert!(share >= low, "it never goes back");
            // Nor does it jump, where there was a guess, but for what a tile is of the whole.
            let of_tile = (done - before) as f64 / stats.samples as f64;
            assert!(
                guess.is_none() || share - low < 0.05 + 3.0 * of_tile,
                "from {low} to {share}"
            );
        }
    }
}

/// Goes on from `checkpoint` by the rules of `scene`. Returns the picture, and what the first tile found told: what is known of the samples that
/// are to come, and how many there are in all.
fn gone_on(checkpoint: Checkpoint, scene: &Scene) -> (RenderOutcome, Option<(Sight, f64)>) {
    let prepared = prepared(scene);
    assert!(checkpoint.fits(&prepared, checkpoint.region(), &[]));
    let progress = RenderProgress::default();
    let first = Mutex::new(None);
    let on_tile = |_: &TilePixels<'_>| {
        let [done, left] = progress.samples_done_and_left();
        let mut first = first.lock().expect("no panic");
        first.get_or_insert((progress.sight(), done + left));
    };
    let watch = Watch {
        on_tile: Some(&on_tile),
        ..Watch::default()
    };
    let checkpoint = checkpoint.with_rules_of(&scene.render);
    let run = RunConfig::default();
    let outcome = resume(&prepared, checkpoint, &run, &progress, watch);
    let first = first.into_inner().expect("no panic");
    (outcome.expect("nobody cancels"), first)
}

/// Nothing is lost of what has more samples than the rules allow by now: the pass that was going on is done for all pixels, those that have fewer
/// get what they may, and it ends.
#[test]
fn what_has_more_samples_than_it_may_goes_on_and_ends() {
    let (checkpoint, _) = reached(&with_samples(1 << 10), Some(36));
    let (found, _) = gone_on(checkpoint, &with_samples(8));
    assert_eq!(found.stats.ending, Ending::Samples);
    assert_eq!(found.stats.sample_range, [48; 2]);
    assert_eq!(found.image.hash(), run(&with_samples(48)).image.hash());

    let mut scene = with_samples(1 << 12);
    scene.render.stop.noise = Some(0.01);
    let (checkpoint, before) = reached(&scene, None);
    let before = before.expect("nobody cancels").stats;
    let [fewest, most] = before.sample_range;
    assert!(fewest < 64 && most > 64, "{fewest} to {most}");
    let (found, _) = gone_on(checkpoint, &with_samples(64));
    assert_eq!(found.stats.ending, Ending::Samples);
    // Pixels without noise, such as those of the sky, need no more than they have.
    assert_eq!(found.stats.sample_range, [fewest, most]);
    assert!(found.stats.samples > before.samples);
    assert!(found.stats.render_seconds > before.render_seconds);
}

/// How far it is to a lower noise follows from how noise fell so far.
#[test]
fn what_goes_on_to_a_lower_noise_knows_at_once_how_far_that_is() {
    let mut scene = with_samples(1 << 16);
    scene.render.stop.noise = Some(0.02);
    let (checkpoint, _) = reached(&scene, None);
    scene.render.stop.noise = Some(0.01);
    let (found, first) = gone_on(checkpoint, &scene);
    assert_eq!(found.stats.ending, Ending::Noise);
    let (sight, expected) = first.expect("there are tiles");
    assert_eq!(sight, Sight::Known);
    let off = expected / found.stats.samples as f64;
    assert!(
        (0.5..2.0).contains(&off),
        "{expected}: {off} of what it took"
    );
}

/// A noise that is there already ends a render with the pass that is going on, which is told as soon as it is set: what is left is no more than that.
#[test]
fn a_noise_that_is_reached_ends_the_render_with_its_pass() {
    for adaptive in [false, true] {
        let mut scene = with_samples(1 << 16);
        scene.render.stop.noise = Some(0.001);
        scene.render.adaptive = adaptive;
        let pixels = scene.render.pixel_count();
        let live = LiveRules::new(StopRules::of(&scene.render));
        let config = RunConfig {
            threads: 1,
            rules: Some(live.clone()),
            ..RunConfig::default()
        };
        let progress = RenderProgress::default();
        let reached = Stop {
            noise: Some(0.5),
            ..Stop::default()
        };
        let set_at = Mutex::new(None);
        let told = Mutex::new(Vec::new());
        let on_tile = |_: &TilePixels<'_>| {
            let done = progress.samples.done();
            let mut set_at = set_at.lock().expect("no panic");
            if set_at.is_none() && done > 70 * pixels {
                assert!(!progress.ends_with_pass());
                live.set(rules(1 << 16, reached));
                *set_at = Some(done);
            } else if set_at.is_some() {
                let [done, left] = progress.samples_done_and_left();
                let mut told = told.lock().expect("no panic");
                told.push((progress.ends_with_pass(), done + left, progress.share()));
            }
        };
        let watch = Watch {
            on_tile: Some(&on_tile),
            ..Watch::default()
        };
        let outcome = render_watched(&prepared(&scene), None, &config, &progress, watch);
        let stats = outcome.expect("nobody cancels").stats;
        assert_eq!(stats.ending, Ending::Noise);
        let told = told.into_inner().expect("no panic");
        assert!(!told.is_empty(), "it was set at the end of a pass");
        for (ends_with_pass, whole, share) in told {
            assert!(ends_with_pass);
            assert!(
                (whole - stats.samples as f64).abs() < 1.5,
                "{whole} of {stats:?}"
            );
            assert!(share > 0.5, "{share}");
        }
    }
}
