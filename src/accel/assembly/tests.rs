use super::*;
use crate::accel::{BruteForce, tests};
use crate::geometry::{Triangle, shapes, shapes::Random};
use crate::math::{DMat3, power_of_two};

#[expect(clippy::needless_pass_by_value, reason = "as brute force wants it")]
fn kd_tree(triangles: Vec<Triangle>) -> Accelerator {
    Accelerator::KdTree(tests::kd_tree(&triangles))
}

#[expect(clippy::needless_pass_by_value, reason = "as brute force wants it")]
fn wide_tree(triangles: Vec<Triangle>) -> Accelerator {
    Accelerator::Wide(tests::wide_tree(&triangles))
}

fn brute_force(triangles: Vec<Triangle>) -> Accelerator {
    Accelerator::BruteForce(BruteForce::new(triangles))
}

/// A scene built anew is the same scene.
#[test]
fn rebuilding_changes_no_answer() {
    let before = assembly(brute_force);
    for (name, structure) in [
        ("wide", wide_tree as fn(Vec<Triangle>) -> Accelerator),
        ("kd-tree", kd_tree),
    ] {
        let after = before.rebuilt(|triangles| Some(structure(triangles)));
        let after = after.expect("nobody cancels");
        assert_eq!(after.name(), name);
        assert_eq!(after.triangle_count(), before.triangle_count());
        let quality = after.quality();
        assert!(quality.references >= quality.triangles && quality.sah_cost > 0.0);
        for ray in rays(&before) {
            let hit = after.intersect(&ray, f32::INFINITY);
            assert_eq!(hit, before.intersect(&ray, f32::INFINITY), "{name}");
            let [nearest, any] = [false, true].map(|any| after.visits(&ray, f32::INFINITY, any));
            assert!(hit.is_none() || nearest.blocks > 0 && any.blocks > 0);
        }
    }
    assert!(before.rebuilt(|_| None).is_none());
}

fn turned(x: f64, z: f64, scale: f64) -> ScaledRotation {
    ScaledRotation::new(DMat3::from_rotation_z(z) * DMat3::from_rotation_x(x) * scale)
}

/// Copies of two meshes and two flat parts between them: turned, mirrored, tiny, one twice in the same place.
fn parts() -> Vec<Part> {
    let mut random = Random::new(3);
    let mut places = |count: u32| (0..count).map(|_| random.in_cube()).collect::<Vec<_>>();
    let copies = |structure, turn, translations| {
        Part::Copies(Copies {
            structure,
            turn,
            translations,
        })
    };
    let twice = vec![DVec3::new(0.2, 0.1, -0.3); 2];
    vec![
        copies(0, turned(0.3, 2.0, 0.12), places(9)),
        Part::Flat(30),
        copies(1, turned(0.0, 0.0, 0.25), twice),
        copies(1, turned(1.0, -0.2, -0.2), places(4)),
        Part::Flat(0),
        copies(0, turned(0.1, 0.1, 1e-6), places(3)),
        Part::Flat(50),
    ]
}

fn assembly(structure: fn(Vec<Triangle>) -> Accelerator) -> Assembly {
    let flat = structure(tests::prepared(&shapes::soup(80, 0.2, 1)));
    let shared = [shapes::icosphere(2), shapes::soup(200, 0.3, 2)];
    let shared = shared.map(|mesh| Arc::new(structure(tests::prepared(&mesh))));
    Assembly::new(flat, shared.into(), parts())
}

