//! What a scene does not need is left out: its counter is exactly 0, and the picture is that of a render that does everything.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::{add, diffuse, rectangle, run};
use raymini::analysis::proofs::{Bench, cases};
use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees, Ray, Vec3};
use raymini::render::{
    Decision, Feature, Plan, PreparedScene, PrimaryHitStore, RenderProgress, RunConfig, Work,
    even_passes, reasons, render,
};
use raymini::scene::{
    AmbientOcclusion, Background, Camera, Facing, Light, LightSampling, Material, Mode, PhongModel,
    RadianceMap, Rgb, Scene, Shadows, Textures,
};

fn prepare(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared.expect("can be rendered").expect("nobody cancels")
}

fn hash(scene: &PreparedScene, layers: bool) -> String {
    let run = RunConfig {
        layers,
        ..RunConfig::default()
    };
    let outcome = render(scene, None, &run, &RenderProgress::default(), None);
    outcome.expect("nobody cancels").image.hash()
}

/// The work of all samples.
fn work(scene: &PreparedScene) -> Work {
    let settings = scene.settings();
    let (width, height) = (settings.width, settings.height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Work::of(scene, pixels, settings.samples_per_pixel)
}

/// A floor, a black and a shiny wall, a ball of glass and a mirror, lights of all kinds, one of them black, one behind the wall.
fn showroom() -> Scene {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 5.0, DVec3::Y * 5.0);
    add(&mut scene, "floor", floor, diffuse(0.6));
    let wall = rectangle(DVec3::new(0.0, 2.0, 1.0), DVec3::X * 3.0, DVec3::Z);
    let shiny = Material::Phong {
        diffuse: Rgb::splat(0.2),
        specular: Rgb::splat(0.5),
        shininess: 40.0,
        textures: Textures::default(),
    };
    add(&mut scene, "wall", wall, shiny);
    let side = rectangle(DVec3::new(-2.0, 0.0, 1.0), DVec3::Y * 2.0, DVec3::Z);
    add(&mut scene, "side", side, diffuse(0.0));
    let glass = Material::Glass {
        ior: 1.5,
        attenuation: DVec3::splat(0.1),
    };
    add(&mut scene, "ball", shapes::icosphere(2), glass);
    let mirror = rectangle(DVec3::new(1.5, 0.5, 0.5), DVec3::Y, DVec3::Z * 0.5);
    let reflectance = Rgb::splat(0.9);
    add(
        &mut scene,
        "mirror",
        mirror,
        Material::Mirror { reflectance },
    );
    let lamp = rectangle(DVec3::new(-1.0, -1.0, 3.0), DVec3::X * 0.2, DVec3::Y * 0.2);
    let radiance = Rgb::splat(6.0);
    add(&mut scene, "lamp", lamp, Material::Emitter { radiance });
    let point = |x: f64, y: f64, intensity: f64| Light::Point {
        position: DVec3::new(x, y, 1.5),
        intensity: Rgb::splat(intensity),
    };
    let disk = |x: f64, visible: bool| Light::Disk {
        center: DVec3::new(x, -1.0, 2.5),
        facing: Facing::Target(DVec3::ZERO),
        radius: 0.4,
        radiance: Rgb::splat(3.0),
        visible,
    };
    scene.lights = vec![
        point(2.0, -2.0, 5.0),
        point(0.0, 4.0, 5.0),
        point(1.0, 1.0, 0.0),
        disk(-1.0, false),
        disk(1.0, true),
    ];
    scene.background = Background::Gradient {
        zenith: Rgb::new(0.2, 0.3, 0.5),
        horizon: Rgb::splat(0.4),
        ground: Rgb::splat(0.1),
        up: DVec3::Z,
    };
    scene.camera = Camera {
        eye: DVec3::new(1.0, -5.0, 2.0),
        target: DVec3::new(0.0, 0.0, 0.6),
        up: DVec3::Z,
        vertical_fov: Degrees(45.0),
        aperture_radius: 0.05,
        ..Camera::default()
    };
    scene.render.width = 24;
    scene.render.height = 16;
    scene.render.samples_per_pixel = 4;
    scene.render.shadow_samples = 4;
    scene.render.max_bounces = 6;
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        samples: 8,
        radius: 0.2,
    };
    scene
}

