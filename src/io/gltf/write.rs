//! Scenes as GLB.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::materials::roughness_of;
use crate::geometry::TriangleMesh;
use crate::io::mesh_writing::fit_f32;
use crate::io::part_name;
use crate::math::{DMat3, DVec2, DVec3, Vec3};
use crate::scene::{Camera, Light, Material, Object, Rgb, Scene};

/// What surfaces reflect at right angles where a file says nothing.
const PLASTIC: f64 = 0.04;
/// Codes of the format.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes the objects of a scene with their meshes and materials, its lights, and `camera` if there is one, as a GLB.
///
/// Objects that share a mesh and a material share it in the file. Reading it gives the same scene, as far as the format holds it: see
/// [`losses`]. Of grids of copies, the first is written.
///
/// # Errors
/// What `out` returns; and that the scene is too large for the format.
pub fn write(scene: &Scene, camera: Option<&Camera>, out: &mut dyn Write) -> io::Result<()> {
    let mut writer = Writer::default();
    let materials: BTreeMap<&str, usize> = scene
        .materials
        .keys()
        .map(String::as_str)
        .zip(0..)
        .collect();
    let mut meshes: BTreeMap<(&str, Option<usize>), usize> = BTreeMap::new();
    let mut nodes = Vec::new();
    for object in &scene.objects {
        let Some(mesh) = scene.meshes.get(&object.mesh) else {
            continue;
        };
        let material = object
            .material
            .as_deref()
            .and_then(|name| materials.get(name).copied());
        let number = *meshes
            .entry((&object.mesh, material))
            .or_insert(writer.meshes.len());
        if number == writer.meshes.len() {
            writer.add_mesh(part_name::short_name(&object.mesh), mesh, material);
        }
        nodes.push(node_of(object, number));
    }
    if let Some(what) = scene.meshes.values().find_map(|mesh| beyond_f32(mesh)) {
        let message = format!("{what} beyond 3.4e38, the largest number of glTF");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    let mut lights = Vec::new();
    for light in &scene.lights {
        let name = scene.light_label(lights.len());
        let (record, node) = light_of(light, &name, lights.len());
        lights.push(record);
        nodes.push(node);
    }
    nodes.extend(camera.map(camera_node));

    let mut used = BTreeSet::new();
    let written: Vec<Value> = scene
        .materials
        .iter()
        .map(|(name, material)| material_of(name, material, &mut used))
        .collect();
    if !lights.is_empty() {
        used.insert("KHR_lights_punctual");
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "RayMini" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
    });
    let mut put = |key: &str, values: Vec<Value>| {
        // Empty lists are not allowed.
        if !values.is_empty() {
            document[key] = Value::Array(values);
        }
    };
    put("nodes", nodes);
    put("meshes", writer.meshes);
    put("materials", written);
    put("accessors", writer.accessors);
    put("bufferViews", writer.views);
    put(
        "extensionsUsed",
        used.into_iter().map(Value::from).collect(),
    );
    if let Some(camera) = camera {
        let yfov = camera.vertical_fov.radians();
        put(
            "cameras",
            vec![json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.01 } })],
        );
    }
    if !writer.binary.is_empty() {
        put(
            "buffers",
            vec![json!({ "byteLength": writer.binary.len() })],
        );
    }
    if !lights.is_empty() {
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    }
    write_container(&document, writer.binary, out)
}

/// What of a scene [`write()`] leaves out or rounds, in sentences.
#[must_use]
pub fn losses(scene: &Scene) -> Vec<String> {
    let is_rounded = |mesh: &Arc<TriangleMesh>| !fit_f32(&mesh.positions);
    let rounded = scene.meshes.values().any(is_rounded);
    let has_images = !scene.texture_names().is_empty();
    let disks = scene.lights.iter().filter(|light| light.has_area()).count();
    [
        rounded.then_some("positions are rounded to 32 bits, as glTF holds them"),
        has_images.then_some("images of materials are left out"),
        (disks > 0).then_some("disk lights are written as spot lights"),
    ]
    .into_iter()
    .flatten()
    .map(str::to_owned)
    .collect()
}

/// What of a mesh 32 bits do not reach, if anything.
fn beyond_f32(mesh: &TriangleMesh) -> Option<&'static str> {
    let coordinates = mesh.texture_coordinates.iter().flatten();
    if !mesh.positions.iter().all(|p| p.as_vec3().is_finite()) {
        Some("it has coordinates")
    } else if !coordinates.into_iter().all(|uv| uv.as_vec2().is_finite()) {
        Some("it has texture coordinates")
    } else {
        None
    }
}

/// The lists of the document that meshes make, and the data behind them.
#[derive(Default)]
struct Writer {
    meshes: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    binary: Vec<u8>,
    /// The attributes and indices of meshes that are written, by their address.
    known: BTreeMap<usize, (Value, usize)>,
}

