//! Image backgrounds: where their pixels are, and the light they give against closed forms, found every way.
//!
//! Sequences are fixed by seeds. Where a tolerance is statistical, it says how many standard deviations it is.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::common::{
    add, assert_near, assert_ways_agree, diffuse, looking_at_floor, picture, rectangle, run, value,
};
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees};
use raymini::render::Image;
use raymini::scene::{
    AmbientOcclusion, Background, Camera, Light, LightSampling, Material, Mode, RadianceMap,
    RenderSettings, Rgb, Scene, Textures,
};

/// Gives the scene a sky of `width × height` pixels with Z up.
fn set_sky(scene: &mut Scene, width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| pixel(x, y)).collect();
    let (map, cleaned) = RadianceMap::cleaned(width, height, pixels);
    assert_eq!(cleaned, 0);
    scene.images.insert("sky".into(), Arc::new(map));
    scene.background = Background::Image {
        image: "sky".into(),
        up: DVec3::Z,
        rotation: Degrees(0.0),
        scale: 1.0,
    };
}

fn turn_sky(scene: &mut Scene, degrees: f64) {
    if let Background::Image { rotation, .. } = &mut scene.background {
        *rotation = Degrees(degrees);
    }
}

/// The ways a matt floor is lit by a background: in mode direct without and with occlusion, in mode path found each way.
fn ways_of_lighting(scene: &Scene) -> Vec<(String, Scene)> {
    let mut ways = Vec::new();
    let mut way = |name: &str, change: &dyn Fn(&mut RenderSettings)| {
        let mut scene = scene.clone();
        scene.render.max_bounces = 1;
        change(&mut scene.render);
        ways.push((name.to_owned(), scene));
    };
    way("direct", &|render| render.samples_per_pixel = 256);
    way("direct, occlusion", &|render| {
        render.samples_per_pixel = 256;
        render.ambient_occlusion.enabled = true;
    });
    for sampling in [LightSampling::Mis, LightSampling::Nee] {
        way(&format!("path, {sampling:?}"), &|render| {
            render.mode = Mode::Path;
            render.samples_per_pixel = 1 << 15;
            render.light_sampling = sampling;
        });
    }
    ways
}

#[test]
fn an_even_sky_gives_a_matt_floor_its_reflectance() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    set_sky(&mut scene, 8, 4, |_, _| [2.0; 3]);
    for (name, scene) in ways_of_lighting(&scene) {
        assert_near(value(&scene), 1.0, 2e-3, &name);
    }
}

/// A sun of one texel: a tent in the azimuth and in the height between the neighbours' centres, whose irradiance on the floor
/// is the product of two integrals.
#[test]
fn a_hard_sun_gives_the_irradiance_of_its_closed_form() {
    let (width, height) = (256_u32, 128_u32);
    for (x, y) in [(0, 40), (77, 10), (255, 1), (128, 63)] {
        let mut scene = looking_at_floor(0.0, diffuse(1.0));
        let radiance = 1e4_f32;
        set_sky(&mut scene, width, height, |i, j| {
            if (i, j) == (x, y) {
                [radiance; 3]
            } else {
                [0.0; 3]
            }
        });
        let cosine = |row: u32| ((f64::from(row) + 0.5) / f64::from(height) * PI).cos();
        let (above, middle, below) = (cosine(y - 1), cosine(y), cosine(y + 1));
        // What is under the horizon does not count: the tent's lower half ends there.
        let lower = if below >= 0.0 {
            (middle - below) * (2.0 * middle + below) / 6.0
        } else {
            let part = |mu: f64| (mu * mu * mu / 3.0 - below * mu * mu / 2.0) / (middle - below);
            part(middle)
        };
        let upper = (above - middle) * (above + 2.0 * middle) / 6.0;
        let irradiance = f64::from(radiance) * (upper + lower) * TAU / f64::from(width);
        for (name, scene) in ways_of_lighting(&scene) {
            let what = format!("{name}, sun at ({x}, {y})");
            assert_near(value(&scene), irradiance / PI, 3e-3, &what);
        }
    }
}

/// Between its texels' centres an image is linear in the height, as a gradient is: they differ at the horizon only.
#[test]
fn an_image_of_a_gradient_lights_like_the_gradient() {
    let [zenith, horizon, ground] = [[0.2_f32, 0.4, 1.0], [1.0, 0.9, 0.8], [0.3, 0.2, 0.1]];
    let rgb = |c: [f32; 3]| Rgb::from_array(c.map(f64::from));
    let mut scene = looking_at_floor(0.0, diffuse(0.8));
    // A floor that leans sees both halves.
    scene.objects[0].rotate = DVec3::new(-30.0, 0.0, 0.0);
    scene.camera.eye = DVec3::new(0.0, 4.0, 8.0);
    let mut exact = scene.clone();
    exact.background = Background::Gradient {
        zenith: rgb(zenith),
        horizon: rgb(horizon),
        ground: rgb(ground),
        up: DVec3::Z,
    };
    let expected = picture(&exact).pixels[0];
    set_sky(&mut scene, 64, 32, |_, y| {
        #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
        let t = ((f64::from(y) + 0.5) / 32.0 * PI).cos() as f32;
        let end = if t >= 0.0 { zenith } else { ground };
        std::array::from_fn(|c| horizon[c] + (end[c] - horizon[c]) * t.abs())
    });
    for (name, scene) in ways_of_lighting(&scene) {
        let found = picture(&scene).pixels[0];
        for channel in 0..3 {
            let what = format!("{name}, channel {channel}");
            assert_near(found[channel].into(), expected[channel].into(), 4e-3, &what);
        }
    }
}

