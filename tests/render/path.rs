//! Path tracing against closed forms, and its ways of finding light against each other.
//!
//! Sequences are fixed by seeds. Where a tolerance is statistical, it says how many standard deviations it is.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use crate::common::{
    WAYS, add, assert_near, assert_ways_agree, diffuse, looking_at_floor, picture, rectangle, run,
    value,
};
use raymini::geometry::TriangleMesh;
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees};
use raymini::scene::{
    Background, Camera, Facing, Light, Material, Mode, RenderSettings, Rgb, Scene, Textures,
};

/// A disk of 512 triangles at `height`, facing down.
fn polygon_disk(height: f64, radius: f64) -> TriangleMesh {
    let corner = |i: u32| {
        let angle = TAU * f64::from(i) / 512.0;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), height)
    };
    TriangleMesh {
        positions: std::iter::once(DVec3::Z * height)
            .chain((0..512).map(corner))
            .collect(),
        triangles: (0..512).map(|i| [0, 1 + (i + 1) % 512, 1 + i]).collect(),
        ..TriangleMesh::default()
    }
}

/// [`looking_at_floor`] by path tracing.
fn path_to_floor(x: f64, material: Material) -> Scene {
    let mut scene = looking_at_floor(x, material);
    scene.render.mode = Mode::Path;
    scene
}

/// The disk's closed form, for a disk light and for an emitting mesh of the same shape, found each way.
#[test]
fn a_disk_and_an_emitting_mesh_give_the_irradiance_of_the_formula() {
    for (height, offset, expected) in [(1.0, 0.5, 1.375_963_021), (2.0, 0.0, 0.628_318_531)] {
        let mut mesh = path_to_floor(offset, diffuse(0.5));
        mesh.render.mode = Mode::Direct;
        mesh.render.samples_per_pixel = 1 << 14;
        add(
            &mut mesh,
            "lamp",
            polygon_disk(height, 1.0),
            Material::emitter(),
        );
        assert_near(
            value(&mesh),
            0.5 * expected / PI,
            5e-3,
            &format!("mesh, directly, h {height}"),
        );
        for way in WAYS {
            let mut scene = path_to_floor(offset, diffuse(0.5));
            scene.render.light_sampling = way;
            scene.render.max_bounces = 1;
            scene.render.samples_per_pixel = 1 << 14;
            let mut mesh = scene.clone();
            let (center, facing) = (DVec3::Z * height, Facing::Normal(-DVec3::Z));
            scene.lights.push(Light::Disk {
                center,
                facing,
                radius: 1.0,
                radiance: Rgb::ONE,
                visible: true,
            });
            assert_near(
                value(&scene),
                0.5 * expected / PI,
                5e-3,
                &format!("disk, {way:?}, h {height}"),
            );
            add(
                &mut mesh,
                "lamp",
                polygon_disk(height, 1.0),
                Material::emitter(),
            );
            assert_near(
                value(&mesh),
                0.5 * expected / PI,
                5e-3,
                &format!("mesh, {way:?}, h {height}"),
            );
        }
    }
}

