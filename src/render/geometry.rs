//! The triangles of a scene as rendering reads them: placed, narrowed, in a structure. What occurs once is in one flat
//! structure; a mesh that occurs often is there once, in a frame of its own, and its copies are places.

mod origin;
mod shading;
mod shared;
mod sketch;

use std::ops::Range;
use std::sync::Arc;

use super::memory::require_structure;
use crate::accel::{
    Accelerator, Assembly, BruteForce, BuildQuality, KdParameters, KdTree, Part, PlacedTriangle,
    WideTree,
};
use crate::control::{CancelToken, Progress};
use crate::geometry::{Triangle, TriangleMesh, corner_normals};
use crate::math::{DVec3, SceneFrame, Vec3};
use crate::scene::{AcceleratorBuild, AcceleratorChoice, Placement, Scene, SceneError};
pub(crate) use origin::is_nothing;
use origin::{GeometryOrigin, ObjectShape};
pub use shading::ShadingNormals;
use shading::{SmoothNormals, TrueNormals};
use shared::SharedMeshes;
pub use sketch::SketchStore;

/// The scene's triangles, placed, narrowed and in an acceleration structure. It depends on the objects and their meshes
/// alone: moving the camera or editing a light or a material needs no new one.
#[derive(Debug)]
pub struct PreparedGeometry {
    frame: SceneFrame,
    accelerator: Assembly,
    objects: Vec<PreparedObject>,
    shared: SharedMeshes,
    origin: GeometryOrigin,
}

/// One object of the description among the prepared triangles.
#[derive(Clone, Debug)]
pub struct PreparedObject {
    /// Its triangles, copy after copy.
    pub triangles: Range<u32>,
    /// Triangles of one copy.
    pub triangles_per_copy: u32,
    /// Shading normals, shared by the copies; `None` where all triangles are shaded by their own. In world orientation, or
    /// that of the mesh where the object shares it.
    pub normals: Option<Arc<ShadingNormals>>,
}

