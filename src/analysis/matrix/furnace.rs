//! Closed rooms, where every lost or invented bit of light is repeated a thousand times.

use std::f64::consts::PI;

use super::stage::{
    add, largest, mapped, matt, mean_over_seeds, picture, point, relative, run, still,
};
use super::{Bar, Case, Effort};
use crate::geometry::shapes;
use crate::math::{DVec3, Degrees};
use crate::scene::{Camera, Light, Material, Mode, Rgb, Scene};

pub const CASES: &[Case] = &[
    Case {
        name: "albedo 0.999, 1,000 bounces",
        tried: "the light of a point in the middle of a matt ball, summed over 1,000 bounces: relative error",
        bar: Bar::AtMost(1e-3),
        is_timed: false,
        measure: thousand_bounces,
    },
    Case {
        name: "albedo 0.99 and more, roulette",
        tried: "the same without end, paths ended at random: distance from the sum of the series in standard errors, four of which are at most 3 % of it; with --long 1 %, but for 0.999",
        bar: Bar::AtMost(4.0),
        is_timed: false,
        measure: endless_bounces,
    },
    Case {
        name: "closed room without light",
        tried: "a closed box of albedo 1 in a bright world, paths of up to 1,000 bounces: brightest pixel",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: dark_room,
    },
    Case {
        name: "furnace without dark pixels",
        tried: "the inside of a rough closed body that shines, a picture from within: pixels that are not exactly 1",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: shining_body,
    },
];

/// A matt ball of radius 1 around a point light whose direct light leaves the wall with a radiance of `albedo`.
fn ball(albedo: f64, pixels: u32) -> Scene {
    let mut scene = still(pixels, pixels);
    add(&mut scene, "ball", shapes::icosphere(6), matt(albedo));
    scene.lights = vec![point(DVec3::ZERO, PI)];
    scene.camera = Camera {
        eye: DVec3::new(0.3, 0.2, 0.1),
        target: DVec3::X,
        vertical_fov: Degrees(90.0),
        ..Camera::default()
    };
    scene.render.mode = Mode::Path;
    scene
}

fn thousand_bounces(effort: Effort) -> f64 {
    let mut scene = ball(0.999, 4);
    scene.render.max_bounces = 1000;
    scene.render.roulette = false;
    scene.render.samples_per_pixel = effort.pick(16, 256);
    let image = picture(&scene);
    let sum: f64 = image.pixels.iter().map(|p| f64::from(p[0])).sum();
    let expected = 0.999 * (1.0 - libm::pow(0.999, 1000.0)) / 0.001;
    relative(sum / image.pixels.len() as f64, expected)
}

fn endless_bounces(effort: Effort) -> f64 {
    // Roulette leaves paths alone down to a half of what they began with, which then ends them like any albedo: the sum of a path is off
    // by about half of its mean, whatever the albedo. So 4 standard errors of n paths are 2 / √n of it, and each bound is some 1.8 times
    // that. The number of bounces goes with 1 / (1 − albedo): the last albedo has to do with fewer paths.
    let tried: &[(f64, u32, f64)] = effort.pick(
        &[(0.99, 32, 0.03)],
        &[
            (0.97, 256, 0.01),
            (0.98, 256, 0.01),
            (0.99, 256, 0.01),
            (0.995, 256, 0.01),
            (0.999, 32, 0.03),
        ],
    );
    largest(tried.iter().map(|&(albedo, samples, most_spread)| {
        let mut scene = ball(albedo, 4);
        scene.render.max_bounces = 1 << 20;
        scene.render.samples_per_pixel = samples;
        let (mean, error) = mean_over_seeds(&mut scene, 32);
        // The ball is made of triangles: its light is a little off that of a sphere, far less than the noise.
        let expected = albedo / (1.0 - albedo);
        let spread = 4.0 * error / expected;
        assert!(
            spread <= most_spread,
            "4 standard errors at albedo {albedo} are {spread} of the mean"
        );
        (mean - expected).abs() / error
    }))
}

fn dark_room(_: Effort) -> f64 {
    let mut scene = still(16, 16);
    let room = shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE);
    add(&mut scene, "room", room, matt(1.0));
    scene.background = super::stage::white();
    scene.lights = vec![Light::disk()];
    scene.lights[0].move_to(DVec3::Z * 3.0);
    scene.camera.eye = DVec3::new(0.3, -0.4, 0.1);
    scene.camera.target = DVec3::X;
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1000;
    scene.render.roulette = false;
    let outcome = run(&scene);
    let most = 1000 * outcome.stats.rays.camera;
    assert!(
        outcome.stats.rays.bounce <= most,
        "{:?}",
        outcome.stats.rays
    );
    largest(outcome.image.pixels.iter().map(|p| f64::from(p[0])))
}

fn shining_body(effort: Effort) -> f64 {
    let mut random = shapes::Random::new(5);
    let mesh = mapped(shapes::icosphere(4), |p| p * (0.5 + 0.5 * random.unit()));
    let mut scene = still(256, 256);
    let radiance = Rgb::ONE;
    add(&mut scene, "body", mesh, Material::Emitter { radiance });
    scene.camera = Camera {
        eye: DVec3::new(0.01, 0.02, 0.03),
        target: DVec3::X,
        vertical_fov: Degrees(150.0),
        ..Camera::default()
    };
    scene.render.samples_per_pixel = effort.pick(4, 256);
    let image = picture(&scene);
    image.pixels.iter().filter(|&&p| p != [1.0; 3]).count() as f64
}
