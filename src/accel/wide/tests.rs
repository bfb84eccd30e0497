//! What the builder makes of triangles: cut or not, fast or well.

use super::build::{BLOCK_COST, NODE_COST};
use super::*;
use crate::accel::tests::{bits, prepared, rays, scenes, wide_tree};
use crate::accel::{Accelerator, BruteForce, Visits};
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, Vec3};

/// Triangles of which every other one is long and thin.
fn long_and_short(count: usize, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let triangle = |index: usize| {
        let center = random.in_cube();
        let [a, b] = [0, 1].map(|_| random.in_cube() * 0.05);
        let others = if index.is_multiple_of(2) {
            [a, b]
        } else {
            [a * 12.0, a * 6.0 + b * 0.05]
        };
        let [b, c] = others.map(|other| center + other);
        Triangle {
            corners: [center, b, c].map(|corner: DVec3| corner.as_vec3()),
        }
    };
    (0..count).map(triangle).collect()
}

/// Two walls whose boxes hold everything, in the midst of small triangles.
fn large_and_small(count: usize) -> Vec<Triangle> {
    let mut triangles = long_and_short(count, 2);
    for z in [-0.1_f32, 0.1] {
        let corners = [[-1.0, -1.0, -1.0], [1.0, -0.9, z], [0.9, 1.0, 1.0]];
        triangles.push(Triangle {
            corners: corners.map(Vec3::from),
        });
    }
    triangles
}

fn references_per_triangle(tree: &WideTree) -> f64 {
    let quality = tree.quality();
    quality.references as f64 / quality.triangles as f64
}

/// From points on the sides of boxes, in all directions, along axes and within the sides; and to such points.
fn rays_at_box_sides(tree: &WideTree) -> Vec<Ray> {
    let mut random = Random::new(3);
    let mut rays = Vec::new();
    for node in tree.nodes.iter().take(400) {
        for lane in 0..node.children.len() {
            let Bounds { min, max } = node.bounds(lane);
            if node.children[lane] == Child::NONE {
                continue;
            }
            let share = (random.in_cube() * 0.5 + 0.5).as_vec3();
            let mut origin = min + (max - min) * share;
            let axis = lane % 3;
            origin[axis] = if lane.is_multiple_of(2) {
                min[axis]
            } else {
                max[axis]
            };
            let any = random.in_cube().as_vec3();
            let mut within = any;
            within[axis] = 0.0;
            rays.extend([
                Ray::new(origin, any),
                Ray::new(origin, -any),
                Ray::new(origin, within),
                Ray::new(origin, Vec3::AXES[axis]),
                Ray::new(origin, -Vec3::AXES[axis]),
                Ray::new(origin + any * 2.0, -any),
            ]);
        }
    }
    rays
}

#[test]
fn cut_triangles_are_hit_as_by_brute_force() {
    for (name, triangles) in [
        ("long and short", long_and_short(15_000, 1)),
        ("large and small", large_and_small(8000)),
    ] {
        let tree = wide_tree(&triangles);
        tree.validate()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let references = references_per_triangle(&tree);
        assert!(references > 1.04, "{name}: {references} references");
        let all = BruteForce::new(triangles.clone());
        let mut hits = 0;
        let rays = rays(&triangles, 5)
            .into_iter()
            .chain(rays_at_box_sides(&tree));
        for ray in rays.step_by(4) {
            let expected = all.intersect(&ray, f32::INFINITY);
            let found = tree.intersect(&ray, f32::INFINITY);
            assert_eq!(bits(found), bits(expected), "{name}: {ray:?}");
            assert_eq!(
                tree.occluded(&ray, f32::INFINITY),
                expected.is_some(),
                "{name}: {ray:?}"
            );
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 1000, "{name}: only {hits} hits");
    }
}

/// Against the tree that is built alike but for the cuts.
#[test]
fn what_is_cut_pays() {
    let triangles = long_and_short(20_000, 4);
    let cut = wide_tree(&triangles);
    let bytes = cut.bytes() / triangles.len();
    assert!(bytes <= 80, "{bytes} bytes per triangle");
    let whole = uncut_tree(&triangles);
    assert_eq!(references_per_triangle(&whole), 1.0);
    let [cut, whole] = [cut, whole].map(|tree| tree.quality().sah_cost);
    assert!(cut < 0.75 * whole, "costs of {cut} and {whole}");
}

/// Soups so dense that the heuristic finds a plane as dear as a division by objects: what is cut must pay there, too.
#[test]
fn dense_soups_are_cut() {
    for (name, mesh) in [
        ("slivers", shapes::slivers(20_000, 1e-3, 5)),
        ("soup", shapes::soup(20_000, 0.3, 6)),
    ] {
        let triangles = prepared(&mesh);
        let cut = wide_tree(&triangles);
        let references = references_per_triangle(&cut);
        assert!((1.5..=1.7).contains(&references), "{name}: {references}");
        let bytes = cut.bytes() / triangles.len();
        assert!(bytes <= 80, "{name}: {bytes} bytes per triangle");
        // What the heuristic does not count: rays that hit something end there.
        let rays = rays(&triangles, 7);
        let visited = [cut, uncut_tree(&triangles)].map(|tree| {
            let tree = Accelerator::Wide(tree);
            let mut all = Visits::default();
            for ray in &rays {
                all += tree.visits(ray, f32::INFINITY, false);
            }
            NODE_COST * all.nodes as f64 + BLOCK_COST * all.blocks as f64
        });
        let [cut, whole] = visited;
        assert!(
            cut < 0.8 * whole,
            "{name}: visits that cost {cut} and {whole}"
        );
    }
}

fn uncut_tree(triangles: &[Triangle]) -> WideTree {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let tree = WideTree::build_adding(triangles, BuildQuality::Best, 0, &cancel, &progress);
    tree.expect("nobody cancels")
}

fn fast_tree(triangles: &[Triangle]) -> WideTree {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let tree = WideTree::build(triangles, BuildQuality::Fast, &cancel, &progress);
    tree.expect("nobody cancels")
}

#[test]
fn a_tree_built_fast_cuts_nothing_and_answers_alike() {
    for (name, triangles) in scenes() {
        let tree = fast_tree(&triangles);
        tree.validate()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let quality = tree.quality();
        assert_eq!(quality.references, quality.triangles, "{name}");
        let all = BruteForce::new(triangles.clone());
        for ray in rays(&triangles, 11) {
            let expected = bits(all.intersect(&ray, f32::INFINITY));
            let found = bits(tree.intersect(&ray, f32::INFINITY));
            assert_eq!(found, expected, "{name}: {ray:?}");
        }
    }
}

#[test]
fn progress_counts_every_triangle() {
    let mut triangles = long_and_short(20_000, 6);
    triangles[7].corners[1].x = f32::NAN;
    for quality in [BuildQuality::Best, BuildQuality::Fast] {
        let progress = Progress::new();
        let tree = WideTree::build(&triangles, quality, &CancelToken::new(), &progress);
        assert!(tree.is_some());
        assert_eq!(progress.done(), triangles.len() as u64);
    }
}
