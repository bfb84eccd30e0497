//! The keys of every record of a scene, in the order in which they are written.

use super::keys::{Allowed, Keys};
use crate::math::{DVec3, Degrees};
use crate::scene::{
    Background, Bookmark, Camera, Choice, Copies, Display, Facing, Light, Material, NamedLight,
    Object, Output, PngBits, RenderSettings, Rgb, Scene, Stop,
};

/// The whole file. `scene` holds the defaults when reading.
pub fn scene(keys: &mut Keys<'_>, scene: &mut Scene) {
    keys.record("camera", |keys| camera(keys, &mut scene.camera));
    let up = scene.camera.up;
    keys.record("background", |keys| {
        background(keys, &mut scene.background, up);
    });
    keys.map("materials", &mut scene.materials, material);
    keys.list("objects", &mut scene.objects, object);
    let mut lights = scene.named_lights();
    keys.list("lights", &mut lights, named_light);
    scene.set_named_lights(lights);
    keys.list("bookmarks", &mut scene.bookmarks, bookmark);
    keys.record("render", |keys| render(keys, &mut scene.render));
    keys.record("display", |keys| display(keys, &mut scene.display));
    keys.record("output", |keys| output(keys, &mut scene.output));
    keys.finish();
}

fn bookmark(keys: &mut Keys<'_>, bookmark: &mut Bookmark) {
    keys.text("name", &mut bookmark.name);
    camera(keys, &mut bookmark.camera);
}

fn camera(keys: &mut Keys<'_>, camera: &mut Camera) {
    keys.vector("eye", &mut camera.eye);
    keys.vector("target", &mut camera.target);
    keys.vector("up", &mut camera.up);
    keys.number(
        "vertical_fov",
        &mut camera.vertical_fov.0,
        Allowed::Between(0.0, 180.0),
    );
    keys.number(
        "aperture_radius",
        &mut camera.aperture_radius,
        Allowed::NotNegative,
    );
    keys.optional_number(
        "focus_distance",
        &mut camera.focus_distance,
        Allowed::PositiveOrInfinite,
    );
}

/// What a background may have, by its kind; `up` goes with the latter two.
const GRADIENT_KEYS: [&str; 3] = ["zenith", "horizon", "ground"];
const IMAGE_KEYS: [&str; 3] = ["image", "rotation", "scale"];

fn background(keys: &mut Keys<'_>, background: &mut Background, camera_up: DVec3) {
    if keys.is_reading() {
        *background = background_of_kind(keys, camera_up);
    }
    match background {
        Background::Constant { radiance } => keys.color("radiance", radiance),
        Background::Gradient {
            zenith,
            horizon,
            ground,
            up,
        } => {
            keys.color("zenith", zenith);
            keys.color("horizon", horizon);
            if keys.is_reading() {
                *ground = *horizon;
            }
            keys.color("ground", ground);
            keys.vector("up", up);
        }
        Background::Image {
            image,
            up,
            rotation,
            scale,
        } => {
            keys.text("image", image);
            keys.vector("up", up);
            keys.number("rotation", &mut rotation.0, Allowed::Any);
            keys.number("scale", scale, Allowed::NotNegative);
        }
    }
    // Known here too, so that a misspelt key of another kind finds its neighbour.
    for key in GRADIENT_KEYS.into_iter().chain(IMAGE_KEYS).chain(["up"]) {
        keys.know(key);
    }
}

/// The keys of a background that make way for a new `key` of it.
pub fn excluded_by(key: &str) -> &'static [&'static str] {
    match key {
        "radiance" => &[
            "zenith", "horizon", "ground", "up", "image", "rotation", "scale",
        ],
        "zenith" | "horizon" | "ground" => &["radiance", "image", "rotation", "scale"],
        "image" => &["radiance", "zenith", "horizon", "ground"],
        "up" => &["radiance"],
        _ => &[],
    }
}

