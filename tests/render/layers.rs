//! The parts of a picture: they add up to it, each holds what its name says, and keeping them changes nothing.

use crate::common::{self, add, diffuse, looking_at_floor, rectangle};
use raymini::control::CancelToken;
use raymini::geometry::shapes;
use raymini::math::{DVec3, Degrees};
use raymini::render::{
    Image, Layer, PreparedScene, RenderOutcome, RenderProgress, RunConfig, render,
};
use raymini::scene::{
    AmbientOcclusion, Background, Camera, Facing, Light, Material, Mode, Object, RenderSettings,
    Rgb, Scene, Shadows, Textures,
};

fn render_layers(scene: &Scene) -> RenderOutcome {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new()).expect("is right");
    let config = RunConfig {
        layers: true,
        ..RunConfig::default()
    };
    let outcome = render(
        &prepared.expect("nobody cancels"),
        None,
        &config,
        &RenderProgress::default(),
        None,
    );
    outcome.expect("nobody cancels")
}

fn layer(outcome: &RenderOutcome, wanted: Layer) -> &Image {
    let found = outcome.layers.iter().find(|(layer, _)| *layer == wanted);
    &found.expect("the scene has this layer").1
}

fn ball(scene: &mut Scene, name: &str, center: DVec3, material: Material) {
    add(scene, name, shapes::icosphere(3), material);
    *scene.objects.last_mut().expect("just added") = Object {
        translate: center,
        scale: 0.8,
        smooth: true,
        ..scene.objects.last().expect("just added").clone()
    };
}

