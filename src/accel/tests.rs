//! The trees against brute force, bit for bit, on rays and scenes chosen to be hard.

use super::*;
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::geometry::{RayKernel, TriangleMesh};
use crate::math::{DVec3, SceneFrame, Vec3, power_of_two};
use block::{BlockFilter, TriangleBlock};
use simd::{LANES, LaneSet, Query, Simd};
use std::time::{Duration, Instant};

/// The mesh as the renderer prepares it.
fn prepared(mesh: &TriangleMesh) -> Vec<Triangle> {
    let frame = SceneFrame::around(&mesh.bounds());
    let corners = (0..mesh.triangles.len()).map(|i| mesh.corners(i));
    corners
        .map(|corners| Triangle {
            corners: corners.map(|corner| frame.narrow(corner)),
        })
        .collect()
}

fn joined(meshes: impl IntoIterator<Item = TriangleMesh>) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = u32::try_from(all.positions.len()).unwrap();
        all.positions.extend(mesh.positions);
        let triangles = mesh.triangles.into_iter();
        all.triangles
            .extend(triangles.map(|t| t.map(|vertex| vertex + first)));
    }
    all
}

fn moved(mut mesh: TriangleMesh, f: impl Fn(DVec3) -> DVec3) -> TriangleMesh {
    mesh.positions.iter_mut().for_each(|p| *p = f(*p));
    mesh
}

/// A sphere a million times smaller than the ground it stands on.
fn teapot_in_a_stadium() -> TriangleMesh {
    let teapot = moved(shapes::icosphere(2), |p| {
        p * 1e-6 + DVec3::new(0.3, 0.2, 1e-6)
    });
    joined([shapes::grid(4), teapot])
}

pub(super) fn scenes() -> Vec<(&'static str, Vec<Triangle>)> {
    let identical = vec![[0, 1, 2]; 100];
    let identical = TriangleMesh {
        triangles: identical,
        ..shapes::soup(1, 1.0, 3)
    };
    let square = shapes::grid(3);
    let meshes = [
        ("nothing", TriangleMesh::default()),
        ("one triangle", shapes::soup(1, 1.0, 1)),
        ("two triangles", shapes::soup(2, 1.0, 2)),
        ("sphere", shapes::icosphere(3)),
        ("box", shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE)),
        ("soup", shapes::soup(600, 0.2, 4)),
        ("large soup", shapes::soup(1500, 0.1, 5)),
        ("slivers", shapes::slivers(400, 1e-6, 6)),
        ("vertex fan", shapes::vertex_fan(120, 7)),
        ("identical", identical),
        ("flat", shapes::flat_overlap(200, 8)),
        ("axis-aligned", shapes::axis_aligned(300, 16, 9)),
        ("one spot", shapes::one_spot(200, 10)),
        ("stadium", teapot_in_a_stadium()),
        (
            "coplanar duplicates",
            joined([square.clone(), square.clone(), square]),
        ),
    ];
    let mut scenes: Vec<_> = meshes.map(|(name, mesh)| (name, prepared(&mesh))).into();

    // Not as the renderer prepares them, but no answer may depend on that.
    let sphere = prepared(&shapes::icosphere(2));
    let mapped = |f: fn(Vec3) -> Vec3| {
        let triangles = sphere.iter();
        triangles
            .map(|t| Triangle {
                corners: t.corners.map(f),
            })
            .collect()
    };
    scenes.push(("far out", mapped(|p| p + 1000.0)));
    scenes.push(("tiny", mapped(|p| p * 2_f32.powi(-20))));
    scenes.push(("huge", mapped(|p| p * 2_f32.powi(20))));
    scenes.push(("very tiny", mapped(|p| p * 2_f32.powi(-100))));
    scenes.push((
        "subnormal",
        mapped(|p| p * 2_f32.powi(-100) * 2_f32.powi(-32)),
    ));
    scenes
}

pub(super) fn kd_tree(triangles: &[Triangle]) -> KdTree {
    let tree = KdTree::build(triangles, &KdParameters::default(), &CancelToken::new());
    tree.expect("nobody cancels")
}

pub(super) fn wide_tree(triangles: &[Triangle]) -> WideTree {
    WideTree::build(
        triangles,
        BuildQuality::Best,
        &CancelToken::new(),
        &Progress::new(),
    )
    .expect("nobody cancels")
}

