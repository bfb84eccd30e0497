//! Textures on objects, against closed forms and brute force.

use std::sync::Arc;

use crate::common::{add, assert_near, picture, rectangle};
use raymini::control::CancelToken;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec2, DVec3, Degrees, Vec3};
use raymini::render::{Feature, Image, PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{
    Background, Camera, Copies, Light, Material, Mode, Rgb, Scene, Texels, TextureImage, Textures,
};

/// A square of side 2 about the origin, facing +Z, with the whole image on it.
fn square() -> TriangleMesh {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    TriangleMesh {
        texture_coordinates: Some(corners.map(|(u, v)| DVec2::new(u, v)).to_vec()),
        ..rectangle(DVec3::ZERO, DVec3::X, DVec3::Y)
    }
}

fn textured(diffuse: f64, textures: Textures) -> Material {
    Material::Phong {
        diffuse: Rgb::splat(diffuse),
        specular: Rgb::ZERO,
        shininess: 1.0,
        textures,
    }
}

fn diffuse_image(name: &str) -> Textures {
    Textures {
        diffuse_image: Some(name.into()),
        ..Textures::default()
    }
}

fn normal_image(name: &str) -> Textures {
    Textures {
        normal_image: Some(name.into()),
        ..Textures::default()
    }
}

fn set_image(scene: &mut Scene, name: &str, width: u32, texels: Texels) {
    let height = u32::try_from(texels.len()).expect("is small") / width;
    let image = TextureImage::new(width, height, texels);
    scene.textures.insert(name.into(), Arc::new(image));
}

/// One that says the same normal everywhere: a unit vector relative to the surface.
fn set_normal(scene: &mut Scene, name: &str, normal: Vec3) {
    let texels = Texels::Floats(vec![(normal * 0.5 + 0.5).to_array()]);
    set_image(scene, name, 1, texels);
}

/// Of `mesh`, seen from straight above: the picture shows the square from (−1, −1) to (1, 1) at `side` × `side` pixels.
fn seen_from_above(mesh: TriangleMesh, material: Material, side: u32) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, "mesh", mesh, material);
    let vertical_fov = Degrees(2.0 * 0.125_f64.atan().to_degrees());
    scene.camera = Camera {
        eye: DVec3::Z * 8.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        vertical_fov,
        ..Camera::default()
    };
    (scene.render.width, scene.render.height) = (side, side);
    scene.render.samples_per_pixel = 1;
    scene.render.mode = Mode::Albedo;
    scene
}

fn prepare(scene: &Scene) -> PreparedScene {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
    prepared.expect("can be rendered").expect("nobody cancels")
}

fn image_of(prepared: &PreparedScene, threads: usize) -> Image {
    let run = RunConfig {
        threads,
        ..RunConfig::default()
    };
    let outcome = render(prepared, None, &run, &RenderProgress::default(), None);
    outcome.expect("nobody cancels").image
}

/// sRGB by IEC 61966-2-1.
fn decoded(code: u8) -> f64 {
    let code = f64::from(code) / 255.0;
    if code <= 0.04045 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

/// Texels of no order.
fn codes(count: usize) -> Vec<[u8; 3]> {
    let code = |index: usize| u8::try_from(index * index * 31 % 251).expect("fits");
    (0..count)
        .map(|i| [code(i), code(i + 100), code(i + 200)])
        .collect()
}

/// Each texel fills a pixel; turned, mirrored and as one of two copies too.
#[test]
fn a_square_seen_straight_on_shows_each_texel() {
    const SIDE: usize = 8;
    let texels = codes(SIDE * SIDE);
    let expected = |x: usize, y: usize| texels[y * SIDE + x].map(|code| 0.5 * decoded(code));
    for (rotate, scale, count) in [
        (DVec3::ZERO, 1.0, 1),
        (DVec3::Z * 90.0, 1.0, 1),
        (DVec3::ZERO, -1.0, 1),
        (DVec3::X * 180.0, -1.0, 2),
        (DVec3::Z * 90.0, 1.0, 2),
    ] {
        let mut scene = seen_from_above(square(), textured(0.5, diffuse_image("a")), 8);
        set_image(&mut scene, "a", 8, Texels::Bytes(texels.clone()));
        let object = &mut scene.objects[0];
        (object.rotate, object.scale) = (rotate, scale);
        object.copies = Copies {
            count: [count, 1, 1],
            step: DVec3::X * 40.0,
        };
        let image = picture(&scene);
        for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
            let last = SIDE - 1;
            let expected = match (rotate.x != 0.0, rotate.z != 0.0, scale < 0.0) {
                // A quarter turn counter-clockwise: what is on the right now was below.
                (_, true, _) => expected(last - y, x),
                // Through the origin: half a turn; and after half a turn about X: X is mirrored.
                (false, false, true) => expected(last - x, last - y),
                (true, false, true) => expected(last - x, y),
                _ => expected(x, y),
            };
            let found = image.pixel(u32::try_from(x).unwrap(), u32::try_from(y).unwrap());
            for (found, expected) in found.iter().zip(expected) {
                let error = (f64::from(*found) - expected).abs();
                assert!(
                    error < 2e-6,
                    "{rotate} {scale} {count}, {x},{y}: {found} {expected}"
                );
            }
        }
    }
}

