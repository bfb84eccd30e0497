//! Glass against Fresnel's equations and the geometry of lenses.

use std::f64::consts::PI;

use crate::common::{add, assert_near, diffuse, looking_at_floor, picture, rectangle, value};
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec3, Degrees};
use raymini::scene::{
    Background, Camera, Facing, Light, LightSampling, Material, Mode, RenderSettings, Rgb, Scene,
    Textures,
};

/// A slab of glass before a black backdrop, under an even sky from the eye's side.
#[test]
fn a_slab_of_glass_reflects_and_transmits_what_fresnel_says() {
    for (degrees, reflected) in [
        (0.0_f64, 0.076_923_1),
        (45.0, 0.095_673_2),
        (60.0, 0.163_767_5),
        (80.0, 0.558_770_8),
    ] {
        let mut scene = Scene::default();
        let slab = |z: f64, flip: bool| {
            let (u, v) = (DVec3::X * 50.0, DVec3::Y * 50.0);
            if flip {
                rectangle(DVec3::Z * z, v, u)
            } else {
                rectangle(DVec3::Z * z, u, v)
            }
        };
        add(&mut scene, "top", slab(0.0, false), Material::glass());
        add(&mut scene, "bottom", slab(-0.1, true), Material::glass());
        let black = Material::Phong {
            diffuse: Rgb::ZERO,
            specular: Rgb::ZERO,
            shininess: 1.0,
            textures: Textures::default(),
        };
        add(&mut scene, "backdrop", slab(-1.0, false), black);
        scene.background = Background::Constant { radiance: Rgb::ONE };
        let (sine, cosine) = degrees.to_radians().sin_cos();
        scene.camera = Camera {
            eye: DVec3::new(0.0, -sine, cosine) * 3.0,
            target: DVec3::ZERO,
            up: DVec3::new(0.0, cosine, sine),
            vertical_fov: Degrees(1e-4),
            ..Camera::default()
        };
        scene.render = RenderSettings {
            width: 1,
            height: 1,
            samples_per_pixel: 1 << 16,
            antialiasing: false,
            max_bounces: 64,
            ..RenderSettings::default()
        };
        // Four standard deviations of a coin with the reflectance for its chance.
        let tolerance = 4.0 * (reflected * (1.0 - reflected) / 65_536.0_f64).sqrt();
        let found = value(&scene);
        assert!(
            (found - reflected).abs() < tolerance,
            "{degrees}°: {found}, not {reflected} ± {tolerance}"
        );
    }
}

/// Glass of any shape under an even sky is invisible, whatever is refracted, but for what `max_bounces` cuts off.
#[test]
fn glass_in_a_white_furnace_is_invisible() {
    let mut scene = Scene::default();
    let corners: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) - 0.5)
        .collect();
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    add(
        &mut scene,
        "cube",
        TriangleMesh {
            positions: corners,
            triangles: faces.to_vec(),
            ..TriangleMesh::default()
        },
        Material::glass(),
    );
    scene.objects[0].rotate = DVec3::new(20.0, 30.0, 40.0);
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.5),
    };
    scene.camera = Camera {
        eye: DVec3::new(0.0, -4.0, 1.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 32,
        height: 32,
        max_bounces: 1 << 16,
        ..RenderSettings::default()
    };
    let image = picture(&scene);
    // Every path ends in the sky with weight 1, but for the rounding of n² on the way in and out.
    for pixel in &image.pixels {
        assert!((pixel[0] - 0.5).abs() < 1e-6, "{pixel:?}");
    }
}

