//! Small pictures of what materials look like: a ball before a chequered wall, rendered by our own tracer.
//!
//! A ball is asked for where it is drawn ([`Balls::texture`]); the app has what is missing rendered in the background, on one thread,
//! and nothing happens where nothing is missing. Materials that look the same share a ball. Images lie on it once around: their middle in
//! front, their edges meeting behind.

use std::collections::BTreeMap;
use std::sync::Arc;

use egui::{ColorImage, TextureHandle, TextureId, TextureOptions};

use super::event::Event;
use super::jobs::Job;
use crate::control::CancelToken;
use crate::geometry::{TriangleMesh, shapes};
use crate::math::{DBounds, DVec2, DVec3, Degrees};
use crate::render::{PreparedScene, RenderProgress, RunConfig, display, render};
use crate::scene::{
    Background, Filter, Light, Material, Mode, Object, RenderSettings, Rgb, Scene, TextureImage,
    Textures, presets,
};

/// Images of textures by the names that materials have for them.
type Images = BTreeMap<String, Arc<TextureImage>>;

/// Side of the pictures, in pixels.
const SIDE: u32 = 88;
/// Diameter of the ball, as a share of that.
pub const SHARE: f32 = 0.9;
/// Samples of a pixel.
const SAMPLES: u32 = 32;
/// Pictures that are kept.
const MOST: usize = 200;
/// Pictures that one job makes: others may be asked for meanwhile.
const MOST_AT_ONCE: usize = 4;
/// Most texels of an image on a ball: larger ones would take longer than a ball is worth.
const MOST_TEXELS: u64 = 1 << 25;
/// Name of the material, and of the mesh that has it.
const BALL: &str = "ball";

/// What materials look like, as far as it is known.
#[derive(Default)]
pub struct Balls {
    /// The oldest first.
    known: Vec<Known>,
    /// The images of the scene.
    images: Images,
    /// What was shown last for a name: it stays until what the material has become is there.
    shown: BTreeMap<String, TextureHandle>,
    /// What was asked for since the last request.
    missing: Vec<Material>,
    /// What a job was asked for that it has not made yet.
    requested: Vec<Material>,
    /// What all balls share, once there was one.
    prepared: Arc<std::sync::OnceLock<PreparedScene>>,
}

/// A material whose ball is known.
struct Known {
    material: Material,
    /// The images that were on it.
    images: Images,
    /// `None` where it cannot be rendered.
    texture: Option<TextureHandle>,
}

/// Whether two sets of images are the same ones under the same names.
fn are_same(a: &Images, b: &Images) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| a.0 == b.0 && Arc::ptr_eq(a.1, b.1))
}

impl Balls {
    /// Takes the images of the scene; balls with others are made anew.
    pub fn set_images(&mut self, images: &Images) {
        if are_same(&self.images, images) {
            return;
        }
        self.images.clone_from(images);
        self.known
            .retain(|known| are_same(&known.images, &images_of(&known.material, images)));
    }

    /// The ball of `material`; while it is not there, that of what the material called `name` was before, where it has a name.
    pub fn texture(&mut self, name: Option<&str>, material: &Material) -> Option<TextureId> {
        let known = self.known.iter().find(|known| known.material == *material);
        match known.map(|known| &known.texture) {
            Some(Some(texture)) => {
                if let Some(name) = name
                    && self.shown.get(name).map(TextureHandle::id) != Some(texture.id())
                {
                    self.shown.insert(name.to_owned(), texture.clone());
                }
                Some(texture.id())
            }
            Some(None) => None,
            None => {
                if !self.missing.contains(material) {
                    self.missing.push(Material::clone(material));
                }
                self.shown.get(name?).map(TextureHandle::id)
            }
        }
    }

    /// Whether the ball of `material` is there.
    #[must_use]
    pub fn has(&self, material: &Material) -> bool {
        let mut known = self.known.iter();
        known.any(|known| known.material == *material && known.texture.is_some())
    }

    /// What is missing of what was drawn since the last call.
    pub fn next_request(&mut self) -> Option<BallRequest> {
        let mut materials = std::mem::take(&mut self.missing);
        materials.truncate(MOST_AT_ONCE);
        self.requested.clone_from(&materials);
        (!materials.is_empty()).then(|| BallRequest {
            materials: materials
                .into_iter()
                .map(|material| {
                    let images = images_of(&material, &self.images);
                    (material, images)
                })
                .collect(),
            prepared: Arc::clone(&self.prepared),
        })
    }

