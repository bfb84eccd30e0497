//! Lights from nearly nothing to much larger than the scene, near and far, dim and bright, none and many.

use cpu_time::ProcessTime;

use super::stage::{
    add, assert_shows_something, different_pixels, improper_pixels, lamp, largest, matt,
    mean_over_seeds, picture, point, prepared, rectangle, relative, run, showroom, spot_of_floor,
    still, value, visibly_different,
};
use super::{Bar, Case, Effort};
use crate::geometry::shapes::Random;
use crate::math::{DVec3, power_of_two};
use crate::render::{Image, RenderProgress, RunConfig, render};
use crate::scene::{Background, Facing, Light, Mode, Scene, Shadows};

pub const CASES: &[Case] = &[
    Case {
        name: "light radius 1e-6 to 1e3",
        tried: "the light of a disk straight above, modes direct and path, seen and unseen disks: largest relative error",
        bar: Bar::AtMost(1e-3),
        is_timed: false,
        measure: every_radius,
    },
    Case {
        name: "tiny light, hard shadow",
        tried: "a disk of radius 1e-6 with soft and with hard shadows: pixels that differ visibly, in per cent",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: tiny_light,
    },
    Case {
        name: "light near a surface",
        tried: "a disk 0.1 to 1e-6 of its radius above a floor, modes direct and path: largest relative error",
        bar: Bar::AtMost(1e-2),
        is_timed: false,
        measure: near_light,
    },
    Case {
        name: "light through a surface",
        tried: "a disk of radiance 1 that cuts a white floor: by how much any pixel is brighter than 1",
        bar: Bar::AtMost(1e-6),
        is_timed: false,
        measure: cutting_light,
    },
    Case {
        name: "behind a light",
        tried: "a floor behind a one-sided disk, and in its plane, modes direct and path: light and shadow rays together",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: behind_light,
    },
    Case {
        name: "intensity times 2^±60 and 2^±100",
        tried: "a scene with all kinds of light: pixels that are not the same bits times the same power of two",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: power_of_two_brighter,
    },
    Case {
        name: "intensity times 1e±30",
        tried: "the same: largest difference, relative to the brightest pixel",
        bar: Bar::AtMost(1e-5),
        is_timed: false,
        measure: far_brighter,
    },
    Case {
        name: "no light",
        tried: "a scene without lights: shadow rays, and pixels that are not what shines by itself",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: no_light,
    },
    Case {
        name: "10,000 lights",
        tried: "the mean under 10,000 lights against the sum over all, modes direct and path: distance in standard errors",
        bar: Bar::AtMost(4.0),
        is_timed: false,
        measure: many_lights,
    },
    Case {
        name: "time under 10,000 lights",
        tried: "processor time of a sample, relative to that under 10 lights, the slower of modes direct and path",
        bar: Bar::AtMost(3.0),
        is_timed: true,
        measure: time_of_many_lights,
    },
];

fn every_radius(effort: Effort) -> f64 {
    let mut errors = Vec::new();
    for exponent in -6..=3 {
        let radius = libm::pow(10.0, f64::from(exponent));
        for mode in [Mode::Direct, Mode::Path] {
            for is_seen in [false, true] {
                let mut scene = spot_of_floor(0.0, 30.0, matt(1.0));
                scene.lights = vec![lamp(DVec3::Z, radius)];
                if let Light::Disk { visible, .. } = &mut scene.lights[0] {
                    *visible = is_seen;
                }
                // A seen disk must not hide the floor: the eye stays below it.
                scene.camera.eye = DVec3::new(0.0, -0.4, 0.6);
                scene.render.mode = mode;
                scene.render.max_bounces = 1;
                scene.render.samples_per_pixel = effort.pick(1 << 12, 1 << 16);
                let square = radius * radius;
                errors.push(relative(value(&scene), square / (square + 1.0)));
            }
        }
    }
    largest(errors)
}

