//! Rays take no memory of their own, however deep the tree is that they walk through.
//!
//! This file is a program of its own, as it counts what the whole program allocates.

use std::sync::Arc;

use raymini::control::CancelToken;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::{Object, Scene};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// How many pieces of memory a render of `mesh` on one thread asks for, and the rays that it takes.
fn allocations(mesh: TriangleMesh) -> (u64, u64) {
    let mut scene = Scene::default();
    scene.meshes.insert("mesh".into(), Arc::new(mesh));
    scene.objects.push(Object {
        mesh: "mesh".into(),
        ..Object::default()
    });
    (scene.camera.eye, scene.camera.target) = ((0.0, -6.0, 0.0).into(), (0.0, 0.0, 0.0).into());
    (scene.render.width, scene.render.height) = (64, 64);
    scene.render.samples_per_pixel = 16;
    let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
    let prepared = prepared.expect("can be rendered").expect("nobody cancels");
    let run = RunConfig {
        threads: 1,
        ..RunConfig::default()
    };
    let before = dhat::HeapStats::get().total_blocks;
    let outcome = render(&prepared, None, &run, &RenderProgress::default(), None);
    let after = dhat::HeapStats::get().total_blocks;
    let outcome = outcome.expect("nobody cancels");
    (after - before, outcome.stats.rays.total())
}

/// Many thin triangles that all overlap leave more boxes to wait for a ray than the walk has room for in its array.
#[test]
fn rays_through_deep_trees_share_their_memory() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let (shallow, _) = allocations(shapes::slivers(1, 1e-3, 1));
    let (deep, rays) = allocations(shapes::slivers(60_000, 1e-3, 1));
    assert!(rays >= 64 * 64 * 16, "only {rays} rays");
    assert!(
        deep < shallow + 100,
        "{deep} pieces of memory for {rays} rays, {shallow} where nothing waits"
    );
}
