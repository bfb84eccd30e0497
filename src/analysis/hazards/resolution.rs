//! What rounding to `f32` does to meshes where they stand, and what it has done to them before.

use std::collections::HashSet;
use std::sync::Arc;

use super::mesh_use::middle_of;
use super::tally::Tally;
use super::{Figure, Hazard, HazardKind, Place, Severity, Subject, stops};
use crate::control::CancelToken;
use crate::geometry::{LostDigits, MeshSize, TriangleMesh, face_normal, spacing_at};
use crate::math::{DBounds, DVec3, SceneFrame, percent, three_digits};
use crate::render::PreparedScene;
use crate::scene::{Object, Placement, Scene, SceneError};

/// Examines what rounding does to every object. `None` when cancelled.
///
/// # Errors
/// Meshes that are not there.
pub fn examine(
    scene: &Scene,
    prepared: &PreparedScene,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let scene_extent = scene.bounds().size().max_element();
    let geometry = prepared.geometry();
    let mut told = HashSet::new();
    let mut hazards = Vec::new();
    for (number, object) in scene.objects.iter().enumerate() {
        let mesh = scene.mesh_of(object)?;
        let Some(size) = MeshSize::of(mesh) else {
            continue;
        };
        let shared = geometry.shared_frame(number);
        let rounding = Rounding {
            frame: *shared.unwrap_or(geometry.frame()),
            placement: shared.is_none().then(|| object.placement()),
        };
        let Some(moved) = rounding.measure(object, mesh, cancel) else {
            return Ok(None);
        };
        let bounds = object.bounds_of(mesh);
        let coarseness = if shared.is_none() {
            vec![Coarseness {
                length: moved.farthest,
                extent: scene_extent,
                of: Rounded::Placed,
            }]
        } else {
            let corners = Coarseness {
                length: moved.farthest,
                extent: size.bounds.size().max_element(),
                of: Rounded::Shared,
            };
            let points = Coarseness {
                length: rounding_within(&bounds, geometry.frame()) / object.scale.abs(),
                extent: scene_extent,
                of: Rounded::Points,
            };
            vec![corners, points]
        };
        let coarse = coarseness.iter();
        hazards.extend(coarse.filter_map(|c| c.hazard(object, &size, bounds.center())));
        hazards.extend(collapsed_faces(object, moved.collapsed));
        if told.insert(&object.mesh) {
            hazards.extend(lost_digits(object, mesh, &size));
        }
    }
    Ok(Some(hazards))
}

/// The largest distance, along an axis and in world units, by which a point of `bounds` moves when it is rounded in `frame`.
fn rounding_within(bounds: &DBounds, frame: &SceneFrame) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| frame.prepared_from_world(corner).abs());
    spacing_at(min.max(max).max_element()) / 2.0 / frame.scale()
}

/// How the corners of an object become `f32`: where they stand in the scene, or in a frame of the mesh's own where copies share
/// it.
struct Rounding {
    frame: SceneFrame,
    placement: Option<Placement>,
}

/// What rounding does.
struct Moved {
    /// The largest distance by which a corner moves, in the mesh's unit.
    farthest: f64,
    /// Faces that have an area before and none afterwards, in one copy.
    collapsed: Tally,
}

impl Rounding {
    fn measure(
        &self,
        object: &Object,
        mesh: &Arc<TriangleMesh>,
        cancel: &CancelToken,
    ) -> Option<Moved> {
        let mut moved = Moved {
            farthest: 0.0,
            collapsed: Tally::default(),
        };
        // Copies that are placed in the scene are few; those that are not are all alike.
        let copies = self.placement.is_some().then(|| object.copies.offsets());
        let offsets = copies.into_iter().flatten();
        let unit = self.frame.scale() * self.placement.map_or(1.0, |_| object.scale.abs());
        let mut is_first = true;
        for offset in offsets.chain(self.placement.is_none().then_some(DVec3::ZERO)) {
            for face in 0..mesh.triangles.len() {
                if stops(cancel, face) {
                    return None;
                }
                let corners = mesh.corners(face);
                let exact = corners.map(|corner| self.prepared(corner, offset));
                let rounded = exact.map(|corner| corner.as_vec3().as_dvec3());
                for (exact, rounded) in exact.into_iter().zip(rounded) {
                    moved.farthest = moved.farthest.max((rounded - exact).length() / unit);
                }
                if is_first && face_normal(rounded).is_none() && face_normal(corners).is_some() {
                    let middle = object.placement().world_from_object(middle_of(corners));
                    moved.collapsed.add(|| place_of(&[face], middle));
                }
            }
            is_first = false;
        }
        Some(moved)
    }

