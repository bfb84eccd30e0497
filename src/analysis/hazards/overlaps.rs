//! Faces of different objects that overlap in a plane, so near to each other that rounding decides which of them a ray meets first.
//!
//! They are looked for where rays from the eye arrive: elsewhere, as under a body that stands on a floor, nobody sees them. Left out:
//! what mirrors and glass show, and faces with the same three corners, which are told by themselves.

use std::collections::BTreeMap;

use super::mesh_use::narrowed;
use super::pair::{Pair, Shows};
use super::placed_copy::PlacedCopy;
use super::tally::Tally;
use super::{Hazard, HazardKind, Place};
use crate::accel::{BoxTree, Hit};
use crate::control::CancelToken;
use crate::geometry::{face_normal, spacing_at};
use crate::math::{Bounds, DBounds, DVec3, Ray, Vec3, three_digits};
use crate::render::{PreparedGeometry, PreparedScene, is_nothing};
use crate::scene::{Scene, SceneError};

/// The sine of the largest angle between faces that lie in one plane: rounding turns faces by as much whose edges are a hundred units in the
/// last place. Surfaces that cross are as near to each other, but in a line alone.
const PARALLEL: f64 = 1e-2;

/// How far inside of a face a point is to be, in prepared units: faces side by side overlap by what their corners are rounded.
const INSIDE: f64 = 8.0 / (1 << 24) as f64;

/// How far apart faces near the eye are that rounding does not mix up, in prepared units, of which a scene is one to two across: some 170
/// units in the last place.
const APART: f64 = 1e-5;

/// The most faces that are compared with what the eye sees: some seconds of work.
const MOST_COMPARED: usize = 1 << 26;

/// Looks for faces that overlap where [`looks`] from the eye of the `prepared` scene meet them. `None` when cancelled.
///
/// # Errors
/// Meshes and materials that are not there.
pub fn examine(
    scene: &Scene,
    looks: &[Look],
    prepared: &PreparedScene,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let boxes: Vec<_> = looks.iter().map(Look::bounds).collect();
    let tree = BoxTree::build(&boxes);
    let frame = prepared.geometry().frame();
    // For two objects, the looks at both, and the face of each object.
    let mut found: BTreeMap<[usize; 2], BTreeMap<u32, [usize; 2]>> = BTreeMap::new();
    let (mut compared, mut left_out) = (0, 0);
    for (number, object) in scene.objects.iter().enumerate() {
        if is_nothing(&scene.material_of(object)?, &scene.render) {
            continue;
        }
        for copy in PlacedCopy::all_of(object, scene.mesh_of(object)?, frame) {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            if !copy.is_near(&tree, |look| looks[look as usize].object != number) {
                continue;
            }
            let faces = copy.faces();
            if compared + faces > MOST_COMPARED {
                left_out += faces;
                continue;
            }
            compared += faces;
            let compare = |index: u32, face, corners| {
                let look = &looks[index as usize];
                if look.object != number && look.is_overlapped_by(corners) {
                    let mut both = [(look.object, look.face), (number, face)];
                    both.sort_unstable();
                    let pair = both.map(|(object, _)| object);
                    let faces = both.map(|(_, face)| face);
                    found.entry(pair).or_default().entry(index).or_insert(faces);
                }
            };
            if copy.for_each_face_near(&tree, cancel, compare).is_none() {
                return Ok(None);
            }
        }
    }
    let hazard = |(pair, places): ([usize; 2], BTreeMap<u32, [usize; 2]>)| {
        let (mut tally, mut apart) = (Tally::default(), APART);
        for (index, faces) in places {
            let Look {
                position, rounding, ..
            } = looks[index as usize];
            apart = apart.max(2.0 * rounding);
            tally.add(|| Place {
                faces: faces.to_vec(),
                position: Some(frame.world_from_prepared(position).to_array()),
                pixel: None,
            });
        }
        let apart = three_digits(apart / frame.scale());
        hazard(scene, pair, (tally, looks.len()), &apart)
    };
    let mut hazards: Vec<_> = found.into_iter().map(hazard).collect::<Result<_, _>>()?;
    hazards.extend((left_out > 0).then(|| unexamined(left_out)));
    Ok(Some(hazards))
}

/// What the eye sees in one direction, in the prepared scene.
pub struct Look {
    pub object: usize,
    /// Number of the triangle in the mesh.
    face: usize,
    corners: [DVec3; 3],
    /// Unit.
    pub normal: DVec3,
    /// In the plane of the corners.
    position: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// What the distance along the ray may be off by, and that to another face.
    rounding: f64,
}

