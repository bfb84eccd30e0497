//! What it takes to remember scenes.
//!
//! Copies of a scene share their meshes and images, so those count once, and not at all where the scene that is edited has them.

use std::collections::HashSet;
use std::sync::Arc;

use crate::geometry::TriangleMesh;
use crate::scene::{Light, Material, Object, RadianceMap, Scene};

/// Bytes of `scenes` that `present` does not share: their plain data, and meshes and images that it does not have.
#[must_use]
pub fn bytes_beside<'a>(scenes: impl IntoIterator<Item = &'a Scene>, present: &Scene) -> usize {
    let mut known: HashSet<*const ()> = shared_data(present).map(|(place, _)| place).collect();
    let mut sum = 0;
    for scene in scenes {
        let own = shared_data(scene).filter(|&(place, _)| known.insert(place));
        sum += plain_bytes(scene) + own.map(|(_, bytes)| bytes).sum::<usize>();
    }
    sum
}

/// Where meshes and images of `scene` lie, and their bytes.
fn shared_data(scene: &Scene) -> impl Iterator<Item = (*const (), usize)> {
    let meshes = scene.meshes.values();
    let meshes = meshes.map(|mesh| (Arc::as_ptr(mesh).cast(), mesh_bytes(mesh)));
    let images = scene.images.values();
    let images = images.map(|image| (Arc::as_ptr(image).cast(), image_bytes(image)));
    let textures = scene.textures.values();
    let textures = textures.map(|image| (Arc::as_ptr(image).cast(), image.texels().bytes()));
    meshes.chain(images).chain(textures)
}

fn plain_bytes(scene: &Scene) -> usize {
    scene.objects.len() * size_of::<Object>()
        + scene.lights.len() * size_of::<Light>()
        + scene.materials.len() * size_of::<Material>()
}

/// Bytes of the vertices and triangles of `mesh`.
fn mesh_bytes(mesh: &TriangleMesh) -> usize {
    let normals = mesh.normals.as_deref().unwrap_or_default();
    let coordinates = mesh.texture_coordinates.as_deref().unwrap_or_default();
    let colors = mesh.colors.as_deref().unwrap_or_default();
    size_of_val(&*mesh.positions)
        + size_of_val(&*mesh.triangles)
        + size_of_val(normals)
        + size_of_val(coordinates)
        + size_of_val(colors)
}

fn image_bytes(image: &RadianceMap) -> usize {
    image.width() as usize * image.height() as usize * size_of::<[f32; 3]>()
}
