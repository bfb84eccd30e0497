//! Scenes of every size, near to the origin and far from it: what rendering takes out by centring and scaling.

use super::stage::{different_pixels, largest, mapped, picture, showroom, visibly_different};
use super::{Bar, Case, Effort};
use crate::geometry::TriangleMesh;
use crate::math::{DVec3, power_of_two};
use crate::scene::{Facing, Light, Material, Mode, Scene};
use std::sync::Arc;

pub const CASES: &[Case] = &[
    Case {
        name: "size times 2^±20 and 2^±60",
        tried: "a scene scaled with its camera and lights, modes direct, path and normals: pixels that are not the same bits",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: powers_of_two,
    },
    Case {
        name: "size times 1e±6",
        tried: "the same: pixels that differ visibly, in per cent",
        bar: Bar::AtMost(0.01),
        is_timed: false,
        measure: million_times,
    },
    Case {
        name: "size times 1e±20",
        tried: "the same: pixels that differ visibly, in per cent",
        bar: Bar::AtMost(0.01),
        is_timed: false,
        measure: far_beyond_single_precision,
    },
    Case {
        name: "1e3 to 1e7 sizes off the origin",
        tried: "a scene moved with its camera and lights: pixels that differ visibly, in per cent",
        bar: Bar::AtMost(0.1),
        is_timed: false,
        measure: moved_away,
    },
];

fn scenes() -> [Scene; 3] {
    [Mode::Direct, Mode::Path, Mode::Normals].map(|mode| {
        let mut scene = showroom(80, 60);
        scene.render.mode = mode;
        scene.render.samples_per_pixel = 2;
        let attenuation = DVec3::new(0.1, 0.4, 0.9);
        let glass = Material::Glass {
            ior: 1.5,
            attenuation,
        };
        scene.materials.insert("glass".into(), glass);
        scene
    })
}

/// `scene` with every place mapped, of which lengths grow by `factor`.
fn placed(scene: &Scene, factor: f64, place: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = scene.clone();
    let meshes = std::mem::take(&mut scene.meshes);
    let moved = |mesh: Arc<TriangleMesh>| Arc::new(mapped(Arc::unwrap_or_clone(mesh), &place));
    scene.meshes = meshes
        .into_iter()
        .map(|(name, mesh)| (name, moved(mesh)))
        .collect();
    scene.camera.eye = place(scene.camera.eye);
    scene.camera.target = place(scene.camera.target);
    scene.camera.aperture_radius *= factor;
    for light in &mut scene.lights {
        match light {
            Light::Point {
                position,
                intensity,
            } => {
                *position = place(*position);
                *intensity *= factor * factor;
            }
            Light::Disk {
                center,
                facing,
                radius,
                ..
            } => {
                *center = place(*center);
                if let Facing::Target(target) = facing {
                    *target = place(*target);
                }
                *radius *= factor;
            }
        }
    }
    for material in scene.materials.values_mut() {
        if let Material::Glass { attenuation, .. } = material {
            *attenuation /= factor;
        }
    }
    scene
}

fn scaled(scene: &Scene, factor: f64) -> Scene {
    placed(scene, factor, |p| p * factor)
}

fn powers_of_two(effort: Effort) -> f64 {
    let exponents: &[i32] = effort.pick(&[-60, -20, 20, 60], &[-60, -40, -20, -1, 1, 20, 40, 60]);
    let mut different = 0.0;
    for scene in scenes() {
        let base = picture(&scene);
        for &exponent in exponents {
            let scaled = picture(&scaled(&scene, power_of_two(exponent)));
            different += different_pixels(&base, &scaled);
        }
    }
    different
}

fn million_times(_: Effort) -> f64 {
    largest_difference(|scene| vec![scaled(scene, 1e-6), scaled(scene, 1e6)])
}

fn far_beyond_single_precision(_: Effort) -> f64 {
    largest_difference(|scene| vec![scaled(scene, 1e-20), scaled(scene, 1e20)])
}

fn moved_away(_: Effort) -> f64 {
    largest_difference(|scene| {
        let by = DVec3::new(8.0, -5.6, 2.4);
        let moved = |distance: f64| placed(scene, 1.0, |p| p + by * distance);
        [1e3, 1e4, 1e5, 1e6, 1e7].map(moved).into()
    })
}

fn largest_difference(changed: impl Fn(&Scene) -> Vec<Scene>) -> f64 {
    largest(scenes().iter().map(|scene| {
        let base = picture(scene);
        let scenes = changed(scene).into_iter();
        largest(scenes.map(|scene| visibly_different(&base, &picture(&scene), 1.0)))
    }))
}