impl PreparedGeometry {
    /// Places and narrows the scene's triangles and builds their acceleration structure; gives back `previous` where it was
    /// made from the same objects, keeps its triangles and normals where only the structure is another, and its shared meshes where
    /// objects only moved. `None` when cancelled. `progress` counts the triangles that structures are built over.
    ///
    /// # Errors
    /// A mesh that is not loaded, or more triangles than can be numbered.
    pub fn prepare(
        scene: &Scene,
        previous: Option<&Arc<Self>>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Arc<Self>>, SceneError> {
        let origin = GeometryOrigin::of(scene)?;
        if let Some(previous) = previous.filter(|previous| previous.origin == origin) {
            return Ok(Some(Arc::clone(previous)));
        }
        require_structure(origin.stored_triangles())?;
        let placed = previous.filter(|previous| previous.origin.objects == origin.objects);
        if let (Some(placed), Some(choice)) = (placed, origin.structure) {
            let prepared = placed.restructured(origin, choice, cancel, progress);
            return Ok(prepared.map(Arc::new));
        }
        Self::new(scene, origin, previous, cancel, progress)
    }

    /// The scene's triangles and normals without an acceleration structure: all that is needed to draw them. It answers rays, but by trying
    /// all triangles that are in no structure of `previous`. [`Self::prepare`] goes on from it. It is `previous` itself where the objects
    /// are the same. `None` when cancelled.
    ///
    /// # Errors
    /// A mesh that is not loaded, or more triangles than can be numbered.
    pub fn place(
        scene: &Scene,
        previous: Option<&Arc<Self>>,
        cancel: &CancelToken,
    ) -> Result<Option<Arc<Self>>, SceneError> {
        let origin = GeometryOrigin {
            structure: None,
            ..GeometryOrigin::of(scene)?
        };
        if let Some(previous) =
            previous.filter(|previous| previous.origin.objects == origin.objects)
        {
            return Ok(Some(Arc::clone(previous)));
        }
        Self::new(scene, origin, previous, cancel, &Progress::new())
    }

    fn new(
        scene: &Scene,
        origin: GeometryOrigin,
        previous: Option<&Arc<Self>>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<Arc<Self>>, SceneError> {
        let count = scene.triangle_count();
        if count > u64::from(u32::MAX / 2) {
            return Err(SceneError::TooManyTriangles { count });
        }
        let frame = SceneFrame::around(&scene.measured_bounds()?);
        let previous = previous.map(|previous| &previous.shared);
        let Some(shared) = SharedMeshes::prepare(&origin, previous, cancel, progress) else {
            return Ok(None);
        };
        Ok(Self::assemble(origin, frame, shared, cancel, progress).map(Arc::new))
    }

    /// The same triangles and normals in structures of the given choice.
    fn restructured(
        &self,
        origin: GeometryOrigin,
        choice: StructureChoice,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let triangles: Vec<_> = self.accelerator.flat().triangles().collect();
        progress.set_total(triangles.len() as u64 + self.shared.triangles_without(choice));
        let shared = self.shared.restructured(choice, cancel, progress)?;
        let flat = build_structure(choice, triangles, cancel, progress)?;
        Some(Self {
            frame: self.frame,
            accelerator: self.accelerator.with_structures(flat, shared.structures()),
            objects: self.objects.clone(),
            shared,
            origin,
        })
    }

    fn assemble(
        origin: GeometryOrigin,
        frame: SceneFrame,
        shared: SharedMeshes,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let mut triangles = Vec::new();
        let mut parts = Vec::with_capacity(origin.objects.len());
        let mut objects = Vec::with_capacity(origin.objects.len());
        let mut start = 0;
        for (identity, shape) in &origin.objects {
            let mesh = &identity.0;
            let triangles_per_copy = id(mesh.triangles.len());
            let placed = shared.place(identity, shape, &frame);
            let (part, count, normals) = if let Some((copies, normals)) = placed {
                let count = triangles_per_copy * id(copies.translations.len());
                (Part::Copies(copies), count, normals)
            } else {
                let before = triangles.len();
                place_triangles(mesh, shape, &frame, &mut triangles, cancel)?;
                let placed = &triangles[before..];
                let normals = place_normals(mesh, shape, placed, cancel)?;
                let count = id(placed.len());
                (Part::Flat(count), count, normals.map(Arc::new))
            };
            parts.push(part);
            objects.push(PreparedObject {
                triangles: start..start + count,
                triangles_per_copy,
                normals,
            });
            start += count;
        }
        let flat = structure_of(origin.structure, triangles, cancel, progress)?;
        Some(Self {
            frame,
            accelerator: Assembly::new(flat, shared.structures(), parts),
            objects,
            shared,
            origin,
        })
    }

    /// Between the world and the prepared triangles.
    #[must_use]
    pub fn frame(&self) -> &SceneFrame {
        &self.frame
    }

    /// The frame in which the corners of object number `object` are rounded, where copies share its mesh: one around the mesh in
    /// its own coordinates. `None` where they are placed and then rounded in [`Self::frame`].
    ///
    /// # Panics
    /// When there is no such object.
    #[must_use]
    pub fn shared_frame(&self, object: usize) -> Option<&SceneFrame> {
        self.shared.frame_of(&self.origin.objects[object].0)
    }

    /// What finds hits.
    #[must_use]
    pub fn accelerator(&self) -> &Assembly {
        &self.accelerator
    }

    /// The prepared triangle with number `id`: its corners in the prepared scene, its points, its normal.
    #[must_use]
    #[inline]
    pub fn triangle(&self, id: u32) -> PlacedTriangle<'_> {
        self.accelerator.triangle(id)
    }

    /// The objects in the order of the description.
    #[must_use]
    pub fn objects(&self) -> &[PreparedObject] {
        &self.objects
    }

    /// The index of the object that `triangle` belongs to.
    #[must_use]
    pub fn object_of(&self, triangle: u32) -> usize {
        self.accelerator.part_of(triangle)
    }

    /// Memory of all shading normals, in bytes; 0 where all triangles are flat.
    #[must_use]
    pub fn normal_bytes(&self) -> usize {
        let normals = self
            .objects
            .iter()
            .filter_map(|object| object.normals.as_ref());
        normals.map(|normals| normals.bytes()).sum()
    }

    /// The shading normals of the corners of `triangle` in world orientation, in the order of its corners; `None` where it is
    /// shaded by its own.
    #[must_use]
    #[inline]
    pub fn corner_normals(&self, triangle: &PlacedTriangle<'_>) -> Option<[Vec3; 3]> {
        let object = &self.objects[triangle.part];
        let normals = object.normals.as_ref()?;
        let in_copy = triangle.number % object.triangles_per_copy;
        Some(triangle.directions_in_scene(normals.of_corners(in_copy)?))
    }
}

/// Which structure is built, and how carefully.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureChoice {
    /// Which structure.
    pub kind: AcceleratorChoice,
    /// How the wide tree is built.
    pub build: AcceleratorBuild,
}