/// Rays at triangles, from near, from within, from far out, along axes, and at random.
fn rays(assembly: &Assembly) -> Vec<Ray> {
    let mut random = Random::new(8);
    let mut rays = Vec::new();
    for turn in 0..3000_u32 {
        let id = u32::try_from(random.bits() % u64::from(assembly.triangle_count())).unwrap();
        let [a, b, c] = assembly.triangle(id).in_scene().corners.map(Vec3::as_dvec3);
        let share = [random.unit(), random.unit()];
        let target = match turn % 4 {
            0 => a,
            1 => a + (b - a) * share[0],
            _ => a + (b - a) * share[0] + (c - a) * (share[1] * (1.0 - share[0])),
        };
        let size = [2.0, 0.3, 1e-4, 1e5][turn as usize / 4 % 4];
        let mut away = random.in_cube() * size;
        if turn % 7 == 0 {
            away.x = 0.0;
            away.y = 0.0;
        }
        let origin = (target + away).as_vec3();
        rays.push(Ray::new(origin, target.as_vec3() - origin));
        rays.push(Ray::new(target.as_vec3(), random.in_cube().as_vec3()));
    }
    rays.retain(|ray| ray.direction != Vec3::ZERO);
    rays
}

#[test]
fn the_tree_of_boxes_answers_like_all_copies_in_turn() {
    let trees = [assembly(kd_tree), assembly(wide_tree)];
    let all = assembly(brute_force);
    assert!(trees.iter().all(|tree| tree.tree.is_some()) && all.tree.is_none());
    let mut met = vec![0; all.parts.len()];
    for ray in rays(&all) {
        let expected = all.intersect(&ray, f32::INFINITY);
        for tree in &trees {
            assert_eq!(tree.intersect(&ray, f32::INFINITY), expected, "{ray:?}");
        }
        let beside = Ray::new(ray.origin, ray.direction * 1.001);
        let rays = [(ray, f32::INFINITY), (beside, f32::INFINITY)].repeat(3);
        let hits = trees[1].intersect_packet(&Packet::new(&rays));
        assert_eq!((hits[0], hits[4]), (expected, expected), "{ray:?}");
        let Some(hit) = expected else {
            let occluded = |tree: &Assembly| tree.occluded(&ray, f32::INFINITY);
            assert!(!trees.iter().any(occluded), "{ray:?}");
            continue;
        };
        met[all.part_of(hit.triangle)] += 1;
        for (t_max, expected) in [(hit.t, false), (hit.t.next_up(), true)] {
            for assembly in trees.iter().chain([&all]) {
                assert_eq!(assembly.occluded(&ray, t_max), expected, "{ray:?}");
                let hit = assembly.intersect(&ray, t_max);
                assert_eq!(hit.is_some(), expected, "{ray:?}");
            }
        }
    }
    for (part, count) in met.into_iter().enumerate() {
        assert!(part == 4 || count > 25, "part {part} is met {count} times");
    }
}

/// The weights of a hit belong to the triangle that its id names, where its `t` says.
#[test]
fn hits_lie_where_their_triangle_is() {
    let assembly = assembly(kd_tree);
    for ray in rays(&assembly) {
        let Some(hit) = assembly.intersect(&ray, f32::INFINITY) else {
            continue;
        };
        let triangle = assembly.triangle(hit.triangle);
        let (point, error) = triangle.point(hit.barycentrics);
        let [a, b, c] = triangle.in_scene().corners;
        let [u, v, w] = hit.barycentrics;
        assert!(
            (a * u + b * v + c * w - point)
                .abs()
                .cmple(error * 4.0 + 1e-7)
                .all()
        );
        // Seen from the side, a rounding across is a long way along the ray.
        let direction = ray.direction.normalize();
        let slack = 1e-6 * (1.0 + ray.origin.length()) / triangle.normal().dot(direction).abs();
        assert!((ray.at(hit.t) - point).length() < slack, "{ray:?}: {hit:?}");
        let outward = triangle.in_scene().normal();
        assert!(triangle.normal().dot(outward) > 0.9 || triangle.part == 5);
    }
}

#[test]
fn of_coinciding_copies_the_first_is_hit() {
    let assembly = assembly(kd_tree);
    let second = assembly.parts[2].start + 200;
    let hits = rays(&assembly).into_iter();
    let hits = hits.filter_map(|ray| assembly.intersect(&ray, f32::INFINITY));
    let of_part = hits.filter(|hit| assembly.part_of(hit.triangle) == 2);
    assert!(
        of_part
            .inspect(|hit| assert!(hit.triangle < second))
            .count()
            > 100
    );
}