impl Writer {
    fn add_mesh(&mut self, name: &str, mesh: &Arc<TriangleMesh>, material: Option<usize>) {
        let address = Arc::as_ptr(mesh).addr();
        let (attributes, indices) = if let Some(known) = self.known.get(&address) {
            known.clone()
        } else {
            let added = self.add_geometry(mesh);
            self.known.insert(address, added.clone());
            added
        };
        let mut primitive = json!({ "attributes": attributes, "indices": indices });
        if let Some(material) = material {
            primitive["material"] = material.into();
        }
        self.meshes
            .push(json!({ "name": name, "primitives": [primitive] }));
    }

    fn add_geometry(&mut self, mesh: &TriangleMesh) -> (Value, usize) {
        let mut attributes = Map::new();
        let positions = mesh
            .positions
            .iter()
            .map(|position| position.as_vec3().to_array());
        let bounds = positions
            .clone()
            .fold(None, |bounds: Option<[[f32; 3]; 2]>, position| {
                let [min, max] = bounds.unwrap_or([position; 2]);
                Some([
                    std::array::from_fn(|axis| min[axis].min(position[axis])),
                    std::array::from_fn(|axis| max[axis].max(position[axis])),
                ])
            });
        let position = self.add_floats(positions, "VEC3");
        if let Some([min, max]) = bounds {
            self.accessors[position]["min"] = json!(min);
            self.accessors[position]["max"] = json!(max);
        }
        attributes.insert("POSITION".into(), position.into());
        if let Some(normals) = &mesh.normals {
            let accessor = self.add_floats(normals.iter().map(|&normal| unit(normal)), "VEC3");
            attributes.insert("NORMAL".into(), accessor.into());
        }
        if let Some(textures) = &mesh.texture_coordinates {
            // Images begin at their top there, and at their bottom here.
            let flipped = textures
                .iter()
                .map(|&DVec2 { x, y }| DVec2::new(x, 1.0 - y));
            let flipped = flipped.map(|coordinate| coordinate.as_vec2().to_array());
            let accessor = self.add_floats(flipped, "VEC2");
            attributes.insert("TEXCOORD_0".into(), accessor.into());
        }
        if let Some(colors) = &mesh.colors {
            let accessor = self.add_floats(colors.iter().map(Vec3::to_array), "VEC3");
            attributes.insert("COLOR_0".into(), accessor.into());
        }
        let indices = mesh
            .triangles
            .as_flattened()
            .iter()
            .map(|index| index.to_le_bytes());
        let indices = self.add(indices, UNSIGNED_INT, "SCALAR", 1);
        (Value::Object(attributes), indices)
    }

    fn add_floats<const N: usize>(
        &mut self,
        elements: impl Iterator<Item = [f32; N]>,
        kind: &str,
    ) -> usize {
        self.add(elements.flatten().map(f32::to_le_bytes), FLOAT, kind, N)
    }

    /// Adds numbers of four bytes each, and returns the number of their accessor, which has `width` numbers per element.
    fn add(
        &mut self,
        numbers: impl Iterator<Item = [u8; 4]>,
        component: u32,
        kind: &str,
        width: usize,
    ) -> usize {
        let start = self.binary.len();
        self.binary.extend(numbers.flatten());
        let length = self.binary.len() - start;
        self.views
            .push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": component,
            "count": length / (4 * width),
            "type": kind,
        }));
        self.accessors.len() - 1
    }
}

/// A normal as the format wants it: of length 1, as far as 32 bits go. One that is so already stays.
fn unit(normal: DVec3) -> [f32; 3] {
    const TOLERANCE: f64 = 1e-6;
    let is_unit = (normal.length_squared() - 1.0).abs() < TOLERANCE;
    let unit = if is_unit {
        normal
    } else {
        normal.normalize_or_zero()
    };
    unit.as_vec3().to_array()
}

fn node_of(object: &Object, mesh: usize) -> Value {
    let mut node = json!({ "name": object.name, "mesh": mesh });
    if object.translate != DVec3::ZERO {
        node["translation"] = json!(object.translate.to_array());
    }
    if object.rotate != DVec3::ZERO {
        let unscaled = Object {
            rotate: object.rotate,
            ..Object::default()
        };
        node["rotation"] = json!(quaternion(&unscaled.placement().linear));
    }
    if object.scale != 1.0 {
        node["scale"] = json!(DVec3::splat(object.scale).to_array());
    }
    node
}

/// The quaternion X, Y, Z, W of a rotation. Source: Shepperd 1978, Quaternion from Rotation Matrix.
fn quaternion(rotation: &DMat3) -> [f64; 4] {
    let [x, y, z] = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
    // Four times the square of each.
    let squares = [
        1.0 + x.x - y.y - z.z,
        1.0 - x.x + y.y - z.z,
        1.0 - x.x - y.y + z.z,
        1.0 + x.x + y.y + z.z,
    ];
    let largest = (0..4).fold(
        0,
        |best, i| if squares[i] > squares[best] { i } else { best },
    );
    let s = 0.5 / squares[largest].sqrt();
    let value = 0.5 * squares[largest].sqrt();
    let [a, b, c] = [y.z - z.y, z.x - x.z, x.y - y.x].map(|difference| difference * s);
    let [xy, yz, zx] = [x.y + y.x, y.z + z.y, z.x + x.z].map(|sum| sum * s);
    match largest {
        0 => [value, xy, zx, a],
        1 => [xy, value, yz, b],
        2 => [zx, yz, value, c],
        _ => [a, b, c, value],
    }
}

