//! Lights with area, occlusion, mirrors, glass and the lens against their closed forms.
//!
//! Sequences are fixed by seeds. Tolerances are several times the error that the stated number of samples leaves.

use std::f64::consts::PI;

use crate::common::{add, assert_near, diffuse, looking_at_floor, picture, rectangle, run, value};
use raymini::control::CancelToken;
use raymini::math::{DVec3, Degrees};
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{
    AcceleratorChoice, AmbientOcclusion, Background, Camera, Facing, Light, LightSampling,
    Material, Mode, RenderSettings, Rgb, SamplerChoice, Scene, Shadows,
};

fn disk(center: DVec3, radius: f64) -> Light {
    Light::Disk {
        center,
        facing: Facing::Normal(-DVec3::Z),
        radius,
        radiance: Rgb::ONE,
        visible: true,
    }
}

/// Irradiance of a disk of radiance 1 on a parallel receiver (the view factor of a disk).
fn disk_irradiance(radius: f64, height: f64, offset: f64) -> f64 {
    let (r2, h2, a2) = (radius * radius, height * height, offset * offset);
    let root = ((a2 + h2 + r2).powi(2) - 4.0 * a2 * r2).sqrt();
    PI / 2.0 * (1.0 - (a2 + h2 - r2) / root)
}

#[test]
fn a_disk_light_gives_the_irradiance_of_the_formula_near_and_far() {
    let cases = [
        (1.0, 1.0, 0.0),
        (1.0, 2.0, 0.0),
        (1.0, 1.0, 0.5),
        (1.0, 1.0, 2.0),
        (0.5, 2.0, 1.0),
        (0.1, 1.0, 0.3),
        (10.0, 0.5, 3.0),
        (1.0, 0.01, 0.0),
        (1.0, 0.1, 0.99),
        (1e-6, 1.0, 0.5),
    ];
    for (radius, height, offset) in cases {
        let mut scene = looking_at_floor(offset, diffuse(1.0));
        scene.lights.push(disk(DVec3::Z * height, radius));
        // The eye must look past the disk.
        if height < 0.2 {
            scene.camera.eye = DVec3::new(offset, -8.0, height / 100.0);
        }
        let expected = disk_irradiance(radius, height, offset) / PI;
        assert_near(
            value(&scene),
            expected,
            2e-3,
            &format!("R {radius}, h {height}, a {offset}"),
        );
    }
    // Published values of the same table, so that a slip in the formula above is seen.
    assert_near(disk_irradiance(1.0, 1.0, 0.5), 1.375_963_021, 1e-9, "table");
    assert_near(
        disk_irradiance(1.0, 0.1, 0.99),
        1.648_455_661,
        1e-9,
        "table",
    );
}

/// Where only aiming finds the light, of a disk far larger than its distance: its area alone would hide nearly all of it.
#[test]
fn a_near_disk_that_no_path_meets_gives_its_light() {
    for (radius, height) in [(1.0, 0.1), (1.0, 1e-3), (1.0, 1e-5), (1e3, 1.0)] {
        let mut scene = looking_at_floor(0.0, diffuse(1.0));
        scene.render.mode = Mode::Path;
        scene.render.max_bounces = 1;
        let mut light = disk(DVec3::Z * height, radius);
        if let Light::Disk { visible, .. } = &mut light {
            *visible = false;
        }
        scene.lights.push(light);
        let expected = disk_irradiance(radius, height, 0.0) / PI;
        assert_near(
            value(&scene),
            expected,
            1e-2,
            &format!("R {radius}, h {height}"),
        );
    }
}

/// Over all of a floor, however far beyond it the disk goes: what is rounded at its rim must not count where it is near.
#[test]
fn a_disk_far_larger_than_the_scene_lights_it_as_a_sky() {
    for radius in [1e3, 1e5, 1e7, 1e10] {
        for (mode, visible) in [
            (Mode::Direct, true),
            (Mode::Direct, false),
            (Mode::Path, true),
            (Mode::Path, false),
        ] {
            let mut scene = looking_at_floor(0.0, diffuse(0.5));
            scene.render.mode = mode;
            scene.render.max_bounces = 1;
            let mut light = disk(DVec3::Z, radius);
            if let Light::Disk { visible: seen, .. } = &mut light {
                *seen = visible;
            }
            scene.lights.push(light);
            let what = format!("{mode:?}, R {radius}, visible: {visible}");
            assert_near(value(&scene), 0.5, 1e-2, &what);
        }
    }
}

