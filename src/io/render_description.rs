//! All that the radiance of a picture follows from, as a text with a line for each: two renders with the same text end in the
//! same bits.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::scene_file;
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::math::{DVec2, DVec3, Vec3};
use crate::render::{Layer, Region};
use crate::scene::{
    Background, Display, Output, RadianceMap, Scene, Texels, TextureImage, Textures,
};

/// Describes a render of `region` of `scene` that keeps `layers`: the scene file, in which meshes and images are named by what is
/// in them, so that it does not matter where they lie. How the picture is shown and stored is left out. `None` when cancelled.
#[must_use]
pub fn describe_render(
    scene: &Scene,
    region: Region,
    layers: &[Layer],
    cancel: &CancelToken,
) -> Option<String> {
    let mut named = Scene {
        display: Display::default(),
        output: Output::default(),
        bookmarks: Vec::new(),
        ..scene.clone()
    };
    let meshes = scene.meshes.iter();
    let meshes: BTreeMap<&String, String> = meshes
        .map(|(name, mesh)| (name, name_by_content(name, &hash_of_mesh(mesh, cancel))))
        .collect();
    for object in &mut named.objects {
        if let Some(name) = meshes.get(&object.mesh) {
            object.mesh.clone_from(name);
        }
    }
    if let Background::Image { image, .. } = &mut named.background
        && let Some(map) = scene.images.get(image)
    {
        *image = name_by_content(image, &hash_of_image(map, cancel));
    }
    for image in named.material_textures_mut().flat_map(Textures::images_mut) {
        if let Some(texture) = scene.textures.get(image) {
            *image = name_by_content(image, &hash_of_texture(texture, cancel));
        }
    }
    let layers: Vec<&str> = layers.iter().map(|layer| layer.name()).collect();
    let Region {
        x,
        y,
        width,
        height,
    } = region;
    let description = || {
        format!(
            "version = {}\nregion = {x},{y},{width},{height}\nlayers = {layers:?}\n\n{}",
            env!("CARGO_PKG_VERSION"),
            scene_file::write(&named)
        )
    };
    (!cancel.is_cancelled()).then(description)
}

/// Where two descriptions differ first, by the order of keys, as a sentence about `saved`; `None` where they do not.
#[must_use]
pub fn difference(saved: &str, here: &str) -> Option<String> {
    if saved == here {
        return None;
    }
    let (saved, here) = (values(saved), values(here));
    let differs = |key: &&String| saved.get(*key) != here.get(*key);
    let key = saved.keys().chain(here.keys()).filter(differs).min()?;
    let value = |values: &BTreeMap<String, &str>| {
        let value = values.get(key);
        value.map_or_else(|| "not there".to_owned(), ToString::to_string)
    };
    Some(format!("{key} is {}, here {}", value(&saved), value(&here)))
}

/// Every line `key = value` by its dotted key, list items by number.
fn values(description: &str) -> BTreeMap<String, &str> {
    let mut values = BTreeMap::new();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut table = String::new();
    for line in description.lines() {
        let list = line.strip_prefix("[[").and_then(|l| l.strip_suffix("]]"));
        let record = line.strip_prefix('[').and_then(|l| l.strip_suffix(']'));
        if let Some(list) = list {
            let count = counts.entry(list).or_default();
            table = format!("{list}.{count}.");
            *count += 1;
        } else if let Some(record) = record {
            table = format!("{record}.");
        } else if let Some((key, value)) = line.split_once(" = ") {
            values.insert(format!("{table}{key}"), value);
        }
    }
    values
}

fn name_by_content(name: &str, hash: &str) -> String {
    let file = Path::new(name).file_name();
    let file = file.map_or(name.into(), |file| file.to_string_lossy());
    format!("{file} with the SHA-256 {hash}")
}

/// Over positions, triangles and normals, each preceded by their number, and what else vertices have, preceded by its name.
fn hash_of_mesh(mesh: &TriangleMesh, cancel: &CancelToken) -> String {
    let mut digest = Digested::new(cancel);
    let vectors = |digest: &mut Digested<'_>, vectors: &[DVec3]| {
        digest.take((vectors.len() as u64).to_le_bytes());
        let coordinates = vectors.iter().flat_map(DVec3::to_array);
        digest.take_all(coordinates.map(f64::to_le_bytes));
    };
    vectors(&mut digest, &mesh.positions);
    digest.take((mesh.triangles.len() as u64).to_le_bytes());
    let corners = mesh.triangles.iter().flatten();
    digest.take_all(corners.map(|corner| corner.to_le_bytes()));
    if let Some(normals) = &mesh.normals {
        vectors(&mut digest, normals);
    }
    if let Some(coordinates) = &mesh.texture_coordinates {
        digest.take("texture coordinates");
        let coordinates = coordinates.iter().flat_map(DVec2::to_array);
        digest.take_all(coordinates.map(f64::to_le_bytes));
    }
    if let Some(colors) = &mesh.colors {
        digest.take("colours");
        let channels = colors.iter().flat_map(Vec3::to_array);
        digest.take_all(channels.map(f32::to_le_bytes));
    }
    digest.in_hexadecimal()
}