/// The largest channel, at least a little, and the colour over it.
fn strength_and_color(color: Rgb) -> (f64, [f64; 3]) {
    let strength = color.max_element();
    if strength > 0.0 {
        (strength, (color / strength).to_array())
    } else {
        (0.0, [1.0; 3])
    }
}

fn light_of(light: &Light, name: &str, index: usize) -> (Value, Value) {
    let (kind, intensity) = match light {
        Light::Point { intensity, .. } => ("point", *intensity),
        Light::Disk {
            radius, radiance, ..
        } => ("spot", *radiance * (std::f64::consts::PI * radius * radius)),
    };
    let (strength, color) = strength_and_color(intensity);
    let mut record = json!({ "type": kind, "color": color, "intensity": strength });
    let position = light.position();
    let mut node = json!({
        "name": name,
        "translation": position.to_array(),
        "extensions": { "KHR_lights_punctual": { "light": index } },
    });
    if let Light::Disk { facing, .. } = light {
        record["spot"] = json!({});
        if let Some(normal) = facing.normal(position) {
            let across = normal.any_orthonormal_vector();
            node["rotation"] = json!(quaternion(&DMat3::from_cols(
                across,
                across.cross(normal),
                -normal
            )));
        }
    }
    (record, node)
}

fn camera_node(camera: &Camera) -> Value {
    let mut node = json!({ "name": "camera", "camera": 0, "translation": camera.eye.to_array() });
    if let Some(axes) = camera.axes() {
        node["rotation"] = json!(quaternion(&DMat3::from_cols(
            axes.right,
            axes.up,
            -axes.forward
        )));
    }
    node
}

/// A material from which [`super::materials::to_material`] makes the same one, and the extensions it uses.
fn material_of(name: &str, material: &Material, used: &mut BTreeSet<&'static str>) -> Value {
    let surface = |base: Rgb, metal: f64, roughness: f64| {
        let [r, g, b] = base.min(Rgb::ONE).to_array();
        json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": metal, "roughnessFactor": roughness })
    };
    let mut extensions = Map::new();
    let mut extend = |name: &'static str, value: Value| {
        used.insert(name);
        extensions.insert(name.to_owned(), value);
    };
    let mut record = json!({ "name": name, "doubleSided": true });
    record["pbrMetallicRoughness"] = match material {
        Material::Phong {
            diffuse,
            specular,
            shininess,
            ..
        } => {
            extend(
                "KHR_materials_specular",
                json!({ "specularColorFactor": (*specular / PLASTIC).to_array() }),
            );
            // What is reflected at right angles does not go in.
            let share = 1.0 - specular.max_element().min(1.0);
            let base = if share > 0.0 {
                *diffuse / share
            } else {
                Rgb::ZERO
            };
            surface(base, 0.0, roughness_of(*shininess))
        }
        Material::Mirror { reflectance } => surface(*reflectance, 1.0, 0.0),
        Material::Glass { ior, attenuation } => {
            extend(
                "KHR_materials_transmission",
                json!({ "transmissionFactor": 1.0 }),
            );
            extend("KHR_materials_ior", json!({ "ior": ior }));
            let most = attenuation.max_element();
            if most > 0.0 {
                let color = (*attenuation / most).map(|fading| libm::exp(-fading));
                extend(
                    "KHR_materials_volume",
                    json!({ "thicknessFactor": 1.0, "attenuationDistance": 1.0 / most, "attenuationColor": color.to_array() }),
                );
            }
            surface(Rgb::ONE, 0.0, 0.0)
        }
        Material::Emitter { radiance } => {
            let (strength, color) = strength_and_color(*radiance);
            record["emissiveFactor"] = json!(color);
            extend(
                "KHR_materials_emissive_strength",
                json!({ "emissiveStrength": strength }),
            );
            surface(Rgb::ZERO, 0.0, 1.0)
        }
    };
    if !extensions.is_empty() {
        record["extensions"] = Value::Object(extensions);
    }
    record
}

/// The two chunks behind their header, each filled up to whole words.
fn write_container(document: &Value, mut binary: Vec<u8>, out: &mut dyn Write) -> io::Result<()> {
    let mut text = serde_json::to_vec(document)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let of_binary = if binary.is_empty() {
        0
    } else {
        8 + binary.len()
    };
    let total = u32::try_from(12 + 8 + text.len() + of_binary).map_err(|_| {
        io::Error::new(
            io::ErrorKind::FileTooLarge,
            "the scene is too large for GLB, which ends at 4 GiB",
        )
    })?;
    // Each is less than the total.
    let length = |bytes: &[u8]| u32::try_from(bytes.len()).unwrap_or(total).to_le_bytes();
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&length(&text))?;
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    if of_binary > 0 {
        out.write_all(&length(&binary))?;
        out.write_all(b"BIN\0")?;
        out.write_all(&binary)?;
    }
    Ok(())
}
