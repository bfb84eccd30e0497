//! From prepared triangles to what the GPU draws, on a worker thread.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::ball::Ball;
use super::choice::Group;
use super::detail::{Level, levels_of};
use super::geometry::{Place, PreviewMesh, PreviewObject, PreviewPart, Vertex};
use crate::control::CancelToken;
use crate::math::{Bounds, DMat3, DVec3, ScaledRotation, Vec3};
use crate::render::{PreparedGeometry, PreparedObject, ShadingNormals};

/// The most groups that the copies of an object are looked at in.
const MOST_GROUPS: usize = 1024;

/// The prepared triangles as the preview draws them: every corner with its normal, shared meshes once. Where there are more than
/// `most_triangles` with all copies, at several levels of detail. `None` when cancelled.
#[must_use]
pub fn preview_mesh(
    geometry: &PreparedGeometry,
    most_triangles: u64,
    cancel: &CancelToken,
) -> Option<PreviewMesh> {
    let mut mesh = PreviewMesh {
        frame: *geometry.frame(),
        bounds: geometry.accelerator().bounds(),
        parts: Vec::new(),
        places: vec![Place::new(DVec3::ZERO)],
        objects: Vec::with_capacity(geometry.objects().len()),
    };
    // The place of what is placed already.
    let once = Group {
        places: 0..1,
        ball: ball_around(&[DVec3::ZERO]),
    };
    // Parts of shared meshes, by the addresses of triangles and normals.
    let mut shared = HashMap::new();
    for (index, object) in geometry.objects().iter().enumerate() {
        if cancel.is_cancelled() {
            return None;
        }
        let normals = object.normals.as_deref();
        let drawn = if let Some((structure, turn, places)) = geometry.accelerator().copies_of(index)
        {
            let key = (Arc::as_ptr(structure), normals.map(std::ptr::from_ref));
            let part = *shared.entry(key).or_insert_with(|| {
                let corners = structure.triangles().map(|t| t.corners);
                mesh.add_part(corners, object.triangles_per_copy, normals, true)
            });
            PreviewObject {
                part,
                groups: mesh.add_places(places.collect()),
                turn: *turn,
            }
        } else {
            let ids = object.triangles.clone();
            let corners = ids.map(|id| geometry.triangle(id).in_scene().corners);
            PreviewObject {
                part: mesh.add_part(corners, object.triangles_per_copy, normals, false),
                groups: vec![once.clone()],
                turn: ScaledRotation::new(DMat3::IDENTITY),
            }
        };
        mesh.objects.push(drawn);
    }
    let count = |object: &PreparedObject| object.triangles.len() as u64;
    if geometry.objects().iter().map(count).sum::<u64>() > most_triangles {
        let parts = std::mem::take(&mut mesh.parts).into_par_iter();
        let coarser = |mut part: PreviewPart| {
            part.levels = levels_of(part.levels.pop()?, cancel)?;
            Some(part)
        };
        mesh.parts = parts.map(coarser).collect::<Option<_>>()?;
    }
    Some(mesh)
}

impl PreviewMesh {
    /// Adds triangles, copy after copy of `per_copy` each that `normals` belong to; returns the number of the part.
    fn add_part(
        &mut self,
        triangles: impl ExactSizeIterator<Item = [Vec3; 3]>,
        per_copy: u32,
        normals: Option<&ShadingNormals>,
        is_shared: bool,
    ) -> usize {
        let mut vertices = Vec::with_capacity(triangles.len() * 3);
        for (index, corners) in (0..).zip(triangles) {
            let normals = normals.and_then(|normals| normals.of_corners(index % per_copy));
            let normals = normals.unwrap_or([flat_normal(corners); 3]);
            vertices.extend((0..3).map(|i| Vertex::new(corners[i], normals[i])));
        }
        self.parts.push(PreviewPart {
            levels: vec![Level::whole(vertices)],
            is_shared,
        });
        self.parts.len() - 1
    }

    /// Adds places of copies, those together that are near each other.
    fn add_places(&mut self, mut places: Vec<DVec3>) -> Vec<Group> {
        let bounds = Bounds::of_points(places.iter().map(|place| place.as_vec3()));
        let size = bounds.size().max_element().max(f32::MIN_POSITIVE);
        places.sort_by_cached_key(|place| curve_place((place.as_vec3() - bounds.min) / size));
        let together = places.len().div_ceil(MOST_GROUPS).max(1);
        let mut groups = Vec::with_capacity(places.len().div_ceil(together));
        for group in places.chunks_mut(together) {
            // The first few of a group may stand for all.
            scatter(group);
            let end = |places: &Vec<Place>| u32::try_from(places.len()).unwrap_or(u32::MAX);
            let start = end(&self.places);
            self.places.extend(group.iter().copied().map(Place::new));
            groups.push(Group {
                places: start..end(&self.places),
                ball: ball_around(group),
            });
        }
        groups
    }
}

/// Where a point of the unit cube is along a curve that passes all of it, near what is near (Morton's order).
fn curve_place(point: Vec3) -> u64 {
    let spread = |x: f32| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "20 bits"
        )]
        let bits = (x.clamp(0.0, 1.0) * 1_048_575.0) as u64;
        (0..20).fold(0, |spread, bit| spread | ((bits >> bit & 1) << (3 * bit)))
    };
    spread(point.x) | spread(point.y) << 1 | spread(point.z) << 2
}

/// Puts things in an order in which neighbours are far apart, always the same.
fn scatter(places: &mut [DVec3]) {
    let mut numbered: Vec<(u64, DVec3)> = (1_u64..)
        .map(|number| number.wrapping_mul(0x9E37_79B9_7F4A_7C15))
        .zip(places.iter().copied())
        .collect();
    numbered.sort_unstable_by_key(|(key, _)| *key);
    for (place, (_, scattered)) in places.iter_mut().zip(numbered) {
        *place = scattered;
    }
}

fn ball_around(places: &[DVec3]) -> Ball {
    let (min, max) = places.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(min, max), place| (min.min(*place), max.max(*place)),
    );
    let center = (min + max) * 0.5;
    Ball {
        center,
        radius: center.distance(max),
    }
}

/// A triangle's own normal. In `f64`, so that slivers have one too.
fn flat_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
