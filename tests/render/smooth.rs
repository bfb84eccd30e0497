//! Smooth shading of coarse meshes: no facets where light turns away, no black silhouettes.

use crate::common::{add, diffuse, picture};
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec3, Degrees};
use raymini::scene::{
    Background, Camera, Facing, Light, Material, Mode, RenderSettings, Rgb, Scene,
};

/// A smooth unit ball of `20 · 4^subdivisions` triangles in the middle of the picture.
fn ball(subdivisions: u32, material: Material) -> Scene {
    smooth(shapes::icosphere(subdivisions), material)
}

/// A smooth mesh in the middle of the picture.
fn smooth(mesh: TriangleMesh, material: Material) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, "ball", mesh, material);
    scene.objects[0].smooth = true;
    scene.camera = Camera {
        eye: DVec3::new(1.5, -6.0, 2.0),
        target: DVec3::ZERO,
        vertical_fov: Degrees(18.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 96,
        height: 96,
        samples_per_pixel: 1,
        ..RenderSettings::default()
    };
    scene
}

/// Where the shading normal faces the light, a ball shines as the cosine says, down to the terminator, however coarse.
#[test]
fn no_facet_is_dark_before_the_terminator() {
    let light = DVec3::new(40.0, -10.0, 25.0);
    for subdivisions in [1, 2, 3] {
        let mut scene = ball(subdivisions, diffuse(1.0));
        scene.render.mode = Mode::Normals;
        let normals = picture(&scene);
        scene.render.mode = Mode::Object;
        let objects = picture(&scene);
        scene.render.mode = Mode::Direct;
        scene.lights.push(Light::Point {
            position: light,
            intensity: Rgb::splat(light.length_squared() * std::f64::consts::PI),
        });
        let lit = picture(&scene);
        let (mut near_terminator, mut dark) = (0, 0);
        for ((normal, lit), object) in normals.pixels.iter().zip(&lit.pixels).zip(&objects.pixels) {
            if *object == [0.0; 3] {
                continue;
            }
            let normal = DVec3::from_array(normal.map(|c| f64::from(c) * 2.0 - 1.0));
            let cosine = normal.dot(light.normalize());
            let lit = f64::from(lit[0]);
            if cosine > 0.05 {
                near_terminator += u32::from(cosine < 0.3);
                // The light is 48 radii away, so that its direction and distance vary a little over the ball.
                assert!(
                    (lit - cosine).abs() < 0.08,
                    "{subdivisions}: {lit} {cosine}"
                );
            } else if cosine < -0.05 {
                dark += 1;
                assert!(lit < 1e-6, "{subdivisions}: {lit} at {cosine}");
            }
        }
        assert!(
            near_terminator > 150 && dark > 500,
            "{near_terminator} {dark}"
        );
    }
}

/// A convex mirror of reflectance 1 in a white furnace is invisible, silhouette included: one reflection leads away from it.
#[test]
fn a_smooth_mirror_has_no_black_silhouette() {
    let mirror = Material::Mirror {
        reflectance: Rgb::ONE,
    };
    // A cube's normals lean far from its faces.
    let cube = shapes::cuboid(DVec3::splat(-0.6), DVec3::splat(0.6));
    for mesh in [shapes::icosphere(0), shapes::icosphere(2), cube] {
        for mode in [Mode::Direct, Mode::Path] {
            let mut scene = smooth(mesh.clone(), mirror.clone());
            scene.render.mode = mode;
            scene.render.max_bounces = 1;
            scene.render.samples_per_pixel = 8;
            scene.background = Background::Constant { radiance: Rgb::ONE };
            for pixel in &picture(&scene).pixels {
                assert!((pixel[0] - 1.0).abs() < 1e-5, "{pixel:?}");
            }
        }
    }
}

/// A smooth matt ball of albedo 1 under an even sky: every direction over the shading normal reaches the sky.
#[test]
fn a_smooth_matt_ball_in_a_white_furnace_is_invisible() {
    for subdivisions in [0, 1, 3] {
        let mut scene = ball(subdivisions, diffuse(1.0));
        scene.render.mode = Mode::Path;
        scene.render.roulette = false;
        scene.render.max_bounces = 64;
        scene.render.samples_per_pixel = 8;
        scene.background = Background::Constant { radiance: Rgb::ONE };
        for pixel in &picture(&scene).pixels {
            assert!((pixel[0] - 1.0).abs() < 1e-5, "{subdivisions}: {pixel:?}");
        }
    }
}

/// A coarse ball throws a shadow and lets no light through.
#[test]
fn no_light_leaks_through_a_smooth_ball() {
    let mut scene = ball(1, diffuse(1.0));
    scene.lights.push(Light::Disk {
        center: DVec3::new(0.0, 5.0, 0.0),
        facing: Facing::Normal(-DVec3::Y),
        radius: 0.5,
        radiance: Rgb::splat(100.0),
        visible: false,
    });
    scene.render.samples_per_pixel = 4;
    let picture = picture(&scene);
    // The side towards the camera looks away from the light.
    for y in 40..56 {
        for x in 40..56 {
            assert_eq!(picture.pixel(x, y), [0.0; 3]);
        }
    }
}