/// Every structure but the reference.
pub(super) fn trees(triangles: &[Triangle]) -> [Accelerator; 2] {
    let (kd, wide) = (kd_tree(triangles), wide_tree(triangles));
    [Accelerator::KdTree(kd), Accelerator::Wide(wide)]
}

pub(super) fn narrowed(v: DVec3) -> Vec3 {
    v.as_vec3()
}

/// A random number below 2³¹.
pub(super) fn whole(random: &mut Random) -> usize {
    usize::try_from(random.bits() >> 33).unwrap()
}

/// Rays that miss, hit, graze and run along `triangles`.
pub(super) fn rays(triangles: &[Triangle], seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
    let (center, half) = if bounds.is_empty() {
        (DVec3::ZERO, DVec3::ONE)
    } else {
        (bounds.center().as_dvec3(), bounds.size().as_dvec3() * 0.5)
    };
    let size = half.max_element().max(f64::from(f32::MIN_POSITIVE));
    let mut rays = Vec::new();

    // From inside and outside the box in all directions.
    for reach in [0.9, 3.0, 100.0] {
        for _ in 0..150 {
            let origin = center + random.in_cube() * size * reach;
            let target = center + random.in_cube() * half;
            rays.push(Ray::new(narrowed(origin), narrowed(random.in_cube())));
            rays.push(Ray::new(narrowed(origin), narrowed(target - origin)));
        }
    }
    if triangles.is_empty() {
        return rays;
    }

    let any_triangle = |random: &mut Random| {
        let index = random.bits() % triangles.len() as u64;
        triangles[usize::try_from(index).unwrap()].corners
    };
    for i in 0..600 {
        // At vertices and edges.
        let [a, b, c] = any_triangle(&mut random).map(Vec3::as_dvec3);
        let origin = narrowed(center + random.in_cube() * size * 2.0);
        let share = if i % 3 == 0 { 0.0 } else { random.unit() };
        rays.push(Ray::new(origin, narrowed(a + (b - a) * share) - origin));
        // In the triangle's plane, towards it and away from it, from its plane and from its corner.
        let beside =
            a + (b - a) * (random.unit() * 6.0 - 3.0) + (c - a) * (random.unit() * 6.0 - 3.0);
        rays.push(Ray::new(narrowed(beside), narrowed(b - beside)));
        rays.push(Ray::new(narrowed(beside), narrowed(c - b)));
        rays.push(Ray::new(narrowed(a), narrowed(c - b)));
        rays.push(Ray::new(narrowed(a), narrowed(random.in_cube())));
    }

    // Along the lattice, with both zeros, from where planes are likely: coordinates of corners.
    for z in [-1.0, -0.0, 0.0, 1.0] {
        for y in [-1.0, -0.0, 0.0, 1.0] {
            for x in [-1.0, -0.0, 0.0, 1.0] {
                let direction = Vec3::new(x, y, z);
                if direction == Vec3::ZERO {
                    continue;
                }
                for i in 0..12 {
                    let mut corner = || any_triangle(&mut random)[i % 3];
                    let mut origin = Vec3::new(corner().x, corner().y, corner().z);
                    if i % 2 == 0 {
                        origin -= direction * narrowed(DVec3::splat(size * 4.0));
                    }
                    rays.push(Ray::new(origin, direction));
                }
            }
        }
    }
    rays.retain(|ray| ray.direction.is_finite() && ray.direction != Vec3::ZERO);
    rays
}

pub(super) fn bits(hit: Option<Hit>) -> Option<(u32, u32, [u32; 3])> {
    hit.map(|hit| {
        (
            hit.triangle,
            hit.t.to_bits(),
            hit.barycentrics.map(f32::to_bits),
        )
    })
}

/// Asserts that both structures answer with the same bits; returns the number of hits.
fn assert_same(name: &str, tree: &Accelerator, all: &BruteForce, rays: &[Ray]) -> usize {
    let mut hits = 0;
    let name = format!("{} over {name}", tree.name());
    for ray in rays {
        let expected = all.intersect(ray, f32::INFINITY);
        assert_eq!(
            bits(tree.intersect(ray, f32::INFINITY)),
            bits(expected),
            "{name}: {ray:?}, {expected:?}"
        );
        if let Some(hit) = expected {
            hits += 1;
            // The interval is open: nothing is nearer than the nearest hit, and the next number reaches it.
            for (t_max, occluded) in [(hit.t, false), (hit.t.next_up(), true)] {
                assert_eq!(
                    tree.occluded(ray, t_max),
                    occluded,
                    "{name}: {ray:?} up to {t_max}"
                );
                assert_eq!(
                    all.occluded(ray, t_max),
                    occluded,
                    "{name}: {ray:?} up to {t_max}"
                );
                assert_eq!(
                    tree.intersect(ray, t_max).is_some(),
                    occluded,
                    "{name}: {ray:?}"
                );
            }
        } else {
            assert!(!tree.occluded(ray, f32::INFINITY), "{name}: {ray:?}");
        }
    }
    hits
}