#[test]
fn the_back_of_a_disk_gives_nothing() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    scene.lights.push(Light::Disk {
        center: DVec3::Z,
        facing: Facing::Normal(DVec3::Z),
        radius: 1.0,
        radiance: Rgb::ONE,
        visible: false,
    });
    let outcome = run(&scene);
    assert_eq!(outcome.image.pixel(0, 0), [0.0; 3]);
    assert_eq!(outcome.stats.rays.shadow, 0);
}

/// Adds a half plane at height 1 that ends above x = 0.
fn add_edge(scene: &mut Scene) {
    let plate = rectangle(
        DVec3::new(-10.0, 0.0, 1.0),
        DVec3::X * 10.0,
        DVec3::Y * 20.0,
    );
    add(scene, "edge", plate, diffuse(1.0));
}

/// A half-plane edge at height 1 under a disk of radius 1 at height 4; the physical irradiance.
#[test]
fn the_penumbra_of_an_edge_has_its_profile() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    add_edge(&mut scene);
    scene.lights.push(disk(DVec3::Z * 4.0, 1.0));
    scene.render.samples_per_pixel = 1 << 15;
    let cases = [
        (-0.25, 0.012_109_184),
        (-0.1, 0.056_151_216),
        (0.0, 0.092_399_784),
        (0.1, 0.128_443_889),
        (0.25, 0.171_417_692),
    ];
    for (x, irradiance) in cases {
        scene.camera.target.x = x;
        scene.camera.eye.x = x;
        assert_near(value(&scene), irradiance / PI, 4e-3, &format!("x = {x}"));
    }
    // Outside the penumbra nothing is left to chance.
    scene.render.samples_per_pixel = 16;
    scene.camera.target.x = -0.34;
    scene.camera.eye.x = -0.34;
    assert_eq!(picture(&scene).pixel(0, 0), [0.0; 3]);
}

/// The same edge under the rule of 2011: the unoccluded irradiance of the disk's centre, times the free fraction.
#[test]
fn the_rule_of_2011_has_its_own_penumbra() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    add_edge(&mut scene);
    scene.lights.push(disk(DVec3::Z * 4.0, 1.0));
    scene.render.shadows = Shadows::Fraction;
    scene.render.samples_per_pixel = 1 << 13;
    scene.render.shadow_samples = 4;
    let cases: [(f64, f64); 5] = [
        (-0.25, 0.072_146_806),
        (-0.1, 0.311_918_832),
        (0.0, 0.5),
        (0.2, 0.857_621_510),
        (0.25, 0.927_853_194),
    ];
    for (x, fraction) in cases {
        scene.camera.target.x = x;
        scene.camera.eye.x = x;
        // A small disk's irradiance: π R² cos² θ / d², both cosines the same.
        let distance_squared = x * x + 16.0;
        let center = PI * 16.0 / distance_squared.powi(2);
        let expected = fraction * center / PI;
        assert_near(value(&scene), expected, 4e-3, &format!("x = {x}"));
    }
}

/// Error falls at least like N^−0.70 in the penumbra and N^−0.95 unoccluded.
#[test]
fn the_error_of_soft_shadows_falls_as_a_low_discrepancy_sequence_should() {
    let mut scene = looking_at_floor(0.1, diffuse(1.0));
    scene.lights.push(disk(DVec3::Z * 4.0, 1.0));
    let unoccluded = slope(&scene, disk_irradiance(1.0, 4.0, 0.1) / PI);
    add_edge(&mut scene);
    let penumbra = slope(&scene, 0.128_443_889 / PI);
    assert!(penumbra <= PENUMBRA_SLOPE, "penumbra: {penumbra}");
    assert!(unoccluded <= UNOCCLUDED_SLOPE, "unoccluded: {unoccluded}");
}