type Edit = fn(&mut Scene);

/// Gives the scene a small image of a sky with a sun.
fn set_sky(scene: &mut Scene, brightness: f32) {
    let sky = [0.2, 0.5, 9.0, 0.3, 0.1, 0.1, 0.2, 0.1];
    let pixels = sky.map(|pixel| [pixel * brightness; 3]).to_vec();
    let (map, _) = RadianceMap::cleaned(4, 2, pixels);
    scene.images.insert("sky".into(), Arc::new(map));
    scene.background = Background::Image {
        image: "sky".into(),
        up: DVec3::Z,
        rotation: Degrees(30.0),
        scale: 1.0,
    };
}

/// What may be changed about the showroom.
fn changes() -> BTreeMap<&'static str, Edit> {
    let mut changes: BTreeMap<&'static str, Edit> = BTreeMap::new();
    changes.insert("one sample", |s| s.render.samples_per_pixel = 1);
    changes.insert("no antialiasing", |s| s.render.antialiasing = false);
    changes.insert("pinhole and no antialiasing", |s| {
        s.camera.aperture_radius = 0.0;
        s.render.antialiasing = false;
    });
    changes.insert("no lens", |s| s.camera.aperture_radius = 0.0);
    changes.insert("no depth of field", |s| s.render.depth_of_field = false);
    changes.insert("hard shadows", |s| s.render.shadows = Shadows::Hard);
    changes.insert("no shadows", |s| s.render.shadows = Shadows::Off);
    changes.insert("shadows of 2011", |s| s.render.shadows = Shadows::Fraction);
    changes.insert("no glass", |s| s.render.glass = false);
    changes.insert("no mirror", |s| s.render.mirror = false);
    changes.insert("black mirror", |s| {
        let reflectance = Rgb::ZERO;
        s.materials
            .insert("mirror".into(), Material::Mirror { reflectance });
    });
    changes.insert("no occlusion", |s| {
        s.render.ambient_occlusion.enabled = false;
    });
    changes.insert("black background", |s| s.background = Background::default());
    changes.insert("sky", |s| set_sky(s, 2.0));
    changes.insert("black sky", |s| set_sky(s, 0.0));
    changes.insert("classic", |s| {
        // Paths need the modified model.
        if s.render.mode == Mode::Direct {
            s.render.phong = PhongModel::Classic;
        }
    });
    changes.insert("clamp", |s| s.render.clamp = Some(2.0));
    changes.insert("no lights", |s| s.lights.clear());
    changes.insert("no lamp", |s| {
        let radiance = Rgb::ZERO;
        s.materials
            .insert("lamp".into(), Material::Emitter { radiance });
    });
    changes.insert("nothing shines", |s| {
        let radiance = Rgb::ZERO;
        s.materials
            .insert("lamp".into(), Material::Emitter { radiance });
        for light in &mut s.lights {
            match light {
                Light::Point { intensity, .. } => *intensity = Rgb::ZERO,
                Light::Disk { radiance, .. } => *radiance = Rgb::ZERO,
            }
        }
        s.background = Background::default();
    });
    changes.insert("points only", |s| {
        s.lights
            .retain(|light| matches!(light, Light::Point { .. }));
    });
    changes.insert("one point", |s| {
        s.lights.truncate(1);
        let clay = diffuse(0.5);
        s.materials.insert("lamp".into(), clay);
    });
    changes.insert("many lights", |s| {
        let lights = s.lights.clone();
        s.lights = std::iter::repeat_with(|| lights.clone())
            .take(9)
            .flatten()
            .collect();
    });
    changes.insert("no bounce", |s| s.render.max_bounces = 0);
    changes.insert("one bounce", |s| s.render.max_bounces = 1);
    changes.insert("three bounces", |s| s.render.max_bounces = 3);
    changes.insert("no roulette", |s| s.render.roulette = false);
    changes.insert("aimed at only", |s| {
        s.render.light_sampling = LightSampling::Nee;
    });
    changes.insert("met only", |s| {
        s.render.light_sampling = LightSampling::Bsdf;
    });
    changes
}

