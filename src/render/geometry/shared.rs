//! Meshes that occur more than once: which they are, and what all their copies share.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::origin::{GeometryOrigin, MeshIdentity, ObjectShape};
use super::{ShadingNormals, SmoothNormals, StructureChoice, TrueNormals, structure_of};
use crate::accel::{Accelerator, Copies};
use crate::control::{CancelToken, Progress};
use crate::geometry::{Triangle, corner_normals};
use crate::math::{DVec3, Degrees, ScaledRotation, SceneFrame, Vec3};

/// Copies share their triangles where at least this many need not be repeated for it. Below, the flat tree costs little, its rays are
/// faster, and walls made of one square stay watertight where they meet: one flat tree is, copies side by side are not.
const WORTH_SHARING: u64 = 4096;

/// The meshes that objects share.
#[derive(Clone, Debug, Default)]
pub struct SharedMeshes {
    meshes: Vec<SharedMesh>,
    indices: HashMap<MeshIdentity, usize>,
}

/// A mesh in a frame of its own, its structure, and its normals for each way of shading asked for: flat, or smooth up to a
/// crease angle. None of that depends on where the copies are.
#[derive(Clone, Debug)]
struct SharedMesh {
    mesh: MeshIdentity,
    frame: SceneFrame,
    structure: Arc<Accelerator>,
    /// Which structure that is; `None` for a list, of triangles that are only placed.
    choice: Option<StructureChoice>,
    normals: Vec<(Option<Degrees>, Option<Arc<ShadingNormals>>)>,
}

impl SharedMeshes {
    /// The meshes that are worth sharing, each taken from `previous` or built. `None` when cancelled.
    pub fn prepare(
        origin: &GeometryOrigin,
        previous: Option<&Self>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let mut occurrences: HashMap<&MeshIdentity, u64> = HashMap::new();
        for (mesh, shape) in &origin.objects {
            let count = occurrences.entry(mesh).or_default();
            *count = count.saturating_add(shape.copies.total());
        }
        let mut shared = Self::default();
        let is_shared = |mesh: &MeshIdentity| {
            let repeated = occurrences[mesh].saturating_sub(1);
            repeated.saturating_mul(mesh.0.triangles.len() as u64) >= WORTH_SHARING
        };
        let known = |mesh: &MeshIdentity| {
            let known = previous.and_then(|previous| previous.find(mesh));
            // Any structure holds the triangles that are to be placed.
            known.filter(|known| origin.structure.is_none() || known.choice == origin.structure)
        };
        progress.set_total(triangles_to_build(origin, is_shared, known));
        for (mesh, shape) in &origin.objects {
            if !is_shared(mesh) {
                continue;
            }
            let index = if let Some(&index) = shared.indices.get(mesh) {
                index
            } else {
                shared.add(match known(mesh) {
                    Some(known) => known.clone(),
                    None => SharedMesh::build(mesh, origin.structure, cancel, progress)?,
                })
            };
            shared.meshes[index].add_normals(shape.smooth, cancel)?;
        }
        Some(shared)
    }

    /// The same meshes in structures of that choice; meshes that have such a structure keep it. `None` when cancelled.
    pub fn restructured(
        &self,
        choice: StructureChoice,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let restructured = |mesh: &SharedMesh| {
            if mesh.choice == Some(choice) {
                return Some(mesh.clone());
            }
            let triangles = mesh.structure.triangles().collect();
            let structure = super::build_structure(choice, triangles, cancel, progress)?;
            Some(SharedMesh {
                structure: Arc::new(structure),
                choice: Some(choice),
                ..mesh.clone()
            })
        };
        Some(Self {
            meshes: self
                .meshes
                .iter()
                .map(restructured)
                .collect::<Option<_>>()?,
            indices: self.indices.clone(),
        })
    }

    /// How many triangles structures of that choice are still to be built over.
    pub fn triangles_without(&self, choice: StructureChoice) -> u64 {
        let meshes = self.meshes.iter();
        let others = meshes.filter(|mesh| mesh.choice != Some(choice));
        others
            .map(|mesh| mesh.structure.triangle_count() as u64)
            .sum()
    }

    fn add(&mut self, mesh: SharedMesh) -> usize {
        let index = self.meshes.len();
        self.indices.insert(mesh.mesh.clone(), index);
        self.meshes.push(mesh);
        index
    }

