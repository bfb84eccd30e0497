//! Lights that faces pass through or touch.

use std::collections::BTreeMap;

use super::disk_reach::{DiskSpace, distance_to_triangle, nearest_on_triangle};
use super::mesh_use::narrowed;
use super::placed_copy::PlacedCopy;
use super::tally::Tally;
use super::{Figure, Hazard, HazardKind, Place, Severity, Subject};
use crate::accel::BoxTree;
use crate::control::CancelToken;
use crate::math::{Bounds, DBounds, DVec3, SceneFrame, three_digits};
use crate::scene::{Light, Object, Scene, SceneError};

/// How near a face is to a disk light, in radii, to touch it nearly.
const NEAR: f64 = 1e-3;

/// What rounding moves in prepared units, where the largest coordinate is between a half and one: some units in the last place of an `f32`.
const ROUNDING: f64 = 4.0 / (1 << 24) as f64;

/// How near a face is to a point light, in prepared units, to touch it: nearer, rounding has a say in which side is lit.
const NEAR_POINT: f64 = 4.0 * ROUNDING;

/// Looks for faces at every light. `None` when cancelled.
///
/// # Errors
/// Meshes that are not there.
pub fn examine(
    scene: &Scene,
    frame: &SceneFrame,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let lights: Vec<_> = scene
        .lights
        .iter()
        .map(|light| Reach::of(light, frame))
        .collect();
    let boxes: Vec<_> = lights.iter().map(Reach::bounds).collect();
    let tree = BoxTree::build(&boxes);
    let mut found: BTreeMap<(u32, usize), Found> = BTreeMap::new();
    for (number, object) in scene.objects.iter().enumerate() {
        for copy in PlacedCopy::all_of(object, scene.mesh_of(object)?, frame) {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            if !copy.is_near(&tree, |_| true) {
                continue;
            }
            let add = |light: u32, face, corners| {
                let reach = &lights[light as usize];
                let Some(nearness) = reach.nearness(corners) else {
                    return;
                };
                let nearest = nearest_on_triangle(reach.middle(), corners);
                let position = frame.world_from_prepared(nearest);
                found
                    .entry((light, number))
                    .or_default()
                    .add(nearness, || Place {
                        faces: vec![face],
                        position: Some(position.to_array()),
                        pixel: None,
                    });
            };
            if copy.for_each_face_near(&tree, cancel, add).is_none() {
                return Ok(None);
            }
        }
    }
    let hazards = found.into_iter().flat_map(|((light, object), found)| {
        found.hazards(scene, light as usize, &scene.objects[object], frame)
    });
    Ok(Some(hazards.collect()))
}

/// How far around a light faces count, in prepared units.
enum Reach {
    Point {
        position: DVec3,
    },
    Disk {
        space: DiskSpace,
        bounds: DBounds,
        /// In radii.
        reach: f64,
        /// Heights below which a face is in the disk's plane as far as rounding tells, in radii.
        in_plane: f64,
    },
}

/// How near a face is to a light.
#[derive(Clone, Copy)]
enum Nearness {
    /// It passes through a disk.
    Cuts,
    /// It is in a disk's plane, where rounding alone tells which of both is in front.
    InPlane,
    /// So far away, in radii of a disk, or in prepared units from a point.
    Near(f64),
}

impl Reach {
    fn of(light: &Light, frame: &SceneFrame) -> Self {
        match *light {
            Light::Point { position, .. } => Self::Point {
                position: frame.prepared_from_world(position),
            },
            Light::Disk {
                center,
                facing,
                radius,
                ..
            } => {
                // A prepared scene's disks have a direction.
                let normal = facing.normal(center).unwrap_or(DVec3::Z);
                let (center, radius) = (frame.prepared_from_world(center), radius * frame.scale());
                let in_plane = ROUNDING * center.abs().max_element().max(1.0) / radius;
                let reach = NEAR.max(2.0 * in_plane);
                // √(1 − n²) per axis is how far the rim goes.
                let across = (DVec3::ONE - normal * normal)
                    .max(DVec3::ZERO)
                    .map(f64::sqrt);
                let extent = across * radius + DVec3::splat(reach * radius);
                Self::Disk {
                    space: DiskSpace::new(center, normal, radius),
                    bounds: DBounds {
                        min: center - extent,
                        max: center + extent,
                    },
                    reach,
                    in_plane,
                }
            }
        }
    }

    fn bounds(&self) -> Bounds {
        narrowed(&match *self {
            Self::Point { position } => DBounds {
                min: position - NEAR_POINT,
                max: position + NEAR_POINT,
            },
            Self::Disk { bounds, .. } => bounds,
        })
    }

