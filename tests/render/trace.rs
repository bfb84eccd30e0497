//! One camera sample taken again: what it brings is what a render adds to the pixel, and every ray is told.

use std::process::Command;

use crate::common::{add, diffuse, rectangle, run};
use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees};
use raymini::render::{
    Met, PreparedScene, RayCounts, RayPurpose, SampleTrace, TraceError, trace_sample,
};
use raymini::scene::{
    Background, Camera, Facing, Filter, Light, Material, Mode, RenderSettings, Rgb, Scene, Shadows,
    Textures,
};

/// Balls of glass and of something matt beside a mirror on a floor.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0);
    add(&mut scene, "floor", floor, diffuse(0.6));
    let glass = Material::Glass {
        ior: 1.5,
        attenuation: Rgb::splat(0.1),
    };
    add(&mut scene, "glass", shapes::icosphere(2), glass);
    scene.objects[1].translate = DVec3::new(-1.2, 0.0, 1.0);
    let matt = Material::Phong {
        diffuse: Rgb::new(0.5, 0.2, 0.2),
        specular: Rgb::splat(0.3),
        shininess: 20.0,
        textures: Textures::default(),
    };
    add(&mut scene, "matt", shapes::icosphere(2), matt);
    scene.objects[2].translate = DVec3::new(1.2, 0.0, 1.0);
    scene.objects[2].smooth = true;
    let mirror = Material::Mirror {
        reflectance: Rgb::splat(0.9),
    };
    let wall = rectangle(DVec3::new(0.0, 3.0, 1.5), DVec3::X * 3.0, DVec3::Z * 1.5);
    add(&mut scene, "mirror", wall, mirror);
    for (center, radius) in [
        (DVec3::new(1.5, 1.0, 2.8), 0.7),
        (DVec3::new(-3.0, -1.0, 4.0), 2.0),
    ] {
        scene.lights.push(Light::Disk {
            center,
            facing: Facing::Target(DVec3::ZERO),
            radius,
            radiance: Rgb::splat(12.0),
            visible: true,
        });
    }
    scene.lights.push(Light::Point {
        position: DVec3::new(0.0, -5.0, 2.0),
        intensity: Rgb::splat(3.0),
    });
    scene.background = Background::Gradient {
        zenith: Rgb::new(0.2, 0.3, 0.6),
        horizon: Rgb::splat(0.5),
        ground: Rgb::splat(0.1),
        up: DVec3::Z,
    };
    scene.camera = Camera {
        eye: DVec3::new(0.5, -7.0, 3.0),
        target: DVec3::new(0.0, 0.0, 1.4),
        vertical_fov: Degrees(40.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 7,
        height: 6,
        samples_per_pixel: 16,
        ..RenderSettings::default()
    };
    scene
}

type Change = fn(&mut Scene);

/// Settings that between them trace every kind of ray in every way.
const CASES: [(&str, Change); 9] = [
    ("direct", |_| ()),
    ("many shadow rays", |scene| {
        scene.render.shadow_samples = 5;
        // So that shadow rays are looked along together.
        scene.render.glass = false;
    }),
    ("one kind of shadow", |scene| {
        scene.render.shadows = Shadows::Fraction;
    }),
    ("no shadow", |scene| scene.render.shadows = Shadows::Off),
    ("occlusion", |scene| {
        scene.render.ambient_occlusion.enabled = true;
        scene.render.ambient_occlusion.samples = 70;
    }),
    ("path", |scene| scene.render.mode = Mode::Path),
    ("path, bounded, with a lens", |scene| {
        scene.render.mode = Mode::Path;
        scene.render.clamp = Some(0.3);
        scene.render.filter = Filter::Gaussian;
        scene.camera.aperture_radius = 0.2;
    }),
    ("ao", |scene| scene.render.mode = Mode::Ao),
    ("depth", |scene| scene.render.mode = Mode::Depth),
];

fn prepare(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared.expect("can be rendered").expect("nobody cancels")
}

