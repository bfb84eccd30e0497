//! Meshes with the objects that show them, so that what is wrong with a mesh is looked for and told once.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Hazard, HazardKind, Place, Severity, Subject, tally::Tally};
use crate::geometry::TriangleMesh;
use crate::math::{Bounds, DBounds, DVec3, Vec3};
use crate::scene::{Copies, Material, Object, Scene, SceneError};

/// A mesh and the objects that show it: what is wrong with it is found once.
pub struct MeshUse<'a> {
    name: &'a str,
    /// As it is shown, its winding repaired where its objects say so.
    pub mesh: Arc<TriangleMesh>,
    objects: Vec<&'a Object>,
    /// Whether any of the objects is of glass.
    pub is_glass: bool,
    /// Whether any of the objects is shaded smoothly.
    pub is_smooth: bool,
}

impl<'a> MeshUse<'a> {
    /// The meshes that objects of the scene show, each once.
    ///
    /// # Errors
    /// Meshes and materials that are not there.
    pub fn all_of(scene: &'a Scene) -> Result<Vec<Self>, SceneError> {
        let mut numbers = BTreeMap::new();
        let mut uses: Vec<Self> = Vec::new();
        for object in &scene.objects {
            let shown = (object.mesh.as_str(), object.repair_winding);
            let number = *numbers.entry(shown).or_insert(uses.len());
            if number == uses.len() {
                uses.push(Self {
                    name: &object.mesh,
                    mesh: scene.shown_mesh_of(object)?,
                    objects: Vec::new(),
                    is_glass: false,
                    is_smooth: false,
                });
            }
            let mesh = &mut uses[number];
            mesh.objects.push(object);
            mesh.is_glass |= is_glass(scene, object)?;
            mesh.is_smooth |= object.smooth;
        }
        Ok(uses)
    }

    /// The place of triangles around `point`, in the mesh's coordinates.
    pub fn place(&self, faces: &[usize], point: DVec3) -> Place {
        let placement = self.objects[0].placement();
        Place {
            faces: faces.to_vec(),
            position: Some(placement.world_from_object(point).to_array()),
            pixel: None,
        }
    }

    /// The place of one triangle: its middle.
    pub fn place_of_face(&self, face: usize) -> Place {
        self.place(&[face], middle_of(self.mesh.corners(face)))
    }

    /// A hazard of this mesh with what `tally` holds.
    pub fn hazard(&self, kind: HazardKind, severity: Severity, tally: Tally) -> Hazard {
        let copies = self.objects.iter().map(|object| object.copies.total());
        Hazard {
            kind,
            severity,
            subject: Subject::Mesh {
                mesh: self.name.to_owned(),
                objects: self.objects.iter().map(|o| o.name.clone()).collect(),
                copies: copies.fold(0, u64::saturating_add),
            },
            count: tally.count,
            places: tally.places,
            figure: None,
            message: String::new(),
            advice: String::new(),
        }
    }
}

/// Whether an object is a body of glass that is rendered as such.
///
/// # Errors
/// A material that is not there.
pub fn is_glass(scene: &Scene, object: &Object) -> Result<bool, SceneError> {
    let is_glass = matches!(scene.material_of(object)?, Material::Glass { .. });
    Ok(is_glass && scene.render.glass)
}

/// The world box of the first copy of `object`, which shows `mesh`.
pub fn bounds_of_first_copy(object: &Object, mesh: &TriangleMesh) -> DBounds {
    let alone = Object {
        copies: Copies::default(),
        ..object.clone()
    };
    alone.bounds_of(mesh)
}

/// The mean of the corners.
pub fn middle_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    // Thirds first: sums of large corners may overflow.
    a / 3.0 + b / 3.0 + c / 3.0
}

/// A box in `f32` around one in `f64`, larger by what rounds.
pub fn narrowed(bounds: &DBounds) -> Bounds {
    let slack =
        |corner: DVec3| corner.as_vec3().abs().max_element() * f32::EPSILON + f32::MIN_POSITIVE;
    Bounds {
        min: bounds.min.as_vec3() - Vec3::splat(slack(bounds.min)),
        max: bounds.max.as_vec3() + Vec3::splat(slack(bounds.max)),
    }
}
