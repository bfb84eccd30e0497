//! Scenes with more lights than are summed: the choice among them against the sum of all.
//!
//! Sequences are fixed by seeds. Statistical tolerances say how many standard deviations they are.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::{
    self, add, assert_ways_agree, diffuse, looking_at_floor, picture, rectangle, run, value,
};
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::DVec3;
use raymini::scene::{
    Camera, Facing, Light, Material, Mode, RenderSettings, Rgb, Scene, Shadows, Textures,
};

/// Numbers in `0..1` that are the same everywhere (the R₁ sequence of a few irrationals).
fn unit(index: u32, which: u32) -> f64 {
    let irrational = [
        0.618_033_988_7,
        0.754_877_666_2,
        0.569_840_290_9,
        0.819_172_513_4,
        0.671_043_606_7,
        0.549_700_477_9,
    ][which as usize];
    (0.5 + f64::from(index + 1) * irrational).fract()
}

fn direction(index: u32) -> DVec3 {
    let z = 2.0 * unit(index, 3) - 1.0;
    let (sine, cosine) = (2.0 * PI * unit(index, 4)).sin_cos();
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * cosine, across * sine, z)
}

/// Points and disks in turn, anywhere in the box `[-2, 2]² × [0.05, 2]`, of very different strengths.
fn mixed_lights(count: u32, visible: bool) -> Vec<Light> {
    let light = |index| {
        let place = DVec3::new(
            4.0 * unit(index, 0) - 2.0,
            4.0 * unit(index, 1) - 2.0,
            0.05 + 1.95 * unit(index, 2),
        );
        let strength = Rgb::splat(unit(index, 5).powi(4) + 0.01);
        if index % 2 == 0 {
            Light::Point {
                position: place,
                intensity: strength * 0.01,
            }
        } else {
            Light::Disk {
                center: place,
                facing: Facing::Normal(direction(index)),
                radius: 0.01 + 0.05 * unit(index, 3),
                radiance: strength,
                visible,
            }
        }
    };
    (0..count).map(light).collect()
}

/// The value of the only pixel over 64 seeds: its mean, and the variance of that.
fn mean_and_variance(scene: &mut Scene) -> (f64, f64) {
    let values: Vec<f64> = (0..64)
        .map(|seed| {
            scene.render.seed = seed;
            value(scene)
        })
        .collect();
    let mean = values.iter().sum::<f64>() / 64.0;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 63.0;
    (mean, variance / 64.0)
}

/// The sum of all lights, 32 at a time, of which each is summed exactly.
fn sum_and_variance(scene: &Scene, samples: u32) -> (f64, f64) {
    let mut total = (0.0, 0.0);
    for lights in scene.lights.chunks(32) {
        let mut part = Scene {
            lights: lights.to_vec(),
            ..scene.clone()
        };
        part.render.mode = Mode::Direct;
        part.render.samples_per_pixel = samples;
        let (mean, variance) = mean_and_variance(&mut part);
        total = (total.0 + mean, total.1 + variance);
    }
    total
}

#[track_caller]
fn assert_within_four_sigma(a: (f64, f64), b: (f64, f64), what: &str) {
    let sigma = (a.1 + b.1).sqrt();
    assert!(
        (a.0 - b.0).abs() < 4.0 * sigma,
        "{what}: {} and {}, σ = {sigma}",
        a.0,
        b.0
    );
    assert!(sigma < 0.02 * a.0, "{what}: σ = {sigma} of {}", a.0);
}

/// A thousand lights over a floor and over slopes among them, seen by no ray, against the sum of all.
#[test]
fn the_choice_among_a_thousand_lights_is_as_bright_as_their_sum() {
    for (x, tilt) in [(0.0, 0.0), (0.7, 0.0), (-1.1, 0.8), (0.3, -1.3)] {
        let mut scene = looking_at_floor(x, diffuse(0.8));
        // Turned about the point that is seen, in part among the lights and in part below them.
        let along = DVec3::new(f64::cos(tilt), 0.0, f64::sin(tilt));
        let mesh = rectangle(DVec3::X * x, along * 3.0, DVec3::Y * 3.0);
        scene.meshes.insert("floor".into(), Arc::new(mesh));
        scene.lights = mixed_lights(1000, false);
        scene.camera.eye = DVec3::new(x, 0.0, 0.0) + DVec3::new(-along.z, -2.0, along.x) * 0.01;
        let sum = sum_and_variance(&scene, 4);
        for mode in [Mode::Direct, Mode::Path] {
            scene.render.mode = mode;
            scene.render.max_bounces = 1;
            scene.render.samples_per_pixel = 1024;
            let chosen = mean_and_variance(&mut scene);
            let what = format!("{mode:?} at {x}, tilted by {tilt}");
            assert_within_four_sigma(sum, chosen, &what);
        }
    }
}

