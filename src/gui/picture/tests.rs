//! Tests of a render as the window watches it.

use super::*;
use crate::render::{ErrorEstimate, Interval, NOISE_TARGETS, Region};
use crate::scene::RenderSettings;

const SAMPLES: u32 = 4;

/// A render of `region` of a picture of 8 × 6 pixels that begins now.
fn picture_of(region: Region) -> Picture {
    let scene = Scene {
        render: RenderSettings {
            width: 8,
            height: 6,
            samples_per_pixel: SAMPLES,
            ..RenderSettings::default()
        },
        ..Scene::default()
    };
    let part = Part { region, of: [8, 6] };
    let buffer = PictureBuffer::new(part, Vec::new(), scene.display);
    let buffer = Arc::new(buffer.expect("a few pixels fit"));
    let (names, progress) = (["a", "b"].map(str::to_owned), RenderProgress::default());
    Picture::new(1, names, scene, buffer, progress, Instant::now())
}

fn picture() -> Picture {
    picture_of(Region::full(8, 6))
}

fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

/// Until the clock shows another time.
fn wait_for_the_clock() {
    let now = Instant::now();
    while Instant::now() == now {
        std::hint::spin_loop();
    }
}

#[test]
fn tiles_wait_for_the_look_that_all_of_the_picture_gets() {
    let ctx = egui::Context::default();
    let mut picture = picture();
    let piece = |gray: u8| EncodedTile {
        position: [0, 0],
        pixels: Arc::new(egui::ColorImage::filled(
            [4, 6],
            egui::Color32::from_gray(gray),
        )),
    };
    picture.await_look(true);
    picture.take_tile(piece(1));
    picture.show_tiles(&ctx);
    assert!(!picture.is_shown() && picture.first_tile.is_none());
    picture.take_encoded(Encoded::Coarse(CoarseTexels {
        pixels: Arc::new(egui::ColorImage::filled([8, 6], egui::Color32::BLACK)),
        share: egui::Vec2::splat(1.0),
        is_smooth: false,
    }));
    picture.show_tiles(&ctx);
    assert_eq!(picture.canvas.layers().count(), 1);
    picture.take_tile(piece(2));
    picture.show_tiles(&ctx);
    assert_eq!(picture.canvas.layers().count(), 2);
    // One may have been covered meanwhile: that is mended when it ends.
    assert!(!picture.may_lack_tiles());
    picture.end(Outcome::Cancelled);
    assert!(picture.may_lack_tiles());
}

#[test]
fn the_rest_goes_on_at_the_pace_so_far() {
    let picture = picture();
    let samples = &picture.progress.samples;
    samples.set_total(1000);
    assert_eq!(picture.remaining_after(seconds(10.0)), None, "a guess");
    samples.advance(250);
    assert_eq!(picture.remaining_after(seconds(0.1)), None, "a guess");
    let left = picture.remaining_after(seconds(10.0));
    assert_eq!(left, Some(seconds(30.0)));
    samples.advance(250);
    let left = picture.remaining_after(seconds(20.0));
    assert_eq!(left, Some(seconds(20.0)));
}

#[test]
fn times_stand_still_in_a_pause_and_go_on_after_it() {
    let mut picture = picture();
    // So long that the rest is known.
    picture.go_on_after(seconds(60.0), 0.25);
    picture.progress.samples.set_total(1000);
    picture.progress.samples.advance(250);
    picture.pause();
    let paused = (picture.elapsed(), picture.remaining());
    assert!(paused.0 >= seconds(60.0) && paused.1 >= Some(seconds(180.0)));
    wait_for_the_clock();
    assert_eq!((picture.elapsed(), picture.remaining()), paused);
    let scene = picture.scene.clone();
    picture.resume(&scene, picture.buffer.part());
    wait_for_the_clock();
    assert!(picture.elapsed() > paused.0 && picture.remaining() > paused.1);
}