/// A floor of 400 × 400 checks to the horizon. The truth is the mean over 48 × 48 places of each pixel, computed here; what pixels
/// show at one sample and at 16 is compared with it, and with what one place of each pixel would show.
#[test]
fn a_checker_far_away_fades_to_its_mean() {
    const SIDE: u32 = 32;
    let mut floor = square();
    for position in &mut floor.positions {
        *position *= 200.0;
    }
    let coordinates = floor.texture_coordinates.as_mut().expect("some");
    for uv in coordinates {
        *uv *= 200.0;
    }
    let mut scene = seen_from_above(floor, textured(1.0, diffuse_image("checker")), SIDE);
    // The smallest checker, enlarged so that its edges are sharp.
    let texel = |index: usize| {
        let (x, y) = (index % 64, index / 64);
        [if (x / 32 + y / 32) % 2 == 0 { 1.0 } else { 0.0 }; 3]
    };
    set_image(
        &mut scene,
        "checker",
        64,
        Texels::Floats((0..64 * 64).map(texel).collect()),
    );
    let eye = DVec3::new(0.3, -150.0, 3.0);
    scene.camera = Camera {
        eye,
        target: DVec3::new(5.0, 40.0, 0.0),
        up: DVec3::Z,
        vertical_fov: Degrees(0.7),
        ..Camera::default()
    };
    let axes = scene.camera.axes().expect("a direction");
    let half = 0.35_f64.to_radians().tan();
    let floor_at = |x: f64, y: f64| {
        let at = |pixel: f64| (pixel / f64::from(SIDE) * 2.0 - 1.0) * half;
        let direction = axes.forward + axes.right * at(x) - axes.up * at(y);
        eye + direction * (-eye.z / direction.z)
    };
    let shown = |x: f64, y: f64| {
        let at = floor_at(x, y);
        // Row 0 is above: the lower left check is dark.
        let check = (at.x + 200.0).floor() + (at.y + 200.0).floor();
        check.rem_euclid(2.0)
    };
    let truth = |x: u32, y: u32| {
        const PLACES: u32 = 48;
        let at = |pixel: u32, k: u32| f64::from(pixel) + (f64::from(k) + 0.5) / f64::from(PLACES);
        let places = (0..PLACES).flat_map(|i| (0..PLACES).map(move |j| (i, j)));
        let sum: f64 = places.map(|(i, j)| shown(at(x, i), at(y, j))).sum();
        sum / f64::from(PLACES * PLACES)
    };
    let pixels: Vec<_> = (0..SIDE)
        .flat_map(|y| (0..SIDE).map(move |x| (x, y)))
        .collect();
    let truths: Vec<f64> = pixels.iter().map(|&(x, y)| truth(x, y)).collect();
    let rmse = |value: &dyn Fn(u32, u32) -> f64| {
        let errors = pixels.iter().zip(&truths);
        let squares = errors.map(|(&(x, y), truth)| (value(x, y) - truth).powi(2));
        (squares.sum::<f64>() / pixels.len() as f64).sqrt()
    };
    let aliased = rmse(&|x, y| shown(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let at_samples = [1, 16, 256].map(|samples| {
        scene.render.samples_per_pixel = samples;
        let image = picture(&scene);
        rmse(&|x, y| f64::from(image.pixel(x, y)[0]))
    });
    assert!(aliased > 0.4, "{aliased}");
    for rmse in at_samples {
        assert!(rmse < 0.08 * aliased, "{at_samples:?} of {aliased}");
    }

    // Beyond a hundred checks a pixel there is nothing but their mean.
    scene.camera.eye = eye + DVec3::new(0.0, -1e5, 2e3);
    scene.camera.target = DVec3::ZERO;
    scene.camera.vertical_fov = Degrees(0.1);
    scene.render.samples_per_pixel = 1;
    let far = picture(&scene);
    let middle = far.pixel(SIDE / 2, SIDE / 2)[0];
    assert_near(f64::from(middle), 0.5, 0.02, "far away");
}

/// The light inside a ball of matt 0.5 with a lamp in its middle, many times reflected, is that of one that a grey image covers, in
/// every bit; and a convex body under an even sky shows its albedo.
#[test]
fn a_grey_image_reflects_as_a_grey_material() {
    let mut ball = shapes::icosphere(2);
    let coordinate = |p: &DVec3| DVec2::new(3.0 * p.x, p.y - p.z);
    ball.texture_coordinates = Some(ball.positions.iter().map(coordinate).collect());
    for mode in [Mode::Direct, Mode::Path] {
        let pictures = [(0.5, None), (1.0, Some("grey"))].map(|(diffuse, image)| {
            let textures = image.map(diffuse_image).unwrap_or_default();
            let mut scene = seen_from_above(ball.clone(), textured(diffuse, textures), 16);
            set_image(&mut scene, "grey", 4, Texels::Floats(vec![[0.5; 3]; 12]));
            scene.camera.eye = DVec3::new(0.1, 0.2, 0.3);
            scene.camera.vertical_fov = Degrees(70.0);
            scene.lights.push(Light::Point {
                position: DVec3::ZERO,
                intensity: Rgb::ONE,
            });
            scene.render.mode = mode;
            scene.render.samples_per_pixel = 16;
            picture(&scene)
        });
        assert!(pictures[0].pixel(3, 3)[0] > 0.1);
        assert_eq!(pictures[0].hash(), pictures[1].hash(), "{mode:?}");

        let mut scene = seen_from_above(ball.clone(), textured(0.8, diffuse_image("grey")), 8);
        set_image(&mut scene, "grey", 2, Texels::Bytes(vec![[100; 3]; 6]));
        scene.background = Background::Constant { radiance: Rgb::ONE };
        scene.render.mode = mode;
        scene.render.samples_per_pixel = 4;
        let found = f64::from(picture(&scene).pixel(4, 4)[1]);
        assert_near(found, 0.8 * decoded(100), 1e-5, "under an even sky");
    }
}

/// A rough scene of many normals, both sides seen.
fn shiny_ball(textures: Textures) -> Scene {
    let mut ball = shapes::icosphere(2);
    let coordinate = |p: &DVec3| DVec2::new(p.x + p.z, p.y - p.z);
    ball.texture_coordinates = Some(ball.positions.iter().map(coordinate).collect());
    ball.triangles.truncate(ball.triangles.len() / 2);
    let material = Material::Phong {
        diffuse: Rgb::splat(0.5),
        specular: Rgb::splat(0.4),
        shininess: 20.0,
        textures,
    };
    let mut scene = seen_from_above(ball, material, 24);
    scene.camera.vertical_fov = Degrees(18.0);
    scene.objects[0].smooth = true;
    scene.lights.push(Light::Point {
        position: DVec3::new(3.0, -4.0, 5.0),
        intensity: Rgb::splat(60.0),
    });
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.2),
    };
    scene.render.samples_per_pixel = 4;
    scene.render.mode = Mode::Direct;
    scene
}