/// Radiance over n² is what refraction keeps: under an even sky, inside glass it is n² times what it is outside.
#[test]
fn radiance_is_concentrated_inside_glass() {
    for (mode, ior) in [(Mode::Direct, 1.5), (Mode::Path, 1.5), (Mode::Path, 0.8)] {
        let mut scene = Scene::default();
        let glass = Material::Glass {
            ior,
            attenuation: Rgb::ZERO,
        };
        add(&mut scene, "ball", shapes::icosphere(4), glass);
        scene.objects[0].smooth = true;
        scene.background = Background::Constant { radiance: Rgb::ONE };
        scene.camera = Camera {
            eye: DVec3::new(0.1, 0.2, 0.05),
            target: DVec3::new(0.3, 1.0, 0.2),
            ..Camera::default()
        };
        scene.render = RenderSettings {
            mode,
            width: 8,
            height: 8,
            max_bounces: 1 << 12,
            ..RenderSettings::default()
        };
        let expected = ior * ior;
        for pixel in &picture(&scene).pixels {
            assert_near(f64::from(pixel[0]), expected, 1e-5, "inside");
        }
    }
}

/// A lamp inside a ball of glass gives the walls around no more light than without: less by what the glass reflects back to
/// the lamp, which absorbs it. At 4 % reflectance that is at most 4 %; 1.5 % of noise are allowed for.
#[test]
fn a_lamp_inside_glass_gives_no_more_light() {
    let on_the_wall = |ior: f64| {
        let mut scene = Scene::default();
        add(&mut scene, "room", shapes::icosphere(4), diffuse(0.2));
        scene.objects[0].scale = 3.0;
        let emitter = Material::Emitter { radiance: Rgb::ONE };
        add(&mut scene, "lamp", shapes::icosphere(3), emitter);
        scene.objects[1].scale = 0.3;
        let glass = Material::Glass {
            ior,
            attenuation: Rgb::ZERO,
        };
        add(&mut scene, "shell", shapes::icosphere(4), glass);
        scene.objects[2].smooth = true;
        scene.camera = Camera {
            eye: DVec3::new(0.0, -1.5, 0.0),
            target: DVec3::new(0.0, -3.0, 0.5),
            ..Camera::default()
        };
        scene.render = RenderSettings {
            mode: Mode::Path,
            width: 8,
            height: 8,
            samples_per_pixel: 1 << 13,
            max_bounces: 12,
            light_sampling: LightSampling::Bsdf,
            ..RenderSettings::default()
        };
        let pixels = picture(&scene).pixels;
        pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 64.0
    };
    let share = on_the_wall(1.5) / on_the_wall(1.0);
    assert!((0.945..1.015).contains(&share), "{share}");
}

#[test]
fn light_passes_straight_through_glass_to_what_it_lights() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    scene.lights.push(Light::Point {
        position: DVec3::Z * 2.0,
        intensity: Rgb::ONE,
    });
    let open = value(&scene);
    assert_near(open, 1.0 / (4.0 * PI), 1e-5, "a point light two above");
    add(
        &mut scene,
        "upper",
        rectangle(DVec3::Z * 1.0, DVec3::X, DVec3::Y),
        Material::Glass {
            ior: 1.5,
            attenuation: Rgb::splat(2.0),
        },
    );
    add(
        &mut scene,
        "lower",
        rectangle(DVec3::Z * 0.5, DVec3::Y, DVec3::X),
        Material::Glass {
            ior: 1.5,
            attenuation: Rgb::splat(2.0),
        },
    );
    assert_near(
        value(&scene),
        open * 0.96 * 0.96 * (-1.0_f64).exp(),
        1e-4,
        "two faces and half a unit of glass",
    );
}

/// At 60° both faces of a pane reflect 8.9 %; a straight ray loses that twice.
#[test]
fn light_passes_straight_through_glass_at_any_angle() {
    for (degrees, reflectance) in [
        (45.0_f64, 0.050_239_9),
        (60.0, 0.089_186_7),
        (80.0, 0.387_704_4),
    ] {
        let mut scene = looking_at_floor(0.0, diffuse(1.0));
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let position = DVec3::new(sine, 0.0, cosine) * 4.0;
        scene.lights.push(Light::Point {
            position,
            intensity: Rgb::ONE,
        });
        let open = value(&scene);
        let pane = |z: f64, flip: bool| {
            let (u, v) = (DVec3::X * 18.0, DVec3::Y * 18.0);
            let (u, v) = if flip { (v, u) } else { (u, v) };
            rectangle(DVec3::Z * z, u, v)
        };
        scene.camera.eye.z = 0.01;
        add(&mut scene, "upper", pane(0.3, false), Material::glass());
        add(&mut scene, "lower", pane(0.2, true), Material::glass());
        let passed = (1.0 - reflectance) * (1.0 - reflectance);
        assert_near(value(&scene), open * passed, 1e-4, &format!("{degrees}°"));
    }
}