    fn prepared(&self, corner: DVec3, offset: DVec3) -> DVec3 {
        let placed = self.placement.map_or(corner, |placement| {
            placement.world_from_object(corner) + offset
        });
        self.frame.prepared_from_world(placed)
    }
}

fn place_of(faces: &[usize], position: DVec3) -> Place {
    Place {
        faces: faces.to_vec(),
        position: Some(position.to_array()),
        pixel: None,
    }
}

/// A hazard of an object with what `tally` holds.
fn hazard(object: &Object, kind: HazardKind, severity: Severity, tally: Tally) -> Hazard {
    Hazard {
        kind,
        severity,
        subject: Subject::Object {
            object: object.name.clone(),
            mesh: object.mesh.clone(),
            copies: object.copies.total(),
        },
        count: tally.count,
        places: tally.places,
        figure: None,
        message: String::new(),
        advice: String::new(),
    }
}

/// What is rounded.
#[derive(Clone, Copy)]
enum Rounded {
    /// Corners where they stand in the scene.
    Placed,
    /// Corners of a mesh that copies share, in its own frame.
    Shared,
    /// Points on copies whose corners are not rounded in the scene.
    Points,
}

/// How far rounding moves something.
struct Coarseness {
    /// The distance, in the mesh's unit.
    length: f64,
    /// The longest side of the box of the scene, or of the mesh, whose size makes it that large.
    extent: f64,
    of: Rounded,
}

impl Coarseness {
    /// The hazard that it is to `object` around `center`, if it is one.
    fn hazard(&self, object: &Object, size: &MeshSize, center: DVec3) -> Option<Hazard> {
        if !size.shows(self.length) {
            return None;
        }
        let mut tally = Tally::default();
        tally.add(|| place_of(&[], center));
        let of_edge = self.length / size.median_edge;
        let moved = format!(
            "by up to {} of the median edge ({} of the object's size) when they are rounded to 32 bits",
            percent(of_edge),
            percent(self.length / size.diagonal),
        );
        let extent = three_digits(self.extent);
        let nearer = "Move it nearer to the middle of the scene, or make what makes the scene so large smaller or leave it out: a far \
                      ground, a dome, a lost vertex.";
        let (severity, message, advice) = match self.of {
            Rounded::Placed => (
                Severity::Warning,
                format!("corners move {moved}, as the scene is {extent} across"),
                nearer,
            ),
            Rounded::Shared => (
                Severity::Warning,
                format!("corners move {moved}, as the mesh is {extent} across"),
                "Leave out what makes the mesh so large: a lost vertex, a far part.",
            ),
            Rounded::Points => (
                Severity::Note,
                format!(
                    "its shape is exact, as copies share the mesh, but points on it move {moved}, as the scene is {extent} across; \
                     edges of shadows may have steps"
                ),
                nearer,
            ),
        };
        Some(Hazard {
            figure: Some(Figure {
                value: of_edge,
                of: "largest move over the median edge",
            }),
            message,
            advice: advice.to_owned(),
            ..hazard(object, HazardKind::CoarseResolution, severity, tally)
        })
    }
}

fn collapsed_faces(object: &Object, collapsed: Tally) -> Option<Hazard> {
    (collapsed.count > 0).then(|| Hazard {
        message: format!(
            "{} area when their corners are rounded to 32 bits, and {} not there for rays",
            collapsed.of("face loses its", "faces lose their"),
            if collapsed.count == 1 { "is" } else { "are" }
        ),
        advice: "Their neighbours close the gaps, so that the surface stays whole. Make the scene smaller, or the faces less thin, \
                 if their normals matter."
            .to_owned(),
        ..hazard(object, HazardKind::CollapsedFaces, Severity::Note, collapsed)
    })
}

/// A mesh whose coordinates were `f32` far from their origin before they were written.
fn lost_digits(object: &Object, mesh: &TriangleMesh, size: &MeshSize) -> Option<Hazard> {
    let lost = LostDigits::of_measured(mesh, size)?;
    let mut tally = Tally::default();
    let center = size.bounds.center();
    tally.add(|| place_of(&[], object.placement().world_from_object(center)));
    Some(Hazard {
        figure: Some(Figure {
            value: lost.of_edge,
            of: "distance of neighbouring 32-bit numbers over the median edge",
        }),
        message: lost.to_string(),
        advice: "What was lost is not in the file. Move the object to the origin in the program that made it, write it again, and \
                 move it back by translate."
            .to_owned(),
        ..hazard(object, HazardKind::LostDigits, Severity::Warning, tally)
    })
}
