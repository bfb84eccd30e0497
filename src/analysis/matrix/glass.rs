//! Glass from a single face to a thousand, of every index.

use super::stage::{
    add, glass, improper_pixels, largest, mean_over_seeds, picture, rectangle, run, showroom,
    still, white,
};
use super::{Bar, Case, Effort};
use crate::geometry::{TriangleMesh, shapes};
use crate::math::{DVec3, Degrees};
use crate::render::fresnel;
use crate::scene::{Camera, Material, Mode, Rgb, Scene};

pub const CASES: &[Case] = &[
    Case {
        name: "1,000 faces of glass",
        tried: "light through 2, 10, 100 and 1,000 faces against (1−R)/(1+(M−1)R): distance in standard errors",
        bar: Bar::AtMost(4.0),
        is_timed: false,
        measure: through_a_stack,
    },
    Case {
        name: "rays through 1,000 faces",
        tried: "rays of a sample of that stack, per face",
        bar: Bar::AtMost(2.0),
        is_timed: false,
        measure: rays_through_a_stack,
    },
    Case {
        name: "what a depth cap cuts off is told",
        tried: "10 faces between a lamp and a white world at 1 to 100 bounces: samples that lack light without being counted, or are counted and lack none",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: told_depth_cap,
    },
    Case {
        name: "index 1",
        tried: "a ball of index 1 against none, modes direct and path: largest difference in units in the last place",
        bar: Bar::AtMost(2.0),
        is_timed: false,
        measure: index_of_one,
    },
    Case {
        name: "index 1/1000 to 1000",
        tried: "light from one face at 0° to 80° against Fresnel's equations: distance in standard errors; 1 where all is reflected",
        bar: Bar::AtMost(4.0),
        is_timed: false,
        measure: every_index,
    },
    Case {
        name: "critical angle",
        tried: "1,000 units in the last place of the cosine to both sides: largest fall of the reflectance on the way",
        bar: Bar::AtMost(1e-3),
        is_timed: false,
        measure: critical_angle,
    },
    Case {
        name: "glass in a white furnace",
        tried: "a ball of glass in light from everywhere, seen from outside: largest difference from none",
        bar: Bar::AtMost(1e-5),
        is_timed: false,
        measure: white_furnace,
    },
];

/// The eye looks straight down through `faces` faces of glass at a lamp of radiance 1.
fn stack(faces: u32) -> Scene {
    let mut scene = still(1, 1);
    let face = |number: u32| {
        let height = f64::from(number) * 1e-2;
        let mut face = rectangle(DVec3::Z * height, DVec3::X * 9.0, DVec3::Y * 9.0);
        if number.is_multiple_of(2) {
            // The undersides of the plates face down.
            face.triangles
                .iter_mut()
                .for_each(|corners| corners.swap(1, 2));
        }
        face
    };
    let plates: TriangleMesh = super::stage::joined((0..faces).map(face));
    add(&mut scene, "plates", plates, glass(1.5));
    let lamp = rectangle(DVec3::NEG_Z, DVec3::X * 9.0, DVec3::Y * 9.0);
    add(
        &mut scene,
        "lamp",
        lamp,
        Material::Emitter { radiance: Rgb::ONE },
    );
    scene.camera = Camera {
        eye: DVec3::Z * 30.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        vertical_fov: Degrees(1e-3),
        ..Camera::default()
    };
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 100_000;
    scene
}

fn through_a_stack(effort: Effort) -> f64 {
    largest([2, 10, 100, 1000].map(|faces| {
        let mut scene = stack(faces);
        scene.render.samples_per_pixel = effort.pick(256, 8192);
        let (mean, error) = mean_over_seeds(&mut scene, 16);
        let reflectance = 0.04;
        let expected = (1.0 - reflectance) / (1.0 + f64::from(faces - 1) * reflectance);
        (mean - expected).abs() / error
    }))
}

fn rays_through_a_stack(_: Effort) -> f64 {
    let mut scene = stack(1000);
    scene.render.samples_per_pixel = 1024;
    let rays = run(&scene).stats.rays;
    rays.bounce as f64 / rays.camera as f64 / 1000.0
}

fn told_depth_cap(_: Effort) -> f64 {
    let mut scene = stack(10);
    // Every path that is not cut off ends in a radiance of 1, at the lamp or in the world.
    scene.background = white();
    scene.render.samples_per_pixel = 1024;
    scene.render.roulette = false;
    let mut wrong = 0.0;
    let mut told = Vec::new();
    for bounces in [1, 8, 12, 100] {
        scene.render.max_bounces = bounces;
        let outcome = run(&scene);
        let samples = f64::from(scene.render.samples_per_pixel);
        let lacking = samples * (1.0 - f64::from(outcome.image.pixel(0, 0)[0]));
        let counted = outcome.stats.depth_limited_samples as f64;
        wrong += (lacking.round() - counted).abs();
        told.push(counted);
    }
    assert!(told.is_sorted_by(|more, less| more > less), "{told:?}");
    wrong
}