/// Just below a ceiling of a hundred wide disks, where sampling their areas alone is noisy; by their centres too.
#[test]
fn near_disks_among_many_are_as_bright_as_their_sum() {
    let mut scene = looking_at_floor(0.13, diffuse(0.8));
    scene.camera.eye.z = 0.02;
    for index in 0..100 {
        let (column, row) = (f64::from(index % 10), f64::from(index / 10));
        scene.lights.push(Light::Disk {
            center: DVec3::new(0.4 * column - 1.8, 0.4 * row - 1.8, 0.05),
            facing: Facing::Normal(-DVec3::Z),
            radius: 0.19,
            radiance: Rgb::ONE,
            visible: false,
        });
    }
    for shadows in [Shadows::Soft, Shadows::Hard] {
        scene.render.shadows = shadows;
        let sum = sum_and_variance(&scene, 128);
        scene.render.samples_per_pixel = 256;
        let chosen = mean_and_variance(&mut scene);
        assert_within_four_sigma(sum, chosen, &format!("{shadows:?}"));
        // Of 4096 single samples none stands out.
        scene.render.width = 64;
        scene.render.height = 64;
        scene.render.samples_per_pixel = 1;
        let image = picture(&scene);
        let brightest = image
            .pixels
            .iter()
            .map(|pixel| pixel[0])
            .fold(0.0, f32::max);
        assert!(
            f64::from(brightest) < 8.0 * sum.0,
            "{shadows:?}: {brightest} of {}",
            sum.0
        );
        scene.render.width = 1;
        scene.render.height = 1;
    }
}

/// Hard shadows of chosen disks are those of points: no other disk's size or sample matters, and behind a plate is darkness.
#[test]
fn hard_shadows_of_many_disks_are_sharp() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    for _ in 0..40 {
        scene.lights.push(Light::Disk {
            center: DVec3::Z * 2.0,
            facing: Facing::Normal(-DVec3::Z),
            radius: 0.5,
            radiance: Rgb::ONE,
            visible: false,
        });
    }
    scene.render.shadows = Shadows::Hard;
    scene.render.samples_per_pixel = 4;
    let expected = 40.0 * 0.25 / 4.0;
    common::assert_near(value(&scene), expected, 1e-4, "forty times L·A/d²·1/π");
    let plate = rectangle(DVec3::Z, DVec3::X * 0.01, DVec3::Y * 0.01);
    add(&mut scene, "plate", plate, diffuse(1.0));
    assert_eq!(picture(&scene).pixel(0, 0), [0.0; 3]);
}

#[test]
fn every_way_of_finding_many_lights_finds_the_same() {
    let mut base = Scene::default();
    let shiny = Material::Phong {
        diffuse: Rgb::splat(0.4),
        specular: Rgb::splat(0.4),
        shininess: 10.0,
        textures: Textures::default(),
    };
    add(
        &mut base,
        "floor",
        rectangle(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0),
        shiny,
    );
    add(
        &mut base,
        "wall",
        rectangle(DVec3::new(0.0, 1.5, 1.0), DVec3::X * 2.0, DVec3::Z),
        diffuse(0.7),
    );
    base.camera = Camera {
        eye: DVec3::new(1.0, -4.0, 2.0),
        target: DVec3::Z * 0.5,
        ..Camera::default()
    };
    base.render = RenderSettings {
        mode: Mode::Path,
        width: 4,
        height: 4,
        samples_per_pixel: 128,
        max_bounces: 3,
        ..RenderSettings::default()
    };
    // 5120 emitting triangles.
    let mut mesh = base.clone();
    let ball = shapes::icosphere(4);
    let ball = TriangleMesh {
        positions: ball
            .positions
            .iter()
            .map(|p| *p * DVec3::new(0.6, 0.3, 0.3) + DVec3::new(0.2, 0.3, 0.8))
            .collect(),
        ..ball
    };
    add(&mut mesh, "lamp", ball, Material::emitter());
    let mut disks = base;
    disks.lights = (0..100)
        .map(|index| Light::Disk {
            center: DVec3::new(
                3.0 * unit(index, 0) - 1.5,
                2.5 * unit(index, 1) - 1.5,
                0.3 + unit(index, 2),
            ),
            facing: Facing::Normal(direction(index) - DVec3::Z * 0.5),
            radius: 0.15,
            radiance: Rgb::splat(1.0 + unit(index, 5)),
            visible: true,
        })
        .collect();

    for (name, mut scene) in [("mesh", mesh), ("disks", disks)] {
        assert_ways_agree(&mut scene, name);
    }
}

/// What a sample costs does not grow with the number of lights beyond those that are summed.
#[test]
fn ten_thousand_lights_take_eight_rays_per_sample() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    let points = |count: u32| -> Vec<Light> {
        (0..count)
            .map(|index| Light::Point {
                position: DVec3::new(unit(index, 0), unit(index, 1), 1.0),
                intensity: Rgb::splat(0.01),
            })
            .collect()
    };
    scene.render.samples_per_pixel = 16;
    for (count, rays) in [(32, 32), (33, 8), (10_000, 8)] {
        scene.lights = points(count);
        assert_eq!(run(&scene).stats.rays.shadow, 16 * rays, "{count} lights");
        scene.render.shadow_samples = 3;
        // A point is summed once, whatever is asked; of chosen ones there are more.
        let rays = if count == 32 { 32 } else { 24 };
        assert_eq!(run(&scene).stats.rays.shadow, 16 * rays, "{count} lights");
        scene.render.shadow_samples = 1;
    }
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1;
    for count in [1, 32, 33, 10_000] {
        scene.lights = points(count);
        assert_eq!(run(&scene).stats.rays.shadow, 16, "{count} lights");
    }
}
