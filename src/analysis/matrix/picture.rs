//! Pictures of one pixel and of too many, pixels of too many samples, and renders that are called off.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use super::stage::{
    add, assert_shows_something, different_pixels, largest, picture, prepared, rectangle, relative,
    showroom, still, value,
};
use super::{Bar, Case, Effort};
use crate::control::CancelToken;
use crate::math::DVec3;
use crate::memory::peak_bytes;
use crate::render::{
    Bands, Decision, Dimension, Image, Region, RenderProgress, RunConfig, Sampler, render,
};
use crate::scene::{Background, Camera, Material, Mode, Rgb, SamplerChoice, Scene};

pub const CASES: &[Case] = &[
    Case {
        name: "pictures of 1 × 1 to 16,384 × 16,384",
        tried: "one pixel, and regions of the largest picture: pixels that are not the background's known value",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: smallest_and_largest,
    },
    Case {
        name: "memory of 16,384 × 16,384 pixels",
        tried: "GiB to render them in bands, as estimated; with --long they are rendered and compared with what they show, and it is the most that the process ever held",
        bar: Bar::AtMost(8.0),
        is_timed: false,
        measure: largest_whole,
    },
    Case {
        name: "100,000 samples in a pixel: drift",
        tried: "a pixel that is 0.1 in every sample: relative error",
        bar: Bar::AtMost(1e-6),
        is_timed: false,
        measure: drift,
    },
    Case {
        name: "100,000 samples in a pixel: repeats",
        tried: "random points of samples up to number 2^18: how many are there twice",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: repeated_samples,
    },
    Case {
        name: "any number of threads",
        tried: "a scene with everything, 1, 2 and 7 threads: pixels that are not the same bits",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: threads,
    },
    Case {
        name: "cancelled renders",
        tried: "from the request to the end of a path-traced render, the slowest of several: milliseconds",
        bar: Bar::AtMost(50.0),
        is_timed: true,
        measure: cancel_latency,
    },
];

/// A sky that is bright where the eye looks.
fn sky(width: u32, height: u32) -> Scene {
    let mut scene = still(width, height);
    scene.background = Background::Constant {
        radiance: Rgb::new(0.25, 0.5, 0.75),
    };
    scene
}

fn smallest_and_largest(_: Effort) -> f64 {
    let wrong = |image: &Image| {
        let pixels = image.pixels.iter();
        pixels.filter(|&&pixel| pixel != [0.25, 0.5, 0.75]).count() as f64
    };
    let mut count = wrong(&picture(&sky(1, 1)));
    for (width, height) in [(16_384, 16_384), (65_536, 1), (1, 65_536)] {
        let scene = prepared(&sky(width, height));
        let side = 40.min(width).min(height);
        for (x, y) in [
            (0, 0),
            (width - side, height - side),
            (width / 2, height / 2),
        ] {
            let region = Region {
                x: x.min(width - side),
                y: y.min(height - side),
                width: side,
                height: side,
            };
            let (run, progress) = (RunConfig::default(), RenderProgress::default());
            let outcome = render(&scene, Some(region), &run, &progress, None);
            count += wrong(&outcome.expect("nobody cancels").image);
        }
    }
    count
}

/// Along each side of [`board`].
const FIELDS: u32 = 16;

/// A shining board of fields, each of its own colour, that fills a square picture.
fn board(side: u32) -> Scene {
    let mut scene = still(side, side);
    scene.camera = Camera {
        eye: DVec3::NEG_Y * 30.0,
        ..Camera::default()
    };
    // Half of the board is as high as half of the picture.
    let half = 30.0 * libm::tan(scene.camera.vertical_fov.radians() / 2.0);
    let width = 2.0 * half / f64::from(FIELDS);
    for row in 0..FIELDS {
        for column in 0..FIELDS {
            let middle = |number: u32| (f64::from(number) + 0.5) * width - half;
            let center = DVec3::new(middle(column), 0.0, -middle(row));
            let field = rectangle(center, DVec3::X * width / 2.0, DVec3::Z * width / 2.0);
            let radiance = Rgb::from_array(color_of_field(row, column).map(f64::from));
            let name = format!("field {row} {column}");
            add(&mut scene, &name, field, Material::Emitter { radiance });
        }
    }
    scene
}