fn trace(prepared: &PreparedScene, pixel: (u32, u32), sample: u32) -> SampleTrace {
    let trace = trace_sample(prepared, pixel, sample, &CancelToken::new());
    trace
        .expect("is one of the picture")
        .expect("nobody cancels")
}

fn count(counts: &mut RayCounts, trace: &SampleTrace) {
    for ray in &trace.rays {
        *match ray.purpose {
            RayPurpose::Camera => &mut counts.camera,
            RayPurpose::Shadow => &mut counts.shadow,
            RayPurpose::AmbientOcclusion => &mut counts.ambient_occlusion,
            RayPurpose::Bounce => &mut counts.bounce,
        } += 1;
    }
}

/// Samples are summed in blocks, each from zero, and the sums of blocks in their order.
#[test]
fn samples_add_up_to_the_pixel_and_their_rays_to_all_rays() {
    for (name, change) in CASES {
        let mut scene = scene();
        change(&mut scene);
        let prepared = prepare(&scene);
        let outcome = run(&scene);
        let mut counts = RayCounts::default();
        let mut depth_limited = 0;
        for (y, x) in (0..6).flat_map(|y| (0..7).map(move |x| (y, x))) {
            let mut sum = [0.0_f64; 3];
            let mut first = 0;
            for block in [1, 1, 1, 1, 2, 2, 4, 4] {
                let mut block_sum = [0.0_f64; 3];
                for sample in first..first + block {
                    let trace = trace(&prepared, (x, y), sample);
                    count(&mut counts, &trace);
                    depth_limited += u64::from(trace.is_depth_limited);
                    for (sum, value) in block_sum.iter_mut().zip(trace.radiance) {
                        *sum += f64::from(value);
                    }
                }
                for (sum, block) in sum.iter_mut().zip(block_sum) {
                    *sum += block;
                }
                first += block;
            }
            assert_eq!(first, 16);
            #[expect(clippy::cast_possible_truncation, reason = "the picture is f32")]
            let mean = sum.map(|sum| (sum / 16.0) as f32);
            let pixel = outcome.image.pixel(x, y);
            assert_eq!(mean.map(f32::to_bits), pixel.map(f32::to_bits), "{name}");
        }
        assert_eq!(counts, outcome.stats.rays, "{name}");
        assert_eq!(depth_limited, outcome.stats.depth_limited_samples, "{name}");
    }
}

/// What is told of the rays agrees with the scene, and the rays of a path with each other.
#[test]
fn rays_lead_from_one_surface_to_the_next() {
    for (name, change) in CASES {
        let mut scene = scene();
        change(&mut scene);
        let prepared = prepare(&scene);
        let (mut met, mut lights) = (0, 0);
        for (pixel, sample) in (0..42).flat_map(|p| (0..4).map(move |s| ((p % 7, p / 7), s))) {
            let trace = trace(&prepared, pixel, sample);
            let first = &trace.rays[0];
            assert_eq!(first.purpose, RayPurpose::Camera);
            let from_eye = first.origin.distance(scene.camera.eye);
            assert!(from_eye <= scene.camera.aperture_radius + 1e-12, "{name}");
            // Where the path is.
            let mut place = first.origin;
            for (number, ray) in trace.rays.iter().enumerate() {
                assert!((ray.direction.length() - 1.0).abs() < 1e-6);
                if number > 0 {
                    // Rays from smooth objects start where those would be round.
                    assert!(ray.origin.distance(place) < 0.05, "{name}: {ray:?}");
                }
                let (distance, position) = match ray.met {
                    Met::Nothing => continue,
                    Met::Light {
                        light,
                        distance,
                        position,
                    } => {
                        let Light::Disk { center, radius, .. } = scene.lights[light] else {
                            panic!("points are not met");
                        };
                        assert!(position.distance(center) <= radius * 1.0001);
                        lights += 1;
                        (distance, position)
                    }
                    Met::Surface(surface) => {
                        met += 1;
                        let object = &scene.objects[surface.object];
                        let mesh = &scene.meshes[&object.mesh];
                        let [a, b, c] = mesh
                            .corners(surface.triangle as usize)
                            .map(|corner| corner + object.translate);
                        let normal = (b - a).cross(c - a).normalize();
                        assert!((surface.position - a).dot(normal).abs() < 1e-5);
                        let facing = surface.geometric_normal.dot(normal);
                        assert!((facing.abs() - 1.0).abs() < 1e-6);
                        assert_eq!(facing > 0.0, surface.front);
                        assert!(surface.geometric_normal.dot(ray.direction) <= 0.0);
                        assert!((surface.shading_normal.length() - 1.0).abs() < 1e-6);
                        assert_eq!(surface.copy, 0);
                        (surface.distance, surface.position)
                    }
                };
                let there = ray.origin + ray.direction * distance;
                assert!(there.distance(position) < 1e-4, "{name}: {ray:?}");
                assert!(distance <= ray.reach * 1.0001);
                if ray.passed.is_none() {
                    place = position;
                }
            }
        }
        assert!(met > 40, "{name}: {met}");
        let sees_lights = scene.render.mode.shows_light();
        assert_eq!(lights > 0, sees_lights, "{name}");
    }
}

