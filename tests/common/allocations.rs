//! How many pieces of memory a render asks for, in programs of their own: it counts what the whole program allocates.

use raymini::control::CancelToken;
use raymini::render::{PreparedScene, RenderProgress, RunConfig, render};
use raymini::scene::Scene;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// The pieces that a render of `scene` on one thread asks for while a profiler runs, and the rays that it takes.
pub fn allocations(scene: &Scene) -> (u64, u64) {
    let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
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
