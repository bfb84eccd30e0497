//! What scene files say, and what is written back.

mod mistakes;
mod overrides;

use super::*;
use crate::math::{DVec3, Degrees};
use crate::scene::{
    Background, Copies, Display, Facing, Light, Material, Mode, Object, Output, PngBits, Shadows,
    Textures, ToneCurve,
};

fn parse(text: &str) -> Result<Scene, SceneFileError> {
    SceneFile::parse(text, "test.toml").map(|file| file.scene)
}

#[test]
fn an_empty_file_is_the_default_scene() {
    assert_eq!(parse("").expect("is right"), Scene::default());
}

#[test]
fn one_object_is_a_scene_and_takes_its_meshs_name() {
    let scene = parse("[[objects]]\nmesh = \"shapes/ram.off\"").expect("is right");
    assert_eq!(
        scene.objects,
        [Object {
            name: "ram".into(),
            mesh: "shapes/ram.off".into(),
            ..Object::default()
        }]
    );
}

#[test]
fn gradient_defaults_follow_the_horizon_and_the_camera() {
    let scene = parse(
        "[camera]\nup = [0, 3, 0]\n[background]\nzenith = [1, 1, 1]\nhorizon = [0.5, 0.5, 0.5]",
    );
    let expected = Background::Gradient {
        zenith: DVec3::ONE,
        horizon: DVec3::splat(0.5),
        ground: DVec3::splat(0.5),
        up: DVec3::new(0.0, 3.0, 0.0),
    };
    assert_eq!(scene.expect("is right").background, expected);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn every_key_round_trips() {
    let scene = Scene {
        camera: crate::scene::Camera {
            eye: DVec3::new(1.0, -1e-20, 1e20),
            target: DVec3::new(0.1, 0.2, 0.3),
            up: DVec3::Y,
            vertical_fov: Degrees(0.001),
            aperture_radius: 0.05,
            focus_distance: Some(6.5),
        },
        bookmarks: vec![
            crate::scene::Bookmark {
                name: "from \"above\"".into(),
                camera: crate::scene::Camera {
                    eye: DVec3::Z * 7.5,
                    target: DVec3::X,
                    focus_distance: Some(f64::INFINITY),
                    ..crate::scene::Camera::default()
                },
            },
            crate::scene::Bookmark::default(),
        ],
        background: Background::Gradient {
            zenith: DVec3::new(0.1, 0.2, 0.3),
            horizon: DVec3::ONE,
            ground: DVec3::ZERO,
            up: DVec3::Z,
        },
        materials: [
            (
                "clay".into(),
                Material::Phong {
                    diffuse: DVec3::X,
                    specular: DVec3::splat(0.1),
                    shininess: 1e7,
                    textures: Textures::default(),
                },
            ),
            ("odd \"name\"".into(), Material::default()),
            (
                "wood".into(),
                Material::Phong {
                    diffuse: DVec3::ONE,
                    specular: DVec3::ZERO,
                    shininess: 40.0,
                    textures: Textures {
                        diffuse_image: Some("a \"b\".png".into()),
                        normal_image: Some("bumps.exr".into()),
                        vertex_colors: true,
                    },
                },
            ),
            (
                "chrome".into(),
                Material::Mirror {
                    reflectance: DVec3::splat(0.9),
                },
            ),
            (
                "bottle".into(),
                Material::Glass {
                    ior: 1.33,
                    attenuation: DVec3::X,
                },
            ),
            (
                "lamp".into(),
                Material::Emitter {
                    radiance: DVec3::splat(5.0),
                },
            ),
        ]
        .into(),
        objects: vec![Object {
            name: "a.b".into(),
            mesh: "dir/ü \"x\".off".into(),
            material: Some("odd \"name\"".into()),
            smooth: true,
            crease_angle: Degrees(30.0),
            repair_winding: true,
            scale: -2.5,
            rotate: DVec3::new(0.0, 90.0, -1.0 / 3.0),
            translate: DVec3::new(1e7, 0.1 + 0.2, 0.0),
            copies: Copies {
                count: [3, 1, 2],
                step: DVec3::X,
            },
        }],
        lights: vec![
            Light::Point {
                position: DVec3::ONE,
                intensity: DVec3::new(20.0, 0.0, 1e30),
            },
            Light::Disk {
                center: DVec3::Z,
                facing: Facing::Target(DVec3::ZERO),
                radius: 0.5,
                radiance: DVec3::splat(40.0),
                visible: false,
            },
            Light::Disk {
                center: DVec3::ZERO,
                facing: Facing::Normal(DVec3::new(0.0, 1.0, -2.0)),
                radius: 1e-6,
                radiance: DVec3::X,
                visible: true,
            },
        ],
        light_names: vec![String::new(), "key \"warm\"".into()],
        render: crate::scene::RenderSettings {
            mode: Mode::Normals,
            width: 1,
            height: 65_536,
            samples_per_pixel: 7,
            stop: crate::scene::Stop {
                seconds: Some(1.5),
                noise: Some(0.03),
                passes: Some(12),
            },
            adaptive: false,
            error_estimate: true,
            seed: i64::MAX as u64,
            sampler: crate::scene::SamplerChoice::Independent,
            max_bounces: 3,
            roulette: false,
            light_sampling: crate::scene::LightSampling::Nee,
            filter: crate::scene::Filter::Gaussian,
            shadows: Shadows::Hard,
            shadow_samples: 5,
            ambient_occlusion: crate::scene::AmbientOcclusion {
                enabled: true,
                samples: 7,
                radius: 0.25,
            },
            mirror: false,
            glass: false,
            depth_of_field: false,
            antialiasing: false,
            phong: crate::scene::PhongModel::Classic,
            clamp: Some(12.5),
            accelerator: crate::scene::AcceleratorChoice::BruteForce,
            accelerator_build: crate::scene::AcceleratorBuild::Fast,
        },
        display: Display {
            exposure: -1.5,
            tone_curve: ToneCurve::Aces,
            gamma: 1.5,
        },
        output: Output {
            png_bits: PngBits::Sixteen,
            layers: false,
        },
        meshes: std::collections::BTreeMap::new(),
        images: std::collections::BTreeMap::new(),
        textures: std::collections::BTreeMap::new(),
    };
    let text = write(&scene);
    assert_eq!(
        parse(&text).expect("what is written can be read"),
        scene,
        "{text}"
    );
    assert_eq!(write(&parse(&text).expect("is right")), text);
    let plain = Scene::default();
    assert_eq!(parse(&write(&plain)).expect("is right"), plain);
}

#[test]
fn an_image_background_round_trips_and_has_defaults() {
    let with = |background| Scene {
        background,
        ..Scene::default()
    };
    let scene = with(Background::Image {
        image: "skies/\"ü\".exr".into(),
        up: DVec3::new(0.0, 1.0, -2.0),
        rotation: Degrees(-123.25),
        scale: 0.1,
    });
    assert_eq!(parse(&write(&scene)).expect("can be read"), scene);
    let short = "[camera]\nup = [0, 3, 0]\n[background]\nimage = \"sky.hdr\"";
    let expected = Background::Image {
        image: "sky.hdr".into(),
        up: DVec3::new(0.0, 3.0, 0.0),
        rotation: Degrees(0.0),
        scale: 1.0,
    };
    assert_eq!(parse(short).expect("is right").background, expected);
}

/// Written over several lines, as a text may be but a key may not, it made the file unreadable.
#[test]
fn a_material_of_any_name_is_written_so_that_it_can_be_read() {
    let names = ["a\nb", "\r\n\t\u{0}\u{7f}\u{85}", "'\"\\", "", " ", "é.ü"];
    let mut scene = Scene::default();
    for name in names {
        scene.materials.insert(name.into(), Material::mirror());
    }
    assert_eq!(parse(&write(&scene)).expect("can be read"), scene);
    let changed = apply_overrides(&scene, &["render.width=7".to_owned()]).expect("is right");
    assert_eq!(
        (changed.render.width, changed.materials),
        (7, scene.materials)
    );
}

/// A camera to come back to is checked like the camera, and named where it is wrong.
#[test]
fn bookmarks_are_cameras_with_names() {
    let scene = parse("[[bookmarks]]\nname = \"side\"\neye = [9, 0, 1]\n").unwrap();
    assert_eq!(scene.bookmarks[0].name, "side");
    assert_eq!(scene.bookmarks[0].camera.eye, DVec3::new(9.0, 0.0, 1.0));
    assert!(!write(&Scene::default()).contains("bookmarks"));
    for (text, expected) in [
        ("[[bookmarks]]\nfov = 4\n", "fov"),
        (
            "[[bookmarks]]\n[[bookmarks]]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n",
            "bookmarks.1.target",
        ),
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
