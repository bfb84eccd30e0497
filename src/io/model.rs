//! Files of meshes as what they bring into a scene: objects with their materials, lights and a camera where the format has them.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use super::gltf::{self, Gltf};
use super::material_library::{Definitions, load_libraries, path_below};
use super::mesh_file::{Dropped, MeshFile};
use super::mesh_parts::PartCutter;
use super::mesh_source::GLTF;
use super::mtl::MtlMaterial;
use super::part_name::{self, with_part};
use super::remarks::Remarks;
use super::scene_paths::absolute_mesh;
use super::shorten::shortened;
use crate::control::CancelToken;
use crate::math::DBounds;
use crate::scene::presets::{self, UpAxis};
use crate::scene::{Camera, Material, Object, Remeasure, Scene, UniqueNames};

/// Most parts that become objects of their own: more are nobody's work, and no list shows them.
const MOST_PARTS: usize = 10_000;

/// What a file brings into a scene.
#[derive(Clone, Debug)]
pub struct Model {
    /// Its objects with their meshes and materials, and its lights. The rest of the scene is as it is by default. An object without
    /// material is one of which the file says nothing.
    pub scene: Scene,
    /// Its camera, if it has one.
    pub camera: Option<Camera>,
    /// Which way is most likely up.
    pub up: UpAxis,
    /// What was found.
    pub facts: ModelFacts,
    /// What the file holds and the model does not, in sentences that begin with the file's name.
    pub warnings: Vec<String>,
}

/// What a file held, in numbers.
#[derive(Clone, Debug)]
pub struct ModelFacts {
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// Vertices.
    pub vertices: u64,
    /// Faces, the dropped ones included.
    pub faces: u64,
    /// Faces with more than three corners among them.
    pub polygons: u64,
    /// Triangles of objects, each counted once however many show it.
    pub triangles: u64,
    /// Faces that were left out.
    pub dropped: Dropped,
    /// Nodes of the scene, where the format has them.
    pub nodes: Option<u64>,
    /// The world box of all objects.
    pub bounds: DBounds,
}

impl Model {
    /// Makes everything in it `factor` times as large, as seen from the origin.
    ///
    /// `factor`: finite, more than 0.
    pub fn scale_by(&mut self, factor: f64) {
        // Angles are not rounded for nothing.
        if factor == 1.0 {
            return;
        }
        let other_unit = Remeasure {
            scale: factor,
            ..Remeasure::default()
        };
        other_unit.apply(&mut self.scene);
        if let Some(camera) = &mut self.camera {
            other_unit.camera(camera);
        }
    }
}

/// The model of the mesh file at `path` that was read: an object for each part, or one where there are no parts. Files of materials are
/// read too. `None` when cancelled.
pub fn of_mesh_file(path: &Path, file: MeshFile, cancel: &CancelToken) -> Option<Model> {
    let shown = path.display().to_string();
    let mut warnings = super::load::mesh_warnings(&shown, &file);
    let facts = ModelFacts {
        format: file.format,
        vertices: file.mesh.positions.len() as u64,
        faces: file.faces,
        polygons: file.polygons,
        triangles: file.mesh.triangles.len() as u64,
        dropped: file.dropped,
        nodes: None,
        bounds: file.mesh.bounds(),
    };
    let up = file.likely_up();
    let mut scene = Scene::default();
    let definitions = if file.parts_are_images {
        let names = file.parts.names().filter(|name| !name.is_empty());
        names.map(|name| (name.to_owned(), wearing(name))).collect()
    } else if file.parts.is_empty() {
        Definitions::new()
    } else {
        load_libraries(path, &file.libraries, &mut warnings, cancel)?
    };
    let mut materials = Materials {
        definitions,
        remarks: Remarks::of("material"),
    };

    let mesh = absolute_mesh(&path.to_string_lossy(), Path::new("."));
    let stem = path.file_stem();
    let stem = stem.map_or_else(|| mesh.clone(), |stem| stem.to_string_lossy().into_owned());
    let parts = file.parts.names().len();
    let has_names = part_name::has_parts(&mesh);
    if parts > 1 && parts <= MOST_PARTS && has_names {
        let mut cutter = PartCutter::new(&file.mesh, &file.parts);
        let mut names = UniqueNames::default();
        for part in file.parts.names() {
            if cancel.is_cancelled() {
                return None;
            }
            let name = if part.is_empty() { &stem } else { part };
            let object = Object {
                name: names.unique(name),
                mesh: with_part(&mesh, part),
                material: materials.worn_by(part, &mut scene),
                ..presets::object()
            };
            // Two names that are no UTF-8 may look the same; the first part is what they mean.
            if let (false, Some(cut)) = (scene.meshes.contains_key(&object.mesh), cutter.cut(part))
            {
                scene.meshes.insert(object.mesh.clone(), Arc::new(cut));
                scene.objects.push(object);
            }
        }
    } else {
        if parts > 1 {
            let why = if has_names {
                format!(
                    "has {parts} parts of different materials; more than {MOST_PARTS} are shown as one object"
                )
            } else {
                format!(
                    "has {parts} parts of different materials, shown as one object: only those of files called .obj or .ply can be told apart"
                )
            };
            warnings.push(format!("{shown}: {why}"));
        }
        let worn = file.parts.names().next().filter(|_| parts == 1);
        let material = worn.and_then(|part| {
            let is_defined = materials.definitions.contains_key(part);
            is_defined
                .then(|| materials.worn_by(part, &mut scene))
                .flatten()
        });
        if let (None, Some(part)) = (&material, worn.filter(|part| !part.is_empty())) {
            materials.remarks.add(part, UNDEFINED);
        }
        scene.objects.push(Object {
            name: stem,
            mesh: mesh.clone(),
            material,
            ..presets::object()
        });
        scene.meshes.insert(mesh, Arc::new(file.mesh));
    }
    show_vertex_colors(&mut scene);
    let remarks = materials.remarks.sentences();
    warnings.extend(remarks.map(|remark| format!("{shown}: {remark}")));
    warnings.extend(lost_digits_of(&scene, &shown));
    resolve_images(&mut scene, path, &mut warnings);
    Some(Model {
        scene,
        camera: None,
        up,
        facts,
        warnings,
    })
}