#[test]
fn the_trees_answer_like_brute_force() {
    for (name, triangles) in scenes() {
        for tree in trees(&triangles) {
            let sound = match &tree {
                Accelerator::Wide(tree) => tree.validate(),
                Accelerator::KdTree(tree) => tree.validate(),
                Accelerator::BruteForce(_) => Ok(()),
            };
            sound.unwrap_or_else(|error| panic!("{} over {name}: {error}", tree.name()));
            let hits = assert_same(
                name,
                &tree,
                &BruteForce::new(triangles.clone()),
                &rays(&triangles, 1),
            );
            assert!(
                triangles.is_empty() || hits > 200,
                "{name}: only {hits} hits"
            );
        }
    }
}

/// Rays that no margin is relative to: distances overflow and underflow, and planes lie where differences are infinite.
#[test]
fn extreme_rays_and_triangles_are_met_as_by_brute_force() {
    let mut random = Random::new(8);
    let mut hits = 0;
    for turn in 0..400 {
        let exponent = random.unit() * 270.0 - 145.0;
        let mut extreme = |exponent: f64| narrowed(random.in_cube() * exponent.exp2());
        let triangles: Vec<_> = (0..40)
            .map(|i| Triangle {
                corners: [0, 1, 2].map(|_| extreme(if i % 2 == 0 { exponent } else { 126.9 })),
            })
            .collect();
        let mut rays = Vec::new();
        for i in 0..50 {
            let origin = extreme([exponent, 127.0, -120.0][turn % 3]);
            let target = triangles[i % 40].corners[i % 3];
            let direction = [target - origin, target, extreme(-126.0), extreme(127.0)][i % 4];
            rays.push(Ray::new(origin, direction));
        }
        rays.retain(|ray| ray.direction.is_finite() && ray.direction != Vec3::ZERO);
        let tree = Accelerator::Wide(wide_tree(&triangles));
        hits += assert_same("extreme", &tree, &BruteForce::new(triangles), &rays);
    }
    assert!(hits > 1000, "only {hits} hits");
}

/// Small leaves, many planes: what the default parameters would leave in one block is cut up too.
#[test]
fn a_tree_of_tiny_cells_answers_like_brute_force() {
    let parameters = KdParameters {
        traversal_cost: 1e-3,
        min_gain: -1.0,
        max_depth: Some(30),
        reference_budget: 20.0,
        ..KdParameters::default()
    };
    for (name, triangles) in scenes() {
        let tree = KdTree::build(&triangles, &parameters, &CancelToken::new()).unwrap();
        tree.validate()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let some: Vec<_> = rays(&triangles, 2).into_iter().step_by(3).collect();
        let tree = Accelerator::KdTree(tree);
        assert_same(name, &tree, &BruteForce::new(triangles), &some);
    }
}

/// A closed surface with a rough radius, around the origin.
fn rough_sphere(subdivisions: u32, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let mut mesh = shapes::icosphere(subdivisions);
    for position in &mut mesh.positions {
        *position *= 0.5 + 0.5 * random.unit();
    }
    prepared(&mesh)
}

/// Aimed rays, as random ones never find a crack.
#[test]
fn no_ray_escapes_a_closed_mesh_through_its_edges_and_vertices() {
    let mut random = Random::new(1);
    for offset in [0.0, 1000.0] {
        let mut triangles = rough_sphere(3, 2);
        for triangle in &mut triangles {
            triangle.corners = triangle.corners.map(|corner| corner + offset);
        }
        let trees = trees(&triangles);
        for i in 0..60 {
            let origin = narrowed(random.in_cube() * 0.1 + f64::from(offset));
            for triangle in &triangles {
                let [a, b, _] = triangle.corners.map(Vec3::as_dvec3);
                let share = if i % 3 == 0 { 0.0 } else { random.unit() };
                let ray = Ray::new(origin, narrowed(a + (b - a) * share) - origin);
                for tree in &trees {
                    let hit = tree.intersect(&ray, f32::INFINITY);
                    assert!(hit.is_some(), "{ray:?} escapes the {}", tree.name());
                    let occluded = tree.occluded(&ray, f32::INFINITY);
                    assert!(occluded, "{ray:?} escapes the {}", tree.name());
                }
            }
        }
    }
}

