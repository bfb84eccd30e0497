use super::*;
use crate::math::{DVec3, Degrees};
use crate::scene::{
    Background, Copies, Display, Facing, Light, Material, Mode, Object, Output, PngBits, Shadows,
    Textures, ToneCurve,
};

fn parse(text: &str) -> Result<Scene, SceneFileError> {
    SceneFile::parse(text, "test.toml").map(|file| file.scene)
}

fn message(text: &str) -> String {
    parse(text).expect_err("the file is wrong").to_string()
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

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn mistakes_name_place_and_expectation() {
    let cases = [
        (
            "[[lights]]\nkind = \"disk\"\ntarget = [0, 0, 1]\nnormal = [0, 0, 1]",
            "4:1: `normal` says the same as `target`; leave one of them out",
        ),
        (
            "[[lights]]\nkind = \"disk\"\nradius = 0",
            "3:10: `lights.0.radius` is 0; expected a finite number above 0",
        ),
        (
            "[[lights]]\nkind = \"disk\"\ntarget = [0, 0, 0]",
            "3:10: lights.0.target is [0, 0, 0]; expected a point other than the center",
        ),
        (
            "[camera]\nfocus_distance = 0",
            "2:18: `camera.focus_distance` is 0; expected a number above 0, or inf",
        ),
        (
            "[materials.a]\nkind = \"mirror\"\ndiffuse = [1, 1, 1]",
            "3:1: unknown key `diffuse`",
        ),
        (
            "[render]\nmode = \"path\"\nphong = \"classic\"",
            "3:9: render.phong is classic; expected modified in mode path",
        ),
        (
            "[camera]\neye = [0, 0]",
            "test.toml:2:7: `camera.eye` is [0, 0]; expected [x, y, z]",
        ),
        (
            "[camera]\nvertical_fov = 180",
            "2:16: `camera.vertical_fov` is 180; expected a number above 0 and below 180",
        ),
        (
            "[camera]\nvertical_fov = nan",
            "2:16: `camera.vertical_fov` is NaN; expected a number above 0",
        ),
        (
            "[camera]\nfov = 40",
            "2:1: unknown key `fov`; here it is called `vertical_fov`",
        ),
        (
            "[camera]\nwidth = 40",
            "2:1: unknown key `width`; known here: eye, target, up, vertical_fov",
        ),
        (
            "[camera]\nvertical_fow = 40",
            "unknown key `vertical_fow`; the nearest known one is `vertical_fov`",
        ),
        (
            "[camera]\nup = [0, -6, 2.5]",
            "2:6: camera.up is [0, -6, 2.5]; expected a direction that is not parallel",
        ),
        (
            "[camera]\ntarget = [0, -6, 2.5]",
            "2:10: camera.target is [0, -6, 2.5]; expected a point other than the eye",
        ),
        ("camera = 3", "1:10: `camera` is 3; expected a table"),
        (
            "[materails.clay]\n",
            "1:2: unknown key `materails`; the nearest known one is `materials`",
        ),
        (
            "[materials.clay]\ndifuse = [1,1,1]",
            "2:1: unknown key `difuse`; the nearest known one is `diffuse`",
        ),
        (
            "[materials.clay]\ndiffuse = [1, -1, 1]",
            "2:11: `materials.clay.diffuse` is [1, -1, 1]; expected [red, green, blue]",
        ),
        (
            "[materials.clay]\nkind = \"phong \"",
            "2:8: `materials.clay.kind` is \"phong \"; expected one of \"phong\", \"mirror\"",
        ),
        (
            "[[objects]]\nname = \"x\"",
            "1:1: the key `mesh` is missing here",
        ),
        (
            "[objects]\nmesh = \"x\"",
            "1:1: `objects` is a table; expected a list: write [[objects]]",
        ),
        (
            "[[objects]]\nmesh = \"x\"\nscale = 0",
            "3:9: `objects.0.scale` is 0; expected a finite number other than 0",
        ),
        (
            "[[objects]]\nmesh = \"x\"\nscale = \"2\"",
            "`objects.0.scale` is \"2\"; expected",
        ),
        (
            "[materials.clay]\n[[objects]]\nmesh = \"x\"\nmaterial = \"glay\"",
            "4:12: material \"glay\" is not defined; the nearest defined one is \"clay\"",
        ),
        (
            "[[objects]]\nmesh = \"x\"\ncopies = { count = [1, 0, 1] }",
            "`objects.0.copies.count` is [1, 0, 1]; expected three",
        ),
        (
            "[[lights]]\nkind = \"spot\"",
            "2:8: `lights.0.kind` is \"spot\"; expected one of \"point\", \"disk\"",
        ),
        (
            "[[lights]]\nintensity = [1, 1, inf]",
            "`lights.0.intensity` is [1, 1, inf]; expected [red, green, blue]",
        ),
        (
            "[render]\nwidth = 0",
            "2:9: `render.width` is 0; expected a whole number from 1 to 65536",
        ),
        (
            "[render]\nwidth = 640.5",
            "2:9: `render.width` is 640.5; expected a whole number",
        ),
        (
            "[render]\nwidth = 65536\nheight = 65536",
            "render.width is 65536; expected width × height of at most",
        ),
        (
            "[render]\nmode = \"drect\"",
            "2:8: `render.mode` is \"drect\"; expected one of \"direct\"",
        ),
        (
            "[render]\nantialiasing = 1",
            "`render.antialiasing` is 1; expected true or false",
        ),
        (
            "[background]\nradiance = [1,1,1]\nzenith = [1,1,1]",
            "2:1: `radiance` is for a background that is the same",
        ),
        (
            "[background]\nradiance = [1,1,1]\nimage = \"sky.exr\"",
            "2:1: `radiance` is for a background that is the same everywhere; leave it out beside an image",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nground = [1,1,1]",
            "3:1: `ground` is for a gradient; leave it out beside an image",
        ),
        (
            "[background]\nrotation = 20",
            "2:1: `rotation` is for a background with an `image`",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nscale = -1",
            "3:9: `background.scale` is -1; expected a finite number of at least 0",
        ),
        (
            "[background]\nimage = 3",
            "2:9: `background.image` is 3; expected a text in quotes",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nup = [0, 0, 0]",
            "3:6: background.up is [0, 0, 0]; expected a direction",
        ),
        (
            "[background]\nimge = \"sky.exr\"",
            "2:1: unknown key `imge`; the nearest known one is `image`",
        ),
        (
            "[background]\nzenit = [1,1,1]",
            "2:1: unknown key `zenit`; the nearest known one is `zenith`",
        ),
        (
            "[output]\npng_bits = 12",
            "`output.png_bits` is 12; expected 8 or 16",
        ),
        (
            "[render]\nseed = -1",
            "`render.seed` is -1; expected a whole number from 0",
        ),
        ("[render\n", "test.toml:1:8: "),
        ("x = 1979-05-27", "a date has no meaning in a scene"),
        (
            "[render]\nwidth = 99999999999999999999",
            "does not fit a 64-bit integer",
        ),
    ];
    for (text, expected) in cases {
        let found = message(text);
        assert!(
            found.contains(expected),
            "{text:?}\n  found:    {found}\n  expected: {expected}"
        );
    }
}

#[test]
fn columns_count_characters_not_bytes() {
    assert!(message("[materials.\"ä\"]\ndiffuse = { \"ö\" = 1 }").starts_with("test.toml:2:11:"));
    assert!(message("# ü\nü = 1").starts_with("test.toml:2:1:"));
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
fn overrides_change_any_key() {
    let scene = parse("[[objects]]\nmesh = \"x\"\n[[lights]]").expect("is right");
    let set = |assignment: &str| apply_overrides(&scene, &[assignment.to_owned()]);
    assert_eq!(set("render.width=17").expect("is right").render.width, 17);
    assert_eq!(
        set("render.mode = normals").expect("is right").render.mode,
        Mode::Normals
    );
    assert_eq!(
        set("render.mode=\"depth\"").expect("is right").render.mode,
        Mode::Depth
    );
    assert_eq!(
        set("objects.0.scale=2").expect("is right").objects[0]
            .scale
            .to_bits(),
        2.0_f64.to_bits()
    );
    let lit = set("lights.0.intensity=[1, 2, 3]").expect("is right");
    assert_eq!(
        lit.lights,
        [Light::Point {
            position: DVec3::ZERO,
            intensity: DVec3::new(1.0, 2.0, 3.0)
        }]
    );
    assert_eq!(
        set("materials.red.diffuse=[1,0,0]")
            .expect("is right")
            .materials
            .len(),
        1
    );

    // What excludes each other makes way, and order does not matter where the end is right.
    let disk = set("lights.0.kind=disk").expect("is right");
    assert!(matches!(disk.lights[0], Light::Disk { .. }));
    let sky = set("background.zenith=[1, 1, 1]")
        .expect("is right")
        .background;
    assert!(matches!(sky, Background::Gradient { .. }));
    let image = |assignments: &[&str]| {
        let all: Vec<String> = assignments.iter().map(ToString::to_string).collect();
        apply_overrides(&scene, &all).expect("is right").background
    };
    let up = DVec3::new(0.0, 0.0, 1.0);
    let expected = Background::Image {
        image: "sky.hdr".into(),
        up,
        rotation: Degrees(20.0),
        scale: 1.0,
    };
    let assignments = ["background.image=sky.hdr", "background.rotation=20"];
    assert_eq!(image(&assignments), expected);
    let back = [
        assignments[0],
        assignments[1],
        "background.radiance=[1, 1, 1]",
    ];
    assert_eq!(
        image(&back),
        Background::Constant {
            radiance: DVec3::ONE
        }
    );
    let aimed = ["lights.0.kind=disk", "lights.0.target=[0, 0, -3]"].map(str::to_owned);
    assert!(apply_overrides(&scene, &aimed).is_ok());
    let from_above = [
        "camera.eye=[0, 0, 5]",
        "camera.target=[0, 0, 0]",
        "camera.up=[0, 1, 0]",
    ]
    .map(str::to_owned);
    assert!(apply_overrides(&scene, &from_above).is_ok());
}

#[test]
fn wrong_overrides_are_told_with_what_was_expected() {
    let scene = parse("[[objects]]\nmesh = \"x\"\n[[lights]]").expect("is right");
    let cases = [
        (
            "render.wdith=3",
            "--set render.wdith=3: unknown key `wdith`; the nearest known one is `width`",
        ),
        (
            "render.width=x",
            "`render.width` is \"x\"; expected a whole number",
        ),
        (
            "objects.1.scale=2",
            "\"1\" is not one of the 1 items, numbered from 0",
        ),
        (
            "render.width.x=2",
            "\"x\" asks for a part of 640, which has none",
        ),
        ("render.width", "expected KEY=VALUE"),
        (
            "render.width=[",
            "\"[\" is no value; expected one such as 2.5, true",
        ),
        ("camera.eye=1,2,3", "\"1,2,3\" is no value; expected"),
        ("=1", "--set =1: expected KEY=VALUE"),
        (
            "spp=1",
            "--set spp=1: unknown key `spp`; known here: camera, ",
        ),
        (
            "samples_per_pixel=1",
            "unknown key `samples_per_pixel`; there is `render.samples_per_pixel`",
        ),
        ("scale=1", "unknown key `scale`; there is `objects.0.scale`"),
        (
            "render.sampels=1",
            "unknown key `sampels`; the nearest known one is `samples_per_pixel`",
        ),
        (
            "render.qqqq=1",
            "unknown key `qqqq`; the nearest of the 23 known here are mode, seed, stop",
        ),
    ];
    for (assignment, expected) in cases {
        let found = apply_overrides(&scene, &[assignment.to_owned()]);
        let found = found.expect_err("is wrong").to_string();
        assert!(found.contains(expected), "{assignment}: {found}");
    }
}

/// Of several assignments the wrong one is named; all of them where what is wrong then was there before.
#[test]
fn the_assignment_to_blame_is_named() {
    let scene = parse("").expect("is right");
    let found_in = |scene: &Scene, assignments: &[&str]| {
        let assignments: Vec<String> = assignments.iter().map(|&text| text.to_owned()).collect();
        let error = apply_overrides(scene, &assignments).expect_err("is wrong");
        error.at
    };
    let found = |assignments: &[&str]| found_in(&scene, assignments);
    let [right, also] = ["render.height=8", "camera.up=[0, 1, 0]"];
    for wrong in [
        "render.wdith=3",
        "render.width=x",
        "render.width=",
        "camera.vertical_fov=200",
        "background={ zenit = [1, 1, 1] }",
        "materials.clay.diffuse=[1, -1, 1]",
        "camera.target=[0, -6, 2.5]",
    ] {
        for assignments in [[wrong, right, also], [right, also, wrong]] {
            assert_eq!(found(&assignments), format!("--set {wrong}"));
        }
    }
    let together = ["render.mode=path", "render.phong=classic"];
    assert_eq!(found(&together), "--set render.phong=classic");
    let classic = parse("[render]\nphong = \"classic\"").expect("is right");
    let found = found_in(&classic, &["render.mode=path", right]);
    assert_eq!(found, "--set render.mode=path --set render.height=8");
}

#[test]
fn random_edits_never_panic() {
    let base =
        write(&parse("[[objects]]\nmesh = \"x\"\n[[lights]]\n[materials.a]").expect("is right"));
    let mut state = 1_u32;
    let mut next = |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    for _ in 0..3000 {
        let mut bytes = base.clone().into_bytes();
        for _ in 0..=next(3) {
            if bytes.is_empty() {
                break;
            }
            let at = next(bytes.len());
            match next(3) {
                0 => bytes[at] = b"[]{}=\".,#-0\n"[next(12)],
                1 => drop(bytes.remove(at)),
                _ => bytes.truncate(at + 1),
            }
        }
        let _ = parse(&String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn a_long_line_is_read_and_its_columns_are_right() {
    // Keys in another order than they are asked for, and so many that counting columns from the start for each would not end.
    let light = "{ position = [1, 2, 3], kind = \"point\", intensity = [1, 1, 1] }, ";
    let text = format!("lights = [{}{{ intensity = 1 }}]", light.repeat(50_000));
    let error = SceneFile::parse(&text, "test.toml").expect_err("is wrong");
    let column = text.chars().count() - "1 }]".len() + 1;
    assert!(
        error.to_string().contains(&format!(":1:{column}: ")),
        "{error}"
    );
}

/// To compare two words takes the product of their lengths: a scene of some megabytes could ask for all memory there is.
#[test]
fn words_of_any_length_are_compared_in_little_memory() {
    let long = "k".repeat(1 << 20);
    let materials = format!("[materials.clay]\n[materials.l{long}]\n");
    let object = format!("[[objects]]\nmesh = \"a.off\"\nmaterial = \"{long}\"\n");
    for (text, expected) in [
        (format!("{long} = 1\n"), "test.toml:1:1: unknown key `kkkk"),
        (format!("[render]\n{long} = 1\n"), "test.toml:2:1: "),
        (
            format!("{materials}{object}"),
            "test.toml:5:12: material \"kkkk",
        ),
    ] {
        let found = message(&text);
        assert!(found.starts_with(expected), "{found}");
        assert!(found.len() < 1000, "{} bytes", found.len());
    }
}

/// Whatever a file holds, what is said about it fits on a screen.
#[test]
fn messages_show_the_beginning_of_what_is_long() {
    let list = format!("[{}]", "1, ".repeat(5000));
    let text = "é".repeat(5000);
    let huge = format!("[1e308, {}0.5]", "-1e308, ".repeat(20));
    for (value, shown) in [
        (list.clone(), "[1, 1, 1, 1, 1, 1, 1, 1, …]"),
        (format!("[{list}, 2]"), "[a list, 2]"),
        (
            huge,
            "[1e308, -1e308, -1e308, -1e308, -1e308, -1e308, -1e308, -1e308, …]",
        ),
        (format!("\"{text}\""), &format!("\"{}…\"", "é".repeat(60))),
    ] {
        assert_eq!(
            message(&format!("camera.eye = {value}")),
            format!(
                "test.toml:1:14: `camera.eye` is {shown}; expected [x, y, z], each a finite number"
            )
        );
    }
}

/// Keys are not visited in their order in the text.
#[test]
fn columns_are_right_in_any_order() {
    let keys: Vec<String> = (0..2000).rev().map(|i| format!("\"é{i}\"")).collect();
    let pairs: Vec<String> = keys.iter().map(|key| format!("{key} = 7")).collect();
    let text = format!("x = {{ {} }}\n", pairs.join(", "));
    let tree = Node::parse(&text, "").expect("is TOML");
    for key in &keys {
        let before = text.split_once(&format!("{key} = ")).expect("is there").0;
        let place = tree.place_of(&format!("x.{}", key.trim_matches('"')));
        let expected = before.chars().count() + key.chars().count() + " = ".len() + 1;
        assert_eq!((place.line, place.column), (1, expected), "{key}");
    }
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
