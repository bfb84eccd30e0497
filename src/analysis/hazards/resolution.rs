//! What rounding to `f32` does to meshes where they stand, and what it has done to them before.

use std::collections::HashSet;
use std::sync::Arc;

use super::mesh_use::middle_of;
use super::tally::Tally;
use super::{Figure, Hazard, HazardKind, Place, Severity, Subject, stops};
use crate::analysis::report::{percent, three_digits};
use crate::control::CancelToken;
use crate::geometry::{TriangleMesh, face_normal};
use crate::math::{DBounds, DVec3, SceneFrame, length_of};
use crate::render::PreparedScene;
use crate::scene::{Object, Placement, Scene, SceneError};

/// The largest move of a corner, as a share of the median edge, that can be neglected: faces turn by about half a degree.
const MOST_OF_EDGE: f64 = 1e-2;
/// The same as a share of the object's size.
const MOST_OF_SIZE: f64 = 1e-3;

/// Edges of so many triangles, evenly spread over the mesh, stand for all where the median is looked for.
const MOST_MEASURED: usize = 100_000;

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
        let Some(measures) = Measures::of(mesh) else {
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
                extent: mesh.bounds().size().max_element(),
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
        hazards.extend(coarse.filter_map(|c| c.hazard(object, &measures, bounds.center())));
        hazards.extend(collapsed_faces(object, moved.collapsed));
        if told.insert(&object.mesh) {
            hazards.extend(lost_digits(object, mesh, &measures));
        }
    }
    Ok(Some(hazards))
}

/// The largest distance, along an axis and in world units, by which a point of `bounds` moves when it is rounded in `frame`.
fn rounding_within(bounds: &DBounds, frame: &SceneFrame) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| frame.prepared_from_world(corner).abs());
    spacing_at(min.max(max).max_element()) / 2.0 / frame.scale()
}

/// How large a mesh is, in its own unit.
struct Measures {
    /// The diagonal of its box.
    size: f64,
    median_edge: f64,
}

impl Measures {
    /// `None` where there is nothing, or all corners are one.
    fn of(mesh: &TriangleMesh) -> Option<Self> {
        let bounds = mesh.bounds();
        if bounds.is_empty() {
            return None;
        }
        let size = length_of(bounds.size());
        let step = mesh.triangles.len().div_ceil(MOST_MEASURED).max(1);
        let faces = (0..mesh.triangles.len()).step_by(step);
        let mut edges: Vec<f64> = faces
            .flat_map(|face| {
                let [a, b, c] = mesh.corners(face);
                [b - a, c - b, a - c].map(length_of)
            })
            .collect();
        let middle = edges.len() / 2;
        let (_, &mut median_edge, _) = edges.select_nth_unstable_by(middle, f64::total_cmp);
        (size > 0.0 && median_edge > 0.0).then_some(Self { size, median_edge })
    }

    /// A length of the mesh's unit against what can be neglected: over the median edge, and whether it is too much.
    fn is_notable(&self, length: f64) -> bool {
        length > MOST_OF_EDGE * self.median_edge || length > MOST_OF_SIZE * self.size
    }
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
    fn hazard(&self, object: &Object, measures: &Measures, center: DVec3) -> Option<Hazard> {
        if !measures.is_notable(self.length) {
            return None;
        }
        let mut tally = Tally::default();
        tally.add(|| place_of(&[], center));
        let of_edge = self.length / measures.median_edge;
        let moved = format!(
            "by up to {} of the median edge ({} of the object's size) when they are rounded to 32 bits",
            percent(of_edge),
            percent(self.length / measures.size),
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

/// Of coordinates that have all digits of an `f32`, half have its last bit. So few may be enough where many are round.
const LEAST_SHARE_OF_LAST_BITS: f64 = 0.1;

/// A mesh whose coordinates were `f32` far from their origin before they were written.
fn lost_digits(object: &Object, mesh: &TriangleMesh, measures: &Measures) -> Option<Hazard> {
    let bounds = mesh.bounds();
    let largest = bounds.min.abs().max(bounds.max.abs()).to_array();
    let spacing = largest.map(spacing_at).into_iter().fold(0.0, f64::max);
    if !measures.is_notable(spacing) {
        return None;
    }
    let (mut numbers, mut odd) = (0_u64, 0_u64);
    for &vertex in mesh.triangles.iter().flatten() {
        for coordinate in mesh.positions[vertex as usize].to_array() {
            let narrow = narrowed(coordinate);
            if f64::from(narrow) != coordinate {
                return None;
            }
            // Only coordinates as far out as the figure is about tell.
            if spacing_at(coordinate) * 2.0 >= spacing {
                numbers += 1;
                odd += u64::from(narrow.to_bits() & 1);
            }
        }
    }
    if (odd as f64) < LEAST_SHARE_OF_LAST_BITS * numbers as f64 || odd == 0 {
        return None;
    }
    let mut tally = Tally::default();
    tally.add(|| place_of(&[], object.placement().world_from_object(bounds.center())));
    let of_edge = spacing / measures.median_edge;
    Some(Hazard {
        figure: Some(Figure {
            value: of_edge,
            of: "distance of neighbouring 32-bit numbers over the median edge",
        }),
        message: format!(
            "the coordinates in the file were rounded to 32 bits up to {} from their origin, where these are {} of the median edge \
             apart",
            three_digits(largest.into_iter().fold(0.0, f64::max)),
            percent(of_edge)
        ),
        advice: "What was lost is not in the file. Move the object to the origin in the program that made it, write it again, and \
                 move it back by translate."
            .to_owned(),
        ..hazard(object, HazardKind::LostDigits, Severity::Warning, tally)
    })
}

/// The distance of the `f32` numbers around `value`.
fn spacing_at(value: f64) -> f64 {
    let narrow = narrowed(value.abs());
    f64::from(narrow.next_up()) - f64::from(narrow)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the rounding is the question"
)]
fn narrowed(value: f64) -> f32 {
    value as f32
}