fn tiny_light(_: Effort) -> f64 {
    let mut scene = showroom(96, 72);
    scene.lights = vec![lamp(DVec3::new(0.5, -0.5, 3.0), 1e-6)];
    if let Light::Disk { radiance, .. } = &mut scene.lights[0] {
        *radiance *= 1e13;
    }
    let soft = picture(&scene);
    scene.render.shadows = Shadows::Hard;
    visibly_different(&picture(&scene), &soft, 1.0)
}

fn near_light(effort: Effort) -> f64 {
    let mut errors = Vec::new();
    for height in [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        for mode in [Mode::Direct, Mode::Path] {
            let mut scene = spot_of_floor(0.0, 30.0, matt(1.0));
            scene.lights = vec![lamp(DVec3::Z * height, 1.0)];
            scene.render.mode = mode;
            scene.render.max_bounces = 1;
            scene.render.samples_per_pixel = effort.pick(1 << 12, 1 << 16);
            errors.push(relative(value(&scene), 1.0 / (1.0 + height * height)));
        }
    }
    largest(errors)
}

fn cutting_light(effort: Effort) -> f64 {
    let mut excess = Vec::new();
    for mode in [Mode::Direct, Mode::Path] {
        let mut scene = floor(64, 48);
        let mut light = lamp(DVec3::ZERO, 1.0);
        if let Light::Disk { facing, .. } = &mut light {
            *facing = Facing::Normal(DVec3::new(1.0, 0.5, -0.3));
        }
        scene.lights = vec![light];
        scene.render.mode = mode;
        scene.render.max_bounces = 1;
        scene.render.samples_per_pixel = effort.pick(64, 1024);
        let image = picture(&scene);
        assert_eq!(improper_pixels(&image), 0.0);
        let brightest = largest(image.pixels.iter().map(|p| f64::from(p[0])));
        assert!(brightest > 0.3, "the light gives light: {brightest}");
        excess.push(brightest - 1.0);
    }
    largest(excess)
}

/// A white floor seen from above.
fn floor(width: u32, height: u32) -> Scene {
    let mut scene = still(width, height);
    let (u, v) = (DVec3::X * 3.0, DVec3::Y * 3.0);
    let mesh = rectangle(DVec3::ZERO, u, v);
    add(&mut scene, "floor", mesh, matt(1.0));
    scene
}

fn behind_light(_: Effort) -> f64 {
    let mut light = 0.0;
    for (center, normal) in [
        (DVec3::Z, DVec3::Z),
        (DVec3::ZERO, DVec3::Z),
        (DVec3::NEG_Z, DVec3::NEG_Z),
    ] {
        let mut scene = floor(32, 24);
        let mut disk = lamp(center, 1.0);
        if let Light::Disk { facing, .. } = &mut disk {
            *facing = Facing::Normal(normal);
        }
        scene.lights = vec![disk];
        for mode in [Mode::Direct, Mode::Path] {
            scene.render.mode = mode;
            let outcome = run(&scene);
            light += largest(outcome.image.pixels.iter().map(|p| f64::from(p[0])));
            light += outcome.stats.rays.shadow as f64;
        }
    }
    light
}

/// `scene` with everything that shines shining `factor` times as bright.
fn brighter(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    for light in &mut scene.lights {
        match light {
            Light::Point { intensity, .. } => *intensity *= factor,
            Light::Disk { radiance, .. } => *radiance *= factor,
        }
    }
    if let Background::Constant { radiance } = &mut scene.background {
        *radiance *= factor;
    }
    scene
}

fn both_modes() -> [Scene; 2] {
    [Mode::Direct, Mode::Path].map(|mode| {
        let mut scene = showroom(48, 36);
        scene.render.mode = mode;
        scene.render.samples_per_pixel = 4;
        scene
    })
}

fn power_of_two_brighter(_: Effort) -> f64 {
    let mut different = 0.0;
    for scene in both_modes() {
        let base = picture(&scene);
        assert_shows_something(&base);
        for exponent in [-100, -60, 60, 100] {
            let factor = power_of_two(exponent);
            let brighter = picture(&brighter(&scene, factor));
            let back = divided(&brighter, factor);
            different += different_pixels(&base, &back);
        }
    }
    different
}

