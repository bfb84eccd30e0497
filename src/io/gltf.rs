//! glTF 2.0 of Khronos: a scene as JSON (`.gltf`) with buffers in other files or in the text, or all in one binary file (`.glb`).
//!
//! - Each mesh becomes a part of the file for each material it has, called as the mesh, or `mesh/material` where it has several; a number
//!   follows where names repeat. Meshes without a name are `mesh 0` and so on.
//! - Each node with a mesh is an object. Nodes that share a mesh share its triangles. A transform that is no rotation, translation and
//!   even scale is worked into the vertices; such a part is called `part@node`.
//! - Materials become the nearest of the scene's four kinds: by what they emit, let through and reflect (see `materials.rs`). Images of
//!   colours and normals are files, or `image 0` and so on within the file. The colours of vertices count.
//! - Images are where `KHR_texture_transform` moves them: it is worked into the texture coordinates.
//! - Point lights of `KHR_lights_punctual` are point lights; a spot light is an invisible disk that shines where it points; a directional
//!   light is a point far away, at a multiple of the size of all objects. Candela, lux and nit are taken for W/sr, W/m² and W/m²/sr, as
//!   programs that show glTF do.
//! - The first perspective camera of the scene is the camera.
//! - What is needed and not known (`extensionsRequired`) is an error. Animations, skins, morph targets and orthographic cameras are
//!   ignored with a warning; compressed meshes (Draco, meshopt) cannot be read.
//!
//! Everything is checked before it is used: numbers in range, places within buffers, a tree of nodes. How much is read is bounded by
//! the size of the file, however often it says to read the same.
//!
//! Source: Khronos, glTF 2.0 specification, 2021.

mod accessor;
mod container;
mod document;
mod geometry;
mod image_motion;
mod images;
mod lights;
mod materials;
mod nodes;
mod uri;
mod write;

#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::merging::merge;
use super::mesh_file::Dropped;
use super::mesh_reading::{List, Malformed, Place, Watch, numbers};
use super::remarks::Remarks;
use super::shorten::shortened;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::math::DBounds;
use crate::scene::{Camera, Material, NamedLight, Object, Scene, Textures, UniqueNames};
use accessor::Data;
use document::{Document, Index};
use geometry::{MeshReader, Part};
use nodes::{Placed, placed_nodes};

use uri::Uri;

pub use images::{ImageFile, ImageName, image_number};
pub use nodes::Affine;
pub use write::{losses, write};

/// What a file held.
#[derive(Clone, Debug)]
pub struct Gltf {
    /// Its meshes by the names of parts, those of no object too.
    pub parts: BTreeMap<String, Arc<TriangleMesh>>,
    /// Its objects; the mesh of each is the name of a part, its material one of `materials`.
    pub objects: Vec<Object>,
    /// Materials that objects wear. Their images are files, named relative to this one, or `#` and the name of an image within.
    pub materials: BTreeMap<String, Material>,
    /// Its lights.
    pub lights: Vec<NamedLight>,
    /// The first camera. It looks at a point at distance 1.
    pub camera: Option<Camera>,
    /// How many nodes the scene has.
    pub nodes: u64,
    /// Faces, the dropped ones included.
    pub faces: u64,
    /// Faces that were left out.
    pub dropped: Dropped,
    /// What the file holds and the scene does not, in sentences.
    pub warnings: Vec<String>,
}

/// Extensions without which a file may say that it cannot be understood.
const KNOWN_EXTENSIONS: [&str; 11] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_variants",
];

/// Whether these are the bytes of a file of this format: a GLB, or JSON.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    container::is_binary(bytes) || text.trim_ascii_start().starts_with(b"{")
}

/// The memory, in bytes, that a file may take beside four times its own, as anything else may: what its JSON becomes.
#[must_use]
pub fn memory_of_records(bytes: &[u8]) -> u64 {
    /// Of a record, which begins with a brace: a node and where it is, in lists that double when they are full.
    const PER_RECORD: u64 = 1024;
    let json = container::take_apart(bytes).map_or(bytes, |container| container.json);
    let braces = json.split(|&byte| byte == b'{').count() - 1;
    braces as u64 * PER_RECORD
}

/// Gives the bytes of another file, by its name relative to the one that names it, or says why not; `None` when cancelled.
pub type Load<'a> = dyn FnMut(&str) -> Result<Option<Vec<u8>>, String> + 'a;