    /// Takes in what a job made.
    pub fn put(&mut self, ctx: &egui::Context, material: Material, image: Option<ColorImage>) {
        let texture = image.map(|image| ctx.load_texture(BALL, image, TextureOptions::LINEAR));
        self.requested.retain(|requested| *requested != material);
        self.learn(material, texture);
        if self.shown.len() > MOST {
            self.shown.clear();
        }
    }

    /// The job ended by a fault: what it has not made is not asked for again, which would end the same way.
    pub fn give_up(&mut self) {
        for material in std::mem::take(&mut self.requested) {
            self.learn(material, None);
        }
    }

    fn learn(&mut self, material: Material, texture: Option<TextureHandle>) {
        if self.known.len() == MOST {
            self.known.remove(0);
        }
        let images = images_of(&material, &self.images);
        self.known.push(Known {
            material,
            images,
            texture,
        });
    }
}

impl std::fmt::Debug for Balls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Balls")
            .field("known", &self.known.len())
            .field("missing", &self.missing.len())
            .finish_non_exhaustive()
    }
}

/// What a job works with.
#[derive(Debug)]
pub struct BallRequest {
    /// With their images.
    materials: Vec<(Material, Images)>,
    prepared: Arc<std::sync::OnceLock<PreparedScene>>,
}

impl BallRequest {
    /// Renders the balls, and sends each.
    pub fn render(self, job: &Job<Event>) {
        for (material, images) in self.materials {
            if job.cancel.is_cancelled() {
                return;
            }
            let image = image_of(&material, &images, &self.prepared, &job.cancel);
            job.send(Event::BallRendered { material, image });
        }
    }
}

/// Those of `images` that are on `material` and not too large.
fn images_of(material: &Material, images: &Images) -> Images {
    let Some(textures) = material.textures() else {
        return Images::new();
    };
    let names = [&textures.diffuse_image, &textures.normal_image];
    let named = names.into_iter().flatten().filter_map(|name| {
        let image = images.get(name)?;
        let texels = u64::from(image.width()) * u64::from(image.height());
        (texels <= MOST_TEXELS).then(|| (name.clone(), Arc::clone(image)))
    });
    named.collect()
}

/// The ball of `material`; `None` where it cannot be rendered. The first one puts what the others share into `shared`.
fn image_of(
    material: &Material,
    images: &Images,
    shared: &std::sync::OnceLock<PreparedScene>,
    cancel: &CancelToken,
) -> Option<ColorImage> {
    let scene = scene_of(material, images);
    let prepared = PreparedScene::prepare(&scene, shared.get(), cancel);
    let prepared = prepared.ok().flatten()?;
    let run = RunConfig {
        threads: 1,
        cancel: cancel.clone(),
        ..RunConfig::default()
    };
    let outcome = render(&prepared, None, &run, &RenderProgress::default(), None)?;
    let _ = shared.set(prepared);
    let color = |&rgb: &[f32; 3]| {
        let [r, g, b] = display::encode_8(rgb, &scene.display);
        egui::Color32::from_rgb(r, g, b)
    };
    let side = SIDE as usize;
    let pixels = outcome.image.pixels.iter().map(color).collect();
    Some(ColorImage::new([side, side], pixels))
}

