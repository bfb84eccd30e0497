//! Ambient occlusion against its closed forms, all weighted by the cosine.

use crate::common::{add, assert_near, diffuse, looking_at_floor, rectangle, run, value};
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec3, Degrees};
use raymini::scene::{AmbientOcclusion, Background, Camera, Mode, Rgb, Scene};

/// The ambient-occlusion picture of a floor point at distance `d` from a wall of height `h`, rays limited to `radius`.
fn occlusion_at_wall(d: f64, h: f64, radius: f64) -> f64 {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    add(
        &mut scene,
        "wall",
        rectangle(
            DVec3::new(d, 0.0, h / 2.0),
            DVec3::Y * 200.0,
            DVec3::Z * (h / 2.0),
        ),
        diffuse(1.0),
    );
    scene.render.mode = Mode::Ao;
    scene.render.samples_per_pixel = 64;
    let diagonal = scene.bounds().diagonal();
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        samples: 256,
        radius: radius / diagonal,
    };
    value(&scene)
}

/// The share of the solid angle that an endless wall of height `h` at distance `d` leaves free: no cosine weighs it.
///
/// At an azimuth of φ from the wall, it hides what is lower than tan⁻¹(h cos φ / d), whose sine is its share.
fn free_share_uniformly(d: f64, h: f64) -> f64 {
    let steps = 10_000;
    let hidden = |step: i32| {
        let azimuth = (f64::from(step) + 0.5) / f64::from(steps) * std::f64::consts::FRAC_PI_2;
        let tangent = h * azimuth.cos() / d;
        tangent / (1.0 + tangent * tangent).sqrt()
    };
    1.0 - (0..steps).map(hidden).sum::<f64>() / f64::from(steps) / 2.0
}

/// Cosine-weighted closed forms of walls.
#[test]
fn ambient_occlusion_matches_its_closed_forms() {
    let wall = |d: f64, h: f64| 0.5 * (1.0 + d / (d * d + h * h).sqrt());
    for (d, h) in [(1.0, 1.0), (0.5, 2.0), (0.1, 1.0)] {
        assert_near(
            occlusion_at_wall(d, h, 1e4),
            wall(d, h),
            2e-3,
            &format!("wall of height {h} at {d}"),
        );
    }
    // 1 − seg(c), c = d / radius, for an infinite wall.
    for (c, expected) in [(0.25, 0.657_481_2), (0.5, 0.804_498_9), (0.9, 0.981_307_0)] {
        assert_near(
            occlusion_at_wall(c, 50.0, 1.0),
            expected,
            2e-3,
            &format!("wall at {c} of the radius"),
        );
    }
    // Directions that are uniform, not as the cosine, would see far more of the wall than the bar allows.
    assert!((free_share_uniformly(1.0, 1.0) - wall(1.0, 1.0)).abs() > 10.0 * 2e-3);
    // Further than the radius: exactly free.
    assert_eq!(
        occlusion_at_wall(1.5, 1.0, 1.0).to_bits(),
        1.0_f64.to_bits()
    );
}

#[test]
fn occlusion_scales_the_light_of_the_background() {
    let mut scene = looking_at_floor(0.0, diffuse(1.0));
    add(
        &mut scene,
        "wall",
        rectangle(DVec3::new(1.0, 0.0, 0.5), DVec3::Y * 200.0, DVec3::Z * 0.5),
        diffuse(1.0),
    );
    scene.background = Background::Constant {
        radiance: Rgb::splat(2.0),
    };
    scene.render.samples_per_pixel = 64;
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        samples: 256,
        radius: 1e3,
    };
    assert_near(
        value(&scene),
        2.0 * 0.853_553_4,
        2e-3,
        "wall (1, 1) under an even sky",
    );
    scene.render.ambient_occlusion.enabled = false;
    let outcome = run(&scene);
    assert_eq!(outcome.image.pixel(0, 0)[0].to_bits(), 2.0_f32.to_bits());
    assert_eq!(outcome.stats.rays.ambient_occlusion, 0);
}