const PENUMBRA_SLOPE: f64 = -0.70;
const UNOCCLUDED_SLOPE: f64 = -0.95;

/// Independent samples: -0.5 for any integrand, within 0.1, which is four standard deviations of a slope over 100 seeds. Neither bar lets
/// that pass. It falls in the same way with shadow rays, which are independent within a sample too.
#[test]
fn the_error_of_independent_samples_falls_as_one_over_the_root() {
    let assert_is_half = |slope: f64, what: &str| {
        assert!((slope + 0.5).abs() < 0.1, "{what}: {slope}");
    };
    let mut scene = looking_at_floor(0.1, diffuse(1.0));
    scene.render.sampler = SamplerChoice::Independent;
    scene.lights.push(disk(DVec3::Z * 4.0, 1.0));
    let exact = disk_irradiance(1.0, 4.0, 0.1) / PI;
    assert_is_half(slope(&scene, exact), "unoccluded");
    let of_rays = slope_of(&[4, 16, 64, 256], 100, |rays, seed| {
        let mut scene = scene.clone();
        scene.render.samples_per_pixel = 4;
        scene.render.shadow_samples = rays;
        scene.render.seed = seed;
        value(&scene) - exact
    });
    assert_is_half(of_rays, "shadow rays");
    add_edge(&mut scene);
    assert_is_half(slope(&scene, 0.128_443_889 / PI), "penumbra");
}

/// Slope of log RMSE over log samples from 64 to 4096, over 100 seeds.
fn slope(scene: &Scene, exact: f64) -> f64 {
    slope_of(&[64, 256, 1024, 4096], 100, |samples, seed| {
        let mut scene = scene.clone();
        scene.render.samples_per_pixel = samples;
        scene.render.seed = seed;
        value(&scene) - exact
    })
}

