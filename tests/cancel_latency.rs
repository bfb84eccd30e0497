//! How long it takes from asking to end until nothing works any more, in the scenes whose single samples take longest: minutes, some of them.
//!
//! This file is a program of its own, as nothing else may need the processor meanwhile. `cargo test --test cancel_latency -- --nocapture`
//! prints what it measures.

mod common;

use std::time::{Duration, Instant};

use common::{add, diffuse, looking_at_floor, rectangle};
use raymini::analysis::pilot;
use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::DVec3;
use raymini::render::{
    CoarsePicture, PreparedScene, RenderProgress, RunConfig, Watch, render_watched, trace_sample,
};
use raymini::scene::{
    Background, Camera, Copies, Facing, Light, Material, Mode, Object, RenderSettings, Rgb, Scene,
};

/// The promise.
const BAR: Duration = Duration::from_millis(50);
/// Other programs come and go: the best of so many tries counts.
const TRIES: usize = 4;
/// How long work goes on before somebody asks, in milliseconds.
const LEAD: u64 = 60;

const MOST_RAYS: u32 = RenderSettings::MAX_RAYS_PER_SAMPLE;

/// A floor under `count` disk lights, each with as many shadow rays as can be.
fn lit(count: u32) -> Scene {
    let mut scene = looking_at_floor(0.1, diffuse(0.5));
    let light = |number| {
        let share = f64::from(number) / f64::from(count);
        Light::Disk {
            center: DVec3::new(share * 2.0 - 1.0, 0.0, 3.0 + share),
            facing: Facing::Normal(DVec3::NEG_Z),
            radius: 0.5 / f64::from(count),
            radiance: Rgb::ONE,
            visible: true,
        }
    };
    scene.lights = (0..count).map(light).collect();
    scene.render.shadow_samples = MOST_RAYS;
    scene
}

/// [`lit`] through sheets of glass, which shadow rays pass one by one.
fn lit_through_glass() -> Scene {
    let mut scene = lit(2);
    let sheet = rectangle(DVec3::Z, DVec3::X * 3.0, DVec3::Y * 3.0);
    let glass = Material::Glass {
        ior: 1.0001,
        attenuation: Rgb::ZERO,
    };
    add(&mut scene, "glass", sheet, glass);
    scene.objects[1].copies = Copies {
        count: [1, 1, 4000],
        step: DVec3::Z * 4e-4,
    };
    scene
}

/// Triangles all around, under a sky, with as many occlusion rays as can be.
fn occluded(mode: Mode) -> Scene {
    let mut scene = looking_at_floor(0.1, diffuse(0.5));
    add(
        &mut scene,
        "soup",
        shapes::soup(300_000, 0.1, 7),
        diffuse(0.5),
    );
    scene.background = Background::Constant { radiance: Rgb::ONE };
    scene.render.mode = mode;
    scene.render.ambient_occlusion.enabled = true;
    scene.render.ambient_occlusion.samples = MOST_RAYS;
    scene
}

/// The inside of a closed room of a material that takes nothing away, where light goes on for as long as it may.
fn room(mode: Mode, material: Material) -> Scene {
    let mut scene = Scene::default();
    add(
        &mut scene,
        "room",
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        material,
    );
    scene.background = Background::Constant { radiance: Rgb::ONE };
    scene.lights.push(Light::Point {
        position: DVec3::ZERO,
        intensity: Rgb::ONE,
    });
    scene.camera = Camera {
        eye: DVec3::new(0.0, -0.8, 0.1),
        target: DVec3::new(0.1, 0.5, 0.2),
        ..Camera::default()
    };
    scene.render.mode = mode;
    scene.render.max_bounces = RenderSettings::MAX_BOUNCES;
    scene.render.roulette = false;
    scene
}

fn mirrors(mode: Mode) -> Scene {
    room(
        mode,
        Material::Mirror {
            reflectance: Rgb::ONE,
        },
    )
}

fn glass_in_mirrors(mode: Mode) -> Scene {
    let mut scene = mirrors(mode);
    let glass = Material::Glass {
        ior: 1.5,
        attenuation: Rgb::ZERO,
    };
    add(&mut scene, "ball", shapes::icosphere(4), glass);
    scene.objects[1].scale = 0.5;
    scene
}

