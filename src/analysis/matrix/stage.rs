//! What the cases share: small scenes, their renders, and how two pictures differ.

use std::sync::Arc;

use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::math::{DVec3, Degrees};
use crate::render::{Image, PreparedScene, RenderOutcome, RenderProgress, RunConfig, render};
use crate::scene::{
    Background, Camera, Facing, Light, Material, Object, RenderSettings, Rgb, Scene, Textures,
};

/// A matt material that reflects this share.
pub fn matt(reflectance: f64) -> Material {
    phong(reflectance, 0.0, 1.0)
}

/// A grey material.
pub fn phong(diffuse: f64, specular: f64, shininess: f64) -> Material {
    Material::Phong {
        diffuse: Rgb::splat(diffuse),
        specular: Rgb::splat(specular),
        shininess,
        textures: Textures::default(),
    }
}

/// Clear glass.
pub fn glass(ior: f64) -> Material {
    Material::Glass {
        ior,
        attenuation: Rgb::ZERO,
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

/// All triangles of all `meshes`.
pub fn joined(meshes: impl IntoIterator<Item = TriangleMesh>) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = u32::try_from(all.positions.len()).expect("small meshes");
        all.positions.extend(mesh.positions);
        let triangles = mesh.triangles.into_iter();
        all.triangles
            .extend(triangles.map(|t| t.map(|vertex| vertex + first)));
    }
    all
}

/// `mesh` with every vertex mapped.
pub fn mapped(mut mesh: TriangleMesh, mut f: impl FnMut(DVec3) -> DVec3) -> TriangleMesh {
    mesh.positions.iter_mut().for_each(|p| *p = f(*p));
    mesh
}

/// A scene of `width` × `height` pixels with one sample each, at their centres.
pub fn still(width: u32, height: u32) -> Scene {
    Scene {
        render: RenderSettings {
            width,
            height,
            samples_per_pixel: 1,
            ..RenderSettings::default()
        },
        ..Scene::default()
    }
}

/// Adds a mesh of its own material, which is called as the object is.
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

/// One pixel that sees the point `(x, 0, 0)` of a floor, from the side at `degrees` off its normal.
pub fn spot_of_floor(x: f64, degrees: f64, material: Material) -> Scene {
    let mut scene = still(1, 1);
    let (u, v) = (DVec3::X * 20.0, DVec3::Y * 20.0);
    add(&mut scene, "floor", rectangle(DVec3::ZERO, u, v), material);
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let target = DVec3::X * x;
    scene.camera = Camera {
        eye: target + DVec3::new(0.0, -sin, cos) * 8.0,
        target,
        up: DVec3::new(0.0, cos, sin),
        vertical_fov: Degrees(1e-4),
        ..Camera::default()
    };
    scene.render.antialiasing = false;
    scene
}

/// A one-sided disk that shines down, of radiance 1.
pub fn lamp(center: DVec3, radius: f64) -> Light {
    Light::Disk {
        center,
        facing: Facing::Normal(DVec3::NEG_Z),
        radius,
        radiance: Rgb::ONE,
        visible: false,
    }
}

/// A point light of equal channels.
pub fn point(position: DVec3, intensity: f64) -> Light {
    Light::Point {
        position,
        intensity: Rgb::splat(intensity),
    }
}

/// Radiance 1 from everywhere.
pub fn white() -> Background {
    Background::Constant { radiance: Rgb::ONE }
}

/// A little of everything: smooth and flat bodies, a mirror, glass, a lamp, a point light, a lens, on a floor of side `2 · reach`.
pub fn showroom(width: u32, height: u32) -> Scene {
    use crate::geometry::shapes;
    let mut scene = still(width, height);
    let ball = |at: DVec3, radius: f64| mapped(shapes::icosphere(3), |p| p * radius + at);
    let (u, v) = (DVec3::X * 4.0, DVec3::Y * 4.0);
    let floor = rectangle(DVec3::new(0.0, 0.0, -1.0), u, v);
    add(&mut scene, "floor", floor, phong(0.6, 0.3, 20.0));
    add(
        &mut scene,
        "matt",
        ball(DVec3::new(-1.3, 0.2, -0.3), 0.7),
        matt(0.7),
    );
    scene.objects[1].smooth = true;
    add(
        &mut scene,
        "mirror",
        ball(DVec3::new(1.2, 0.9, -0.2), 0.8),
        Material::mirror(),
    );
    add(
        &mut scene,
        "glass",
        ball(DVec3::new(0.4, -1.1, -0.5), 0.5),
        glass(1.5),
    );
    scene.lights = vec![
        lamp(DVec3::new(0.5, -0.5, 3.0), 0.6),
        point(DVec3::new(-3.0, -3.0, 4.0), 9.0),
    ];
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.2),
    };
    scene.camera.aperture_radius = 0.02;
    scene
}