/// Slope of log RMSE over log samples, of the error that a trial of so many samples finds.
fn slope_of(counts: &[u32], trials: u64, mut error: impl FnMut(u32, u64) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = counts
        .iter()
        .map(|&samples| {
            let squared = (0..trials).map(|trial| error(samples, trial).powi(2));
            let mean_square = squared.sum::<f64>() / trials as f64;
            (f64::from(samples).ln(), mean_square.sqrt().ln())
        })
        .collect();
    let n = points.len() as f64;
    let (mx, my) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
        / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// K bounces between parallel mirrors, then the emitter.
#[test]
fn parallel_mirrors_multiply_their_reflectance() {
    // The ray climbs between mirrors at x = 0 and x = 1 by a unit per crossing and leaves above height 9.5.
    let mut scene = Scene::default();
    let mirror = Material::Mirror {
        reflectance: Rgb::splat(0.9),
    };
    add(
        &mut scene,
        "left",
        rectangle(DVec3::new(0.0, 0.0, 5.0), DVec3::Y, DVec3::Z * 4.6),
        mirror.clone(),
    );
    add(
        &mut scene,
        "right",
        rectangle(DVec3::new(1.0, 0.0, 5.0), DVec3::Y, DVec3::Z * 4.6),
        mirror,
    );
    scene.background = Background::Constant { radiance: Rgb::ONE };
    scene.camera = Camera {
        eye: DVec3::new(0.5, 0.0, 0.0),
        target: DVec3::new(1.0, 0.0, 0.5),
        vertical_fov: Degrees(1e-4),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 1,
        height: 1,
        samples_per_pixel: 1,
        max_bounces: 20,
        ..RenderSettings::default()
    };
    // Heights of the hits: 0.5, 1.5, …, 9.5; those in 0.4..=9.6 are ten.
    assert_near(value(&scene), 0.348_678_440_1, 1e-5, "ten reflections");
    assert_eq!(run(&scene).stats.rays.bounce, 10);
    scene.render.max_bounces = 9;
    assert_eq!(picture(&scene).pixel(0, 0), [0.0; 3]);
    scene.render.mirror = false;
    assert!(
        value(&scene) > 0.0,
        "switched off, a mirror is grey and lit by the sky"
    );
    assert_eq!(run(&scene).stats.rays.bounce, 0);
}

#[test]
fn a_disk_in_the_plane_of_a_ceiling_gives_all_its_light() {
    for tilt in [0.0, 0.3] {
        let mut scene = looking_at_floor(0.5, diffuse(1.0));
        scene.render.samples_per_pixel = 256;
        let normal = DVec3::new(tilt, 0.1 * tilt, -1.0).normalize();
        let (u, v) = normal.any_orthonormal_pair();
        scene.lights.push(Light::Disk {
            center: DVec3::Z * 2.0,
            facing: Facing::Normal(normal),
            radius: 0.5,
            radiance: Rgb::ONE,
            visible: true,
        });
        let free = value(&scene);
        add(
            &mut scene,
            "ceiling",
            rectangle(DVec3::Z * 2.0, u * 3.0, v * 3.0),
            diffuse(1.0),
        );
        assert_near(value(&scene), free, 1e-3, &format!("tilted by {tilt}"));
    }
}

/// Near the floor, where light is also met: aiming and meeting must agree on what is in front, ceiling or lamp.
#[test]
fn a_near_disk_in_a_ceiling_is_met_and_aimed_at_alike() {
    for tilt in [0.0, 0.3] {
        for (mode, way) in [
            (Mode::Direct, LightSampling::Mis),
            (Mode::Path, LightSampling::Mis),
            (Mode::Path, LightSampling::Nee),
            (Mode::Path, LightSampling::Bsdf),
        ] {
            let mut scene = looking_at_floor(0.2, diffuse(1.0));
            scene.camera.eye.z = 0.05;
            scene.render.samples_per_pixel = 1 << 14;
            scene.render.mode = mode;
            scene.render.light_sampling = way;
            scene.render.max_bounces = 1;
            let normal = DVec3::new(tilt, 0.1 * tilt, -1.0).normalize();
            let (u, v) = normal.any_orthonormal_pair();
            let center = DVec3::new(0.13, -0.29, 0.77);
            scene.lights.push(Light::Disk {
                center,
                facing: Facing::Normal(normal),
                radius: 0.6,
                radiance: Rgb::ONE,
                visible: true,
            });
            let free = value(&scene);
            let ceiling = rectangle(center, u * 1.9, v * 1.9);
            add(&mut scene, "ceiling", ceiling, diffuse(1.0));
            assert_near(
                value(&scene),
                free,
                1e-3,
                &format!("{mode:?} {way:?} {tilt}"),
            );
        }
    }
}

/// Everything at once: the same bits on any number of threads and with any structure, in both modes.
#[test]
fn all_effects_together_give_the_same_bits() {
    let mut scene = Scene::default();
    add(
        &mut scene,
        "floor",
        rectangle(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0),
        diffuse(1.0),
    );
    add(
        &mut scene,
        "ball",
        raymini::geometry::shapes::icosphere(2),
        Material::glass(),
    );
    add(
        &mut scene,
        "mirror",
        rectangle(DVec3::new(0.0, 3.0, 1.0), DVec3::X * 3.0, DVec3::Z),
        Material::mirror(),
    );
    add(
        &mut scene,
        "lamp",
        rectangle(DVec3::new(2.0, 0.0, 2.0), DVec3::X * 0.3, DVec3::Y * 0.3),
        Material::emitter(),
    );
    scene.objects[1].translate = DVec3::Z * 1.1;
    scene.lights.push(disk(DVec3::new(-1.0, -1.0, 3.0), 0.4));
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.2),
    };
    scene.camera.aperture_radius = 0.05;
    scene.render = RenderSettings {
        width: 40,
        height: 30,
        samples_per_pixel: 8,
        ..RenderSettings::default()
    };
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        samples: 4,
        radius: 0.1,
    };
    for mode in [Mode::Direct, Mode::Path] {
        scene.render.mode = mode;
        scene.render.accelerator = AcceleratorChoice::KdTree;
        let hash = |scene: &Scene, threads: usize| {
            let prepared =
                PreparedScene::prepare(scene, None, &CancelToken::new()).expect("can be rendered");
            let prepared = prepared.expect("nobody cancels");
            let run = RunConfig {
                threads,
                ..RunConfig::default()
            };
            let outcome = render(&prepared, None, &run, &RenderProgress::default(), None);
            outcome.expect("nobody cancels").image.hash()
        };
        let expected = hash(&scene, 1);
        for threads in [2, 7] {
            assert_eq!(
                hash(&scene, threads),
                expected,
                "{mode:?}, {threads} threads"
            );
        }
        scene.render.accelerator = AcceleratorChoice::BruteForce;
        assert_eq!(hash(&scene, 2), expected, "{mode:?}, brute force");
    }
}