#[test]
fn an_even_image_of_normals_changes_no_bit() {
    for mode in [Mode::Direct, Mode::Path, Mode::Normals, Mode::Ao] {
        for smooth in [false, true] {
            let hash = |textures| {
                let mut scene = shiny_ball(textures);
                set_normal(&mut scene, "even", Vec3::Z);
                set_image(
                    &mut scene,
                    "bytes",
                    1,
                    Texels::Bytes(vec![[128, 128, 255]; 3]),
                );
                scene.render.mode = mode;
                scene.objects[0].smooth = smooth;
                picture(&scene).hash()
            };
            let expected = hash(Textures::default());
            assert_eq!(hash(normal_image("even")), expected, "{mode:?}");
            assert_eq!(hash(normal_image("bytes")), expected, "{mode:?}");
        }
    }
}

/// Lambert's cosine with the normal that the image says: `ρ/π · I cos θ / d²`, on the front and the back, with the image upright,
/// mirrored, turned, and on an object that is turned itself.
#[test]
fn a_tilted_normal_is_lit_by_its_cosine() {
    type Placed = fn(DVec2) -> DVec2;

    let tilted = Vec3::new(0.48, -0.36, 0.8);
    let light = DVec3::new(0.7, 0.4, 2.0);
    // The image's axes in the plane of the square.
    let cases: [(Placed, [DVec3; 2]); 4] = [
        (|uv| uv, [DVec3::X, DVec3::Y]),
        (|uv| DVec2::new(1.0 - uv.x, uv.y), [DVec3::NEG_X, DVec3::Y]),
        (|uv| DVec2::new(uv.y, uv.x), [DVec3::Y, DVec3::X]),
        (
            |uv| DVec2::new(5.0 * uv.y, -0.1 * uv.x),
            [DVec3::Y, DVec3::NEG_X],
        ),
    ];
    for (placed, [first, second]) in cases {
        for (from_below, turn) in [(false, 0.0), (true, 0.0), (false, 90.0)] {
            let mut mesh = square();
            let coordinates = mesh.texture_coordinates.as_mut().expect("some");
            for uv in coordinates {
                *uv = placed(*uv);
            }
            let mut scene = seen_from_above(mesh, textured(0.6, normal_image("tilt")), 8);
            set_normal(&mut scene, "tilt", tilted);
            scene.render.mode = Mode::Direct;
            scene.objects[0].rotate = DVec3::Z * turn;
            let side = if from_below { -1.0 } else { 1.0 };
            scene.camera.eye *= side;
            let light = light * DVec3::new(1.0, 1.0, side);
            scene.lights.push(Light::Point {
                position: light,
                intensity: Rgb::splat(7.0),
            });
            let image = picture(&scene);
            let turned = |v: DVec3| {
                if turn == 0.0 {
                    v
                } else {
                    DVec3::new(-v.y, v.x, v.z)
                }
            };
            let [x, y, z] = tilted.as_dvec3().to_array();
            // What stands out from the front is sunk into the back.
            let normal = (turned(first) * x + turned(second) * y + DVec3::Z * z) * side;
            for (column, row) in [(0, 0), (7, 2), (4, 4), (1, 6)] {
                let at = |pixel: u32| (f64::from(pixel) + 0.5) / 4.0 - 1.0;
                // From below, up is up and right is left.
                let point = DVec3::new(at(column) * side, -at(row), 0.0);
                let towards = light - point;
                let cosine = normal.dot(towards.normalize()).max(0.0);
                let expected = 0.6 / std::f64::consts::PI * 7.0 * cosine / towards.length_squared();
                let found = f64::from(image.pixel(column, row)[0]);
                assert_near(
                    found,
                    expected,
                    1e-4,
                    &format!("{side} {turn} {column},{row}"),
                );
            }
        }
    }
}