struct MayHit<'a> {
    ray: &'a Ray,
    t_max: f32,
    block: &'a TriangleBlock,
}

impl Query for MayHit<'_> {
    type Answer = LaneSet;

    fn answer<S: Simd>(&self, simd: S) -> LaneSet {
        BlockFilter::new(simd, self.ray).may_hit(self.block, slabs::later(self.t_max))
    }
}

/// What the filter passes by each kind of instructions.
fn may_hit(ray: &Ray, t_max: f32, block: &TriangleBlock) -> Vec<LaneSet> {
    simd::answers(&MayHit { ray, t_max, block })
}

#[test]
fn the_filter_passes_every_hit_and_no_empty_lane() {
    let mut hits = 0;
    for (name, triangles) in scenes() {
        let ids: Vec<u32> = (0..).take(triangles.len()).collect();
        let blocks: Vec<_> = ids
            .chunks(LANES)
            .map(|ids| TriangleBlock::new(ids, &triangles))
            .collect();
        for ray in rays(&triangles, 3).iter().step_by(5) {
            let kernel = RayKernel::new(ray);
            for block in &blocks {
                let passes = |t_max: f32, lane: usize| {
                    let mut passed = may_hit(ray, t_max, block).into_iter();
                    let first = passed.next().unwrap().contains(lane);
                    passed
                        .all(|other| other.contains(lane) == first)
                        .then_some(first)
                };
                for lane in 0..LANES {
                    let triangle = block.triangle(lane);
                    if block.ids[lane] == TriangleBlock::NO_TRIANGLE {
                        let passed = passes(f32::INFINITY, lane);
                        assert_eq!(passed, Some(false), "{name}: {ray:?} hits an empty lane");
                    } else if let Some(hit) = kernel.intersect(&triangle, f32::INFINITY) {
                        hits += 1;
                        for t_max in [hit.t, f32::INFINITY] {
                            let passed = passes(t_max, lane);
                            assert_eq!(passed, Some(true), "{name}: {ray:?} misses {triangle:?}");
                        }
                    }
                }
            }
        }
    }
    assert!(hits > 10_000, "only {hits} hits");
}

/// The filter's error bound must hold where `f32` overflows and underflows, too.
#[test]
fn the_filter_passes_every_hit_of_extreme_size() {
    let mut random = Random::new(5);
    let mut hits = 0;
    for i in 0..300_000 {
        // All over f32's range; where products begin to underflow; each point on its own.
        let common = [random.unit() * 270.0 - 145.0, random.unit() * 8.0 - 70.0];
        let mut extreme = || {
            let own = random.unit() * 240.0 - 120.0;
            let exponent = common.get(i % 3).copied().unwrap_or(own);
            random.in_cube() * exponent.exp2()
        };
        let corners = [extreme(), extreme(), extreme()];
        let origin = narrowed(extreme());
        let on_edge = corners[0] + (corners[1] - corners[0]) * random.unit();
        let ray = Ray::new(origin, narrowed(on_edge) - origin);
        if ray.direction == Vec3::ZERO {
            continue;
        }
        let triangle = Triangle {
            corners: corners.map(narrowed),
        };
        let kernel = RayKernel::new(&ray);
        if let Some(hit) = kernel.intersect(&triangle, f32::INFINITY) {
            hits += 1;
            let block = TriangleBlock::new(&[0], &[triangle]);
            for t_max in [hit.t, f32::INFINITY] {
                for passed in may_hit(&ray, t_max, &block) {
                    assert_eq!(passed, LaneSet::first(1), "{ray:?} misses {triangle:?}");
                }
            }
        }
    }
    assert!(hits > 20_000, "only {hits} hits");
}