/// One sample of 64 directions, without occlusion: a sun of a hundred-thousandth of the sky gives no bright speckles.
#[test]
fn a_sun_gives_no_fireflies_in_mode_direct() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    scene.camera.vertical_fov = Degrees(1.0);
    (scene.render.width, scene.render.height) = (32, 32);
    scene.render.samples_per_pixel = 1;
    set_sky(&mut scene, 512, 256, |x, y| {
        if (x, y) == (300, 60) {
            [3e4; 3]
        } else {
            [0.3; 3]
        }
    });
    let values: Vec<f64> = picture(&scene).pixels.iter().map(|p| p[0].into()).collect();
    let mean = values.iter().sum::<f64>() / 1024.0;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 1023.0;
    let largest = values.iter().copied().fold(0.0, f64::max);
    assert!(
        variance.sqrt() < 0.05 * mean,
        "{} of {mean}",
        variance.sqrt()
    );
    assert!(largest < 1.3 * mean, "{largest} of {mean}");
}

/// A lamp and a disk share what is aimed at with the sky.
#[test]
fn every_way_of_finding_the_sky_finds_the_same() {
    let mut scene = Scene::default();
    let shiny = Material::Phong {
        diffuse: Rgb::splat(0.4),
        specular: Rgb::splat(0.4),
        shininess: 20.0,
        textures: Textures::default(),
    };
    let floor = rectangle(DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0);
    add(&mut scene, "floor", floor, shiny);
    let wall = rectangle(DVec3::new(0.0, 1.5, 1.0), DVec3::X * 3.0, DVec3::Z);
    add(&mut scene, "wall", wall, diffuse(0.7));
    let lamp = rectangle(DVec3::new(0.5, 0.5, 2.0), DVec3::X * 0.6, DVec3::Y * 0.4);
    add(&mut scene, "lamp", lamp, Material::emitter());
    scene.lights.push(Light::disk());
    // Wide enough that scattering alone meets it often.
    set_sky(&mut scene, 16, 8, |x, y| match (x, y) {
        (6..8, 2) => [12.0, 10.0, 8.0],
        (_, 5..) => [0.0; 3],
        _ => [0.2, 0.3, 0.5],
    });
    scene.camera = Camera {
        eye: DVec3::new(1.0, -4.0, 2.0),
        target: DVec3::Z * 0.5,
        ..Camera::default()
    };
    scene.render = RenderSettings {
        mode: Mode::Path,
        width: 4,
        height: 4,
        samples_per_pixel: 256,
        max_bounces: 3,
        ..RenderSettings::default()
    };
    assert_ways_agree(&mut scene, "sky and lamps");
}