/// Where all corners lie on one point or line of the image, it has no direction.
#[test]
fn images_of_normals_turn_nothing_where_coordinates_are_degenerate() {
    let hash = |textures, line: f64| {
        let mut scene = shiny_ball(textures);
        set_normal(&mut scene, "tilt", Vec3::new(0.6, 0.0, 0.8));
        let mesh = Arc::make_mut(scene.meshes.get_mut("mesh").expect("is there"));
        let coordinates = mesh.texture_coordinates.as_mut().expect("some");
        for uv in coordinates {
            *uv *= DVec2::new(line, 0.0);
        }
        picture(&scene).hash()
    };
    for line in [0.0, 1.0] {
        assert_eq!(
            hash(normal_image("tilt"), line),
            hash(Textures::default(), line)
        );
    }
}

/// Lengths × 2^±20, nearer to or farther from everything else: the same bits; on any number of threads.
#[test]
fn the_picture_does_not_depend_on_scale_or_threads() {
    let hash = |factor: f64, threads: usize| {
        let textures = Textures {
            diffuse_image: Some("a".into()),
            normal_image: Some("tilt".into()),
            vertex_colors: true,
        };
        let mut scene = shiny_ball(textures);
        set_normal(&mut scene, "tilt", Vec3::new(0.36, -0.48, 0.8));
        set_image(&mut scene, "a", 16, Texels::Bytes(codes(256)));
        let mesh = Arc::make_mut(scene.meshes.get_mut("mesh").expect("is there"));
        mesh.colors = Some(mesh.positions.iter().map(|p| p.abs().as_vec3()).collect());
        mesh.positions.iter_mut().for_each(|p| *p *= factor);
        scene.camera.eye *= factor;
        let Light::Point {
            position,
            intensity,
        } = &mut scene.lights[0]
        else {
            unreachable!("it is a point");
        };
        *position *= factor;
        *intensity *= factor * factor;
        scene.render.mode = Mode::Path;
        image_of(&prepare(&scene), threads).hash()
    };
    let expected = hash(1.0, 1);
    for (factor, threads) in [(1.0, 3), (2_f64.powi(20), 2), (2_f64.powi(-20), 1)] {
        assert_eq!(hash(factor, threads), expected, "{factor}");
    }
}

