//! Cameras of every angle and lens.

use std::f64::consts::PI;

use super::stage::{
    add, different_pixels, largest, picture, prepared, rectangle, showroom, still, value,
};
use super::{Bar, Case, Effort};
use crate::math::{DVec3, Degrees};
use crate::render::CameraRay;
use crate::scene::{Camera, Material, Mode, Rgb, Scene};

pub const CASES: &[Case] = &[
    Case {
        name: "field of view 0.001°",
        tried: "1,024 stripes, each as wide as a pixel, seen askew from afar: pixels that show another stripe",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: narrow_view,
    },
    Case {
        name: "field of view up to 179.9°",
        tried: "directions of pixels against the tangent formula: largest error in pixels",
        bar: Bar::AtMost(1e-3),
        is_timed: false,
        measure: wide_view,
    },
    Case {
        name: "the middle of a picture",
        tried: "fields of view of 0.001° to 179.9°, an even and an odd number of pixels: angle between the ray through the middle and the axis of the view, in radians",
        bar: Bar::AtMost(1e-7),
        is_timed: false,
        measure: middle_of_view,
    },
    Case {
        name: "aperture 0",
        tried: "a lens of radius 0 against the pinhole: pixels that are not the same bits",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: closed_aperture,
    },
    Case {
        name: "blur of a lens",
        tried: "an edge through lenses of radius 1e-3 to 1e3, focused at 5 and at infinity, against the area of the cut disk: largest error",
        bar: Bar::AtMost(5e-3),
        is_timed: false,
        measure: blurred_edge,
    },
];

/// How many pixels show another colour than they should, where each of 1024 stripes fills one of them, in a view a millionth of a degree
/// high.
fn narrow_view(_: Effort) -> f64 {
    let width = 1024;
    let mut scene = still(width, 1);
    let forward = DVec3::new(0.48, 0.6, 0.64);
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let fov = Degrees(0.001_f64 / f64::from(width));
    // So far that a pixel is one unit wide.
    let far = 0.5 / libm::tan(fov.radians() / 2.0);
    for number in 0..width {
        let across = f64::from(number) + 0.5 - f64::from(width) / 2.0;
        let stripe = rectangle(right * across, right * 0.5, up * 2.0);
        let shade = f64::from(number % 7) / 8.0;
        let radiance = Rgb::new(
            shade,
            f64::from(number % 11) / 16.0,
            f64::from(number % 13) / 16.0,
        );
        add(
            &mut scene,
            &format!("stripe {number}"),
            stripe,
            Material::Emitter { radiance },
        );
    }
    scene.camera = Camera {
        eye: forward * -far,
        target: DVec3::ZERO,
        up,
        vertical_fov: fov,
        ..Camera::default()
    };
    let image = picture(&scene);
    let is_wrong = |number: &u32| {
        let expected =
            [number % 7 * 2, number % 11, number % 13].map(|share| f64::from(share) / 16.0);
        image.pixel(*number, 0).map(f64::from) != expected
    };
    (0..width).filter(is_wrong).count() as f64
}

fn wide_view(_: Effort) -> f64 {
    let (width, height) = (64, 48);
    let mut errors = Vec::new();
    for fov in [1e-3, 1.0, 40.0, 120.0, 179.0, 179.9] {
        let mut scene = showroom(width, height);
        scene.camera.aperture_radius = 0.0;
        scene.camera.vertical_fov = Degrees(fov);
        let prepared = prepared(&scene);
        let axes = scene.camera.axes().expect("a direction");
        let half = libm::tan(Degrees(fov).radians() / 2.0);
        let frame = *prepared.geometry().frame();
        for (x, y) in [(0.5, 0.5), (32.0, 24.0), (63.5, 24.0), (63.5, 47.5)] {
            let pixel = half / (f64::from(height) / 2.0);
            let expected = [x - f64::from(width) / 2.0, f64::from(height) / 2.0 - y];
            // Where it meets the plane of the picture, in pixels.
            let off = |v: DVec3| {
                let depth = v.dot(axes.forward);
                let [across, along] = [axes.right, axes.up].map(|axis| v.dot(axis) / depth / pixel);
                (across - expected[0]).hypot(along - expected[1])
            };
            errors.push(off(prepared.camera().direction(x, y)));
            // The ray that rendering traces, as far as the target is, where pixels are wider than single precision there.
            if let Some(CameraRay { ray, .. }) = prepared.camera().ray(x, y)
                && fov >= 1.0
            {
                let direction = ray.direction.as_dvec3().normalize();
                let reach = (scene.camera.target - scene.camera.eye).length() * frame.scale();
                let far = frame.world_from_prepared(ray.origin.as_dvec3() + direction * reach);
                errors.push(off(far - scene.camera.eye));
            }
        }
    }
    assert!(errors.len() > 30, "rays meet the scene's box");
    largest(errors)
}

