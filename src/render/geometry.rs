use std::ops::Range;
use std::sync::Arc;

use crate::accel::{Accelerator, BruteForce, KdParameters, KdTree};
use crate::control::CancelToken;
use crate::geometry::{Triangle, TriangleMesh, corner_normals};
use crate::math::{Degrees, SceneFrame, Vec3};
use crate::scene::{AcceleratorChoice, Object, Placement, Scene, SceneError};

/// The scene's triangles, placed, narrowed and in an acceleration structure. It depends on the objects and their meshes
/// alone: moving the camera or editing a light or a material needs no new one.
#[derive(Debug)]
pub struct PreparedGeometry {
    frame: SceneFrame,
    accelerator: Accelerator,
    objects: Vec<PreparedObject>,
    origin: GeometryOrigin,
}

/// One object of the description among the prepared triangles.
#[derive(Debug)]
pub struct PreparedObject {
    /// Its triangles, copy after copy.
    pub triangles: Range<u32>,
    /// Triangles of one copy.
    pub triangles_per_copy: u32,
    /// Shading normals, shared by the copies; `None` for flat shading.
    pub normals: Option<ObjectNormals>,
}

/// Shading normals of one object, in world orientation.
#[derive(Debug)]
pub struct ObjectNormals {
    /// Unit vectors.
    pub normals: Vec<Vec3>,
    /// Indices into `normals` for the three corners of each triangle of one copy.
    pub corners: Vec<[u32; 3]>,
}

/// Everything geometry is made from, kept to tell whether a changed scene needs new geometry.
#[derive(Debug, PartialEq)]
struct GeometryOrigin {
    objects: Vec<(MeshIdentity, ObjectShape)>,
    structure: AcceleratorChoice,
}

/// A mesh, equal to itself alone.
#[derive(Debug)]
struct MeshIdentity(Arc<TriangleMesh>);

impl PartialEq for MeshIdentity {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// What an object says about its shape.
#[derive(Debug, PartialEq)]
struct ObjectShape {
    placement: Placement,
    copies: crate::scene::Copies,
    smooth: Option<Degrees>,
}

impl GeometryOrigin {
    fn of(scene: &Scene) -> Result<Self, SceneError> {
        let object_origin = |object: &Object| {
            let shape = ObjectShape {
                placement: object.placement(),
                copies: object.copies,
                smooth: object.smooth.then_some(object.crease_angle),
            };
            Ok((MeshIdentity(Arc::clone(scene.mesh_of(object)?)), shape))
        };
        let objects = scene
            .objects
            .iter()
            .map(object_origin)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            objects,
            structure: scene.render.accelerator,
        })
    }
}

impl PreparedGeometry {
    /// Places and narrows the scene's triangles and builds their acceleration structure; gives back `previous` where it was
    /// made from the same objects. `None` when cancelled.
    ///
    /// # Errors
    /// A mesh that is not loaded, or more triangles than can be numbered.
    pub fn prepare(
        scene: &Scene,
        previous: Option<&Arc<Self>>,
        cancel: &CancelToken,
    ) -> Result<Option<Arc<Self>>, SceneError> {
        let origin = GeometryOrigin::of(scene)?;
        if let Some(previous) = previous.filter(|previous| previous.origin == origin) {
            return Ok(Some(Arc::clone(previous)));
        }
        let count = scene.triangle_count();
        if count > u64::from(u32::MAX / 2) {
            return Err(SceneError::TooManyTriangles { count });
        }

        let bounds = scene.measured_bounds()?;
        let frame = SceneFrame::around(&bounds);
        let mut triangles = Vec::new();
        let mut objects = Vec::with_capacity(origin.objects.len());
        for (MeshIdentity(mesh), shape) in &origin.objects {
            let start = triangles.len();
            if !place_triangles(mesh, shape, &frame, &mut triangles, cancel) {
                return Ok(None);
            }
            objects.push(PreparedObject {
                triangles: id(start)..id(triangles.len()),
                triangles_per_copy: id(mesh.triangles.len()),
                normals: shape
                    .smooth
                    .map(|crease| place_normals(mesh, shape, crease)),
            });
        }

        let accelerator = match scene.render.accelerator {
            AcceleratorChoice::BruteForce => Accelerator::BruteForce(BruteForce::new(triangles)),
            AcceleratorChoice::Auto | AcceleratorChoice::KdTree => {
                match KdTree::build(triangles, &KdParameters::default(), cancel) {
                    Some(tree) => Accelerator::KdTree(tree),
                    None => return Ok(None),
                }
            }
        };
        Ok(Some(Arc::new(Self {
            frame,
            accelerator,
            objects,
            origin,
        })))
    }

    /// Between the world and the prepared triangles.
    #[must_use]
    pub fn frame(&self) -> &SceneFrame {
        &self.frame
    }

    /// The structure that finds hits.
    #[must_use]
    pub fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// The prepared triangles, object after object.
    #[must_use]
    pub fn triangles(&self) -> &[Triangle] {
        self.accelerator.triangles()
    }

    /// The objects in the order of the description.
    #[must_use]
    pub fn objects(&self) -> &[PreparedObject] {
        &self.objects
    }

    /// The index of the object that `triangle` belongs to.
    #[must_use]
    pub fn object_of(&self, triangle: u32) -> usize {
        self.objects
            .partition_point(|object| object.triangles.end <= triangle)
    }
}

impl PreparedObject {
    /// The shading normals of the corners of `triangle`, a number in its range; `None` for flat shading.
    #[must_use]
    pub fn normal_corners(&self, triangle: u32) -> Option<[Vec3; 3]> {
        let normals = self.normals.as_ref()?;
        let in_copy = (triangle - self.triangles.start) % self.triangles_per_copy;
        Some(normals.corners[in_copy as usize].map(|index| normals.normals[index as usize]))
    }
}

/// Appends all copies of a mesh; false when cancelled.
fn place_triangles(
    mesh: &TriangleMesh,
    shape: &ObjectShape,
    frame: &SceneFrame,
    triangles: &mut Vec<Triangle>,
    cancel: &CancelToken,
) -> bool {
    let in_world: Vec<_> = mesh
        .positions
        .iter()
        .map(|&p| shape.placement.world_from_object(p))
        .collect();
    for offset in shape.copies.offsets() {
        if cancel.is_cancelled() {
            return false;
        }
        let prepared: Vec<Vec3> = in_world.iter().map(|&p| frame.narrow(p + offset)).collect();
        triangles.extend(mesh.triangles.iter().map(|&corners| {
            let corners =
                outward_order(corners, &shape.placement).map(|vertex| prepared[vertex as usize]);
            Triangle { corners }
        }));
    }
    true
}

fn place_normals(mesh: &TriangleMesh, shape: &ObjectShape, crease: Degrees) -> ObjectNormals {
    let object = corner_normals(mesh, crease);
    let linear = shape.placement.linear;
    ObjectNormals {
        normals: object
            .normals
            .iter()
            .map(|&n| (linear * n).normalize_or_zero().as_vec3())
            .collect(),
        corners: object
            .corners
            .iter()
            .map(|&corners| outward_order(corners, &shape.placement))
            .collect(),
    }
}

/// A placement that mirrors turns triangles inside out; swapping two corners turns them back.
fn outward_order(corners: [u32; 3], placement: &Placement) -> [u32; 3] {
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