/// All scenes, of many samples that take long.
fn scenes() -> Vec<(&'static str, Scene)> {
    let many_lights = |mode| {
        let mut scene = lit(10_000);
        scene.render.mode = mode;
        scene
    };
    let mut scenes = vec![
        ("65,536 shadow rays to each of 32 lights", lit(32)),
        (
            "524,288 shadow rays to 10,000 lights",
            many_lights(Mode::Direct),
        ),
        ("paths to 10,000 lights", many_lights(Mode::Path)),
        (
            "65,536 shadow rays through 4,000 sheets of glass",
            lit_through_glass(),
        ),
        (
            "65,536 occlusion rays among 300,000 triangles",
            occluded(Mode::Direct),
        ),
        ("the same as a picture of occlusion", occluded(Mode::Ao)),
        ("2^20 mirrors", mirrors(Mode::Direct)),
        ("paths by 2^20 mirrors", mirrors(Mode::Path)),
        ("2^20 mirrors and glass", glass_in_mirrors(Mode::Direct)),
        (
            "paths by 2^20 mirrors and glass",
            glass_in_mirrors(Mode::Path),
        ),
        (
            "paths of 2^20 bounces at albedo 1",
            room(Mode::Path, diffuse(1.0)),
        ),
    ];
    for (_, scene) in &mut scenes {
        (scene.render.width, scene.render.height) = (64, 48);
        scene.render.samples_per_pixel = 1 << 20;
    }
    scenes
}

fn prepared(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared.expect("can be rendered").expect("nobody cancels")
}

/// A large mesh, smooth, which shines: places, normals, a tree of triangles and one of lights.
fn shining() -> Scene {
    let mut scene = Scene::default();
    let radiance = Rgb::ONE;
    add(
        &mut scene,
        "sun",
        shapes::icosphere(8),
        Material::Emitter { radiance },
    );
    scene.objects[0].smooth = true;
    scene.objects.push(Object {
        translate: DVec3::X * 3.0,
        ..scene.objects[0].clone()
    });
    scene.render.mode = Mode::Path;
    scene
}

/// Has `work` done until it is cancelled after `lead` milliseconds, as it tells, and measures how long that takes: the best of some tries,
/// which is printed and held to the bar.
fn measure(what: &str, lead: u64, work: impl Fn(&RunConfig) -> bool + Sync) {
    let tries = (0..TRIES).map(|_| {
        let run = RunConfig {
            threads: 2,
            ..RunConfig::default()
        };
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| work(&run));
            std::thread::sleep(Duration::from_millis(lead));
            let asked = Instant::now();
            run.cancel.cancel();
            let is_cancelled = worker.join().expect("does not panic");
            assert!(is_cancelled, "{what}: it was done before");
            asked.elapsed()
        })
    });
    let times: Vec<Duration> = tries.collect();
    let best = times.iter().min().expect("there are some");
    println!("{best:8.1?} at best, {times:.1?}: {what}");
    assert!(*best < BAR, "{what}: {times:?}");
}

#[test]
fn whatever_goes_on_ends_soon_after_somebody_asks() {
    for (what, scene) in scenes() {
        let ready = prepared(&scene);
        measure(&format!("render, {what}"), LEAD, |run| {
            let progress = RenderProgress::default();
            render_watched(&ready, None, run, &progress, Watch::default()).is_none()
        });
        measure(&format!("first look, {what}"), LEAD, |run| {
            let watch = Watch {
                on_coarse: Some(&|_: &CoarsePicture| ()),
                ..Watch::default()
            };
            render_watched(&ready, None, run, &RenderProgress::default(), watch).is_none()
        });
        measure(&format!("time estimate, {what}"), LEAD, |run| {
            let estimate = pilot::estimate_time(&scene, &ready, None, run);
            estimate.expect("can be rendered").is_none()
        });
    }
    let ready = prepared(&lit(32));
    measure(
        "rays of a pixel, 65,536 to each of 32 lights",
        LEAD,
        |run| {
            let trace = trace_sample(&ready, (0, 0), 0, &run.cancel);
            trace.expect("is one of the picture").is_none()
        },
    );
    let scene = shining();
    for lead in [LEAD, 250, 500] {
        let what = format!("preparing 2.6 million triangles that shine, after {lead} ms");
        measure(&what, lead, |run| {
            let prepared = PreparedScene::prepare(&scene, None, &run.cancel);
            prepared.expect("can be rendered").is_none()
        });
    }
}