/// A ball of radius 1 on a dark floor before a chequered wall, under a disk and a bright sky.
fn scene_of(material: &Material, images: &Images) -> Scene {
    let mut scene = Scene {
        background: Background::Gradient {
            zenith: Rgb::new(0.34, 0.41, 0.52),
            horizon: Rgb::new(0.52, 0.53, 0.55),
            ground: Rgb::splat(0.08),
            up: DVec3::Z,
        },
        lights: vec![Light::disk()],
        render: RenderSettings {
            mode: Mode::Path,
            width: SIDE,
            height: SIDE,
            samples_per_pixel: SAMPLES,
            error_estimate: false,
            filter: Filter::Gaussian,
            // Without bright specks, which are larger than life in so small a picture.
            clamp: Some(4.0),
            ..RenderSettings::default()
        },
        ..Scene::default()
    };
    scene.lights[0] = Light::Disk {
        center: DVec3::new(-3.0, -4.0, 5.0),
        facing: crate::scene::Facing::Target(DVec3::ZERO),
        radius: 1.2,
        radiance: Rgb::splat(22.0),
        visible: true,
    };
    let matt = |value: f64| {
        let mut matt = Material::default();
        if let Material::Phong { diffuse, .. } = &mut matt {
            *diffuse = Rgb::splat(value);
        }
        matt
    };
    let mut add = |name: &str, mesh: TriangleMesh, material: Material, smooth: bool| {
        scene.meshes.insert(name.to_owned(), Arc::new(mesh));
        scene.materials.insert(name.to_owned(), material);
        scene.objects.push(Object {
            name: name.to_owned(),
            mesh: name.to_owned(),
            material: Some(name.to_owned()),
            smooth,
            ..Object::default()
        });
    };
    // Images that are not there are left out, and the ball's corners have no colours.
    let mut worn = material.clone();
    if let Some(textures) = worn.textures_mut() {
        let there = |name: &Option<String>| name.clone().filter(|name| images.contains_key(name));
        *textures = Textures {
            diffuse_image: there(&textures.diffuse_image),
            normal_image: there(&textures.normal_image),
            vertex_colors: false,
        };
    }
    add(BALL, ball(), worn, true);
    let [light, dark] = chequers();
    add("light squares", light, matt(0.7), false);
    add("dark squares", dark, matt(0.12), false);
    let ball = DBounds {
        min: DVec3::splat(-1.0),
        max: DVec3::splat(1.0),
    };
    let towards = DVec3::new(0.0, -1.0, 0.25);
    let fov = Degrees(24.0);
    scene.textures.clone_from(images);
    scene.camera = presets::framing(&ball, towards, DVec3::Z, fov, 1.0);
    // That frames the ball around the box, which is larger by √3.
    let distance = 1.0
        / ((fov.radians() / 2.0).tan() * f64::from(SHARE))
            .atan()
            .sin();
    scene.camera.eye = towards.normalize() * distance;
    scene
}

/// The ball, with an image once around it: across by the angle about Z from behind, upwards by height as on a map.
fn ball() -> TriangleMesh {
    use std::f64::consts::{PI, TAU};
    let mut mesh = shapes::icosphere(5);
    let on_image = |place: &DVec3| {
        let across = 0.5 + f64::atan2(place.x, -place.y) / TAU;
        let upwards = 0.5 + place.z.clamp(-1.0, 1.0).asin() / PI;
        DVec2::new(across, upwards)
    };
    mesh.texture_coordinates = Some(mesh.positions.iter().map(on_image).collect());
    mesh
}

/// The light and the dark squares of a floor under the ball and a wall behind it.
fn chequers() -> [TriangleMesh; 2] {
    const SQUARES: i32 = 10;
    const WIDTH: f64 = 0.8;
    let mut meshes = [TriangleMesh::default(), TriangleMesh::default()];
    for plane in [Plane::Floor, Plane::Wall] {
        for row in 0..SQUARES {
            for column in -SQUARES / 2..SQUARES / 2 {
                let mesh = &mut meshes[usize::from((row + column).rem_euclid(2) == 1)];
                let first = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
                for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                    let across = f64::from(column + x) * WIDTH;
                    let away = f64::from(row + y) * WIDTH;
                    mesh.positions.push(match plane {
                        Plane::Floor => DVec3::new(across, 2.4 - away, -1.0),
                        Plane::Wall => DVec3::new(across, 2.4, away - 1.0),
                    });
                }
                let corners = [[0, 1, 2], [0, 2, 3]];
                let triangles = corners.map(|corners| corners.map(|corner| first + corner));
                mesh.triangles.extend(triangles);
            }
        }
    }
    meshes
}

#[derive(Clone, Copy)]
enum Plane {
    Floor,
    Wall,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Texels;

    fn image(material: &Material) -> ColorImage {
        let shared = std::sync::OnceLock::new();
        image_of(material, &Images::new(), &shared, &CancelToken::new()).expect("can be rendered")
    }

    fn materials(request: Option<BallRequest>) -> Vec<Material> {
        let materials = request.unwrap().materials.into_iter();
        materials.map(|(material, _)| material).collect()
    }

    /// A material with an image whose left half is red and whose right half is blue.
    fn flag(name: &str) -> (Material, Images) {
        let mut material = Material::default();
        if let Material::Phong {
            diffuse, textures, ..
        } = &mut material
        {
            *diffuse = Rgb::ONE;
            textures.diffuse_image = Some(name.to_owned());
        }
        let texels = vec![[255, 0, 0], [255, 0, 0], [0, 0, 255], [0, 0, 255]];
        let image = TextureImage::new(4, 1, Texels::Bytes(texels));
        let images = Images::from([(name.to_owned(), Arc::new(image))]);
        (material, images)
    }

