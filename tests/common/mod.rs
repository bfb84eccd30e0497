//! What several test files share: small scenes and their values.
#![allow(dead_code, reason = "each test file uses a part")]

use std::sync::Arc;

use raymini::control::CancelToken;
use raymini::geometry::TriangleMesh;
use raymini::math::{DVec3, Degrees};
use raymini::render::{Image, PreparedScene, RenderOutcome, RenderProgress, RunConfig, render};
use raymini::scene::{Camera, Material, Object, RenderSettings, Rgb, Scene};

/// A matt material.
pub fn diffuse(reflectance: f64) -> Material {
    Material::Phong {
        diffuse: Rgb::splat(reflectance),
        specular: Rgb::ZERO,
        shininess: 1.0,
    }
}

/// The rectangle `center ± u ± v`, as two triangles.
pub fn rectangle(center: DVec3, u: DVec3, v: DVec3) -> TriangleMesh {
    TriangleMesh {
        positions: vec![
            center - u - v,
            center + u - v,
            center + u + v,
            center - u + v,
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
    }
}

/// Adds a mesh of its own material.
pub fn add(scene: &mut Scene, name: &str, mesh: TriangleMesh, material: Material) {
    scene.meshes.insert(name.into(), Arc::new(mesh));
    scene.materials.insert(name.into(), material);
    scene.objects.push(Object {
        name: name.into(),
        mesh: name.into(),
        material: Some(name.into()),
        ..Object::default()
    });
}

/// One pixel that sees the point `(x, 0, 0)` of a floor from the side.
pub fn looking_at_floor(x: f64, material: Material) -> Scene {
    let mut scene = Scene::default();
    add(
        &mut scene,
        "floor",
        rectangle(DVec3::ZERO, DVec3::X * 20.0, DVec3::Y * 20.0),
        material,
    );
    scene.camera = Camera {
        eye: DVec3::new(x, -8.0, 0.2),
        target: DVec3::new(x, 0.0, 0.0),
        vertical_fov: Degrees(1e-4),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 1,
        height: 1,
        samples_per_pixel: 4096,
        antialiasing: false,
        ..RenderSettings::default()
    };
    scene
}

/// A render on all cores; it must hold no sample that is not a number.
pub fn run(scene: &Scene) -> RenderOutcome {
    let prepared =
        PreparedScene::prepare(scene, None, &CancelToken::new()).expect("can be rendered");
    let prepared = prepared.expect("nobody cancels");
    let outcome = render(
        &prepared,
        None,
        &RunConfig::default(),
        &RenderProgress::default(),
        &|_| (),
    );
    let outcome = outcome.expect("nobody cancels");
    assert_eq!(outcome.stats.non_finite_samples, 0);
    outcome
}

/// Its picture.
pub fn picture(scene: &Scene) -> Image {
    run(scene).image
}

/// The red value of its only, or top left, pixel.
pub fn value(scene: &Scene) -> f64 {
    f64::from(picture(scene).pixel(0, 0)[0])
}

/// Asserts a relative distance.
#[track_caller]
pub fn assert_near(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{what}: {found}, not {expected}"
    );
}
