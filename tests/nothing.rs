//! The picture of nothing takes memory for its pixels and for nothing else: however large it is, as many pieces.
//!
//! This file is a program of its own, as it counts what the whole program allocates.

use raymini::control::CancelToken;
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::Scene;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// How many pieces of memory a render on one thread asks for.
fn allocations(side: u32) -> u64 {
    let mut scene = Scene::default();
    (scene.render.width, scene.render.height) = (side, side);
    scene.render.samples_per_pixel = 1;
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
    assert_eq!(outcome.stats.rays.total(), u64::from(side).pow(2));
    after - before
}

/// Some sixty, give or take a few by the moment at which the thread starts. The largest has a thousand tiles.
#[test]
fn a_larger_picture_of_nothing_takes_no_more_pieces_of_memory() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let smallest = allocations(8);
    assert!(smallest < 80, "{smallest} at 8 × 8 pixels");
    for side in [64, 512, 1024] {
        let found = allocations(side);
        assert!(
            found.abs_diff(smallest) < 20,
            "{found} at {side} × {side} pixels, {smallest} at 8 × 8"
        );
    }
}