    fn find(&self, mesh: &MeshIdentity) -> Option<&SharedMesh> {
        Some(&self.meshes[*self.indices.get(mesh)?])
    }

    /// The structures, in the order that [`Copies::structure`] counts.
    pub fn structures(&self) -> Vec<Arc<Accelerator>> {
        let structures = self.meshes.iter().map(|mesh| Arc::clone(&mesh.structure));
        structures.collect()
    }

    /// The frame of a shared mesh; `None` where `mesh` is not shared.
    pub fn frame_of(&self, mesh: &MeshIdentity) -> Option<&SceneFrame> {
        Some(&self.find(mesh)?.frame)
    }

    /// Where the copies of an object are in the prepared scene, and their normals; `None` where its mesh is not shared.
    pub fn place(
        &self,
        mesh: &MeshIdentity,
        shape: &ObjectShape,
        scene: &SceneFrame,
    ) -> Option<(Copies, Option<Arc<ShadingNormals>>)> {
        let index = *self.indices.get(mesh)?;
        let shared = &self.meshes[index];
        let local_origin = shared.frame.world_from_prepared(DVec3::ZERO);
        let in_world = shape.placement.world_from_object(local_origin);
        let turn = shape.placement.linear * (scene.scale() / shared.frame.scale());
        let copies = Copies {
            structure: index,
            turn: ScaledRotation::new(turn),
            translations: shape
                .copies
                .offsets()
                .map(|offset| scene.prepared_from_world(in_world + offset))
                .collect(),
        };
        let mut known = shared.normals.iter();
        let (_, normals) = known
            .find(|(smooth, _)| *smooth == shape.smooth)
            .expect("added when the meshes were prepared");
        Some((copies, normals.clone()))
    }
}

/// How many triangles structures are built over: those of new shared meshes once, and all copies of what is not shared.
fn triangles_to_build<'a>(
    origin: &GeometryOrigin,
    is_shared: impl Fn(&MeshIdentity) -> bool,
    known: impl Fn(&MeshIdentity) -> Option<&'a SharedMesh>,
) -> u64 {
    let mut new = HashSet::new();
    let counts = origin.objects.iter().map(|(mesh, shape)| {
        let count = mesh.0.triangles.len() as u64;
        if !is_shared(mesh) {
            count.saturating_mul(shape.copies.total())
        } else if known(mesh).is_none() && new.insert(mesh) {
            count
        } else {
            0
        }
    });
    counts.fold(0, u64::saturating_add)
}

impl SharedMesh {
    fn build(
        identity: &MeshIdentity,
        choice: Option<StructureChoice>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let mesh = &identity.0;
        let frame = SceneFrame::around(&mesh.bounds());
        let positions: Vec<Vec3> = mesh.positions.iter().map(|&p| frame.narrow(p)).collect();
        let triangle = |corners: &[u32; 3]| Triangle {
            corners: corners.map(|vertex| positions[vertex as usize]),
        };
        let triangles = mesh.triangles.iter().map(triangle).collect();
        let structure = structure_of(choice, triangles, cancel, progress)?;
        Some(Self {
            mesh: identity.clone(),
            frame,
            structure: Arc::new(structure),
            choice,
            normals: Vec::new(),
        })
    }

    /// Adds what is not there yet; `None` when cancelled.
    fn add_normals(&mut self, smooth: Option<Degrees>, cancel: &CancelToken) -> Option<()> {
        if self.normals.iter().any(|(known, _)| *known == smooth) {
            return Some(());
        }
        let mesh = &self.mesh.0;
        let normals = if let Some(crease) = smooth {
            let normals = corner_normals(mesh, crease, cancel)?;
            let normals = SmoothNormals::new(normals, |normal| normal, |corners| corners);
            Some(ShadingNormals::Smooth(normals))
        } else {
            let rounded: Vec<_> = self.structure.triangles().collect();
            let exact = |index| mesh.corners(index);
            let found = TrueNormals::of_copies(&rounded, rounded.len(), exact, cancel)?;
            found.map(ShadingNormals::Flat)
        };
        self.normals.push((smooth, normals.map(Arc::new)));
        Some(())
    }
}