/// A ray parallel to the axis of a unit ball crosses it at `sin i / sin(2(i − t))` from the centre, where `sin i` is the ray's
/// height and `t` its angle inside. Two half walls of different colours meet at the axis, a little before that place and a
/// little behind: the ray sees one and then the other.
#[test]
fn a_ball_lens_bends_rays_to_where_geometry_says() {
    let cases = [
        (1.5, 0.1, 1.495_827_1),
        (1.5, 0.5, 1.391_572_9),
        (1.5, 0.7, 1.277_787_0),
        (1.33, 0.3, 1.951_478_2),
        (1.33, 0.7, 1.635_539_4),
        (1.7, 0.5, 1.149_199_6),
    ];
    for (ior, height, crossing) in cases {
        let side_at = |distance: f64| {
            let mut scene = Scene::default();
            let glass = Material::Glass {
                ior,
                attenuation: Rgb::ZERO,
            };
            add(&mut scene, "ball", shapes::icosphere(5), glass);
            scene.objects[0].smooth = true;
            for (name, side, radiance) in [("upper", 2.0, Rgb::X), ("lower", -2.0, Rgb::Y)] {
                let wall = rectangle(
                    DVec3::new(0.0, distance, side),
                    DVec3::X * 2.0,
                    DVec3::Z * 2.0,
                );
                add(&mut scene, name, wall, Material::Emitter { radiance });
            }
            scene.camera = Camera {
                eye: DVec3::new(0.0, -1e4, height),
                target: DVec3::new(0.0, 0.0, height),
                vertical_fov: Degrees(1e-7),
                ..Camera::default()
            };
            scene.render = RenderSettings {
                mode: Mode::Path,
                width: 1,
                height: 1,
                samples_per_pixel: 256,
                antialiasing: false,
                max_bounces: 2,
                ..RenderSettings::default()
            };
            // Two boundaries and no more: what passes straight through, which is most.
            let [upper, lower, _] = picture(&scene).pixel(0, 0);
            assert!(
                upper.max(lower) > 0.7 && upper.min(lower) < 0.1,
                "{upper} {lower}"
            );
            upper > lower
        };
        assert!(side_at(crossing * 0.99), "n {ior}, height {height}");
        assert!(!side_at(crossing * 1.01), "n {ior}, height {height}");
    }
}

/// A cube of half a side 1 that bends nothing and takes light away per unit: e⁻⁰, e⁻¹ and e⁻² of the three channels.
fn absorbing_cube() -> (TriangleMesh, Material) {
    let glass = Material::Glass {
        ior: 1.0,
        attenuation: Rgb::new(0.0, 1.0, 2.0),
    };
    (shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE), glass)
}

/// One pixel along −Z from `eye` above the middle of the scene.
fn looking_down_from(eye: f64) -> Scene {
    Scene {
        camera: Camera {
            eye: DVec3::new(0.1, 0.2, eye),
            target: DVec3::new(0.1, 0.2, -10.0),
            up: DVec3::Y,
            vertical_fov: Degrees(1e-3),
            ..Camera::default()
        },
        render: RenderSettings {
            width: 1,
            height: 1,
            samples_per_pixel: 4,
            antialiasing: false,
            max_bounces: 8,
            ..RenderSettings::default()
        },
        ..Scene::default()
    }
}

