//! Whole renders against closed forms, and against themselves where the same picture must come out.

use std::f64::consts::PI;
use std::sync::Arc;

use raymini::control::CancelToken;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec3, Degrees, power_of_two};
use raymini::render::{
    CoarsePicture, Image, PreparedScene, Region, RenderOutcome, RenderProgress, RunConfig,
    TilePixels, Watch, render, render_watched,
};
use raymini::scene::{
    AcceleratorChoice, Background, Camera, Light, Material, Mode, Object, PhongModel,
    RenderSettings, Rgb, Scene, Shadows, Textures,
};

/// A scene of meshes, all of one diffuse reflectance.
fn scene_of(meshes: Vec<TriangleMesh>, diffuse: f64) -> Scene {
    let mut scene = Scene::default();
    scene.materials.insert(
        "grey".into(),
        Material::Phong {
            diffuse: Rgb::splat(diffuse),
            specular: Rgb::ZERO,
            shininess: 1.0,
            textures: Textures::default(),
        },
    );
    for (index, mesh) in meshes.into_iter().enumerate() {
        let name = format!("mesh {index}");
        scene.objects.push(Object {
            name: name.clone(),
            mesh: name.clone(),
            material: Some("grey".into()),
            ..Object::default()
        });
        scene.meshes.insert(name, Arc::new(mesh));
    }
    scene.render = RenderSettings {
        width: 48,
        height: 32,
        ..RenderSettings::default()
    };
    scene
}

/// The rectangle `center ± u ± v`, as two triangles.
fn rectangle(center: DVec3, u: DVec3, v: DVec3) -> TriangleMesh {
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

/// A large square in the plane z = 0.
fn floor() -> TriangleMesh {
    rectangle(DVec3::ZERO, DVec3::X * 10.0, DVec3::Y * 10.0)
}

/// Some hundred triangles in a ball, none alike.
fn shards() -> TriangleMesh {
    let mut state = 12_345_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) * 2.0 - 1.0
    };
    let mut point = || DVec3::new(next(), next(), next());
    let mut mesh = TriangleMesh::default();
    for index in 0..300 {
        let corner = point();
        mesh.positions
            .extend([corner, corner + 0.3 * point(), corner + 0.3 * point()]);
        mesh.triangles
            .push([3 * index, 3 * index + 1, 3 * index + 2]);
    }
    mesh
}

/// Shards over a floor under two lights and a sky, seen from the side.
fn shards_scene() -> Scene {
    let mut scene = scene_of(vec![shards(), floor()], 0.6);
    scene.materials.insert(
        "shiny".into(),
        Material::Phong {
            diffuse: Rgb::new(0.5, 0.3, 0.1),
            specular: Rgb::splat(0.4),
            shininess: 50.0,
            textures: Textures::default(),
        },
    );
    scene.objects[0].material = Some("shiny".into());
    scene.objects[0].smooth = true;
    scene.objects[0].translate = DVec3::Z * 1.5;
    scene.camera = Camera {
        eye: DVec3::new(0.5, -6.0, 2.0),
        target: DVec3::Z,
        ..Camera::default()
    };
    scene.background = Background::Gradient {
        zenith: Rgb::new(0.1, 0.2, 0.4),
        horizon: Rgb::splat(0.3),
        ground: Rgb::ZERO,
        up: DVec3::Z,
    };
    for (x, power) in [(-3.0, 20.0), (4.0, 9.0)] {
        scene.lights.push(Light::Point {
            position: DVec3::new(x, -2.0, 5.0),
            intensity: Rgb::splat(power),
        });
    }
    scene
}

fn prepare(scene: &Scene) -> PreparedScene {
    PreparedScene::prepare(scene, None, &CancelToken::new())
        .expect("can be rendered")
        .expect("nobody cancels")
}

fn run(scene: &Scene, threads: usize) -> RenderOutcome {
    let config = RunConfig {
        threads,
        ..RunConfig::default()
    };
    render(
        &prepare(scene),
        None,
        &config,
        &RenderProgress::default(),
        None,
    )
    .expect("nobody cancels")
}

fn picture(scene: &Scene) -> Image {
    run(scene, 0).image
}

