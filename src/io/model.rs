//! Files of meshes as what they bring into a scene: objects with their materials, lights and a camera where the format has them.

use std::path::Path;
use std::sync::Arc;

use super::material_library::{Definitions, load_libraries};
use super::mesh_file::{Dropped, MeshFile};
use super::mesh_parts::PartCutter;
use super::part_name::{self, with_part};
use super::remarks::Remarks;
use super::scene_paths::absolute_mesh;
use crate::control::CancelToken;
use crate::math::DBounds;
use crate::scene::presets::{self, UpAxis};
use crate::scene::{Camera, Material, Object, Scene, UniqueNames};

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
    /// Triangles, each counted once however many objects show it.
    pub triangles: u64,
    /// Faces that were left out.
    pub dropped: Dropped,
    /// The world box of all objects.
    pub bounds: DBounds,
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
        bounds: file.mesh.bounds(),
    };
    let up = file.likely_up();
    let mut scene = Scene::default();
    let definitions = if file.parts.is_empty() {
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
                    "has {parts} parts of different materials, shown as one object: only those of files called .obj can be told apart"
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
    let remarks = materials.remarks.sentences();
    warnings.extend(remarks.map(|remark| format!("{shown}: {remark}")));
    Some(Model {
        scene,
        camera: None,
        up,
        facts,
        warnings,
    })
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
