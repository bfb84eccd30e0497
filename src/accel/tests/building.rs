//! How the trees are built: their size, whatever the triangles; by any number of threads; and not to the end where cancelled.

use super::*;
use simd::LANES;
use std::time::{Duration, Instant};

fn hostile(count: u32) -> Vec<(&'static str, Vec<Triangle>)> {
    let meshes = [
        ("vertex fan", shapes::vertex_fan(count, 1)),
        ("flat", shapes::flat_overlap(count, 2)),
        ("one spot", shapes::one_spot(count, 3)),
        ("axis-aligned", shapes::axis_aligned(count, 16, 4)),
        ("slivers", shapes::slivers(count, 1e-3, 5)),
        ("stadium", teapot_in_a_stadium()),
    ];
    meshes.map(|(name, mesh)| (name, prepared(&mesh))).into()
}

#[test]
fn hostile_scenes_stay_within_the_reference_budget() {
    // Planes that cost nothing are tried everywhere; without a budget there would be ten times as many references.
    let eager = KdParameters {
        traversal_cost: 0.0,
        min_gain: 0.0,
        max_depth: Some(48),
        ..KdParameters::default()
    };
    for (name, triangles) in hostile(2000) {
        for parameters in [KdParameters::default(), eager] {
            let tree = KdTree::build(&triangles, &parameters, &CancelToken::new()).unwrap();
            let KdStatistics {
                references,
                max_depth,
                ..
            } = tree.statistics();
            let per_triangle = references as f64 / triangles.len() as f64;
            assert!(per_triangle <= 8.0, "{name}: {per_triangle} references");
            let depth = parameters
                .max_depth
                .map_or_else(|| 8.5 + 1.3 * (triangles.len() as f64).log2(), f64::from);
            assert!(f64::from(max_depth) <= depth, "{name}: depth {max_depth}");
        }
    }
}

#[test]
fn progress_of_the_kd_tree_counts_every_triangle() {
    for count in [0, 5, 300, 40_000] {
        let triangles = prepared(&shapes::soup(count, 0.02, 8));
        let (parameters, cancel) = (KdParameters::default(), CancelToken::new());
        let progress = Progress::new();
        let tree = KdTree::build_watched(&triangles, &parameters, &cancel, &progress);
        assert!(tree.is_some());
        assert_eq!(progress.done(), u64::from(count));
    }
}

/// Where no single plane pays, as in the vertex fan, the builder must not stop at a leaf with everything.
#[test]
fn hostile_scenes_cost_less_than_one_leaf() {
    for (name, triangles) in hostile(2000) {
        let one_leaf =
            KdParameters::default().intersection_cost * triangles.len().div_ceil(LANES) as f64;
        let cost = kd_tree(&triangles).statistics().sah_cost;
        assert!(cost < 0.7 * one_leaf, "{name}: {cost} against {one_leaf}");
    }
}

/// The wide tree divides them in the middle, where no heuristic tells them apart, and cuts no more triangles than it may.
#[test]
fn hostile_scenes_fill_the_blocks_of_the_wide_tree() {
    for (name, triangles) in hostile(2000) {
        let tree = wide_tree(&triangles);
        tree.validate()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let references = tree.quality().references as f64;
        let per_triangle = references / triangles.len() as f64;
        assert!(per_triangle <= 1.8, "{name}: {per_triangle} references");
        let bytes = tree.bytes() as f64 / references;
        assert!(bytes < 75.0, "{name}: {bytes} bytes per reference");
    }
}

#[test]
fn triangles_of_a_smooth_mesh_take_at_most_90_bytes_in_the_kd_tree() {
    let triangles = prepared(&shapes::icosphere(5));
    let bytes = kd_tree(&triangles).bytes() / triangles.len();
    assert!(bytes <= 90, "{bytes} bytes per triangle");
}

#[test]
fn identical_triangles_make_one_leaf() {
    let mesh = TriangleMesh {
        triangles: vec![[0, 1, 2]; 1000],
        ..shapes::soup(1, 1.0, 3)
    };
    let statistics = kd_tree(&prepared(&mesh)).statistics();
    assert!(statistics.references <= 1000, "{statistics:?}");
}

#[test]
fn few_triangles_need_no_planes() {
    for count in 0..=u32::try_from(LANES).unwrap() {
        let statistics = kd_tree(&prepared(&shapes::soup(count, 0.1, 1))).statistics();
        assert_eq!((statistics.nodes, statistics.max_depth), (1, 0));
    }
}

#[test]
fn the_trees_do_not_depend_on_the_number_of_threads() {
    let triangles = prepared(&shapes::soup(30_000, 0.05, 1));
    let built = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| trees(&triangles).map(|tree| format!("{tree:?}")))
    };
    let alone = built(1);
    for threads in [2, 5] {
        assert!(
            built(threads) == alone,
            "{threads} threads build another tree"
        );
    }
}

#[test]
fn a_cancelled_build_returns_nothing() {
    let triangles = prepared(&shapes::soup(5000, 0.1, 1));
    let cancel = CancelToken::new();
    cancel.cancel();
    assert!(KdTree::build(&triangles, &KdParameters::default(), &cancel).is_none());
    assert!(WideTree::build(&triangles, BuildQuality::Best, &cancel, &Progress::new()).is_none());
}

/// The build would run for minutes; ten seconds is far more than a cancelled one needs on any machine.
#[test]
fn a_build_stops_when_cancelled_half_way() {
    let triangles = prepared(&shapes::flat_overlap(30_000, 1));
    let endless = KdParameters {
        traversal_cost: 0.0,
        min_gain: 0.0,
        reference_budget: 1e4,
        ..KdParameters::default()
    };
    let cancel = CancelToken::new();
    let (built, elapsed) = std::thread::scope(|scope| {
        let building = scope.spawn(|| KdTree::build(&triangles, &endless, &cancel));
        std::thread::sleep(Duration::from_millis(100));
        cancel.cancel();
        let cancelled = Instant::now();
        (building.join().unwrap(), cancelled.elapsed())
    });
    assert!(built.is_none());
    assert!(elapsed < Duration::from_secs(10), "{elapsed:?}");
}