/// In each mode, with each change and each pair of changes: doing what is not needed, everything or one thing, changes no bit.
#[test]
fn a_render_that_does_everything_gives_the_same_picture() {
    let changes = changes();
    for mode in [Mode::Direct, Mode::Path, Mode::Ao, Mode::Normals] {
        for (first, change) in &changes {
            for (second, other) in &changes {
                if second < first {
                    continue;
                }
                let mut scene = showroom();
                scene.render.mode = mode;
                change(&mut scene);
                other(&mut scene);
                let prepared = prepare(&scene);
                let plan = prepared.plan();
                let expected = hash(&prepared, false);
                let everything = prepared.clone().with_plan(plan.forcing_everything());
                let what = format!("{mode:?}, {first}, {second}");
                assert_eq!(hash(&everything, false), expected, "{what}");
                if first == second {
                    assert_eq!(hash(&prepared, true), expected, "{what}, with layers");
                    for feature in Feature::ALL {
                        let forced = prepared.clone().with_plan(plan.forcing(feature));
                        assert_eq!(hash(&forced, false), expected, "{what}, {feature:?}");
                    }
                }
            }
        }
    }
}

/// Where the error decides which pixels get samples, what samples cost decides too: that must not depend on what else is kept.
#[test]
fn layers_change_no_bit_where_samples_are_chosen() {
    let mut scene = showroom();
    scene.render.samples_per_pixel = 64;
    scene.render.stop.noise = Some(0.05);
    let shiny = Material::Phong {
        diffuse: Rgb::ZERO,
        specular: Rgb::splat(0.8),
        shininess: 20.0,
        textures: Textures::default(),
    };
    scene.materials.insert("wall".into(), shiny);
    let prepared = prepare(&scene);
    assert_eq!(hash(&prepared, true), hash(&prepared, false));
}

/// For each kind of random number: a change that makes it unneeded, and one mode in which it is needed else.
#[test]
fn numbers_that_decide_nothing_are_not_drawn() {
    let changes = changes();
    let cases = [
        (Decision::Pixel, Mode::Direct, "one sample"),
        (Decision::Pixel, Mode::Direct, "no antialiasing"),
        (Decision::Lens, Mode::Direct, "no lens"),
        (Decision::Lens, Mode::Path, "no depth of field"),
        (Decision::Light, Mode::Direct, "hard shadows"),
        (Decision::Light, Mode::Direct, "points only"),
        (Decision::Light, Mode::Path, "nothing shines"),
        (Decision::Light, Mode::Path, "one point"),
        (Decision::AmbientOcclusion, Mode::Direct, "no occlusion"),
        (Decision::AmbientOcclusion, Mode::Direct, "black background"),
        (Decision::Boundary, Mode::Direct, "no glass"),
        (Decision::EmitterPoint, Mode::Direct, "no lamp"),
        (Decision::Roulette, Mode::Path, "no roulette"),
        (Decision::Roulette, Mode::Path, "three bounces"),
        (Decision::Direction, Mode::Path, "nothing shines"),
    ];
    for (decision, mode, name) in cases {
        let mut scene = showroom();
        scene.render.mode = mode;
        assert!(
            work(&prepare(&scene)).draws(decision) > 0,
            "{decision:?} is drawn"
        );
        changes[name](&mut scene);
        assert_eq!(
            work(&prepare(&scene)).draws(decision),
            0,
            "{decision:?}, {name}"
        );
    }
    let mut scene = showroom();
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1;
    scene.render.light_sampling = LightSampling::Nee;
    // It is not aimed at.
    scene.background = Background::default();
    let scene = prepare(&scene);
    assert_eq!(
        work(&scene).draws(Decision::Direction),
        0,
        "the last surface scatters nothing"
    );
}