/// A render on all cores.
pub fn run(scene: &Scene) -> RenderOutcome {
    run_on(scene, 0)
}

/// A render on so many threads.
pub fn run_on(scene: &Scene, threads: usize) -> RenderOutcome {
    let run = RunConfig {
        threads,
        ..RunConfig::default()
    };
    render(
        &prepared(scene),
        None,
        &run,
        &RenderProgress::default(),
        None,
    )
    .expect("nobody cancels")
}

/// The scene as rendering reads it.
pub fn prepared(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared
        .unwrap_or_else(|error| panic!("cannot be rendered: {error}"))
        .expect("nobody cancels")
}

/// Its picture.
pub fn picture(scene: &Scene) -> Image {
    run(scene).image
}

/// The red value of the only, or top left, pixel.
pub fn value(scene: &Scene) -> f64 {
    f64::from(picture(scene).pixel(0, 0)[0])
}

/// `|found / expected − 1|`.
pub fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// The largest of `figures`; not a number where any is not, 0 where there are none.
pub fn largest(figures: impl IntoIterator<Item = f64>) -> f64 {
    figures.into_iter().fold(
        0.0,
        |largest, figure| {
            if figure <= largest { largest } else { figure }
        },
    )
}

/// How many pixels of two pictures are not the same bits, or are no proper light; all where the sizes differ.
pub fn different_pixels(a: &Image, b: &Image) -> f64 {
    if (a.width, a.height) != (b.width, b.height) {
        return f64::from(a.width) * f64::from(a.height);
    }
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| {
        a.map(f32::to_bits) != b.map(f32::to_bits) || !is_light(a)
    };
    a.pixels.iter().zip(&b.pixels).filter(differ).count() as f64
}

/// The share of pixels that differ by more than 1/255 of `white` in a channel, or are no proper light, in per cent.
pub fn visibly_different(a: &Image, b: &Image, white: f32) -> f64 {
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| {
        let is_near = |channel: usize| (a[channel] - b[channel]).abs() <= white / 255.0;
        !(is_light(a) && (0..3).all(is_near))
    };
    let count = a.pixels.iter().zip(&b.pixels).filter(differ).count();
    100.0 * count as f64 / a.pixels.len() as f64
}

/// How many pixels are infinite, negative, or not a number.
pub fn improper_pixels(image: &Image) -> f64 {
    image.pixels.iter().filter(|pixel| !is_light(pixel)).count() as f64
}

/// That there is something in a picture that others are compared with: a third of it is not black.
#[track_caller]
pub fn assert_shows_something(image: &Image) {
    let is_lit = |pixel: &&[f32; 3]| pixel.iter().any(|&channel| channel > 0.01);
    let lit = image.pixels.iter().filter(is_lit).count();
    let count = image.pixels.len();
    assert!(
        3 * lit > count,
        "only {lit} of {count} pixels are not black"
    );
}

fn is_light(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|&c| c.is_finite() && c >= 0.0)
}

/// The mean of a red channel over seeds, and its standard error.
pub fn mean_over_seeds(scene: &mut Scene, seeds: u32) -> (f64, f64) {
    let means: Vec<f64> = (0..seeds)
        .map(|seed| {
            scene.render.seed = u64::from(seed);
            let image = picture(scene);
            let sum: f64 = image.pixels.iter().map(|p| f64::from(p[0])).sum();
            sum / image.pixels.len() as f64
        })
        .collect();
    let count = f64::from(seeds);
    let mean = means.iter().sum::<f64>() / count;
    let square: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
    (mean, (square / (count - 1.0) / count).sqrt())
}