    #[test]
    fn an_image_is_on_the_ball_and_comes_anew_with_the_file() {
        let (material, images) = flag("flag.png");
        let shared = std::sync::OnceLock::new();
        let image = image_of(&material, &images, &shared, &CancelToken::new()).unwrap();
        let side = image.size[0];
        let [left, right] =
            [1, 3].map(|quarters| image.pixels[side / 2 * side + side * quarters / 4]);
        // Between two texels their colours go over into each other.
        assert!(left.r() > left.b().saturating_add(60), "{left:?}");
        assert!(right.b() > right.r().saturating_add(60), "{right:?}");

        let mut balls = Balls::default();
        balls.set_images(&images);
        balls.texture(None, &material);
        let request = balls.next_request().unwrap();
        assert_eq!(request.materials[0].1.len(), 1);
        let ctx = egui::Context::default();
        balls.put(&ctx, Material::clone(&material), Some(image));
        balls.set_images(&images);
        assert!(balls.has(&material));
        let (_, written_anew) = flag("flag.png");
        balls.set_images(&written_anew);
        assert!(!balls.has(&material));
    }

    /// Mean of the channels of the pixels around the middle.
    fn middle(image: &ColorImage) -> [f64; 3] {
        let side = image.size[0];
        let mut sums = [0.0; 3];
        for y in side / 2 - 4..side / 2 + 4 {
            for x in side / 2 - 4..side / 2 + 4 {
                let pixel = image.pixels[y * side + x].to_array();
                for channel in 0..3 {
                    sums[channel] += f64::from(pixel[channel]) / 64.0;
                }
            }
        }
        sums
    }

    #[test]
    fn a_ball_has_the_color_of_its_material() {
        let presets = presets::materials::all();
        let ball = |name: &str| {
            let preset = presets.iter().find(|preset| preset.name == name).unwrap();
            middle(&image(&preset.material))
        };
        let [red, green, _] = ball("Red plastic");
        assert!(red > 1.8 * green, "{red} {green}");
        let [plaster, ..] = ball("Plaster");
        let [rubber, ..] = ball("Rubber");
        assert!(plaster > 150.0 && rubber < 90.0, "{plaster} {rubber}");
        let [red, _, blue] = ball("Gold");
        assert!(red > 1.3 * blue, "{red} {blue}");
    }

    #[test]
    fn the_ball_fills_its_share_of_the_picture() {
        let emitter = Material::Emitter {
            radiance: Rgb::splat(3.0),
        };
        let image = image(&emitter);
        let side = image.size[0];
        let bright = |pixel: &egui::Color32| pixel.r() > 238;
        let row = &image.pixels[side / 2 * side..(side / 2 + 1) * side];
        let width = row.iter().filter(|pixel| bright(pixel)).count() as f32;
        let share = width / side as f32;
        assert!((share - SHARE).abs() < 0.04, "{share}");
    }

    #[test]
    fn what_a_job_failed_at_is_not_asked_for_again() {
        let mut balls = Balls::default();
        let materials = [Material::mirror(), Material::default()];
        for material in &materials {
            balls.texture(None, material);
        }
        assert_eq!(self::materials(balls.next_request()), materials);
        let image = ColorImage::filled([2, 2], egui::Color32::RED);
        balls.put(&egui::Context::default(), Material::mirror(), Some(image));
        balls.give_up();
        let textures = materials.map(|material| balls.texture(None, &material));
        assert!(textures[0].is_some() && textures[1].is_none());
        assert!(balls.next_request().is_none());
    }

    #[test]
    fn what_is_missing_is_asked_for_once_and_forgotten_when_it_is_not_drawn() {
        let mut balls = Balls::default();
        let material = Material::mirror();
        for _ in 0..2 {
            assert_eq!(balls.texture(Some("chrome"), &material), None);
        }
        assert_eq!(materials(balls.next_request()), [Material::mirror()]);
        assert!(balls.next_request().is_none());
        let ctx = egui::Context::default();
        let image = ColorImage::filled([2, 2], egui::Color32::RED);
        balls.put(&ctx, Material::mirror(), Some(image));
        let mirror = balls.texture(Some("chrome"), &material);
        assert!(mirror.is_some() && balls.has(&material));
        // What it was stays until what it has become is there.
        let glass = Material::glass();
        assert_eq!(balls.texture(Some("chrome"), &glass), mirror);
        assert_eq!(balls.texture(None, &glass), None);
        assert_eq!(materials(balls.next_request()), [Material::glass()]);
        balls.put(&ctx, Material::glass(), None);
        assert_eq!(balls.texture(Some("chrome"), &glass), None);
        assert!(balls.next_request().is_none());
    }
}