/// One ray for all samples of a pixel that look along one line; in a render, for those of one pass.
#[test]
fn samples_that_look_along_one_line_share_a_ray() {
    let mut scene = showroom();
    scene.render.samples_per_pixel = 64;
    let pixels = scene.render.pixel_count();
    let taken = |scene: &Scene| {
        let prepared = prepare(scene);
        let stats = run(scene).stats;
        assert_eq!(stats.samples, 64 * pixels);
        (work(&prepared).rays.camera, stats.rays.camera, stats.passes)
    };
    let (camera, in_render, _) = taken(&scene);
    assert_eq!((camera, in_render), (64 * pixels, 64 * pixels));
    changes()["pinhole and no antialiasing"](&mut scene);
    let (camera, in_render, passes) = taken(&scene);
    assert_eq!(
        (camera, in_render),
        (pixels, u64::from(passes) * pixels),
        "{passes} passes"
    );
    assert_eq!(passes, even_passes(64));
    let scene = prepare(&scene);
    for feature in [Feature::EyeRays, Feature::PixelPoints, Feature::Lens] {
        let again = scene.clone().with_plan(scene.plan().forcing(feature));
        assert_eq!(work(&again).rays.camera, 64 * pixels, "{feature:?}");
    }
}

type Count<'a> = &'a dyn Fn(&Work) -> u64;

/// For each kind of ray: a change that makes it unneeded; a render that does everything traces it all the same.
#[test]
fn rays_that_bring_nothing_are_not_traced() {
    let changes = changes();
    let bounce = |work: &Work| work.rays.bounce;
    let shadow = |work: &Work| work.rays.shadow;
    let occlusion = |work: &Work| work.rays.ambient_occlusion;
    let cases: [(Count<'_>, Mode, &str); 5] = [
        (&shadow, Mode::Direct, "no shadows"),
        (&shadow, Mode::Direct, "nothing shines"),
        (&occlusion, Mode::Direct, "black background"),
        (&occlusion, Mode::Direct, "no occlusion"),
        (&bounce, Mode::Path, "nothing shines"),
    ];
    for (count, mode, name) in cases {
        let mut scene = showroom();
        scene.render.mode = mode;
        assert!(
            count(&work(&prepare(&scene))) > 0,
            "{name}: traced where needed"
        );
        changes[name](&mut scene);
        let scene = prepare(&scene);
        assert_eq!(count(&work(&scene)), 0, "{name}");
        let everything = scene.plan().forcing_everything();
        let everything = work(&scene.with_plan(everything));
        assert!(
            count(&everything) > 0,
            "{mode:?}, {name}: traced for nothing"
        );
    }
    // Without mirrors and glass nothing goes on in mode direct.
    let mut scene = showroom();
    scene.render.mirror = false;
    scene.render.glass = false;
    assert_eq!(work(&prepare(&scene)).rays.bounce, 0);
}

/// A mirror's last ray is there for what shines alone; a black emitter does not.
#[test]
fn the_last_ray_of_a_mirror_looks_for_light_only() {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 50.0, DVec3::Y * 50.0);
    let reflectance = Rgb::splat(0.8);
    add(&mut scene, "floor", floor, Material::Mirror { reflectance });
    let lamp = rectangle(DVec3::Z * 20.0, DVec3::X, DVec3::Y);
    let radiance = Rgb::ZERO;
    add(&mut scene, "lamp", lamp, Material::Emitter { radiance });
    scene.lights = vec![Light::Point {
        position: DVec3::Z * 3.0,
        intensity: Rgb::ONE,
    }];
    scene.camera = Camera {
        eye: DVec3::new(0.1, -3.0, 8.0),
        target: DVec3::ZERO,
        vertical_fov: Degrees(30.0),
        ..Camera::default()
    };
    (scene.render.width, scene.render.height) = (10, 8);
    scene.render.samples_per_pixel = 2;
    scene.render.max_bounces = 1;
    for mode in [Mode::Direct, Mode::Path] {
        scene.render.mode = mode;
        let prepared = prepare(&scene);
        assert_eq!(work(&prepared).rays.bounce, 0, "{mode:?}");
        let plan = prepared.plan().forcing(Feature::DarkRays);
        let forced = prepared.clone().with_plan(plan);
        assert_eq!(work(&forced).rays.bounce, 160, "{mode:?}");
        assert_eq!(hash(&forced, false), hash(&prepared, false), "{mode:?}");
        let mut lit = scene.clone();
        let radiance = Rgb::ONE;
        lit.materials
            .insert("lamp".into(), Material::Emitter { radiance });
        assert_eq!(work(&prepare(&lit)).rays.bounce, 160, "{mode:?}");
    }
}