/// The colour of a field, counted from the top and from the left.
fn color_of_field(row: u32, column: u32) -> [f32; 3] {
    let share = |number: u32| (number + 1) as f32 / FIELDS as f32;
    [share(row), share(column), 0.5]
}

fn largest_whole(effort: Effort) -> f64 {
    let side = 16_384;
    let scene = prepared(&board(side));
    let run = RunConfig::default();
    let bands = Bands::of(&scene, None, &run).expect("is rendered in bands");
    let memory = bands.memory(&scene, &run);
    let mut bytes = memory.bytes();
    if effort == Effort::Long {
        let granted = memory.require();
        granted.unwrap_or_else(|error| panic!("cannot be tried: {error}"));
        let outcome = bands.render(&scene, &run, RenderProgress::default);
        let wrong = wrong_pixels(&outcome.expect("nobody cancels").image);
        assert_eq!(wrong, 0, "pixels that show another field");
        bytes = bytes.max(peak_bytes().unwrap_or(0));
    }
    bytes as f64 / f64::from(1 << 30)
}

/// How many pixels of a picture of [`board`] do not show the field that is there.
fn wrong_pixels(image: &Image) -> usize {
    let side = image.width / FIELDS;
    let rows = image.pixels.chunks(image.width as usize).zip(0..);
    let wrong_in_row = |(row, number): (&[[f32; 3]], u32)| {
        let fields = row.chunks(side as usize).zip(0..);
        let wrong_in_field = |(pixels, column): (&[[f32; 3]], u32)| {
            let expected = color_of_field(number / side, column);
            pixels.iter().filter(|&&pixel| pixel != expected).count()
        };
        fields.map(wrong_in_field).sum::<usize>()
    };
    rows.map(wrong_in_row).sum()
}

fn drift(effort: Effort) -> f64 {
    let mut scene = still(1, 1);
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.1),
    };
    scene.render.samples_per_pixel = effort.pick(100_000, 1 << 22);
    relative(value(&scene), f64::from(0.1_f32))
}

fn repeated_samples(_: Effort) -> f64 {
    let count = 1 << 18;
    let points: HashSet<[u32; 2]> = (0..count)
        .map(|index| {
            let sampler = Sampler::new(SamplerChoice::Sobol, 5, (3, 4), index);
            let point = sampler.next_2d(Dimension::once(Decision::Lens));
            [point.x.to_bits(), point.y.to_bits()]
        })
        .collect();
    f64::from(count) - points.len() as f64
}

fn threads(_: Effort) -> f64 {
    let mut different = 0.0;
    for mode in [Mode::Direct, Mode::Path] {
        let mut scene = showroom(72, 54);
        scene.render.mode = mode;
        scene.render.samples_per_pixel = 8;
        let alone = super::stage::run_on(&scene, 1).image;
        assert_shows_something(&alone);
        for threads in [2, 7] {
            let image = super::stage::run_on(&scene, threads).image;
            different += different_pixels(&alone, &image);
        }
    }
    different
}

fn cancel_latency(effort: Effort) -> f64 {
    let mut scene = showroom(640, 480);
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 64;
    scene.render.samples_per_pixel = 1 << 20;
    let scene = prepared(&scene);
    largest((0..effort.pick(4, 50)).map(|turn| {
        let cancel = CancelToken::new();
        let run = RunConfig {
            cancel: cancel.clone(),
            ..RunConfig::default()
        };
        let rendering = std::thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let outcome = render(&scene, None, &run, &RenderProgress::default(), None);
                (outcome.is_none(), Instant::now())
            });
            std::thread::sleep(Duration::from_millis(30 + 17 * turn));
            let asked = Instant::now();
            cancel.cancel();
            let (was_cancelled, ended) = worker.join().expect("ends");
            assert!(was_cancelled);
            ended - asked
        });
        rendering.as_secs_f64() * 1e3
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_board_shows_its_fields_where_they_are_looked_for() {
        let mut image = picture(&board(64));
        assert_eq!(wrong_pixels(&image), 0);
        image.pixels.rotate_left(64 * 4);
        assert_eq!(wrong_pixels(&image), 64 * 64);
    }
}