/// Reads a file from its bytes. `load` gives the bytes of other files.
///
/// `progress` advances by the bytes of this file; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// The first thing that breaks the rules of the format, or that is not known and needed.
pub fn parse(
    bytes: &[u8],
    load: &mut Load<'_>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Gltf>, Malformed> {
    let mut watch = Watch::new(cancel, progress);
    if cancel.is_cancelled() {
        return Ok(None);
    }
    let container = container::take_apart(bytes)?;
    let document = Document::parse(container.json)?;
    check_version(&document)?;
    let Some(buffers) = buffers(&document, container.binary, load)? else {
        return Ok(None);
    };
    let others = buffers.iter().map(|buffer| match buffer {
        Cow::Borrowed(_) => 0,
        Cow::Owned(bytes) => bytes.len() as u64,
    });
    let size = bytes.len() as u64 + others.sum::<u64>();
    let data = Data::new(&document, buffers, size);
    let placed = placed_nodes(&document)?;

    let mut reader = MeshReader::new(&data);
    let mut of_meshes = Vec::with_capacity(document.meshes.len());
    let mut parts = BTreeMap::new();
    for (index, mesh) in (0..).zip(&document.meshes) {
        let share = bytes.len() * index as usize / document.meshes.len();
        if watch.report(share).is_none() {
            return Ok(None);
        }
        let Some(of_mesh) = reader.parts(index, mesh, &mut watch)? else {
            return Ok(None);
        };
        parts.extend(
            of_mesh
                .iter()
                .map(|part| (part.name.clone(), Arc::clone(&part.mesh))),
        );
        of_meshes.push(of_mesh);
    }
    let mut builder = Builder {
        data: &data,
        of_meshes,
        parts,
        objects: Vec::new(),
        names: UniqueNames::default(),
        materials: Materials::new(&document),
    };
    for placed in &placed {
        if cancel.is_cancelled() {
            return Ok(None);
        }
        builder.add_node(placed, &mut reader)?;
    }
    // Cancelling comes too late here: the work is done.
    let _ = watch.report(bytes.len());
    let mut light_remarks = Remarks::of("light");
    let around = builder.bounds();
    let (lights, camera) = lights::of_nodes(&document, &placed, &around, &mut light_remarks)?;
    let mut warnings: Vec<String> = reader
        .tally
        .warnings()
        .chain(warnings(&document, &placed, &reader.notes))
        .collect();
    warnings.extend(builder.materials.remarks.sentences());
    warnings.extend(light_remarks.sentences());
    if builder.objects.is_empty() {
        warnings.push("the scene has no meshes".to_owned());
    }
    let (_, dropped) = reader.tally.counts();
    Ok(Some(Gltf {
        parts: builder.parts,
        objects: builder.objects,
        materials: builder.materials.used,
        lights,
        camera,
        nodes: placed.len() as u64,
        faces: reader.tally.faces,
        dropped,
        warnings,
    }))
}

fn check_version(document: &Document) -> Result<(), Malformed> {
    let version = document.asset.version.as_deref().unwrap_or("none");
    if !version.starts_with("2.") {
        return Err(Malformed::in_line(
            1,
            "glTF of version 2",
            format!("version {}", shortened(version)),
        ));
    }
    let unknown = document
        .extensions_required
        .iter()
        .find(|name| !KNOWN_EXTENSIONS.contains(&name.as_str()));
    match unknown {
        Some(name) => {
            let why = match name.as_str() {
                "KHR_draco_mesh_compression"
                | "EXT_meshopt_compression"
                | "KHR_meshopt_compression" => ": compressed meshes are not read",
                "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => {
                    ": images of this format are not read"
                }
                _ => "",
            };
            let found = format!("that it needs {}{why}", shortened(name));
            Err(Malformed::in_line(
                1,
                "a file that needs no extension unknown here",
                found,
            ))
        }
        None => Ok(()),
    }
}

/// The bytes of all buffers; `None` when cancelled.
fn buffers<'a>(
    document: &Document,
    binary: Option<&'a [u8]>,
    load: &mut Load<'_>,
) -> Result<Option<Vec<Cow<'a, [u8]>>>, Malformed> {
    let mut buffers = Vec::with_capacity(document.buffers.len());
    // Many buffers of one file would take the memory of many files.
    let mut loaded: HashMap<String, Index> = HashMap::new();
    for (index, buffer) in (0..).zip(&document.buffers) {
        let place = Place::Item(List::Buffers, index);
        let bytes = match (&buffer.uri, binary) {
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                let mut used = document.extensions_used.iter();
                let found = if used.any(|name| name.ends_with("_meshopt_compression")) {
                    "none, as the meshes are compressed by meshopt"
                } else {
                    "none"
                };
                return Err(Malformed::at(place, "a buffer with a uri", found));
            }
            (Some(uri), _) => match uri::read(uri)
                .map_err(|found| Malformed::at(place, "data in base64", found))?
            {
                Uri::Data(bytes) => Cow::Owned(bytes),
                Uri::File(name) => {
                    if loaded.insert(name.to_string(), index).is_some() {
                        return Err(Malformed::at(
                            place,
                            "a file of its own",
                            format!("\"{}\" again", shortened(&name)),
                        ));
                    }
                    match load(&name).map_err(|reason| {
                        Malformed::at(place, format!("the file \"{}\"", shortened(&name)), reason)
                    })? {
                        None => return Ok(None),
                        Some(bytes) => Cow::Owned(bytes),
                    }
                }
            },
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let expected = format!("{} bytes, as its byteLength says", buffer.byte_length);
            return Err(Malformed::at(place, expected, bytes.len().to_string()));
        }
        buffers.push(bytes);
    }
    Ok(Some(buffers))
}