/// Reasons name what holds of the scene: each by the settings that make it so.
#[test]
fn reasons_are_those_of_the_scene() {
    let reason = |scene: &Scene, wanted: Feature| {
        let all = reasons(scene).expect("all is loaded");
        let found = all.into_iter().find(|(feature, _)| *feature == wanted);
        found.expect("every feature has its place").1
    };
    let changed = |mode: Mode, edit: Edit| {
        let mut scene = showroom();
        scene.render.mode = mode;
        edit(&mut scene);
        scene
    };
    let only_glass: Edit = |s| s.objects.retain(|object| object.name == "ball");
    let cases: [(Mode, Edit, Feature, Option<&str>); 9] = [
        (
            Mode::Normals,
            |_| {},
            Feature::ShadowRays,
            Some("the mode shows no light"),
        ),
        (
            Mode::Depth,
            |_| {},
            Feature::Roulette,
            Some("the mode shows no light"),
        ),
        (
            Mode::Ao,
            |s| s.objects.clear(),
            Feature::Occlusion,
            Some("nothing is there"),
        ),
        (
            Mode::Direct,
            only_glass,
            Feature::Aiming,
            Some("nothing scatters light"),
        ),
        (
            Mode::Direct,
            only_glass,
            Feature::ShadowRays,
            Some("nothing is aimed at"),
        ),
        (
            Mode::Path,
            only_glass,
            Feature::LastRays,
            Some("nothing scatters light"),
        ),
        (Mode::Path, only_glass, Feature::Roulette, None),
        (
            Mode::Direct,
            |s| s.render.max_bounces = 0,
            Feature::Occlusion,
            Some("render.max_bounces is 0"),
        ),
        (
            Mode::Path,
            |s| s.objects.clear(),
            Feature::Roulette,
            Some("nothing reflects light"),
        ),
    ];
    for (mode, edit, feature, expected) in cases {
        let scene = changed(mode, edit);
        assert_eq!(reason(&scene, feature), expected, "{mode:?}, {feature:?}");
        // What the plan leaves out for it, the picture does without.
        let prepared = prepare(&scene);
        let everything = prepared.plan().forcing_everything();
        let forced = prepared.clone().with_plan(everything);
        assert_eq!(hash(&forced, false), hash(&prepared, false), "{mode:?}");
    }
}

/// Shadow rays, counted by hand: of a floor that faces one point light and lies behind another, one each for the first only.
#[test]
fn each_light_in_front_takes_one_ray() {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 50.0, DVec3::Y * 50.0);
    add(&mut scene, "floor", floor, diffuse(0.5));
    let point = |z: f64, intensity: f64| Light::Point {
        position: DVec3::new(0.3, 0.2, z),
        intensity: Rgb::splat(intensity),
    };
    scene.lights = vec![point(3.0, 1.0), point(-3.0, 1.0), point(2.0, 0.0)];
    scene.camera = Camera {
        eye: DVec3::new(0.1, -3.0, 8.0),
        target: DVec3::ZERO,
        vertical_fov: Degrees(30.0),
        ..Camera::default()
    };
    scene.render.width = 10;
    scene.render.height = 8;
    scene.render.samples_per_pixel = 3;
    let prepared = prepare(&scene);
    let found = work(&prepared);
    assert_eq!(found.samples, 240);
    assert_eq!(found.rays.shadow, 240);
    let plan = prepared.plan().forcing(Feature::DarkRays);
    assert_eq!(work(&prepared.with_plan(plan)).rays.shadow, 720);
}