fn middle_of_view(_: Effort) -> f64 {
    let mut angles = Vec::new();
    for (width, height) in [(64, 48), (63, 47)] {
        for fov in [1e-3, 1.0, 40.0, 120.0, 179.0, 179.9] {
            let mut scene = showroom(width, height);
            scene.camera.aperture_radius = 0.0;
            scene.camera.vertical_fov = Degrees(fov);
            let prepared = prepared(&scene);
            let axis = scene.camera.target - scene.camera.eye;
            let angle = |v: DVec3| libm::atan2(v.cross(axis).length(), v.dot(axis));
            let (x, y) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
            angles.push(angle(prepared.camera().direction(x, y)));
            let ray = prepared.camera().ray(x, y).expect("meets the objects");
            angles.push(angle(ray.ray.direction.as_dvec3()));
        }
    }
    largest(angles)
}

fn closed_aperture(_: Effort) -> f64 {
    let mut scene = showroom(64, 48);
    scene.render.samples_per_pixel = 4;
    scene.render.depth_of_field = false;
    let pinhole = picture(&scene);
    scene.render.depth_of_field = true;
    let mut different = 0.0;
    for aperture in [0.0, 1e-300] {
        scene.camera.aperture_radius = aperture;
        different += different_pixels(&pinhole, &picture(&scene));
    }
    different
}

/// The share of a unit disk beyond a line at distance `c` from its middle.
fn segment(c: f64) -> f64 {
    if c >= 1.0 {
        return 0.0;
    }
    if c <= -1.0 {
        return 1.0;
    }
    (libm::acos(c) - c * (1.0 - c * c).sqrt()) / PI
}

fn blurred_edge(effort: Effort) -> f64 {
    let mut errors = Vec::new();
    for aperture in [1e-3, 0.1, 10.0, 1e3] {
        for focus in [5.0, f64::INFINITY] {
            for depth in [2.0, 4.0, 10.0, 50.0] {
                for share in [-0.8, -0.3, 0.0, 0.5, 0.9] {
                    // A ray from `a` on the lens to the focus on the axis is at `a (1 − depth/focus)`.
                    let spread = aperture * (1.0 - depth / focus);
                    let edge = share * spread.abs();
                    let scene = lamp_beyond(edge, depth, spread.abs(), aperture, focus, effort);
                    errors.push((value(&scene) - segment(share)).abs());
                }
            }
        }
    }
    largest(errors)
}

/// The eye at the origin looks along +Y at a lamp that fills `x > edge` at `y = depth`.
fn lamp_beyond(
    edge: f64,
    depth: f64,
    spread: f64,
    aperture: f64,
    focus: f64,
    effort: Effort,
) -> Scene {
    let mut scene = still(1, 1);
    let reach = 3.0 * spread;
    let center = DVec3::new(edge + reach, depth, 0.0);
    let lamp = rectangle(center, DVec3::X * reach, DVec3::Z * reach);
    add(
        &mut scene,
        "lamp",
        lamp,
        Material::Emitter { radiance: Rgb::ONE },
    );
    scene.camera = Camera {
        eye: DVec3::ZERO,
        target: DVec3::Y * depth,
        up: DVec3::Z,
        vertical_fov: Degrees(1e-6),
        aperture_radius: aperture,
        focus_distance: Some(focus),
    };
    scene.render.mode = Mode::Direct;
    scene.render.samples_per_pixel = effort.pick(1 << 12, 1 << 16);
    scene
}
