//! From prepared triangles to what the GPU draws, on a worker thread.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use super::geometry::{Place, PreviewMesh, PreviewObject, Vertex};
use crate::math::{DMat3, DVec3, ScaledRotation, Vec3};
use crate::render::{PreparedGeometry, ShadingNormals};

/// The prepared triangles as the preview draws them: every corner with its normal, shared meshes once.
#[must_use]
pub fn preview_mesh(geometry: &PreparedGeometry) -> PreviewMesh {
    let mut mesh = PreviewMesh {
        frame: *geometry.frame(),
        bounds: geometry.accelerator().bounds(),
        vertices: Vec::new(),
        places: vec![Place::new(DVec3::ZERO)],
        objects: Vec::with_capacity(geometry.objects().len()),
    };
    // Corners of shared meshes, by the addresses of triangles and normals.
    let mut shared = HashMap::new();
    for (index, object) in geometry.objects().iter().enumerate() {
        let normals = object.normals.as_deref();
        let drawn = if let Some((structure, turn, places)) = geometry.accelerator().copies_of(index)
        {
            let key = (Arc::as_ptr(structure), normals.map(std::ptr::from_ref));
            let corners = shared.entry(key).or_insert_with(|| {
                let corners = structure.triangles().map(|t| t.corners);
                mesh.add_corners(corners, object.triangles_per_copy, normals)
            });
            PreviewObject {
                corners: corners.clone(),
                places: mesh.add_places(places.map(Place::new)),
                turn: *turn,
                is_shared: true,
            }
        } else {
            let ids = object.triangles.clone();
            let corners = ids.map(|id| geometry.triangle(id).in_scene().corners);
            PreviewObject {
                corners: mesh.add_corners(corners, object.triangles_per_copy, normals),
                places: 0..1,
                turn: ScaledRotation::new(DMat3::IDENTITY),
                is_shared: false,
            }
        };
        mesh.objects.push(drawn);
    }
    mesh
}

impl PreviewMesh {
    /// Adds the corners of triangles, copy after copy of `per_copy` each that `normals` belong to; returns where they are.
    fn add_corners(
        &mut self,
        triangles: impl ExactSizeIterator<Item = [Vec3; 3]>,
        per_copy: u32,
        normals: Option<&ShadingNormals>,
    ) -> Range<usize> {
        let start = self.vertices.len();
        self.vertices.reserve(triangles.len() * 3);
        for (index, corners) in (0..).zip(triangles) {
            let normals = normals.and_then(|normals| normals.of_corners(index % per_copy));
            let normals = normals.unwrap_or([flat_normal(corners); 3]);
            let vertices = (0..3).map(|i| Vertex::new(corners[i], normals[i]));
            self.vertices.extend(vertices);
        }
        start..self.vertices.len()
    }

    fn add_places(&mut self, places: impl Iterator<Item = Place>) -> Range<u32> {
        let end = |places: &Vec<Place>| u32::try_from(places.len()).unwrap_or(u32::MAX);
        let start = end(&self.places);
        self.places.extend(places);
        start..end(&self.places)
    }
}

/// A triangle's own normal. In `f64`, so that slivers have one too.
fn flat_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