/// The point of the plane z = 0 in the middle of pixel `(x, y)`.
fn floor_point(scene: &Scene, x: u32, y: u32) -> DVec3 {
    let axes = scene.camera.axes().expect("has a direction");
    let (width, height) = (
        f64::from(scene.render.width),
        f64::from(scene.render.height),
    );
    let half = (scene.camera.vertical_fov.radians() / 2.0).tan();
    let right = (2.0 * (f64::from(x) + 0.5) / width - 1.0) * half * width / height;
    let up = (1.0 - 2.0 * (f64::from(y) + 0.5) / height) * half;
    let direction = axes.forward + axes.right * right + axes.up * up;
    scene.camera.eye - direction * (scene.camera.eye.z / direction.z)
}

/// A floor under one point light, seen from straight above through pixel centres.
fn lit_floor() -> (Scene, DVec3, Rgb) {
    let mut scene = scene_of(vec![floor()], 0.7);
    let (position, intensity) = (DVec3::new(1.0, 0.5, 2.0), Rgb::new(5.0, 3.0, 1.0));
    scene.lights.push(Light::Point {
        position,
        intensity,
    });
    scene.camera = Camera {
        eye: DVec3::Z * 8.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        vertical_fov: Degrees(60.0),
        ..Camera::default()
    };
    scene.render.antialiasing = false;
    scene.render.samples_per_pixel = 1;
    (scene, position, intensity)
}

fn assert_close(found: [f32; 3], expected: DVec3, tolerance: f64, what: &str) {
    for (channel, value) in found.into_iter().enumerate() {
        let (value, expected) = (f64::from(value), expected[channel]);
        assert!(
            (value - expected).abs() <= tolerance * expected.abs(),
            "{what}, channel {channel}: {value}, not {expected}"
        );
    }
}

#[test]
fn a_diffuse_floor_under_a_point_light_has_the_radiance_of_the_formula() {
    let (scene, light, intensity) = lit_floor();
    let image = picture(&scene);
    for (x, y) in [(0, 0), (24, 16), (47, 31), (40, 5)] {
        let towards = light - floor_point(&scene, x, y);
        let irradiance = intensity * towards.normalize().z / towards.length_squared();
        assert_close(
            image.pixel(x, y),
            0.7 / PI * irradiance,
            1e-5,
            &format!("pixel {x}, {y}"),
        );
    }
}

#[test]
fn the_classic_formula_replaces_brdf_and_cosine() {
    let (mut scene, light, intensity) = lit_floor();
    scene.render.phong = PhongModel::Classic;
    let (diffuse, specular, shininess) = (0.2, 0.5, 12.0);
    let shiny = Material::Phong {
        diffuse: Rgb::splat(diffuse),
        specular: Rgb::splat(specular),
        shininess,
        textures: Textures::default(),
    };
    scene.materials.insert("grey".into(), shiny);
    let image = picture(&scene);
    for (x, y) in [(0, 0), (24, 16), (30, 12)] {
        let point = floor_point(&scene, x, y);
        let (towards, wo) = (light - point, (scene.camera.eye - point).normalize());
        let wi = towards.normalize();
        let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
        let reflected = diffuse * wi.z + specular * mirror.dot(wo).max(0.0).powf(shininess);
        assert_close(
            image.pixel(x, y),
            reflected * intensity / towards.length_squared(),
            2e-5,
            &format!("{x}, {y}"),
        );
    }
}