/// Colours of vertices, linear between them, times the material's.
#[test]
fn colors_of_vertices_are_mixed() {
    let corners = [Vec3::X, Vec3::Y, Vec3::ONE, Vec3::Z * 0.5];
    let mesh = TriangleMesh {
        colors: Some(corners.to_vec()),
        texture_coordinates: None,
        ..square()
    };
    let textures = Textures {
        vertex_colors: true,
        ..Textures::default()
    };
    let scene = seen_from_above(mesh, textured(0.5, textures), 16);
    let image = picture(&scene);
    for (x, y) in [(3, 12), (12, 13), (5, 2), (9, 8)] {
        let at = |pixel: u32| (pixel as f32 + 0.5) / 16.0;
        let (u, v) = (at(x), 1.0 - at(y));
        // The diagonal from the first corner to the third cuts it in two.
        let [a, b, c, d] = corners;
        let expected = if u >= v {
            a * (1.0 - u) + b * (u - v) + c * v
        } else {
            a * (1.0 - v) + c * u + d * (v - u)
        };
        let found = Vec3::from(image.pixel(x, y));
        assert!(
            found.abs_diff_eq(expected * 0.5, 1e-5),
            "{x},{y}: {found} {expected}"
        );
    }
}

/// What no mesh carries, or no material asks for, is not prepared; with the code for it the picture is the same.
#[test]
fn a_scene_without_textures_carries_nothing_of_them() {
    let needed = |scene: &Scene| {
        let prepared = prepare(scene);
        let needs = prepared.plan().needs(Feature::Textures);
        assert_eq!(needs, prepared.texture_bytes() > 0);
        if !needs {
            let forced = prepared.plan().forcing(Feature::Textures);
            let pictures = [prepared.clone(), prepared.with_plan(forced)]
                .map(|prepared| image_of(&prepared, 1).hash());
            assert_eq!(pictures[0], pictures[1]);
        }
        needs
    };
    let mut scene = shiny_ball(diffuse_image("a"));
    set_image(&mut scene, "a", 16, Texels::Bytes(codes(256)));
    assert!(needed(&scene));
    let mut hidden = scene.clone();
    hidden.render.mode = Mode::Depth;
    assert!(!needed(&hidden));
    let mut bare = scene.clone();
    Arc::make_mut(bare.meshes.get_mut("mesh").expect("is there")).texture_coordinates = None;
    assert!(!needed(&bare));
    assert!(!needed(&shiny_ball(Textures::default())));
    let colors = Textures {
        vertex_colors: true,
        ..Textures::default()
    };
    assert!(!needed(&shiny_ball(colors)), "there are no colours");
}

#[test]
fn an_image_that_is_not_loaded_is_named() {
    let scene = shiny_ball(diffuse_image("a.png"));
    let error = PreparedScene::prepare(&scene, None, &CancelToken::new());
    let error = error.expect_err("is not loaded").to_string();
    assert_eq!(error, "the image \"a.png\" of a material is not loaded");
}

#[test]
fn textures_that_a_mesh_cannot_show_are_warned_of() {
    let mut scene = shiny_ball(diffuse_image("a"));
    assert_eq!(scene.warnings(), Vec::<String>::new());
    let mesh = Arc::make_mut(scene.meshes.get_mut("mesh").expect("is there"));
    mesh.texture_coordinates = None;
    let expected =
        "the material of object \"mesh\" has an image, but the mesh has no texture coordinates";
    assert_eq!(scene.warnings(), [expected]);
    let textures = Textures {
        vertex_colors: true,
        ..Textures::default()
    };
    let expected = "the material of object \"mesh\" has colours of vertices, but the mesh has none";
    assert_eq!(shiny_ball(textures).warnings(), [expected]);
}