#[test]
fn the_picture_of_nothing_takes_its_camera_rays_and_no_random_number() {
    let mut scene = Scene::default();
    (scene.render.width, scene.render.height) = (40, 30);
    scene.render.samples_per_pixel = 1;
    for mode in [Mode::Direct, Mode::Path] {
        scene.render.mode = mode;
        let found = work(&prepare(&scene));
        assert_eq!(found.samples, 1200);
        assert_eq!((found.rays.camera, found.rays.total()), (1200, 1200));
        assert_eq!(found.all_draws(), 0);
        assert!(
            reasons(&scene)
                .expect("all materials")
                .iter()
                .all(|(_, reason)| reason.is_some())
        );
    }
}

/// The plan of a scene under a black image is that of one under nothing.
#[test]
fn a_black_sky_is_not_needed() {
    let [mut image, mut nothing] = [showroom(), showroom()];
    set_sky(&mut image, 0.0);
    nothing.background = Background::default();
    for mode in [Mode::Direct, Mode::Path] {
        image.render.mode = mode;
        nothing.render.mode = mode;
        let plans = [&image, &nothing].map(|scene| reasons(scene).expect("all is loaded"));
        assert_eq!(plans[0], plans[1], "{mode:?}");
    }
}

/// Triangles that are shaded flat have no normals, and those of an object that is smooth take some.
#[test]
fn flat_objects_store_no_normals() {
    let mut scene = showroom();
    assert_eq!(prepare(&scene).geometry().normal_bytes(), 0);
    scene.objects[3].smooth = true;
    assert!(prepare(&scene).geometry().normal_bytes() > 0);
}

/// A change of camera, light or material keeps the triangles and their tree.
#[test]
fn edits_that_move_no_triangle_build_nothing() {
    let scene = showroom();
    let before = prepare(&scene);
    let edits: [Edit; 3] = [
        |s| s.camera.eye.x += 0.1,
        |s| s.lights[0].move_to(DVec3::splat(3.0)),
        |s| {
            s.materials.insert("floor".into(), diffuse(0.1));
        },
    ];
    for edit in edits {
        let mut scene = scene.clone();
        edit(&mut scene);
        let after = PreparedScene::prepare(&scene, Some(&before), &CancelToken::new());
        let after = after.expect("can be rendered").expect("nobody cancels");
        assert!(Arc::ptr_eq(after.geometry(), before.geometry()));
    }
}

/// A render on all cores by which the store learns what the rays from the eye hit, or uses what it knows: hash and camera rays.
fn render_with(store: &PrimaryHitStore, scene: &Scene, previous: &PreparedScene) -> (String, u64) {
    let prepared = PreparedScene::prepare(scene, Some(previous), &CancelToken::new());
    let prepared = prepared.expect("can be rendered").expect("nobody cancels");
    let prepared = prepared.with_primary_hits(store);
    let (run, progress) = (RunConfig::default(), RenderProgress::default());
    let outcome = render(&prepared, None, &run, &progress, None).expect("nobody cancels");
    let samples = outcome.stats.samples;
    assert_eq!(samples, 24 * 16 * u64::from(scene.render.samples_per_pixel));
    (outcome.image.hash(), outcome.stats.rays.camera)
}