/// Of all triangles on the line of a ray, those behind its start and those beyond its end are nearly all left out.
#[test]
fn the_filter_leaves_out_what_is_out_of_reach() {
    let triangles = rough_sphere(2, 3);
    let ids: Vec<u32> = (0..).take(triangles.len()).collect();
    let mut random = Random::new(12);
    let (mut within, mut passed) = (0, 0);
    for _ in 0..2000 {
        let ray = Ray::new(
            narrowed(random.in_cube() * 0.3),
            narrowed(random.in_cube().normalize()),
        );
        let kernel = RayKernel::new(&ray);
        for ids in ids.chunks(LANES) {
            let block = TriangleBlock::new(ids, &triangles);
            for t_max in [0.5, f32::INFINITY] {
                let hits = ids.iter().map(|&id| &triangles[id as usize]);
                within += hits
                    .filter(|t| kernel.intersect(t, t_max).is_some())
                    .count();
                let answers = may_hit(&ray, t_max, &block);
                passed += answers[0].count();
                assert!(answers.iter().all(|other| *other == answers[0]), "{ray:?}");
            }
        }
    }
    assert!(within > 1000, "only {within} hits");
    assert!(
        passed <= within + within / 100,
        "{passed} for {within} hits"
    );
}

#[test]
fn the_length_of_the_direction_scales_t_and_nothing_else() {
    let triangles = rough_sphere(2, 3);
    let trees = trees(&triangles);
    for ray in rays(&triangles, 4) {
        let hit = trees[0].intersect(&ray, f32::INFINITY);
        for exponent in [-40, 40] {
            let scale = power_of_two(exponent);
            let scaled = Ray::new(ray.origin, narrowed(ray.direction.as_dvec3() * scale));
            let expected = hit.map(|hit| Hit {
                t: narrowed(DVec3::splat(f64::from(hit.t) / scale)).x,
                ..hit
            });
            for tree in &trees {
                assert_eq!(tree.intersect(&scaled, f32::INFINITY), expected, "{ray:?}");
            }
        }
    }
}

#[test]
fn of_coinciding_triangles_the_first_is_hit() {
    let square = shapes::grid(8);
    let triangles = prepared(&joined([square.clone(), square.clone(), square]));
    let trees = trees(&triangles);
    let mut random = Random::new(6);
    for _ in 0..1000 {
        let target = random.in_cube().with_z(0.0) * 0.49;
        let origin = target + DVec3::new(0.1, 0.2, 1.0);
        let ray = Ray::new(narrowed(origin), narrowed(target - origin));
        for tree in &trees {
            let hit = tree
                .intersect(&ray, f32::INFINITY)
                .expect("the ray meets the square");
            assert!(hit.triangle < 128, "{hit:?}");
        }
    }
}

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

/// Loaders refuse such triangles, but they must not bring the rest down.
#[test]
fn triangles_that_are_not_finite_are_never_hit() {
    let mut triangles = prepared(&shapes::soup(300, 0.3, 1));
    for (i, bad) in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
        .into_iter()
        .enumerate()
    {
        triangles[i * 7].corners[i % 3].x = bad;
        triangles[i * 11 + 50].corners = [Vec3::splat(bad); 3];
    }
    let finite = prepared(&shapes::soup(300, 0.3, 1));
    for tree in trees(&triangles) {
        assert!(triangles.iter().zip(tree.triangles()).all(|(a, b)| {
            let bits =
                |triangle: &Triangle| triangle.corners.map(|c| c.to_array().map(f32::to_bits));
            bits(a) == bits(&b)
        }));
        let all = BruteForce::new(triangles.clone());
        let hits = assert_same("not finite", &tree, &all, &rays(&finite, 7));
        assert!(hits > 300, "only {hits} hits");
    }
}

#[test]
fn an_accelerator_passes_questions_on() {
    let triangles = prepared(&shapes::icosphere(1));
    let [kd, wide] = trees(&triangles);
    let all = Accelerator::BruteForce(BruteForce::new(triangles.clone()));
    let names = [&kd, &wide, &all].map(Accelerator::name);
    assert_eq!(names, ["kd-tree", "wide", "brute-force"]);
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    for accelerator in [&kd, &wide, &all] {
        assert!(accelerator.triangles().eq(triangles.iter().copied()));
        assert_eq!(accelerator.bounds(), all.bounds());
        assert!(accelerator.intersect(&ray, f32::INFINITY).is_some());
        assert!(accelerator.occluded(&ray, f32::INFINITY));
        assert!(!accelerator.occluded(&ray, 0.1));
        assert!(accelerator.bytes() >= size_of_val(&*triangles));
        assert_eq!(accelerator.triangle_count(), triangles.len());
    }
}
