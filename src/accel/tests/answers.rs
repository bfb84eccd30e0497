//! The trees against brute force, bit for bit.

use super::*;
use crate::math::power_of_two;

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