fn far_brighter(_: Effort) -> f64 {
    let mut differences = Vec::new();
    for scene in both_modes() {
        let base = picture(&scene);
        let brightest = largest(base.pixels.iter().flatten().map(|&c| f64::from(c)));
        for factor in [1e-30, 1e30] {
            let back = divided(&picture(&brighter(&scene, factor)), factor);
            let pairs = base
                .pixels
                .iter()
                .flatten()
                .zip(back.pixels.iter().flatten());
            let apart = pairs.map(|(&a, &b)| f64::from(a - b).abs() / brightest);
            differences.push(largest(apart));
        }
    }
    largest(differences)
}

#[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
fn divided(image: &Image, factor: f64) -> Image {
    let mut image = image.clone();
    for channel in image.pixels.iter_mut().flatten() {
        *channel = (f64::from(*channel) / factor) as f32;
    }
    image
}

fn no_light(_: Effort) -> f64 {
    let mut count = 0.0;
    for mode in [Mode::Direct, Mode::Path] {
        let mut scene = showroom(32, 24);
        scene.lights.clear();
        scene.background = Background::default();
        scene.render.mode = mode;
        let outcome = run(&scene);
        count += outcome.stats.rays.shadow as f64;
        count += outcome
            .image
            .pixels
            .iter()
            .filter(|&&p| p != [0.0; 3])
            .count() as f64;
    }
    count
}

/// A floor under `count` lights, points and disks of random places and colours, which give as much light whatever their number.
fn under_lights(count: u32) -> Scene {
    let mut random = Random::new(11);
    let mut scene = floor(24, 18);
    let share = 1.0 / f64::from(count);
    scene.lights = (0..count)
        .map(|number| {
            let place = random.in_cube() * DVec3::new(3.0, 3.0, 0.7) + DVec3::Z * 1.5;
            let strength = (0.2 + random.unit()) * share;
            if number.is_multiple_of(2) {
                return point(place, 8.0 * strength);
            }
            let mut light = lamp(place, 0.1);
            if let Light::Disk { radiance, .. } = &mut light {
                *radiance *= 250.0 * strength;
            }
            light
        })
        .collect();
    scene.render.max_bounces = 1;
    scene.render.antialiasing = false;
    scene
}

fn many_lights(effort: Effort) -> f64 {
    let mut scene = under_lights(10_000);
    let lights = std::mem::take(&mut scene.lights);
    // At most 32 lights at a time are all asked, which makes no choice.
    let mut sum = 0.0;
    for some in lights.chunks(32) {
        scene.lights = some.to_vec();
        scene.render.samples_per_pixel = effort.pick(2, 32);
        let image = picture(&scene);
        sum +=
            image.pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / image.pixels.len() as f64;
    }
    scene.lights = lights;
    largest([Mode::Direct, Mode::Path].map(|mode| {
        scene.render.mode = mode;
        scene.render.samples_per_pixel = effort.pick(16, 256);
        let (mean, error) = mean_over_seeds(&mut scene, 32);
        (mean - sum).abs() / error
    }))
}

fn time_of_many_lights(effort: Effort) -> f64 {
    let seconds = |mode: Mode, count: u32| {
        let mut scene = under_lights(count);
        scene.render.mode = mode;
        scene.render.width = 96;
        scene.render.height = 72;
        scene.render.samples_per_pixel = effort.pick(16, 128);
        let ready = prepared(&scene);
        let started = ProcessTime::now();
        let (run, progress) = (RunConfig::default(), RenderProgress::default());
        let done = render(&ready, None, &run, &progress, None);
        assert!(done.is_some(), "nobody cancels");
        started.elapsed().as_secs_f64()
    };
    largest([Mode::Direct, Mode::Path].map(|mode| {
        let least = |count| {
            (0..3)
                .map(|_| seconds(mode, count))
                .fold(f64::INFINITY, f64::min)
        };
        least(10_000) / least(10)
    }))
}