/// Where all samples of a pixel send the same ray, it is traced once, and not again for a new light or material; a new camera, size
/// or visible disk, near which rays start elsewhere, makes it another ray.
#[test]
fn rays_from_the_eye_are_traced_once_for_all_lights_and_materials() {
    let edits: [(&str, Edit, bool); 7] = [
        ("nothing", |_| {}, true),
        ("light", |s| s.lights[0].move_to(DVec3::splat(2.0)), true),
        (
            "material",
            |s| {
                s.materials.insert("floor".into(), diffuse(0.1));
            },
            true,
        ),
        ("shadows", |s| s.render.shadows = Shadows::Hard, true),
        ("camera", |s| s.camera.eye.x += 0.01, false),
        ("geometry", |s| s.objects[1].translate.x += 0.1, false),
        (
            "visible disk",
            |s| s.lights[4].move_to(DVec3::splat(9.0)),
            false,
        ),
    ];
    for samples in [1, 4] {
        for (name, edit, is_known) in edits {
            for mode in [Mode::Direct, Mode::Path] {
                let mut scene = showroom();
                scene.camera.aperture_radius = 0.0;
                scene.render.antialiasing = false;
                scene.render.samples_per_pixel = samples;
                scene.render.mode = mode;
                let store = PrimaryHitStore::default();
                let first = prepare(&scene);
                let (found, camera_rays) = render_with(&store, &scene, &first);
                assert_eq!(found, hash(&first, false));
                assert_eq!(camera_rays, 24 * 16);
                edit(&mut scene);
                let (found, camera_rays) = render_with(&store, &scene, &first);
                assert_eq!(found, hash(&prepare(&scene), false), "{name}");
                assert_eq!(camera_rays == 0, is_known, "{name}: {camera_rays} rays");
            }
        }
    }
    let store = PrimaryHitStore::default();
    let scene = prepare(&showroom()).with_primary_hits(&store);
    assert!(!scene.keeps_primary_hits(), "each sample sends another ray");
}

/// Clear glass of index 1 is not there, and neither is glass without triangles: shadow rays need not look for it.
#[test]
fn glass_that_is_not_there_is_not_looked_for() {
    let needs_it = |scene: &Scene| prepare(scene).plan().needs(Feature::GlassShadows);
    let mut scene = showroom();
    assert!(needs_it(&scene));
    let glass = |ior: f64| Material::Glass {
        ior,
        attenuation: DVec3::ZERO,
    };
    scene.materials.insert("ball".into(), glass(1.0));
    assert!(!needs_it(&scene));
    scene.materials.insert("ball".into(), glass(1.1));
    assert!(needs_it(&scene));
    scene.meshes.insert("ball".into(), Arc::default());
    assert!(!needs_it(&scene));
}

#[test]
fn few_triangles_need_no_node() {
    let mut scene = Scene::default();
    for number in 0..4 {
        let place = DVec3::new(f64::from(number), 0.0, 0.0);
        let square = rectangle(place, DVec3::Y, DVec3::Z);
        add(&mut scene, &number.to_string(), square, diffuse(0.5));
    }
    let ray = Ray::new(Vec3::new(-1.0, 0.01, 0.02), Vec3::X);
    let visits = |scene: &Scene| {
        prepare(scene)
            .geometry()
            .accelerator()
            .visits(&ray, f32::INFINITY, false)
    };
    assert_eq!(visits(&scene).nodes, 0);
    assert!(visits(&scene).blocks > 0);
    add(&mut scene, "ball", shapes::icosphere(2), diffuse(0.5));
    assert!(visits(&scene).nodes > 0);
}

#[test]
fn a_plan_knows_what_it_forces() {
    let mut scene = showroom();
    scene.camera.aperture_radius = 0.0;
    let plan = Plan::of(&scene).expect("all materials are there");
    assert!(!plan.does(Feature::Lens));
    let forced = plan.forcing(Feature::Lens);
    assert!(forced.does(Feature::Lens) && !forced.needs(Feature::Lens));
}

/// What `raymini plan --proofs` shows: whatever is left out is counted 0 times, more otherwise, and the picture is the same.
#[test]
fn every_proof_holds() {
    let mut scene = raymini::io::demo_scene();
    (scene.render.width, scene.render.height) = (96, 54);
    let bench = Bench {
        scene: &scene,
        pairs: 1,
    };
    for case in cases() {
        let finding = case.run(&bench).expect("can be rendered");
        assert!(finding.holds(), "{case:?}: {finding:?}");
    }
}