#[test]
fn a_hard_shadow_is_exactly_the_projection_of_what_blocks() {
    let (mut scene, light, _) = lit_floor();
    let blocker = rectangle(DVec3::new(0.5, 0.0, 1.0), DVec3::X * 0.4, DVec3::Y * 0.3);
    scene.meshes.insert("blocker".into(), Arc::new(blocker));
    scene.objects.push(Object {
        mesh: "blocker".into(),
        ..Object::default()
    });
    let without = picture(&Scene {
        objects: scene.objects[..1].to_vec(),
        ..scene.clone()
    });
    let image = picture(&scene);
    let objects = picture(&Scene {
        render: RenderSettings {
            mode: Mode::Object,
            ..scene.render.clone()
        },
        ..scene.clone()
    });
    let floor_color = objects.pixel(0, 0);
    let (mut lit, mut dark) = (0, 0);
    for y in 0..32 {
        for x in 0..48 {
            if objects.pixel(x, y) != floor_color {
                continue;
            }
            let point = floor_point(&scene, x, y);
            let at_blocker = point + (light - point) * (1.0 / light.z);
            let inside = (at_blocker - DVec3::new(0.5, 0.0, 1.0)).abs();
            // Nothing is sampled, so every pixel is one or the other; a centre on the edge may be either.
            if (inside.x - 0.4).abs() < 1e-5 || (inside.y - 0.3).abs() < 1e-5 {
                continue;
            }
            let blocked = inside.x < 0.4 && inside.y < 0.3;
            let expected = if blocked {
                [0.0; 3]
            } else {
                without.pixel(x, y)
            };
            assert_eq!(image.pixel(x, y), expected, "pixel {x}, {y}");
            if blocked { dark += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 500 && dark > 20, "{lit} lit, {dark} dark");

    scene.render.shadows = Shadows::Off;
    let unshadowed = picture(&scene);
    assert_eq!(unshadowed.pixel(5, 5), without.pixel(5, 5));
    assert_eq!(run(&scene, 1).stats.rays.shadow, 0);
}

#[test]
fn an_even_background_lights_a_diffuse_surface_by_its_reflectance() {
    let (mut scene, ..) = lit_floor();
    scene.lights.clear();
    scene.camera.vertical_fov = Degrees(150.0);
    scene.background = Background::Constant {
        radiance: Rgb::new(0.25, 0.5, 4.0),
    };
    let outcome = run(&scene, 0);
    assert_close(
        outcome.image.pixel(24, 16),
        0.7 * DVec3::new(0.25, 0.5, 4.0),
        1e-6,
        "floor",
    );
    assert_eq!(outcome.image.pixel(0, 0), [0.25, 0.5, 4.0]);
    assert_eq!(
        outcome.stats.rays.total(),
        48 * 32,
        "one camera ray per pixel and nothing else"
    );
}

/// Coverage of a box pixel by a half plane.
#[test]
fn antialiasing_converges_to_the_covered_area() {
    // Bright sky beyond the edge of a black plate, the edge tilted by φ at signed distance s from the middle of a pixel.
    for (s, degrees, coverage) in [
        (0.25_f64, 0.0_f64, 0.75),
        (0.25, 30.0, 0.783_493_6),
        (0.4, 30.0, 0.907_512_9),
        (0.1, 10.0, 0.601_542_7),
    ] {
        let normal = DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
        let mut scene = scene_of(
            vec![rectangle(
                normal * -5.0,
                normal * 5.0,
                normal.cross(DVec3::Z) * 5.0,
            )],
            0.0,
        );
        // One unit per pixel on the plane: the picture is 9 high, the eye far away.
        let height = 9.0;
        let distance = 1000.0;
        scene.camera = Camera {
            // The pixel's middle lies at distance s on the bright side.
            eye: normal * s + DVec3::Z * distance,
            target: normal * s,
            up: DVec3::Y,
            vertical_fov: Degrees((2.0 * (height / 2.0 / distance).atan()).to_degrees()),
            ..Camera::default()
        };
        scene.background = Background::Constant { radiance: Rgb::ONE };
        scene.render = RenderSettings {
            width: 9,
            height: 9,
            samples_per_pixel: 4096,
            ..RenderSettings::default()
        };
        let found = f64::from(picture(&scene).pixel(4, 4)[0]);
        // Scrambled Sobol across a straight edge: error well below 1/√N = 0.016, of the order N^−¾ = 0.002.
        assert!(
            (found - coverage).abs() < 0.004,
            "s {s}, φ {degrees}°: {found}, not {coverage}"
        );
    }
}

#[test]
fn the_picture_is_the_same_for_any_number_of_threads_and_any_structure() {
    let mut scene = shards_scene();
    let reference = run(&scene, 1);
    for threads in [2, 7] {
        assert_eq!(
            run(&scene, threads).image.hash(),
            reference.image.hash(),
            "{threads} threads"
        );
        assert_eq!(run(&scene, threads).stats.rays, reference.stats.rays);
    }
    for structure in [
        AcceleratorChoice::BruteForce,
        AcceleratorChoice::KdTree,
        AcceleratorChoice::Wide,
    ] {
        scene.render.accelerator = structure;
        assert_eq!(
            picture(&scene).hash(),
            reference.image.hash(),
            "{structure:?}"
        );
    }
    assert_eq!(reference.stats.non_finite_samples, 0);
    scene.render.seed = 1;
    assert_ne!(picture(&scene).hash(), reference.image.hash());
}

#[test]
fn a_region_is_a_piece_of_the_whole() {
    let scene = shards_scene();
    let (whole, prepared) = (picture(&scene), prepare(&scene));
    let region = Region {
        x: 13,
        y: 7,
        width: 21,
        height: 9,
    };
    let part = render(
        &prepared,
        Some(region),
        &RunConfig::default(),
        &RenderProgress::default(),
        None,
    );
    let part = part.expect("nobody cancels").image;
    for y in 0..region.height {
        for x in 0..region.width {
            assert_eq!(part.pixel(x, y), whole.pixel(x + region.x, y + region.y));
        }
    }
}

#[test]
fn scaling_the_world_by_a_power_of_two_changes_no_bit() {
    let base = shards_scene();
    let expected = picture(&base).hash();
    for exponent in [-60, -20, 20, 60] {
        assert_eq!(
            picture(&scaled(&base, power_of_two(exponent))).hash(),
            expected,
            "2^{exponent}"
        );
    }
}

#[test]
fn scaling_the_world_by_any_factor_hardly_changes_a_pixel() {
    let base = shards_scene();
    let expected = picture(&base);
    for factor in [1e-20, 1e-6, 1e6, 1e20] {
        assert_mostly_equal(
            &picture(&scaled(&base, factor)),
            &expected,
            &format!("scaled by {factor}"),
        );
    }
}

#[test]
fn moving_the_world_far_away_hardly_changes_a_pixel() {
    let base = shards_scene();
    let expected = picture(&base);
    for distance in [1e3, 1e6] {
        let mut scene = base.clone();
        let offset = DVec3::new(distance, -distance, 0.5 * distance);
        scene.camera.eye += offset;
        scene.camera.target += offset;
        for object in &mut scene.objects {
            object.translate += offset;
        }
        for light in &mut scene.lights {
            let Light::Point { position, .. } = light else {
                continue;
            };
            *position += offset;
        }
        assert_mostly_equal(&picture(&scene), &expected, &format!("moved by {distance}"));
    }
}

/// The same scene in another unit of length: lengths × s, intensities × s².
fn scaled(scene: &Scene, s: f64) -> Scene {
    let mut scene = scene.clone();
    scene.camera.eye *= s;
    scene.camera.target *= s;
    for object in &mut scene.objects {
        object.scale *= s;
        object.translate *= s;
    }
    for light in &mut scene.lights {
        let Light::Point {
            position,
            intensity,
        } = light
        else {
            continue;
        };
        *position *= s;
        *intensity *= s * s;
    }
    scene
}

/// At least 99.9 % of the pixels within 1/255.
fn assert_mostly_equal(found: &Image, expected: &Image, what: &str) {
    let near =
        |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1.0 / 255.0);
    let equal = found
        .pixels
        .iter()
        .zip(&expected.pixels)
        .filter(|(a, b)| near(a, b))
        .count();
    assert!(
        equal * 1000 >= expected.pixels.len() * 999,
        "{what}: {equal} of {} pixels",
        expected.pixels.len()
    );
}

#[test]
fn intensities_scale_the_picture_exactly() {
    let mut base = shards_scene();
    base.background = Background::default();
    let expected = picture(&base);
    for exponent in [-60, 60] {
        let mut scene = base.clone();
        for light in &mut scene.lights {
            let Light::Point { intensity, .. } = light else {
                continue;
            };
            *intensity *= power_of_two(exponent);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a power of two")]
        let factor = power_of_two(exponent) as f32;
        for (bright, plain) in picture(&scene).pixels.iter().zip(&expected.pixels) {
            assert_eq!(*bright, plain.map(|value| value * factor));
        }
    }
}

#[test]
fn an_empty_scene_is_its_background() {
    let settings = RenderSettings {
        width: 3,
        height: 2,
        ..RenderSettings::default()
    };
    let background = Background::Constant {
        radiance: Rgb::new(0.1, 0.2, 0.3),
    };
    let scene = Scene {
        render: settings,
        background,
        ..Scene::default()
    };
    let outcome = run(&scene, 1);
    assert!(
        outcome
            .image
            .pixels
            .iter()
            .all(|&pixel| pixel == [0.1, 0.2, 0.3])
    );
    assert_eq!(outcome.stats.rays.total(), 3 * 2 * 16);
}

#[test]
fn a_light_behind_the_surface_costs_no_ray() {
    let (mut scene, ..) = lit_floor();
    scene.lights = vec![Light::Point {
        position: -DVec3::Z,
        intensity: Rgb::ONE,
    }];
    let outcome = run(&scene, 1);
    assert_eq!(outcome.image.pixel(24, 16), [0.0; 3]);
    assert_eq!(outcome.stats.rays.shadow, 0);
}

/// By brute force every ray that passes the box tests every block of eight triangles; the trees take fewer steps.
#[test]
fn steps_are_shown_by_colors() {
    let (mut scene, ..) = lit_floor();
    let mesh = shapes::grid(10);
    assert_eq!(mesh.triangles.len(), 200);
    let name = scene.objects[0].mesh.clone();
    scene.meshes.insert(name, Arc::new(mesh));
    scene.render.mode = Mode::Steps;
    let mut steps = |accelerator: AcceleratorChoice| {
        scene.render.accelerator = accelerator;
        picture(&scene).pixel(24, 16)
    };
    let all = steps(AcceleratorChoice::BruteForce);
    // 25 blocks: log2 26 of 8, three times as far along black, red, yellow, white.
    let heat = 3.0 * 26_f32.log2() / 8.0;
    for (found, expected) in all.into_iter().zip([1.0, heat - 1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-5, "{all:?}");
    }
    for tree in [AcceleratorChoice::Wide, AcceleratorChoice::KdTree] {
        let [red, green, _] = steps(tree);
        assert!(red > 0.0 && red + green < 1.0 + heat - 1.0, "{tree:?}");
    }
}

#[test]
fn false_colors_show_depth_normals_and_sides() {
    let (mut scene, ..) = lit_floor();
    let mut show = |mode: Mode| {
        scene.render.mode = mode;
        picture(&scene).pixel(24, 16)
    };
    assert_eq!(show(Mode::Normals), [0.5, 0.5, 1.0]);
    assert_eq!(show(Mode::Albedo), [0.7; 3]);
    let [red, green, blue] = show(Mode::Facing);
    assert!(
        green > 0.99 && red == 0.0 && blue == 0.0,
        "the front is green: {red}, {green}, {blue}"
    );
    let expected = floor_point(&scene, 24, 16).distance(scene.camera.eye);
    scene.render.mode = Mode::Depth;
    assert_close(
        picture(&scene).pixel(24, 16),
        DVec3::splat(expected),
        1e-6,
        "distance in scene units",
    );
    scene.objects[0].rotate.x = 180.0;
    scene.render.mode = Mode::Facing;
    let [red, green, _] = picture(&scene).pixel(24, 16);
    assert!(
        red > 0.99 && green == 0.0,
        "the back is red: {red}, {green}"
    );
}

#[test]
fn a_mirrored_object_still_shows_its_front() {
    let (mut scene, ..) = lit_floor();
    // Scaling by −1 turns the floor's normal down; a half turn about X turns it up again.
    scene.objects[0].scale = -1.0;
    scene.objects[0].rotate.x = 180.0;
    scene.render.mode = Mode::Facing;
    let [red, green, _] = picture(&scene).pixel(24, 16);
    assert!(green > 0.99 && red == 0.0, "{red}, {green}");
}

#[test]
fn cancelling_gives_no_picture() {
    let mut scene = shards_scene();
    scene.render.samples_per_pixel = 1 << 20;
    let prepared = prepare(&scene);
    let config = RunConfig {
        threads: 2,
        ..RunConfig::default()
    };
    let progress = RenderProgress::default();
    let outcome = std::thread::scope(|scope| {
        let render = scope.spawn(|| render(&prepared, None, &config, &progress, None));
        while progress.rays() == 0 {
            std::thread::yield_now();
        }
        config.cancel.cancel();
        render.join().expect("does not panic")
    });
    assert!(outcome.is_none());
    assert!(progress.samples.fraction() < 1.0);
}

#[test]
fn tiles_deliver_the_whole_picture() {
    let mut scene = shards_scene();
    scene.render.samples_per_pixel = 20;
    let (prepared, progress) = (prepare(&scene), RenderProgress::default());
    let streamed = std::sync::Mutex::new(Image::black(48, 32));
    let on_tile = |tile: &TilePixels<'_>| {
        tile.region
            .copy_into(tile.rgb, &mut streamed.lock().expect("no panic"));
    };
    let config = RunConfig::default();
    let outcome = render(&prepared, None, &config, &progress, Some(&on_tile));
    assert_eq!(
        streamed.into_inner().expect("no panic"),
        outcome.expect("nobody cancels").image
    );
    assert_eq!(progress.samples.done(), progress.samples.total());
}

/// For whoever waits, a picture in blocks comes before the first sample counts, and changes no bit of the rest.
#[test]
fn a_coarse_picture_comes_first_where_asked_for() {
    let mut scene = shards_scene();
    scene.render.samples_per_pixel = 3;
    let (prepared, progress) = (prepare(&scene), RenderProgress::default());
    let shown = std::sync::Mutex::new(Vec::new());
    let on_coarse = |coarse: &CoarsePicture| {
        assert_eq!(progress.samples.done(), 0);
        shown.lock().expect("no panic").push(coarse.clone());
    };
    let on_tile = |_: &TilePixels<'_>| assert!(!shown.lock().expect("no panic").is_empty());
    let watch = Watch {
        on_coarse: Some(&on_coarse),
        on_tile: Some(&on_tile),
        ..Watch::default()
    };
    let config = RunConfig::default();
    let outcome = render_watched(&prepared, None, &config, &progress, watch);
    let outcome = outcome.expect("nobody cancels");
    let shown = shown.into_inner().expect("no panic");
    assert!(shown.is_sorted_by(|a, b| a.side > b.side));
    // A block looks like the first sample of the pixel in its middle.
    scene.render.stop.passes = Some(1);
    let first = render(
        &prepare(&scene),
        None,
        &config,
        &RenderProgress::default(),
        None,
    );
    let first = first.expect("nobody cancels").image;
    for coarse in &shown {
        let [columns, rows] = coarse.size();
        for (number, &rgb) in coarse.rgb.iter().enumerate() {
            let middle =
                |index: usize| u32::try_from(index).unwrap() * coarse.side + (coarse.side - 1) / 2;
            let (x, y) = (middle(number % columns), middle(number / columns));
            if x < 48 && y < 32 && columns * rows > 1 {
                assert_eq!(rgb, first.pixel(x, y));
            }
        }
    }
    assert!(progress.in_hand.tiles().is_empty());
    let plain = render(&prepared, None, &RunConfig::default(), &progress, None);
    let plain = plain.expect("nobody cancels");
    assert_eq!(outcome.image.hash(), plain.image.hash());
    assert_eq!(outcome.stats.rays, plain.stats.rays);
}

#[test]
fn only_changed_geometry_is_prepared_again() {
    let mut scene = shards_scene();
    let before = prepare(&scene);
    let again = |scene: &Scene| {
        let after = PreparedScene::prepare(scene, Some(&before), &CancelToken::new());
        after.expect("can be rendered").expect("nobody cancels")
    };
    scene.camera.eye.x += 1.0;
    scene.lights.pop();
    scene.materials.insert("shiny".into(), Material::default());
    assert!(Arc::ptr_eq(before.geometry(), again(&scene).geometry()));
    scene.objects[0].translate.x += 1.0;
    assert!(!Arc::ptr_eq(before.geometry(), again(&scene).geometry()));
}

#[test]
fn numbers_too_large_to_render_are_refused_by_name() {
    let (mut scene, ..) = lit_floor();
    let refusal = |scene: &Scene| {
        let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
        prepared.expect_err("is refused").to_string()
    };
    scene.lights.push(Light::Point {
        position: DVec3::Z,
        intensity: Rgb::splat(1e300),
    });
    assert!(refusal(&scene).starts_with("lights.1 is too large a number"));
    scene.lights.clear();
    let glaring = Material::Emitter {
        radiance: Rgb::splat(1e39),
    };
    scene.materials.insert("grey".into(), glaring);
    assert!(refusal(&scene).starts_with("the material of objects.0 is too large"));
}

#[test]
fn backgrounds_too_bright_for_32_bits_are_refused_by_name() {
    let refusal = |background: Background| {
        let scene = Scene {
            background,
            ..Scene::default()
        };
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        prepared.expect_err("is refused").to_string()
    };
    let glaring = Rgb::new(1e39, 1.0, 0.0);
    assert_eq!(
        refusal(Background::Constant { radiance: glaring }),
        "background.radiance is [1e39, 1, 0]; expected at most 3.4028235e38 in each channel"
    );
    for (index, name) in ["zenith", "horizon", "ground"].into_iter().enumerate() {
        let mut radiances = [Rgb::ONE; 3];
        radiances[index] = glaring;
        let [zenith, horizon, ground] = radiances;
        let background = Background::Gradient {
            zenith,
            horizon,
            ground,
            up: DVec3::Z,
        };
        let expected = format!("background.{name} is [1e39, 1, 0]");
        assert!(refusal(background).starts_with(&expected));
    }
}