/// Asserts what is left of `whole` light after `length` through [`absorbing_cube`], in both modes.
#[track_caller]
fn assert_absorbed(scene: &mut Scene, whole: f64, length: f64, what: &str) {
    for mode in [Mode::Direct, Mode::Path] {
        scene.render.mode = mode;
        let found = picture(scene).pixel(0, 0);
        for (channel, found) in found.into_iter().enumerate() {
            let expected = whole * (-(channel as f64) * length).exp();
            let what = format!("{what}, {mode:?}, channel {channel}");
            assert_near(f64::from(found), expected, 1e-5, &what);
        }
    }
}

/// Glass absorbs between its surface and whatever stands in it, for an eye in it too, and between two things that stand in it.
#[test]
fn glass_absorbs_light_of_what_stands_in_it() {
    for (eye, length) in [(5.0, 1.0), (0.5, 0.5)] {
        for lamp in ["mesh", "disk"] {
            let mut scene = looking_down_from(eye);
            let (cube, glass) = absorbing_cube();
            add(&mut scene, "cube", cube, glass);
            if lamp == "mesh" {
                let lamp = rectangle(DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 0.5);
                add(&mut scene, "lamp", lamp, Material::emitter());
            } else {
                scene.lights.push(Light::Disk {
                    center: DVec3::ZERO,
                    facing: Facing::Normal(DVec3::Z),
                    radius: 0.5,
                    radiance: Rgb::ONE,
                    visible: true,
                });
            }
            assert_absorbed(&mut scene, 1.0, length, &format!("{lamp} seen from {eye}"));
        }
    }

    // A floor in the cube and a light above it in the cube: 0.4 to the light, 1.5 to the eye's side of the cube.
    let mut scene = looking_down_from(5.0);
    let (cube, glass) = absorbing_cube();
    add(&mut scene, "cube", cube, glass);
    let floor = rectangle(DVec3::Z * -0.5, DVec3::X * 0.6, DVec3::Y * 0.6);
    add(&mut scene, "floor", floor, diffuse(1.0));
    scene.render.max_bounces = 2;
    scene.lights.push(Light::Point {
        position: DVec3::new(0.1, 0.2, -0.1),
        intensity: Rgb::splat(0.4 * 0.4 * PI),
    });
    assert_absorbed(&mut scene, 1.0, 0.4 + 1.5, "floor lit from inside");
}

/// The inner of two absorbs, here half as much.
#[test]
fn glass_in_glass_absorbs_as_the_inner_one() {
    let thinner = Material::Glass {
        ior: 1.0,
        attenuation: Rgb::new(0.0, 0.5, 1.0),
    };
    let inner = shapes::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    for (eye, length) in [(5.0, 0.5 + 0.5 + 0.5), (0.0, 0.25 + 0.5)] {
        let mut scene = looking_down_from(eye);
        let (cube, glass) = absorbing_cube();
        add(&mut scene, "cube", cube, glass);
        add(&mut scene, "inner", inner.clone(), thinner.clone());
        let lamp = rectangle(DVec3::Z * -2.0, DVec3::X, DVec3::Y);
        add(&mut scene, "lamp", lamp, Material::emitter());
        assert_absorbed(&mut scene, 1.0, length, &format!("from {eye}"));
    }
}

/// A shadow ray loses what is between the last face and a light in the glass.
#[test]
fn light_that_stands_in_glass_loses_on_its_way_out() {
    let mut scene = looking_down_from(-5.0);
    let (cube, glass) = absorbing_cube();
    add(&mut scene, "cube", cube, glass);
    let floor = rectangle(DVec3::Z * -9.0, DVec3::X, DVec3::Y);
    add(&mut scene, "floor", floor, diffuse(1.0));
    scene.lights.push(Light::Point {
        position: DVec3::new(0.1, 0.2, 0.0),
        intensity: Rgb::splat(81.0 * PI),
    });
    let [r, g, b] = picture(&scene).pixel(0, 0).map(f64::from);
    assert_near(r, 1.0, 1e-5, "nothing is lost");
    assert_near(g, (-1.0_f64).exp(), 1e-5, "one unit");
    assert_near(b, (-2.0_f64).exp(), 1e-5, "one unit, twice as thick");
}