/// The model of a scene of meshes that was read from the file at `path`.
#[must_use]
pub fn of_gltf(path: &Path, gltf: &Gltf) -> Model {
    let file = absolute_mesh(&path.to_string_lossy(), Path::new("."));
    let shown = path.display();
    let mut scene = gltf.scene(|part| with_part(&file, part));
    let mut warnings: Vec<String> = gltf
        .warnings
        .iter()
        .map(|warning| format!("{shown}: {warning}"))
        .collect();
    if !part_name::has_parts(&file) && !scene.objects.is_empty() {
        warnings.push(format!(
            "{shown}: a saved scene will not find its parts: rename it to end in .gltf or .glb"
        ));
    }
    for object in &mut scene.objects {
        object.crease_angle = presets::object().crease_angle;
    }
    warnings.extend(lost_digits_of(&scene, &shown.to_string()));
    resolve_images(&mut scene, path, &mut warnings);
    let bounds = scene.bounds();
    // Meshes that differ in their material alone have the same vertices and faces in the file.
    let mut known = HashSet::new();
    let meshes = scene.meshes.values();
    let meshes: Vec<_> = meshes
        .filter(|mesh| known.insert(Arc::as_ptr(mesh)))
        .collect();
    let vertices = meshes.iter().map(|mesh| mesh.positions.len() as u64);
    let triangles = meshes.iter().map(|mesh| mesh.triangles.len() as u64);
    Model {
        camera: gltf.camera,
        up: UpAxis::Y,
        facts: ModelFacts {
            format: GLTF,
            vertices: vertices.sum(),
            faces: gltf.faces,
            polygons: 0,
            triangles: triangles.sum(),
            dropped: gltf.dropped,
            nodes: Some(gltf.nodes),
            bounds,
        },
        scene,
        warnings,
    }
}

/// What is to be said of the digits of the meshes of `scene`, which are those of the file called `name`.
fn lost_digits_of(scene: &Scene, name: &str) -> Option<String> {
    super::load::lost_digits_warning(name, scene.meshes.values().map(|mesh| &**mesh))
}

/// A material of an image alone.
fn wearing(image: &str) -> MtlMaterial {
    MtlMaterial {
        diffuse_image: Some(image.to_owned()),
        ..MtlMaterial::default()
    }
}

/// Colours of vertices show where a material has no image instead.
fn show_vertex_colors(scene: &mut Scene) {
    for object in &scene.objects {
        let has_colors = scene
            .meshes
            .get(&object.mesh)
            .is_some_and(|mesh| mesh.colors.is_some());
        let worn = object.material.as_ref().filter(|_| has_colors);
        let material = worn.and_then(|name| scene.materials.get_mut(name));
        if let Some(textures) = material.and_then(Material::textures_mut) {
            textures.vertex_colors = textures.diffuse_image.is_none();
        }
    }
}

/// Gives images, which are named relative to the file at `path`, the names under which a scene keeps them. Those outside of its folder
/// are left out, with a warning.
fn resolve_images(scene: &mut Scene, path: &Path, warnings: &mut Vec<String>) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = absolute_mesh(&path.to_string_lossy(), Path::new("."));
    for name in scene.texture_names() {
        let resolved = match gltf::within(&name) {
            Some(part) => Ok(with_part(&file, part)),
            None => path_below(&name, folder)
                .map(|image| absolute_mesh(&image.to_string_lossy(), Path::new("."))),
        };
        let textures = scene.material_textures_mut();
        match resolved {
            Ok(resolved) => textures.for_each(|textures| textures.rename(&name, &resolved)),
            Err(reason) => {
                textures.for_each(|textures| textures.leave_out(&name));
                warnings.push(format!(
                    "{}: the image \"{}\" {reason}",
                    path.display(),
                    shortened(&name)
                ));
            }
        }
    }
}

/// What is said of a material that no file of materials has.
const UNDEFINED: &str = "is not defined in any file of materials that was read; it is grey";

/// The materials that parts name.
struct Materials {
    definitions: Definitions,
    remarks: Remarks,
}

impl Materials {
    /// The name of the material of the part called so, which `scene` has then; `None` for faces without material.
    fn worn_by(&mut self, part: &str, scene: &mut Scene) -> Option<String> {
        if part.is_empty() {
            return None;
        }
        let material = if let Some(definition) = self.definitions.get(part) {
            definition.to_material(part, &mut self.remarks)
        } else {
            self.remarks.add(part, UNDEFINED);
            Material::default()
        };
        scene.materials.insert(part.to_owned(), material);
        Some(part.to_owned())
    }
}