    /// Where the light is.
    fn middle(&self) -> DVec3 {
        match *self {
            Self::Point { position } => position,
            Self::Disk { space, .. } => space.center(),
        }
    }

    /// How near a face is; `None` where it is not near, or behind a disk, whose back is black.
    fn nearness(&self, corners: [DVec3; 3]) -> Option<Nearness> {
        match *self {
            Self::Point { position } => {
                let distance = distance_to_triangle(position, corners);
                (distance <= NEAR_POINT).then_some(Nearness::Near(distance))
            }
            Self::Disk {
                space,
                reach,
                in_plane,
                ..
            } => {
                let [lowest, highest] = space.heights(corners, reach)?;
                if lowest < -in_plane {
                    (highest > in_plane).then_some(Nearness::Cuts)
                } else if highest <= in_plane {
                    Some(Nearness::InPlane)
                } else {
                    Some(Nearness::Near(lowest.max(0.0)))
                }
            }
        }
    }
}

/// The faces of one object at one light.
#[derive(Default)]
struct Found {
    cutting: Tally,
    in_plane: Tally,
    near: Tally,
    /// Of those that are near.
    nearest: Option<f64>,
}

impl Found {
    fn add(&mut self, nearness: Nearness, place: impl FnOnce() -> Place) {
        match nearness {
            Nearness::Cuts => self.cutting.add(place),
            Nearness::InPlane => self.in_plane.add(place),
            Nearness::Near(distance) => {
                self.near.add(place);
                let nearest = self.nearest.unwrap_or(f64::INFINITY);
                self.nearest = Some(nearest.min(distance));
            }
        }
    }

    fn hazards(
        self,
        scene: &Scene,
        light: usize,
        object: &Object,
        frame: &SceneFrame,
    ) -> Vec<Hazard> {
        let Self {
            cutting,
            in_plane,
            near,
            nearest,
        } = self;
        let hazard = |kind, severity, tally: Tally, message: String, advice: &str| Hazard {
            kind,
            severity,
            subject: Subject::Light {
                light,
                object: object.name.clone(),
                mesh: object.mesh.clone(),
            },
            count: tally.count,
            places: tally.places,
            figure: None,
            message,
            advice: advice.to_owned(),
        };
        let mut hazards = Vec::new();
        if cutting.count > 0 {
            let message = format!(
                "{} through the disk",
                cutting.of("face passes", "faces pass")
            );
            let advice = "Move the light or make it smaller: what is behind the faces lights the wrong side or nothing, and what is \
                          near in front of them is noisy.";
            let severity = Severity::Warning;
            hazards.push(hazard(
                HazardKind::LightCut,
                severity,
                cutting,
                message,
                advice,
            ));
        }
        if in_plane.count > 0 {
            let message = format!(
                "{} in the plane of the disk",
                in_plane.of("face lies", "faces lie")
            );
            let advice = "Nothing needs to be done for a lamp in a ceiling: its bright side counts as in front. A small gap makes that \
                          certain.";
            let severity = Severity::Note;
            hazards.push(Hazard {
                figure: Some(Figure {
                    value: 0.0,
                    of: "distance over radius",
                }),
                ..hazard(
                    HazardKind::LightTouching,
                    severity,
                    in_plane,
                    message,
                    advice,
                )
            });
        }
        let Some(nearest) = nearest else {
            return hazards;
        };
        let is_disk = matches!(scene.lights[light], Light::Disk { .. });
        let faces = near.of("face is", "faces are");
        let severity = Severity::Warning;
        hazards.push(if is_disk {
            let message = format!(
                "{faces} within {} of its radius in front of the disk",
                three_digits(nearest)
            );
            let advice = "Move the light away from them: they shade what lies behind them, and what lies between is noisy.";
            Hazard {
                figure: Some(Figure {
                    value: nearest,
                    of: "distance over radius",
                }),
                ..hazard(HazardKind::LightTouching, severity, near, message, advice)
            }
        } else {
            let distance = nearest / frame.scale();
            let message = format!("{faces} only {} from the point", three_digits(distance));
            let advice = "Move the light away from them: its light grows without bound as 1/distance², and rounding decides which side \
                          it is on. Or make it a disk.";
            Hazard {
                figure: Some(Figure {
                    value: distance,
                    of: "distance in scene units",
                }),
                ..hazard(HazardKind::LightTouching, severity, near, message, advice)
            }
        });
        hazards
    }
}
