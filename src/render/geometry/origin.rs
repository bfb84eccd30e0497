//! What prepared geometry is made from. As long as that is equal, a changed scene keeps its triangles and their structure.

use std::collections::HashSet;
use std::hash::{Hash, Hasher};
use std::sync::{Arc, LazyLock};

use super::StructureChoice;
use crate::geometry::TriangleMesh;
use crate::math::Degrees;
use crate::scene::{Copies, Material, Object, Placement, RenderSettings, Rgb, Scene, SceneError};

/// Everything geometry is made from, kept to tell whether a changed scene needs new geometry.
#[derive(Debug, PartialEq)]
pub struct GeometryOrigin {
    pub objects: Vec<(MeshIdentity, ObjectShape)>,
    /// `None` where triangles are only placed.
    pub structure: Option<StructureChoice>,
}

/// A mesh, equal to itself alone.
#[derive(Clone, Debug)]
pub struct MeshIdentity(pub Arc<TriangleMesh>);

impl PartialEq for MeshIdentity {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for MeshIdentity {}

impl Hash for MeshIdentity {
    fn hash<H: Hasher>(&self, state: &mut H) {
        Arc::as_ptr(&self.0).hash(state);
    }
}

/// What an object says about its shape.
#[derive(Debug, PartialEq)]
pub struct ObjectShape {
    pub placement: Placement,
    pub copies: Copies,
    pub smooth: Option<Degrees>,
}

/// The mesh of what is not there.
static NOTHING: LazyLock<Arc<TriangleMesh>> = LazyLock::new(Arc::default);

/// Whether light passes `material` as if nothing were there. No ray must know of it, or its rounding would show.
pub fn is_nothing(material: &Material, settings: &RenderSettings) -> bool {
    let clear = Material::Glass {
        ior: 1.0,
        attenuation: Rgb::ZERO,
    };
    *material == clear && settings.glass && settings.mode.shows_light()
}

impl GeometryOrigin {
    /// The triangles that are stored: those of each mesh once, however often it is placed.
    pub fn stored_triangles(&self) -> u64 {
        let mut seen = HashSet::new();
        let meshes = self.objects.iter().map(|(mesh, _)| &mesh.0);
        let once = meshes.filter(|mesh| seen.insert(Arc::as_ptr(mesh)));
        once.map(|mesh| mesh.triangles.len() as u64).sum()
    }

    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        let object_origin = |object: &Object| {
            let shape = ObjectShape {
                placement: object.placement(),
                copies: object.copies,
                smooth: object.smooth.then_some(object.crease_angle),
            };
            let mesh = if is_nothing(&scene.material_of(object)?, &scene.render) {
                Arc::clone(&NOTHING)
            } else {
                scene.shown_mesh_of(object)?
            };
            Ok((MeshIdentity(mesh), shape))
        };
        let objects = scene
            .objects
            .iter()
            .map(object_origin)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            objects,
            structure: Some(StructureChoice {
                kind: scene.render.accelerator,
                build: scene.render.accelerator_build,
            }),
        })
    }
}