/// Value = 1 − seg(X/c) for an edge at distance 2 seen by a lens of radius 0.1 focused at 5.
#[test]
fn a_lens_blurs_an_edge_by_its_profile() {
    let mut scene = Scene::default();
    // The half plane x < 0 at distance 2, bright; the rest black.
    add(
        &mut scene,
        "plate",
        rectangle(DVec3::new(-5.0, 2.0, 0.0), DVec3::X * 5.0, DVec3::Z * 5.0),
        Material::emitter(),
    );
    scene.render = RenderSettings {
        width: 1,
        height: 1,
        samples_per_pixel: 1 << 14,
        antialiasing: false,
        ..RenderSettings::default()
    };
    for (offset, expected) in [
        (-0.1, 0.109_551),
        (-0.05, 0.291_791),
        (0.0, 0.5),
        (0.05, 0.708_209),
        (0.1, 0.890_449),
    ] {
        // On the focus plane the pixel's centre lies at −offset on the bright side.
        scene.camera = Camera {
            eye: DVec3::ZERO,
            target: DVec3::new(-offset, 5.0, 0.0),
            vertical_fov: Degrees(1e-4),
            aperture_radius: 0.1,
            focus_distance: Some(5.0),
            ..Camera::default()
        };
        let found = value(&scene);
        assert!(
            (found - expected).abs() < 2e-3,
            "X = {offset}: {found}, not {expected}"
        );
    }
    // In focus it is sharp for every sample, and without depth of field a pinhole.
    scene.camera.focus_distance = Some(2.0);
    scene.camera.target.x = -0.01;
    assert_eq!(value(&scene).to_bits(), 1.0_f64.to_bits());
    scene.camera.focus_distance = Some(5.0);
    scene.render.depth_of_field = false;
    assert_eq!(value(&scene).to_bits(), 1.0_f64.to_bits());
}

#[test]
fn a_disk_is_seen_bright_in_front_and_black_from_behind() {
    let mut scene = Scene::default();
    add(
        &mut scene,
        "speck",
        rectangle(DVec3::Y * 9.0, DVec3::X * 0.1, DVec3::Z * 0.1),
        diffuse(1.0),
    );
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.25),
    };
    let light = |normal: DVec3, visible: bool| Light::Disk {
        center: DVec3::Y * 3.0,
        facing: Facing::Normal(normal),
        radius: 1.0,
        radiance: Rgb::splat(7.0),
        visible,
    };
    scene.camera = Camera {
        eye: DVec3::ZERO,
        target: DVec3::new(0.0, 3.0, 0.5),
        vertical_fov: Degrees(1e-3),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 1,
        height: 1,
        samples_per_pixel: 1,
        ..RenderSettings::default()
    };
    for (normal, visible, expected) in [
        (-DVec3::Y, true, 7.0),
        (DVec3::Y, true, 0.0),
        (-DVec3::Y, false, 0.25),
    ] {
        scene.lights = vec![light(normal, visible)];
        assert_near(
            value(&scene),
            expected,
            1e-6,
            &format!("{normal}, {visible}"),
        );
    }
}

#[test]
fn hard_shadows_take_a_disk_for_its_centre() {
    let mut scene = looking_at_floor(0.5, diffuse(1.0));
    scene.lights.push(disk(DVec3::Z * 2.0, 0.5));
    scene.render.shadows = Shadows::Hard;
    scene.render.samples_per_pixel = 1;
    let distance_squared = 4.25_f64;
    let cosine = 2.0 / distance_squared.sqrt();
    assert_near(
        value(&scene),
        PI * 0.25 * cosine * cosine / distance_squared / PI,
        1e-5,
        "L·A·cos²/d²·1/π",
    );
}