/// Looks through the middles of the pixels of `pilot`, where they meet something; `prepared` is its scene in any size.
pub fn looks(pilot: &Scene, prepared: &PreparedScene) -> Vec<Look> {
    let (width, height) = (pilot.render.width, pilot.render.height);
    let settings = prepared.settings();
    let middle = |number: u32, count: u32, size: u32| {
        (f64::from(number) + 0.5) * f64::from(size) / f64::from(count)
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let look = |(x, y)| {
        let x = middle(x, width, settings.width);
        let y = middle(y, height, settings.height);
        let ray = prepared.camera().ray(x, y)?.ray;
        let geometry = prepared.geometry();
        let hit = geometry.accelerator().intersect(&ray, f32::INFINITY)?;
        Some(Look::new(geometry, &ray, &hit))
    };
    pixels.filter_map(look).collect()
}

impl Look {
    fn new(geometry: &PreparedGeometry, ray: &Ray, hit: &Hit) -> Self {
        let triangle = geometry.triangle(hit.triangle);
        let corners = triangle.in_scene().corners.map(Vec3::as_dvec3);
        let [a, b, c] = corners;
        let [_, v, w] = hit.barycentrics.map(f64::from);
        let direction = ray.direction.as_dvec3();
        let per_copy = geometry.objects()[triangle.part].triangles_per_copy;
        Self {
            object: triangle.part,
            face: (triangle.number % per_copy) as usize,
            corners,
            normal: triangle.normal().as_dvec3(),
            position: a + (b - a) * v + (c - a) * w,
            direction: direction.normalize_or_zero(),
            rounding: 2.0 * spacing_at(f64::from(hit.t) * direction.length()),
        }
    }

    /// A box around all points of faces that may overlap there.
    fn bounds(&self) -> Bounds {
        // No corner is beyond 1, and three coordinates of two faces round.
        let reach = self.rounding + 4.0 * spacing_at(1.0);
        narrowed(&DBounds {
            min: self.position - reach,
            max: self.position + reach,
        })
    }

    /// Whether the face with these corners lies in the plane of what is seen, around the point that is seen, as far as rounding tells,
    /// and has other corners.
    fn is_overlapped_by(&self, corners: [DVec3; 3]) -> bool {
        let Some(normal) = face_normal(corners) else {
            return false;
        };
        if normal.cross(self.normal).length() > PARALLEL {
            return false;
        }
        let rounding = self.rounding * normal.dot(self.direction).abs()
            + rounding_across(&self.corners, normal)
            + rounding_across(&corners, normal);
        let gap = normal.dot(self.position - corners[0]).abs();
        gap <= rounding && self.is_inside(corners, normal) && !self.has_corners(corners)
    }

    /// Whether the point that is seen lies well inside of a triangle of this normal, seen along that.
    fn is_inside(&self, corners: [DVec3; 3], normal: DVec3) -> bool {
        (0..3).all(|index| {
            let (from, to) = (corners[index], corners[(index + 1) % 3]);
            let inwards = normal.cross(to - from).normalize_or_zero();
            inwards.dot(self.position - from) >= INSIDE
        })
    }

    /// Whether all corners of what is seen are `others`.
    fn has_corners(&self, others: [DVec3; 3]) -> bool {
        let is_there = |corner: &DVec3| others.iter().any(|o| o.distance(*corner) < INSIDE);
        self.corners.iter().all(is_there)
    }
}

/// How far a plane of this normal may move as its corners are rounded to `f32`.
fn rounding_across(corners: &[DVec3; 3], normal: DVec3) -> f64 {
    let [a, b, c] = corners.map(DVec3::abs);
    let largest = a.max(b).max(c);
    normal.abs().dot(largest.map(spacing_at)) / 2.0
}

/// The hazard of two objects that overlap where `tally` says, of so many looks. `apart`: the distance from which on they do not.
fn hazard(
    scene: &Scene,
    pair: [usize; 2],
    (tally, looks): (Tally, usize),
    apart: &str,
) -> Result<Hazard, SceneError> {
    let pair = Pair::of(scene, pair)?;
    let advice = match pair.shows {
        Shows::Glass => format!(
            "Move them apart or into each other by more than {apart}: light that crosses both at once is bent by one of them only."
        ),
        Shows::Alike => "Nothing needs to be done: both look the same there.".to_owned(),
        Shows::Either => format!(
            "Move one of them by more than {apart}, or take away what lies in the other: the picture may be speckled there, or show \
             the wrong one."
        ),
    };
    Ok(Hazard {
        message: format!(
            "faces of both overlap in one plane, so that rounding decides which is seen: along {} of {looks} rays from the eye",
            tally.count
        ),
        advice,
        ..pair.hazard(HazardKind::OverlappingFaces, tally)
    })
}

fn unexamined(faces: usize) -> Hazard {
    let message = format!(
        "{faces} faces near what is seen were not compared with it: whether they overlap others in a plane is not known"
    );
    Hazard::unexamined(faces, message)
}