/// A copy that is only moved meets the ray's own direction, and `t` is the ray's.
#[test]
fn a_moved_copy_keeps_direction_and_t() {
    let turn = ScaledRotation::new(DMat3::IDENTITY * power_of_two(-3));
    let place = Place {
        turn: &turn,
        translation: DVec3::new(0.3, 0.7, -0.1),
    };
    let ray = Ray::new(Vec3::new(0.1, -0.9, 0.3), Vec3::new(0.123, 0.77, -1e-5));
    let local = place.local_ray(&ray).expect("f32 holds it");
    assert_eq!(local.direction, ray.direction * 8.0);
    let (t, back) = (0.625, turn.apply(local.at(0.625).as_dvec3()));
    assert!((back + place.translation - ray.at(t).as_dvec3()).length() < 5e-7);
}

/// The sphere is closed: whatever is aimed at an edge or a corner of a copy from within it meets that copy.
#[test]
fn no_ray_escapes_a_closed_copy() {
    let mut random = Random::new(5);
    let shared = vec![Arc::new(kd_tree(tests::prepared(&shapes::icosphere(3))))];
    for (turn, place) in [
        (turned(0.4, 1.1, 0.03), DVec3::new(0.9, -0.4, 0.2)),
        (turned(-0.4, 0.3, -0.6), DVec3::new(0.1, 0.2, 0.3)),
    ] {
        let part = Part::Copies(Copies {
            structure: 0,
            turn,
            translations: vec![place],
        });
        let assembly = Assembly::new(kd_tree(Vec::new()), shared.clone(), vec![part]);
        for id in (0..assembly.triangle_count()).cycle().take(20_000) {
            let [a, b, _] = assembly.triangle(id).in_scene().corners;
            let inside = place + turn.apply(random.in_cube() * 0.3);
            let origin = inside.as_vec3();
            let target = if id % 3 == 0 { a } else { a.midpoint(b) };
            let ray = Ray::new(origin, target - origin);
            assert!(assembly.intersect(&ray, f32::INFINITY).is_some(), "{ray:?}");
            assert!(assembly.occluded(&ray, f32::INFINITY), "{ray:?}");
        }
    }
}

/// Local rays from far away meet corners that the ray itself, across an axis but for a little, passes by, box and all.
#[test]
fn a_corner_at_the_rim_of_its_box_is_not_lost() {
    let square = tests::prepared(&shapes::grid(1));
    let mut random = Random::new(9);
    let turn = turned(0.0, std::f64::consts::FRAC_PI_4, 0.013);
    let part = Part::Copies(Copies {
        structure: 0,
        turn,
        translations: (0..40).map(|_| random.in_cube()).collect(),
    });
    let assembly = |structure: fn(Vec<Triangle>) -> Accelerator| {
        let shared = vec![Arc::new(structure(square.clone()))];
        Assembly::new(structure(Vec::new()), shared, vec![part.clone()])
    };
    let (tree, all) = (assembly(kd_tree), assembly(brute_force));
    let corner = turn.apply(square[0].corners[1].as_dvec3()).x.abs();
    let mut hits = 0;
    for turn in 0..20_000_u32 {
        let translation = tree.copies[turn as usize % 40].translation;
        let distance = [1.0, 20.0, 1000.0][turn as usize % 3];
        // A few roundings of a coordinate of that size beside the corner.
        let beside = random.in_cube().x * distance * f64::from(f32::EPSILON);
        let target = translation + DVec3::X * (corner + beside);
        let away = random.in_cube().with_x(1e-7) * distance;
        let ray = Ray::new((target + away).as_vec3(), -away.as_vec3());
        let expected = all.intersect(&ray, f32::INFINITY);
        hits += u32::from(expected.is_some());
        assert_eq!(tree.intersect(&ray, f32::INFINITY), expected, "{ray:?}");
        assert_eq!(tree.occluded(&ray, f32::INFINITY), expected.is_some());
    }
    assert!(hits > 2000, "only {hits} hits");
}