/// A black object far away; the pixel at the middle shows the sky along `direction`, a wide picture what is around it.
fn looking_at_sky(direction: DVec3, up: DVec3) -> Scene {
    let mut scene = Scene::default();
    let speck = rectangle(-direction * 10.0, DVec3::X * 1e-3, DVec3::Y * 1e-3);
    add(&mut scene, "speck", speck, diffuse(0.0));
    scene.camera = Camera {
        eye: DVec3::ZERO,
        target: direction,
        up,
        vertical_fov: Degrees(60.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 3,
        height: 3,
        samples_per_pixel: 1,
        ..RenderSettings::default()
    };
    scene
}

#[test]
fn the_image_stands_upright_and_is_not_mirrored() {
    // Columns tell the azimuth (red), rows the height (green): smooth, so that interpolation keeps them.
    let sky = |x: u32, y: u32| [x as f32, y as f32, 0.0];
    let seen = |direction: DVec3, up: DVec3, degrees: f64| {
        let mut scene = looking_at_sky(direction, up);
        set_sky(&mut scene, 360, 180, sky);
        turn_sky(&mut scene, degrees);
        picture(&scene)
    };
    // The middle of the image, between columns 179 and 180, is along +X.
    let ahead = seen(DVec3::X, DVec3::Z, 0.0);
    let [column, row, _] = ahead.pixel(1, 1);
    assert!((column - 179.5).abs() < 1e-3 && (row - 89.5).abs() < 1e-3);
    // Right of it in the picture is right of it in the image, and up is up.
    assert!(ahead.pixel(2, 1)[0] > 190.0 && ahead.pixel(0, 1)[0] < 170.0);
    assert!(ahead.pixel(1, 0)[1] < 80.0 && ahead.pixel(1, 2)[1] > 100.0);
    // A quarter of the image to the left is along +Y, to the right along −Y.
    assert!((seen(DVec3::Y, DVec3::Z, 0.0).pixel(1, 1)[0] - 89.5).abs() < 1e-3);
    assert!((seen(-DVec3::Y, DVec3::Z, 0.0).pixel(1, 1)[0] - 269.5).abs() < 1e-3);
    // Straight up is the first row, straight down the last.
    assert_eq!(seen(DVec3::Z, DVec3::Y, 0.0).pixel(1, 1)[1], 0.0);
    assert_eq!(seen(-DVec3::Z, DVec3::Y, 0.0).pixel(1, 1)[1], 179.0);
    // Turned by 90° counter-clockwise from above, the middle is along +Y.
    assert!((seen(DVec3::Y, DVec3::Z, 90.0).pixel(1, 1)[0] - 179.5).abs() < 1e-3);
}

#[test]
fn four_quarter_turns_return_and_scale_multiplies() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    scene.render.samples_per_pixel = 4;
    set_sky(&mut scene, 16, 8, |x, y| [x as f32, y as f32, 1.0]);
    let base = picture(&scene);
    let turned: Vec<Image> = [90.0, 180.0, 270.0, 360.0]
        .map(|degrees| {
            turn_sky(&mut scene, degrees);
            picture(&scene)
        })
        .into();
    assert_eq!(turned[3].hash(), base.hash());
    let Background::Image { scale, .. } = &mut scene.background else {
        unreachable!("an image was set")
    };
    *scale = 4.0;
    let brighter = picture(&scene).pixels[0];
    assert_eq!(brighter, base.pixels[0].map(|channel| channel * 4.0));
}

/// Light from all around on a floor does not depend on the turn; which pixel is where does.
#[test]
fn a_turned_sky_lights_a_level_floor_alike() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    scene.render.samples_per_pixel = 256;
    set_sky(&mut scene, 16, 8, |x, _| [x as f32, 1.0, 1.0]);
    let base = value(&scene);
    for degrees in [90.0, 123.0, -45.0] {
        turn_sky(&mut scene, degrees);
        assert_near(value(&scene), base, 3e-3, &format!("{degrees}°"));
    }
}

#[test]
fn a_black_image_costs_no_ray() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    scene.render.samples_per_pixel = 4;
    scene.render.ambient_occlusion = AmbientOcclusion {
        enabled: true,
        ..AmbientOcclusion::default()
    };
    set_sky(&mut scene, 4, 2, |_, _| [0.0; 3]);
    let outcome = run(&scene);
    assert_eq!(outcome.image.pixel(0, 0), [0.0; 3]);
    assert_eq!(outcome.stats.rays.ambient_occlusion, 0);
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1;
    assert_eq!(run(&scene).stats.rays.shadow, 0);
    // Nor does one that is scaled to nothing.
    set_sky(&mut scene, 4, 2, |_, _| [1.0; 3]);
    if let Background::Image { scale, .. } = &mut scene.background {
        *scale = 0.0;
    }
    assert_eq!(run(&scene).stats.rays.shadow, 0);
}

#[test]
fn mirrors_and_glass_show_the_image() {
    for material in [Material::mirror(), Material::glass()] {
        let mut scene = looking_at_floor(0.0, material.clone());
        // Closed, so that what enters glass leaves it.
        let ball = Arc::new(shapes::icosphere(2));
        scene.meshes.insert("floor".into(), ball);
        scene.render.samples_per_pixel = 64;
        scene.render.max_bounces = 1 << 12;
        scene.render.roulette = false;
        set_sky(&mut scene, 8, 4, |_, _| [3.0; 3]);
        let even = value(&scene);
        let expected = match material {
            Material::Mirror { reflectance } => 3.0 * reflectance.x,
            _ => 3.0,
        };
        assert_near(even, expected, 1e-5, &format!("{material:?}"));
        scene.render.mode = Mode::Path;
        assert_near(
            value(&scene),
            expected,
            1e-5,
            &format!("{material:?}, path"),
        );
    }
}

#[test]
fn an_image_that_is_missing_or_too_bright_is_refused() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    set_sky(&mut scene, 4, 2, |_, _| [1e30; 3]);
    let error = |scene: &Scene| {
        let cancel = raymini::control::CancelToken::new();
        raymini::render::PreparedScene::prepare(scene, None, &cancel)
            .expect_err("is refused")
            .to_string()
    };
    if let Background::Image { scale, .. } = &mut scene.background {
        *scale = 1e20;
    }
    let text = error(&scene);
    assert!(text.starts_with("background.scale is 1"), "{text}");
    scene.images.clear();
    assert_eq!(
        error(&scene),
        "the image \"sky\" of the background is not loaded"
    );
}