/// What is done counts with the time it took, in this session and before.
#[test]
fn the_rest_of_a_render_that_went_on_is_at_the_pace_of_all_of_it() {
    let mut picture = picture();
    picture.go_on_after(seconds(30.0), 0.5);
    picture.progress.samples.set_total(1000);
    picture.progress.samples.advance(500);
    picture.pause();
    let here = picture.elapsed_here();
    assert_eq!(picture.elapsed(), seconds(30.0) + here);
    assert_eq!(picture.goes_on_from(), Some(0.5));
    // Another quarter after 20 seconds more.
    picture.progress.samples.advance(250);
    let left = picture.remaining_after(seconds(50.0)).expect("is known");
    assert!((left.as_secs_f64() - 50.0 / 3.0).abs() < 1e-6, "{left:?}");
}

/// A region is a whole of its own: its pixels are all the work there is.
#[test]
fn of_a_region_only_its_own_samples_are_left() {
    let region = Region {
        x: 2,
        y: 1,
        width: 4,
        height: 3,
    };
    let picture = picture_of(region);
    let all = region.pixel_count() as u64 * u64::from(SAMPLES);
    picture.progress.samples.set_total(all);
    picture.progress.samples.advance(all / 2);
    assert_eq!(
        picture.samples(),
        Samples::OnAverage(f64::from(SAMPLES) / 2.0)
    );
    let left = picture.remaining_after(seconds(9.0));
    assert_eq!(left, Some(seconds(9.0)));
    picture.progress.samples.advance(all / 2);
    let left = picture.remaining_after(seconds(18.0));
    assert_eq!(left, Some(Duration::ZERO));
}

#[test]
fn where_it_stops_at_a_noise_what_is_foreseen_counts_and_the_clock_ends_it_before() {
    let exactly = |value| Interval {
        value,
        low: value,
        high: value,
    };
    let mut picture = picture();
    picture.progress.samples.set_total(1000);
    picture.progress.samples.advance(500);
    picture.errors = vec![ErrorPoint {
        seconds: 10.0,
        cpu_seconds: 10.0,
        error: ErrorEstimate {
            samples_per_pixel: 2.0,
            rmse: exactly(0.1),
            relmse: exactly(0.1),
            percentile_999: exactly(0.2),
            unmeasured_pixels: 0,
        },
        time_to: [None; NOISE_TARGETS.len()],
        time_to_stop: Some(exactly(40.0)),
    }];
    picture.newest_error = seconds(10.5);
    let left = |picture: &Picture, elapsed| picture.remaining_after(seconds(elapsed));
    assert_eq!(left(&picture, 10.5), Some(seconds(30.0)));
    assert_eq!(left(&picture, 15.5), Some(seconds(25.0)));
    assert_eq!(left(&picture, 99.0), Some(Duration::ZERO));
    picture.scene.render.stop.seconds = Some(20.0);
    assert_eq!(left(&picture, 15.5), Some(seconds(5.0)));
}

/// Other rules make what is done a share of another whole, also where the bar came far by those before.
#[test]
fn by_other_rules_the_rest_is_at_the_pace_of_the_samples() {
    let mut picture = picture();
    let (pixels, samples) = (8 * 6, picture.progress.samples.clone());
    samples.set_total(pixels * 4);
    samples.advance(pixels * 3);
    let mut rules = StopRules::of(&picture.scene.render);
    rules.samples_per_pixel = 12;
    picture.end_by(rules, "longer".to_owned());
    assert_eq!(picture.remaining_after(seconds(3.0)), Some(seconds(9.0)));
    // Known to be less: the bar does not jump, the time does.
    samples.set_remaining(pixels);
    assert_eq!(picture.remaining_after(seconds(3.0)), Some(seconds(1.0)));
}

/// What was told beside Render is told at first, and by and by what the render shows.
#[test]
fn the_time_that_was_expected_counts_until_the_pace_is_known() {
    let mut picture = picture();
    picture.expect_time(Some(20.0));
    let samples = picture.progress.samples.clone();
    samples.set_total(1000);
    assert_eq!(picture.remaining_after(seconds(0.0)), Some(seconds(20.0)));
    samples.advance(2);
    let left = picture.remaining_after(seconds(1.0)).expect("is expected");
    assert!(left > seconds(19.0) && left < seconds(45.0), "{left:?}");
    samples.advance(98);
    assert_eq!(picture.remaining_after(seconds(3.0)), Some(seconds(27.0)));
}