/// A point light of intensity π in a diffuse ball of radius 1: n bounces give ρ(1 − ρⁿ)/(1 − ρ).
#[test]
fn a_light_in_a_diffuse_ball_sums_its_bounces() {
    let mut scene = Scene::default();
    add(&mut scene, "ball", shapes::icosphere(4), diffuse(0.5));
    scene.lights.push(Light::Point {
        position: DVec3::ZERO,
        intensity: Rgb::splat(PI),
    });
    scene.camera = Camera {
        eye: DVec3::new(0.3, 0.2, 0.1),
        target: DVec3::X,
        vertical_fov: Degrees(90.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 16,
        height: 16,
        samples_per_pixel: 64,
        roulette: false,
        ..RenderSettings::default()
    };
    let mean = |scene: &Scene| {
        let image = picture(scene);
        image
            .pixels
            .iter()
            .map(|pixel| f64::from(pixel[0]))
            .sum::<f64>()
            / image.pixels.len() as f64
    };
    for bounces in [0, 1, 2, 4, 8] {
        scene.render.max_bounces = bounces;
        let expected = 0.5 * (1.0 - 0.5_f64.powf(f64::from(bounces))) / 0.5;
        // The ball's faces lie up to 0.4 % inside the sphere.
        assert_near(mean(&scene), expected, 6e-3, &format!("{bounces} bounces"));
    }
    // With roulette and without a cap, all of it.
    scene.render.max_bounces = 1 << 20;
    scene.render.roulette = true;
    assert_near(mean(&scene), 1.0, 1e-2, "all bounces");
    // Where hardly anything is absorbed, roulette must not let those that go on carry more and more. Three standard deviations of
    // this mean are 1 %, and the faces are closer as above.
    scene.materials.insert("ball".into(), diffuse(0.99));
    assert_near(mean(&scene), 99.0, 2e-2, "albedo 0.99");
}

/// What a lobe reflects of an even sky, at some exponents and angles.
#[test]
fn the_phong_lobe_has_the_albedo_of_the_table() {
    let table = [
        (1.0, [1.0, 0.755_409_16, 0.458_441_52]),
        (50.0, [1.0, FRAC_1_SQRT_2, 0.260_465_08]),
        (1e4, [1.0, FRAC_1_SQRT_2, 0.258_819_05]),
        (1e7, [1.0, FRAC_1_SQRT_2, 0.258_819_05]),
    ];
    for (shininess, albedos) in table {
        for (degrees, albedo) in [0.0_f64, 45.0, 75.0].into_iter().zip(albedos) {
            let mut scene = path_to_floor(
                0.0,
                Material::Phong {
                    diffuse: Rgb::ZERO,
                    specular: Rgb::ONE,
                    shininess,
                    textures: Textures::default(),
                },
            );
            let (sine, cosine) = degrees.to_radians().sin_cos();
            scene.camera.eye = DVec3::new(0.0, -sine, cosine) * 3.0;
            scene.camera.up = DVec3::new(0.0, cosine, sine);
            scene.background = Background::Constant { radiance: Rgb::ONE };
            scene.render.samples_per_pixel = 1 << 14;
            assert_near(
                value(&scene),
                albedo,
                2e-3,
                &format!("n {shininess}, {degrees}°"),
            );
        }
    }
}

#[test]
fn every_way_of_finding_light_finds_the_same() {
    let mut scene = Scene::default();
    let shiny = Material::Phong {
        diffuse: Rgb::splat(0.4),
        specular: Rgb::splat(0.4),
        shininess: 20.0,
        textures: Textures::default(),
    };
    add(
        &mut scene,
        "floor",
        rectangle(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0),
        shiny,
    );
    add(
        &mut scene,
        "wall",
        rectangle(DVec3::new(0.0, 1.5, 1.0), DVec3::X * 3.0, DVec3::Z),
        diffuse(0.7),
    );
    add(
        &mut scene,
        "lamp",
        rectangle(DVec3::new(0.5, 0.5, 2.0), DVec3::X * 0.6, DVec3::Y * 0.4),
        Material::emitter(),
    );
    add(
        &mut scene,
        "mirror",
        rectangle(DVec3::new(-1.5, 0.0, 1.0), DVec3::Y, DVec3::Z),
        Material::mirror(),
    );
    scene.lights.push(Light::Disk {
        center: DVec3::new(-0.5, -0.5, 1.5),
        facing: Facing::Target(DVec3::ZERO),
        radius: 0.5,
        radiance: Rgb::splat(2.0),
        visible: true,
    });
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.1),
    };
    scene.camera = Camera {
        eye: DVec3::new(1.0, -4.0, 2.0),
        target: DVec3::Z * 0.5,
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 4,
        height: 4,
        samples_per_pixel: 256,
        max_bounces: 4,
        ..RenderSettings::default()
    };

    assert_ways_agree(&mut scene, "mirror, emitter, disk");
}