/// The kind of background that the keys of a file ask for, with its defaults. Keys of another kind are refused.
fn background_of_kind(keys: &mut Keys<'_>, camera_up: DVec3) -> Background {
    const NOT_EVEN: &str = "is for a background that is the same everywhere; leave it out beside";
    let has_any = |keys: &Keys<'_>, of: &[&str]| of.iter().any(|key| keys.has(key));
    if keys.has("image") {
        keys.refuse("radiance", &format!("{NOT_EVEN} an image"));
        for key in GRADIENT_KEYS {
            keys.refuse(key, "is for a gradient; leave it out beside an image");
        }
        return Background::Image {
            image: String::new(),
            up: camera_up,
            rotation: Degrees(0.0),
            scale: 1.0,
        };
    }
    for key in ["rotation", "scale"] {
        keys.refuse(key, "is for a background with an `image`");
    }
    if has_any(keys, &GRADIENT_KEYS) || keys.has("up") {
        keys.refuse("radiance", &format!("{NOT_EVEN} a gradient"));
        return Background::Gradient {
            zenith: Rgb::ZERO,
            horizon: Rgb::ZERO,
            ground: Rgb::ZERO,
            up: camera_up,
        };
    }
    Background::default()
}

/// The values of `kind` in `[materials.NAME]`.
#[derive(Clone, Copy, PartialEq)]
enum MaterialKind {
    Phong,
    Mirror,
    Glass,
    Emitter,
}

impl Choice for MaterialKind {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Phong, "phong"),
        (Self::Mirror, "mirror"),
        (Self::Glass, "glass"),
        (Self::Emitter, "emitter"),
    ];
}

fn material(keys: &mut Keys<'_>, material: &mut Material) {
    let mut kind = match material {
        Material::Phong { .. } => MaterialKind::Phong,
        Material::Mirror { .. } => MaterialKind::Mirror,
        Material::Glass { .. } => MaterialKind::Glass,
        Material::Emitter { .. } => MaterialKind::Emitter,
    };
    keys.choice("kind", &mut kind);
    if keys.is_reading() {
        *material = match kind {
            MaterialKind::Phong => Material::default(),
            MaterialKind::Mirror => Material::mirror(),
            MaterialKind::Glass => Material::glass(),
            MaterialKind::Emitter => Material::emitter(),
        };
    }
    match material {
        Material::Phong {
            diffuse,
            specular,
            shininess,
            textures,
        } => {
            keys.color("diffuse", diffuse);
            keys.optional_text("diffuse_image", &mut textures.diffuse_image);
            keys.optional_text("normal_image", &mut textures.normal_image);
            if keys.is_reading() || textures.vertex_colors {
                keys.flag("vertex_colors", &mut textures.vertex_colors);
            }
            keys.color("specular", specular);
            let allowed = Allowed::Within(0.0, Material::MAX_SHININESS);
            keys.number("shininess", shininess, allowed);
        }
        Material::Mirror { reflectance } => keys.color("reflectance", reflectance),
        Material::Glass { ior, attenuation } => {
            let allowed = Allowed::Within(Material::MIN_IOR, Material::MAX_IOR);
            keys.number("ior", ior, allowed);
            keys.color("attenuation", attenuation);
        }
        Material::Emitter { radiance } => keys.color("radiance", radiance),
    }
}

fn object(keys: &mut Keys<'_>, object: &mut Object) {
    keys.text("name", &mut object.name);
    keys.required_text("mesh", &mut object.mesh);
    keys.optional_text("material", &mut object.material);
    keys.flag("smooth", &mut object.smooth);
    keys.number(
        "crease_angle",
        &mut object.crease_angle.0,
        Allowed::Within(0.0, 180.0),
    );
    if keys.is_reading() || object.repair_winding {
        keys.flag("repair_winding", &mut object.repair_winding);
    }
    keys.number("scale", &mut object.scale, Allowed::NonZero);
    keys.vector("rotate", &mut object.rotate);
    keys.vector("translate", &mut object.translate);
    if keys.is_reading() || object.copies != Copies::default() {
        keys.record("copies", |keys| {
            keys.counts("count", &mut object.copies.count);
            keys.vector("step", &mut object.copies.step);
        });
    }
}

/// The values of `kind` in `[[lights]]`.
#[derive(Clone, Copy, PartialEq)]
enum LightKind {
    Point,
    Disk,
}

impl Choice for LightKind {
    const ALL: &'static [(Self, &'static str)] = &[(Self::Point, "point"), (Self::Disk, "disk")];
}

fn named_light(keys: &mut Keys<'_>, named: &mut NamedLight) {
    if keys.is_reading() || !named.name.is_empty() {
        keys.text("name", &mut named.name);
    }
    light(keys, &mut named.light);
}