/// The structure of that choice over `triangles`; `None` when cancelled. `progress` advances by their number altogether.
///
/// # Panics
/// When there are more triangles than the structure can number.
#[must_use]
pub fn build_structure(
    structure: StructureChoice,
    triangles: Vec<Triangle>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Option<Accelerator> {
    let quality = match structure.build {
        AcceleratorBuild::Best => BuildQuality::Best,
        AcceleratorBuild::Fast => BuildQuality::Fast,
    };
    match structure.kind {
        AcceleratorChoice::Auto | AcceleratorChoice::Wide => {
            let tree = WideTree::build(&triangles, quality, cancel, progress)?;
            Some(Accelerator::Wide(tree))
        }
        AcceleratorChoice::KdTree => {
            let parameters = KdParameters::default();
            let tree = KdTree::build_watched(&triangles, &parameters, cancel, progress)?;
            Some(Accelerator::KdTree(tree))
        }
        AcceleratorChoice::BruteForce => {
            progress.advance(triangles.len() as u64);
            Some(Accelerator::BruteForce(BruteForce::new(triangles)))
        }
    }
}

/// [`build_structure`], or a list of the triangles where no structure is chosen.
fn structure_of(
    choice: Option<StructureChoice>,
    triangles: Vec<Triangle>,
    cancel: &CancelToken,
    progress: &Progress,
) -> Option<Accelerator> {
    match choice {
        Some(choice) => build_structure(choice, triangles, cancel, progress),
        None => Some(Accelerator::BruteForce(BruteForce::new(triangles))),
    }
}

/// Triangles between two looks at the cancel token.
const CHUNK: usize = 1 << 16;

/// Appends all copies of a mesh; `None` when cancelled.
fn place_triangles(
    mesh: &TriangleMesh,
    shape: &ObjectShape,
    frame: &SceneFrame,
    triangles: &mut Vec<Triangle>,
    cancel: &CancelToken,
) -> Option<()> {
    // However many copies there are of nothing.
    if mesh.triangles.is_empty() {
        return Some(());
    }
    let in_world: Vec<_> = mesh
        .positions
        .iter()
        .map(|&p| shape.placement.world_from_object(p))
        .collect();
    for offset in shape.copies.offsets() {
        let prepared: Vec<Vec3> = in_world.iter().map(|&p| frame.narrow(p + offset)).collect();
        for placed in mesh.triangles.chunks(CHUNK) {
            if cancel.is_cancelled() {
                return None;
            }
            triangles.extend(placed.iter().map(|&corners| {
                let corners = outward_order(corners, &shape.placement)
                    .map(|vertex| prepared[vertex as usize]);
                Triangle { corners }
            }));
        }
    }
    Some(())
}

/// The shading normals of all copies of a mesh, which are the triangles `placed`; none where they are those of the triangles. `None`
/// when cancelled.
#[expect(
    clippy::option_option,
    reason = "there may be none, and it may be cancelled"
)]
fn place_normals(
    mesh: &TriangleMesh,
    shape: &ObjectShape,
    placed: &[Triangle],
    cancel: &CancelToken,
) -> Option<Option<ShadingNormals>> {
    let placement = &shape.placement;
    if let Some(crease) = shape.smooth {
        let turned = |normal: DVec3| (placement.linear * normal).normalize_or_zero();
        let ordered = |corners| outward_order(corners, placement);
        let normals = corner_normals(mesh, crease, cancel)?;
        let normals = SmoothNormals::new(normals, turned, ordered);
        return Some(Some(ShadingNormals::Smooth(normals)));
    }
    let exact = |index: usize| {
        outward_order(mesh.corners(index), placement)
            .map(|corner| placement.world_from_object(corner))
    };
    let normals = TrueNormals::of_copies(placed, mesh.triangles.len(), exact, cancel)?;
    Some(normals.map(ShadingNormals::Flat))
}

/// A placement that mirrors turns triangles inside out; swapping two corners turns them back.
fn outward_order<T: Copy>(corners: [T; 3], placement: &Placement) -> [T; 3] {
    let [a, b, c] = corners;
    if placement.linear.determinant() < 0.0 {
        [a, c, b]
    } else {
        [a, b, c]
    }
}

fn id(index: usize) -> u32 {
    u32::try_from(index).expect("the number of triangles is checked first")
}