/// Few triangles that stand for a smooth ball, lifted to it, so near to lamps that the lift turns directions to them by degrees.
#[test]
fn every_way_of_finding_light_finds_the_same_on_a_coarse_smooth_ball() {
    let mut scene = Scene::default();
    add(&mut scene, "ball", shapes::icosphere(1), diffuse(0.8));
    scene.objects[0].smooth = true;
    scene.objects[0].crease_angle = Degrees(180.0);
    let lamp = DVec3::new(0.5, -0.9, 0.55);
    let (u, v) = lamp.normalize().any_orthonormal_pair();
    add(
        &mut scene,
        "lamp",
        rectangle(lamp, u * 0.1, v * 0.1),
        Material::emitter(),
    );
    scene.lights.push(Light::Disk {
        center: DVec3::new(-0.5, -0.9, 0.55),
        facing: Facing::Target(DVec3::ZERO),
        radius: 0.1,
        radiance: Rgb::ONE,
        visible: true,
    });
    scene.camera = Camera {
        eye: DVec3::new(0.0, -4.0, 2.0),
        target: DVec3::Z * 0.3,
        vertical_fov: Degrees(25.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 4,
        height: 4,
        samples_per_pixel: 256,
        max_bounces: 1,
        ..RenderSettings::default()
    };

    assert_ways_agree(&mut scene, "smooth ball, emitter, disk");
}

#[test]
fn glass_in_a_white_furnace_is_invisible() {
    let mut scene = Scene::default();
    add(&mut scene, "ball", shapes::icosphere(2), Material::glass());
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.5),
    };
    scene.camera = Camera {
        eye: DVec3::new(0.0, -4.0, 1.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 24,
        height: 24,
        max_bounces: 1 << 16,
        roulette: false,
        ..RenderSettings::default()
    };
    // But for the rounding of n² on the way in and out.
    for pixel in &picture(&scene).pixels {
        assert!((pixel[0] - 0.5).abs() < 1e-6, "{pixel:?}");
    }
}

#[test]
fn a_closed_room_without_light_is_black_and_ends() {
    let mut scene = Scene::default();
    add(&mut scene, "room", shapes::icosphere(1), diffuse(1.0));
    scene.camera = Camera {
        eye: DVec3::ZERO,
        target: DVec3::X,
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 8,
        height: 8,
        samples_per_pixel: 4,
        max_bounces: 1 << 20,
        ..RenderSettings::default()
    };
    assert!(
        picture(&scene)
            .pixels
            .iter()
            .all(|&pixel| pixel == [0.0; 3])
    );
}

#[test]
fn the_classic_formula_is_refused() {
    let mut scene = path_to_floor(0.0, diffuse(0.5));
    scene.render.phong = raymini::scene::PhongModel::Classic;
    let error = scene.validate().expect_err("is refused").to_string();
    assert!(
        error.starts_with("render.phong is classic; expected modified in mode path"),
        "{error}"
    );
}

#[test]
fn what_max_bounces_cuts_off_is_counted() {
    let mut scene = Scene::default();
    let wall = rectangle(DVec3::ZERO, DVec3::X * 9.0, DVec3::Z * 9.0);
    add(&mut scene, "wall", wall, diffuse(0.5));
    scene.render.width = 8;
    scene.render.height = 8;
    scene.render.samples_per_pixel = 4;
    scene.background = Background::Constant { radiance: Rgb::ONE };
    let mirror = Material::Mirror {
        reflectance: Rgb::splat(0.5),
    };
    let (all, none) = (8 * 8 * 4, 0);
    // After one bounce the light of the background is met: nothing is missing.
    let cases = [
        (Mode::Direct, mirror.clone(), [all, none]),
        (Mode::Direct, diffuse(0.5), [all, none]),
        (Mode::Path, mirror, [all, none]),
        (Mode::Path, diffuse(0.5), [all, none]),
        (Mode::Path, diffuse(0.0), [none, none]),
        (Mode::Normals, diffuse(0.5), [none, none]),
    ];
    for (mode, material, counts) in cases {
        scene.render.mode = mode;
        scene.materials.insert("wall".into(), material.clone());
        for (max_bounces, count) in (0..).zip(counts) {
            scene.render.max_bounces = max_bounces;
            let stats = run(&scene).stats;
            assert_eq!(
                stats.depth_limited_samples, count,
                "{mode:?}, {material:?}, {max_bounces}"
            );
            assert_eq!(stats.notable_depth_limited_share().is_some(), count > 0);
        }
    }
}