fn hash_of_image(map: &RadianceMap, cancel: &CancelToken) -> String {
    let mut digest = Digested::new(cancel);
    digest.take(map.width().to_le_bytes());
    digest.take(map.height().to_le_bytes());
    let values = map.pixels().iter().flatten();
    digest.take_all(values.map(|value| value.to_le_bytes()));
    digest.in_hexadecimal()
}

fn hash_of_texture(image: &TextureImage, cancel: &CancelToken) -> String {
    let mut digest = Digested::new(cancel);
    digest.take(image.width().to_le_bytes());
    digest.take(image.height().to_le_bytes());
    match image.texels() {
        Texels::Bytes(texels) => {
            digest.take_all(texels.chunks(16).map(<[_]>::as_flattened));
        }
        Texels::Words(texels) => {
            digest.take_all(texels.iter().flatten().map(|value| value.to_le_bytes()));
        }
        Texels::Floats(texels) => {
            digest.take_all(texels.iter().flatten().map(|value| value.to_le_bytes()));
        }
    }
    digest.in_hexadecimal()
}

/// The SHA-256 of what it takes; not meaningful when cancelled.
struct Digested<'a> {
    digest: Sha256,
    cancel: &'a CancelToken,
}

impl<'a> Digested<'a> {
    fn new(cancel: &'a CancelToken) -> Self {
        Self {
            digest: Sha256::new(),
            cancel,
        }
    }

    fn take(&mut self, bytes: impl AsRef<[u8]>) {
        self.digest.update(bytes);
    }

    /// Takes what may be very much.
    fn take_all(&mut self, values: impl Iterator<Item = impl AsRef<[u8]>>) {
        /// Values between two looks at the cancel token.
        const CHUNK: usize = 1 << 16;
        for (number, value) in values.enumerate() {
            if number % CHUNK == 0 && self.cancel.is_cancelled() {
                return;
            }
            self.digest.update(value);
        }
    }

    fn in_hexadecimal(self) -> String {
        let mut text = String::with_capacity(64);
        for byte in self.digest.finalize() {
            write!(text, "{byte:02x}").expect("a text takes all that is written to it");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::shapes;
    use crate::scene::{Light, Object};

    type Change = fn(&mut Scene);

    fn scene() -> Scene {
        let mut scene = Scene::default();
        for name in ["/home/a/ball.off", "/home/a/block.off"] {
            scene
                .meshes
                .insert(name.into(), Arc::new(shapes::icosphere(0)));
            scene.objects.push(Object {
                mesh: name.into(),
                ..Object::default()
            });
        }
        scene
    }

    fn describe(scene: &Scene) -> String {
        describe_part(scene, Region::full(640, 480), &[Layer::Emission])
    }

    fn describe_part(scene: &Scene, region: Region, layers: &[Layer]) -> String {
        let description = describe_render(scene, region, layers, &CancelToken::new());
        description.expect("nobody cancels")
    }

    #[test]
    fn nothing_is_described_when_cancelled() {
        let cancel = CancelToken::new();
        cancel.cancel();
        let description = describe_render(&scene(), Region::full(1, 1), &[], &cancel);
        assert_eq!(description, None);
    }

    #[test]
    fn where_meshes_lie_does_not_matter_but_what_is_in_them() {
        let here = scene();
        let mut moved = here.clone();
        for object in &mut moved.objects {
            let name = object.mesh.replace("/home/a", "/other/place");
            let mesh = moved.meshes.remove(&object.mesh).expect("is there");
            moved.meshes.insert(name.clone(), mesh);
            object.mesh = name;
        }
        assert_eq!(describe(&here), describe(&moved));

        let mut other = here.clone();
        let mesh = other.meshes.get_mut("/home/a/block.off").expect("is there");
        Arc::make_mut(mesh).positions[0].x += 1e-9;
        let difference = difference(&describe(&here), &describe(&other)).expect("differ");
        assert!(
            difference.starts_with("objects.1.mesh is \"block.off with the SHA-256 "),
            "{difference}"
        );
    }

    #[test]
    fn the_first_key_that_differs_is_named() {
        let here = scene();
        let changed = |change: Change| {
            let mut scene = scene();
            change(&mut scene);
            difference(&describe(&here), &describe(&scene))
        };
        assert_eq!(changed(|_| ()), None);
        let cases: [(Change, &str); 4] = [
            (
                |scene| scene.render.samples_per_pixel = 5,
                "render.samples_per_pixel is 16, here 5",
            ),
            (
                |scene| scene.render.stop.noise = Some(0.5),
                "render.stop.noise is not there, here 0.5",
            ),
            (
                |scene| scene.objects[1].scale = 2.0,
                "objects.1.scale is 1.0, here 2.0",
            ),
            (
                |scene| {
                    scene.lights.push(Light::Point {
                        position: DVec3::X,
                        intensity: DVec3::ONE,
                    });
                },
                "lights.0.intensity is not there, here [1.0, 1.0, 1.0]",
            ),
        ];
        for (change, expected) in cases {
            assert_eq!(changed(change).as_deref(), Some(expected));
        }
        let part = Region {
            x: 1,
            ..Region::full(10, 10)
        };
        assert_eq!(
            difference(&describe(&here), &describe_part(&here, part, &[])).as_deref(),
            Some("layers is [\"emission\"], here []")
        );
    }
}
