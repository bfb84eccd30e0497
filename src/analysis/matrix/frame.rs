//! Scenes of every size, near to the origin and far from it: what rendering takes out by centring and scaling.

use super::stage::{
    add, assert_shows_something, different_pixels, largest, mapped, matt, picture, rectangle,
    showroom, still, visibly_different,
};
use super::{Bar, Case, Effort};
use crate::analysis::hazards::{self, HazardKind};
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::geometry::shapes;
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
    Case {
        name: "digits lost before",
        tried: "balls moved off by up to 1e6 of their sizes, stored in single and in double precision: examinations that do not tell them apart",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: lost_digits,
    },
    Case {
        name: "small and far from the middle",
        tried: "a ball off the middle of a ground 1e2 to 1e7 times its size: examinations that do not name what is crushed, or name what is not",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: crushed,
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

/// `scene` with every place mapped by `place`, which makes lengths `factor` times as large.
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
        assert_shows_something(&base);
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
        [1e3, 1e4, 1e5, 1e6, 1e7]
            .map(|distance| placed(scene, 1.0, |p| p + AWAY * distance))
            .into()
    })
}

/// Which way scenes are moved, by a little more than their size.
const AWAY: DVec3 = DVec3::new(8.0, -5.6, 2.4);

fn largest_difference(changed: impl Fn(&Scene) -> Vec<Scene>) -> f64 {
    largest(scenes().iter().map(|scene| {
        let base = picture(scene);
        assert_shows_something(&base);
        let scenes = changed(scene).into_iter();
        largest(scenes.map(|scene| visibly_different(&base, &picture(&scene), 1.0)))
    }))
}

/// Whether the examination of `scene` finds something of `kind`.
fn is_told(scene: &Scene, kind: HazardKind) -> bool {
    let hazards = hazards::examine(scene, &CancelToken::new());
    let hazards = hazards.unwrap_or_else(|error| panic!("cannot be rendered: {error}"));
    let hazards = hazards.expect("nobody cancels");
    hazards.iter().any(|hazard| hazard.kind == kind)
}

fn lost_digits(_: Effort) -> f64 {
    let mut wrong = 0;
    for distance in [1.0, 1e5, 1e6] {
        let far = mapped(shapes::icosphere(3), |p| {
            p + DVec3::new(2.0, -1.4, 0.6) * distance
        });
        let rounded = mapped(far.clone(), |p| p.as_vec3().as_dvec3());
        for (mesh, has_lost) in [(far, false), (rounded, distance > 1.0)] {
            let mut scene = still(16, 12);
            scene.camera.target = mesh.bounds().center();
            scene.camera.eye = scene.camera.target + DVec3::new(0.0, -6.0, 2.5);
            add(&mut scene, "ball", mesh, matt(0.5));
            wrong += u32::from(is_told(&scene, HazardKind::LostDigits) != has_lost);
        }
    }
    f64::from(wrong)
}

fn crushed(_: Effort) -> f64 {
    let mut wrong = 0;
    for (size, is_crushed) in [(1e2, false), (1e3, false), (1e6, true), (1e7, true)] {
        let place = DVec3::new(size / 3.0, size / 4.0, 1.0);
        let mut scene = still(16, 12);
        let (u, v) = (DVec3::X * size, DVec3::Y * size);
        add(
            &mut scene,
            "ground",
            rectangle(DVec3::ZERO, u, v),
            matt(0.5),
        );
        let ball = mapped(shapes::icosphere(3), |p| p + place);
        add(&mut scene, "ball", ball, matt(0.5));
        scene.camera.target = place;
        scene.camera.eye = place + DVec3::new(0.0, -6.0, 2.5);
        wrong += u32::from(is_told(&scene, HazardKind::CoarseResolution) != is_crushed);
    }
    f64::from(wrong)
}

/// That the figures notice what they are there for.
#[cfg(test)]
mod controls {
    use super::*;

    /// What a program sees of a moved scene that reads places in single precision.
    #[test]
    fn places_rounded_after_moving_are_noticed() {
        let difference = largest_difference(|scene| {
            let rounded = |p: DVec3| (p + AWAY * 1e5).as_vec3().as_dvec3();
            vec![placed(scene, 1.0, rounded)]
        });
        let case = CASES
            .iter()
            .find(|case| case.name.contains("off the origin"));
        let bar = case.expect("is there").bar;
        assert!(!bar.is_kept_by(difference), "{difference} % differ");
    }
}