fn light(keys: &mut Keys<'_>, light: &mut Light) {
    let mut kind = match light {
        Light::Point { .. } => LightKind::Point,
        Light::Disk { .. } => LightKind::Disk,
    };
    keys.choice("kind", &mut kind);
    if keys.is_reading() {
        *light = match kind {
            LightKind::Point => Light::default(),
            LightKind::Disk => Light::disk(),
        };
    }
    match light {
        Light::Point {
            position,
            intensity,
        } => {
            keys.vector("position", position);
            keys.color("intensity", intensity);
        }
        Light::Disk {
            center,
            facing: direction,
            radius,
            radiance,
            visible,
        } => {
            keys.vector("center", center);
            facing(keys, direction);
            keys.number("radius", radius, Allowed::Positive);
            keys.color("radiance", radiance);
            keys.flag("visible", visible);
        }
    }
}

fn facing(keys: &mut Keys<'_>, facing: &mut Facing) {
    if keys.has("target") {
        *facing = Facing::Target(DVec3::ZERO);
        keys.refuse("normal", "says the same as `target`; leave one of them out");
    }
    match facing {
        Facing::Target(target) => keys.vector("target", target),
        Facing::Normal(normal) => keys.vector("normal", normal),
    }
    keys.know("target");
}

fn render(keys: &mut Keys<'_>, render: &mut RenderSettings) {
    keys.choice("mode", &mut render.mode);
    keys.integer("width", &mut render.width, 1..=RenderSettings::MAX_SIDE);
    keys.integer("height", &mut render.height, 1..=RenderSettings::MAX_SIDE);
    keys.integer(
        "samples_per_pixel",
        &mut render.samples_per_pixel,
        1..=RenderSettings::MAX_SAMPLES,
    );
    keys.flag("adaptive", &mut render.adaptive);
    keys.flag("error_estimate", &mut render.error_estimate);
    keys.integer("seed", &mut render.seed, 0..=RenderSettings::MAX_SEED);
    keys.choice("sampler", &mut render.sampler);
    keys.integer(
        "max_bounces",
        &mut render.max_bounces,
        0..=RenderSettings::MAX_BOUNCES,
    );
    keys.flag("roulette", &mut render.roulette);
    keys.choice("light_sampling", &mut render.light_sampling);
    keys.choice("filter", &mut render.filter);
    keys.choice("shadows", &mut render.shadows);
    keys.integer(
        "shadow_samples",
        &mut render.shadow_samples,
        1..=RenderSettings::MAX_RAYS_PER_SAMPLE,
    );
    keys.flag("mirror", &mut render.mirror);
    keys.flag("glass", &mut render.glass);
    keys.flag("depth_of_field", &mut render.depth_of_field);
    keys.flag("antialiasing", &mut render.antialiasing);
    keys.choice("phong", &mut render.phong);
    keys.optional_number("clamp", &mut render.clamp, Allowed::Positive);
    keys.choice("accelerator", &mut render.accelerator);
    keys.choice("accelerator_build", &mut render.accelerator_build);
    let stop = &mut render.stop;
    if keys.is_reading() || *stop != Stop::default() {
        keys.record("stop", |keys| {
            keys.optional_number("seconds", &mut stop.seconds, Allowed::Positive);
            keys.optional_number("noise", &mut stop.noise, Allowed::Positive);
            keys.optional_integer("passes", &mut stop.passes, 1..=u32::MAX);
        });
    }
    let occlusion = &mut render.ambient_occlusion;
    keys.record("ambient_occlusion", |keys| {
        keys.flag("enabled", &mut occlusion.enabled);
        keys.integer(
            "samples",
            &mut occlusion.samples,
            1..=RenderSettings::MAX_RAYS_PER_SAMPLE,
        );
        keys.number("radius", &mut occlusion.radius, Allowed::Positive);
    });
}

fn display(keys: &mut Keys<'_>, display: &mut Display) {
    // Beyond this many stops nothing of an f32 picture is left to see.
    keys.number(
        "exposure",
        &mut display.exposure,
        Allowed::Within(-150.0, 150.0),
    );
    keys.choice("tone_curve", &mut display.tone_curve);
    // Beyond these a picture is white or black.
    keys.number("gamma", &mut display.gamma, Allowed::Within(0.1, 10.0));
}

fn output(keys: &mut Keys<'_>, output: &mut Output) {
    keys.numbered_choice(
        "png_bits",
        &mut output.png_bits,
        &[(PngBits::Eight, 8), (PngBits::Sixteen, 16)],
    );
    keys.flag("layers", &mut output.layers);
}
