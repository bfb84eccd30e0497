//! Scenes and rays chosen to be hard, which the tests of all structures share.

mod answers;
mod building;
mod filter;

use super::*;
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, SceneFrame, Vec3};

/// The mesh as the renderer prepares it.
pub(super) fn prepared(mesh: &TriangleMesh) -> Vec<Triangle> {
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

/// A closed surface with a rough radius, around the origin.
fn rough_sphere(subdivisions: u32, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let mut mesh = shapes::icosphere(subdivisions);
    for position in &mut mesh.positions {
        *position *= 0.5 + 0.5 * random.unit();
    }
    prepared(&mesh)
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
