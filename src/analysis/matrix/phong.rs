//! Lobes from the widest to the narrowest.

use std::f64::consts::PI;

use super::stage::{largest, phong, point, relative, spot_of_floor, value, white};
use super::{Bar, Case, Effort};
use crate::math::{DVec3, Degrees};
use crate::scene::Mode;

pub const CASES: &[Case] = &[
    Case {
        name: "shininess 0",
        tried: "a lobe of exponent 0 under point lights around it, cut where it would lie below 0: largest relative error",
        bar: Bar::AtMost(1e-6),
        is_timed: false,
        measure: shininess_zero,
    },
    Case {
        name: "shininess 1 to 1e7",
        tried: "light of a white sky reflected at 0° to 85°, against the integral of the lobe: largest relative error",
        bar: Bar::AtMost(1e-3),
        is_timed: false,
        measure: reflected_light,
    },
    Case {
        name: "width of a lobe",
        tried: "exponents up to 1e7 lit from where the lobe falls to a half: largest relative error",
        bar: Bar::AtMost(1e-2),
        is_timed: false,
        measure: half_width,
    },
];

fn shininess_zero(_: Effort) -> f64 {
    let mut errors = Vec::new();
    for degrees in [0.0, 40.0, 75.0] {
        for light in [
            DVec3::new(0.3, 0.2, 2.0),
            DVec3::new(-3.0, 1.0, 1.0),
            DVec3::new(0.0, 4.0, 1.0),
            DVec3::new(0.0, -6.0, 0.7),
        ] {
            let mut scene = spot_of_floor(0.0, degrees, phong(0.0, 1.0, 0.0));
            scene.lights = vec![point(light, 1.0)];
            let eye = scene.camera.eye.normalize();
            let mirrored = DVec3::new(-eye.x, -eye.y, eye.z);
            let is_lit = light.dot(mirrored) > 0.0;
            let irradiance = light.normalize().z / light.length_squared();
            let found = value(&scene);
            errors.push(if is_lit {
                relative(found, irradiance / PI)
            } else {
                found
            });
        }
    }
    largest(errors)
}

/// The reflected share of light from everywhere. Source: `∫ (n+2)/(2π) cosⁿα cosθ dω` by quadrature in 50 digits.
const REFLECTED: [(f64, [f64; 4]); 6] = [
    // At 0°, 30°, 60° and 85°.
    (1.0, [1.0, 0.880_842_78, 0.608_997_78, 0.363_097_49]),
    (10.0, [1.0, 0.866_028_53, 0.504_735_95, 0.171_274_58]),
    (100.0, [1.0, 0.866_025_40, 0.5, 0.097_613_36]),
    (1e4, [1.0, 0.866_025_40, 0.5, 0.087_155_74]),
    (1e6, [1.0, 0.866_025_40, 0.5, 0.087_155_74]),
    (1e7, [1.0, 0.866_025_40, 0.5, 0.087_155_74]),
];

fn reflected_light(effort: Effort) -> f64 {
    let errors = REFLECTED.iter().flat_map(|&(shininess, expected)| {
        [0.0, 30.0, 60.0, 85.0]
            .into_iter()
            .zip(expected)
            .map(move |(degrees, expected)| {
                let mut scene = spot_of_floor(0.0, degrees, phong(0.0, 1.0, shininess));
                scene.background = white();
                scene.render.mode = Mode::Path;
                scene.render.max_bounces = 1;
                scene.render.samples_per_pixel = effort.pick(1 << 14, 1 << 18);
                relative(value(&scene), expected)
            })
    });
    largest(errors)
}

fn half_width(_: Effort) -> f64 {
    largest([1e2, 1e4, 1e6, 1e7].map(|shininess| {
        let angle = libm::acos(libm::pow(0.5, 1.0 / shininess));
        let mut scene = spot_of_floor(0.0, 0.0, phong(0.0, 1.0, shininess));
        let lit_from = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            point(DVec3::new(sin, 0.0, cos) * 5.0, 1.0)
        };
        // Narrower than the narrowest lobe is wide.
        scene.camera.vertical_fov = Degrees(1e-5);
        scene.lights = vec![lit_from(0.0)];
        let peak = value(&scene);
        scene.lights = vec![lit_from(angle)];
        relative(value(&scene) / peak, 0.5 * libm::cos(angle))
    }))
}