/// The objects of the scene, made of nodes.
struct Builder<'a, 'd> {
    data: &'a Data<'d>,
    of_meshes: Vec<Vec<Part>>,
    parts: BTreeMap<String, Arc<TriangleMesh>>,
    objects: Vec<Object>,
    names: UniqueNames,
    materials: Materials<'a>,
}

impl Builder<'_, '_> {
    /// The box around all objects.
    fn bounds(&self) -> DBounds {
        let objects = self.objects.iter();
        let bounds = objects.filter_map(|object| {
            let mesh = self.parts.get(&object.mesh)?;
            Some(object.bounds_of(mesh))
        });
        bounds.fold(DBounds::EMPTY, DBounds::union)
    }

    /// Adds the objects of a node.
    fn add_node(
        &mut self,
        placed: &Placed,
        reader: &mut MeshReader<'_, '_>,
    ) -> Result<(), Malformed> {
        let node = &self.data.document.nodes[placed.node as usize];
        let Some(mesh) = node.mesh else {
            return Ok(());
        };
        let place = Place::Item(List::Nodes, placed.node);
        let parts = self.of_meshes.get(mesh as usize);
        let parts =
            parts.ok_or_else(|| accessor::beyond(List::Meshes, mesh, self.of_meshes.len()))?;
        let is_one = parts.len() == 1;
        for part in parts {
            if part.mesh.triangles.is_empty() {
                continue;
            }
            let part_of_name = part.name.rsplit_once('/').map_or("", |(_, last)| last);
            let name = match node.name.as_deref() {
                None | Some("") => part.name.clone(),
                Some(name) if is_one => name.to_owned(),
                Some(name) => format!("{name}/{part_of_name}"),
            };
            let (object, mesh) = if let Some(object) = placed.world.as_object() {
                (object, part.name.clone())
            } else {
                // Such copies count as what is read: many of one mesh would take more than the file accounts for.
                self.data
                    .spend_vertices(place, part.mesh.positions.len() as u64)?;
                let baked = placed.world.apply(&part.mesh);
                let baked =
                    baked.ok_or_else(|| Malformed::at(place, "finite coordinates", "others"))?;
                let node = node.name.clone().unwrap_or_else(|| placed.node.to_string());
                let mesh = reader.unique_name(&format!("{}@{node}", part.name));
                self.parts.insert(mesh.clone(), Arc::new(baked));
                (Object::default(), mesh)
            };
            let worn = part.material.map(|index| self.materials.worn(index));
            let material = worn.transpose()?;
            if let (Some(name), true) = (&material, part.mesh.colors.is_some()) {
                self.materials.vary_by_vertex(name);
            }
            self.objects.push(Object {
                name: self.names.unique(&name),
                mesh,
                material,
                smooth: part.mesh.normals.is_some(),
                ..object
            });
        }
        Ok(())
    }
}

/// The materials of the document as the scene has them.
struct Materials<'a> {
    document: &'a Document,
    /// The name of each material of the document that is worn.
    names: HashMap<Index, String>,
    unique: UniqueNames,
    used: BTreeMap<String, Material>,
    remarks: Remarks,
}

impl<'a> Materials<'a> {
    fn new(document: &'a Document) -> Self {
        Self {
            document,
            names: HashMap::new(),
            unique: UniqueNames::default(),
            used: BTreeMap::new(),
            remarks: Remarks::of("material"),
        }
    }

    /// The colours of vertices multiply those of the material called `name`.
    fn vary_by_vertex(&mut self, name: &str) {
        let material = self.used.get_mut(name);
        if let Some(textures) = material.and_then(Material::textures_mut) {
            textures.vertex_colors = true;
        }
    }