fn index_of_one(_: Effort) -> f64 {
    largest([Mode::Direct, Mode::Path].map(|mode| {
        let mut scene = showroom(64, 48);
        scene.materials.insert("glass".into(), glass(1.0));
        scene.render.mode = mode;
        scene.render.samples_per_pixel = 4;
        let with = picture(&scene);
        scene.objects.retain(|object| object.name != "glass");
        let without = picture(&scene);
        let pairs = with
            .pixels
            .iter()
            .flatten()
            .zip(without.pixels.iter().flatten());
        largest(pairs.map(|(a, b)| f64::from(a.to_bits().abs_diff(b.to_bits()))))
    }))
}

/// Fresnel's equations for unpolarised light. Source: Born, Wolf, Principles of Optics, 7th edition, §1.5.2.
fn reflectance(cosine: f64, index: f64) -> f64 {
    let square = 1.0 - (1.0 - cosine * cosine) / (index * index);
    if square <= 0.0 {
        return 1.0;
    }
    let inside = square.sqrt();
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (index * cosine - inside) / (index * cosine + inside);
    f64::midpoint(s * s, p * p)
}

fn every_index(effort: Effort) -> f64 {
    let mut distances = Vec::new();
    for index in [1e3, 2.4, 1.5, 1.33, 1.0 / 1.5, 0.5, 1e-3] {
        for degrees in [0.0_f64, 20.0, 60.0, 80.0] {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let mut scene = still(1, 1);
            let face = rectangle(DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0);
            add(&mut scene, "face", face, glass(index));
            // A lamp over everything, behind the eye.
            let lamp = rectangle(DVec3::Z * 20.0, DVec3::X * 4e3, DVec3::Y * 4e3);
            let shining = Material::Emitter { radiance: Rgb::ONE };
            add(&mut scene, "lamp", lamp, shining);
            scene.camera = Camera {
                eye: DVec3::new(0.0, -sin, cos) * 8.0,
                target: DVec3::ZERO,
                up: DVec3::new(0.0, cos, sin),
                vertical_fov: Degrees(1e-4),
                ..Camera::default()
            };
            scene.render.mode = Mode::Path;
            scene.render.samples_per_pixel = effort.pick(1 << 12, 1 << 16);
            let found = f64::from(picture(&scene).pixel(0, 0)[0]);
            let expected = reflectance(cos, index);
            distances.push(standard_errors(
                found,
                expected,
                scene.render.samples_per_pixel,
            ));
        }
    }
    largest(distances)
}

/// How far the mean of so many samples of 0 and 1 is from what it should be.
fn standard_errors(found: f64, expected: f64, samples: u32) -> f64 {
    if found == expected {
        return 0.0;
    }
    (found - expected).abs() / (expected * (1.0 - expected) / f64::from(samples)).sqrt()
}

fn critical_angle(_: Effort) -> f64 {
    let index = 1.0_f32 / 1.5;
    let critical = (1.0 - index * index).sqrt();
    let mut cosine = (0..1000).fold(critical, |cosine, _| cosine.next_up());
    let (mut highest, mut fall) = (0.0_f32, 0.0_f32);
    for _ in 0..2000 {
        let found = fresnel(cosine, index).reflectance;
        assert!((0.0..=1.0).contains(&found), "{found} at {cosine}");
        highest = highest.max(found);
        fall = fall.max(highest - found);
        cosine = cosine.next_down();
    }
    assert_eq!(highest, 1.0, "all is reflected beyond the critical angle");
    f64::from(fall)
}

fn white_furnace(effort: Effort) -> f64 {
    let mut scene = still(32, 32);
    add(&mut scene, "ball", shapes::icosphere(4), glass(1.5));
    scene.objects[0].smooth = true;
    scene.background = white();
    scene.camera.vertical_fov = Degrees(25.0);
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1 << 16;
    scene.render.samples_per_pixel = effort.pick(16, 256);
    let image = picture(&scene);
    assert_eq!(improper_pixels(&image), 0.0);
    largest(
        image
            .pixels
            .iter()
            .flatten()
            .map(|&c| (f64::from(c) - 1.0).abs()),
    )
}

#[cfg(test)]
mod controls {
    use super::*;

    /// Source: Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994.
    #[test]
    fn an_approximation_of_fresnel_is_noticed() {
        let cosine = 0.5;
        let schlick = 0.04 + 0.96 * libm::pow(1.0 - cosine, 5.0);
        let distance = standard_errors(schlick, reflectance(cosine, 1.5), 1 << 12);
        assert!(distance > 4.0, "{distance}");
    }
}