/// A floor with a glossy, a mirror and a glass ball, under every kind of light.
fn everything() -> Scene {
    let mut scene = Scene::default();
    let floor = rectangle(DVec3::ZERO, DVec3::X * 6.0, DVec3::Y * 6.0);
    add(&mut scene, "floor", floor, diffuse(0.6));
    let panel = rectangle(DVec3::new(0.0, 3.0, 3.0), DVec3::X, DVec3::Z * 0.3);
    let emitter = Material::Emitter {
        radiance: Rgb::new(3.0, 2.0, 1.0),
    };
    add(&mut scene, "panel", panel, emitter);
    let glossy = Material::Phong {
        diffuse: Rgb::new(0.5, 0.2, 0.1),
        specular: Rgb::new(0.1, 0.3, 0.4),
        shininess: 30.0,
        textures: Textures::default(),
    };
    ball(&mut scene, "glossy", DVec3::new(-2.0, 0.0, 0.8), glossy);
    ball(
        &mut scene,
        "mirror",
        DVec3::new(0.0, 0.5, 0.8),
        Material::mirror(),
    );
    let bottle = Material::Glass {
        ior: 1.5,
        attenuation: Rgb::new(0.5, 0.1, 0.2),
    };
    ball(&mut scene, "bottle", DVec3::new(2.0, -0.3, 0.8), bottle);
    scene.lights.push(Light::Point {
        position: DVec3::new(-3.0, -3.0, 4.0),
        intensity: Rgb::splat(12.0),
    });
    scene.lights.push(Light::Disk {
        center: DVec3::new(2.0, -1.0, 4.0),
        facing: Facing::Target(DVec3::ZERO),
        radius: 0.7,
        radiance: Rgb::new(2.0, 3.0, 4.0),
        visible: true,
    });
    scene.background = Background::Gradient {
        zenith: Rgb::new(0.2, 0.3, 0.6),
        horizon: Rgb::splat(0.5),
        ground: Rgb::splat(0.1),
        up: DVec3::Z,
    };
    scene.camera = Camera {
        eye: DVec3::new(0.0, -8.0, 4.0),
        target: DVec3::new(0.0, 0.5, 1.0),
        vertical_fov: Degrees(45.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 60,
        height: 40,
        samples_per_pixel: 40,
        ambient_occlusion: AmbientOcclusion {
            enabled: true,
            samples: 4,
            ..AmbientOcclusion::default()
        },
        ..RenderSettings::default()
    };
    scene
}

#[test]
fn the_parts_add_up_to_the_picture() {
    let mut scene = everything();
    for mode in [Mode::Direct, Mode::Path] {
        for clamp in [None, Some(1.5)] {
            scene.render.mode = mode;
            scene.render.clamp = clamp;
            let outcome = render_layers(&scene);
            let parts: Vec<&Image> = outcome
                .layers
                .iter()
                .filter(|(layer, _)| layer.is_part())
                .map(|(_, image)| image)
                .collect();
            for (index, pixel) in outcome.image.pixels.iter().enumerate() {
                for (channel, &whole) in pixel.iter().enumerate() {
                    let values = parts.iter().map(|image| image.pixels[index][channel]);
                    let sum: f64 = values.map(f64::from).sum();
                    let whole = f64::from(whole);
                    assert!(
                        (sum - whole).abs() <= 1e-6 * whole.abs(),
                        "{mode:?}: {sum} {whole}"
                    );
                }
            }
            // Each of them holds something here.
            for (layer, image) in &outcome.layers {
                let is_black = image.pixels.iter().all(|&pixel| pixel == [0.0; 3]);
                assert!(!is_black, "{mode:?}: {layer:?}");
            }
            assert_eq!(outcome.image.hash(), common::picture(&scene).hash());
            assert_eq!(outcome.stats.clamped.samples > 0, clamp.is_some());
        }
    }
}

/// What a scene cannot have is not kept.
#[test]
fn layers_follow_from_the_scene() {
    let mut scene = everything();
    scene.render.mode = Mode::Path;
    let of = |scene: &Scene| Layer::all_of(scene);
    assert_eq!(of(&scene), Layer::ALL[..8]);
    scene.render.mode = Mode::Normals;
    assert_eq!(of(&scene), []);
    let mut plain = looking_at_floor(0.0, diffuse(0.5));
    assert_eq!(of(&plain), [Layer::Emission]);
    plain.lights.push(Light::default());
    let lit = [Layer::Emission, Layer::DirectDiffuse, Layer::Shadow];
    assert_eq!(of(&plain), lit);
    plain.render.shadows = Shadows::Off;
    assert_eq!(of(&plain), lit[..2]);
}

/// A floor of which a plate shadows half the pixels, lit by a point light far above: the factor is 0 or 1 there, and light with
/// shadows is light without times the factor.
#[test]
fn the_shadow_factor_is_what_shadows_take() {
    let mut scene = looking_at_floor(0.0, diffuse(0.5));
    scene.camera.eye = DVec3::new(0.0, -6.0, 6.0);
    scene.camera.vertical_fov = Degrees(20.0);
    scene.render.width = 32;
    scene.render.height = 24;
    scene.render.samples_per_pixel = 1;
    let plate = rectangle(
        DVec3::new(-10.0, 0.0, 8.0),
        DVec3::X * 10.0,
        DVec3::Y * 20.0,
    );
    add(&mut scene, "plate", plate, diffuse(0.5));
    scene.lights.push(Light::Point {
        position: DVec3::Z * 20.0,
        intensity: Rgb::splat(100.0),
    });
    let with = render_layers(&scene);
    scene.render.shadows = Shadows::Off;
    let without = render_layers(&scene).image;
    let factor = layer(&with, Layer::Shadow);
    let mut counts = [0; 2];
    for ((with, without), factor) in with
        .image
        .pixels
        .iter()
        .zip(&without.pixels)
        .zip(&factor.pixels)
    {
        assert!(factor[0].to_bits() == 0 || factor[0].to_bits() == 1.0_f32.to_bits());
        counts[usize::from(factor[0] > 0.5)] += 1;
        assert_eq!(with[0].to_bits(), (without[0] * factor[0]).to_bits());
    }
    assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
}

#[test]
fn the_occlusion_factor_is_the_occlusion_picture() {
    let mut scene = everything();
    scene.render.samples_per_pixel = 1;
    scene.render.mode = Mode::Direct;
    let layers = render_layers(&scene);
    scene.render.mode = Mode::Ao;
    let picture = common::picture(&scene);
    let factor = layer(&layers, Layer::Occlusion);
    // On the floor, which is met first: not in mirrors, not beside.
    let ambient = layer(&layers, Layer::Ambient);
    let mut compared = 0;
    for ((factor, ao), ambient) in factor
        .pixels
        .iter()
        .zip(&picture.pixels)
        .zip(&ambient.pixels)
    {
        if ambient[0] > 0.0 {
            assert_eq!(factor, ao);
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
}

/// A layer of zeros would say that the picture has none.
#[test]
fn an_error_that_nothing_is_known_of_is_no_layer() {
    let mut scene = everything();
    for (samples, is_known) in [(1, false), (2, false), (4, true)] {
        scene.render.samples_per_pixel = samples;
        let outcome = render_layers(&scene);
        let is_there = outcome
            .layers
            .iter()
            .any(|(layer, _)| *layer == Layer::Error);
        assert_eq!(is_there, is_known, "{samples}");
        assert_eq!(outcome.stats.error.is_some(), is_known, "{samples}");
    }
}

#[test]
fn open_exr_files_hold_the_layers_as_channels() {
    let mut scene = everything();
    scene.render.samples_per_pixel = 2;
    let outcome = render_layers(&scene);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("out.exr");
    raymini::io::write_image(
        &outcome.image,
        &outcome.layers,
        &scene.display,
        &scene.output,
        &path,
    )
    .expect("is written");
    let file = exr::prelude::read_first_flat_layer_from_file(&path).expect("is an EXR");
    let channel = |name: String| {
        let channels = &file.layer_data.channel_data.list;
        let found = channels
            .iter()
            .find(|channel| channel.name.eq(name.as_str()));
        let found = found.unwrap_or_else(|| panic!("no channel {name}"));
        found.sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let red: Vec<f32> = outcome.image.pixels.iter().map(|rgb| rgb[0]).collect();
    assert_eq!(channel("R".to_owned()), red);
    for (layer, image) in &outcome.layers {
        let blue: Vec<f32> = image.pixels.iter().map(|rgb| rgb[2]).collect();
        assert_eq!(channel(format!("{}.B", layer.name())), blue);
    }
}