/// The free share seen from `(a, 0, 0)` in a scene of its own, rays of any length.
fn free_share(scene: &mut Scene, eye: DVec3, a: f64) -> f64 {
    scene.camera = Camera {
        eye,
        target: DVec3::X * a,
        up: DVec3::new(0.3, 0.4, 0.5),
        vertical_fov: Degrees(1e-4),
        ..Camera::default()
    };
    scene.render.mode = Mode::Ao;
    scene.render.width = 1;
    scene.render.height = 1;
    scene.render.antialiasing = false;
    scene.render.samples_per_pixel = 64;
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        samples: 256,
        radius: 10.0,
    };
    value(scene)
}

/// A well of radius `r` and depth `h` around the Z axis, its bottom at 0, of 1024 sides.
fn well(r: f64, h: f64) -> TriangleMesh {
    let sides = 1024_u32;
    let mut positions = vec![DVec3::ZERO];
    let mut triangles = Vec::new();
    for side in 0..sides {
        let (sin, cos) = (f64::from(side) / f64::from(sides) * std::f64::consts::TAU).sin_cos();
        positions.extend([
            DVec3::new(cos * r, sin * r, 0.0),
            DVec3::new(cos * r, sin * r, h),
        ]);
        let corner = |side: u32, top: u32| 1 + 2 * (side % sides) + top;
        let (a, b) = (corner(side, 0), corner(side + 1, 0));
        let (c, d) = (corner(side + 1, 1), corner(side, 1));
        triangles.extend([[0, a, b], [a, c, b], [a, d, c]]);
    }
    TriangleMesh {
        positions,
        triangles,
        ..TriangleMesh::default()
    }
}

#[test]
fn a_well_lets_in_what_its_mouth_covers() {
    for (r, h, expected) in [
        (1.0, 1.0, 0.5),
        (1.0, 2.0, 0.2),
        (0.5, 2.0, 0.058_823_5),
        (1.0, 10.0, 0.009_901_0),
    ] {
        let mut scene = Scene::default();
        add(&mut scene, "well", well(r, h), diffuse(1.0));
        let found = free_share(&mut scene, DVec3::Z * 0.3, 0.0);
        assert_near(found, expected, 6e-3, &format!("radius {r}, depth {h}"));
    }
    for (a, expected) in [(0.5, 0.437_982_6), (0.9, 0.312_308_8)] {
        let mut scene = Scene::default();
        add(&mut scene, "well", well(1.0, 1.0), diffuse(1.0));
        let found = free_share(&mut scene, DVec3::new(a, 0.0, 0.3), a);
        assert_near(found, expected, 4e-3, &format!("{a} from the middle"));
    }
}

/// A unit ball that rests on a plane, seen from `a` beside the contact.
#[test]
fn a_ball_on_a_plane_hides_its_part_of_the_sky() {
    for (a, expected) in [
        (0.25, 0.086_924_7),
        (0.5, 0.284_458_2),
        (1.0, 0.646_446_6),
        (2.0, 0.910_557_3),
        (4.0, 0.985_733_2),
    ] {
        let mut scene = looking_at_floor(0.0, diffuse(1.0));
        add(&mut scene, "ball", shapes::icosphere(6), diffuse(1.0));
        scene.objects[1].translate = DVec3::Z;
        let found = free_share(&mut scene, DVec3::new(a, -8.0, 0.2), a);
        assert_near(found, expected, 3e-3, &format!("{a} from the contact"));
    }
}

/// A convex body occludes nothing of itself: free to the last bit, however far rays reach.
#[test]
fn a_convex_body_is_free() {
    let mut scene = Scene::default();
    add(&mut scene, "ball", shapes::icosphere(2), diffuse(1.0));
    let found = free_share(&mut scene, DVec3::new(3.0, -2.0, 1.0), 0.0);
    assert_eq!(found.to_bits(), 1.0_f64.to_bits());
}