#[test]
fn pixels_and_samples_that_are_not_there_are_errors() {
    let prepared = prepare(&scene());
    let pixel = |x, y| {
        Err(TraceError::NoSuchPixel {
            x,
            y,
            width: 7,
            height: 6,
        })
    };
    let cancel = CancelToken::new();
    let traced = |pixel, sample| trace_sample(&prepared, pixel, sample, &cancel);
    assert_eq!(traced((7, 0), 0), pixel(7, 0));
    assert_eq!(traced((0, u32::MAX), 0), pixel(0, u32::MAX));
    let sample = TraceError::NoSuchSample {
        sample: 16,
        count: 16,
    };
    assert_eq!(traced((6, 5), 16), Err(sample));
    assert!(traced((6, 5), 15).is_ok_and(|trace| trace.is_some()));
    cancel.cancel();
    assert_eq!(traced((6, 5), 15), Ok(None));
}

#[test]
fn the_command_prints_what_the_picture_holds() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let scene = "[[objects]]\nname = \"plate\"\nmesh = \"builtin:ground\"\n\
        [[lights]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = [3, 2, 1]\n\
        [camera]\neye = [0, -4, 2]\n[render]\nwidth = 4\nheight = 3\nsamples_per_pixel = 1\n";
    std::fs::write(folder.path().join("scene.toml"), scene).expect("is written");
    let raymini = |arguments: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(arguments.split(' '))
            .output()
            .expect("starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    };
    let (code, _, said) = raymini("render scene.toml -o a.exr");
    assert_eq!(code, Some(0), "{said}");
    let image = raymini::io::read_image(&folder.path().join("a.exr")).expect("is a picture");
    for (x, y) in [(1, 1), (2, 1), (0, 0)] {
        let (code, lines, said) = raymini(&format!("render scene.toml --pixel {x},{y} --sample 0"));
        assert_eq!(code, Some(0), "{said}");
        let radiance = lines.lines().last().expect("a line");
        let values = radiance.strip_prefix("radiance ").expect("the radiance");
        let values: Vec<f32> = values
            .split(' ')
            .map(|v| v.parse().expect("a number"))
            .collect();
        assert_eq!(values, image.image.pixel(x, y), "{lines}");
        let sees_plate = lines.contains("meets objects.0 \"plate\", copy 0, triangle ");
        assert_eq!(sees_plate, y == 1, "{lines}");
    }
    for (arguments, code, expected) in [
        (
            "--pixel 4,0",
            1,
            "pixel 4,0 does not lie in the 4×3 picture",
        ),
        ("--pixel 0,0 --sample 1", 1, "sample 1 is not taken"),
        ("--pixel 0", 2, "such as 320,240"),
        ("--sample 0 -o b.png", 2, "cannot be used with"),
        ("--pixel 0,0 -o b.png", 2, "cannot be used with"),
        ("", 2, "--output <FILE>"),
    ] {
        let arguments = format!("render scene.toml {arguments}");
        let (found, _, said) = raymini(arguments.trim_end());
        assert_eq!(found, Some(code), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}
