//! Rays take no memory of their own, however deep the tree is that they walk through.

#[path = "common/allocations.rs"]
mod allocations;

use std::sync::Arc;

use allocations::allocations;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::scene::{Object, Scene};

fn scene_of(mesh: TriangleMesh) -> Scene {
    let mut scene = Scene::default();
    scene.meshes.insert("mesh".into(), Arc::new(mesh));
    scene.objects.push(Object {
        mesh: "mesh".into(),
        ..Object::default()
    });
    (scene.camera.eye, scene.camera.target) = ((0.0, -6.0, 0.0).into(), (0.0, 0.0, 0.0).into());
    (scene.render.width, scene.render.height) = (64, 64);
    scene.render.samples_per_pixel = 16;
    scene
}

/// Many thin triangles that all overlap leave more boxes to wait for a ray than the walk has room for in its array.
#[test]
fn rays_through_deep_trees_share_their_memory() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let (shallow, _) = allocations(&scene_of(shapes::slivers(1, 1e-3, 1)));
    let (deep, rays) = allocations(&scene_of(shapes::slivers(60_000, 1e-3, 1)));
    assert!(rays >= 64 * 64 * 16, "only {rays} rays");
    assert!(
        deep < shallow + 100,
        "{deep} pieces of memory for {rays} rays, {shallow} where nothing waits"
    );
}