    /// The name of a material that is worn.
    fn worn(&mut self, index: Index) -> Result<String, Malformed> {
        if let Some(name) = self.names.get(&index) {
            return Ok(name.clone());
        }
        let all = &self.document.materials;
        let source = all
            .get(index as usize)
            .ok_or_else(|| accessor::beyond(List::Materials, index, all.len()))?;
        let name = match source.name.as_deref() {
            None | Some("") => format!("material {index}"),
            Some(name) => name.to_owned(),
        };
        let name = self.unique.unique(&name);
        let base = source.color_texture();
        let normals = source.normal_texture.as_deref();
        let moved = |texture: &document::TextureInfo| texture.transform().unwrap_or_default();
        if let (Some(base), Some(normals)) = (base, normals)
            && moved(base) != moved(normals)
        {
            let what = "has an image of normals that is moved otherwise than that of colours; both are moved alike here";
            self.remarks.add(&name, what);
        }
        let mut image = |texture: Option<&document::TextureInfo>| {
            let image = images::image_of(self.document, texture?, &name, &mut self.remarks)?;
            Some(image_name(image))
        };
        let textures = Textures {
            diffuse_image: image(base),
            normal_image: image(normals),
            vertex_colors: false,
        };
        let material = materials::to_material(source, textures, &name, &mut self.remarks);
        self.used.insert(name.clone(), material);
        self.names.insert(index, name.clone());
        Ok(name)
    }
}

/// What the name of an image within the file begins with, in the materials of a [`Gltf`]: no file is called so.
const WITHIN: &str = "#";

/// The part of a name of an image within the file.
#[must_use]
pub fn within(name: &str) -> Option<&str> {
    name.strip_prefix(WITHIN)
}

fn image_name(image: ImageName) -> String {
    match image {
        ImageName::File(name) => name,
        ImageName::Within(part) => format!("{WITHIN}{part}"),
    }
}

/// What is ignored.
fn warnings(
    document: &Document,
    placed: &[Placed],
    notes: &geometry::Notes,
) -> impl Iterator<Item = String> {
    let nodes = placed
        .iter()
        .map(|placed| &document.nodes[placed.node as usize]);
    let skinned = nodes.clone().filter(|node| node.skin.is_some()).count();
    let of = |extensions: &document::NodeExtensions| extensions.instancing.is_some();
    let instanced = nodes
        .filter(|node| node.extensions.as_deref().is_some_and(of))
        .count();
    let is_flat = |camera: &&document::Camera| camera.perspective.is_none();
    let flat = document.cameras.iter().filter(is_flat).count();
    let count = |count: usize, what: &str, rest: &str| {
        (count > 0).then(|| format!("{}{rest}", numbers(count, what)))
    };
    [
        notes.lines_and_points.counted(
            "mesh has lines or points, which are ignored",
            "meshes have lines or points, which are ignored",
        ),
        notes.without_positions.counted(
            "mesh has a primitive without positions, which is ignored",
            "meshes have primitives without positions, which are ignored",
        ),
        notes.partly_normals.counted(
            "mesh has normals in parts only; they are ignored",
            "meshes have normals in parts only; they are ignored",
        ),
        notes
            .not_finite
            .found("normals or texture coordinates that are not finite are taken as 0"),
        notes.morphed.found("morph targets are ignored"),
        count(
            document.animations.len(),
            "animation",
            " ignored: the scene is as it is at rest",
        ),
        count(skinned, "node", " bent by skins shown unbent"),
        count(flat, "orthographic camera", " ignored"),
        count(
            instanced,
            "node",
            " with instances of EXT_mesh_gpu_instancing shown once",
        ),
    ]
    .into_iter()
    .flatten()
}

impl Gltf {
    /// The triangles of all objects where they are, without their materials.
    ///
    /// # Errors
    /// That they are too many, in a plain sentence.
    pub fn whole(&self) -> Result<TriangleMesh, String> {
        let merged = merge(&self.objects, &self.parts)?;
        Ok(merged.mesh)
    }

    /// The scene that the file brings; its meshes are called as `mesh_name` calls each part.
    #[must_use]
    pub fn scene(&self, mesh_name: impl Fn(&str) -> String) -> Scene {
        let mut scene = Scene {
            objects: self.objects.clone(),
            materials: self.materials.clone(),
            ..Scene::default()
        };
        for light in &self.lights {
            scene.add_light(light.clone());
        }
        for object in &mut scene.objects {
            let mesh = mesh_name(&object.mesh);
            if let Some(part) = self.parts.get(&object.mesh) {
                scene.meshes.insert(mesh.clone(), Arc::clone(part));
            }
            object.mesh = mesh;
        }
        scene
    }
}
