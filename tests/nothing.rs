//! The picture of nothing takes memory for its pixels and for nothing else: however large it is, as many pieces.

#[path = "common/allocations.rs"]
mod allocations;

use raymini::scene::Scene;

/// How many pieces of memory a picture of nothing takes.
fn allocations_at(side: u32) -> u64 {
    let mut scene = Scene::default();
    (scene.render.width, scene.render.height) = (side, side);
    scene.render.samples_per_pixel = 1;
    let (found, rays) = allocations::allocations(&scene);
    assert_eq!(rays, u64::from(side).pow(2));
    found
}

/// Some sixty, give or take a few by the moment at which the thread starts. The largest has a thousand tiles.
#[test]
fn a_larger_picture_of_nothing_takes_no_more_pieces_of_memory() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let smallest = allocations_at(8);
    assert!(smallest < 80, "{smallest} at 8 × 8 pixels");
    for side in [64, 512, 1024] {
        let found = allocations_at(side);
        assert!(
            found.abs_diff(smallest) < 20,
            "{found} at {side} × {side} pixels, {smallest} at 8 × 8"
        );
    }
}
