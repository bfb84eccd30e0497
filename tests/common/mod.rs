//! What several test files share: small scenes and their values.
#![allow(dead_code, reason = "each test file uses a part")]

use std::ops::Range;
use std::sync::Arc;

use raymini::control::CancelToken;
use raymini::geometry::TriangleMesh;
use raymini::math::{DVec3, Degrees};
use raymini::render::{Image, PreparedScene, RenderOutcome, RenderProgress, RunConfig, render};
use raymini::scene::{
    Camera, LightSampling, Material, Object, RenderSettings, Rgb, Scene, Textures,
};

/// A matt material.
pub fn diffuse(reflectance: f64) -> Material {
    Material::Phong {
        diffuse: Rgb::splat(reflectance),
        specular: Rgb::ZERO,
        shininess: 1.0,
        textures: Textures::default(),
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
        ..TriangleMesh::default()
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
        None,
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

/// Every way in which paths find light.
pub const WAYS: [LightSampling; 3] = [LightSampling::Mis, LightSampling::Nee, LightSampling::Bsdf];

/// Asserts that all ways find the same light in every pixel: the difference of the means over 64 seeds, in standard deviations,
/// stays below 4.4. α = 0.0011 for three comparisons of 16 pixels each, twice over.
#[track_caller]
pub fn assert_ways_agree(scene: &mut Scene, what: &str) {
    let means = WAYS.map(|way| {
        scene.render.light_sampling = way;
        let first = 1000 * (way as u64);
        (way, means_over_seeds(scene, first..first + 64))
    });
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let ((a, means_a), (b, means_b)) = (&means[a], &means[b]);
        assert_same_means(means_a, means_b, &format!("{what}, {a:?} and {b:?}"));
    }
}

/// The mean of each pixel's red value over renders with these seeds, and the variance of that mean.
pub fn means_over_seeds(scene: &Scene, seeds: Range<u64>) -> Vec<(f64, f64)> {
    let mut scene = scene.clone();
    let runs: Vec<Image> = seeds
        .map(|seed| {
            scene.render.seed = seed;
            picture(&scene)
        })
        .collect();
    let count = runs.len() as f64;
    let of_pixel = |pixel: usize| {
        let values = runs.iter().map(|run| f64::from(run.pixels[pixel][0]));
        let mean = values.clone().sum::<f64>() / count;
        let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, variance / count)
    };
    (0..runs[0].pixels.len()).map(of_pixel).collect()
}

/// Asserts that the means of each pixel are less than 4.4 standard deviations of their difference apart.
#[track_caller]
pub fn assert_same_means(a: &[(f64, f64)], b: &[(f64, f64)], what: &str) {
    for (pixel, ((mean_a, variance_a), (mean_b, variance_b))) in a.iter().zip(b).enumerate() {
        let z = (mean_a - mean_b) / (variance_a + variance_b).sqrt().max(1e-12);
        assert!(
            z.abs() < 4.4,
            "{what}, pixel {pixel}: {mean_a}, {mean_b}, z = {z}"
        );
    }
}
