//! What the rays are sent at: small scenes, by every structure, alone and with copies.

use std::sync::Arc;

use crate::accel::{
    Accelerator, Assembly, BruteForce, BuildQuality, Copies, KdParameters, KdTree, Part, WideTree,
};
use crate::analysis::matrix::meshes::{narrowed, stadium_of};
use crate::analysis::matrix::stage::{joined, mapped};
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::geometry::{Triangle, TriangleMesh};
use crate::math::{DMat3, DVec3, ScaledRotation, Vec3};

/// Scenes of at most 160 triangles, few enough for brute force, as rendering stores them, or moved and scaled as it never does. The
/// first has none.
pub fn scenes() -> Vec<Vec<Triangle>> {
    let identical = TriangleMesh {
        triangles: vec![[0, 1, 2]; 60],
        ..shapes::soup(1, 1.0, 3)
    };
    let square = shapes::grid(3);
    let far_apart = joined([
        shapes::icosphere(1),
        mapped(shapes::icosphere(1), |p| p * 1e-3 + 30.0),
    ]);
    let meshes = [
        TriangleMesh::default(),
        shapes::soup(1, 1.0, 1),
        shapes::soup(2, 1.0, 2),
        shapes::icosphere(1),
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        shapes::soup(120, 0.2, 4),
        shapes::soup(60, 1.5, 5),
        shapes::slivers(80, 1e-6, 6),
        shapes::vertex_fan(60, 7),
        identical,
        shapes::flat_overlap(60, 8),
        shapes::axis_aligned(120, 16, 9),
        shapes::one_spot(60, 10),
        joined([square.clone(), square.clone(), square]),
        far_apart,
        stadium_of(4, 1),
    ];
    let mut scenes: Vec<_> = meshes.iter().map(narrowed).collect();
    let ball = narrowed(&shapes::icosphere(1));
    let changed = |f: &dyn Fn(Vec3) -> Vec3| {
        let triangles = ball.iter();
        triangles
            .map(|t| Triangle {
                corners: t.corners.map(f),
            })
            .collect()
    };
    scenes.push(changed(&|p| p + 1000.0));
    scenes.push(changed(&|p| p * 2_f32.powi(-20)));
    scenes.push(changed(&|p| p * 2_f32.powi(20)));
    scenes.push(changed(&|p| p * 2_f32.powi(-100)));
    scenes.push(changed(&|p| p + Vec3::new(1e5, -3e4, 7.0)));
    scenes
}

/// Builds a structure.
pub type Build = fn(&[Triangle]) -> Accelerator;

pub fn brute_force(triangles: &[Triangle]) -> Accelerator {
    Accelerator::BruteForce(BruteForce::new(triangles.to_vec()))
}

pub fn kd_tree(triangles: &[Triangle]) -> Accelerator {
    let tree = KdTree::build(triangles, &KdParameters::default(), &CancelToken::new());
    Accelerator::KdTree(tree.expect("nobody cancels"))
}

pub fn wide_tree(triangles: &[Triangle]) -> Accelerator {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let tree = WideTree::build(triangles, BuildQuality::Best, &cancel, &progress);
    Accelerator::Wide(tree.expect("nobody cancels"))
}

/// The kd-tree and the wide tree.
pub fn trees(triangles: &[Triangle]) -> [Accelerator; 2] {
    [kd_tree(triangles), wide_tree(triangles)]
}

/// Triangles that occur once, as rays of a scene meet them.
pub fn without_copies(triangles: &[Triangle], build: Build) -> Assembly {
    let count = u32::try_from(triangles.len()).expect("few triangles");
    Assembly::new(build(triangles), Vec::new(), vec![Part::Flat(count)])
}

/// Copies of two meshes among triangles that occur once: turned, mirrored, tiny, and two in the same place.
pub fn placed_copies(build: Build) -> Assembly {
    let turned = |x: f64, z: f64, scale: f64| {
        ScaledRotation::new(DMat3::from_rotation_z(z) * DMat3::from_rotation_x(x) * scale)
    };
    let copies = |structure: usize, turn: ScaledRotation, translations: Vec<DVec3>| {
        Part::Copies(Copies {
            structure,
            turn,
            translations,
        })
    };
    let mut random = Random::new(3);
    let mut places = |count: u32| (0..count).map(|_| random.in_cube()).collect::<Vec<_>>();
    let once = narrowed(&shapes::soup(20, 0.2, 1));
    let shared = [shapes::icosphere(0), shapes::soup(12, 0.3, 2)];
    let shared = shared.map(|mesh| Arc::new(build(&narrowed(&mesh))));
    let parts = vec![
        copies(0, turned(0.3, 2.0, 0.12), places(3)),
        Part::Flat(20),
        copies(
            1,
            turned(0.0, 0.0, 0.25),
            vec![DVec3::new(0.2, 0.1, -0.3); 2],
        ),
        copies(1, turned(1.0, -0.2, -0.2), places(2)),
        copies(0, turned(0.1, 0.1, 1e-6), places(1)),
    ];
    Assembly::new(build(&once), shared.into(), parts)
}
