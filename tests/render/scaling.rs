//! A scene in another unit makes the same picture.

use std::sync::Arc;

use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::DVec3;
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{Facing, Light, Material, Mode, Object, Remeasure, Rgb, Scene};

fn in_unit(scale: f64) -> Remeasure {
    Remeasure {
        scale,
        ..Remeasure::default()
    }
}

/// Every length is twice as large, so that no rounding differs: the picture is the same to the last bits.
#[test]
fn a_scene_in_another_unit_makes_the_same_picture() {
    let mut scene = Scene::default();
    for (name, material) in [
        ("ball", Material::default()),
        (
            "glass",
            Material::Glass {
                ior: 1.5,
                attenuation: Rgb::new(0.5, 0.25, 1.0),
            },
        ),
    ] {
        scene
            .meshes
            .insert(name.into(), Arc::new(shapes::icosphere(2)));
        scene.materials.insert(name.into(), material);
        scene.objects.push(Object {
            name: name.into(),
            mesh: name.into(),
            material: Some(name.into()),
            ..Object::default()
        });
    }
    scene.objects[0].copies.count = [1, 2, 1];
    scene.objects[0].copies.step = DVec3::new(0.0, 2.5, 0.0);
    scene.objects[1].translate = DVec3::new(2.0, -1.0, 0.5);
    scene.camera.eye = DVec3::new(4.0, -6.0, 2.0);
    scene.camera.target = DVec3::new(0.5, 0.5, 0.0);
    scene.camera.aperture_radius = 0.125;
    scene.camera.focus_distance = Some(7.0);
    scene.lights = vec![
        Light::Point {
            position: DVec3::new(-2.0, -4.0, 3.0),
            intensity: Rgb::new(30.0, 20.0, 10.0),
        },
        Light::Disk {
            center: DVec3::new(3.0, -3.0, 4.0),
            facing: Facing::Target(DVec3::new(1.0, 0.0, 0.0)),
            radius: 0.5,
            radiance: Rgb::splat(8.0),
            visible: true,
        },
    ];
    (scene.render.width, scene.render.height) = (32, 24);
    scene.render.samples_per_pixel = 4;
    scene.render.mode = Mode::Path;
    let picture = |scene: &Scene| {
        let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
        let prepared = prepared.unwrap().unwrap();
        let run = RunConfig::default();
        let outcome = render(&prepared, None, &run, &RenderProgress::default(), None);
        outcome.unwrap().image
    };
    let before = picture(&scene);
    assert!(before.pixels.iter().flatten().any(|&value| value > 0.1));
    let mut larger = scene.clone();
    in_unit(2.0).apply(&mut larger);
    let after = picture(&larger);
    for (a, b) in before
        .pixels
        .iter()
        .flatten()
        .zip(after.pixels.iter().flatten())
    {
        assert!((a - b).abs() <= 1e-5 * (1.0 + a), "{a} and {b}");
    }
    in_unit(0.5).apply(&mut larger);
    assert_eq!(larger, scene);
}
